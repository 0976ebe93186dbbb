//! Which program is started where work has to be done in a process of its own.
//!
//! As a rule it is this one, once more. Where this house is a library inside another program, such as an
//! interpreter of Python, that program must not be started again: whoever loads the library names the
//! program that came with it.

use std::io;
use std::path::PathBuf;
use std::sync::OnceLock;

static NAMED: OnceLock<PathBuf> = OnceLock::new();

/// Names the program that works apart, in place of the one that this process runs. The first name stays.
pub fn name(program: PathBuf) {
    // Whoever comes second came with the same library, so with the same program.
    let _ = NAMED.set(program);
}

/// The program that works apart.
///
/// # Errors
/// What the system says where nobody named one, and this process's own cannot be found.
pub fn apart() -> io::Result<PathBuf> {
    NAMED.get().map_or_else(std::env::current_exe, |named| Ok(named.clone()))
}
