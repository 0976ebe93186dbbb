//! How far joints sink under gravity in five seconds when nothing drives them, the root held.
//!
//! Links and joints become a mass matrix and gravity's pull on each joint (kg, m, rad). Time goes on by
//! implicit steps: `(M + h (D + C)) dv = h (g - (D + C) v)`. `D` is the file's damping. Dry friction is
//! `C`: a resistance proportional to speed up to the friction that the file gives, and constant beyond.
//! How steep it is differs by engine. Contacts and Coriolis forces are left out.
//!
//! MuJoCo's is soft on purpose: a held joint creeps at `R f / b`, where `R = (1 - d) / d * (1/M)ii`,
//! `b = 2 / (dmax * timeconst)`, with its defaults d 0.9, dmax 0.95, timeconst 0.02 s.

use std::collections::BTreeMap;

use crate::find::place::at_joint;
use crate::find::vectors::{
    STRAIGHT, Turn, Vector, about, after, along, apply, cross, dot, of_angles,
};
use crate::find::vectors::{plus, solved};
use crate::read::urdf::{Joint, Urdf};
use crate::rule::Place;

/// Seconds looked at.
const TIME: f64 = 5.0;
/// A step, s: finer ones changed no sunk way by more than 2 %.
const STEP: f64 = 0.005;
/// Steps after which masses and pulls are measured anew.
const ANEW: usize = 4;
/// Most joints of a file that is looked at; the work grows with their third power. A guess with room.
const MOST: usize = 64;
/// What counts as sunk: share of the range, and radians of a turn.
const SUNK: (f64, f64) = (0.01, 0.02);
/// Metres per second squared.
const GRAVITY: f64 = 9.81;

/// How an engine takes joint friction.
#[derive(Clone, Copy, Debug)]
enum Friction {
    /// Not at all.
    None,
    /// As MuJoCo: it creeps.
    Soft,
    /// The same for every joint, and it holds; N m or N.
    Own(f64),
}

/// In MuJoCo, where dry friction is soft.
pub(crate) fn in_mujoco(urdf: &Urdf) -> Vec<Place> {
    if urdf.holds_in_mujoco { Vec::new() } else { sunk(urdf, Friction::Soft) }
}

/// In Newton with its MuJoCo solver, which knows no file's options.
pub(crate) fn in_newton(urdf: &Urdf) -> Vec<Place> {
    sunk(urdf, Friction::Soft)
}

/// In engines that drop joint friction.
pub(crate) fn without_friction(urdf: &Urdf) -> Vec<Place> {
    sunk(urdf, Friction::None)
}

/// In SAPIEN, which gives every joint a friction of 0.05.
pub(crate) fn in_sapien(urdf: &Urdf) -> Vec<Place> {
    sunk(urdf, Friction::Own(0.05))
}

/// Joints with friction that move by more than a hundredth of their range, or 0.02 rad, and how far. Of
/// one without friction the file itself says that it falls.
fn sunk(urdf: &Urdf, friction: Friction) -> Vec<Place> {
    let Some(mut robot) = Robot::of(urdf) else { return Vec::new() };
    let farthest = robot.fall(friction);
    let told = |(degree, far): (&Degree<'_>, &f64)| {
        let span = (degree.ends[1] - degree.ends[0]).min(std::f64::consts::TAU);
        let least = if degree.slides { SUNK.0 * span } else { SUNK.1.max(SUNK.0 * span) };
        let unit = if degree.slides { "m" } else { "rad" };
        let found = format!("{far:.3} {unit} in 5 s");
        (degree.friction > 0.0 && *far > least).then(|| at_joint(degree.joint, &found))
    };
    robot.degrees.iter().zip(&farthest).filter_map(told).collect()
}

/// A joint that moves.
struct Degree<'u> {
    joint: &'u Joint,
    slides: bool,
    axis: Vector,
    ends: [f64; 2],
    damping: f64,
    friction: f64,
}

