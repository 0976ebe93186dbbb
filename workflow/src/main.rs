//! The `kinfold` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    workflow::cli::main()
}
