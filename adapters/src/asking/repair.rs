//! One question until its answer is right: what is wrong goes back as a list, twice at most.

use std::fmt;
use std::sync::Arc;

use serde::Serialize;
use serde_json::Value;

use super::pointing::Convention;
use crate::chat::{Codec, Piece, Question, Turn};
use crate::generators::answer::shortened;
use crate::{AdapterError, Transport};

pub(super) const SYSTEM: &str = include_str!("../prompts/system.md");
pub(super) const REPAIR: &str = include_str!("../prompts/repair.md");

/// Most times an answer goes back.
pub const MAX_ROUNDS: u32 = 2;
/// Most faults of one answer that are told to the model: what is that wrong is wrong as a whole.
const MAX_TAUGHT: usize = 40;
/// Most faults of one answer that are told to a person.
const MAX_TOLD: usize = 8;

/// A vision-language model that is asked for conditions.
pub struct Asking<C> {
    /// Whose protocol is spoken.
    pub codec: C,
    /// What everything passes through.
    pub transport: Arc<dyn Transport>,
    /// How the model writes a point.
    pub convention: Convention,
    /// Most tokens of one answer.
    pub max_tokens: u32,
}

/// A rule an answer breaks.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Fault {
    /// Name of the rule, such as `K04`.
    pub code: &'static str,
    /// Where in the answer, such as `/parts/3/parent`.
    pub path: String,
    /// The rule and what was found.
    pub message: String,
}

impl Fault {
    /// The message holds pieces of the answer, which are cut to what may be passed on.
    pub(super) fn new(code: &'static str, path: String, message: impl Into<String>) -> Self {
        Self { code, path, message: shortened(&message.into()) }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}: {}", self.code, self.path, self.message)
    }
}

impl<C: Codec> Asking<C> {
    /// Asks, judges, and sends back what is wrong.
    pub(super) fn repaired<T>(
        &self,
        (name, schema): (&'static str, Value),
        pieces: Vec<Piece>,
        judge: impl Fn(Value) -> Result<T, Vec<Fault>>,
    ) -> Result<T, AdapterError> {
        let mut turns = vec![Turn::Ours(pieces)];
        let mut round = 0;
        loop {
            let (step, schema) = (format!("vlm.{name}/{round}"), schema.clone());
            let (system, max_tokens) = (SYSTEM, self.max_tokens);
            let turns_now = turns.clone();
            let question =
                Question { step, system, turns: turns_now, schema_name: name, schema, max_tokens };
            let response = self.transport.send(&self.codec.request(&question))?;
            let reply = self.codec.reply(&question.step, &response)?;
            let faults = match first_json(&reply.text).and_then(&judge) {
                Ok(answer) => return Ok(answer),
                Err(faults) => faults,
            };
            if round == MAX_ROUNDS {
                return Err(unrepaired(self.codec.identity(), name, &faults));
            }
            let taught = &faults[..faults.len().min(MAX_TAUGHT)];
            let list = serde_json::to_string(taught).unwrap_or_default();
            turns.push(Turn::Theirs(reply.text));
            turns.push(Turn::Ours(vec![Piece::text(REPAIR.replace("{faults}", &list))]));
            round += 1;
        }
    }
}

fn unrepaired(who: String, question: &'static str, faults: &[Fault]) -> AdapterError {
    let mut found: Vec<_> = faults.iter().take(MAX_TOLD).map(Fault::to_string).collect();
    if faults.len() > MAX_TOLD {
        found.push(format!("and {} more", faults.len() - MAX_TOLD));
    }
    let found = found.join("; ");
    AdapterError::Unrepaired { who, question, rounds: MAX_ROUNDS, found }
}

/// The first JSON object in a text: some models put it into a fence or a sentence.
pub(super) fn first_json(text: &str) -> Result<Value, Vec<Fault>> {
    let start = text.find('{').unwrap_or(0);
    let mut values = serde_json::Deserializer::from_str(&text[start..]).into_iter::<Value>();
    match values.next() {
        Some(Ok(value)) => Ok(value),
        Some(Err(e)) => Err(vec![Fault::new("J01", "/".into(), format!("must be JSON: {e}"))]),
        None => Err(vec![Fault::new("J01", "/".into(), "must be JSON, found nothing")]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_is_found_in_a_fence_and_in_a_sentence() {
        let expected = serde_json::json!({ "a": [1] });
        for text in ["{\"a\":[1]}", "```json\n{\"a\":[1]}\n```", "Sure: {\"a\":[1]} There."] {
            assert_eq!(first_json(text).unwrap(), expected, "{text}");
        }
        for text in ["", "no", "{\"a\":", "é{"] {
            assert_eq!(first_json(text).unwrap_err()[0].code, "J01", "{text}");
        }
    }
}
