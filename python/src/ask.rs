//! What is asked about files: a verdict, a forecast, a run again.

use std::ffi::OsString;
use std::path::PathBuf;

use ::forecast::{Client, Outside};
use pyo3::prelude::*;
use workflow::cli::asked;
use workflow::cli::speech::Answer;

use crate::errors::Wrong;
use crate::threads::alone;

/// What the command line answers: how it ends, what goes to stdout, and what a person should know.
pub(crate) type Told = (u8, String, Vec<String>);

/// An answer for Python.
pub(crate) fn told(answer: Answer) -> Told {
    (answer.exit as u8, answer.result, answer.remarks)
}

/// Checks models; `words` are those behind `kinfold check`.
#[pyfunction]
pub(crate) fn check(py: Python<'_>, words: Vec<OsString>) -> PyResult<Told> {
    alone(py, move || Ok(told(asked::check(words)?)))
}

/// The digest of some bytes, as traces and services name them: BLAKE3, 64 hexadecimal digits.
#[pyfunction]
pub(crate) fn digest(py: Python<'_>, content: &[u8]) -> String {
    py.detach(|| ::trace::Digest::of(content).to_string())
}

/// Mends a model; `words` are those behind `kinfold fix`.
#[pyfunction]
pub(crate) fn fix(py: Python<'_>, words: Vec<OsString>) -> PyResult<Told> {
    alone(py, move || Ok(told(asked::fix(words)?)))
}

/// Measures an articulator; `words` are those behind `kinfold eval`.
#[pyfunction]
pub(crate) fn evaluate(py: Python<'_>, words: Vec<OsString>) -> PyResult<Told> {
    alone(py, move || Ok(told(asked::eval(words)?)))
}

/// Runs the flow of a trace again, or takes something out of it; `words` are those behind `kinfold trace`.
#[pyfunction]
pub(crate) fn trace(py: Python<'_>, words: Vec<OsString>) -> PyResult<Told> {
    alone(py, move || Ok(told(asked::trace(words)?)))
}

/// What clients will do with a file, as JSON; `clients` is `all` or a list with commas between.
#[pyfunction]
pub(crate) fn forecast(
    py: Python<'_>,
    path: PathBuf,
    clients: &str,
    outside: bool,
) -> PyResult<String> {
    let clients = Client::list(clients).map_err(|e| Wrong::of("InputError", &e).raised(py))?;
    let outside = if outside { Outside::Allowed } else { Outside::Refused };
    alone(py, move || {
        let said = ::forecast::forecast(&path, &clients, outside);
        let said = said.map_err(|e| Wrong::of("InputError", &e))?;
        serde_json::to_string(&said).map_err(|e| Wrong::of("InternalError", &e))
    })
}
