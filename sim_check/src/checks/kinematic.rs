//! Whether parts overlap at rest or on their way, stay attached, and open outwards (group C of the
//! profile).
//!
//! ```
//! use sim_check::checks::kinematic;
//! use sim_check::{CheckOptions, Status};
//! let options = CheckOptions::default();
//! let text = r#"<robot name="bare"><link name="base"/></robot>"#;
//! let robot = sim_check::read::load::from_text(text, ".".as_ref(), &options).robot.unwrap();
//! // What has no colliders touches nothing, which is no pass.
//! let checks = kinematic::checks(&robot, &options);
//! assert!(checks.len() == 5 && checks.iter().all(|c| c.status == Status::Unknown));
//! ```

use rayon::prelude::*;

use crate::checks::study::Study;
use crate::checks::sweep::Scene;
use crate::checks::sweep::advance::{Side, TooMuchWork, step, sweep};
use crate::checks::sweep::guide::{Hold, gap_bound, hold};
use crate::checks::sweep::overlap::{Overlap, overlaps};
use crate::checks::sweep::seen::Skins;
use crate::checks::sweep::together::{Meeting, RANDOM_CONFIGURATIONS, meetings};
use crate::options::CheckOptions;
use crate::profile::bounds::{FARTHER, SLIDE_KEEPS, SOON};
use crate::profile::words::percent;
use crate::profile::{Group, Tier};
use crate::robot::Robot;
use crate::verdict::{Check, MAX_EVIDENCE, all_unknown};

/// C1 to C5; all unknown if a collider is missing or a joint cannot be moved.
pub fn checks(robot: &Robot, options: &CheckOptions) -> Vec<Check> {
    checks_of(&Study::new(robot), options)
}

/// The same, with what others make of the robot.
pub(crate) fn checks_of(study: &Study, options: &CheckOptions) -> Vec<Check> {
    let run = || run(study, options);
    std::panic::catch_unwind(run).unwrap_or_else(|_| {
        all_unknown(Group::Contact, "a geometry query failed on this asset's numbers")
    })
}

fn run(study: &Study, options: &CheckOptions) -> Vec<Check> {
    if options.up_to < Tier::Kinematic {
        return Vec::new();
    }
    let scene = match study.scene() {
        Ok(scene) => scene,
        Err(fault) => return all_unknown(Group::Contact, &fault.to_string()),
    };
    let swept: Result<Vec<Swept>, TooMuchWork> = (0..scene.drives.len())
        .into_par_iter()
        .with_max_len(1)
        .map(|d| Swept::new(scene, d))
        .collect();
    let (along, outward) = match &swept {
        Ok(swept) => (along_ranges(scene, swept), outward(scene, swept)),
        Err(e) => ["C2", "C5"].map(|id| Check::unknown(id, e.to_string())).into(),
    };
    let together = together(scene, options.seed);
    let attached = attached(scene, study);
    let held: Vec<String> = scene.missing.iter().chain(&scene.held).cloned().collect();
    let moved = [along, together, attached, outward].map(|check| known_but(check, &held));
    std::iter::once(known_but(at_rest(scene), &scene.missing)).chain(moved).collect()
}

/// A check that holds of what could be looked at is unknown where that was not all.
pub(crate) fn known_but(check: Check, missing: &[String]) -> Check {
    match check.holds() && !missing.is_empty() {
        true => Check::unknown(&check.id, missing.join("; ")),
        false => check,
    }
}

/// A joint swept to both ends.
struct Swept {
    lower: Side,
    upper: Side,
    lower_end: f64,
    upper_end: f64,
}

impl Swept {
    fn new(scene: &Scene, drive: usize) -> Result<Self, TooMuchWork> {
        let of = &scene.drives[drive];
        let lower = sweep(scene, drive, of.lower)?;
        let upper = sweep(scene, drive, of.upper)?;
        let [lower_end, upper_end] = [of.lower, of.upper];
        Ok(Self { lower, upper, lower_end, upper_end })
    }

    fn all(&self) -> impl Iterator<Item = &(Overlap, f64)> {
        self.lower.worst.iter().chain(&self.upper.worst)
    }

    /// Whether something overlaps before the joint has moved.
    fn is_stuck(&self) -> bool {
        [&self.lower, &self.upper].iter().any(|s| s.first_hit == Some(0.0))
    }

