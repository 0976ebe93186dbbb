//! Parts of one kind on one parent, and what an answer about one of them says of another.

use object::confidence::OtherAxis;
use object::{ArticulatedObject, DVec3, JointMotion, Range};

use crate::classic::lexicon::words::are_alike;

/// A part whose middle is nearer its axis than this goes to no side: a share of the object's diagonal, a guess.
const STILL: f64 = 0.01;
/// Directions are alike within 14°, as where siblings vote on axes.
const ALIKE: f64 = 0.97;
/// Two parts set off to one side if their headings lie within 45°; a guess.
const ONE_SIDE: f64 = 0.7;
/// A range that goes this many times as far to one side as to the other opens to that side; a guess.
const ONE_WAY: f64 = 9.0;

/// The other parts of a part's kind on its parent, with joints as it has them, in order.
pub(super) fn siblings(object: &ArticulatedObject, part: usize) -> Vec<usize> {
    let parts = object.tree().parts();
    let own = &parts[part];
    let is_one = |other: &usize| {
        let other_part = &parts[*other];
        *other != part
            && own.parent.is_some()
            && other_part.parent == own.parent
            && other_part.joints == own.joints
            && are_alike(&own.text, &other_part.text)
    };
    (0..parts.len()).filter(is_one).collect()
}

/// The way the middle of a part's surface sets off where its joint goes ahead, in the mesh's frame and of any
/// length; none where it hardly does.
pub fn heading(object: &ArticulatedObject, part: usize, motion: &JointMotion) -> Option<DVec3> {
    if !motion.kind.turns() {
        return Some(motion.axis);
    }
    let mesh = object.mesh();
    let (mut sum, mut area) = (DVec3::ZERO, 0.0);
    for face in object.faces_of(part) {
        sum += mesh.centroid(face) * mesh.area(face);
        area += mesh.area(face);
    }
    let way = motion.axis.cross(sum / area - motion.pivot);
    (way.length() > STILL * mesh.bounds().diagonal()).then_some(way)
}

/// The ways that a joint may open, as ranges: ahead, back, both. The way it opens already keeps its range.
pub(super) fn openings(range: Range) -> Option<[Range; 3]> {
    let Range::Limits { lower, upper } = range else { return None };
    let far = upper.max(-lower);
    let found = [far / ONE_WAY < upper, far / ONE_WAY < -lower];
    let ways =
        [([true, false], [0.0, far]), ([false, true], [-far, 0.0]), ([true; 2], [-far, far])];
    let one = |(way, [lower, upper]): ([bool; 2], [f64; 2])| {
        if way == found { range } else { Range::Limits { lower, upper } }
    };
    Some(ways.map(one))
}

/// How a sibling opens where a part opens by a range, both with their joints: to the same side, or both ways as
/// well; none where their sides cannot be compared.
pub(super) fn opened(
    object: &ArticulatedObject,
    [(part, own), (sibling, other)]: [(usize, JointMotion); 2],
    range: Range,
) -> Option<Range> {
    let [ahead, back, both] = openings(other.range)?;
    let (lower, upper) = range.ends();
    let sign = match (lower < 0.0, upper > 0.0) {
        (true, true) => return Some(both),
        (false, _) => 1.0,
        (true, false) => -1.0,
    };
    let along = match (heading(object, part, &own), heading(object, sibling, &other)) {
        (Some(a), Some(b)) => a.normalize_or_zero().dot(b.normalize_or_zero()) / ONE_SIDE,
        (None, None) => own.axis.dot(other.axis) / ALIKE,
        _ => return None,
    };
    (along.abs() >= 1.0).then_some(if along * sign > 0.0 { ahead } else { back })
}

/// The joint of a sibling where a part's joint, found so, has that line: the one of the sibling's two likeliest
/// that goes the same way. Doors hang on either side, so nothing is heard of a line that only moves to another.
pub(super) fn like(
    (found, (axis, pivot)): (JointMotion, (DVec3, DVec3)),
    sibling: JointMotion,
    instead: Option<OtherAxis>,
) -> Option<JointMotion> {
    let is_alike = |other: DVec3| axis.dot(other).abs() > ALIKE;
    let is_moved = is_alike(found.axis) && found.pivot != pivot;
    match instead {
        _ if is_moved => None,
        _ if is_alike(sibling.axis) => Some(sibling),
        Some(other) if is_alike(other.axis) => {
            Some(JointMotion { axis: other.axis, pivot: other.pivot, ..sibling })
        }
        _ => None,
    }
}
