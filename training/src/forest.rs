//! Growing boosted trees that choose one of several rows.
//!
//! A question is a run of rows of which one is right. Trees are grown one after another on the slope
//! of its negative log-likelihood, over numbers parted into bins, the leaf that gains most first. The
//! same lessons and the same seed give the same trees, however many threads grow them.

use std::ops::Range;

use model::classic::learned::forest::{Forest, Step, Tree, Way, chances};
use rand::seq::index::sample;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Most trees of a forest and most ends of a tree that are asked for; a guess, far more than helps.
const MOST_TREES: usize = 10_000;
const MOST_LEAVES: usize = 4_096;
/// Most bins of a number.
const BINS: usize = 128;
/// Rows are counted in runs of this many at once, and the runs added up in order.
const RUN: usize = 1 << 16;
/// A row counts at least this much in a sum of curvatures, as a share of its weight.
const LEAST_CURVE: f32 = 1e-3;
/// Least gain for which a leaf is parted.
const LEAST_GAIN: f64 = 1e-9;

/// A number of an object that never changes. It chooses the fold that is not grown on the object,
/// so that this fold can answer for the object out of fold. Numbers beyond the last fold start
/// again at the first.
pub fn fold_number(id: &str) -> usize {
    usize::from(blake3::hash(id.as_bytes()).as_bytes()[0])
}

/// Of so many folds, the one that is not grown on an object.
pub fn left_out_fold(id: &str, folds: usize) -> usize {
    fold_number(id) % folds.max(1)
}

/// How a forest grows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Growth {
    /// How many trees.
    pub trees: usize,
    /// Most ends of a tree.
    pub leaves: usize,
    /// What share of its best step a tree takes, 0 to 1.
    pub rate: f32,
    /// What share of the questions each tree is grown on, 0 to 1.
    pub questions: f64,
    /// What share of the features each tree may ask about, 0 to 1.
    #[serde(rename = "features")]
    pub numbers: f64,
    /// Least curvature of an end, where rows weigh 1 on average.
    pub curve: f64,
    /// Curvature that holds every end back.
    pub hold: f64,
    /// Of the questions and the numbers drawn.
    pub seed: u64,
}

impl Growth {
    /// Refuses numbers by which nothing grows.
    ///
    /// # Errors
    /// The first that will not do, and what was found.
    pub fn check(&self) -> Result<(), String> {
        let counts = [("trees", self.trees, MOST_TREES), ("leaves", self.leaves, MOST_LEAVES)];
        for (name, count, most) in counts {
            let least = if name == "trees" { 1 } else { 2 };
            if !(least..=most).contains(&count) {
                return Err(format!("`{name}` must be from {least} to {most}, found {count}"));
            }
        }
        let shares = [
            ("rate", f64::from(self.rate)),
            ("questions", self.questions),
            ("features", self.numbers),
        ];
        for (name, share) in shares {
            if !(share > 0.0 && share <= 1.0) {
                return Err(format!("`{name}` must be above 0 and at most 1, found {share}"));
            }
        }
        for (name, least) in [("curve", self.curve), ("hold", self.hold)] {
            if !(least.is_finite() && least >= 0.0) {
                return Err(format!("`{name}` must be 0 or more, found {least}"));
            }
        }
        Ok(())
    }
}

/// One of several rows is right, or several are good.
#[derive(Clone, Debug, PartialEq)]
pub struct Question<const N: usize> {
    /// How much it counts.
    pub weight: f32,
    /// How often each row ought to be chosen, and, where there is one more, none of them, which always
    /// scores 0; these add up to 1.
    pub truth: Vec<f32>,
    /// The rows.
    pub numbers: Vec<[f32; N]>,
}

/// Between which values the bins of each number part, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Bins<const N: usize>(Vec<Vec<f32>>);

impl<const N: usize> Bins<N> {
    /// Bins that hold about as many of these rows each.
    pub fn of<'a>(rows: impl Iterator<Item = &'a [f32; N]>) -> Self {
        let mut columns = vec![Vec::new(); N];
        for row in rows {
            columns.iter_mut().zip(row).for_each(|(c, x)| c.push(*x));
        }
        Self(columns.into_par_iter().map(edges).collect())
    }

    fn bin(&self, number: usize, value: f32) -> u8 {
        self.0[number].partition_point(|edge| *edge < value) as u8
    }
}

