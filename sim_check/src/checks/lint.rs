//! The checks that need no motion: units, geometry, mass and joints (groups U and G, M1 to M6, J1
//! to J6 of the profile).
//!
//! ```
//! use sim_check::CheckOptions;
//! use sim_check::checks::lint;
//! let options = CheckOptions::default();
//! let text = r#"<robot name="die"><link name="die">
//!   <visual><geometry><box size="20 20 20"/></geometry></visual></link></robot>"#;
//! let robot = sim_check::read::load::from_text(text, ".".as_ref(), &options).robot.unwrap();
//! // Millimetres taken for metres: 35 m across.
//! let size = lint::checks(&robot, &options).into_iter().find(|c| c.id == "U2").unwrap();
//! assert!(!size.holds() && size.evidence[0].starts_with("diagonal 34.64 m"));
//! ```

use std::panic::{AssertUnwindSafe, catch_unwind};

use rayon::prelude::*;

use crate::checks::study::Study;
use crate::options::CheckOptions;
use crate::profile::{Group, RULES};
use crate::robot::Robot;
use crate::verdict::Check;

mod collision;
mod cover;
mod finding;
mod floating;
mod joints;
mod mass;
mod part;
pub(crate) mod surface;
#[cfg(test)]
mod tests;
mod units;
mod visual;
mod winding;

pub use mass::{Filled, filled};
use part::Parts;

/// Runs every static check on a robot. A check that breaks down is unknown, not a pass.
pub fn checks(robot: &Robot, options: &CheckOptions) -> Vec<Check> {
    checks_of(&Study::new(robot), options)
}

/// The same, with what others make of the robot.
pub(crate) fn checks_of(study: &Study, options: &CheckOptions) -> Vec<Check> {
    // A panic in a geometry library must become a failed check, whatever the asset.
    match catch_unwind(AssertUnwindSafe(|| Parts::new(study))) {
        Err(_) => of_groups(|_| "the geometry could not be prepared: a library panicked"),
        Ok(parts) if parts.diagonal <= 0.0 => without_geometry(&parts, study),
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
        (&["J1", "J2", "J4"], Box::new(|| joints::numbers(parts.robot, parts.subject))),
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

/// Where nothing is seen or touched, or nothing of it can be had: what asks for numbers alone is
/// judged all the same.
fn without_geometry(parts: &Parts, study: &Study) -> Vec<Check> {
    let broken = collision::broken(parts);
    let why = parts.parts.iter().find_map(|p| {
        let reason = p.unread()?;
        Some(format!("there is no geometry to check: link `{}`: {reason}", p.link.name))
    });
    let why = why.unwrap_or_else(|| "there is no geometry to check".into());
    let mut checks: Vec<Check> =
        guarded(&["J1", "J2", "J4"], || joints::numbers(study.robot, study.subject));
    checks.extend(guarded(&["M1", "M3", "M6"], || mass::numbers(parts)));
    if !broken.is_empty() {
        checks.push(Check::from_faults("G2", broken));
    }
    let rest = of_groups(|_| why.clone());
    let missing: Vec<Check> =
        rest.into_iter().filter(|c| checks.iter().all(|known| known.id != c.id)).collect();
    checks.extend(missing);
    checks
}

fn of_groups<R: Into<String>>(reason: impl Fn(&str) -> R) -> Vec<Check> {
    let is_mine = |g| matches!(g, Group::Units | Group::Geometry | Group::Mass | Group::Joints);
    let mine = RULES.iter().filter(|r| is_mine(r.group) && !["M7", "J7"].contains(&r.id));
    mine.map(|r| Check::unknown(r.id, reason(r.id))).collect()
}
