//! Which joints look wrong, as a model answers it, and every rule about that answer.

use std::collections::BTreeMap;

use object::KinematicTree;
use serde::Deserialize;
use serde_json::Value;
use trace::Digest;

use super::motion::id;
use super::repair::{Asking, Fault, REPAIR, SYSTEM};
use super::{motion, pictures, schema};
use crate::chat::{Codec, Piece};
use crate::critic::{JointFault, Remark};
use crate::generators::answer::shortened;
use crate::sent::sent;
use crate::{AdapterError, Critic, CritiqueQuestion};

const CRITIC: &str = include_str!("../prompts/critic.md");

impl<C: Codec> Critic for Asking<C> {
    fn identity(&self) -> Result<String, AdapterError> {
        let words = Digest::of([SYSTEM, CRITIC, REPAIR].concat().as_bytes());
        Ok(format!("{} prompts {}", self.codec.identity(), words.short()))
    }

    fn criticise(&self, question: &CritiqueQuestion<'_>) -> Result<Vec<Remark>, AdapterError> {
        let tree = question.object.tree();
        if moving(tree).next().is_none() {
            return Ok(vec![]);
        }
        let photo = sent(question.photo)?;
        let views: Vec<_> = question.views.iter().map(|v| v.name.as_str()).collect();
        let words = CRITIC.replace("{views}", &views.join("; "));
        let words = words.replace("{parts}", &motion::lines(question.object));
        let mut pieces = vec![Piece::text(words)];
        pieces.push(Piece::picture(&photo.media_type, &photo.bytes));
        pieces.extend(pictures(question.views));
        self.repaired(("critic", schema::critic()), pieces, |value| judged(value, tree))
    }
}

/// The answer, as the schema has it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FlagsAnswer {
    flags: Vec<FlagAnswer>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FlagAnswer {
    part_id: String,
    fault: JointFault,
    reason: String,
}

/// Reads an answer and applies every rule; all faults at once. The remarks come in the order of
/// parts, their reasons on one line and no longer than [`crate::critic::MAX_REASON`].
///
/// # Errors
/// The rules it breaks.
pub fn judged(value: Value, tree: &KinematicTree) -> Result<Vec<Remark>, Vec<Fault>> {
    let answer: FlagsAnswer = serde_json::from_value(value)
        .map_err(|e| vec![Fault::new("J02", "/".into(), format!("must fit the schema: {e}"))])?;
    let (mut faults, mut remarks) = (vec![], BTreeMap::new());
    for (n, flag) in answer.flags.into_iter().enumerate() {
        let path = |key: &str| format!("/flags/{n}/{key}");
        let Some((part, name)) = moving(tree).find(|(part, _)| id(*part) == flag.part_id) else {
            let message = format!("no moving part has the id {:?}", flag.part_id);
            faults.push(Fault::new("F01", path("part_id"), message));
            continue;
        };
        let reason = bounded(&flag.reason);
        let remark = Remark { part: name.to_owned(), fault: flag.fault, reason };
        if remark.is_flag() && remark.reason.is_empty() {
            faults.push(Fault::new("F03", path("reason"), "what is flagged has a reason"));
        }
        if remarks.insert(part, remark).is_some() {
            let message = format!("a part has one flag, {} has two", id(part));
            faults.push(Fault::new("F02", path("part_id"), message));
        }
    }
    for (part, _) in moving(tree).filter(|(part, _)| !remarks.contains_key(part)) {
        let message = format!("{} has no flag", id(part));
        faults.push(Fault::new("F02", "/flags".into(), message));
    }
    if faults.is_empty() { Ok(remarks.into_values().collect()) } else { Err(faults) }
}

/// The parts that move, by number and name.
fn moving(tree: &KinematicTree) -> impl Iterator<Item = (usize, &str)> {
    let parts = tree.parts().iter().enumerate().filter(|(_, p)| !p.joints.is_empty());
    parts.map(|(n, p)| (n, p.name.as_str()))
}

/// A model's sentence as it may be passed on.
fn bounded(reason: &str) -> String {
    shortened(reason.trim()).trim().to_owned()
}