/// Values halfway between those that take equal shares of all rows.
fn edges(mut values: Vec<f32>) -> Vec<f32> {
    values.sort_unstable_by(f32::total_cmp);
    let mut levels = values.clone();
    levels.dedup();
    if levels.len() > BINS {
        levels = (0..BINS).map(|b| values[b * values.len() / BINS]).collect();
        levels.dedup();
    }
    levels.windows(2).map(|pair| 0.5 * pair[0] + 0.5 * pair[1]).collect()
}

/// Questions in bins, by object.
#[derive(Clone, Debug)]
pub struct Lessons<'a, const N: usize> {
    bins: &'a Bins<N>,
    rows: Vec<[u8; N]>,
    questions: Vec<Asked>,
    objects: Vec<Range<usize>>,
}

impl<'a, const N: usize> Lessons<'a, N> {
    /// No question yet.
    pub fn new(bins: &'a Bins<N>) -> Self {
        Self { bins, rows: Vec::new(), questions: Vec::new(), objects: Vec::new() }
    }

    /// Adds what is asked about one object.
    pub fn add(&mut self, asked: &[Question<N>]) {
        let first = self.questions.len();
        for question in asked {
            let from = self.rows.len();
            for numbers in &question.numbers {
                let mut row = [0; N];
                for (n, (bin, value)) in row.iter_mut().zip(numbers).enumerate() {
                    *bin = self.bins.bin(n, *value);
                }
                self.rows.push(row);
            }
            let (rows, weight) = (from..self.rows.len(), question.weight);
            let truth = question.truth.clone();
            self.questions.push(Asked { rows, truth, weight });
        }
        self.objects.push(first..self.questions.len());
    }

    /// Adds all that a forest follows from, but for how it grows and which objects it knows, to a digest.
    pub fn hash_into(&self, hasher: &mut blake3::Hasher) {
        let mut put = |number: u64| {
            hasher.update(&number.to_le_bytes());
        };
        put(N as u64);
        for edges in &self.bins.0 {
            put(edges.len() as u64);
            edges.iter().for_each(|edge| put(edge.to_bits().into()));
        }
        put(self.questions.len() as u64);
        for question in &self.questions {
            put(question.rows.len() as u64);
            put(question.weight.to_bits().into());
            put(question.truth.len() as u64);
            question.truth.iter().for_each(|truth| put(truth.to_bits().into()));
        }
        put(self.objects.len() as u64);
        self.objects.iter().for_each(|object| put(object.end as u64));
        self.rows.iter().for_each(|row| {
            hasher.update(row);
        });
    }

    /// How many objects there are.
    pub fn objects(&self) -> usize {
        self.objects.len()
    }

    /// Grows a forest on the objects, by number, that it `knows`; `told` hears of the count of trees
    /// and of the mean loss before each.
    pub fn grow(
        &self,
        growth: &Growth,
        knows: impl Fn(usize) -> bool,
        mut told: impl FnMut(usize, f64),
    ) -> Forest<N> {
        let known: Vec<(usize, Range<usize>)> =
            self.objects.iter().cloned().enumerate().filter(|o| knows(o.0)).collect();
        let asked = || known.iter().flat_map(|o| &self.questions[o.1.clone()]);
        let all: f64 = asked().map(|q| f64::from(q.weight) * q.rows.len() as f64).sum();
        let rows: usize = asked().map(|q| q.rows.len()).sum();
        let scale = rows as f64 / all.max(f64::MIN_POSITIVE);
        let mut rng = Pcg64Mcg::seed_from_u64(growth.seed);
        let mut scores = vec![0.0f32; self.rows.len()];
        let mut forest = Forest::default();
        for tree in 0..growth.trees {
            let count = (growth.numbers * N as f64).ceil() as usize;
            let mut numbers = sample(&mut rng, N, count.min(N)).into_vec();
            numbers.sort_unstable();
            let drawn = Drawn { share: growth.questions, dice: rng.random() };
            let (pulls, loss) = self.pulls(&known, &drawn, (&scores, scale as f32));
            told(tree, loss);
            // Of the numbers that were drawn none may tell anything.
            let Some(grown) = (Grower { lessons: self, growth, numbers, pulls }).grow() else {
                continue;
            };
            let add = |(score, row): (&mut f32, &[u8; N])| *score += grown.score(row);
            scores.par_iter_mut().zip(&self.rows).for_each(add);
            forest.trees.extend(grown.tree(self.bins));
        }
        forest
    }

