//! Group S and J7 against closed forms and the corpus of one-defect files.

use super::drop::{Drop, Energy, drift_bound};
use crate::CheckOptions;
use crate::checks::dynamics;
use crate::checks::sweep::Scene;
use crate::checks::sweep::tests::{defects, joint, link, robot, weighing};
use crate::profile::bounds::{TIPPED, radians};
use crate::read::load;
use crate::robot::Robot;
use crate::verdict::{Check, Status};

fn checks(robot: &Robot) -> Vec<Check> {
    dynamics::checks(robot, &CheckOptions::default(), true)
}

fn cabinet() -> Robot {
    let base = link("base", [0.0, 0.0, 0.3], [0.5, 0.4, 0.6]);
    let door = link("door", [0.2, -0.01, 0.0], [0.38, 0.02, 0.5]);
    let hinge =
        joint(("revolute", "base", "door"), [-0.2, -0.22, 0.3], [0.0, 0.0, -1.0], [0.0, 1.6]);
    let drawer = link("drawer", [0.0; 3], [0.3, 0.3, 0.1]);
    let slide =
        joint(("prismatic", "base", "drawer"), [0.0, 0.36, 0.3], [0.0, 1.0, 0.0], [0.0, 0.2]);
    let knob = link("knob", [0.0; 3], [0.05, 0.02, 0.05]);
    let turn =
        joint(("continuous", "door", "knob"), [0.3, -0.04, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0]);
    let all = base + &door + &drawer + &knob + &hinge + &slide + &turn;
    robot(&all.replace("</joint>", "<dynamics damping=\"0.05\" friction=\"0.2\"/></joint>"))
}

#[test]
fn a_good_cabinet_does_what_its_file_says() {
    let found = checks(&cabinet());
    assert_eq!(
        found.iter().map(|c| c.id.as_str()).collect::<Vec<_>>(),
        ["S1", "S2", "S3", "S4", "S5"]
    );
    assert!(found.iter().all(|c| c.status == Status::Pass), "{found:#?}");
}

#[test]
fn a_rod_swings_with_the_period_of_the_textbook() {
    let base = link("base", [0.0, 0.0, -0.7], [0.2, 0.2, 0.2]);
    let rod = link("rod", [0.5, 0.0, 0.0], [1.0, 1e-3, 1e-3]);
    let hinge = joint(("revolute", "base", "rod"), [0.0; 3], [0.0, 1.0, 0.0], [-1.0, 1.0]);
    let r = robot(&(base + &rod + &hinge));
    let scene = Scene::new(&r).unwrap();
    let swing = super::pendulum::swing(&scene, 0).unwrap();
    assert_eq!(swing.by, super::pendulum::Driver::Field);
    assert!(swing.error() < 0.002, "{swing:?}");
}

/// A disc on x of a few grams: the engine's own reading of such an inertia is wrong.
#[test]
fn a_small_wheel_turns_with_its_own_inertia_whatever_its_axis() {
    for axis in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
        let size = [0, 1, 2].map(|i| if axis[i] > 0.5 { 0.005 } else { 0.03 });
        let base = link("base", [0.0, 0.0, -0.7], [0.2, 0.2, 0.2]);
        let turn = joint(("continuous", "base", "wheel"), [0.0; 3], axis, [0.0; 2]);
        let r = robot(&(base + &link("wheel", [0.0; 3], size) + &turn));
        let scene = Scene::new(&r).unwrap();
        let swing = super::pendulum::swing(&scene, 0).unwrap();
        assert_eq!(swing.by, super::pendulum::Driver::Spring);
        assert!(swing.error() < 0.005, "{axis:?} {swing:?}");
    }
}

