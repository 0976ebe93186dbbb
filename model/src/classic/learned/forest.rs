//! Boosted trees: one score from `N` features. Each question compares one feature with a bound;
//! the leaves that are reached are added up.

/// One question of a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Which feature is asked about.
    pub feature: u16,
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

impl Way {
    /// The question it leads to, if any.
    fn step(self) -> Option<u16> {
        match self {
            Self::Step(step) => Some(step),
            Self::End(_) => None,
        }
    }
}

/// How many trees are gone through side by side: where a way leads is known only once a comparison is made,
/// which nobody can guess, so several ways wait for theirs together.
const ABREAST: usize = 6;

/// A question or an end, laid out so that both ways of a question lie side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(8))]
struct Node {
    /// Endless for an end.
    most: f32,
    feature: u16,
    /// Where yes leads; no leads to the next; an end to itself.
    yes: u16,
}

/// Questions, the first one first, and what each end adds to the score.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree<const N: usize> {
    steps: Vec<Step>,
    ends: Vec<f32>,
    /// The same as one goes through it, and what each node, if it is an end, adds to the score.
    nodes: Vec<Node>,
    worth: Vec<f32>,
}

impl<const N: usize> Tree<N> {
    /// A tree that ends whatever is asked; `None` where a way leads nowhere or back, two ways lead to one
    /// question, a question is about no feature, there are no features, something is not finite, or there are
    /// more than 32,767 questions.
    pub fn new(steps: Vec<Step>, ends: Vec<f32>) -> Option<Self> {
        let leads = |from: usize, way: &Way| match *way {
            Way::Step(to) => usize::from(to) > from && usize::from(to) < steps.len(),
            Way::End(end) => usize::from(end) < ends.len(),
        };
        let is_sound = |(i, s): (usize, &Step)| {
            let is_known = usize::from(s.feature) < N && s.most.is_finite();
            is_known && s.ways.iter().all(|w| leads(i, w))
        };
        let mut led: Vec<u16> = steps.iter().flat_map(|s| s.ways).filter_map(Way::step).collect();
        led.sort_unstable();
        let is_tree = steps.iter().enumerate().all(is_sound)
            && led.windows(2).all(|pair| pair[0] < pair[1])
            && !ends.is_empty()
            && ends.iter().all(|e| e.is_finite())
            && N > 0
            && steps.len() <= usize::from(u16::MAX / 2);
        if !is_tree {
            return None;
        }
        let (nodes, worth) = laid_out(&steps, &ends);
        Some(Self { steps, ends, nodes, worth })
    }

    /// Its questions, the first one first.
    pub(super) fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// What each of its ends adds to the score.
    pub(super) fn ends(&self) -> &[f32] {
        &self.ends
    }
}

/// A sound tree's nodes, and what each adds to the score.
fn laid_out(steps: &[Step], ends: &[f32]) -> (Vec<Node>, Vec<f32>) {
    let mut ways = vec![if steps.is_empty() { Way::End(0) } else { Way::Step(0) }];
    let (mut nodes, mut worth) = (Vec::new(), Vec::new());
    while let Some(&way) = ways.get(nodes.len()) {
        let (node, adds) = match way {
            Way::Step(step) => {
                let Step { feature, most, ways: both } = steps[usize::from(step)];
                let yes = ways.len() as u16;
                ways.extend(both);
                (Node { most, feature, yes }, 0.0)
            }
            Way::End(end) => {
                let yes = nodes.len() as u16;
                (Node { most: f32::INFINITY, feature: 0, yes }, ends[usize::from(end)])
            }
        };
        nodes.push(node);
        worth.push(adds);
    }
    (nodes, worth)
}

/// Adds what some trees make of the features to a score, one after another.
fn add<const N: usize, const A: usize>(trees: &[Tree<N>; A], features: &[f32; N], score: &mut f32) {
    let mut at = [0_usize; A];
    loop {
        let mut moved = 0;
        for (tree, at) in trees.iter().zip(&mut at) {
            let node = tree.nodes[*at];
            let is_more = features[usize::from(node.feature)] > node.most;
            let next = usize::from(node.yes) + usize::from(is_more);
            moved |= next ^ *at;
            *at = next;
        }
        if moved == 0 {
            break;
        }
    }
    trees.iter().zip(at).for_each(|(tree, at)| *score += tree.worth[at]);
}

