//! What would free a joint that collides or jams on its way: the smallest change of its range, or
//! its axis the other way round.
//!
//! ```
//! use sim_check::advice::{Remedy, advice};
//! use sim_check::{CheckOptions, read::load::from_text};
//! let block = |name: &str, x: f64| {
//!     let shape = format!(r#"<origin xyz="{x} 0 0"/><geometry><box size="0.2 0.2 0.2"/></geometry>"#);
//!     format!(r#"<link name="{name}"><visual>{shape}</visual><collision>{shape}</collision>
//!       <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>
//!       </inertial></link>"#)
//! };
//! let joint = r#"<joint name="slide" type="prismatic"><parent link="wall"/><child link="block"/>
//!   <axis xyz="1 0 0"/><limit lower="0" upper="0.5" effort="1" velocity="1"/></joint>"#;
//! let text = format!("<robot name=\"r\">{}{}{joint}</robot>", block("wall", 0.4), block("block", 0.0));
//! let robot = from_text(&text, ".".as_ref(), &CheckOptions::default()).robot.unwrap();
//! // It runs into the wall after 0.2 m, and is free the other way.
//! assert_eq!(advice(&robot)[0].remedy, Remedy::Flip);
//! ```

use rayon::prelude::*;

use crate::checks::dynamics::drive::drive;
use crate::checks::sweep::Scene;
use crate::checks::sweep::advance::{TooMuchWork, sweep};
use crate::checks::sweep::overlap::overlaps;
use crate::profile::bounds::{FARTHER, REACHED, SOON};
use crate::robot::{Motion, Robot};

/// Halvings of the way to a hit: to a millionth of it.
const HALVINGS: usize = 20;
/// A joint that covers less of its range than this is stuck, and no other range will do.
const STUCK: f64 = 0.5;

/// A change to one joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Advice {
    /// Name of the joint.
    pub joint: String,
    /// What to change about it.
    pub remedy: Remedy,
}

/// What frees a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Remedy {
    /// Its range, clamped to the largest interval around rest that is free of overlaps: radians or
    /// metres, lower and upper.
    Clamp([f64; 2]),
    /// Its axis, turned round: it opens into another part, and is free the other way.
    Flip,
}

/// The remedies for every limited joint that overlaps on its way alone, in the order of joints; none
/// for a joint that overlaps at rest, which no range can free.
pub fn advice(robot: &Robot) -> Vec<Advice> {
    of_limited(robot, |scene, d| remedy(scene, d).ok().flatten())
}

/// The remedies for every limited joint that touches another part on its way, though it overlaps
/// none beyond the bound, and stops there when it is driven: the part of its range that it covers.
pub fn jams(robot: &Robot) -> Vec<Advice> {
    of_limited(robot, |scene, d| {
        let driven = drive(scene, d).ok().filter(|d| d.finite)?;
        let jammed = (STUCK..REACHED).contains(&driven.reached);
        jammed.then_some(Remedy::Clamp(driven.covered))
    })
}

/// What is advised for each drive with limits that moves nothing but itself.
fn of_limited(
    robot: &Robot,
    advise: impl Fn(&Scene, usize) -> Option<Remedy> + Sync,
) -> Vec<Advice> {
    let Ok(scene) = Scene::new(robot) else { return Vec::new() };
    let limited = |&d: &usize| {
        let drive = &scene.drives[d];
        robot.joints[drive.joint].kind != Motion::Continuous && drive.followers.is_empty()
    };
    let drives: Vec<usize> = (0..scene.drives.len()).filter(limited).collect();
    let found = drives.into_par_iter().map(|d| {
        let remedy = advise(&scene, d)?;
        Some(Advice { joint: scene.name(d).to_owned(), remedy })
    });
    found.collect::<Vec<_>>().into_iter().flatten().collect()
}

