//! Conditions: read, proved, and written as a file has them.

use object::{Condition, ConditionFile};
use pyo3::prelude::*;

use crate::arrays::up_axis;
use crate::errors::Wrong;

/// Proves a condition and returns it as it stands in a file of ours, whatever it was written as.
///
/// `up` is the up axis of one that does not say.
#[pyfunction]
pub(crate) fn condition(py: Python<'_>, text: &str, up: &str) -> PyResult<String> {
    let up = up_axis(up).map_err(|wrong| wrong.raised(py))?;
    let read = py.detach(|| Condition::from_json_with(text, up));
    let read = read.map_err(|error| Wrong::from(error).raised(py))?;
    // Said in any case, so that nobody reads it by another axis later.
    let file = ConditionFile { up: Some(read.frame.up), ..ConditionFile::from(&read) };
    let written = serde_json::to_string_pretty(&file);
    written.map_err(|e| Wrong::of("InternalError", &e).raised(py))
}

/// The JSON Schema of a condition.
#[pyfunction]
pub(crate) fn condition_schema() -> String {
    Condition::json_schema().to_string()
}
