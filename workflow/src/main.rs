//! The `kinfold` program.

use std::process::ExitCode;

/// A batch runs many short threads; the system's allocator keeps a heap for each of them, three times
/// the memory and never the same twice.
#[global_allocator]
static HEAP: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    workflow::cli::main()
}
