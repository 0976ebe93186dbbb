//! The program that works apart for a house inside another program: it keeps programs, reads layers, checks,
//! mends, and looks at models and traces, each as `kinfold` does it, and nothing else.

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use super::args::{CheckArgs, FixArgs, TraceCommand, ViewArgs};
use super::commands::sealed::meant;
use super::commands::{check, fix, trace, trace_diff, trace_verify, view};
use super::speech::{Answer, Complaint};
use super::{layers, looks, speak};

/// What the library asks of it, in words of the command line: no other verb is even known here, which keeps
/// the program small.
#[derive(Debug, Parser)]
#[command(name = "kinfold-apart")]
struct Words {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    Check(Box<CheckArgs>),
    Fix(FixArgs),
    View(ViewArgs),
    #[command(subcommand)]
    Trace(TraceCommand),
}

/// Reads the command line, does what it says if it is one of these, and tells who asked how it went.
pub fn main() -> ExitCode {
    if let Some(code) = adapters::keeper::asked(std::env::args_os()) {
        return code;
    }
    if let Some(code) = layers::asked(std::env::args_os()) {
        return code;
    }
    layers::read_apart();
    let answer = match Words::try_parse_from(std::env::args_os()) {
        Ok(words) => answer(words.verb),
        Err(error) => {
            let mut complaint = nothing_else();
            complaint.causes.extend(error.to_string().lines().next().map(str::to_owned));
            Err(complaint)
        }
    };
    ExitCode::from(match answer {
        Ok(answer) => speak(&answer.result, &answer.remarks, (answer.exit, false)),
        Err(told) => speak(&told.result, &told.lines(), (told.exit, false)),
    } as u8)
}

fn answer(verb: Verb) -> Result<Answer, Complaint> {
    let _watch = match &verb {
        Verb::Trace(command) => looks::watch_trace(command),
        Verb::Check(_) | Verb::Fix(_) | Verb::View(_) => None,
    };
    match verb {
        Verb::Check(args) if args.here => check::here(&args),
        Verb::Fix(args) if args.here => fix::apart(&args),
        Verb::View(args) if args.here => view::view(&args),
        Verb::Trace(TraceCommand::Show { file, json, .. }) => trace::show(&meant(&file), json),
        Verb::Trace(TraceCommand::Verify { file, files, key, verbose, json, .. }) => {
            let (file, told) = (meant(&file), (verbose, json));
            trace_verify::verify(&file, files.as_deref(), key.as_deref(), told)
        }
        Verb::Trace(TraceCommand::Diff { a, b, json, .. }) => {
            trace_diff::diff(&meant(&a), &meant(&b), json)
        }
        Verb::Check(_) | Verb::Fix(_) | Verb::View(_) | Verb::Trace(_) => Err(nothing_else()),
    }
}

fn nothing_else() -> Complaint {
    Complaint::misused("this program only works for the library it came with")
        .hint("the command line is `kinfold`")
}