fn remedy(scene: &Scene, drive: usize) -> Result<Option<Remedy>, TooMuchWork> {
    let (lower, upper) = (scene.drives[drive].lower, scene.drives[drive].upper);
    let hits = [sweep(scene, drive, lower)?.first_hit, sweep(scene, drive, upper)?.first_hit];
    if hits == [None; 2] || hits.contains(&Some(0.0)) {
        return Ok(None);
    }
    let opens_up = upper >= -lower;
    let (main, end) = if opens_up { (hits[1], upper) } else { (hits[0], lower) };
    if let Some(hit) = main.map(f64::abs).filter(|h| *h <= SOON * end.abs()) {
        let mirrored = sweep(scene, drive, -end)?.first_hit.map_or(end.abs(), f64::abs);
        if mirrored >= FARTHER * hit {
            return Ok(Some(Remedy::Flip));
        }
    }
    let free = |hit: Option<f64>, end: f64| hit.map_or(end, |hit| last_free(scene, drive, hit));
    Ok(Some(Remedy::Clamp([free(hits[0], lower), free(hits[1], upper)])))
}

/// The joint value between rest and a hit up to which nothing overlaps beyond the bound.
fn last_free(scene: &Scene, drive: usize, hit: f64) -> f64 {
    let is_free = |q: f64| {
        let found = overlaps(scene, &scene.with(&[(drive, q)]), |_, _| true);
        found.first().is_none_or(|o| o.depth <= scene.bound())
    };
    let (mut free, mut blocked) = (0.0, hit);
    for _ in 0..HALVINGS {
        let middle = (free + blocked) / 2.0;
        if is_free(middle) { free = middle } else { blocked = middle }
    }
    free
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::sweep::tests::{joint, link, robot};

    /// A block that slides 0.5 m towards a wall 0.2 m away, and the other way into the open.
    fn slide([lower, upper]: [f64; 2]) -> Vec<Advice> {
        let slide =
            joint(("prismatic", "base", "block"), [0.0; 3], [1.0, 0.0, 0.0], [lower, upper]);
        let wall = link("base", [0.75, 0.0, 0.5], [0.1, 1.0, 1.0]);
        advice(&robot(&(wall + &link("block", [0.0, 0.0, 0.5], [1.0, 0.2, 0.2]) + &slide)))
    }

    #[test]
    fn a_range_that_runs_into_a_wall_is_clamped_to_before_it() {
        let [Advice { joint, remedy: Remedy::Clamp([lower, upper]) }] = &slide([-0.1, 0.3])[..]
        else {
            panic!("{:?}", slide([-0.1, 0.3]))
        };
        assert_eq!((joint.as_str(), *lower), ("block_joint", -0.1));
        assert!((upper - 0.2).abs() < 0.005, "{upper}");
    }

    #[test]
    fn an_axis_that_points_into_the_wall_is_turned_round() {
        assert_eq!(slide([0.0, 0.5])[0].remedy, Remedy::Flip);
    }

    #[test]
    fn a_joint_that_is_stopped_by_a_touch_gets_the_range_it_covers() {
        let text = |upper: f64| {
            let slide =
                joint(("prismatic", "base", "block"), [0.0; 3], [1.0, 0.0, 0.0], [-0.1, upper]);
            let lug = link("lug", [0.75, 0.0, 0.5], [0.1, 1.0, 1.0]);
            let held = joint(("prismatic", "base", "lug"), [0.0; 3], [0.0, 0.0, 1.0], [0.0, 0.1]);
            let base = link("base", [0.0, 0.0, -0.5], [2.0, 1.0, 0.2]);
            base + &lug + &held + &link("block", [0.0, 0.0, 0.5], [1.0, 0.2, 0.2]) + &slide
        };
        assert!(jams(&robot(&text(0.15))).is_empty());
        assert!(jams(&robot(&text(1.5))).is_empty(), "it covers a fifth only");
        let [Advice { remedy: Remedy::Clamp([lower, upper]), .. }] = &jams(&robot(&text(0.25)))[..]
        else {
            panic!("{:?}", jams(&robot(&text(0.25))))
        };
        assert!(*lower < -0.095 && (upper - 0.2).abs() < 0.005, "{lower} {upper}");
    }

    #[test]
    fn a_joint_that_is_free_needs_nothing() {
        assert!(slide([-0.5, 0.1]).is_empty());
    }
}
