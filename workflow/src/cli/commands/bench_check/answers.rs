//! Who is asked, and what was answered.

use std::path::Path;

use serde::Serialize;

use crate::mutate::manifest::Mutant;

/// What was seen of the model without a defect.
pub(super) struct Seen {
    /// What was found of it, which is a false alarm.
    pub(super) alarm: Option<String>,
    pub(super) seconds: f64,
}

/// What was seen of a mutant.
pub(super) struct Found {
    pub(super) is_found: bool,
    /// What by, or what was seen instead.
    pub(super) by: String,
    pub(super) seconds: f64,
}

/// A checker.
pub(super) trait Asker {
    /// Asked of the model without a defect, before all of its mutants.
    fn original(&mut self, file: &Path) -> Seen;
    /// Asked of one of its mutants.
    fn mutant(&mut self, file: &Path, mutant: &Mutant) -> Found;
}

/// One answer.
#[derive(Debug, Serialize)]
pub(super) struct One {
    /// The folder of the mutants.
    pub(super) model: String,
    pub(super) kind: String,
    pub(super) found: bool,
    pub(super) by: String,
    pub(super) seconds: f64,
}

/// A model without a defect.
#[derive(Debug, Serialize)]
pub(super) struct Original {
    /// The folder of the mutants.
    pub(super) model: String,
    pub(super) format: String,
    /// What was found of it.
    pub(super) alarm: Option<String>,
    pub(super) seconds: f64,
}

/// All answers of a checker.
#[derive(Debug, Serialize)]
pub(super) struct Bench {
    pub(super) program: String,
    pub(super) originals: Vec<Original>,
    pub(super) mutants: Vec<One>,
    /// Kinds that no model has a place for are not in it.
    pub(super) not_applicable: Vec<(String, usize)>,
}
