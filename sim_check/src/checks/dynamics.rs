//! What a physics engine makes of the asset, joint by joint, held against closed forms (checks S1
//! to S5 and J7).
//!
//! ```
//! use sim_check::checks::dynamics::hold;
//! use sim_check::{CheckOptions, Status};
//! let options = CheckOptions::default();
//! let text = r#"<robot name="lift"><link name="base"/>
//!   <link name="cab"><inertial><mass value="1"/>
//!     <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
//!   <joint name="rise" type="prismatic"><parent link="base"/><child link="cab"/>
//!     <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"#;
//! let robot = sim_check::read::load::from_text(text, ".".as_ref(), &options).robot.unwrap();
//! // Nothing holds it: it falls to its lower limit.
//! assert_eq!(hold(&robot, &options).status, Status::Fail);
//! ```

use rayon::prelude::*;

use crate::checks::kinematic::known_but;
use crate::checks::study::Study;
use crate::checks::sweep::Scene;
use crate::mass::lump::Lump;
use crate::options::CheckOptions;
use crate::profile::bounds::{
    CLOSED_FORM, GAIN, OPENED, OVERSHOOT, PUSHED, PUSHED_LEAST, REACHED, SETTLE, TIPPED, radians,
};
use crate::profile::words::{moved, percent};
use crate::profile::{Group, Tier};
use crate::robot::Robot;
use crate::verdict::{Check, all_unknown};

pub mod drive;
pub mod drop;
pub mod feet;
pub mod hold;
pub mod pendulum;
pub mod strangers;
pub mod weld;
pub mod world;

use drive::{Driven, drive, push};
use drop::{Drop, Energy, GRAVITY, drift_bound, is_anchored, swing};
use world::SimFault;

/// J7: gravity does not open a joint that nobody touches.
pub fn hold(robot: &Robot, options: &CheckOptions) -> Check {
    let _ = options;
    let run = || hold::check(robot);
    std::panic::catch_unwind(run).unwrap_or_else(|_| Check::unknown("J7", "the check broke down"))
}

/// S1 to S5; all unknown if the parts overlap at rest (they would be flung apart) or a collider is
/// missing.
pub fn checks(robot: &Robot, options: &CheckOptions, rest_is_clean: bool) -> Vec<Check> {
    let reason = "C1 does not hold: parts that overlap at rest would be flung apart";
    checks_of(&Study::new(robot), options, (!rest_is_clean).then_some(reason))
}

/// The same, with what others make of the robot.
/// `unfit`: why what is at rest cannot be simulated, if so.
pub(crate) fn checks_of(study: &Study, options: &CheckOptions, unfit: Option<&str>) -> Vec<Check> {
    if options.up_to < Tier::Dynamic {
        return Vec::new();
    }
    if let Some(reason) = unfit {
        return all_unknown(Group::Simulation, reason);
    }
    let run = || match study.scene() {
        Ok(scene) => run(scene),
        Err(fault) => all_unknown(Group::Simulation, &fault.to_string()),
    };
    std::panic::catch_unwind(run)
        .unwrap_or_else(|_| all_unknown(Group::Simulation, "the physics engine broke down"))
}

fn run(scene: &Scene) -> Vec<Check> {
    let drives = 0..scene.drives.len();
    let (dropped, (swung, driven)) = rayon::join(
        || drop_unless_anchored(scene),
        || {
            rayon::join(
                || swing(scene),
                || {
                    drives
                        .into_par_iter()
                        .with_max_len(1)
                        .map(|d| drive(scene, d))
                        .collect::<Vec<_>>()
                },
            )
        },
    );
    let driven: Result<Vec<Driven>, SimFault> = driven.into_iter().collect();
    let (all, mut held) = (&scene.missing, scene.missing.clone());
    held.extend(scene.held.iter().cloned());
    vec![
        known_but(sound(&dropped, &swung, &driven), &held),
        known_but(settles(scene, dropped), all),
        known_but(reaches(scene, driven), &held),
        known_but(limits_hold(scene), &held),
        known_but(closed_forms(scene), &held),
    ]
}

fn drop_unless_anchored(scene: &Scene) -> Result<Option<Drop>, SimFault> {
    if is_anchored(scene) { Ok(None) } else { drop::drop(scene).map(Some) }
}

