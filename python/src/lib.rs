//! The house from Python: what the package `kinfold` around this module is made of.
//!
//! Everything here takes and gives plain things: bytes, texts, numbers. Names that a person sees, arrays and
//! documents are the package's. Work is done on a thread of its own, without the interpreter's lock; whoever
//! asked waits for it, hears Ctrl-C, and runs what of Python has to be run.

mod arrays;
mod articulate;
mod ask;
mod batch;
mod callables;
mod condition;
mod errors;
mod make;
mod page;
mod threads;

use std::ffi::OsString;
use std::path::PathBuf;

use pyo3::prelude::*;

/// Names the program of the wheel that works apart.
#[pyfunction]
fn name_apart(program: PathBuf) {
    workflow::cli::program::name(program);
}

/// The command line: does what the words say, and returns what to end with.
#[pyfunction]
fn command_line(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| workflow::cli::with(words) as u8)
}

/// What the package `kinfold` is made of.
#[pymodule]
fn _kinfold(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", workflow::recording::VERSION)?;
    module.add("MAX_VERTICES", object::mesh::MAX_VERTICES)?;
    module.add("MAX_FACES", object::mesh::MAX_FACES)?;
    module.add_class::<articulate::Articulated>()?;
    module.add_class::<batch::Batch>()?;
    module.add_class::<callables::Reply>()?;
    module.add_function(wrap_pyfunction!(name_apart, module)?)?;
    module.add_function(wrap_pyfunction!(command_line, module)?)?;
    module.add_function(wrap_pyfunction!(condition::condition, module)?)?;
    module.add_function(wrap_pyfunction!(condition::condition_file, module)?)?;
    module.add_function(wrap_pyfunction!(condition::condition_kept, module)?)?;
    module.add_function(wrap_pyfunction!(condition::condition_schema, module)?)?;
    module.add_function(wrap_pyfunction!(arrays::read_mesh, module)?)?;
    module.add_function(wrap_pyfunction!(arrays::write_glb, module)?)?;
    module.add_function(wrap_pyfunction!(arrays::mesh_digest, module)?)?;
    module.add_function(wrap_pyfunction!(articulate::articulate, module)?)?;
    module.add_function(wrap_pyfunction!(ask::check, module)?)?;
    module.add_function(wrap_pyfunction!(ask::digest, module)?)?;
    module.add_function(wrap_pyfunction!(ask::fix, module)?)?;
    module.add_function(wrap_pyfunction!(ask::evaluate, module)?)?;
    module.add_function(wrap_pyfunction!(ask::forecast, module)?)?;
    module.add_function(wrap_pyfunction!(ask::trace, module)?)?;
    module.add_function(wrap_pyfunction!(make::make, module)?)
}
