//! What a person says of a joint stands in the asset as it was said, and nothing amends it.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]

mod cabinet;

use asset::{Amendment, Asset, BuildOptions, Motion, build};
use cabinet::{BODY, DOOR, DRAWER, MAP, cabinet};
use object::condition::GivenJoint;
use object::{Condition, DVec3, Origin, Range, Sourced};

const DOOR_AXIS: DVec3 = DVec3::new(0.01, -0.02, -1.0);
const DOOR_PIVOT: DVec3 = DVec3::new(1.003, 0.981, 1.37);

/// The cabinet with a door that is said to go through the body, and a drawer that is shown drawn out.
fn condition() -> Condition {
    let mut condition = cabinet::condition();
    let door = GivenJoint {
        axis: Some(DOOR_AXIS.normalize()),
        pivot: Some(DOOR_PIVOT),
        range: Some(Range::Limits { lower: -0.7, upper: 2.75 }),
        effort: Some(7.5),
        damping: Some(0.25),
        ..GivenJoint::default()
    };
    condition.prompts[DOOR].joints = vec![door];
    let drawer = GivenJoint { open_by: Some(0.15), ..GivenJoint::default() };
    condition.prompts[DRAWER].joints = vec![drawer];
    condition
}

fn built() -> Asset {
    build(&cabinet(), &condition(), &MAP, &BuildOptions::default()).unwrap()
}

fn motion<'a>(asset: &'a Asset, joint: &str) -> &'a Motion {
    asset.joints.iter().find(|j| j.name == joint).and_then(|j| j.motion.as_ref()).unwrap()
}

fn is_said<T: PartialEq + std::fmt::Debug>(number: &Sourced<T>, value: T) {
    assert_eq!((&number.value, number.origin), (&value, Origin::User), "{}", number.how);
}

#[test]
fn axis_pivot_range_and_drive_are_exported_as_given_although_the_range_is_blocked() {
    let asset = built();
    let door = motion(&asset, "door_turn");
    is_said(&door.axis, DOOR_AXIS.normalize());
    let [lower, upper] = door.limits.as_ref().unwrap();
    is_said(lower, -0.7);
    is_said(upper, 2.75);
    is_said(&door.effort, 7.5);
    is_said(&door.damping, 0.25);
    let joint = asset.joints.iter().find(|j| j.name == "door_turn").unwrap();
    let there = asset.links[joint.child].frame;
    let said = DOOR_PIVOT * asset.scale.value + asset.offset;
    assert!((there - said).length() < 1e-12, "{there} {said}");
    assert_eq!(joint.origin.origin, Origin::User);
    assert_eq!(asset.links[joint.parent].part, BODY);
    assert!(
        asset.changes.iter().all(|c| c.part != "door" || c.what == "collision"),
        "{:?}",
        asset.changes
    );
}

#[test]
fn how_far_a_slide_is_shown_open_is_its_lower_end_and_no_more() {
    let asset = built();
    let [lower, upper] = motion(&asset, "drawer_slide").limits.as_ref().unwrap();
    is_said(lower, -0.15);
    assert_ne!(upper.origin, Origin::User, "nobody said how much farther it goes");
}

#[test]
fn a_verdict_amends_nothing_that_was_given() {
    let asset = built();
    let amended = |joint, amendment| asset.amended(joint, amendment, ["", ""], "C2");
    assert!(amended("door_turn", Amendment::Range([0.0, 1.0])).is_none());
    assert!(amended("door_turn", Amendment::Flip).is_none());
    assert!(amended("drawer_slide", Amendment::Flip).is_none(), "which way it is open was said");
    let upper = motion(&asset, "drawer_slide").limits.as_ref().unwrap()[1].value;
    assert!(amended("drawer_slide", Amendment::Range([-0.1, upper])).is_none());
    let cut = amended("drawer_slide", Amendment::Range([-0.15, upper / 2.0])).unwrap();
    let [lower, upper] = motion(&cut, "drawer_slide").limits.as_ref().unwrap();
    is_said(lower, -0.15);
    assert_eq!(upper.origin, Origin::Measured);
    let firmer = asset.firmer(2.0, ["", ""], "S2");
    is_said(&motion(&firmer, "door_turn").effort, 7.5);
}
