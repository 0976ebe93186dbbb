//! Forests that are asked about many rows at once, with the very answers of [`Forest::scores`].
//!
//! A walk through a tree waits at every question for the answer. Here every question of a tree is asked of
//! 256 rows together, and of each pair of ways both are followed, as sets of rows: bits in four words. All
//! questions about one feature share its bounds in order, so that a row's place among these answers them all.

use std::ops::Range;

use crate::classic::learned::forest::{Forest, Tree, Way, chances};

/// Words of a set of rows.
const WORDS: usize = 4;
/// How many rows are asked about at once.
pub const ABREAST: usize = 64 * WORDS;
/// Fewer rows than this are asked about one by one: most of the bits would be idle.
const FEW: usize = 24;
/// Most ends of a tree that are told apart by the bits of a byte.
const MOST_ENDS: usize = 256;

/// Some of [`ABREAST`] rows.
type Rows = [u64; WORDS];

/// Forests that are asked side by side.
#[derive(Clone, Debug, Default)]
pub struct Grove<const N: usize> {
    /// The forests, fold by fold, as they were grown.
    folds: Vec<Forest<N>>,
    /// The bounds of all folds' questions: those of the first feature, rising, then those of the next.
    bounds: Vec<f32>,
    /// Where the bounds of each feature begin, and where those of the last end.
    starts: Vec<u32>,
    /// The trees of each fold; nothing of one that has a tree with too many ends.
    sets: Vec<Option<Vec<Sieve>>>,
}

/// A tree as sets of rows pass through it.
#[derive(Clone, Debug)]
struct Sieve {
    questions: Vec<Question>,
    ends: Vec<End>,
    /// What each end adds to the score.
    worth: Vec<f32>,
    /// How many sets there are on the way, all rows first.
    sets: usize,
}

/// A question: the rows of one set are parted into two.
#[derive(Clone, Copy, Debug)]
struct Question {
    /// Which bound is asked about.
    bound: u32,
    /// The set that is parted.
    of: u16,
    /// The set of those who say yes; the next is of those who say no.
    yes: u16,
}

/// An end of the tree, and the set of rows that come there.
#[derive(Clone, Copy, Debug)]
struct End {
    of: u16,
}

impl<const N: usize> Grove<N> {
    /// Forests side by side.
    pub fn of(folds: Vec<Forest<N>>) -> Self {
        let mut bounds: Vec<Vec<f32>> = vec![Vec::new(); N];
        for step in folds.iter().flat_map(|f| &f.trees).flat_map(Tree::steps) {
            bounds[usize::from(step.feature)].push(step.most);
        }
        for of_feature in &mut bounds {
            of_feature.sort_by(f32::total_cmp);
            of_feature.dedup();
        }
        let mut starts = vec![0];
        starts.extend(bounds.iter().scan(0, |end, of_feature| {
            *end += of_feature.len() as u32;
            Some(*end)
        }));
        let place = |feature: u16, most: f32| {
            let of_feature = &bounds[usize::from(feature)];
            starts[usize::from(feature)] + of_feature.partition_point(|b| *b < most) as u32
        };
        let fold = |forest: &Forest<N>| {
            forest.trees.iter().map(|tree| Sieve::of(tree, place)).collect::<Option<Vec<Sieve>>>()
        };
        let sets = folds.iter().map(fold).collect();
        Self { folds, bounds: bounds.concat(), starts, sets }
    }

    /// The forests, fold by fold.
    pub fn folds(&self) -> &[Forest<N>] {
        &self.folds
    }

    /// How likely each row is, on the average of some folds, by their places: chances that add up to 1 for
    /// each question, whose rows, so many of each, come one after another.
    pub fn mean_chances_of(
        &self,
        asked: Range<usize>,
        rows: &[[f32; N]],
        counts: &[usize],
    ) -> Vec<f32> {
        let mut mean = vec![0.0; rows.len()];
        let folds = asked.len() as f32;
        let period = counts.first().copied().unwrap_or(1).max(1);
        for scores in self.scores_of(asked, rows, period) {
            let (mut means, mut scores) = (&mut mean[..], &scores[..]);
            for &count in counts {
                let (own, scored);
                (own, means) = means.split_at_mut(count.min(means.len()));
                (scored, scores) = scores.split_at(count.min(scores.len()));
                for (sum, chance) in own.iter_mut().zip(chances(scored)) {
                    *sum += chance / folds;
                }
            }
        }
        mean
    }

    /// For some folds, by their places, the score of each row.
    pub fn scores(&self, asked: Range<usize>, rows: &[[f32; N]]) -> Vec<Vec<f32>> {
        self.scores_of(asked, rows, 1)
    }

