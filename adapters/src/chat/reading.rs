//! What all three protocols need to read an answer.

use serde_json::Value;

use super::{Reply, Usage};
use crate::AdapterError;
use crate::generators::answer::{Asked, shortened};

/// A service's way to say that it was done.
pub(super) struct Ending<'a> {
    /// Where the answer says why it ended.
    pub pointer: &'a str,
    /// What it says when it is whole.
    pub whole: &'a [&'a str],
}

/// Refuses an answer that did not end by itself.
pub(super) fn check_whole(
    asked: Asked<'_>,
    answer: &Value,
    ending: &Ending<'_>,
) -> Result<(), AdapterError> {
    match answer.pointer(ending.pointer).and_then(Value::as_str) {
        Some(reason) if ending.whole.contains(&reason) => Ok(()),
        Some(reason) => {
            let found = format!("one that ended with `{}`", shortened(reason));
            Err(asked.broke("the answer must be whole", found))
        }
        None => {
            let found = shortened(&answer.to_string());
            Err(asked.broke("the answer must say why it ended", found))
        }
    }
}

/// A reply of some words; none is an error.
pub(super) fn reply(
    asked: Asked<'_>,
    text: String,
    answer: &Value,
    [input, output]: [&str; 2],
) -> Result<Reply, AdapterError> {
    if text.trim().is_empty() {
        return Err(asked.broke("the answer must say something", "no words"));
    }
    let count = |pointer| answer.pointer(pointer).and_then(Value::as_u64);
    Ok(Reply { text, usage: Usage { input: count(input), output: count(output) } })
}

/// The texts under `key` in a list of pieces, joined.
pub(super) fn joined(answer: &Value, list: &str, key: &str) -> String {
    let pieces = answer.pointer(list).and_then(Value::as_array);
    let texts =
        pieces.into_iter().flatten().filter(|p| p.get("thought") != Some(&Value::Bool(true)));
    texts.filter_map(|p| p.get(key)?.as_str()).collect()
}
