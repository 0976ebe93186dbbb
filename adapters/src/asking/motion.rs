//! How an object's parts move, in words for a model.

use object::articulated::JointMotion;
use object::mesh::Bounds;
use object::{ArticulatedObject, DVec3, Range};

/// A component of a direction below this goes unmentioned.
const SLIGHT: f64 = 0.35;

/// A part's id in a question.
pub(super) fn id(part: usize) -> String {
    format!("p{part}")
}

/// A line for each part that moves.
pub(super) fn lines(object: &ArticulatedObject) -> String {
    let (tree, bounds) = (object.tree(), object.mesh().bounds());
    let name = |n: usize| {
        let part = &tree.parts()[n];
        if part.text.is_empty() { part.name.as_str() } else { part.text.as_str() }
    };
    let line = |n: usize| {
        let on = tree.parent(n).map(|p| format!(", on {:?}", name(p))).unwrap_or_default();
        let own: Vec<_> = object.joints(n).iter().map(|m| one(m, &bounds)).collect();
        format!("- {} ({:?}{on}): {}", id(n), name(n), own.join("; and "))
    };
    let moving = (0..tree.len()).filter(|n| !object.joints(*n).is_empty());
    moving.map(line).collect::<Vec<_>>().join("\n")
}

fn one(motion: &JointMotion, bounds: &Bounds) -> String {
    let along = direction(motion.axis);
    if !motion.kind.turns() {
        let (lower, upper) = motion.range.ends();
        let largest = bounds.size().max_element();
        let [lower, upper] = [lower, upper].map(|q| percent(q, largest));
        return format!(
            "slides along {along}, from {lower} to {upper} of the object's largest extent"
        );
    }
    let [right, back, up] = [DVec3::X, DVec3::Y, DVec3::Z]
        .map(|axis| percent((motion.pivot - bounds.min).dot(axis), bounds.size().dot(axis)));
    let place =
        format!("a point {right} from the left, {back} from the front and {up} from the bottom");
    let range = match motion.range {
        Range::Continuous => "without end (the pictures show a quarter turn each way)".to_owned(),
        Range::Limits { lower, upper } => {
            let [lower, upper] = [lower, upper].map(|q| q.to_degrees().round() + 0.0);
            format!("from {lower} to {upper} degrees")
        }
    };
    format!("turns about an axis along {along} through {place} of the object, {range}")
}

/// `right and up (0.71, 0.00, 0.71)`: components to the right, to the back and up.
fn direction(axis: DVec3) -> String {
    let words = [("right", "left"), ("back", "front"), ("up", "down")];
    let named = words.iter().zip(axis.to_array()).filter(|(_, c)| c.abs() > SLIGHT);
    let named: Vec<_> =
        named.map(|((plus, minus), c)| if c > 0.0 { *plus } else { *minus }).collect();
    let [x, y, z] = axis.to_array().map(|c| (c * 100.0).round() / 100.0 + 0.0);
    format!("{} ({x:.2} right, {y:.2} back, {z:.2} up)", named.join(" and "))
}

fn percent(value: f64, of: f64) -> String {
    let share = if of > 0.0 { value / of * 100.0 } else { 0.0 };
    format!("{:.0} %", share.round() + 0.0)
}

#[cfg(test)]
mod tests {
    use object::JointKind;

    use super::*;

    const BOX: Bounds = Bounds { min: DVec3::new(-1.0, -2.0, 0.0), max: DVec3::new(1.0, 2.0, 5.0) };

    fn motion(kind: JointKind, axis: DVec3, range: Range) -> JointMotion {
        JointMotion { kind, axis, pivot: DVec3::new(-1.0, 0.0, 2.5), range }
    }

    #[test]
    fn a_hinge_is_told_with_its_axis_its_place_and_its_range_in_degrees() {
        let range = Range::Limits { lower: -1e-9, upper: std::f64::consts::FRAC_PI_2 };
        let told = one(&motion(JointKind::Revolute, -DVec3::Z, range), &BOX);
        let expected = "turns about an axis along down (0.00 right, 0.00 back, -1.00 up) through a \
            point 0 % from the left, 50 % from the front and 50 % from the bottom of the object, \
            from 0 to 90 degrees";
        assert_eq!(told, expected);
        let told = one(&motion(JointKind::Continuous, DVec3::X, Range::Continuous), &BOX);
        assert!(told.contains("along right (1.00 right") && told.contains("without end"), "{told}");
    }

    #[test]
    fn a_slide_is_told_as_a_share_of_the_largest_extent() {
        let range = Range::Limits { lower: -0.5, upper: 2.0 };
        let axis = DVec3::new(0.0, -0.8, 0.6);
        let told = one(&motion(JointKind::Prismatic, axis, range), &BOX);
        assert!(told.starts_with("slides along front and up (0.00 right, -0.80 back"), "{told}");
        assert!(told.contains("from -10 % to 40 % of"), "{told}");
    }

    #[test]
    fn what_has_no_extent_is_told_without_a_division_by_it() {
        let flat = Bounds { min: DVec3::ZERO, max: DVec3::ZERO };
        let range = Range::Limits { lower: 0.0, upper: 1.0 };
        let told = one(&motion(JointKind::Prismatic, DVec3::Y, range), &flat);
        assert!(told.contains("from 0 % to 0 %"), "{told}");
    }
}
