//! A URDF (or MJCF) on disk to a verdict: reads the file as a simulator would, whoever wrote it, and says
//! what holds and what does not (profile simready-urdf 1.0).
//!
//! [`check`] is the door: it never panics and never errs. What could not be decided is `unknown`,
//! and unknown is a failure.

pub mod advice;
pub mod caps;
mod convex;
pub mod dynamics;
pub mod junit;
pub mod kinematic;
pub mod lint;
pub mod load;
pub mod meshes;
mod mjcf;
pub mod near;
pub mod parse;
pub mod profile;
mod reader;
pub mod robot;
pub mod stl;
pub mod sweep;
pub mod verdict;

mod sidecar;
mod study;
mod tessellate;

pub use meshes::Outside;
pub use robot::Robot;
pub use verdict::{Check, Severity, Status, Tier, Verdict};

use std::collections::BTreeMap;
use std::path::Path;

use load::Loaded;
use profile::{Group, RULES};
use study::Study;

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
    let applies = |id: &str| id != "T4" || options.expected.is_some();
    let rules = RULES.iter().filter(|r| applies(r.id));
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
    let later = |g| !matches!(g, Group::Files | Group::Tree);
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
        checks.extend(lint::guarded(&ids, || sidecar::checks(robot, urdf, &options.provenance)));
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

/// What to check and what is known besides the file.
#[derive(Clone, Debug)]
pub struct CheckOptions {
    /// Seed of every random choice.
    pub seed: u64,
    /// The highest tier to check for; more costs more time.
    pub up_to: Tier,
    /// Counts the kinematic condition promises; without it T4 does not apply.
    pub expected: Option<Expected>,
    /// What the caller knows of the asset's provenance; without it P1 and P2 are unknown.
    pub provenance: Provenance,
    /// Failures somebody answers for: id of the check to reason. They stand in the verdict and do
    /// not lower the tier. What is unknown cannot be waived.
    pub waivers: BTreeMap<String, String>,
    /// Whether meshes may lie outside the URDF's folder.
    pub outside: Outside,
}

/// Counts a kinematic condition promises.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Expected {
    /// Parts; links with visual or collision geometry.
    pub links: usize,
    /// Joints that move.
    pub joints: usize,
}

/// What only the caller can know: this crate reads no traces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Provenance {
    /// What a reader of the trace found wrong with it; empty if it is complete. `None`: nobody
    /// read it.
    pub trace_faults: Option<Vec<String>>,
    /// Licences (SPDX names, lower case) that the policy allows. `None`: no policy given.
    pub allowed_licences: Option<Vec<String>>,
}

impl Default for CheckOptions {
    /// Seed 0, everything up to `audited`, no expectations, no waivers, nothing outside.
    fn default() -> Self {
        Self {
            seed: 0,
            up_to: Tier::Audited,
            expected: None,
            provenance: Provenance::default(),
            waivers: BTreeMap::new(),
            outside: Outside::default(),
        }
    }
}
