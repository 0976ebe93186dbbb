//! J7: does gravity open a joint that nobody touches.

use glamx::{DPose3, DVec3};

use crate::mass::lump::Lump;
use crate::profile::bounds::{HELD_FOR, OPENED};
use crate::profile::words::moved;
use crate::robot::{Joint, Robot, Spring};
use crate::verdict::Check;

/// Steps per second of the integration.
const RATE: f64 = 1000.0;
/// Standard gravity along −z, m/s².
const GRAVITY: DVec3 = DVec3::new(0.0, 0.0, -9.81);

/// Check J7, in closed form. A joint holds if its friction outweighs what gravity does to
/// everything it carries, or if its limit is in the way. Otherwise the fall is computed for 5 s
/// with one degree of freedom: the other joints at rest, the root upright.
///
/// The URDF has no word for a joint that is meant to swing, so none is excused; a balanced one (a
/// wheel) holds because gravity does not turn it. What a mimic joint carries counts where it hangs;
/// its leader is judged for its own branch only.
pub fn check(robot: &Robot) -> Check {
    let poses = robot.link_poses(&[]);
    let (mut faults, mut unknown, mut worst) = (Vec::new(), Vec::new(), 0f64);
    let falls = |j: &&Joint| j.kind.moves() && j.mimic.is_none() && !is_loose(j);
    for joint in robot.joints.iter().filter(falls) {
        match Fall::new(robot, joint, &poses).map(|fall| (fall.furthest(), fall)) {
            Err(reason) => unknown.push(format!("joint `{}` {reason}", joint.name)),
            Ok((moved, fall)) => {
                let share = moved.abs() / fall.bound;
                worst = worst.max(share);
                faults.extend((share > 1.0).then(|| fall.words(joint, moved)));
            }
        }
    }
    let check = match unknown.is_empty() || !faults.is_empty() {
        true => Check::from_faults("J7", faults),
        false => Check::unknown("J7", unknown.join("; ")),
    };
    check.value(worst).threshold(format!(
        "motion / bound <= 1, the bound being {} in {HELD_FOR} s",
        moved(OPENED)
    ))
}

/// Whether it only says that its part floats: gravity does what it does to anything.
fn is_loose(joint: &Joint) -> bool {
    joint.kind == crate::robot::Motion::Floating && joint.held.is_none()
}

/// One joint and what gravity does to it.
struct Fall {
    turns: bool,
    axis: DVec3,
    arm: DVec3,
    mass: f64,
    inertia: f64,
    friction: f64,
    damping: f64,
    spring: Option<Spring>,
    lower: f64,
    upper: f64,
    bound: f64,
}

impl Fall {
    fn new(robot: &Robot, joint: &Joint, poses: &[DPose3]) -> Result<Self, String> {
        if let Some(why) = &joint.held {
            return Err(why.clone());
        }
        if !(joint.kind.has_axis() && joint.axis.is_normalized()) {
            return Err("has no axis to hold".into());
        }
        let carried = (0..robot.links.len()).filter(|&l| robot.is_under(l, joint.child));
        let lump = Lump::of_links(robot, carried, poses);
        let frame = poses[joint.child];
        let (pivot, axis) = (frame.translation, frame.rotation * joint.axis);
        let turns = joint.kind.turns();
        let inertia = if turns { lump.about(pivot, axis) } else { lump.mass };
        let mass = |l: usize| Lump::of_link(robot, l, &poses[l]).mass;
        let massless = |l: &usize| mass(*l) <= 0.0 || mass(*l).is_nan();
        if let Some(l) = bodies_under(robot, joint.child).into_iter().find(massless) {
            return Err(format!("carries link `{}`, which has no mass", robot.links[l].name));
        }
        if !(lump.mass > 0.0 && inertia > 0.0 && inertia.is_finite()) {
            return Err("carries no mass to speak of, so nothing is known".into());
        }
        let (lower, upper) = if joint.kind == crate::robot::Motion::Continuous {
            (f64::NEG_INFINITY, f64::INFINITY)
        } else {
            joint.ends().ok_or("has no limits")?
        };
        let given = |of: Option<f64>| of.filter(|v| v.is_finite() && *v > 0.0).unwrap_or(0.0);
        Ok(Self {
            turns,
            axis,
            arm: lump.com - pivot,
            mass: lump.mass,
            inertia,
            friction: given(joint.dynamics.and_then(|d| d.friction)),
            damping: given(joint.dynamics.and_then(|d| d.damping)),
            spring: joint.spring,
            lower,
            upper,
            bound: OPENED.of(turns),
        })
    }

