//! The program that works apart for a house inside another program: it keeps programs, reads layers, checks,
//! and looks at models and traces, each as `kinfold` does it, and nothing else.

use std::process::ExitCode;

use super::args::{Command, TraceCommand};
use super::commands::sealed::meant;
use super::commands::{check, trace, trace_diff, trace_verify, view};
use super::speech::{Answer, Complaint};
use super::{layers, looks, told};

/// Reads the command line, does what it says if it is one of these, and tells who asked how it went.
pub fn main() -> ExitCode {
    if let Some(code) = adapters::keeper::asked(std::env::args_os()) {
        return code;
    }
    if let Some(code) = layers::asked(std::env::args_os()) {
        return code;
    }
    ExitCode::from(told(std::env::args_os().collect(), answer) as u8)
}

fn answer(command: Command) -> Result<Answer, Complaint> {
    let _watch = looks::watch(&command);
    match command {
        Command::Check(args) if args.here => check::check(&args),
        Command::View(args) if args.here => view::view(&args),
        Command::Trace(TraceCommand::Show { file, json, .. }) => trace::show(&meant(&file), json),
        Command::Trace(TraceCommand::Verify { file, files, key, verbose, json, .. }) => {
            let (file, told) = (meant(&file), (verbose, json));
            trace_verify::verify(&file, files.as_deref(), key.as_deref(), told)
        }
        Command::Trace(TraceCommand::Diff { a, b, json, .. }) => {
            trace_diff::diff(&meant(&a), &meant(&b), json)
        }
        _ => Err(Complaint::misused("this program only works for the library it came with")
            .hint("the command line is `kinfold`")),
    }
}