/// A link: where it hangs, and what it weighs.
struct Hung {
    parent: Option<usize>,
    origin: Vector,
    turn: Turn,
    degree: Option<usize>,
    mass: f64,
    centre: Vector,
    /// About the centre, along the link's axes.
    inertia: Turn,
}

struct Robot<'u> {
    degrees: Vec<Degree<'u>>,
    links: Vec<Hung>,
    values: Vec<f64>,
}

impl<'u> Robot<'u> {
    /// Nothing where something moves that is no hinge and no slide, follows another joint or is hung
    /// twice, where numbers are missing, or where there is too much.
    fn of(urdf: &'u Urdf) -> Option<Self> {
        let mut above: BTreeMap<&str, &Joint> = BTreeMap::new();
        let mut below: BTreeMap<&str, Vec<&Joint>> = BTreeMap::new();
        for joint in &urdf.joints {
            if above.insert(&joint.child, joint).is_some() || joint.mimic.is_some() {
                return None;
            }
            below.entry(&joint.parent).or_default().push(joint);
        }
        let named: BTreeMap<_, _> = urdf.links.iter().map(|l| (l.name.as_str(), l)).collect();
        let mut this = Self { degrees: Vec::new(), links: Vec::new(), values: Vec::new() };
        let mut open: Vec<(&str, Option<usize>)> =
            urdf.roots().map(|l| (l.name.as_str(), None)).collect();
        while let Some((name, parent)) = open.pop() {
            let link = named.get(name)?;
            let joint = above.get(name).copied();
            let degree = match joint {
                Some(joint) => this.degree(joint)?,
                None => None,
            };
            let weight = link.inertial;
            let turned = weight.map_or(STRAIGHT, |w| of_angles(w.angles));
            let hung = Hung {
                parent,
                origin: joint.map_or([0.0; 3], |j| j.origin),
                turn: joint.map_or(STRAIGHT, |j| of_angles(j.angles)),
                degree,
                mass: weight.map_or(0.0, |w| w.mass),
                centre: weight.map_or([0.0; 3], |w| w.centre),
                inertia: weight.map_or([[0.0; 3]; 3], |w| along(&turned, w.inertia)),
            };
            this.links.push(hung);
            let index = this.links.len() - 1;
            let next = below.get(name).into_iter().flatten();
            open.extend(next.map(|j| (j.child.as_str(), Some(index))));
        }
        let any = !this.degrees.is_empty() && this.degrees.len() <= MOST;
        any.then_some(this)
    }

    /// Which of the degrees a joint is: a new one, or none for a fixed joint; `None` where it is of
    /// another kind.
    fn degree(&mut self, joint: &'u Joint) -> Option<Option<usize>> {
        let slides = match joint.kind.as_str() {
            "fixed" => return Some(None),
            "revolute" | "continuous" => false,
            "prismatic" => true,
            _ => return None,
        };
        let axis = joint.axis.unwrap_or([1.0, 0.0, 0.0]);
        let length = dot(axis, axis).sqrt();
        let free = [-f64::INFINITY, f64::INFINITY];
        let ends = match joint.limit {
            Some(l) if joint.has_range() => [l.lower?, l.upper?],
            _ => free,
        };
        let (damping, friction) = joint.dynamics.unwrap_or_default();
        let degree = Degree {
            joint,
            slides,
            axis: axis.map(|a| a / length),
            ends,
            damping: damping.unwrap_or_default().max(0.0),
            friction: friction.unwrap_or_default().max(0.0),
        };
        if length.is_nan() || length <= 0.0 {
            return None;
        }
        self.values.push(0.0);
        self.degrees.push(degree);
        Some(Some(self.degrees.len() - 1))
    }

