//! Points for the corners of a surface such that at each point the faces lie round it like the
//! blades of one fan: where several fans meet, each has a point of its own there.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use glamx::DVec3;

/// Faces round an edge this near each other lie on each other, radians.
const SAME_ANGLE: f64 = 1e-6;

/// One face's use of an edge: its corners at the lower and at the upper place.
#[derive(Clone, Copy)]
struct Use {
    face: u32,
    corners: [u32; 2],
    /// Whether the face walks from the lower place to the upper one.
    forward: bool,
}

/// For each corner of each face, the number of its point. `places` are welded corners, at
/// `positions`; `vertices` are the file's own.
///
/// Two faces hang together across an edge that they alone share, or whose vertices in the file they
/// alone share; of other faces that meet at an edge, those do between which the body lies.
pub(crate) fn points_of(
    positions: &[DVec3],
    places: &[[u32; 3]],
    vertices: &[[u32; 3]],
) -> Vec<[u32; 3]> {
    let mut same: Vec<u32> = (0..3 * places.len() as u32).collect();
    for uses in edges(places).values() {
        for [a, b] in joined(uses, positions, places, vertices) {
            (0..2).for_each(|end| unite(&mut same, a.corners[end], b.corners[end]));
        }
    }
    let mut numbers = BTreeMap::new();
    let mut point = |corner: u32| {
        let next = numbers.len() as u32;
        *numbers.entry(find(&mut same, corner)).or_insert(next)
    };
    (0..places.len() as u32).map(|f| [0, 1, 2].map(|k| point(3 * f + k))).collect()
}

fn edges(places: &[[u32; 3]]) -> BTreeMap<[u32; 2], Vec<Use>> {
    let mut edges: BTreeMap<_, Vec<Use>> = BTreeMap::new();
    for (f, face) in (0u32..).zip(places) {
        for k in 0..3 {
            let next = (k + 1) % 3;
            if face[k] == face[next] {
                continue;
            }
            let forward = face[k] < face[next];
            let [low, high] = if forward { [k, next] } else { [next, k] };
            let corners = [low, high].map(|c| 3 * f + c as u32);
            let of = Use { face: f, corners, forward };
            edges.entry([face[low], face[high]]).or_default().push(of);
        }
    }
    edges
}

/// Pairs of faces that hang together across one edge.
fn joined(
    uses: &[Use],
    positions: &[DVec3],
    places: &[[u32; 3]],
    vertices: &[[u32; 3]],
) -> Vec<[Use; 2]> {
    if let &[a, b] = uses {
        return vec![[a, b]];
    }
    let vertex = |corner: u32| vertices[(corner / 3) as usize][(corner % 3) as usize];
    let mut own: BTreeMap<[u32; 2], Vec<Use>> = BTreeMap::new();
    for of in uses {
        own.entry(of.corners.map(vertex)).or_default().push(*of);
    }
    let (mut pairs, mut left) = (Vec::new(), Vec::new());
    for of in own.into_values() {
        match of[..] {
            [a, b] if a.forward != b.forward => pairs.push([a, b]),
            _ => left.extend(of),
        }
    }
    pairs.extend(around(left, positions, places));
    pairs
}

/// Faces round an edge, each that walks it forward with the next one on its inner side, if that
/// walks it backward.
fn around(uses: Vec<Use>, positions: &[DVec3], places: &[[u32; 3]]) -> Vec<[Use; 2]> {
    let Some(first) = uses.first() else { return Vec::new() };
    let at = |corner: u32| positions[places[(corner / 3) as usize][(corner % 3) as usize] as usize];
    let [low, high] = first.corners.map(at);
    let along = (high - low).normalize_or_zero();
    let aside = |of: &Use| {
        let third = (0..3).map(|k| 3 * of.face + k).find(|c| !of.corners.contains(c));
        let arm = third.map_or(DVec3::ZERO, |c| at(c) - low);
        arm - along * arm.dot(along)
    };
    let zero = aside(first);
    let angle = |of: &Use| {
        let arm = aside(of);
        let angle = zero.cross(arm).dot(along).atan2(zero.dot(arm)).rem_euclid(TAU);
        if angle > TAU - SAME_ANGLE { 0.0 } else { angle }
    };
    // The body lies at lesser angles than what walks the edge forward.
    let mut order: Vec<_> = uses.iter().map(|of| (angle(of), of.forward, *of)).collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)).then(a.2.face.cmp(&b.2.face)));
    let next = order.iter().cycle().skip(1);
    let pairs = order.iter().zip(next).filter(|(a, b)| a.2.forward && !b.2.forward);
    pairs.map(|(a, b)| [a.2, b.2]).collect()
}

fn find(same: &mut [u32], mut corner: u32) -> u32 {
    while same[corner as usize] != corner {
        let above = same[same[corner as usize] as usize];
        same[corner as usize] = above;
        corner = above;
    }
    corner
}

fn unite(same: &mut [u32], a: u32, b: u32) {
    let [a, b] = [find(same, a), find(same, b)];
    same[a.max(b) as usize] = a.min(b);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{block, joined};
    use object::Mesh;
    use object::weld::Weld;

    /// How many points the welded surface of these bodies has.
    fn points(of: &[Mesh]) -> u32 {
        let weld = Weld::new(&joined(of));
        let points = points_of(&weld.places, &weld.faces, &weld.faces);
        1 + points.into_iter().flatten().max().unwrap()
    }

    #[test]
    fn one_block_has_eight() {
        assert_eq!(points(&[block(DVec3::ONE, DVec3::ZERO)]), 8);
    }

    #[test]
    fn blocks_that_touch_at_a_corner_or_along_an_edge_have_eight_each() {
        for there in [DVec3::ONE, DVec3::new(1.0, 1.0, 0.0)] {
            let two = [block(DVec3::ONE, DVec3::ZERO), block(DVec3::ONE, there)];
            assert_eq!(points(&two), 16, "{there}");
        }
    }

    #[test]
    fn four_blocks_round_an_edge_stay_four() {
        let place = |(x, y)| block(DVec3::ONE, DVec3::new(x, y, 0.0));
        let four = [(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)].map(place);
        assert_eq!(points(&four), 32);
    }
}
