//! Contact without an engine: own forward kinematics and convex-convex queries on every pair of
//! bodies, parent and child included, at rest and along every range.
//!
//! Physics engines skip pairs that a joint connects, so a door that swings into its cabinet looks
//! clean to them; and a collider that was never built collides with nothing. Here every pair
//! counts, and [`Scene::new`] refuses a robot whose colliders are not all there.
//!
//! ```
//! use sim_check::CheckOptions;
//! use sim_check::checks::sweep::joint_sweep;
//! use sim_check::read::load::from_text;
//! let text = r#"<robot name="rail"><link name="base"/><link name="sled"/>
//!   <joint name="slide" type="prismatic"><parent link="base"/><child link="sled"/>
//!     <axis xyz="1 0 0"/><limit lower="0" upper="0.5" effort="1" velocity="1"/></joint></robot>"#;
//! let robot = from_text(text, ".".as_ref(), &CheckOptions::default()).robot.unwrap();
//! assert_eq!(joint_sweep(&robot, 4).unwrap(), [[0.25], [0.5], [0.25], [0.0]]);
//! ```

pub mod advance;
pub mod bodies;
pub mod boxes;
mod capsules;
#[cfg(test)]
mod chains;
mod expand;
pub mod facets;
mod gap;
pub mod guide;
pub mod hull;
pub mod overlap;
pub mod round;
pub mod sat;
pub mod scene;
pub mod seen;
pub mod stance;
pub mod terms;
#[cfg(test)]
pub(crate) mod tests;
pub mod together;
pub mod tree;

pub use scene::{Scene, SceneFault};

use glamx::DPose3;

use crate::robot::Robot;

/// Frames of all links in the root frame for one value per joint (radians or metres from rest).
pub fn link_poses(robot: &Robot, q: &[f64]) -> Vec<DPose3> {
    robot.link_poses(q)
}

/// A picture of the motion: each driven joint alone from rest to its lower end, its upper end and
/// back, in `steps` configurations per joint, the first after rest and the last at rest. Each
/// configuration holds one value per joint of the robot, in file order (radians or metres from
/// rest), ready for [`link_poses`]. A continuous joint makes one turn.
///
/// # Errors
/// [`SceneFault`] if a joint cannot be moved.
pub fn joint_sweep(robot: &Robot, steps: usize) -> Result<Vec<Vec<f64>>, SceneFault> {
    let (drives, held) = scene::drives(robot);
    if let Some(why) = held.into_iter().next() {
        return Err(SceneFault::NoneBuilt(why));
    }
    let rest = bodies::values(robot, &drives, &[]);
    if drives.is_empty() {
        return Ok(vec![rest]);
    }
    let states = drives
        .iter()
        .enumerate()
        .flat_map(|(d, drive)| (1..=steps).map(move |k| (d, drive.along(k as f64 / steps as f64))));
    Ok(states.map(|moved| bodies::values(robot, &drives, &[moved])).collect())
}
