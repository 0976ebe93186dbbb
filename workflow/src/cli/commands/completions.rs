//! `kinfold completions`: what a shell needs to complete commands.

use clap::CommandFactory;
use clap_complete::{Shell, generate};

use crate::cli::args::Cli;
use crate::cli::speech::Answer;

/// The completion script of a shell.
pub fn completions(shell: Shell) -> Answer {
    let mut script = Vec::new();
    generate(shell, &mut Cli::command(), "kinfold", &mut script);
    Answer::done(String::from_utf8_lossy(&script))
}
