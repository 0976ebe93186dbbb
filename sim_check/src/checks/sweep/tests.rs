//! Group C against closed forms and the corpus of one-defect files.

use std::path::PathBuf;

use crate::CheckOptions;
use crate::checks::kinematic;
use crate::read::load;
use crate::robot::Robot;
use crate::verdict::{Check, Status};

/// A URDF in words: boxes as links, joints between them.
pub(crate) fn robot(body: &str) -> Robot {
    let text = format!("<robot name=\"r\">{body}</robot>");
    let loaded = load::from_text(&text, &std::env::temp_dir(), &CheckOptions::default());
    loaded.robot.unwrap_or_else(|| panic!("{:?}", loaded.checks))
}

/// A link of one box of 1 kg, with the right inertia.
pub(crate) fn link(name: &str, at: [f64; 3], size: [f64; 3]) -> String {
    weighing(1.0, name, at, size)
}

/// The same of so many kilograms.
pub(crate) fn weighing(mass: f64, name: &str, at: [f64; 3], size: [f64; 3]) -> String {
    let origin = format!("<origin xyz=\"{} {} {}\"/>", at[0], at[1], at[2]);
    let geometry =
        format!("{origin}<geometry><box size=\"{} {} {}\"/></geometry>", size[0], size[1], size[2]);
    let [x, y, z] = size.map(|s| mass * s * s / 12.0);
    format!(
        "<link name=\"{name}\"><inertial>{origin}<mass value=\"{mass}\"/><inertia ixx=\"{}\" \
         iyy=\"{}\" izz=\"{}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>\
         <visual>{geometry}</visual><collision>{geometry}</collision></link>",
        y + z,
        x + z,
        x + y
    )
}

/// A joint `child_joint` from `parent`: kind, place, axis, lower and upper.
pub(crate) fn joint(
    (kind, parent, child): (&str, &str, &str),
    at: [f64; 3],
    axis: [f64; 3],
    [lower, upper]: [f64; 2],
) -> String {
    format!(
        "<joint name=\"{child}_joint\" type=\"{kind}\"><origin xyz=\"{} {} {}\"/>\
         <parent link=\"{parent}\"/><child link=\"{child}\"/><axis xyz=\"{} {} {}\"/>\
         <limit lower=\"{lower}\" upper=\"{upper}\" effort=\"10\" velocity=\"1\"/></joint>",
        at[0], at[1], at[2], axis[0], axis[1], axis[2]
    )
}

pub(crate) fn defects() -> Option<PathBuf> {
    let fallback = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared");
    let shared = std::env::var("KINFOLD_SHARED").unwrap_or_else(|_| fallback.into());
    let folder = PathBuf::from(shared).join("data/defects");
    if !folder.is_dir() {
        eprintln!("SKIPPED: no {} (set KINFOLD_SHARED)", folder.display());
        return None;
    }
    Some(folder)
}

fn check(robot: &Robot, id: &str) -> Check {
    let checks = kinematic::checks(robot, &CheckOptions::default());
    checks.into_iter().find(|c| c.id == id).unwrap()
}

fn status(robot: &Robot, id: &str) -> Status {
    check(robot, id).status
}

#[test]
fn two_boxes_ten_millimetres_into_each_other_fail_at_rest() {
    let slide = joint(("prismatic", "a", "b"), [0.99, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.2]);
    let a = link("a", [0.0; 3], [1.0; 3]);
    let r = robot(&(a + &link("b", [0.0, 0.3, 0.2], [1.0; 3]) + &slide));
    let c1 = check(&r, "C1");
    assert_eq!(c1.status, Status::Fail);
    assert!((c1.value.unwrap() - 10.0).abs() < 1e-9, "{c1:?}");
    assert!(c1.evidence[0].contains("`a` and `b` overlap by 10.00 mm"), "{c1:?}");
}

/// A thin door hinged at the origin along z, 1 m long in y, and a wall of the base it meets after
/// turning by `angle` radians about z.
fn door_and_wall(angle: f64, upper: f64) -> Robot {
    let base = link("base", [0.0, -0.6, 0.0], [0.2, 1.0, 1.0]);
    let wall = link("wall", [0.0; 3], [0.02; 3]);
    let at = [-angle.sin() * 0.9, angle.cos() * 0.9, 0.0];
    let fixed = joint(("fixed", "base", "wall"), at, [1.0, 0.0, 0.0], [0.0; 2]);
    let door = link("door", [0.0, 0.5, 0.0], [0.002, 0.98, 0.5]);
    let hinge = joint(("revolute", "base", "door"), [0.0; 3], [0.0, 0.0, 1.0], [0.0, upper]);
    robot(&(base + &wall + &door + &fixed + &hinge))
}

