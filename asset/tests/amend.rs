//! A finished asset amended as a verdict asks, each step on record.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]

mod cabinet;

use asset::{Amendment, Asset, Motion};
use cabinet::built;

fn motion<'a>(asset: &'a Asset, joint: &str) -> &'a Motion {
    asset.joints.iter().find(|j| j.name == joint).and_then(|j| j.motion.as_ref()).unwrap()
}

fn ends(asset: &Asset, joint: &str) -> [f64; 2] {
    motion(asset, joint).limits.as_ref().unwrap().each_ref().map(|end| end.value)
}

#[test]
fn a_range_is_cut_and_the_change_says_from_what_to_what() {
    let asset = built();
    let [lower, upper] = ends(&asset, "door_turn");
    let cut = asset.amended("door_turn", Amendment::Range([0.0, 0.5]), ["fails", "holds"], "C2");
    let cut = cut.unwrap();
    assert_eq!(ends(&cut, "door_turn"), [0.0, 0.5]);
    assert_eq!(cut.changes.len(), asset.changes.len() + 1);
    let told = cut.changes.last().unwrap();
    assert_eq!(
        (told.part.as_str(), told.what.as_str(), told.why.as_str()),
        ("door", "range", "C2")
    );
    assert_eq!(told.before, format!("{lower:.4} to {upper:.4} (verdict: fails)"));
    assert_eq!(told.after, "0.0000 to 0.5000 (verdict: holds)");
}

#[test]
fn an_axis_is_turned_round_and_its_range_kept() {
    let asset = built();
    let turned = asset.amended("door_turn", Amendment::Flip, ["", ""], "C5").unwrap();
    let [was, now] = [&asset, &turned].map(|a| motion(a, "door_turn").axis.value);
    assert_eq!(now, -was);
    assert_eq!(ends(&turned, "door_turn"), ends(&asset, "door_turn"));
    assert_eq!(turned.changes.last().unwrap().what, "axis");
}

#[test]
fn what_cannot_be_amended_is_not() {
    let asset = built();
    let amended = |joint, range| asset.amended(joint, Amendment::Range(range), ["", ""], "C2");
    assert!(amended("nobody", [0.0, 1.0]).is_none());
    assert!(amended("door_turn", [0.1, 1.0]).is_none(), "leaves out rest");
    assert!(amended("door_turn", [0.0, 0.0]).is_none(), "no range at all");
    assert!(amended("Drawer_cap_turn", [0.0, 1.0]).is_none(), "turns without limits");
}

#[test]
fn firmer_joints_get_friction_and_the_effort_it_takes() {
    let asset = built();
    let firmer = asset.firmer(2.0, ["opens", "holds"], "J7");
    let [was, now] = [&asset, &firmer].map(|a| motion(a, "door_turn"));
    let more = now.friction.value - was.friction.value;
    assert!((more - was.friction.value).abs() < 1e-12);
    assert!((now.effort.value - was.effort.value - 3.0 * more).abs() < 1e-9);
    assert!(now.friction.how.ends_with("; 2 times that: J7"), "{}", now.friction.how);
    assert_eq!(firmer.changes.last().unwrap().after, "2 times that (verdict: holds)");
}
