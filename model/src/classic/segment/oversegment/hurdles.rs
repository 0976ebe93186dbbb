//! The highest single cost on the way to each node, where that is lowest.

/// Neighbours and costs ≥ 0, ready to be asked for ways from many starts.
///
/// The lowest hurdles between nodes that may be passed all lie on one tree, that of least costs.
pub(crate) struct Hurdles<'a> {
    around: &'a [Vec<(u32, f64)>],
    is_wall: Vec<bool>,
    /// The nodes of the tree, each with the one that it hangs on and the cost to get there; whatever a node
    /// hangs on comes before it.
    tree: Vec<(u32, u32, f64)>,
}

impl<'a> Hurdles<'a> {
    /// Nodes for which `wall` holds are reached but not passed, unless a way starts there.
    pub(crate) fn of(around: &'a [Vec<(u32, f64)>], wall: impl Fn(u32) -> bool) -> Self {
        let nodes = 0..around.len() as u32;
        let is_wall: Vec<bool> = nodes.clone().map(wall).collect();
        let mut ways: Vec<(f64, u32, u32)> = Vec::new();
        for a in nodes.filter(|a| !is_wall[*a as usize]) {
            let later = around[a as usize].iter().filter(|(b, _)| a < *b && !is_wall[*b as usize]);
            ways.extend(later.map(|&(b, cost)| (cost.max(0.0), a, b)));
        }
        ways.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { around, tree: hung_up(&least(around.len(), &ways)), is_wall }
    }

    /// The highest single cost on the way to each node from any of the `starts`, where that is lowest.
    pub(crate) fn from(&self, starts: &[u32]) -> Vec<f64> {
        let mut best = vec![f64::INFINITY; self.around.len()];
        let lower = |best: &mut [f64], node: u32, cost: f64| {
            let known = &mut best[node as usize];
            *known = known.min(cost);
        };
        for &start in starts {
            best[start as usize] = 0.0;
            for &(next, cost) in &self.around[start as usize] {
                if !self.is_wall[next as usize] {
                    lower(&mut best, next, cost.max(0.0));
                }
            }
        }
        for &(node, on, cost) in self.tree.iter().rev() {
            let there = best[node as usize].max(cost);
            lower(&mut best, on, there);
        }
        for &(node, on, cost) in &self.tree {
            let there = best[on as usize].max(cost);
            lower(&mut best, node, there);
        }
        for node in (0..self.around.len()).filter(|node| self.is_wall[*node]) {
            for &(next, cost) in &self.around[node] {
                if !self.is_wall[next as usize] || starts.contains(&next) {
                    let there = best[next as usize].max(cost.max(0.0));
                    lower(&mut best, node as u32, there);
                }
            }
        }
        best
    }
}

/// For each node its neighbours in the trees of least costs, from ways in order of cost.
fn least(nodes: usize, ways: &[(f64, u32, u32)]) -> Vec<Vec<(u32, f64)>> {
    let mut into: Vec<u32> = (0..nodes as u32).collect();
    let mut trees = vec![Vec::new(); nodes];
    for &(cost, a, b) in ways {
        let (of_a, of_b) = (root(&mut into, a), root(&mut into, b));
        if of_a != of_b {
            into[of_b as usize] = of_a;
            trees[a as usize].push((b, cost));
            trees[b as usize].push((a, cost));
        }
    }
    trees
}

fn root(into: &mut [u32], mut node: u32) -> u32 {
    while into[node as usize] != node {
        into[node as usize] = into[into[node as usize] as usize];
        node = into[node as usize];
    }
    node
}

/// The nodes of trees that hang on another, what they hang on first.
fn hung_up(trees: &[Vec<(u32, f64)>]) -> Vec<(u32, u32, f64)> {
    let mut is_seen = vec![false; trees.len()];
    let mut hung: Vec<(u32, u32, f64)> = Vec::new();
    for first in 0..trees.len() as u32 {
        let (mut next, mut node) = (hung.len(), first);
        if is_seen[first as usize] {
            continue;
        }
        loop {
            is_seen[node as usize] = true;
            let new = trees[node as usize].iter().filter(|(other, _)| !is_seen[*other as usize]);
            hung.extend(new.map(|&(other, cost)| (other, node, cost)));
            let Some(&(other, ..)) = hung.get(next) else { break };
            (node, next) = (other, next + 1);
        }
    }
    hung
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::classic::segment::oversegment::flood::around;

    #[test]
    fn the_way_with_the_lower_hurdle_counts_however_long_it_is() {
        let around = around(4, &[(0, 1, 2.0), (0, 2, 1.0), (2, 3, 1.0), (3, 1, 1.0)]);
        assert_eq!(Hurdles::of(&around, |_| false).from(&[0]), [0.0, 1.0, 1.0, 1.0]);
        assert_eq!(Hurdles::of(&around, |n| n == 3).from(&[0]), [0.0, 2.0, 1.0, 1.0], "a wall");
        assert_eq!(Hurdles::of(&around, |n| n != 1).from(&[0, 3]), [0.0, 1.0, 1.0, 0.0]);
    }

    /// The least of the highest costs, by asking again and again whether there is a lower one.
    fn slowly(around: &[Vec<(u32, f64)>], starts: &[u32], wall: impl Fn(u32) -> bool) -> Vec<f64> {
        let mut best = vec![f64::INFINITY; around.len()];
        starts.iter().for_each(|s| best[*s as usize] = 0.0);
        for _ in around {
            for node in (0..around.len() as u32).filter(|n| !wall(*n) || starts.contains(n)) {
                for &(next, cost) in &around[node as usize] {
                    let there = best[node as usize].max(cost);
                    best[next as usize] = best[next as usize].min(there);
                }
            }
        }
        best
    }

    #[test]
    fn whatever_the_ways_the_lowest_hurdles_are_found() {
        let mut state = 5_u32;
        let mut next = |below: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % below
        };
        for _ in 0..50 {
            let ways: Vec<(u32, u32, f64)> =
                (0..40).map(|_| (next(25), next(25), f64::from(next(8)))).collect();
            let around = around(25, &ways);
            let wall = |node: u32| node.is_multiple_of(4);
            let hurdles = Hurdles::of(&around, wall);
            for starts in [vec![next(25)], vec![0, 8], vec![4 * next(6), 4 * next(6), next(25)]] {
                assert_eq!(hurdles.from(&starts), slowly(&around, &starts, wall), "{starts:?}");
            }
        }
    }
}
