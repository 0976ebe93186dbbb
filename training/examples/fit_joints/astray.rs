//! Labels that are wrong as found ones are wrong about pieces: of each part one piece, where it meets what
//! it hangs on, is of the other.

use std::collections::BTreeMap;

use model::geometric::joints::Labelled;
use object::DVec3;
use object::mesh::Bounds;

use super::Side;

/// Pieces that lie no farther apart than this share of the diagonal meet.
const MEET: f64 = 0.01;
/// What is more than this many times as large as the part is taken for the part's by nobody.
const AS_LARGE: f64 = 1.5;

/// What hangs together and is of one part.
struct Piece {
    part: usize,
    faces: Vec<usize>,
    area: f64,
    bounds: Bounds,
}

/// The part of each face once every part, or what it hangs on, has a piece of the other, and of which parts
/// that is so.
pub(super) fn given(from: &Labelled, side: Side) -> (Vec<u16>, Vec<bool>) {
    let pieces = pieces(from);
    let (tree, near) = (from.tree, MEET * from.mesh.bounds().diagonal());
    let (mut labels, mut is_changed) = (from.part_of_face.to_vec(), vec![false; tree.len()]);
    for (part, told) in tree.parts().iter().enumerate() {
        let Some(up) = told.parent.filter(|_| !told.joints.is_empty()) else { continue };
        let (winner, loser) = side.of(part, up);
        let all = |of: usize| pieces.iter().filter(move |p| p.part == of);
        let own = Bounds::of(all(part).flat_map(|p| [p.bounds.min, p.bounds.max])).diagonal();
        let Some(main) = all(loser).map(|p| p.area).reduce(f64::max) else { continue };
        let gap = |piece: &Piece| {
            all(winner).map(|p| gap(&p.bounds, &piece.bounds)).fold(f64::INFINITY, f64::min)
        };
        let astray = all(loser)
            .filter(|p| p.area < main && p.bounds.diagonal() < AS_LARGE * own)
            .filter(|p| p.faces.iter().all(|&f| usize::from(labels[f]) == loser))
            .map(|p| (gap(p), p))
            .filter(|(gap, _)| *gap < near)
            .min_by(|(a, p), (b, q)| a.total_cmp(b).then(q.area.total_cmp(&p.area)));
        if let Some((_, piece)) = astray {
            piece.faces.iter().for_each(|&f| labels[f] = winner as u16);
            is_changed[part] = true;
        }
    }
    (labels, is_changed)
}

fn pieces(from: &Labelled) -> Vec<Piece> {
    let (component, _) = from.weld.components();
    let mut faces: BTreeMap<(u32, u16), Vec<usize>> = BTreeMap::new();
    for (face, key) in component.into_iter().zip(from.part_of_face.iter().copied()).enumerate() {
        faces.entry(key).or_default().push(face);
    }
    let piece = |((_, part), faces): ((u32, u16), Vec<usize>)| Piece {
        part: usize::from(part),
        area: faces.iter().map(|&f| from.mesh.area(f)).sum(),
        bounds: Bounds::of(faces.iter().flat_map(|&f| from.mesh.corners(f))),
        faces,
    };
    faces.into_iter().map(piece).collect()
}

/// How far apart two boxes lie.
fn gap(a: &Bounds, b: &Bounds) -> f64 {
    (a.min - b.max).max(b.min - a.max).max(DVec3::ZERO).length()
}