    /// The mass matrix, and what gravity pulls at each joint.
    fn weighed(&self) -> (Vec<Vec<f64>>, Vec<f64>) {
        let count = self.degrees.len();
        let (mut mass, mut pull) = (vec![vec![0.0; count]; count], vec![0.0; count]);
        let mut places: Vec<(Turn, Vector)> = Vec::with_capacity(self.links.len());
        let mut axes = vec![([0.0; 3], [0.0; 3]); count];
        let mut chains: Vec<Vec<usize>> = Vec::with_capacity(self.links.len());
        for link in &self.links {
            let (turn, at) = link.parent.map_or((STRAIGHT, [0.0; 3]), |p| places[p]);
            let mut chain = link.parent.map_or_else(Vec::new, |p| chains[p].clone());
            let mut at = plus(at, apply(&turn, link.origin), 1.0);
            let mut turn = after(&turn, &link.turn);
            if let Some(index) = link.degree {
                let (degree, value) = (&self.degrees[index], self.values[index]);
                let axis = apply(&turn, degree.axis);
                axes[index] = (axis, at);
                if degree.slides {
                    at = plus(at, axis, value);
                } else {
                    turn = after(&turn, &about(degree.axis, value));
                }
                chain.push(index);
            }
            let centre = plus(at, apply(&turn, link.centre), 1.0);
            let moved = |i: usize| {
                let (axis, from) = axes[i];
                if self.degrees[i].slides {
                    (axis, [0.0; 3])
                } else {
                    (cross(axis, plus(centre, from, -1.0)), axis)
                }
            };
            let columns: Vec<(usize, Vector, Vector)> =
                chain.iter().map(|&i| (i, moved(i).0, moved(i).1)).collect();
            let back = |v: Vector| [0, 1, 2].map(|j| (0..3).map(|i| turn[i][j] * v[i]).sum());
            for (i, v, w) in &columns {
                pull[*i] -= link.mass * GRAVITY * v[2];
                let spun = apply(&link.inertia, back(*w));
                for (j, u, z) in &columns {
                    mass[*i][*j] += link.mass * dot(*v, *u) + dot(spun, back(*z));
                }
            }
            places.push((turn, at));
            chains.push(chain);
        }
        (mass, pull)
    }