    /// Slope and curvature of every row of the questions drawn, and the mean loss of those.
    fn pulls(
        &self,
        known: &[(usize, Range<usize>)],
        drawn: &Drawn,
        (scores, scale): (&[f32], f32),
    ) -> (Vec<Pull>, f64) {
        let of_object = |(object, questions): &(usize, Range<usize>)| {
            let mut dice = Pcg64Mcg::seed_from_u64(drawn.dice.wrapping_add(*object as u64));
            let (mut pulls, mut loss, mut weight) = (Vec::new(), 0.0, 0.0);
            for asked in &self.questions[questions.clone()] {
                if dice.random::<f64>() >= drawn.share {
                    continue;
                }
                let mut said = scores[asked.rows.clone()].to_vec();
                said.resize(asked.truth.len(), 0.0);
                let chances = chances(&said);
                weight += f64::from(asked.weight);
                let told = || chances.iter().copied().zip(asked.truth.iter().copied());
                for (chance, truth) in told() {
                    loss -= f64::from(asked.weight * truth) * f64::from(chance.max(1e-9)).ln();
                }
                for (row, (chance, truth)) in asked.rows.clone().zip(told()) {
                    let weight = asked.weight * scale;
                    let slope = (chance - truth) * weight;
                    let curve = (chance * (1.0 - chance)).max(LEAST_CURVE) * weight;
                    pulls.push(Pull { row: row as u32, slope, curve });
                }
            }
            (pulls, loss, weight)
        };
        let each: Vec<(Vec<Pull>, f64, f64)> = known.par_iter().map(of_object).collect();
        let loss: f64 = each.iter().map(|o| o.1).sum();
        let weight: f64 = each.iter().map(|o| o.2).sum();
        (each.into_iter().flat_map(|o| o.0).collect(), loss / weight.max(f64::MIN_POSITIVE))
    }
}

/// What share of the questions is drawn, by which dice.
struct Drawn {
    share: f64,
    dice: u64,
}

/// A question in bins.
#[derive(Clone, Debug)]
struct Asked {
    rows: Range<usize>,
    truth: Vec<f32>,
    weight: f32,
}

/// Which way a row's score should go, and how fast that changes.
#[derive(Clone, Copy, Debug)]
struct Pull {
    row: u32,
    slope: f32,
    curve: f32,
}

/// Sums of slope and curvature.
type Sums = [f64; 2];

/// A leaf that may be parted.
struct Leaf {
    pulls: Range<usize>,
    sums: Sums,
    /// For each number that may be asked about, the sums of each bin.
    bins: Vec<Sums>,
    best: Option<Split>,
}

#[derive(Clone, Copy, Debug)]
struct Split {
    gain: f64,
    /// Which of the numbers that may be asked about.
    place: usize,
    bin: u8,
}

struct Grower<'a, const N: usize> {
    lessons: &'a Lessons<'a, N>,
    growth: &'a Growth,
    numbers: Vec<usize>,
    pulls: Vec<Pull>,
}