#[test]
fn a_first_look_at_a_drop_counts_far_within_the_bounds_only() {
    let cabinet = cabinet();
    let scene = Scene::new(&cabinet).unwrap();
    let (bound, energy) = (drift_bound(&scene), Energy { gain: 0.004, finite: true });
    let calm = Drop { settled: Some(0.3), drift: 0.2 * bound, tilt: 0.2 * radians(TIPPED), energy };
    assert!(calm.is_sure(&scene));
    for unsure in [
        Drop { settled: None, ..calm },
        Drop { drift: 0.3 * bound, ..calm },
        Drop { drift: f64::NAN, ..calm },
        Drop { tilt: 0.3 * radians(TIPPED), ..calm },
        Drop { energy: Energy { gain: 0.006, finite: true }, ..calm },
        Drop { energy: Energy { gain: 0.0, finite: false }, ..calm },
    ] {
        assert!(!unsure.is_sure(&scene), "{unsure:?}");
    }
}

/// The centre of mass stands 3 cm beside the middle of a round foot of 4.5 cm.
#[test]
fn a_top_heavy_tap_that_stands_is_not_thrown_over() {
    let foot = link("foot", [0.0, 0.0, 0.01], [0.09, 0.09, 0.02])
        .replace("<box size=\"0.09 0.09 0.02\"/>", "<cylinder radius=\"0.045\" length=\"0.02\"/>");
    let spout = link("spout", [0.0, -0.06, 0.12], [0.03, 0.18, 0.03]);
    let turn = joint(("revolute", "foot", "spout"), [0.0; 3], [0.0, 0.0, 1.0], [-1.5, 1.5]);
    let found = checks(&robot(&(foot + &spout + &turn)));
    assert_eq!(found[1].status, Status::Pass, "{found:#?}");
}

/// A lamp of two light arms and a heavy head, each joint held by twice what gravity asks for.
#[test]
fn friction_that_outweighs_gravity_keeps_a_heavy_head_on_light_arms_where_it_is() {
    let held = |of: String, friction: f64| {
        let dynamics = format!("<dynamics friction=\"{friction}\" damping=\"0.3\"/></joint>");
        of.replace("</joint>", &dynamics)
    };
    let turn = |names, at, range| joint(names, at, [0.0, 1.0, 0.0], range);
    let base = weighing(6.0, "base", [0.0, 0.0, 0.02], [0.4, 0.4, 0.04]);
    let lower = weighing(0.3, "lower", [0.0, 0.0, 0.2], [0.03, 0.03, 0.4]);
    let upper = weighing(0.2, "upper", [0.17, 0.0, 0.0], [0.34, 0.02, 0.02]);
    let wrist = weighing(0.05, "wrist", [0.02, 0.0, 0.0], [0.04, 0.02, 0.02]);
    let head = weighing(1.0, "head", [0.05, 0.0, -0.1], [0.1, 0.1, 0.1]);
    let lift = turn(("revolute", "base", "lower"), [0.0, 0.0, 0.1], [-0.9, 0.9]);
    let bend = turn(("revolute", "lower", "upper"), [0.0, 0.0, 0.4], [-0.6, 0.8]);
    let tilt = turn(("revolute", "upper", "wrist"), [0.34, 0.0, 0.0], [-0.6, 0.8]);
    let nod = turn(("revolute", "wrist", "head"), [0.04, 0.0, 0.0], [-0.6, 0.8]);
    let parts = base + &lower + &upper + &wrist + &head;
    let joints = held(lift, 9.0) + &held(bend, 9.0) + &held(tilt, 2.0) + &held(nod, 1.0);
    let found = checks(&robot(&(parts + &joints)));
    assert_eq!(found[1].status, Status::Pass, "{found:#?}");
}

#[test]
fn an_arm_whose_mass_stands_beside_its_foot_tips_over() {
    let foot = link("foot", [0.0, 0.0, 0.01], [0.1, 0.1, 0.02]);
    let arm = link("arm", [0.3, 0.0, 0.2], [0.5, 0.02, 0.02]);
    let hinge = joint(("revolute", "foot", "arm"), [0.0; 3], [0.0, 0.0, 1.0], [-0.5, 0.5]);
    let found = checks(&robot(&(foot + &arm + &hinge)));
    assert_eq!(found[1].status, Status::Fail, "{found:#?}");
    assert!(found[1].evidence[0].contains("tips over"));
}

