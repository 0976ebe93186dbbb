//! Where a patch of faces ends: its border as simple loops, in the sense a cap would walk them.

use std::collections::BTreeMap;

/// The loops of places around which faces are missing, each at least three places long and none
/// visited twice within a loop. A face put into a loop walks it as given.
///
/// `faces` hold places and are oriented. Edges walked as often one way as the other are no border;
/// whatever is left over is a sum of closed loops, so that filling all of them closes the patch.
pub(crate) fn loops(faces: impl Iterator<Item = [u32; 3]>) -> Vec<Vec<u32>> {
    let mut onward = onward(faces);
    let mut loops = Vec::new();
    while let Some(&start) = onward.keys().next() {
        let mut path = vec![start];
        while let Some(next) = path.last().and_then(|at| step(&mut onward, *at)) {
            match path.iter().position(|&p| p == next) {
                Some(first) => {
                    let closed: Vec<u32> = path.drain(first..).collect();
                    loops.push(closed);
                    if path.is_empty() {
                        break;
                    }
                    path.push(next);
                }
                None => path.push(next),
            }
        }
    }
    loops.retain(|l| l.len() >= 3);
    loops
}

/// For each place, where a cap goes from there: against the walks that nothing answers.
fn onward(faces: impl Iterator<Item = [u32; 3]>) -> BTreeMap<u32, Vec<u32>> {
    let mut onward: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for ([low, high], surplus) in surplus(faces) {
        let (from, to) = if surplus > 0 { (high, low) } else { (low, high) };
        (0..surplus.abs()).for_each(|_| onward.entry(from).or_default().push(to));
    }
    onward
}

/// Edges that are not walked as often one way as the other, smaller place first, and how much oftener
/// they are walked from the smaller to the larger.
pub(crate) fn surplus(faces: impl Iterator<Item = [u32; 3]>) -> BTreeMap<[u32; 2], i32> {
    let mut surplus: BTreeMap<[u32; 2], i32> = BTreeMap::new();
    for [a, b, c] in faces {
        for [p, q] in [[a, b], [b, c], [c, a]] {
            let way = if p < q { 1 } else { -1 };
            *surplus.entry([p.min(q), p.max(q)]).or_default() += way;
        }
    }
    surplus.retain(|[p, q], sum| p != q && *sum != 0);
    surplus
}

/// Takes the first way onward from a place.
fn step(onward: &mut BTreeMap<u32, Vec<u32>>, at: u32) -> Option<u32> {
    let ways = onward.get_mut(&at)?;
    let next = ways.remove(0);
    if ways.is_empty() {
        onward.remove(&at);
    }
    Some(next)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_border_of_a_square_is_walked_against_its_faces() {
        let square = [[0, 1, 2], [0, 2, 3]];
        assert_eq!(loops(square.into_iter()), [[0, 3, 2, 1]]);
    }

    #[test]
    fn two_triangles_that_meet_in_a_point_have_two_borders() {
        let mut found = loops([[0, 1, 2], [2, 3, 4]].into_iter());
        found.iter_mut().for_each(|l| l.sort_unstable());
        found.sort_unstable();
        assert_eq!(found, [[0, 1, 2], [2, 3, 4]]);
    }

    #[test]
    fn a_closed_surface_has_none() {
        assert!(loops([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]].into_iter()).is_empty());
    }
}
