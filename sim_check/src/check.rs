//! Runs the checks in order: read the file, look at the robot at rest, move it, conclude.

use std::panic::AssertUnwindSafe;
use std::path::Path;

use crate::checks::study::Study;
use crate::checks::{dynamics, kind, kinematic, lint, sidecar};
use crate::options::{Asked, CheckOptions};
use crate::profile::subject::{Base, Judged, Subject};
use crate::profile::{Group, RULES, Tier};
use crate::read::load::{self, Edition, Loaded};
use crate::robot::{Beside, Robot};
use crate::verdict::{self, Check, Status, Verdict};

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
    of_loaded(guarded_read(|| load::read(urdf, options)), urdf, options).0
}

/// Checks what might stand in a file instead of what does; the robot comes along, where there is one.
pub fn check_edition(
    urdf: &Path,
    edition: &Edition,
    options: &CheckOptions,
) -> (Verdict, Option<Robot>) {
    of_loaded(guarded_read(|| load::read_edition(urdf, edition, options)), urdf, options)
}

fn of_loaded(mut loaded: Loaded, urdf: &Path, options: &CheckOptions) -> (Verdict, Option<Robot>) {
    let judged = judged(&loaded, options);
    loaded.checks.extend(match &loaded.robot {
        Some(robot) => on_robot(robot, urdf, options, &judged),
        None => unread(),
    });
    concluded(loaded, options, judged)
}

/// The verdict on a URDF whose check did not come to an end, for this reason: everything is unknown.
///
/// For callers that check in another process and had to stop it, or saw it die.
pub fn undecided(reason: &str, options: &CheckOptions) -> Verdict {
    let rules = RULES.iter().filter(|r| verdict::applies(r, options));
    let checks = rules.map(|r| Check::unknown(r.id, reason)).collect();
    let loaded = Loaded { checks, ..Loaded::default() };
    let judged = judged(&loaded, options);
    concluded(loaded, options, judged).0
}

/// What a model is judged as: as asked, or as found; what could not be read is an object.
fn judged(loaded: &Loaded, options: &CheckOptions) -> Judged {
    let found = loaded.robot.as_ref().map(kind::found);
    let unread = || Judged {
        subject: Subject::Object,
        base: Base::Free,
        because: "it could not be read".into(),
    };
    let mut judged = found.unwrap_or_else(unread);
    match options.subject {
        Asked::Asset => judged.subject = Subject::Object,
        Asked::As(subject) => {
            (judged.subject, judged.because) = (subject, "it was asked for".into());
        }
        Asked::Found => {}
    }
    judged.base = options.base.unwrap_or(judged.base);
    judged
}

fn concluded(loaded: Loaded, options: &CheckOptions, judged: Judged) -> (Verdict, Option<Robot>) {
    let mut checks = verdict::complete(loaded.checks, options, judged.subject);
    if let Some(robot) = &loaded.robot {
        beside(&mut checks, &robot.beside);
    }
    verdict::waive(&mut checks, &options.waivers);
    let verdict = Verdict {
        profile: verdict::PROFILE.into(),
        judged: (options.subject != Asked::Asset).then_some(judged),
        tier: verdict::tier_of(&checks, options.up_to),
        asked: options.up_to,
        robot: loaded.name,
        urdf_blake3: loaded.blake3,
        links: loaded.links,
        moving_joints: loaded.moving_joints,
        seed: options.seed,
        counts: verdict::count(&checks),
        checks,
    };
    (verdict, loaded.robot)
}

/// A file that makes the reader itself break down is an unreadable file.
fn guarded_read(read: impl FnOnce() -> Loaded) -> Loaded {
    std::panic::catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|_| {
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

fn on_robot(robot: &Robot, urdf: &Path, options: &CheckOptions, judged: &Judged) -> Vec<Check> {
    // Of an asset that only its file describes the root's name says whether it is fixed.
    let base = if options.subject == Asked::Asset { options.base } else { Some(judged.base) };
    let mut study = Study::of(robot, judged.subject, base);
    study.is_rest_waived = options.waivers.contains_key("C1");
    let (mut checks, moved) =
        rayon::join(|| at_rest(&study, urdf, options), || in_motion(&study, options));
    checks.extend(moved);
    checks
}

/// The checks that need no motion.
fn at_rest(study: &Study, urdf: &Path, options: &CheckOptions) -> Vec<Check> {
    let mut checks = Vec::new();
    if options.up_to >= Tier::Static {
        checks.extend(lint::checks_of(study, options));
        checks.extend(lint::guarded(&["J7"], || vec![dynamics::hold(study.robot, options)]));
        let ids = ["F4", "M7", "L1", "L2", "P1", "P2", "P3"];
        checks.extend(lint::guarded(&ids, || sidecar::checks(study, urdf, &options.provenance)));
    }
    checks
}

/// The checks that move the robot.
fn in_motion(study: &Study, options: &CheckOptions) -> Vec<Check> {
    let of_group = |g| RULES.iter().filter(move |r| r.group == g).map(|r| r.id).collect::<Vec<_>>();
    let mut checks = Vec::new();
    if options.up_to >= Tier::Kinematic {
        let run = || kinematic::checks_of(study, options);
        checks.extend(lint::guarded(&of_group(Group::Contact), run));
    }
    if options.up_to >= Tier::Dynamic {
        let unfit = unfit(study, &checks);
        let run = || dynamics::checks_of(study, options, unfit.as_deref());
        checks.extend(lint::guarded(&of_group(Group::Simulation), run));
    }
    checks
}

/// Why what is at rest cannot be simulated. What overlaps in a robot at rest is left alone, and
/// what somebody answers for.
fn unfit(study: &Study, checks: &[Check]) -> Option<String> {
    let at_rest = checks.iter().find(|c| c.id == "C1")?;
    match at_rest.status {
        _ if study.leaves_rest() => None,
        Status::Fail => {
            Some("C1 does not hold: parts that overlap at rest would be flung apart".into())
        }
        Status::Unknown => {
            let why = at_rest.evidence.first().map_or("", String::as_str);
            Some(format!("C1 is unknown, so whether anything is flung apart is, too: {why}"))
        }
        Status::Pass | Status::Warn => None,
    }
}

/// What a file says beside its links and joints: checks that depend on what was not read are
/// unknown, and what a person should look at is told.
fn beside(checks: &mut [Check], beside: &Beside) {
    for check in checks.iter_mut() {
        let depends = beside.unread.iter().filter(|u| u.checks.contains(&check.id.as_str()));
        let reasons: Vec<&str> = depends.map(|u| u.what.as_str()).collect();
        if !reasons.is_empty() && check.status != Status::Unknown {
            let severity = check.severity;
            *check = Check { severity, ..Check::unknown(&check.id, reasons.join("; ")) };
        }
        let mine = beside.flags.iter().filter(|(id, _)| *id == check.id);
        let words: Vec<String> = mine.map(|(_, words)| words.clone()).collect();
        if !words.is_empty() && check.holds() {
            check.status = Status::Warn;
            *check = check.clone().evidences(words);
        }
    }
}
