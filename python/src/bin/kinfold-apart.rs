//! What the wheel starts where work needs a process of its own: checks, pages, traces of strangers, and the
//! keeper of programs. It knows nothing of Python.

use std::process::ExitCode;

/// As in `kinfold` itself.
#[global_allocator]
static HEAP: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    workflow::cli::apart::main()
}
