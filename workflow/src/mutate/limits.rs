//! Limits, drives and what joints resist: `limits-…`, `range-into-body`, `effort-zero` and the like.

use std::f64::consts::{PI, TAU};

use glamx::DPose3;
use sim_check::read::source::{At, Edit};
use sim_check::robot::Motion;
use sim_check::verdict::figure;

use super::language::Language;
use super::model::{Model, Mover, quoted};
use super::planted::{Made, first, made};
use super::touch::Solids;
use crate::fix::numbers::short;

/// How deep parts must stand in each other to count, as a share of the model's diagonal, and at least,
/// metres; guesses, a few times what contact of sound parts shows.
const DEEP: (f64, f64) = (0.01, 0.005);
/// Steps in which a range is made longer.
const STEPS: usize = 48;

/// How deep is deep for a model.
pub(super) fn deep(model: &Model) -> Result<f64, String> {
    Ok(DEEP.1.max(DEEP.0 * model.diagonal()?))
}

const NO_RANGE: &str = "no joint has a range of its own in this file";

/// The element with the limits of a joint, in SDF below its axis.
fn limit_at(model: &Model, mover: &Mover) -> Result<At, String> {
    match model.language {
        Language::Urdf => model.child_of(mover.at, "limit"),
        Language::Mjcf => Ok(mover.at),
        Language::Sdf => model.child_of(model.child_of(mover.at, "axis")?, "limit"),
    }
}

/// The edits that write another range.
fn range(model: &Model, mover: &Mover, [lower, upper]: [&str; 2]) -> Result<Vec<Edit>, String> {
    let at = limit_at(model, mover)?;
    Ok(match model.language {
        Language::Urdf => {
            vec![model.source.set(at, "lower", lower), model.source.set(at, "upper", upper)]
        }
        Language::Mjcf => vec![model.source.set(at, "range", &format!("{lower} {upper}"))],
        Language::Sdf => match (model.source.child(at, "lower"), model.source.child(at, "upper")) {
            (Some(low), Some(up)) => vec![
                model.source.replace(low, format!("<lower>{lower}</lower>")),
                model.source.replace(up, format!("<upper>{upper}</upper>")),
            ],
            _ => return Err("its limits are not both told".into()),
        },
    })
}

fn retold(model: &Model, word: &str, of: impl Fn(&Mover, [f64; 2]) -> Option<[f64; 2]>) -> Made {
    first(model.ranged(word), NO_RANGE, |(mover, was)| {
        let new = of(&mover, was).ok_or("no joint has a range that this would make wrong")?;
        written(model, &mover, was, new.map(|v| model.told(mover.joint, v)))
    })
}

fn written(model: &Model, mover: &Mover, was: [f64; 2], new: [String; 2]) -> Made {
    let old = was.map(|v| model.told(mover.joint, v));
    let edits = range(model, mover, [&new[0], &new[1]])?;
    let words = format!("limits {} to {} (were {} to {})", new[0], new[1], old[0], old[1]);
    made(quoted("joint", &mover.joint.name), mover.joint.line, words, edits)
}

pub(super) fn swapped(model: &Model, word: &str) -> Made {
    retold(model, word, |_, [lower, upper]| Some([upper, lower]))
}

pub(super) fn empty(model: &Model, word: &str) -> Made {
    retold(model, word, |_, _| Some([0.0, 0.0]))
}

/// Past rest by a fifth of itself.
pub(super) fn without_rest(model: &Model, word: &str) -> Made {
    retold(model, word, |_, [lower, upper]| {
        let span = upper - lower;
        Some([0.2 * span, 1.2 * span])
    })
}

pub(super) fn degrees(model: &Model, word: &str) -> Made {
    retold(model, word, |mover, [lower, upper]| {
        // What stays within two turns could be meant.
        let is_far = (upper - lower).to_degrees() > 2.0 * TAU;
        (mover.joint.kind == Motion::Revolute && is_far)
            .then(|| [lower.to_degrees(), upper.to_degrees()])
    })
}

pub(super) fn infinite(model: &Model, word: &str) -> Made {
    first(model.ranged(word), NO_RANGE, |(mover, was)| {
        let lower = model.told(mover.joint, was[0]);
        written(model, &mover, was, [lower, "inf".into()])
    })
}

pub(super) fn missing(model: &Model, word: &str) -> Made {
    first(model.ranged(word), NO_RANGE, |(mover, _)| {
        let edit = match model.language {
            Language::Mjcf => {
                let gone = model.source.unset(mover.at, "range");
                gone.ok_or("its range stands in a class")?
            }
            _ => model.source.remove(limit_at(model, &mover)?),
        };
        made(quoted("joint", &mover.joint.name), mover.joint.line, "limits left out", vec![edit])
    })
}