#[test]
fn a_door_that_swings_into_a_wall_is_caught_where_it_happens() {
    let hits = door_and_wall(1.0, 1.2);
    let c2 = check(&hits, "C2");
    assert_eq!(c2.status, Status::Fail);
    let through = 10.0 * (1f64.sin() + 1f64.cos()) + 1.0;
    assert!((c2.value.unwrap() - through).abs() < 0.5, "half the wall and half the door: {c2:?}");
    assert!(c2.evidence[0].contains("at 57.") || c2.evidence[0].contains("at 58."), "{c2:?}");
    assert_eq!(status(&hits, "C1"), Status::Pass);
    let stops_before = door_and_wall(1.0, 0.95);
    assert_eq!(status(&stops_before, "C2"), Status::Pass);
    let c5 = check(&stops_before, "C5");
    assert_eq!((c5.status, c5.value), (Status::Pass, Some(1.0)), "free all the way: {c5:?}");
    // The wall is met after 0.99 of 1.2 rad: late, so that the way it opens is not in question.
    let c5 = check(&hits, "C5");
    assert_eq!((c5.status, c5.value), (Status::Pass, Some(1.0)), "{c5:?}");
}

#[test]
fn a_door_that_opens_to_its_wall_is_measured_against_the_free_side() {
    let inward = door_and_wall(0.3, 1.2);
    let c5 = check(&inward, "C5");
    assert_eq!(c5.status, Status::Fail);
    let times = c5.value.unwrap();
    assert!((times - 1.2 / 0.29).abs() < 0.3, "free for 1.2 rad, met after 0.29: {c5:?}");
}

#[test]
fn what_can_meet_nothing_does_not_open_to_the_free_side() {
    let base = link("base", [0.0; 3], [0.4, 0.5, 0.1]);
    let bare = r#"<link name="door"><inertial><mass value="1"/>
        <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>"#;
    let hinge = joint(("revolute", "base", "door"), [0.0; 3], [0.0, 0.0, 1.0], [0.0, 1.0]);
    let c5 = check(&robot(&(base + bare + &hinge)), "C5");
    assert_eq!((c5.status, c5.value), (Status::Unknown, None), "{c5:?}");
}

#[test]
fn what_goes_both_ways_alike_opens_no_way() {
    let base = link("base", [0.0, -0.6, 0.0], [0.2, 1.0, 1.0]);
    let door = link("door", [0.0, 0.5, 0.0], [0.002, 0.98, 0.5]);
    let hinge = joint(("revolute", "base", "door"), [0.0; 3], [0.0, 0.0, 1.0], [-0.4, 0.4]);
    let c5 = check(&robot(&(base + &door + &hinge)), "C5");
    assert_eq!((c5.status, c5.value), (Status::Pass, None), "{c5:?}");
}

#[test]
fn a_sweep_stops_within_half_a_step_of_the_true_contact() {
    let r = door_and_wall(1.0, 1.2);
    let scene = super::Scene::new(&r).unwrap();
    let side = super::advance::sweep(&scene, 0, 1.2).unwrap();
    let hit = side.first_hit.unwrap();
    // The bound is 0.2 % of the diagonal; the wall's corner stands 10 mm before its centre.
    assert!(hit > 0.985 && hit < 1.0, "{hit}");
}

#[test]
fn a_drawer_that_leaves_its_cabinet_is_not_attached() {
    let cabinet = |travel: f64| {
        let base = link("base", [0.0, 0.0, -0.06], [0.4, 0.5, 0.1]);
        let drawer = link("drawer", [0.0; 3], [0.3, 0.48, 0.01]);
        let slide =
            joint(("prismatic", "base", "drawer"), [0.0; 3], [0.0, -1.0, 0.0], [0.0, travel]);
        robot(&(base + &drawer + &slide))
    };
    assert_eq!(status(&cabinet(0.4), "C4"), Status::Pass);
    assert_eq!(status(&cabinet(0.55), "C4"), Status::Fail);
}

#[test]
fn a_button_on_a_face_may_be_pressed_in() {
    let base = link("base", [0.0, 0.0, -0.1], [0.4, 0.5, 0.1]);
    let button = link("button", [0.0, 0.0, 0.015], [0.02, 0.02, 0.02]);
    let press = joint(("prismatic", "base", "button"), [0.0; 3], [0.0, 0.0, 1.0], [-0.05, 0.0]);
    assert_eq!(status(&robot(&(base + &button + &press)), "C4"), Status::Pass);
}

#[test]
fn a_hinge_far_from_the_part_it_carries_swings_it_away() {
    let base = link("base", [0.0; 3], [0.2, 1.0, 1.0]);
    let flap = link("flap", [-0.5, 0.0, 0.0], [0.1, 0.9, 0.9]);
    let at = [0.62, 0.0, 0.0];
    let hinge = joint(("revolute", "base", "flap"), at, [0.0, 0.0, 1.0], [-3.0, 0.0]);
    let c4 = check(&robot(&(base + &flap + &hinge)), "C4");
    assert_eq!(c4.status, Status::Fail, "{c4:?}");
}

