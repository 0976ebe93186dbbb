//! Runs the checks in order: read the file, look at the robot at rest, move it, conclude.

use std::path::Path;

use crate::checks::study::Study;
use crate::checks::{dynamics, kinematic, lint, sidecar};
use crate::options::CheckOptions;
use crate::profile::{Group, RULES, Tier};
use crate::read::load::{self, Loaded};
use crate::robot::Robot;
use crate::verdict::{self, Check, Verdict};

/// Checks a URDF, or an MJCF model, and everything it refers to. Never panics, never errs; the same file, options and
/// version give the same verdict.
///
/// ```
/// use sim_check::{CheckOptions, Tier, check};
/// let verdict = check("no/such.urdf".as_ref(), &CheckOptions::default());
/// assert_eq!(verdict.tier, Tier::None);
/// assert!(verdict.failures().next().unwrap().evidence[0].contains("cannot be opened"));
/// ```
pub fn check(urdf: &Path, options: &CheckOptions) -> Verdict {
    let mut loaded = guarded_read(urdf, options);
    loaded.checks.extend(match &loaded.robot {
        Some(robot) => on_robot(robot, urdf, options),
        None => unread(),
    });
    concluded(loaded, options)
}

/// The verdict on a URDF whose check did not come to an end, for this reason: everything is unknown.
///
/// For callers that check in another process and had to stop it, or saw it die.
pub fn undecided(reason: &str, options: &CheckOptions) -> Verdict {
    let rules = RULES.iter().filter(|r| verdict::applies(r, options));
    let checks = rules.map(|r| Check::unknown(r.id, reason)).collect();
    concluded(Loaded { checks, ..Loaded::default() }, options)
}

fn concluded(loaded: Loaded, options: &CheckOptions) -> Verdict {
    let mut checks = verdict::complete(loaded.checks, options);
    verdict::waive(&mut checks, &options.waivers);
    Verdict {
        profile: verdict::PROFILE.into(),
        tier: verdict::tier_of(&checks, options.up_to),
        asked: options.up_to,
        robot: loaded.name,
        urdf_blake3: loaded.blake3,
        links: loaded.links,
        moving_joints: loaded.moving_joints,
        seed: options.seed,
        counts: verdict::count(&checks),
        checks,
    }
}

/// A file that makes the reader itself break down is an unreadable file.
fn guarded_read(urdf: &Path, options: &CheckOptions) -> Loaded {
    std::panic::catch_unwind(|| load::read(urdf, options)).unwrap_or_else(|_| {
        let checks = vec![Check::unknown("F1", "the reader broke down (a panic)")];
        Loaded { checks, ..Loaded::default() }
    })
}

/// What follows when there is no robot to check.
fn unread() -> Vec<Check> {
    let later = |g| !matches!(g, Group::Files | Group::Tree | Group::Right);
    let reason = "the file could not be read as one robot (see F1, T1, T2)";
    let rules = RULES.iter().filter(|r| later(r.group) || r.id == "F4");
    rules.map(|r| Check::unknown(r.id, reason)).collect()
}

/// J7, where the joints can move.
fn hold(robot: &Robot, options: &CheckOptions) -> Check {
    match lint::cannot_move(robot) {
        Some(reason) => Check::unknown("J7", reason),
        None => dynamics::hold(robot, options),
    }
}

fn on_robot(robot: &Robot, urdf: &Path, options: &CheckOptions) -> Vec<Check> {
    let study = Study::new(robot);
    let (mut checks, moved) =
        rayon::join(|| at_rest(&study, urdf, options), || in_motion(&study, options));
    checks.extend(moved);
    checks
}

/// The checks that need no motion.
fn at_rest(study: &Study, urdf: &Path, options: &CheckOptions) -> Vec<Check> {
    let (robot, mut checks) = (study.robot, Vec::new());
    if options.up_to >= Tier::Static {
        checks.extend(lint::checks_of(study, options));
        checks.extend(lint::guarded(&["J7"], || vec![hold(robot, options)]));
        let ids = ["F4", "M7", "L1", "L2", "P1", "P2", "P3"];
        checks.extend(lint::guarded(&ids, || sidecar::checks(study, urdf, &options.provenance)));
    }
    checks
}

/// The checks that move the robot; what its joints make impossible is unknown.
fn in_motion(study: &Study, options: &CheckOptions) -> Vec<Check> {
    let of_group = |g| RULES.iter().filter(move |r| r.group == g).map(|r| r.id).collect::<Vec<_>>();
    let (robot, mut checks) = (study.robot, Vec::new());
    if options.up_to >= Tier::Kinematic {
        checks.extend(match lint::cannot_move(robot) {
            Some(reason) => verdict::all_unknown(Group::Contact, &reason),
            None => {
                lint::guarded(&of_group(Group::Contact), || kinematic::checks_of(study, options))
            }
        });
    }
    if options.up_to >= Tier::Dynamic {
        let rest_is_clean = checks.iter().any(|c| c.id == "C1" && c.holds());
        checks.extend(match lint::cannot_move(robot) {
            Some(reason) => verdict::all_unknown(Group::Simulation, &reason),
            None => lint::guarded(&of_group(Group::Simulation), || {
                dynamics::checks_of(study, options, rest_is_clean)
            }),
        });
    }
    checks
}
