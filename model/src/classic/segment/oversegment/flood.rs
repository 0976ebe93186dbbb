//! Geodesic watershed: every node goes to the start it is cheapest to reach.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// For each of `nodes` nodes, the index of the start it is cheapest to reach over the `ways`
/// (node, node, cost ≥ 0, both directions); `None` where no start can be reached. Ties go to the
/// lower node, then the lower start.
pub(crate) fn flood(nodes: usize, ways: &[(u32, u32, f64)], starts: &[u32]) -> Vec<Option<usize>> {
    let around = around(nodes, ways);
    let mut owner = vec![None; nodes];
    let mut heap: BinaryHeap<_> =
        starts.iter().enumerate().map(|(i, &n)| Reverse((Cost(0.0), n, i))).collect();
    let mut best = vec![f64::INFINITY; nodes];
    while let Some(Reverse((Cost(cost), node, start))) = heap.pop() {
        if owner[node as usize].is_some() {
            continue;
        }
        owner[node as usize] = Some(start);
        for &(next, way) in &around[node as usize] {
            let there = cost + way;
            if owner[next as usize].is_none() && there < best[next as usize] {
                best[next as usize] = there;
                heap.push(Reverse((Cost(there), next, start)));
            }
        }
    }
    owner
}

/// The least cost to each node from any of the `starts`, over neighbours and costs ≥ 0; other nodes for which
/// `wall` holds are reached but not passed.
pub(crate) fn costs_from(
    around: &[Vec<(u32, f64)>],
    starts: &[u32],
    wall: impl Fn(u32) -> bool,
) -> Vec<f64> {
    /// Costs that are not negative are in the order of their bits.
    fn entry(cost: f64, node: u32) -> Reverse<u128> {
        Reverse(u128::from(cost.to_bits()) << 32 | u128::from(node))
    }
    let mut best = vec![f64::INFINITY; around.len()];
    let mut heap = BinaryHeap::new();
    for &start in starts {
        best[start as usize] = 0.0;
        heap.push(entry(0.0, start));
    }
    while let Some(Reverse(entered)) = heap.pop() {
        let (node, cost) = (entered as u32, f64::from_bits((entered >> 32) as u64));
        if cost > best[node as usize] || (wall(node) && !starts.contains(&node)) {
            continue;
        }
        for &(next, way) in &around[node as usize] {
            let there = cost + way;
            if there < best[next as usize] {
                best[next as usize] = there;
                heap.push(entry(there, next));
            }
        }
    }
    best
}

/// For each node, its neighbours and the cost to get there.
pub(crate) fn around(nodes: usize, ways: &[(u32, u32, f64)]) -> Vec<Vec<(u32, f64)>> {
    let mut around = vec![Vec::new(); nodes];
    for &(a, b, cost) in ways {
        around[a as usize].push((b, cost));
        around[b as usize].push((a, cost));
    }
    around
}

/// A cost that can be ordered.
#[derive(Clone, Copy, PartialEq)]
struct Cost(f64);

impl Eq for Cost {}

impl PartialOrd for Cost {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cost {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_goes_to_the_start_with_the_cheaper_way() {
        let ways = [(0, 1, 1.0), (1, 2, 1.0), (2, 3, 5.0), (3, 4, 1.0)];
        let owner = flood(6, &ways, &[0, 4]);
        assert_eq!(owner, [Some(0), Some(0), Some(0), Some(1), Some(1), None]);
    }

    #[test]
    fn walls_are_reached_but_not_passed() {
        let around = around(3, &[(0, 1, 1.0), (1, 2, 1.0)]);
        assert_eq!(costs_from(&around, &[0], |n| n == 1), [0.0, 1.0, f64::INFINITY]);
        assert_eq!(costs_from(&around, &[0], |_| false), [0.0, 1.0, 2.0]);
        assert_eq!(costs_from(&around, &[0, 2], |n| n > 0), [0.0, 1.0, 0.0]);
    }
}