/// Two flaps hinged 1 m apart, each 0.6 m long: alone they pass each other by, together they meet.
#[test]
fn two_flaps_that_meet_only_when_both_are_open_are_caught() {
    let base = link("base", [0.5, -0.1, 0.0], [1.4, 0.1, 0.1]);
    let flap = |name: &str, out: f64| link(name, [out, 0.0, 0.0], [0.58, 0.02, 0.1]);
    let hinge = |name, x: f64, range| {
        joint(("revolute", "base", name), [x, 0.0, 0.0], [0.0, 0.0, 1.0], range)
    };
    let left = flap("left", -0.31) + &hinge("left", 0.0, [-3.1, 0.0]);
    let right = flap("right", 0.31) + &hinge("right", 1.0, [0.0, 3.1]);
    let r = robot(&(base + &left + &right));
    assert_eq!(status(&r, "C2"), Status::Pass, "{:?}", check(&r, "C2"));
    let c3 = check(&r, "C3");
    assert_eq!(c3.status, Status::Fail);
    assert!(c3.evidence[0].contains("left_joint") && c3.evidence[0].contains("right_joint"));
}

#[test]
fn a_follower_moves_with_its_leader() {
    let base = link("base", [0.0; 3], [0.1; 3]);
    let slide = |name, mimic: &str| {
        joint(("prismatic", "base", name), [0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.3])
            .replace("</joint>", &format!("{mimic}</joint>"))
    };
    let left = link("left", [0.3, 0.0, 0.0], [0.1; 3]) + &slide("left", "");
    let mimic = "<mimic joint=\"left_joint\" multiplier=\"0.5\"/>";
    let right = link("right", [-0.3, 0.0, 0.0], [0.1; 3]) + &slide("right", mimic);
    let wall = link("wall", [-0.3, 0.2, 0.0], [0.1; 3]);
    let fixed = joint(("fixed", "base", "wall"), [0.0; 3], [1.0, 0.0, 0.0], [0.0; 2]);
    let r = robot(&(base + &left + &right + &wall + &fixed));
    let c2 = check(&r, "C2");
    assert!((c2.value.unwrap() - 50.0).abs() < 1e-6, "{c2:?}");
    let states = super::joint_sweep(&r, 24).unwrap();
    assert_eq!(states.len(), 24);
    assert!(states.iter().all(|q| (q[1] - 0.5 * q[0]).abs() < 1e-15));
    assert!(states.iter().any(|q| (q[0] - 0.3).abs() < 1e-12) && states[23] == vec![0.0; 3]);
}

#[test]
fn without_colliders_nothing_is_clean() {
    let bare = "<link name=\"a\"/><link name=\"b\"/>".to_owned();
    let hinge = joint(("revolute", "a", "b"), [0.0; 3], [0.0, 0.0, 1.0], [0.0, 1.0]);
    let checks = kinematic::checks(&robot(&(bare + &hinge)), &CheckOptions::default());
    assert_eq!(checks.len(), 5);
    assert!(checks.iter().all(|c| c.status == Status::Unknown), "{checks:?}");
}

#[test]
fn threads_and_runs_do_not_change_a_byte() {
    let r = door_and_wall(1.0, 1.2);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let checks = pool.install(|| kinematic::checks(&r, &CheckOptions::default()));
        serde_json::to_string(&checks).unwrap()
    };
    assert_eq!(run(1), run(2));
}

#[test]
fn the_corpus_is_caught_by_the_named_check() {
    let Some(folder) = defects() else { return };
    let read = |name: &str| {
        let path = folder.join(name);
        load::read(&path, &CheckOptions::default()).robot.unwrap()
    };
    let good = kinematic::checks(&read("00_good.urdf"), &CheckOptions::default());
    assert!(good.iter().all(|c| c.status == Status::Pass), "{good:?}");
    for (file, id, depth) in [
        ("15_links_overlap_at_rest.urdf", "C1", Some(89.0)),
        ("16_overlap_along_range_only.urdf", "C2", Some(285.0)),
        ("35_axis_sign_flipped_opens_inward.urdf", "C5", None),
        ("35_axis_sign_flipped_opens_inward.urdf", "C2", Some(285.0)),
    ] {
        let found = check(&read(file), id);
        assert_eq!(found.status, Status::Fail, "{file}: {found:?}");
        if let Some(depth) = depth {
            assert!((found.value.unwrap() - depth).abs() < 1.0, "{file}: {found:?}");
        }
    }
    let c1 = check(&read("16_overlap_along_range_only.urdf"), "C1");
    assert_eq!(c1.status, Status::Pass);
    let none = kinematic::checks(&read("24_no_collision_geometry.urdf"), &CheckOptions::default());
    assert!(none.iter().all(|c| c.status == Status::Unknown));
}
