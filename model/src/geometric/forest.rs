//! Boosted trees: one score from `N` numbers, by questions of the kind "at most this much?".

/// One question of a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Which number is asked about.
    pub number: u16,
    /// The most at which the answer is yes.
    pub most: f32,
    /// Where yes and no lead.
    pub ways: [Way; 2],
}

/// Where an answer leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// To a later question of the same tree.
    Step(u16),
    /// To one of the tree's ends.
    End(u16),
}

/// Questions, the first one first, and what each end adds to the score.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree<const N: usize> {
    steps: Vec<Step>,
    ends: Vec<f32>,
}

impl<const N: usize> Tree<N> {
    /// A tree that ends whatever is asked; `None` where a way leads nowhere or back, a question is
    /// about no number, or something is not finite.
    pub fn new(steps: Vec<Step>, ends: Vec<f32>) -> Option<Self> {
        let leads = |from: usize, way: &Way| match *way {
            Way::Step(to) => usize::from(to) > from && usize::from(to) < steps.len(),
            Way::End(end) => usize::from(end) < ends.len(),
        };
        let is_sound = |(i, s): (usize, &Step)| {
            let is_known = usize::from(s.number) < N && s.most.is_finite();
            is_known && s.ways.iter().all(|w| leads(i, w))
        };
        let is_tree = steps.iter().enumerate().all(is_sound)
            && !ends.is_empty()
            && ends.iter().all(|e| e.is_finite());
        is_tree.then_some(Self { steps, ends })
    }

    /// What the tree adds to the score.
    pub fn score(&self, numbers: &[f32; N]) -> f32 {
        let mut way = if self.steps.is_empty() { Way::End(0) } else { Way::Step(0) };
        loop {
            match way {
                Way::Step(step) => {
                    let step = &self.steps[usize::from(step)];
                    let is_less = numbers[usize::from(step.number)] <= step.most;
                    way = step.ways[usize::from(!is_less)];
                }
                Way::End(end) => return self.ends[usize::from(end)],
            }
        }
    }
}

/// Trees whose scores add up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forest<const N: usize> {
    /// In the order in which they were grown.
    pub trees: Vec<Tree<N>>,
}

impl<const N: usize> Forest<N> {
    /// The sum of all trees' scores: log-odds, up to a constant for the piece.
    pub fn score(&self, numbers: &[f32; N]) -> f32 {
        self.trees.iter().map(|t| t.score(numbers)).sum()
    }

    /// Appends the forest to `bytes`, little-endian: the count of trees (`u32`); for each tree its
    /// counts of questions and ends (`u16`), each question's number (`u16`), bound (`f32`) and two
    /// ways (`u16`: twice the place, plus one if it is an end), and the ends (`f32`).
    pub fn write(&self, bytes: &mut Vec<u8>) {
        bytes.extend((self.trees.len() as u32).to_le_bytes());
        for tree in &self.trees {
            bytes.extend((tree.steps.len() as u16).to_le_bytes());
            bytes.extend((tree.ends.len() as u16).to_le_bytes());
            for step in &tree.steps {
                bytes.extend(step.number.to_le_bytes());
                bytes.extend(step.most.to_le_bytes());
                for way in step.ways {
                    let written = match way {
                        Way::Step(to) => 2 * to,
                        Way::End(end) => 2 * end + 1,
                    };
                    bytes.extend(written.to_le_bytes());
                }
            }
            bytes.extend(tree.ends.iter().flat_map(|e| e.to_le_bytes()));
        }
    }

    /// Takes a forest from the front of `bytes`; `None` if none stands there.
    pub fn read(bytes: &mut &[u8]) -> Option<Self> {
        let count = u32::from_le_bytes(take(bytes)?);
        let trees = (0..count).map(|_| read_tree(bytes)).collect::<Option<_>>()?;
        Some(Self { trees })
    }
}

/// Log-odds as chances that add up to 1.
pub fn chances(scores: &[f32]) -> Vec<f32> {
    let best = scores.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let likely: Vec<f32> = scores.iter().map(|s| (s - best).exp()).collect();
    let all: f32 = likely.iter().sum();
    likely.into_iter().map(|l| l / all).collect()
}

/// How likely each row is, on the average of some forests: chances that add up to 1.
pub fn mean_chances<const N: usize>(voices: &[Forest<N>], rows: &[[f32; N]]) -> Vec<f32> {
    let mut mean = vec![0.0; rows.len()];
    for voice in voices {
        let scores: Vec<f32> = rows.iter().map(|row| voice.score(row)).collect();
        for (sum, chance) in mean.iter_mut().zip(chances(&scores)) {
            *sum += chance / voices.len() as f32;
        }
    }
    mean
}

