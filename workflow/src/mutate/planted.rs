//! What a planted defect is made of, and how a place for it is looked for.

use std::collections::BTreeMap;

use sim_check::read::source::Edit;

/// A defect that can be planted.
#[derive(Clone, Debug, Default)]
pub struct Planted {
    /// What it is about, such as "joint `hinge`".
    pub subject: String,
    /// Its line in the sound text.
    pub line: u32,
    /// What was done, in words.
    pub words: String,
    /// The changes of the text.
    pub(super) edits: Vec<Edit>,
    /// A whole new text, where it is no change of elements.
    pub(super) text: Option<String>,
    /// Files with other bytes than in the sound copy.
    pub files: BTreeMap<String, Vec<u8>>,
}

/// A defect, or why there is no place for it.
pub(super) type Made = Result<Planted, String>;

/// A defect that is edits alone.
pub(super) fn made(subject: String, line: u32, words: impl Into<String>, edits: Vec<Edit>) -> Made {
    Ok(Planted { subject, line, words: words.into(), edits, ..Planted::default() })
}

/// The first of these that gives a defect; else why the last of them gives none.
pub(super) fn first<T>(
    all: impl IntoIterator<Item = T>,
    none: &str,
    of: impl Fn(T) -> Made,
) -> Made {
    let mut why = none.to_owned();
    for one in all {
        match of(one) {
            Ok(planted) => return Ok(planted),
            Err(reason) => why = reason,
        }
    }
    Err(why)
}