    /// Torque or force of gravity and of its spring along the joint when it stands at `q`, N·m or N.
    fn load(&self, q: f64) -> f64 {
        let spring = self.spring.map_or(0.0, |s| s.stiffness * (s.at - q));
        self.gravity(q) + spring
    }

    fn gravity(&self, q: f64) -> f64 {
        let weight = GRAVITY * self.mass;
        if !self.turns {
            return self.axis.dot(weight);
        }
        let arm = glamx::DQuat::from_axis_angle(self.axis, q) * self.arm;
        self.axis.dot(arm.cross(weight))
    }

    /// The joint value furthest from rest within the time, or the first beyond the bound.
    fn furthest(&self) -> f64 {
        let dt = 1.0 / RATE;
        let (mut q, mut speed, mut furthest) = (0.0f64, 0.0f64, 0.0f64);
        for _ in 0..(HELD_FOR * RATE) as usize {
            let load = self.load(q);
            if speed == 0.0 && load.abs() <= self.friction {
                return furthest;
            }
            let direction = if speed == 0.0 { load.signum() } else { speed.signum() };
            let pull = (load - direction * self.friction) / self.inertia;
            // A spring is taken as it will be after the step: stiff ones stay stable so.
            let stiff = self.spring.map_or(0.0, |s| dt * dt * s.stiffness / self.inertia);
            let next = (speed + dt * pull) / (1.0 + dt * self.damping / self.inertia + stiff);
            speed = if speed * next < 0.0 { 0.0 } else { next };
            q += dt * speed;
            if q <= self.lower || q >= self.upper {
                (q, speed) = (q.clamp(self.lower.min(0.0), self.upper.max(0.0)), 0.0);
            }
            furthest = if q.abs() > furthest.abs() { q } else { furthest };
            if furthest.abs() > self.bound {
                break;
            }
        }
        furthest
    }

    fn words(&self, joint: &Joint, moved: f64) -> String {
        let load = self.load(0.0).abs();
        let (unit, shown) = if self.turns {
            ("N m", format!("{:.1} deg", moved.to_degrees()))
        } else {
            ("N", format!("{:.1} mm", moved * 1000.0))
        };
        format!(
            "joint `{}` (line {}) falls beyond {shown}: gravity pulls with {load:.4} {unit}, \
             friction holds {:.4} {unit}",
            joint.name, joint.line, self.friction
        )
    }
}

/// Links under `child` (itself included) that a moving joint holds: each needs mass of its own.
fn bodies_under(robot: &Robot, child: usize) -> Vec<usize> {
    let moves = |l: usize| robot.joint_above(l).is_some_and(|j| robot.joints[j].kind.moves());
    let needs = |l: &usize| moves(*l) && !robot.links[*l].between && robot.is_under(*l, child);
    (0..robot.links.len()).filter(needs).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::sweep::tests::{joint, link, robot};
    use crate::verdict::Status;

    fn lid(axis: [f64; 3], range: [f64; 2], friction: f64) -> Check {
        let hinge = joint(("revolute", "base", "lid"), [0.0; 3], axis, range).replace(
            "</joint>",
            &format!("<dynamics damping=\"0\" friction=\"{friction}\"/></joint>"),
        );
        let parts = link("base", [0.0, 0.0, -1.0], [1.0; 3])
            + &link("lid", [0.5, 0.0, 0.0], [1.0, 1.0, 0.1]);
        check(&robot(&(parts + &hinge)))
    }

    #[test]
    fn a_door_on_a_vertical_hinge_stays_without_friction() {
        assert_eq!(lid([0.0, 0.0, 1.0], [-1.0, 1.0], 0.0).status, Status::Pass);
    }

    #[test]
    fn a_level_lid_needs_friction_of_its_weight_times_its_arm() {
        let torque = 9.81 * 0.5;
        let both = [-1.0, 1.0];
        assert_eq!(lid([0.0, 1.0, 0.0], both, torque * 1.001).status, Status::Pass);
        let falls = lid([0.0, 1.0, 0.0], both, torque * 0.9);
        assert_eq!(falls.status, Status::Fail);
        assert!(falls.evidence[0].contains("gravity pulls with 4.9050 N m"), "{falls:?}");
    }

    #[test]
    fn a_lid_that_rests_on_its_lower_limit_holds() {
        assert_eq!(lid([0.0, -1.0, 0.0], [0.0, 1.0], 0.0).status, Status::Pass);
        assert_eq!(lid([0.0, 1.0, 0.0], [0.0, 1.0], 0.0).status, Status::Fail);
    }
}
