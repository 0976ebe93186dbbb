//! Surfaces that are drawn on both sides: every triangle stands there twice, once each way round, so that
//! it is seen from anywhere. What asks how a surface turns, or where its outside is, wants one of the two.

use std::collections::BTreeMap;

use rustc_hash::FxHashMap;

use crate::mesh::{Bounds, Mesh};
use crate::weld::{DisjointSets, Weld};

/// A component is drawn on both sides if this share of its surface is; where two things touch, a few faces
/// may lie on each other as well.
const MOSTLY: f64 = 0.9;

/// One side of a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OneSide {
    /// The faces of that side, ascending.
    pub faces: Vec<usize>,
    /// For each face of the mesh, the place among [`Self::faces`] of the one that lies where it does.
    pub of_face: Vec<usize>,
}

/// The outer side of a mesh, of which components that are drawn on both sides are half; `None` where no
/// component is. Of both sides of a closed sheet that one is outside which encloses space; of an open one,
/// that which looks away from the middle of its component.
pub fn outer_side(mesh: &Mesh, weld: &Weld) -> Option<OneSide> {
    let (component, count) = weld.components();
    let spots = Spots::of(weld, &component);
    let (mut both, mut all) = (vec![0.0; count], vec![0.0; count]);
    for (face, &c) in component.iter().enumerate() {
        let area = mesh.area(face);
        all[c as usize] += area;
        let spot = &spots.all[spots.of_face[face]];
        both[c as usize] += if spot.ways.iter().all(Option::is_some) { area } else { 0.0 };
    }
    let is_both = |c: u32| both[c as usize] > MOSTLY * all[c as usize];
    if !(0..count as u32).any(is_both) {
        return None;
    }
    let mut outward = Outward::of(mesh, (&component, count), &spots, weld);
    let mut stands: Vec<usize> = (0..component.len()).collect();
    for (face, &c) in component.iter().enumerate() {
        if is_both(c) {
            stands[face] = outward.of_spot(&spots.all[spots.of_face[face]]).unwrap_or(face);
        }
    }
    let mut faces = stands.clone();
    faces.sort_unstable();
    faces.dedup();
    let place = |face: &usize| faces.binary_search(face).unwrap_or(0);
    let of_face = stands.iter().map(place).collect();
    Some(OneSide { faces, of_face })
}

/// Where a triangle lies, whichever way round.
#[derive(Clone, Copy, Debug, Default)]
struct Spot {
    /// The first face that lies there each way round.
    ways: [Option<usize>; 2],
}

/// All spots of a mesh.
struct Spots {
    all: Vec<Spot>,
    of_face: Vec<usize>,
}

impl Spots {
    fn of(weld: &Weld, component: &[u32]) -> Self {
        let (mut number, mut all) = (FxHashMap::default(), Vec::<Spot>::new());
        let mut of_face = Vec::with_capacity(component.len());
        for (face, &[a, b, c]) in weld.faces.iter().enumerate() {
            let mut places = [a, b, c];
            places.sort_unstable();
            // A sliver has no sides.
            let sliver = (places[0] == places[1] || places[1] == places[2]).then_some(face);
            let spot = *number.entry((places, sliver)).or_insert(all.len());
            if spot == all.len() {
                all.push(Spot::default());
            }
            let is_odd = [[a, b, c], [b, c, a], [c, a, b]].contains(&places);
            all[spot].ways[usize::from(is_odd)].get_or_insert(face);
            of_face.push(spot);
        }
        Self { all, of_face }
    }
}

/// Sheets, faces that go on into each other the same way round, and how much space each encloses.
struct Outward {
    sheets: DisjointSets,
    /// For the first face of each sheet, cubes of the mesh's unit.
    encloses: Vec<f64>,
}

impl Outward {
    fn of(mesh: &Mesh, (component, count): (&[u32], usize), spots: &Spots, weld: &Weld) -> Self {
        let mut edges: BTreeMap<[u32; 2], Vec<(usize, usize, bool)>> = BTreeMap::new();
        for (spot, Spot { ways }) in spots.all.iter().enumerate() {
            for &face in ways.iter().flatten() {
                let [a, b, c] = weld.faces[face];
                for [p, q] in [[a, b], [b, c], [c, a]] {
                    edges.entry([p.min(q), p.max(q)]).or_default().push((spot, face, p < q));
                }
            }
        }
        let mut sheets = DisjointSets::new(component.len());
        for around in edges.values() {
            // Where more than two triangles meet, nobody knows which goes on into which.
            let Some(&(first, ..)) = around.first() else { continue };
            let Some(&(second, ..)) = around.iter().find(|(spot, ..)| *spot != first) else {
                continue;
            };
            if around.iter().any(|(spot, ..)| *spot != first && *spot != second) {
                continue;
            }
            for &(_, face, ahead) in around.iter().filter(|(spot, ..)| *spot == first) {
                let other =
                    |&&(spot, _, way): &&(usize, usize, bool)| spot == second && way != ahead;
                if let Some(&(_, next, _)) = around.iter().find(other) {
                    sheets.join(face as u32, next as u32);
                }
            }
        }
        let mut bounds = vec![Bounds::of([]); count];
        for (face, &c) in component.iter().enumerate() {
            let (own, all) = (Bounds::of(mesh.corners(face)), &mut bounds[c as usize]);
            *all = Bounds { min: all.min.min(own.min), max: all.max.max(own.max) };
        }
        let mut encloses = vec![0.0; component.len()];
        for &face in spots.all.iter().flat_map(|spot| &spot.ways).flatten() {
            let out = mesh.centroid(face) - bounds[component[face] as usize].centre();
            encloses[sheets.root(face as u32) as usize] += out.dot(mesh.area_vector(face)) / 3.0;
        }
        Self { sheets, encloses }
    }

