//! The checks that need no motion: units, geometry, mass, joints (U, G, M1–M6, J1–J6).

use std::panic::{AssertUnwindSafe, catch_unwind};

use glamx::DVec3;
use rayon::prelude::*;

use crate::CheckOptions;
use crate::profile::{Group, RULES};
use crate::robot::{Joint, Robot};
use crate::study::Study;
use crate::verdict::Check;

mod collision;
mod cover;
mod floating;
pub(crate) mod inertia;
mod joints;
mod mass;
mod part;
pub(crate) mod surface;
#[cfg(test)]
mod tests;
mod units;
mod visual;
mod winding;

use part::{Part, Parts};

/// Runs every static check on a robot. A check that breaks down is unknown, not a pass.
pub fn checks(robot: &Robot, options: &CheckOptions) -> Vec<Check> {
    checks_of(&Study::new(robot), options)
}

/// The same, with what others make of the robot.
pub(crate) fn checks_of(study: &Study, options: &CheckOptions) -> Vec<Check> {
    // A panic in a geometry library must become a failed check, whatever the asset.
    match catch_unwind(AssertUnwindSafe(|| Parts::new(study))) {
        Err(_) => of_groups(|_| "the geometry could not be prepared: a library panicked"),
        Ok(parts) if parts.diagonal <= 0.0 => {
            let mut checks = of_groups(|_| "there is no geometry to check");
            checks.extend(guarded(&["J1", "J2", "J4"], || joints::numbers(study.robot)));
            checks
        }
        Ok(parts) => on_parts(&parts, options),
    }
}

/// Checks that share nothing but the parts they look at, and the ids they answer for.
type Task<'a> = (&'a [&'a str], Box<dyn Fn() -> Vec<Check> + Sync + 'a>);

fn on_parts(parts: &Parts, options: &CheckOptions) -> Vec<Check> {
    let seed = options.seed;
    let tasks: [Task; 8] = [
        (&["U1", "U2", "U3"], Box::new(|| units::checks(parts))),
        (&["G1"], Box::new(|| vec![visual::sound_surfaces(parts)])),
        (&["G2"], Box::new(|| vec![collision::sound_pieces(parts)])),
        (&["G3"], Box::new(|| vec![cover::cover(parts, seed)])),
        (&["G4"], Box::new(|| vec![floating::loose_pieces(parts)])),
        (&["M1", "M2", "M3", "M4", "M5", "M6"], Box::new(|| mass::checks(parts))),
        (&["J1", "J2", "J4"], Box::new(|| joints::numbers(parts.robot))),
        (&["J3", "J5", "J6"], Box::new(|| joints::geometry(parts))),
    ];
    let of_task = |(ids, run): &Task| guarded(ids, run);
    tasks.par_iter().with_max_len(1).map(of_task).collect::<Vec<_>>().concat()
}

/// The checks, or all of them unknown if they panic.
pub(crate) fn guarded(ids: &[&str], run: impl FnOnce() -> Vec<Check>) -> Vec<Check> {
    let reason = "the check itself broke down (a panic), so nothing is known";
    catch_unwind(AssertUnwindSafe(run))
        .unwrap_or_else(|_| ids.iter().map(|id| Check::unknown(id, reason)).collect())
}

/// Why the robot cannot be moved at all: an axis without direction, limits without order.
pub(crate) fn cannot_move(robot: &Robot) -> Option<String> {
    let fault = |j: &Joint| {
        let axis_fault = || (j.axis == DVec3::ZERO).then(|| "axis has no direction".to_owned());
        let fault = axis_fault().or_else(|| joints::limit_fault(j))?;
        Some(format!("joint `{}` cannot be moved: {fault}", j.name))
    };
    robot.joints.iter().filter(|j| j.kind.has_axis()).find_map(fault)
}

fn of_groups(reason: impl Fn(&str) -> &'static str) -> Vec<Check> {
    let is_mine = |g| matches!(g, Group::Units | Group::Geometry | Group::Mass | Group::Joints);
    let mine = RULES.iter().filter(|r| is_mine(r.group) && !["M7", "J7"].contains(&r.id));
    mine.map(|r| Check::unknown(r.id, reason(r.id))).collect()
}

/// A finding about one link or joint: how far it goes (1 is the bound), the figure, the words.
struct Finding {
    severity: f64,
    value: f64,
    unit: &'static str,
    words: String,
}

/// The worst finding gives the value; those beyond the bound (severity > 1) are the evidence,
/// worst first. `unread` parts make the check unknown unless it fails anyway.
fn judged(id: &str, mut findings: Vec<Finding>, unread: Vec<String>) -> Check {
    findings.sort_by(|a, b| b.severity.total_cmp(&a.severity));
    let worst = findings.first().map(|f| (f.value, f.unit));
    let broken: Vec<String> = findings
        .into_iter()
        .filter(|f| f.severity.is_nan() || f.severity > 1.0)
        .map(|f| f.words)
        .collect();
    let check = if broken.is_empty() && !unread.is_empty() {
        Check::unknown(id, "some geometry could not be read").evidences(unread)
    } else {
        Check::from_faults(id, broken)
    };
    match worst {
        Some((value, unit)) => check.value(value).unit(unit),
        None => check,
    }
}

/// Why a link's geometry is not all there, link by link.
fn unread(parts: &Parts) -> Vec<String> {
    let told = |p: &Part| p.unread().map(|reason| format!("link `{}`: {reason}", p.link.name));
    parts.parts.iter().filter_map(told).collect()
}

/// Millimetres with four digits.
fn mm(metres: f64) -> String {
    format!("{} mm", crate::verdict::figure(metres * 1e3))
}
