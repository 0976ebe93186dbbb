//! Points for the corners of a surface such that at each point the faces lie round it like the
//! blades of one fan: where several fans meet, each has a point of its own there.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use glamx::DVec3;
use object::weld::DisjointSets;

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

/// Which faces hang together across an edge where several bodies meet.
#[derive(Clone, Copy, Default, PartialEq)]
enum Way {
    /// Those between which the body lies.
    #[default]
    Inside,
    /// Those between which there is nothing.
    Outside,
    /// None: a seam.
    Apart,
}

/// Times pairs are chosen anew where a surface would still meet itself.
const ROUNDS: usize = 8;

/// For each corner of each face, the number of its point. `places` are welded corners, at
/// `positions`; `vertices` are the file's own.
///
/// Two faces hang together across an edge that they alone share, or whose vertices in the file they
/// alone share; of other faces that meet at an edge, those do between which the body lies. Where
/// such a surface meets itself, so that an edge would have more than two faces all the same, those
/// hang together between which there is nothing, and where that does not help, none.
pub(crate) fn points_of(
    positions: &[DVec3],
    places: &[[u32; 3]],
    vertices: &[[u32; 3]],
) -> Vec<[u32; 3]> {
    let surface = Surface { positions, places, vertices };
    let mut edges: Vec<(Vec<Use>, Way)> =
        edges(places).into_values().map(|uses| (uses, Way::default())).collect();
    let mut points = surface.points(&edges);
    for _ in 0..ROUNDS {
        let mut is_done = true;
        for (uses, way) in &mut edges {
            if *way != Way::Apart && meets_itself(uses, &points) {
                *way =
                    if *way == Way::Inside && uses.len() > 2 { Way::Outside } else { Way::Apart };
                is_done = false;
            }
        }
        if is_done {
            break;
        }
        points = surface.points(&edges);
    }
    points
}

/// Whether some faces of an edge share both its points but are not just two that walk it either way.
fn meets_itself(uses: &[Use], points: &[[u32; 3]]) -> bool {
    let ends = |of: &Use| of.corners.map(|c| points[(c / 3) as usize][(c % 3) as usize]);
    let mut shared: BTreeMap<_, (usize, usize)> = BTreeMap::new();
    for of in uses {
        let (forward, backward) = shared.entry(ends(of)).or_default();
        *if of.forward { forward } else { backward } += 1;
    }
    shared.values().any(|&(forward, backward)| forward > 1 || backward > 1)
}

struct Surface<'a> {
    positions: &'a [DVec3],
    places: &'a [[u32; 3]],
    vertices: &'a [[u32; 3]],
}

impl Surface<'_> {
    fn points(&self, edges: &[(Vec<Use>, Way)]) -> Vec<[u32; 3]> {
        let mut same = DisjointSets::new(3 * self.places.len());
        for (uses, way) in edges {
            for [a, b] in self.joined(uses, *way) {
                (0..2).for_each(|end| same.join(a.corners[end], b.corners[end]));
            }
        }
        let mut numbers = BTreeMap::new();
        let mut point = |corner: u32| {
            let next = numbers.len() as u32;
            *numbers.entry(same.root(corner)).or_insert(next)
        };
        (0..self.places.len() as u32).map(|f| [0, 1, 2].map(|k| point(3 * f + k))).collect()
    }

    /// Pairs of faces that hang together across one edge.
    fn joined(&self, uses: &[Use], way: Way) -> Vec<[Use; 2]> {
        match (uses, way) {
            (_, Way::Apart) => Vec::new(),
            (&[a, b], _) => vec![[a, b]],
            (_, Way::Outside) => self.around(uses, way),
            (_, Way::Inside) => self.by_vertices(uses),
        }
    }

    fn by_vertices(&self, uses: &[Use]) -> Vec<[Use; 2]> {
        let vertex = |corner: u32| self.vertices[(corner / 3) as usize][(corner % 3) as usize];
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
        pairs.extend(self.around(&left, Way::Inside));
        pairs
    }

    /// Faces round an edge, each that walks it forward with the next one on the side asked for, if
    /// that walks it backward.
    fn around(&self, uses: &[Use], way: Way) -> Vec<[Use; 2]> {
        let Some(first) = uses.first() else { return Vec::new() };
        let place = |corner: u32| self.places[(corner / 3) as usize][(corner % 3) as usize];
        let at = |corner: u32| self.positions[place(corner) as usize];
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
        let sign = if way == Way::Inside { -1.0 } else { 1.0 };
        let mut order: Vec<_> = uses.iter().map(|of| (sign * angle(of), *of)).collect();
        order.sort_by(|(a, one), (b, two)| {
            a.total_cmp(b).then(one.forward.cmp(&two.forward)).then(one.face.cmp(&two.face))
        });
        let next = order.iter().cycle().skip(1);
        let pairs = order.iter().zip(next).filter(|(a, b)| a.1.forward && !b.1.forward);
        pairs.map(|(a, b)| [a.1, b.1]).collect()
    }
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

    /// Two blocks that touch along an edge, between two slabs: at each end of it the faces lie
    /// round in one fan that comes by the edge twice.
    #[test]
    fn a_body_that_touches_itself_along_an_edge_has_two_faces_to_an_edge() {
        let slab = |z| [[0, 0, z], [1, 0, z], [0, 1, z], [1, 1, z]];
        let cells = [&slab(-1)[..], &[[0, 0, 0], [1, 1, 0]], &slab(1)].concat();
        let weld = Weld::new(&solid(&cells));
        let surface =
            Surface { positions: &weld.places, places: &weld.faces, vertices: &weld.faces };
        let edges: Vec<_> =
            edges(&weld.faces).into_values().map(|uses| (uses, Way::Inside)).collect();
        let inside = surface.points(&edges);
        assert!(edges.iter().any(|(uses, _)| meets_itself(uses, &inside)), "nothing to mend");
        let points = points_of(&weld.places, &weld.faces, &weld.faces);
        let mut walks = BTreeMap::new();
        for [a, b, c] in points {
            for walk in [[a, b], [b, c], [c, a]] {
                *walks.entry(walk).or_insert(0) += 1;
            }
        }
        let is_paired = |&[a, b]: &[u32; 2]| walks.get(&[b, a]) == Some(&1);
        assert!(walks.values().all(|n| *n == 1) && walks.keys().all(is_paired));
    }

    /// The outer walls of unit cells.
    fn solid(cells: &[[i32; 3]]) -> Mesh {
        let outer = |&cell: &[i32; 3]| {
            let whole = block(DVec3::ONE, DVec3::from_array(cell.map(f64::from)));
            let beyond = |f: usize| {
                let n = whole.normal(f).to_array();
                std::array::from_fn(|k| cell[k] + n[k].round() as i32)
            };
            let faces = (0..12).filter(|&f| !cells.contains(&beyond(f)));
            whole.submesh(faces).unwrap()
        };
        joined(&cells.iter().map(outer).collect::<Vec<_>>())
    }
}