    /// The side that is opened further, and the sign of it.
    fn main(&self) -> (&Side, f64) {
        if self.upper_end >= -self.lower_end { (&self.upper, 1.0) } else { (&self.lower, -1.0) }
    }
}

fn millimetres(metres: f64) -> String {
    format!("{:.2} mm", metres * 1000.0)
}

fn pair(scene: &Scene, overlap: &Overlap) -> String {
    let [a, b] = overlap.pieces.map(|p| scene.label(p));
    format!("{a} and {b} overlap by {}", millimetres(overlap.depth))
}

/// What was found, the deepest first. Only what is kept as evidence is put into words: bodies thrown
/// together overlap in millions of ways.
fn depth_check<T>(
    id: &str,
    scene: &Scene,
    found: &[(f64, T)],
    say: impl Fn(&T) -> String,
) -> Check {
    let worst = found.first().map_or(0.0, |f| f.0);
    let bad = found.iter().filter(|f| f.0 > scene.bound()).enumerate();
    let words = |(i, (_, what)): (usize, &(f64, T))| match i < MAX_EVIDENCE {
        true => say(what),
        false => String::new(),
    };
    let bad = bad.map(words);
    let bound = millimetres(scene.bound());
    Check::from_faults(id, bad).value(worst * 1000.0).threshold(format!("depth <= {bound}"))
}

fn at_rest(scene: &Scene) -> Check {
    let found = match &scene.met {
        Some(met) => met.iter().map(|&(pieces, depth)| Overlap { pieces, depth }).collect(),
        None => overlaps(scene, &scene.rest(), |_, _| true),
    };
    let found: Vec<_> = found.into_iter().map(|o| (o.depth, o)).collect();
    depth_check("C1", scene, &found, |o| pair(scene, o))
}

fn along_ranges(scene: &Scene, swept: &[Swept]) -> Check {
    let mut found = Vec::new();
    for (drive, swept) in swept.iter().enumerate() {
        found.extend(swept.all().map(|(overlap, q)| (overlap.depth, (drive, overlap, *q))));
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let words = |&(drive, overlap, q): &(usize, &Overlap, f64)| {
        let (joint, at) = (scene.name(drive), scene.shown(drive, q));
        format!("joint `{joint}` at {at}: {}", pair(scene, overlap))
    };
    let say = |m: f64| format!("looked at least every {} of tip motion", millimetres(m));
    depth_check("C2", scene, &found, words).evidence(say(step(scene)))
}

fn together(scene: &Scene, seed: u64) -> Check {
    let Some(found) = meetings(scene, seed) else {
        return Check::unknown("C3", "too many joints to look at every pair of them");
    };
    let moved = |m: &Meeting| {
        let one = |&(d, q): &(usize, f64)| format!("`{}` at {}", scene.name(d), scene.shown(d, q));
        m.moved.iter().map(one).collect::<Vec<_>>().join(", ")
    };
    let say = |m: &&Meeting| format!("{}: {}", moved(m), pair(scene, &m.overlap));
    let found: Vec<_> = found.iter().map(|m| (m.overlap.depth, m)).collect();
    depth_check("C3", scene, &found, say).evidence(format!(
        "looked at the corners of every pair of joints and {RANDOM_CONFIGURATIONS} random poses"
    ))
}

fn attached<'a>(scene: &Scene<'a>, study: &Study<'a>) -> Check {
    let mut unknown = Vec::new();
    let mut faults = Vec::new();
    let mut worst = 0f64;
    let skins = Skins::new(scene, study);
    let drives = (0..scene.drives.len()).into_par_iter();
    let holds: Vec<_> = drives.map(|d| hold(scene, &skins, d)).collect();
    for (drive, held) in holds.into_iter().enumerate() {
        let joint = scene.name(drive);
        let at = |q| scene.shown(drive, q);
        match held {
            None => unknown.push(format!("joint `{joint}` has no colliders on both sides")),
            Some(Hold::GapGrowth { metres, due, at: q }) => {
                let bound = gap_bound(scene) + due;
                worst = worst.max(metres / bound);
                let gap = millimetres(metres);
                let fault =
                    format!("joint `{joint}`: the gap to its parent grows by {gap} at {}", at(q));
                faults.extend((metres > bound).then_some(fault));
            }
            Some(Hold::Overlap { share, at: q }) => {
                worst = worst.max(SLIDE_KEEPS / share.max(1e-9));
                let share = share * 100.0;
                let fault = format!("joint `{joint}` keeps {share:.1} % in its guide at {}", at(q));
                faults.extend((share < 100.0 * SLIDE_KEEPS).then_some(fault));
            }
        }
    }
    let bound = millimetres(gap_bound(scene));
    let check = match unknown.is_empty() || !faults.is_empty() {
        true => Check::from_faults("C4", faults).value(worst),
        false => Check::unknown("C4", unknown.join("; ")),
    };
    let keeps = percent(SLIDE_KEEPS);
    check.threshold(format!(
        "worst / bound <= 1, where a hinge's gap may grow by {bound} and a slide keeps {keeps} inside"
    ))
}