/// The forests that were written one after another, up to what is none.
pub fn forests<const N: usize>(mut bytes: &[u8]) -> Vec<Forest<N>> {
    std::iter::from_fn(|| Forest::read(&mut bytes)).collect()
}

fn read_tree<const N: usize>(bytes: &mut &[u8]) -> Option<Tree<N>> {
    let steps = u16::from_le_bytes(take(bytes)?);
    let ends = u16::from_le_bytes(take(bytes)?);
    let steps = (0..steps).map(|_| read_step(bytes)).collect::<Option<_>>()?;
    let ends = (0..ends).map(|_| take(bytes).map(f32::from_le_bytes)).collect::<Option<_>>()?;
    Tree::new(steps, ends)
}

fn read_step(bytes: &mut &[u8]) -> Option<Step> {
    let number = u16::from_le_bytes(take(bytes)?);
    let most = f32::from_le_bytes(take(bytes)?);
    let way = |written: u16| {
        if written.is_multiple_of(2) { Way::Step(written / 2) } else { Way::End(written / 2) }
    };
    let ways = [u16::from_le_bytes(take(bytes)?), u16::from_le_bytes(take(bytes)?)].map(way);
    Some(Step { number, most, ways })
}

fn take<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (first, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(*first)
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: usize = 8;

    /// Asks about number 3, and of what is more about number 5.
    fn steps() -> Vec<Step> {
        vec![
            Step { number: 3, most: 0.5, ways: [Way::End(0), Way::Step(1)] },
            Step { number: 5, most: -1.0, ways: [Way::End(1), Way::End(2)] },
        ]
    }

    fn numbers(third: f32, fifth: f32) -> [f32; N] {
        let mut numbers = [0.0; N];
        (numbers[3], numbers[5]) = (third, fifth);
        numbers
    }

    #[test]
    fn a_forest_adds_up_where_its_trees_end() {
        let tree = Tree::<N>::new(steps(), vec![1.0, 2.0, 4.0]).unwrap();
        let stump = Tree::new(Vec::new(), vec![0.25]).unwrap();
        let forest = Forest { trees: vec![tree, stump] };
        assert_eq!(forest.score(&numbers(0.5, 9.0)), 1.25);
        assert_eq!(forest.score(&numbers(0.6, -1.0)), 2.25);
        assert_eq!(forest.score(&numbers(0.6, 0.0)), 4.25);
    }

    #[test]
    fn what_was_written_is_read_and_nothing_more() {
        let tree = Tree::<N>::new(steps(), vec![1.0, 2.0, 4.0]).unwrap();
        let forest = Forest { trees: vec![tree.clone(), tree] };
        let mut bytes = Vec::new();
        forest.write(&mut bytes);
        let whole = bytes.len();
        bytes.push(7);
        let mut rest = &bytes[..];
        assert_eq!(Forest::read(&mut rest), Some(forest));
        assert_eq!(rest, [7]);
        for cut in 0..whole {
            assert_eq!(Forest::<N>::read(&mut &bytes[..cut]), None);
        }
    }

    #[test]
    fn chances_add_up_however_large_the_scores() {
        let chances = chances(&[1000.0, 1000.0, -1000.0]);
        assert_eq!(chances, [0.5, 0.5, 0.0]);
    }

    #[test]
    fn voices_are_heard_alike() {
        let says = |yes: f32, no: f32| {
            let steps = vec![Step { number: 0, most: 0.0, ways: [Way::End(0), Way::End(1)] }];
            Forest { trees: vec![Tree::<N>::new(steps, vec![yes, no]).unwrap()] }
        };
        let mut rows = [[0.0; N]; 2];
        rows[1][0] = 1.0;
        let [sure, not] = [says(100.0, 0.0), says(0.0, 0.0)];
        assert_eq!(mean_chances(&[sure, not], &rows), [0.75, 0.25]);
    }

    #[test]
    fn no_tree_leads_back_or_nowhere() {
        let led = |way: Way| {
            let mut steps = steps();
            steps[1].ways[0] = way;
            Tree::<N>::new(steps, vec![1.0, 2.0, 4.0])
        };
        assert!(led(Way::End(2)).is_some());
        for way in [Way::Step(0), Way::Step(1), Way::Step(2), Way::End(3)] {
            assert_eq!(led(way), None);
        }
        let mut steps = steps();
        steps[0].number = N as u16;
        assert_eq!(Tree::<N>::new(steps, vec![1.0, 2.0, 4.0]), None);
        assert_eq!(Tree::<N>::new(Vec::new(), Vec::new()), None);
        assert_eq!(Tree::<N>::new(Vec::new(), vec![f32::NAN]), None);
    }
}