/// Trees whose scores add up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forest<const N: usize> {
    /// In the order in which they were grown.
    pub trees: Vec<Tree<N>>,
}

impl<const N: usize> Forest<N> {
    /// The sum of all trees' scores: log-odds, up to a constant for the segment. What is not a feature is at
    /// most anything.
    pub fn score(&self, features: &[f32; N]) -> f32 {
        self.scores(std::slice::from_ref(features)).into_iter().sum()
    }

    /// The score of each row.
    pub fn scores(&self, rows: &[[f32; N]]) -> Vec<f32> {
        let mut scores = vec![0.0; rows.len()];
        let (abreast, rest) = self.trees.as_chunks::<ABREAST>();
        for trees in abreast {
            rows.iter().zip(&mut scores).for_each(|(row, score)| add(trees, row, score));
        }
        for tree in rest.as_chunks::<1>().0 {
            rows.iter().zip(&mut scores).for_each(|(row, score)| add(tree, row, score));
        }
        scores
    }

    /// Appends the forest to `bytes`, little-endian:
    ///
    /// - the count of trees (`u32`);
    /// - for each tree its counts of questions and leaves (`u16` each);
    /// - for each question its feature (`u16`), its bound (`f32`) and where it leads for either
    ///   answer (`u16` each: twice the index, plus one for a leaf);
    /// - the values of the leaves (`f32`).
    pub fn write(&self, bytes: &mut Vec<u8>) {
        bytes.extend((self.trees.len() as u32).to_le_bytes());
        for tree in &self.trees {
            bytes.extend((tree.steps.len() as u16).to_le_bytes());
            bytes.extend((tree.ends.len() as u16).to_le_bytes());
            for step in &tree.steps {
                bytes.extend(step.feature.to_le_bytes());
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
pub fn mean_chances<const N: usize>(folds: &[Forest<N>], rows: &[[f32; N]]) -> Vec<f32> {
    mean_chances_of(folds, rows, &[rows.len()])
}

/// The same of several questions, whose rows, so many of each, come one after another: chances that add up
/// to 1 for each question.
pub fn mean_chances_of<const N: usize>(
    folds: &[Forest<N>],
    rows: &[[f32; N]],
    counts: &[usize],
) -> Vec<f32> {
    let mut mean = vec![0.0; rows.len()];
    for fold in folds {
        let scores = fold.scores(rows);
        let (mut means, mut scores) = (&mut mean[..], &scores[..]);
        for &count in counts {
            let (own, scored);
            (own, means) = means.split_at_mut(count.min(means.len()));
            (scored, scores) = scores.split_at(count.min(scores.len()));
            for (sum, chance) in own.iter_mut().zip(chances(scored)) {
                *sum += chance / folds.len() as f32;
            }
        }
    }
    mean
}

fn read_tree<const N: usize>(bytes: &mut &[u8]) -> Option<Tree<N>> {
    let steps = u16::from_le_bytes(take(bytes)?);
    let ends = u16::from_le_bytes(take(bytes)?);
    let steps = (0..steps).map(|_| read_step(bytes)).collect::<Option<_>>()?;
    let ends = (0..ends).map(|_| take(bytes).map(f32::from_le_bytes)).collect::<Option<_>>()?;
    Tree::new(steps, ends)
}

fn read_step(bytes: &mut &[u8]) -> Option<Step> {
    let feature = u16::from_le_bytes(take(bytes)?);
    let most = f32::from_le_bytes(take(bytes)?);
    let way = |written: u16| {
        if written.is_multiple_of(2) { Way::Step(written / 2) } else { Way::End(written / 2) }
    };
    let ways = [u16::from_le_bytes(take(bytes)?), u16::from_le_bytes(take(bytes)?)].map(way);
    Some(Step { feature, most, ways })
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

    /// Asks about feature 3, and of what is more about feature 5.
    fn steps() -> Vec<Step> {
        vec![
            Step { feature: 3, most: 0.5, ways: [Way::End(0), Way::Step(1)] },
            Step { feature: 5, most: -1.0, ways: [Way::End(1), Way::End(2)] },
        ]
    }

    fn features(third: f32, fifth: f32) -> [f32; N] {
        let mut features = [0.0; N];
        (features[3], features[5]) = (third, fifth);
        features
    }

    #[test]
    fn a_forest_adds_up_where_its_trees_end() {
        let tree = Tree::<N>::new(steps(), vec![1.0, 2.0, 4.0]).unwrap();
        let stump = Tree::new(Vec::new(), vec![0.25]).unwrap();
        let forest = Forest { trees: vec![tree, stump] };
        assert_eq!(forest.score(&features(0.5, 9.0)), 1.25);
        assert_eq!(forest.score(&features(0.6, -1.0)), 2.25);
        assert_eq!(forest.score(&features(0.6, 0.0)), 4.25);
    }

    #[test]
    fn trees_abreast_add_up_as_one_by_one() {
        // The k-th tree asks k times about feature 3, each time for half as much more.
        let tree = |k: u16| {
            let ways =
                |i: u16| [Way::End(i), if i + 1 < k { Way::Step(i + 1) } else { Way::End(k) }];
            let most = |i: u16| f32::from(i) * 0.5;
            let steps = (0..k).map(|i| Step { feature: 3, most: most(i), ways: ways(i) });
            let ends = (0..=k).map(|i| f32::from(i) + 0.125);
            Tree::<N>::new(steps.collect(), ends.collect()).unwrap()
        };
        let forest = Forest { trees: (0..2 * ABREAST as u16 + 3).map(tree).collect() };
        let rows: Vec<[f32; N]> = (-1..8).map(|i| features(i as f32, 0.0)).collect();
        let one = |row: &[f32; N]| {
            let alone = |tree: &Tree<N>| Forest { trees: vec![tree.clone()] }.score(row);
            forest.trees.iter().map(alone).sum::<f32>()
        };
        assert_eq!(forest.score(&rows[0]), 15.0 * 0.125);
        assert_eq!(
            forest.score(&rows[2]),
            1.0 + 13.0 * 2.0 + 15.0 * 0.125,
            "0 and 0.5 are less than 1"
        );
        assert_eq!(forest.scores(&rows), rows.iter().map(one).collect::<Vec<_>>());
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
    fn folds_are_heard_alike() {
        let says = |yes: f32, no: f32| {
            let steps = vec![Step { feature: 0, most: 0.0, ways: [Way::End(0), Way::End(1)] }];
            Forest { trees: vec![Tree::<N>::new(steps, vec![yes, no]).unwrap()] }
        };
        let mut rows = [[0.0; N]; 2];
        rows[1][0] = 1.0;
        let [sure, not] = [says(100.0, 0.0), says(0.0, 0.0)];
        let folds = [sure, not];
        assert_eq!(mean_chances(&folds, &rows), [0.75, 0.25]);
        let rows = [rows[0], rows[1], rows[0], rows[0], rows[1]];
        assert_eq!(mean_chances_of(&folds, &rows, &[2, 1, 2]), [0.75, 0.25, 1.0, 0.75, 0.25]);
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
        let shared = |to: Way| {
            let mut steps = steps();
            steps[0].ways[0] = to;
            Tree::<N>::new(steps, vec![1.0, 2.0, 4.0])
        };
        assert!(shared(Way::End(2)).is_some());
        assert_eq!(shared(Way::Step(1)), None);
        let mut steps = steps();
        steps[0].feature = N as u16;
        assert_eq!(Tree::<N>::new(steps, vec![1.0, 2.0, 4.0]), None);
        assert_eq!(Tree::<N>::new(Vec::new(), Vec::new()), None);
        assert_eq!(Tree::<N>::new(Vec::new(), vec![f32::NAN]), None);
    }
}