    fn scores_of(&self, asked: Range<usize>, rows: &[[f32; N]], period: usize) -> Vec<Vec<f32>> {
        let folds = self.folds.get(asked.clone()).unwrap_or_default();
        let sets = self.sets.get(asked).unwrap_or_default();
        if rows.len() < FEW {
            return folds.iter().map(|forest| forest.scores(rows)).collect();
        }
        let mut scores = vec![vec![0.0; rows.len()]; folds.len()];
        let mut above = vec![[0; WORDS]; self.bounds.len()];
        for (block, rows) in rows.chunks(ABREAST).enumerate() {
            self.above((rows, period), &mut above);
            for ((sets, forest), scores) in sets.iter().zip(folds).zip(&mut scores) {
                let scores = &mut scores[block * ABREAST..][..rows.len()];
                match sets {
                    Some(trees) => sieve(trees, &above, scores),
                    None => scores.copy_from_slice(&forest.scores(rows)),
                }
            }
        }
        scores
    }

    /// For each bound, which rows are above it. What a row asks about may come again every `period` rows.
    fn above(&self, (rows, period): (&[[f32; N]], usize), above: &mut [Rows]) {
        let mut passed = [0_u32; ABREAST];
        for feature in 0..N {
            let span = self.starts[feature] as usize..self.starts[feature + 1] as usize;
            let (bounds, above) = (&self.bounds[span.clone()], &mut above[span]);
            if bounds.is_empty() {
                continue;
            }
            above.fill([0; WORDS]);
            for (i, row) in rows.iter().enumerate() {
                let value = row[feature];
                // Rows are about a few parts of one segment after another, so that many numbers come again.
                let is_again = |ago: &usize| rows[*ago][feature].to_bits() == value.to_bits();
                let before = [i.checked_sub(1), i.checked_sub(period)].into_iter().flatten();
                let again = before.filter(|_| i > 0).find(is_again).map(|ago| passed[ago]);
                passed[i] = again.unwrap_or_else(|| bounds.partition_point(|b| value > *b) as u32);
                if let Some(last) = (passed[i] as usize).checked_sub(1) {
                    above[last][i / 64] |= 1 << (i % 64);
                }
            }
            for last in (1..above.len()).rev() {
                let higher = above[last];
                above[last - 1].iter_mut().zip(higher).for_each(|(a, b)| *a |= b);
            }
        }
    }
}

impl Sieve {
    /// A tree, its bounds by their places; nothing where it has too many ends.
    fn of<const N: usize>(tree: &Tree<N>, place: impl Fn(u16, f32) -> u32) -> Option<Self> {
        let (steps, values) = (tree.steps(), tree.ends());
        let mut ways = vec![if steps.is_empty() { Way::End(0) } else { Way::Step(0) }];
        let mut new = Self { questions: Vec::new(), ends: Vec::new(), worth: Vec::new(), sets: 0 };
        while let Some(&way) = ways.get(new.sets) {
            let of = new.sets as u16;
            match way {
                Way::Step(step) => {
                    let step = steps.get(usize::from(step))?;
                    let bound = place(step.feature, step.most);
                    new.questions.push(Question { bound, of, yes: ways.len() as u16 });
                    ways.extend(step.ways);
                }
                Way::End(end) => {
                    new.ends.push(End { of });
                    new.worth.push(*values.get(usize::from(end))?);
                }
            }
            new.sets += 1;
        }
        (new.ends.len() <= MOST_ENDS).then_some(new)
    }
}

/// Adds to the score of each row what the trees make of it, one after another.
fn sieve(trees: &[Sieve], above: &[Rows], scores: &mut [f32]) {
    let most = trees.iter().map(|t| t.sets).max().unwrap_or(0);
    let mut sets = vec![[0; WORDS]; most];
    for tree in trees {
        let Some(all) = sets.first_mut() else { return };
        *all = [u64::MAX; WORDS];
        for &Question { bound, of, yes } in &tree.questions {
            let (rows, above) = (sets[usize::from(of)], above[bound as usize]);
            let both = &mut sets[usize::from(yes)..][..2];
            for w in 0..WORDS {
                (both[0][w], both[1][w]) = (rows[w] & !above[w], rows[w] & above[w]);
            }
        }
        let places = places(tree, &sets);
        let mut worth = [0.0; MOST_ENDS];
        worth.iter_mut().zip(&tree.worth).for_each(|(w, value)| *w = *value);
        for (score, place) in scores.iter_mut().zip(places.as_flattened()) {
            *score += worth[usize::from(*place)];
        }
    }
}