#[test]
fn a_joint_blocked_by_another_part_does_not_reach_its_end() {
    let base = link("base", [0.0; 3], [0.1; 3]);
    let slide = |name: &str, y: f64, range| {
        joint(("prismatic", "base", name), [0.0, y, 0.0], [0.0, 1.0, 0.0], range)
    };
    let pusher = link("pusher", [0.2, 0.0, 0.0], [0.1; 3]) + &slide("pusher", 0.0, [0.0, 0.4]);
    let wall = link("wall", [0.2, 0.0, 0.0], [0.1; 3]) + &slide("wall", 0.3, [-0.01, 0.01]);
    let found = checks(&robot(&(base + &pusher + &wall)));
    assert_eq!(found[2].status, Status::Fail, "{found:#?}");
}

/// The pusher comes at 2 m/s, 8 mm a step; the plate is 4 mm thick and has another at its back.
#[test]
fn a_plate_thinner_than_a_step_is_not_passed_through() {
    let base = link("base", [0.0; 3], [0.1; 3]);
    let slide = |name: &str, y: f64, range| {
        joint(("prismatic", "base", name), [0.0, y, 0.0], [0.0, 1.0, 0.0], range)
    };
    let plate = |name: &str, y: f64| {
        link(name, [0.2, 0.0, 0.0], [0.1, 0.004, 0.1]) + &slide(name, y, [-0.01, 0.01])
    };
    let pusher = link("pusher", [0.2, 0.0, 0.0], [0.1; 3]) + &slide("pusher", 0.0, [0.0, 0.4]);
    let plates = plate("first", 0.2) + &plate("second", 0.2045);
    let found = checks(&robot(&(base + &pusher + &plates)));
    assert_eq!(found[2].status, Status::Fail, "{found:#?}");
    // It gets as far as the plate's face, 0.148 m of 0.4, and pushes that a little.
    let stopped = |words: &String| words.starts_with("joint `pusher_joint` covers 37.");
    assert!(found[2].evidence.iter().any(stopped), "{found:#?}");
}

#[test]
fn overlap_at_rest_or_missing_mass_leaves_everything_unknown() {
    let r = cabinet();
    let found = dynamics::checks(&r, &CheckOptions::default(), false);
    assert!(found.len() == 5 && found.iter().all(|c| c.status == Status::Unknown));
    let mut massless = r.clone();
    massless.links[1].inertial = None;
    let found = checks(&massless);
    assert!(found.iter().all(|c| c.status == Status::Unknown), "{found:#?}");
    let hold = dynamics::hold(&massless, &CheckOptions::default());
    assert_eq!(hold.status, Status::Unknown, "{hold:?}");
}

#[test]
fn the_same_asset_gives_the_same_bytes_on_one_thread_and_two() {
    let r = cabinet();
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        serde_json::to_string(&pool.install(|| checks(&r))).unwrap()
    };
    assert_eq!(run(1), run(2));
}

#[test]
fn the_good_file_of_the_corpus_passes_and_the_bad_ones_never_all() {
    let Some(folder) = defects() else { return };
    let read = |name: &str| load::read(&folder.join(name), &CheckOptions::default()).robot.unwrap();
    let good = read("00_good.urdf");
    let hold = dynamics::hold(&good, &CheckOptions::default());
    assert_eq!(hold.status, Status::Pass, "{hold:?}");
    let found = checks(&good);
    assert!(found.iter().all(|c| c.status == Status::Pass), "{found:#?}");
    for bad in ["01_no_inertial_child.urdf", "02_zero_mass.urdf", "24_no_collision_geometry.urdf"] {
        let found = checks(&read(bad));
        assert!(found.iter().any(|c| c.counts_against()), "{bad}: {found:#?}");
    }
}
