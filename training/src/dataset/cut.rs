//! Objects whose bodies come in several pieces, as those do that were cut up for collision, or drawn
//! shell by shell.

use object::articulated::ObjectError;
use object::mesh::MeshError;
use object::weld::Weld;
use object::{ArticulatedObject, DVec3, Mesh};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// A body is cut with this chance, where an object has few.
const CHANCE: f64 = 0.5;
/// How many bodies are cut on average where an object has many.
const BODIES: f64 = 30.0;
/// Most cuts through one body.
const CUTS: usize = 3;
/// Half the gap that a cut leaves, share of the object's diagonal: more than what is welded.
const GAP: f64 = 4e-6;

/// Why what is left is no object.
#[derive(Debug, thiserror::Error)]
pub enum CutError {
    /// Its surface.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Its parts.
    #[error(transparent)]
    Object(#[from] ObjectError),
}

/// A face by its corners, and its part.
type Piece = Vec<([DVec3; 3], u16)>;

/// The object with half of its bodies cut by planes, or, if it has many, some: each piece is a body of
/// its own, closed where it was and its section is round enough, and left open in every other object.
///
/// # Errors
/// [`CutError`] where what is left is no object.
pub fn cut_up(
    object: &ArticulatedObject,
    dice: &mut Pcg64Mcg,
) -> Result<ArticulatedObject, CutError> {
    let mesh = object.mesh();
    let (component, count) = Weld::new(mesh).components();
    let mut bodies: Vec<Piece> = vec![Vec::new(); count];
    for (face, (&c, &part)) in component.iter().zip(object.part_of_face()).enumerate() {
        bodies[c as usize].push((mesh.corners(face), part));
    }
    let chance = CHANCE.min(BODIES / count as f64);
    let gap = GAP * mesh.bounds().diagonal();
    let is_capped = dice.random::<bool>();
    let mut faces = Piece::new();
    for body in bodies {
        let mut pieces = vec![body];
        if dice.random::<f64>() < chance {
            for _ in 0..dice.random_range(1..=CUTS) {
                let piece = pieces.swap_remove(dice.random_range(0..pieces.len()));
                let plane = plane(&piece, dice);
                pieces.extend(halves(piece, plane, gap, is_capped));
            }
        }
        faces.extend(pieces.into_iter().flatten());
    }
    let (corners, labels): (Vec<_>, Vec<_>) = faces.into_iter().unzip();
    let cut = Mesh::of_triangles(&corners)?.with_frame(mesh.frame());
    Ok(object.with_surface(cut, labels)?)
}

/// A plane through a piece: its normal, along an axis as often as not, and how far along that it lies.
fn plane(piece: &Piece, dice: &mut Pcg64Mcg) -> (DVec3, f64) {
    let mut any = || piece[dice.random_range(0..piece.len())].0[dice.random_range(0..3)];
    let through = (any() + any() + any()) / 3.0;
    let normal = if dice.random::<bool>() {
        DVec3::AXES[dice.random_range(0..3)]
    } else {
        let tilt = DVec3::from_array([(); 3].map(|()| dice.random_range(-1.0..1.0)));
        tilt.try_normalize().unwrap_or(DVec3::Z)
    };
    (normal, normal.dot(through))
}

/// The piece on both sides of a plane, or as it was where one side is empty, or a corner lies in the gap.
fn halves(piece: Piece, (normal, at): (DVec3, f64), gap: f64, is_capped: bool) -> Vec<Piece> {
    let beyond = |corner: &DVec3| normal.dot(*corner) - at;
    if piece.iter().flat_map(|f| &f.0).any(|corner| beyond(corner).abs() < 2.0 * gap) {
        return vec![piece];
    }
    let high = half(&piece, (normal, at + gap), is_capped);
    let low = half(&piece, (-normal, gap - at), is_capped);
    if high.is_empty() || low.is_empty() { vec![piece] } else { vec![high, low] }
}

/// What of a piece lies beyond a plane.
fn half(piece: &Piece, (normal, at): (DVec3, f64), is_capped: bool) -> Piece {
    let (mut kept, mut rim) = (Piece::new(), Vec::new());
    for &(corners, part) in piece {
        let beyond = corners.map(|c| normal.dot(c) - at);
        let (mut outline, mut leaves, mut enters) = (Vec::new(), None, None);
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let (from, to) = (beyond[k], beyond[(k + 1) % 3]);
            if from >= 0.0 {
                outline.push(a);
            }
            if (from >= 0.0) != (to >= 0.0) {
                let met = a + (b - a) * (from / (from - to));
                outline.push(met);
                *if from >= 0.0 { &mut leaves } else { &mut enters } = Some(met);
            }
        }
        for k in 1..outline.len().saturating_sub(1) {
            kept.push(([outline[0], outline[k], outline[k + 1]], part));
        }
        rim.extend(enters.zip(leaves).map(|edge| (edge, part)));
    }
    if is_capped {
        kept.extend(cap(&rim, -normal));
    }
    kept
}

