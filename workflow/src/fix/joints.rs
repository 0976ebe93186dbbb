//! Axes and ranges: J1, J2, J3, C2, C5, S3.

use std::f64::consts::TAU;

use sim_check::advice::{self, Advice, Remedy};
use sim_check::profile::bounds::AXIS;
use sim_check::read::source::{At, Edit};
use sim_check::robot::{Joint, Motion};
use sim_check::verdict::figure;

use super::numbers::{inward, negated, short, triple};
use super::offer::{Change, Offer, State, names};
use super::remedies::{NO_RADIANS, Way};

/// A range of which less than this share is free is not clamped: something else is wrong; a guess.
const TOO_LITTLE: f64 = 0.1;

/// What a way offers for each joint that is named in the findings.
pub(super) fn offers(state: &State, way: Way, findings: &[(&str, &str)]) -> Vec<Offer> {
    let named = names(findings, "joint");
    let advised = match way {
        Way::Flip => advice::advice(&state.robot),
        Way::Clamp => {
            let mut all = advice::advice(&state.robot);
            all.extend(advice::jams(&state.robot));
            all
        }
        _ => Vec::new(),
    };
    let joints = state.robot.joints.iter().filter(|j| named.contains(&j.name.as_str()));
    let offer = |joint: &Joint| {
        let changes = match way {
            Way::Unit => unit(state, joint),
            Way::Swap => swap(state, joint),
            Way::Degrees => degrees(state, joint),
            Way::Flip => flip(state, joint, &advised),
            Way::Clamp => clamp(state, joint, &advised),
            _ => return None,
        };
        let subject = format!("joint `{}`", joint.name);
        let changes = changes.transpose()?.map(|change| vec![change]);
        Some(Offer { way, subject, line: joint.line, changes })
    };
    joints.filter_map(offer).collect()
}

type Made = Result<Option<Change>, String>;

fn joint_at(state: &State, joint: &Joint) -> Result<At, String> {
    state.element("joint", &joint.name, joint.line)
}

fn change(words: String, edits: Vec<Edit>) -> Made {
    Ok(Some(Change { words, edits, files: vec![] }))
}

fn unit(state: &State, joint: &Joint) -> Made {
    let length = joint.axis_as_written.length();
    if (length - 1.0).abs() <= AXIS {
        return Ok(None);
    }
    if !(length > 0.0 && length.is_finite()) {
        return Err(
            "its axis has no direction, and nothing in the file tells which is meant".into()
        );
    }
    let at = joint_at(state, joint)?;
    let axis = state.source.child(at, "axis").ok_or("its axis is not told once")?;
    let told = triple(joint.axis_as_written / length);
    let edit = state.source.set(axis, "xyz", &told);
    change(format!("axis {told}, of length 1 (was {})", figure(length)), vec![edit])
}

/// The element that tells a range, and its two ends as they are written.
fn ends(state: &State, joint: &Joint) -> Result<(At, [String; 2]), String> {
    let at = joint_at(state, joint)?;
    if state.is_urdf() {
        let limit = state.source.child(at, "limit").ok_or("has no <limit> to mend")?;
        let end = |name: &str| state.source.get(limit, name).unwrap_or("0").trim().to_owned();
        return Ok((limit, [end("lower"), end("upper")]));
    }
    let range = state.source.get(at, "range").unwrap_or_default();
    match range.split_whitespace().collect::<Vec<_>>()[..] {
        [lower, upper] => Ok((at, [lower.to_owned(), upper.to_owned()])),
        _ => Err("its range stands in a class, which other joints may share: mend it there".into()),
    }
}

/// The edits that write another range.
fn range(state: &State, at: At, [lower, upper]: [&str; 2], was: &[String; 2]) -> Vec<Edit> {
    if !state.is_urdf() {
        return vec![state.source.set(at, "range", &format!("{lower} {upper}"))];
    }
    let both = [("lower", lower, &was[0]), ("upper", upper, &was[1])];
    let other = both.into_iter().filter(|(_, new, old)| *new != old.as_str());
    other.map(|(name, new, _)| state.source.set(at, name, new)).collect()
}

fn swap(state: &State, joint: &Joint) -> Made {
    let Some((lower, upper)) = joint.limits_as_written().filter(|(l, u)| l >= u) else {
        return Ok(None);
    };
    if lower == upper {
        return Err("both limits are the same, and nothing tells how far it goes".into());
    }
    let (at, was) = ends(state, joint)?;
    let edits = range(state, at, [&was[1], &was[0]], &was);
    change(format!("limits {} to {} (they were swapped)", was[1], was[0]), edits)
}

