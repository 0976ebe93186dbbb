//! `kinfold schema`: JSON Schemas of the files people write.

use object::Condition;

use crate::cli::speech::{Answer, Complaint};

/// The schema of a condition file.
///
/// # Errors
/// [`Complaint`] if it cannot be printed.
pub fn condition() -> Result<Answer, Complaint> {
    let text = serde_json::to_string_pretty(&Condition::json_schema());
    text.map(|t| Answer::done(t + "\n")).map_err(|e| Complaint::from_error(&e))
}