fn outward(scene: &Scene, swept: &[Swept]) -> Check {
    let found: Result<Vec<_>, TooMuchWork> =
        (0..swept.len()).into_par_iter().map(|d| way(scene, d, &swept[d])).collect();
    let stuck: Vec<_> = (0..swept.len()).filter(|&d| swept[d].is_stuck()).collect();
    if let Some(&d) = stuck.first() {
        let joint = scene.name(d);
        return Check::unknown("C5", format!("joint `{joint}` is stuck in an overlap at rest"));
    }
    let found = match found {
        Ok(found) => found,
        Err(e) => return Check::unknown("C5", e.to_string()),
    };
    let (mut worst, mut faults, mut unknown) = (None, Vec::new(), Vec::new());
    for (drive, way) in found.iter().enumerate() {
        match way {
            Way::Unseen => unknown.push(unseen(scene, drive)),
            Way::Either => {}
            Way::Free => worst = Some(f64::max(worst.unwrap_or(0.0), 1.0)),
            Way::Meets { hit, free, soon } => {
                let times = free / hit.max(f64::MIN_POSITIVE);
                worst = Some(f64::max(worst.unwrap_or(0.0), times));
                faults.extend((*soon && *free >= FARTHER * hit).then(|| {
                    let [hit, free] = [*hit, *free].map(|q| scene.shown(drive, q));
                    let joint = scene.name(drive);
                    format!(
                        "joint `{joint}` collides after {hit} the way it opens, but is free for \
                         {free} the other way"
                    )
                }));
            }
        }
    }
    let check = match unknown.is_empty() || !faults.is_empty() {
        true => Check::from_faults("C5", faults),
        false => Check::unknown("C5", unknown.join("; ")),
    };
    worst.map_or(check.clone(), |worst| check.value(worst))
}

fn unseen(scene: &Scene, drive: usize) -> String {
    format!("joint `{}` has no colliders on both sides", scene.name(drive))
}

/// How free a joint is the way it opens.
enum Way {
    /// Nothing can be met: there are no colliders on both sides.
    Unseen,
    /// It goes both ways, or round and round: no way is the one it opens.
    Either,
    /// As far as it opens.
    Free,
    /// It meets something after `hit` of its range, and is free for `free` the other way; `soon` if that is
    /// in the first half of its range.
    Meets { hit: f64, free: f64, soon: bool },
}

/// Compares the side a joint is opened to with the other.
fn way(scene: &Scene, drive: usize, swept: &Swept) -> Result<Way, TooMuchWork> {
    if scene.guide_body(drive).is_none() || scene.carried_bodies(drive).is_empty() {
        return Ok(Way::Unseen);
    }
    let (side, sign) = swept.main();
    let other_declared = if sign > 0.0 { -swept.lower_end } else { swept.upper_end };
    let range = side.end.abs();
    if scene.drives[drive].continuous || range <= 0.0 {
        return Ok(Way::Either);
    }
    let Some(hit) = side.first_hit.map(f64::abs) else {
        let goes_both_ways = other_declared >= range;
        return Ok(if goes_both_ways { Way::Either } else { Way::Free });
    };
    if hit <= other_declared {
        return Ok(Way::Either);
    }
    let soon = hit <= SOON * range;
    if !soon {
        // What it meets late says nothing about the way it opens.
        return Ok(Way::Meets { hit, free: hit, soon });
    }
    let mirrored = sweep(scene, drive, -sign * range)?;
    Ok(Way::Meets { hit, free: mirrored.first_hit.map_or(range, f64::abs), soon })
}
