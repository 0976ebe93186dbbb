//! A surface cut into patches that can be oriented: faces joined wherever just two meet.

use object::sheets::{Join, Sheets};

/// Faces grouped into patches; within one patch every joined edge is walked once each way, after
/// the faces marked `flipped` have been turned over.
#[derive(Clone, Debug)]
pub(crate) struct Patches {
    /// The patch of each face, numbered in order of first face.
    pub(crate) patch_of_face: Vec<u32>,
    /// Faces of each patch, ascending.
    pub(crate) faces: Vec<Vec<u32>>,
    /// Faces that must be turned over to agree with the largest share of their patch.
    pub(crate) flipped: Vec<bool>,
    /// Joins that no orientation satisfies (a Möbius strip has some).
    pub(crate) conflicts: usize,
}

/// One face's use of an edge.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Use {
    /// The two places, smaller first.
    places: [u32; 2],
    /// The two vertices of the file, smaller first.
    vertices: [u32; 2],
    face: u32,
    /// Whether the face walks from the smaller place to the larger.
    forward: bool,
}

impl Patches {
    /// Patches of faces given by welded `places` and by the file's own `vertices`; `area` decides
    /// which side of a patch is the majority.
    pub(crate) fn new(places: &[[u32; 3]], vertices: &[[u32; 3]], area: &[f64]) -> Self {
        let Sheets { of_face, faces, mut is_turned, conflicts } =
            Sheets::of(&joins(&uses(places, vertices), places.len()));
        for patch in &faces {
            settle_majority(patch, area, &mut is_turned);
        }
        let conflicts = conflicts.iter().sum();
        Self { patch_of_face: of_face, faces, flipped: is_turned, conflicts }
    }

    /// For each patch, whether its oriented faces have no border: every edge is walked as often
    /// one way as the other, so the volume they enclose is exact.
    pub(crate) fn closed(&self, places: &[[u32; 3]]) -> Vec<bool> {
        let mut walks: Vec<(u32, [u32; 2], i32)> = Vec::with_capacity(places.len() * 3);
        for (face, corners) in places.iter().enumerate() {
            let sign = if self.flipped[face] { -1 } else { 1 };
            for [p, q] in edges(*corners) {
                let way = if p < q { sign } else { -sign };
                walks.push((self.patch_of_face[face], [p.min(q), p.max(q)], way));
            }
        }
        walks.sort_unstable();
        let mut closed = vec![true; self.faces.len()];
        for edge in walks.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            if edge.iter().map(|w| w.2).sum::<i32>() != 0 {
                closed[edge[0].0 as usize] = false;
            }
        }
        closed
    }
}

fn edges([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

fn uses(places: &[[u32; 3]], vertices: &[[u32; 3]]) -> Vec<Use> {
    let mut uses = Vec::with_capacity(places.len() * 3);
    for (face, (p, v)) in places.iter().zip(vertices).enumerate() {
        for ([p, q], [u, w]) in edges(*p).into_iter().zip(edges(*v)) {
            let (places, vertices) = ([p.min(q), p.max(q)], [u.min(w), u.max(w)]);
            uses.push(Use { places, vertices, face: face as u32, forward: p < q });
        }
    }
    uses.sort_unstable();
    uses
}

/// Turns a patch round if most of its area would otherwise be turned over.
fn settle_majority(patch: &[u32], area: &[f64], is_turned: &mut [bool]) {
    let side = |&face: &u32| {
        let face = face as usize;
        if is_turned[face] { -area[face] } else { area[face] }
    };
    if patch.iter().map(side).sum::<f64>() < 0.0 {
        patch.iter().for_each(|&face| is_turned[face as usize] ^= true);
    }
}

/// Two faces are joined when they alone share an edge; where more meet (bodies that touch), when
/// they alone share its vertices in the file.
fn joins(uses: &[Use], faces: usize) -> Vec<Vec<Join>> {
    let mut joins = vec![Vec::new(); faces];
    let mut join = |a: &Use, b: &Use| {
        let is_opposed = a.forward == b.forward;
        joins[a.face as usize].push(Join { other: b.face, is_opposed });
        joins[b.face as usize].push(Join { other: a.face, is_opposed });
    };
    for edge in uses.chunk_by(|a, b| a.places == b.places) {
        if let [a, b] = edge {
            join(a, b);
            continue;
        }
        for own in edge.chunk_by(|a, b| a.vertices == b.vertices) {
            if let [a, b] = own {
                join(a, b);
            }
        }
    }
    joins
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{block, joined};
    use glamx::DVec3;
    use object::weld::Weld;

    fn patches(faces: &[[u32; 3]]) -> Patches {
        Patches::new(faces, faces, &vec![1.0; faces.len()])
    }

    #[test]
    fn one_face_turned_over_is_found() {
        let mut faces = block(DVec3::ONE, DVec3::ZERO).faces().to_vec();
        faces[7].swap(0, 1);
        let p = patches(&faces);
        let flipped: Vec<_> = (0..12).filter(|&f| p.flipped[f]).collect();
        assert_eq!((flipped, p.conflicts, p.closed(&faces)), (vec![7], 0, vec![true]));
    }

    #[test]
    fn an_open_block_is_not_closed() {
        let faces = &block(DVec3::ONE, DVec3::ZERO).faces()[1..].to_vec();
        assert_eq!(patches(faces).closed(faces), [false]);
    }

    #[test]
    fn blocks_that_touch_along_a_wall_stay_two_closed_bodies() {
        let two = joined(&[block(DVec3::ONE, DVec3::ZERO), block(DVec3::ONE, DVec3::X)]);
        let weld = Weld::new(&two);
        let p = Patches::new(&weld.faces, two.faces(), &[1.0; 24]);
        assert_eq!((p.faces.len(), p.conflicts), (2, 0));
        assert_eq!(p.closed(&weld.faces), [true, true]);
    }

    #[test]
    fn a_moebius_strip_is_reported() {
        let n = 7;
        let at = |i: u32, side: u32| if i < n { 2 * i + side } else { 1 - side };
        let quad = |i: u32| {
            let [a, b, c, d] = [at(i, 0), at(i, 1), at(i + 1, 0), at(i + 1, 1)];
            [[a, b, c], [b, d, c]]
        };
        let faces: Vec<_> = (0..n).flat_map(quad).collect();
        assert_eq!(patches(&faces).conflicts, 1);
    }
}
