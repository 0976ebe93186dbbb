//! What was altered on the way from the object to the asset, and why.
//!
//! ```
//! use asset::Change;
//! let told = Change::new("door", "range", "0 to 3 rad".into(), "0 to 2 rad".into(), "free of contact");
//! assert_eq!((told.part.as_str(), told.after.as_str()), ("door", "0 to 2 rad"));
//! ```

use serde::{Deserialize, Serialize};

/// One alteration of a part, kept in `asset.json` so that nothing is changed silently.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Change {
    /// Name of the part; empty when the whole object is meant.
    pub part: String,
    /// What was altered, in a word or two: `faces`, `range`, `mass`, `collision`.
    pub what: String,
    /// What it was, with unit.
    pub before: String,
    /// What it became, with unit.
    pub after: String,
    /// The rule that asked for it.
    pub why: String,
}

impl Change {
    /// An alteration of `what` on `part`.
    pub fn new(part: &str, what: &str, before: String, after: String, why: &str) -> Self {
        Self { part: part.into(), what: what.into(), before, after, why: why.into() }
    }
}
