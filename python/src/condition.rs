//! Conditions: read, proved, and written as a file has them.

use std::path::PathBuf;

use adapters::ConditionFile as ConditionPath;
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
    let read = py.detach(|| written(&Condition::from_json_with(text, up)?));
    read.map_err(|wrong: Wrong| wrong.raised(py))
}

/// The same of a file.
#[pyfunction]
pub(crate) fn condition_file(py: Python<'_>, path: PathBuf, up: &str) -> PyResult<String> {
    let up = up_axis(up).map_err(|wrong| wrong.raised(py))?;
    let read = py.detach(|| written(&ConditionPath { path, up, snap: false }.read()?));
    read.map_err(|wrong: Wrong| wrong.raised(py))
}

/// The same of one that a trace keeps.
#[pyfunction]
pub(crate) fn condition_kept(py: Python<'_>, content: &[u8]) -> PyResult<String> {
    let kept = py.detach(|| <Condition as runner::Artefact<workflow::Tools>>::decode(content));
    let kept = kept.map_err(|e| Wrong::of("RunError", &e).raised(py))?;
    written(&kept).map_err(|wrong| wrong.raised(py))
}

fn written(condition: &Condition) -> Result<String, Wrong> {
    // The up axis is said in any case, so that nobody reads it by another one later.
    let file = ConditionFile { up: Some(condition.frame.up), ..ConditionFile::from(condition) };
    serde_json::to_string_pretty(&file).map_err(|e| Wrong::of("InternalError", &e))
}

/// The JSON Schema of a condition.
#[pyfunction]
pub(crate) fn condition_schema() -> String {
    Condition::json_schema().to_string()
}
