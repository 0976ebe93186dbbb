//! Which parts an object has, as a model answers it, and every rule about that answer.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::repair::Fault;
use object::condition::MAX_TEXT;

/// Most parts of one object.
pub const MAX_PARTS: usize = 64;

/// The answer to "which parts are there".
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartsAnswer {
    /// Whether there is anything to articulate.
    pub verdict: Verdict,
    /// What the object is.
    pub category: String,
    /// A sentence on it.
    pub description: String,
    /// Whether its left and right are the same for everybody.
    pub has_canonical_orientation: bool,
    /// View of its front, from 1.
    pub front_view: Option<i64>,
    /// Its parts.
    pub parts: Vec<PartAnswer>,
}

/// Whether there is anything to articulate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Parts move against each other.
    Articulated,
    /// One stiff body.
    Rigid,
    /// Soft.
    Deformable,
    /// More than one thing.
    MultipleObjects,
    /// Cannot be told.
    Unclear,
}

/// One part as it is answered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartAnswer {
    /// `p0`, `p1`, …
    pub id: String,
    /// A word or two.
    pub name: String,
    /// What tells it from the others.
    pub text: String,
    /// Id of the part it hangs on; none for the base.
    pub parent: Option<String>,
    /// How it moves; empty for fixed.
    pub joint_types: Vec<JointWord>,
    /// A sentence on how it moves.
    pub motion: String,
    /// Views it is seen in, from 1.
    pub visible_views: Vec<i64>,
    /// How sure the model is.
    pub confidence: Confidence,
}

/// A kind of joint, as it is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JointWord {
    /// It slides.
    Prismatic,
    /// It turns.
    Revolute,
}

/// How sure a model is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Confidence {
    /// Sure.
    High,
    /// Rather.
    Medium,
    /// Guessing.
    Low,
}

/// Reads an answer and applies every rule; all faults at once. An answer that there is nothing to
/// articulate has no parts to judge.
///
/// # Errors
/// The rules it breaks.
pub fn judged(value: Value, views: usize) -> Result<PartsAnswer, Vec<Fault>> {
    let answer: PartsAnswer = serde_json::from_value(value)
        .map_err(|e| vec![Fault::new("J02", "/".into(), format!("must fit the schema: {e}"))])?;
    if answer.verdict != Verdict::Articulated {
        return Ok(answer);
    }
    let mut faults = whole(&answer);
    faults.extend(tree(&answer.parts));
    for (n, part) in answer.parts.iter().enumerate() {
        faults.extend(one(part, n, views, answer.has_canonical_orientation));
    }
    if faults.is_empty() { Ok(answer) } else { Err(faults) }
}

fn whole(answer: &PartsAnswer) -> Vec<Fault> {
    let mut faults = vec![];
    let count = answer.parts.len();
    if !(1..=MAX_PARTS).contains(&count) {
        let message = format!("an object has 1 to {MAX_PARTS} parts, found {count}");
        faults.push(Fault::new("K02", "/parts".into(), message));
    }
    let mut seen = BTreeSet::new();
    for (n, part) in answer.parts.iter().enumerate() {
        let path = format!("/parts/{n}/id");
        let digits = part.id.strip_prefix('p').unwrap_or_default();
        if digits.is_empty() || !digits.bytes().all(|b| b.is_ascii_digit()) {
            let message = format!("an id is p and a number, found {:?}", part.id);
            faults.push(Fault::new("K03", path.clone(), message));
        }
        if !seen.insert(&part.id) {
            faults.push(Fault::new("K03", path, format!("{:?} is used twice", part.id)));
        }
    }
    if !answer.parts.iter().any(|p| !p.joint_types.is_empty()) {
        let message = "an articulated object has a part that moves, found none";
        faults.push(Fault::new("K12", "/parts".into(), message));
    }
    faults
}

fn tree(parts: &[PartAnswer]) -> Vec<Fault> {
    let mut faults = vec![];
    let roots: Vec<_> = parts.iter().enumerate().filter(|(_, p)| p.parent.is_none()).collect();
    if roots.len() != 1 {
        let ids: Vec<_> = roots.iter().map(|(_, p)| p.id.as_str()).collect();
        let message = format!("exactly one part has no parent, found {ids:?}");
        faults.push(Fault::new("K04", "/parts".into(), message));
    }
    for (n, root) in roots {
        if !root.joint_types.is_empty() {
            let path = format!("/parts/{n}/joint_types");
            faults.push(Fault::new("K04", path, "the base does not move, found a joint"));
        }
    }
    let parent_of: BTreeMap<_, _> = parts.iter().map(|p| (&p.id, p.parent.as_ref())).collect();
    for (n, part) in parts.iter().enumerate() {
        let path = format!("/parts/{n}/parent");
        let Some(parent) = &part.parent else { continue };
        if !parent_of.contains_key(parent) {
            faults.push(Fault::new("K05", path, format!("no part has the id {parent:?}")));
        } else if circles(&parent_of, &part.id) {
            let message = format!("following the parents of {:?} never ends", part.id);
            faults.push(Fault::new("K06", path, message));
        }
    }
    faults
}

fn circles(parent_of: &BTreeMap<&String, Option<&String>>, from: &String) -> bool {
    let mut walk = Some(from);
    for _ in 0..=parent_of.len() {
        let Some(here) = walk else { return false };
        walk = parent_of.get(here).copied().flatten();
    }
    walk.is_some()
}

/// Words that mean something only where everybody agrees on the front.
const SIDES: [&str; 6] = ["left", "right", "front", "back", "rear", "leftmost"];

fn one(part: &PartAnswer, n: usize, views: usize, sides_known: bool) -> Vec<Fault> {
    let mut faults = vec![];
    let mut fault = |code, key: &str, message: String| {
        faults.push(Fault::new(code, format!("/parts/{n}/{key}"), message));
    };
    let kinds: BTreeSet<_> = part.joint_types.iter().collect();
    if kinds.len() != part.joint_types.len() {
        fault("K07", "joint_types", "a kind of joint stands once, found it twice".into());
    }
    let text = part.text.trim();
    let words: Vec<_> = text.split(|c: char| !c.is_alphanumeric()).collect();
    let is_id = |w: &&str| w.strip_prefix('p').is_some_and(|d| d.parse::<u32>().is_ok());
    let digits = text.chars().all(|c| c.is_ascii_digit() || c.is_whitespace());
    if digits || text.chars().count() > MAX_TEXT || words.iter().any(is_id) {
        let rule = format!("a text has 1 to {MAX_TEXT} characters, words and no ids");
        fault("K08", "text", format!("{rule}, found {text:?}"));
    }
    let side = words.iter().find(|w| SIDES.contains(&w.to_ascii_lowercase().as_str()));
    if let Some(side) = side.filter(|_| !sides_known) {
        let rule = "without a canonical orientation no text names a side";
        fault("K09", "text", format!("{rule}, found {side:?}"));
    }
    let outside = part.visible_views.iter().find(|v| !(1..=views as i64).contains(*v));
    if let Some(view) = outside {
        fault("K11", "visible_views", format!("views are 1 to {views}, found {view}"));
    }
    faults
}