fn degrees(state: &State, joint: &Joint) -> Made {
    if joint.kind != Motion::Revolute {
        return Ok(None);
    }
    let Some((lower, upper)) = joint.limits_as_written() else { return Ok(None) };
    let (most, span) = (lower.abs().max(upper.abs()), (upper - lower).to_radians());
    if most <= NO_RADIANS {
        return Err(format!(
            "limits {} to {} may be radians: several turns are a person's to judge",
            figure(lower),
            figure(upper)
        ));
    }
    if span > TAU + 1e-9 {
        return Err("read as degrees it turns more than once, too".into());
    }
    let (at, was) = ends(state, joint)?;
    let read = |text: &String| text.parse::<f64>().map_err(|_| "its limits are no plain numbers");
    let told = [read(&was[0])?, read(&was[1])?].map(|v| short(v.to_radians()));
    let edits = range(state, at, [&told[0], &told[1]], &was);
    change(format!("limits {} to {} rad (were degrees)", told[0], told[1]), edits)
}

fn flip(state: &State, joint: &Joint, advised: &[Advice]) -> Made {
    let mine = advised.iter().any(|a| a.joint == joint.name && a.remedy == Remedy::Flip);
    if !mine {
        return Ok(None);
    }
    let at = joint_at(state, joint)?;
    let words = "axis turned round: it opens into another part, and is free the other way";
    let turned = |told: &str| told.split_whitespace().map(negated).collect::<Vec<_>>().join(" ");
    let source = &state.source;
    if !state.is_urdf() {
        let told = source.get(at, "axis").map_or_else(|| triple(-joint.axis_as_written), turned);
        return change(words.into(), vec![source.set(at, "axis", &told)]);
    }
    let edit = match source.child(at, "axis") {
        Some(axis) => source.set(axis, "xyz", &turned(source.get(axis, "xyz").unwrap_or("1 0 0"))),
        None => {
            let child = source.child(at, "child").ok_or("names no child")?;
            source.insert_after(at, child, "<axis xyz=\"-1 0 0\"/>")
        }
    };
    change(words.into(), vec![edit])
}

/// Why no range is advised for a joint that is named.
fn unclamped(state: &State, joint: &Joint) -> String {
    let name = |j: usize| state.robot.joints.get(j).map(|j| j.name.as_str());
    let is_followed = state.robot.joints.iter().filter_map(|j| j.mimic);
    let mut is_followed = is_followed.filter(|m| name(m.joint) == Some(joint.name.as_str()));
    if joint.kind == Motion::Continuous {
        "it turns without limits, so no range of it can end sooner".into()
    } else if is_followed.next().is_some() {
        "other joints follow it, and have ranges of their own".into()
    } else {
        "parts meet before it has moved, which no range mends".into()
    }
}

fn clamp(state: &State, joint: &Joint, advised: &[Advice]) -> Made {
    let clamped = advised.iter().filter(|a| a.joint == joint.name).find_map(|a| match a.remedy {
        Remedy::Clamp(ends) => Some(ends),
        Remedy::Flip => None,
    });
    let (Some([lower, upper]), Some(limit)) = (clamped, joint.limit) else {
        return Err(unclamped(state, joint));
    };
    if upper - lower < TOO_LITTLE * (limit.upper - limit.lower) {
        return Err(format!(
            "only {} to {} of its range is free: look at its axis and its place first",
            figure(lower + joint.rest),
            figure(upper + joint.rest)
        ));
    }
    let (at, was) = ends(state, joint)?;
    let written = |new: f64, old: f64, word: &String| -> Result<String, String> {
        if new == old {
            return Ok(word.clone());
        }
        let told = word.parse::<f64>().map_err(|_| "its limits are no plain numbers".to_owned())?;
        // MJCF tells angles in its own unit: as many of it as the file itself says.
        let whole = old + joint.rest;
        let unit = if whole != 0.0 && !state.is_urdf() { told / whole } else { 1.0 };
        Ok(inward((new + joint.rest) * unit))
    };
    let told = [written(lower, limit.lower, &was[0])?, written(upper, limit.upper, &was[1])?];
    if told == was {
        return Ok(None);
    }
    let edits = range(state, at, [&told[0], &told[1]], &was);
    change(
        format!(
            "limits {} to {} (were {} to {}): beyond them parts meet",
            told[0], told[1], was[0], was[1]
        ),
        edits,
    )
}