/// Faces that close a rim which goes round its middle one way; none for others.
fn cap(rim: &[((DVec3, DVec3), u16)], outward: DVec3) -> Piece {
    let middle =
        rim.iter().map(|(edge, _)| edge.0 + edge.1).sum::<DVec3>() / (2 * rim.len()).max(1) as f64;
    let goes_round =
        |&((a, b), _): &((DVec3, DVec3), u16)| (a - middle).cross(b - middle).dot(outward) >= 0.0;
    if !rim.iter().all(goes_round) {
        return Piece::new();
    }
    rim.iter().map(|&((a, b), part)| ([a, b, middle], part)).collect()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;
    use crate::procedural::FAMILIES;

    fn cabinet() -> ArticulatedObject {
        FAMILIES.iter().find(|f| f.name == "cabinet").unwrap().make().unwrap().object
    }

    fn area(object: &ArticulatedObject, part: usize) -> f64 {
        object.faces_of(part).map(|f| object.mesh().area(f)).sum()
    }

    #[test]
    fn what_is_cut_up_is_of_more_bodies_each_of_one_part() {
        let whole = cabinet();
        let bodies = |object: &ArticulatedObject| {
            let (component, count) = Weld::new(object.mesh()).components();
            let mut parts = vec![std::collections::BTreeSet::new(); count];
            for (&c, &part) in component.iter().zip(object.part_of_face()) {
                parts[c as usize].insert(part);
            }
            parts
        };
        let (mut more, mut closed) = (0, 0);
        for seed in 0..6 {
            let cut = cut_up(&whole, &mut Pcg64Mcg::seed_from_u64(seed)).unwrap();
            let found = bodies(&cut);
            more += usize::from(found.len() > bodies(&whole).len());
            assert!(found.iter().all(|parts| parts.len() == 1), "{found:?}");
            for part in 0..whole.tree().len() {
                assert!(area(&cut, part) > 0.999 * area(&whole, part), "nothing of it is lost");
            }
            let off = cut.mesh().signed_volume() - whole.mesh().signed_volume();
            closed += usize::from(off.abs() < 1e-3 * whole.mesh().signed_volume());
        }
        assert!(more >= 5 && closed >= 2, "{more} {closed}");
    }

    #[test]
    fn both_halves_of_a_box_are_closed() {
        // Each side of a unit cube about the origin, by its middle and two ways along it.
        let sides = DVec3::AXES.into_iter().flat_map(|n| [n, -n]).flat_map(|n| {
            let (u, v) = n.abs().any_orthonormal_pair();
            let v = v * u.cross(v).dot(n);
            let at = |x: f64, y: f64| (n + u * x + v * y) / 2.0;
            let [a, b, c, d] = [at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)];
            [[a, b, c], [a, c, d]]
        });
        let piece: Piece = sides.map(|corners| (corners, 0)).collect();
        let halves = halves(piece, (DVec3::new(0.6, 0.0, 0.8), 0.15), 1e-6, true);
        assert_eq!(halves.len(), 2);
        let volume = |piece: &Piece| {
            piece.iter().map(|([a, b, c], _)| a.dot(b.cross(*c)) / 6.0).sum::<f64>()
        };
        let [high, low] = [volume(&halves[0]), volume(&halves[1])];
        assert!(high > 0.2 && low > high && (high + low - 1.0).abs() < 1e-4, "{high} {low}");
    }
}