/// A range that goes on until the part stands deep in its neighbour, by one turn or its own length.
pub(super) fn into_body(model: &Model, word: &str) -> Made {
    let (bound, solids) = (deep(model)?, Solids::of(&model.robot));
    let none = "no joint's part meets another one when it goes on";
    first(model.ranged(word), NO_RANGE, |(mover, was)| {
        let (joint, child) = (mover.joint, mover.joint.child);
        if joint.rest != 0.0 {
            return Err("it is not told from where it stands at rest".into());
        }
        let depth = |q: f64| solids.depth(joint, joint.origin, joint.motion(q));
        if depth(0.0).max(depth(was[0])).max(depth(was[1])) > 0.2 * bound {
            return Err("its part stands in another one already".into());
        }
        let most = match joint.kind.turns() {
            true => TAU - (was[1] - was[0]),
            false => model.bounds(child).map_or(0.0, |b| b.size().dot(joint.axis.abs())),
        };
        for k in 1..=STEPS {
            let more = most * k as f64 / STEPS as f64;
            for (end, q) in [(0, was[0] - more), (1, was[1] + more)] {
                if q.abs() <= PI.max(most) && depth(q) > bound {
                    let mut new = was.map(|v| model.told(joint, v));
                    let told: f64 = figure(q).parse().unwrap_or(q);
                    new[end] = model.told(joint, told);
                    return written(model, &mover, was, new);
                }
            }
        }
        Err(none.into())
    })
}

/// A number of a joint's drive or of what it resists.
fn number(model: &Model, word: &str, (limit, name, told): (bool, [&'static str; 3], &str)) -> Made {
    first(model.movers(word), "no joint moves", |mover| {
        let source = &model.source;
        let edit = match (model.language, limit) {
            (Language::Urdf, true) => source.set(model.child_of(mover.at, "limit")?, name[0], told),
            (Language::Urdf, false) => match source.child(mover.at, "dynamics") {
                Some(at) => source.set(at, name[0], told),
                None => {
                    source.insert_last(mover.at, &format!("<dynamics {}=\"{told}\"/>", name[0]))
                }
            },
            (Language::Mjcf, _) => source.set(mover.at, name[1], told),
            (Language::Sdf, _) => {
                let axis = model.child_of(mover.at, "axis")?;
                let tag = if limit { "limit" } else { "dynamics" };
                match source.child(axis, tag) {
                    Some(at) => model.text(at, name[2], told),
                    None => source.insert_last(
                        axis,
                        &format!("<{tag}>\n\t<{0}>{told}</{0}>\n</{tag}>", name[2]),
                    ),
                }
            }
        };
        let words = format!("{} {told}", name[0]);
        made(quoted("joint", &mover.joint.name), mover.joint.line, words, vec![edit])
    })
}

pub(super) fn effort(model: &Model, word: &str) -> Made {
    number(model, word, (true, ["effort", "", "effort"], "0"))
}

pub(super) fn velocity(model: &Model, word: &str) -> Made {
    number(model, word, (true, ["velocity", "", "velocity"], "0"))
}

pub(super) fn damping(model: &Model, word: &str) -> Made {
    number(model, word, (false, ["damping", "damping", "damping"], "-1"))
}

pub(super) fn friction(model: &Model, word: &str) -> Made {
    number(model, word, (false, ["friction", "frictionloss", "friction"], "-1"))
}

/// A drive that names no joint.
pub(super) fn drive(model: &Model, _: &str) -> Made {
    const NOBODY: &str = "joint_that_is_not_there";
    let (source, root) = (&model.source, model.source.root());
    let (group, line) = match model.language {
        Language::Mjcf => {
            let all = source.children(root, "actuator").into_iter();
            let driven = all.flat_map(|a| source.all_children(a));
            let named: Vec<At> = driven.filter(|a| source.get(*a, "joint").is_some()).collect();
            (named, "<actuator>\n\t<motor joint=\"joint_that_is_not_there\"/>\n</actuator>")
        }
        _ => {
            let all = source.children(root, "transmission").into_iter();
            let named: Vec<At> = all.flat_map(|t| source.children(t, "joint")).collect();
            (
                named,
                "<transmission name=\"drive_of_nothing\">\n\t<type>transmission_interface/SimpleTransmission</type>\n\t<joint name=\"joint_that_is_not_there\">\n\t\t<hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface>\n\t</joint>\n\t<actuator name=\"motor\">\n\t\t<mechanicalReduction>1</mechanicalReduction>\n\t</actuator>\n</transmission>",
            )
        }
    };
    let attribute = if model.language == Language::Mjcf { "joint" } else { "name" };
    let words = format!("a drive of joint `{NOBODY}`");
    match group.first() {
        Some(at) => {
            let line = source.line(*at);
            made("a drive".into(), line, words, vec![source.set(*at, attribute, NOBODY)])
        }
        None => {
            let at = source.line(root);
            made("the model".into(), at, words, vec![source.insert_last(root, line)])
        }
    }
}

/// A control range of three times the joint's.
pub(super) fn control(model: &Model, word: &str) -> Made {
    let source = &model.source;
    let all = source.children(source.root(), "actuator").into_iter();
    let drives = all.flat_map(|a| source.children(a, "position"));
    let drives = model.drawn(word, drives.collect());
    first(drives, "no <position> actuator names a joint with a range", |at| {
        let name = source.get(at, "joint").ok_or("it names no joint")?;
        let joint = model.robot.joints.iter().find(|j| j.name == name);
        let joint = joint.filter(|j| j.kind != Motion::Continuous);
        let (lower, upper) =
            joint.and_then(|j| j.limits_as_written()).ok_or("its joint has no range")?;
        let (middle, half) = ((lower + upper) / 2.0, 1.5 * (upper - lower));
        let told = format!("{} {}", short(middle - half), short(middle + half));
        let mut edits = vec![source.set(at, "ctrlrange", &told)];
        edits.extend(source.unset(at, "inheritrange"));
        made(quoted("a drive of joint", name), source.line(at), format!("ctrlrange {told}"), edits)
    })
}

/// A motion that is none.
pub(super) const STILL: DPose3 = DPose3::IDENTITY;