/// For each row, the place of the end it comes to.
fn places(tree: &Sieve, sets: &[Rows]) -> [[u8; 8]; ABREAST / 8] {
    if tree.ends.len() <= 32 { places_in::<5>(tree, sets) } else { places_in::<8>(tree, sets) }
}

/// The same where places have so many bits.
fn places_in<const BITS: usize>(tree: &Sieve, sets: &[Rows]) -> [[u8; 8]; ABREAST / 8] {
    let mut planes = [[0; WORDS]; BITS];
    for (i, end) in tree.ends.iter().enumerate() {
        let rows = &sets[usize::from(end.of)];
        for (bit, plane) in planes.iter_mut().enumerate() {
            let counts = 0_u64.wrapping_sub((i >> bit & 1) as u64);
            plane.iter_mut().zip(rows).for_each(|(p, r)| *p |= r & counts);
        }
    }
    let mut places = [[0; 8]; ABREAST / 8];
    for (eight, place) in places.iter_mut().enumerate() {
        let (word, shift) = (eight / 8, 8 * (eight % 8));
        let mut all = 0;
        for (bit, plane) in planes.iter().enumerate() {
            all |= SPREAD[usize::from((plane[word] >> shift) as u8)] << bit;
        }
        *place = all.to_le_bytes();
    }
    places
}

/// The bits of a byte as eight bytes, the lowest first.
static SPREAD: [u64; 256] = {
    let mut all = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut bit = 0;
        while bit < 8 {
            all[byte] |= ((byte >> bit & 1) as u64) << (8 * bit);
            bit += 1;
        }
        byte += 1;
    }
    all
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::classic::learned::forest::{Step, mean_chances_of};

    const N: usize = 5;

    /// Numbers that look random and are the same on every run, 0 to 1.
    fn numbers() -> impl FnMut() -> f32 {
        let mut state = 7_u32;
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 16_777_216.0
        }
    }

    /// A tree of so many questions, each about some feature: the k-th leads to the next and, at times, to an
    /// end.
    fn tree(questions: u16, next: &mut impl FnMut() -> f32) -> Tree<N> {
        let mut open: Vec<(usize, usize)> = Vec::new();
        let mut steps: Vec<Step> = Vec::new();
        for step in 0..questions {
            if step > 0 {
                let (of, way) = open.remove((next() * open.len() as f32) as usize);
                steps[of].ways[way] = Way::Step(step);
            }
            let (feature, most) = ((next() * N as f32) as u16, (next() * 8.0).round() / 8.0);
            steps.push(Step { feature, most, ways: [Way::End(0); 2] });
            open.extend([(usize::from(step), 0), (usize::from(step), 1)]);
        }
        for (end, (of, way)) in open.into_iter().enumerate() {
            steps[of].ways[way] = Way::End(end as u16);
        }
        Tree::new(steps, (0..=questions).map(|_| next() - 0.5).collect()).unwrap()
    }

    fn rows(count: usize, next: &mut impl FnMut() -> f32) -> Vec<[f32; N]> {
        let mut row = || std::array::from_fn(|_| (next() * 16.0).round() / 16.0);
        let mut rows: Vec<[f32; N]> = (0..count).map(|_| row()).collect();
        if let Some(row) = rows.get_mut(3) {
            *row = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, f32::NAN];
        }
        rows
    }

    #[test]
    fn many_rows_at_once_are_answered_as_one_by_one() {
        let mut next = numbers();
        let sizes = [[0, 1, 2, 30, 7, 31], [3, 30, 30, 12, 0, 63], [1, 1, 1, 1, 300, 2]];
        let forest = |sizes: [u16; 6]| Forest {
            trees: sizes.into_iter().map(|q| tree(q, &mut next)).collect(),
        };
        let folds: Vec<Forest<N>> = sizes.map(forest).into_iter().collect();
        let grove = Grove::of(folds.clone());
        for count in [0, 1, FEW, 64, 65, 255, 256, 257, 700] {
            let rows = rows(count, &mut next);
            let one = |forest: &Forest<N>| forest.scores(&rows);
            assert_eq!(grove.scores(0..3, &rows), folds.iter().map(one).collect::<Vec<_>>());
            assert_eq!(grove.scores(1..2, &rows), [folds[1].scores(&rows)]);
            let counts = [count / 3, count - count / 3];
            let mean = mean_chances_of(&folds[..2], &rows, &counts);
            assert_eq!(grove.mean_chances_of(0..2, &rows, &counts), mean);
        }
    }
}