    /// Of the faces of a spot, that of the sheet which encloses more; the first of the same sheet or of
    /// equals.
    fn of_spot(&mut self, spot: &Spot) -> Option<usize> {
        let [a, b] = spot.ways;
        let (Some(a), Some(b)) = (a, b) else { return a.or(b) };
        let sheets = [a, b].map(|face| self.sheets.root(face as u32));
        let [of_a, of_b] = sheets.map(|sheet| self.encloses[sheet as usize]);
        let is_first = if of_a == of_b { (sheets[0], a) < (sheets[1], b) } else { of_a > of_b };
        Some(if is_first { a } else { b })
    }
}

#[cfg(test)]
mod tests {
    use glamx::DVec3;

    use super::*;

    /// The twelve faces of a box, outward.
    fn cube(min: DVec3, max: DVec3) -> Vec<[DVec3; 3]> {
        let corner = |i: usize| {
            let pick = |k: usize| if i >> k & 1 == 1 { max[k] } else { min[k] };
            DVec3::new(pick(0), pick(1), pick(2))
        };
        let quads =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let halves = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]];
        quads.into_iter().flat_map(halves).map(|f| f.map(corner)).collect()
    }

    fn mesh(faces: &[[DVec3; 3]]) -> Mesh {
        let indices = (0..faces.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        Mesh::new(faces.concat(), indices).unwrap()
    }

    fn turned(face: &[DVec3; 3]) -> [DVec3; 3] {
        [face[1], face[0], face[2]]
    }

    fn outer(mesh: &Mesh) -> Option<OneSide> {
        outer_side(mesh, &Weld::new(mesh))
    }

    #[test]
    fn of_a_box_drawn_on_both_sides_the_outer_one_is_kept() {
        let once = cube(DVec3::splat(5.0), DVec3::splat(6.0));
        // Every third face stands there first as seen from within, and two are there three times.
        let first = |(i, f): (usize, &[DVec3; 3])| if i % 3 == 0 { turned(f) } else { *f };
        let mut both: Vec<_> = once.iter().enumerate().map(first).collect();
        both.extend(once.iter().enumerate().map(|(i, f)| turned(&first((i, f)))));
        both.extend([once[4], turned(&once[7])]);
        let both = mesh(&both);
        let side = outer(&both).unwrap();
        assert_eq!(side.faces.len(), 12);
        let kept = both.submesh(side.faces.iter().copied()).unwrap();
        assert!((kept.signed_volume() - 1.0).abs() < 1e-12, "{}", kept.signed_volume());
        for (face, &place) in side.of_face.iter().enumerate() {
            let there = both.centroid(side.faces[place]);
            assert!(there.distance(both.centroid(face)) < 1e-12);
        }
    }

    #[test]
    fn what_is_drawn_once_is_left_alone_where_two_things_touch() {
        let low = cube(DVec3::ZERO, DVec3::ONE);
        let high = cube(DVec3::Z, DVec3::new(1.0, 1.0, 2.0));
        let stack = mesh(&[low, high].concat());
        assert_eq!(Weld::new(&stack).components().1, 1, "they are one by their places");
        assert_eq!(outer(&stack), None);
    }

    #[test]
    fn beside_what_is_drawn_on_both_sides_the_rest_stays() {
        let (once, far) =
            (cube(DVec3::ZERO, DVec3::ONE), cube(DVec3::splat(3.0), DVec3::splat(4.0)));
        let both: Vec<_> = far.iter().flat_map(|f| [turned(f), *f]).collect();
        let side = outer(&mesh(&[once, both].concat())).unwrap();
        let outward = (0..12).map(|i| 12 + 2 * i + 1);
        assert_eq!(side.faces, (0..12).chain(outward).collect::<Vec<_>>());
    }

    #[test]
    fn an_open_sheet_looks_away_from_the_middle() {
        // Three walls of a box, and slivers on both of their sides.
        let walls = &cube(DVec3::ZERO, DVec3::ONE)[..6];
        let mut both: Vec<_> = walls.iter().flat_map(|f| [turned(f), *f]).collect();
        both.push([DVec3::ZERO, DVec3::X, DVec3::X]);
        let side = outer(&mesh(&both)).unwrap();
        assert_eq!(side.faces, [1, 3, 5, 7, 9, 11, 12]);
        assert_eq!(side.of_face, [0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6]);
    }

    #[test]
    fn a_band_with_one_side_keeps_one_face_of_each_two() {
        let count = 12;
        let rail = |i: usize, side: f64| {
            let turn = i as f64 / count as f64 * std::f64::consts::TAU;
            let out = DVec3::new(turn.cos(), turn.sin(), 0.0);
            out * 2.0 + (out * (turn / 2.0).cos() + DVec3::Z * (turn / 2.0).sin()) * side
        };
        let piece = |i: usize| {
            // The last piece meets the first one upside down.
            let (a, b) = (rail(i, -0.5), rail(i, 0.5));
            let (c, d) = (rail(i + 1, -0.5), rail(i + 1, 0.5));
            [[a, b, c], [b, d, c]]
        };
        let once: Vec<_> = (0..count).flat_map(piece).collect();
        let both: Vec<_> = once.iter().flat_map(|f| [*f, turned(f)]).collect();
        let side = outer(&mesh(&both)).unwrap();
        assert_eq!(side.faces.len(), once.len());
    }
}