impl<const N: usize> Grower<'_, N> {
    /// A tree in bins; nothing if there is nothing to part.
    fn grow(mut self) -> Option<Grown> {
        let mut leaves = vec![self.leaf(0..self.pulls.len(), None)];
        let mut grown = Grown { steps: Vec::new(), ends: Vec::new() };
        while leaves.len() < self.growth.leaves {
            let gain = |l: &Leaf| l.best.map_or(0.0, |b| b.gain);
            let best = (0..leaves.len())
                .reduce(|a, b| if gain(&leaves[b]) > gain(&leaves[a]) { b } else { a })?;
            let Some(split) = leaves[best].best else { break };
            let (less, more) = self.part(&leaves[best], &split);
            let (step, end) = (grown.steps.len() as u16, leaves.len() as u16);
            let was = Way::End(best as u16);
            let led = grown.steps.iter_mut().flat_map(|s| &mut s.ways).find(|w| **w == was);
            if let Some(way) = led {
                *way = Way::Step(step);
            }
            let number = self.numbers[split.place] as u16;
            grown.steps.push(BinStep { number, bin: split.bin, ways: [was, Way::End(end)] });
            leaves[best] = less;
            leaves.push(more);
        }
        let worth = |leaf: &Leaf| {
            let [slope, curve] = leaf.sums;
            -self.growth.rate * (slope / (curve + self.growth.hold)) as f32
        };
        grown.ends = leaves.iter().map(worth).collect();
        (!grown.steps.is_empty()).then_some(grown)
    }

    /// Parts a leaf's rows; the smaller side is counted, the larger one is what remains.
    fn part(&mut self, leaf: &Leaf, split: &Split) -> (Leaf, Leaf) {
        let number = self.numbers[split.place];
        let rows = &self.lessons.rows;
        let own = &mut self.pulls[leaf.pulls.clone()];
        let (less, more): (Vec<Pull>, Vec<Pull>) =
            own.iter().partition(|p| rows[p.row as usize][number] <= split.bin);
        own[..less.len()].copy_from_slice(&less);
        own[less.len()..].copy_from_slice(&more);
        let middle = leaf.pulls.start + less.len();
        let sides = (leaf.pulls.start..middle, middle..leaf.pulls.end);
        if less.len() <= more.len() {
            let less = self.leaf(sides.0, None);
            let more = self.leaf(sides.1, Some((leaf, &less)));
            (less, more)
        } else {
            let more = self.leaf(sides.1, None);
            let less = self.leaf(sides.0, Some((leaf, &more)));
            (less, more)
        }
    }

    /// A leaf of these rows: counted, or a whole less its other side.
    fn leaf(&self, pulls: Range<usize>, rest: Option<(&Leaf, &Leaf)>) -> Leaf {
        let bins = match rest {
            None => self.count(&self.pulls[pulls.clone()]),
            Some((whole, side)) => {
                let less = |(a, b): (&Sums, &Sums)| [a[0] - b[0], a[1] - b[1]];
                whole.bins.iter().zip(&side.bins).map(less).collect()
            }
        };
        let sums = bins.iter().take(BINS).fold([0.0; 2], |s: Sums, b| [s[0] + b[0], s[1] + b[1]]);
        let best = self.best(&bins, sums);
        Leaf { pulls, sums, bins, best }
    }

    fn count(&self, pulls: &[Pull]) -> Vec<Sums> {
        let cells = self.numbers.len() * BINS;
        let run = |pulls: &[Pull]| {
            let mut sums = vec![[0.0; 2]; cells];
            for pull in pulls {
                let row = &self.lessons.rows[pull.row as usize];
                let (slope, curve) = (f64::from(pull.slope), f64::from(pull.curve));
                for (bins, &number) in sums.chunks_exact_mut(BINS).zip(&self.numbers) {
                    let sum: &mut Sums = &mut bins[usize::from(row[number])];
                    sum[0] += slope;
                    sum[1] += curve;
                }
            }
            sums
        };
        let runs: Vec<Vec<Sums>> = pulls.par_chunks(RUN).map(run).collect();
        let mut runs = runs.into_iter();
        let mut all = runs.next().unwrap_or_else(|| vec![[0.0; 2]; cells]);
        for more in runs {
            for (a, b) in all.iter_mut().zip(&more) {
                *a = [a[0] + b[0], a[1] + b[1]];
            }
        }
        all
    }

    /// The split that gains most, if any gains.
    fn best(&self, bins: &[Sums], whole: Sums) -> Option<Split> {
        let worth = |s: Sums| s[0] * s[0] / (s[1] + self.growth.hold);
        let mut best: Option<Split> = None;
        for (place, bins) in bins.chunks_exact(BINS).enumerate() {
            let mut below = [0.0; 2];
            for (bin, sums) in bins.iter().enumerate().take(BINS - 1) {
                below = [below[0] + sums[0], below[1] + sums[1]];
                let above = [whole[0] - below[0], whole[1] - below[1]];
                if below[1] < self.growth.curve || above[1] < self.growth.curve {
                    continue;
                }
                let gain = worth(below) + worth(above) - worth(whole);
                if gain > best.map_or(LEAST_GAIN, |b| b.gain) {
                    best = Some(Split { gain, place, bin: bin as u8 });
                }
            }
        }
        best
    }
}

/// A tree that asks about bins.
#[derive(Clone, Debug)]
struct Grown {
    steps: Vec<BinStep>,
    ends: Vec<f32>,
}

#[derive(Clone, Copy, Debug)]
struct BinStep {
    number: u16,
    bin: u8,
    ways: [Way; 2],
}

impl Grown {
    fn score<const N: usize>(&self, row: &[u8; N]) -> f32 {
        let mut way = Way::Step(0);
        loop {
            match way {
                Way::Step(step) => {
                    let step = &self.steps[usize::from(step)];
                    way = step.ways[usize::from(row[usize::from(step.number)] > step.bin)];
                }
                Way::End(end) => return self.ends[usize::from(end)],
            }
        }
    }

    /// The same, asking about the numbers themselves.
    fn tree<const N: usize>(&self, bins: &Bins<N>) -> Option<Tree<N>> {
        let step = |s: &BinStep| {
            let most = bins.0[usize::from(s.number)].get(usize::from(s.bin));
            most.map(|&most| Step { feature: s.number, most, ways: s.ways })
        };
        Tree::new(self.steps.iter().map(step).collect::<Option<_>>()?, self.ends.clone())
    }
}

#[cfg(test)]
mod tests;