fn sound(
    dropped: &Result<Option<Drop>, SimFault>,
    swung: &Result<Energy, SimFault>,
    driven: &Result<Vec<Driven>, SimFault>,
) -> Check {
    let (dropped, swung, driven) = match (dropped, swung, driven) {
        (Ok(d), Ok(s), Ok(r)) => (d, s, r),
        (Err(e), ..) | (_, Err(e), _) | (.., Err(e)) => {
            return Check::unknown("S1", e.to_string());
        }
    };
    let runs = [("free swing", Some(*swung)), ("drop", dropped.map(|d| d.energy))];
    let mut faults = Vec::new();
    let mut worst = 0f64;
    for (name, energy) in runs.into_iter().filter_map(|(n, e)| e.map(|e| (n, e))) {
        worst = worst.max(energy.gain);
        faults.extend((!energy.finite).then(|| format!("{name}: a state is not finite")));
        let gained = 100.0 * energy.gain;
        faults.extend(
            exceeds(energy.gain, GAIN)
                .then(|| format!("{name}: gains {gained:.1} % of its energy")),
        );
    }
    let wild = driven.iter().filter(|d| !d.finite).count();
    faults.extend((wild > 0).then(|| format!("{wild} driven joints: a state is not finite")));
    Check::from_faults("S1", faults).value(worst * 100.0).threshold(format!(
        "all states finite, energy gain <= {} of what the motion turns over",
        percent(GAIN)
    ))
}

fn settles(scene: &Scene, dropped: Result<Option<Drop>, SimFault>) -> Check {
    let dropped = match dropped {
        Err(e) => return Check::unknown("S2", e.to_string()),
        Ok(None) => {
            let name = &scene.robot.links[scene.robot.root()].name;
            return Check::pass("S2").evidence(format!("the root `{name}` is fixed: not dropped"));
        }
        Ok(Some(dropped)) => dropped,
    };
    let mut faults = Vec::new();
    let (tilt, bound) = (dropped.tilt, drift_bound(scene));
    let lean = tilt.to_degrees();
    faults
        .extend(exceeds(tilt, radians(TIPPED)).then(|| format!("tips over: leans {lean:.1} deg")));
    faults.extend(dropped.settled.is_none().then(|| format!("still moves after {SETTLE} s")));
    let drift = format!("drifts {:.2} mm sideways", dropped.drift * 1000.0);
    faults.extend(exceeds(dropped.drift, bound).then_some(drift));
    let limit = format!("{:.1} mm", bound * 1000.0);
    Check::from_faults("S2", faults)
        .value(dropped.drift * 1000.0)
        .threshold(format!("settles in {SETTLE} s, leans <= {TIPPED} deg, drifts < {limit}"))
}

fn reaches(scene: &Scene, driven: Result<Vec<Driven>, SimFault>) -> Check {
    let driven = match driven {
        Err(e) => return Check::unknown("S3", e.to_string()),
        Ok(driven) => driven,
    };
    let mut faults = Vec::new();
    let least = driven.iter().map(|d| d.reached).fold(1.0, f64::min);
    for (d, run) in driven.iter().enumerate() {
        let name = scene.name(d);
        let [reached, over] = [run.reached, run.overshoot].map(|s| 100.0 * s);
        let mut say = |bad: bool, what: String| {
            faults.extend(bad.then(|| format!("joint `{name}` {what}")));
        };
        say(!run.finite, "leaves the numbers".into());
        say(exceeds(REACHED, run.reached), format!("covers {reached:.1} % of its range"));
        say(exceeds(run.overshoot, OVERSHOOT), format!("overshoots by {over:.1} %"));
        let drag =
            format!("drags another joint along by {:.1} times {}", run.others, moved(OPENED));
        say(exceeds(run.others, 1.0), drag);
        let joint = &scene.robot.joints[scene.drives[d].joint];
        let [effort, friction] =
            [joint.limit.and_then(|l| l.effort), joint.dynamics.and_then(|y| y.friction)];
        if let (Some(effort), Some(friction)) = (effort, friction) {
            let words = format!("rubs with {friction} but may be driven with {effort} only");
            say(exceeds(friction, effort), words);
        }
    }
    Check::from_faults("S3", faults).value(least * 100.0).threshold(format!(
        "every joint covers >= {} of its range, overshoots < {}, effort above friction",
        percent(REACHED),
        percent(OVERSHOOT)
    ))
}