    /// How far each joint goes from its rest.
    fn fall(&mut self, friction: Friction) -> Vec<f64> {
        let count = self.degrees.len();
        let (mut speed, mut farthest) = (vec![0.0; count], vec![0.0; count]);
        let (mut mass, mut pull) = self.weighed();
        let steep = self.steep(friction, &mass);
        let cap = |d: &Degree<'_>| match friction {
            Friction::None => 0.0,
            Friction::Soft => d.friction,
            Friction::Own(own) => own,
        };
        let caps: Vec<f64> = self.degrees.iter().map(cap).collect();
        for step in 0..(TIME / STEP) as usize {
            if step > 0 && step % ANEW == 0 {
                (mass, pull) = self.weighed();
            }
            let Some(change) = self.pushed((&mass, &pull), &speed, (&steep, &caps)) else {
                return farthest;
            };
            for (i, degree) in self.degrees.iter().enumerate() {
                speed[i] += change[i];
                let to = self.values[i] + STEP * speed[i];
                let kept = to.clamp(degree.ends[0].min(0.0), degree.ends[1].max(0.0));
                if kept != to {
                    speed[i] = 0.0;
                }
                self.values[i] = kept;
                farthest[i] = kept.abs().max(farthest[i]);
            }
        }
        farthest
    }

    /// How speeds change in a step. First all friction holds as steeply as it can; what then is above
    /// its cap slips with it.
    fn pushed(
        &self,
        (mass, pull): (&[Vec<f64>], &[f64]),
        speed: &[f64],
        (steep, caps): (&[f64], &[f64]),
    ) -> Option<Vec<f64>> {
        let mut slips = vec![0.0; self.degrees.len()];
        for _ in 0..=slips.len() {
            let (mut matrix, mut force) = (mass.to_vec(), pull.to_vec());
            for (i, degree) in self.degrees.iter().enumerate() {
                let holds = caps[i] > 0.0 && slips[i] == 0.0;
                let resists = degree.damping + if holds { steep[i] } else { 0.0 };
                force[i] -= resists * speed[i] + slips[i];
                matrix[i][i] += STEP * resists;
                force[i] *= STEP;
            }
            let change = solved(matrix, force)?;
            let mut is_settled = true;
            for i in 0..slips.len() {
                let resisted = steep[i] * (speed[i] + change[i]);
                if caps[i] > 0.0 && slips[i] == 0.0 && resisted.abs() > caps[i] {
                    slips[i] = caps[i] * resisted.signum();
                    is_settled = false;
                }
            }
            if is_settled {
                return Some(change);
            }
        }
        Some(vec![0.0; slips.len()])
    }

    /// What friction resists per speed while it holds.
    fn steep(&self, friction: Friction, mass: &[Vec<f64>]) -> Vec<f64> {
        let count = self.degrees.len();
        let (impedance, most, time) = (0.9, 0.95, 0.02);
        let of = |i: usize| match friction {
            Friction::None => 0.0,
            Friction::Own(_) => 1e6 * mass[i][i],
            Friction::Soft => {
                let mut unit = vec![0.0; count];
                unit[i] = 1.0;
                let loose = solved(mass.to_vec(), unit).map_or(0.0, |column| column[i]);
                let soft = (1.0 - impedance) / impedance * loose;
                2.0 / (most * time) / soft.max(1e-12)
            }
        };
        (0..count).map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::urdf::{Inertial, Limit, Link};

    /// An arm of half a kilogram, its weight 0.2 m from a level hinge, and what the hinge rubs with: the
    /// file of `engines/check_*.py`.
    fn arm(friction: f64) -> Urdf {
        let weight = |mass, i: f64, x| Inertial {
            mass,
            inertia: [i, i, i, 0.0, 0.0, 0.0],
            centre: [x, 0.0, 0.0],
            ..Inertial::default()
        };
        let link = |name: &str, inertial| Link {
            name: name.into(),
            inertial: Some(inertial),
            ..Link::default()
        };
        let limit =
            Limit { lower: Some(-1.5), upper: Some(1.5), effort: Some(9.0), velocity: Some(2.0) };
        let joint = Joint {
            name: "j".into(),
            kind: "revolute".into(),
            parent: "base".into(),
            child: "a".into(),
            axis: Some([0.0, 1.0, 0.0]),
            limit: Some(limit),
            dynamics: Some((Some(0.04), Some(friction))),
            ..Joint::default()
        };
        let links = vec![link("base", weight(1.0, 0.1, 0.0)), link("a", weight(0.5, 0.001, 0.2))];
        Urdf { links, joints: vec![joint], ..Urdf::default() }
    }

    fn far(places: &[Place]) -> f64 {
        let [place] = places else { return 0.0 };
        place.found.split(' ').next().unwrap().parse().unwrap()
    }

    #[test]
    fn a_held_arm_creeps_in_mujoco_as_far_whatever_its_friction() {
        // MuJoCo 4.0.0: 0.2433 rad.
        for friction in [1.1, 2.0, 5.0] {
            let sunk = far(&in_mujoco(&arm(friction)));
            assert!((sunk - 0.2433).abs() < 0.02, "{sunk}");
        }
        let held = Urdf { holds_in_mujoco: true, ..arm(2.0) };
        assert!(in_mujoco(&held).is_empty());
    }

    #[test]
    fn an_arm_falls_to_its_stop_where_friction_is_dropped_or_too_little() {
        assert_eq!(far(&without_friction(&arm(2.0))), 1.5);
        assert_eq!(far(&in_sapien(&arm(2.0))), 1.5);
        assert!(far(&in_mujoco(&arm(0.5))) > 1.0, "gravity pulls with 0.98 N m");
    }

    #[test]
    fn an_upright_hinge_sinks_nowhere() {
        let mut door = arm(0.0);
        door.joints[0].axis = Some([0.0, 0.0, 1.0]);
        assert!(in_mujoco(&door).is_empty() && without_friction(&door).is_empty());
    }

    #[test]
    fn a_file_tied_into_a_ring_is_passed_over() {
        let mut ring = arm(2.0);
        let back = Joint { parent: "a".into(), child: "base".into(), ..ring.joints[0].clone() };
        ring.joints.push(back);
        assert!(without_friction(&ring).is_empty());
    }
}
