//! Labels that are wrong as found ones are wrong about hinges: all that is thin and round about a joint's
//! line is of the part, or all of it is of what the part hangs on.

use model::classic::joints::Labelled;
use model::classic::joints::pins::rings;
use model::classic::joints::scene::Scene;
use object::{DVec3, JointMotion};

/// At how many places along the line one looks for knuckles.
const PLACES: usize = 48;
/// At how many of them there must be something round.
const ROUND: usize = 4;
/// What is this many radii from the line, and this share of the diagonal, goes with the knuckle.
const ABOUT: (f64, f64) = (1.25, 0.002);
/// More than this share of its faces nobody loses at one hinge.
const LOST: f64 = 0.3;

/// Who gets all of a hinge.
#[derive(Clone, Copy, Debug)]
pub(super) enum Side {
    /// The part that turns.
    Part,
    /// What it hangs on.
    Parent,
}

/// Of each part, the faces of it and of what it hangs on that lie about the line of its turn, where there
/// is something thin and round.
pub(super) fn hinges(
    (from, scene): (&Labelled, &Scene),
    truth: &[&[JointMotion]],
) -> Vec<Vec<usize>> {
    let of = |(part, joints): (usize, &&[JointMotion])| {
        let turn = joints.iter().find(|j| j.kind.turns())?;
        Some(hinge((from, scene), [part, from.tree.parent(part)?], turn))
    };
    truth.iter().enumerate().map(|joints| of(joints).unwrap_or_default()).collect()
}

/// The part of each face once every hinge is of one side, and of which parts that changes the hinge.
pub(super) fn given(from: &Labelled, hinges: &[Vec<usize>], side: Side) -> (Vec<u16>, Vec<bool>) {
    let part_of = |f: usize| usize::from(from.part_of_face[f]);
    let (mut labels, mut is_changed) = (from.part_of_face.to_vec(), vec![false; hinges.len()]);
    for (part, hinge) in hinges.iter().enumerate() {
        let Some(up) = from.tree.parent(part) else { continue };
        let (winner, loser) = match side {
            Side::Part => (part, up),
            Side::Parent => (up, part),
        };
        let faces: Vec<usize> = hinge.iter().copied().filter(|&f| part_of(f) == loser).collect();
        let all = (0..labels.len()).filter(|&f| part_of(f) == loser).count();
        if !faces.is_empty() && (faces.len() as f64) < LOST * all as f64 {
            faces.into_iter().for_each(|f| labels[f] = winner as u16);
            is_changed[part] = true;
        }
    }
    (labels, is_changed)
}

/// The faces of a part and of what it hangs on that lie about the line of its turn.
fn hinge((from, scene): (&Labelled, &Scene), sides: [usize; 2], turn: &JointMotion) -> Vec<usize> {
    let d = turn.axis.normalize_or_zero();
    let inside = |x: DVec3| (x - scene.origin) / scene.unit;
    let pivot = inside(turn.pivot);
    let (low, high) = scene.bodies[sides[0]].extent(d);
    let step = (high - low) / PLACES as f64;
    let radius = |i: usize| {
        let along = low + (i as f64 + 0.5) * step;
        let rings = rings(scene, pivot + d * (along - d.dot(pivot)), d);
        rings.iter().map(|r| r.radius).reduce(f64::max)
    };
    let radii: Vec<Option<f64>> = (0..PLACES).map(radius).collect();
    if radii.iter().flatten().count() < ROUND {
        return Vec::new();
    }
    let is_about = |&f: &usize| {
        let x = inside(from.mesh.centroid(f));
        let place = ((x.dot(d) - low) / step).floor();
        let off = (x - pivot).reject_from_normalized(d).length();
        let near = radii.iter().enumerate().filter(|(i, _)| (*i as f64 - place).abs() < 1.5);
        near.filter_map(|(_, r)| *r).any(|r| off < ABOUT.0 * r + ABOUT.1)
    };
    let own = |&f: &usize| sides.contains(&usize::from(from.part_of_face[f]));
    (0..from.part_of_face.len()).filter(own).filter(is_about).collect()
}