fn limits_hold(scene: &Scene) -> Check {
    let effort = |d: usize| {
        let limit = scene.robot.joints[scene.drives[d].joint].limit;
        let told = limit.and_then(|l| l.effort).filter(|e| e.is_finite() && *e > 0.0);
        // A passive joint says nothing of how strong it is: it is pushed by its part's weight.
        let is_silent = scene.robot.format.may_be_passive() && told.is_none();
        told.or_else(|| is_silent.then(|| weight(scene, d)).flatten())
    };
    let drives = 0..scene.drives.len();
    let pushed: Vec<_> =
        drives.into_par_iter().map(|d| effort(d).map(|e| push(scene, d, e))).collect();
    let (mut faults, mut unknown, mut worst) = (Vec::new(), Vec::new(), 0f64);
    for (d, outcome) in pushed.into_iter().enumerate() {
        let (name, of) = (scene.name(d), &scene.drives[d]);
        match outcome {
            None if of.continuous => {}
            None => unknown.push(format!("joint `{name}` declares no effort to push with")),
            Some(Err(e)) => unknown.push(e.to_string()),
            Some(Ok(None)) => {}
            Some(Ok(Some(beyond))) => {
                let bound = PUSHED_LEAST.of(scene.turns(d)).max(PUSHED * (of.upper - of.lower));
                worst = worst.max(beyond / bound);
                let by = scene.shown(d, beyond);
                let words = format!("joint `{name}` is pushed {by} beyond its limit");
                faults.extend(exceeds(beyond, bound).then_some(words));
            }
        }
    }
    judged("S4", faults, unknown).value(worst).threshold(format!(
        "overshoot / bound < 1, the bound being {} of the range, {}",
        percent(PUSHED),
        moved(PUSHED_LEAST)
    ))
}

/// What the weight of all that a drive carries could do to it: N for a slide, N·m at the end of
/// what it carries for a turn. `None` where it has none.
fn weight(scene: &Scene, drive: usize) -> Option<f64> {
    let joint = &scene.robot.joints[scene.drives[drive].joint];
    let carried = (0..scene.robot.links.len()).filter(|&l| scene.robot.is_under(l, joint.child));
    let lump = Lump::of_links(scene.robot, carried, &scene.at_rest.links);
    let arm = lump.com.distance(scene.at_rest.links[joint.child].translation);
    let force = lump.mass * GRAVITY.length();
    let push = if joint.kind.turns() { force * arm.max(0.01 * scene.diagonal) } else { force };
    Some(push).filter(|push| push.is_finite() && *push > 0.0)
}

fn closed_forms(scene: &Scene) -> Check {
    let drives = 0..scene.drives.len();
    let swings: Vec<_> = drives.into_par_iter().map(|d| pendulum::swing(scene, d)).collect();
    let (mut faults, mut unknown, mut worst) = (Vec::new(), Vec::new(), 0f64);
    for (d, swing) in swings.into_iter().enumerate() {
        let name = scene.name(d);
        let Some(swing) = swing else {
            unknown.push(format!("joint `{name}` carries no sound mass"));
            continue;
        };
        worst = worst.max(swing.error());
        let (found, due) = (swing.measured, swing.expected);
        let words = format!("joint `{name}` ({:?}): {found:.4}, closed form {due:.4}", swing.by);
        faults.extend(exceeds(swing.error(), CLOSED_FORM).then_some(words));
    }
    judged("S5", faults, unknown).value(worst * 100.0)
}

/// Whether a figure lies above its bound; what is no number does.
fn exceeds(figure: f64, bound: f64) -> bool {
    figure > bound || figure.is_nan() || bound.is_nan()
}

fn judged(id: &str, faults: Vec<String>, unknown: Vec<String>) -> Check {
    if faults.is_empty() && !unknown.is_empty() {
        return Check::unknown(id, unknown.join("; "));
    }
    Check::from_faults(id, faults)
}

#[cfg(test)]
mod tests;
