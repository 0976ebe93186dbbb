//! What a program asks for, in the words of the command line: the same flows, the same answers, and
//! nothing said on the way but to the program.

use std::ffi::OsString;
use std::sync::Arc;

use clap::Parser as _;
use runner::{Cancel, Observer};

use super::args::{Cli, Command, MakeArgs, Own, TraceCommand};
use super::commands::make::{self, Company};
use super::commands::sealed::meant;
use super::commands::{
    batch as batches, check as checking, eval as evaluating, fix as fixing, trace_extract,
    trace_replay,
};
use super::layers;
use super::speech::{Answer, Complaint};
use crate::batch::item::Onlooker;

/// A program that waits while an asset is made.
pub struct Party<'a> {
    /// Is told what becomes of every stage.
    pub observer: &'a mut (dyn Observer + Send),
    /// How it stops the run.
    pub cancel: Cancel,
    /// Whom it brings to be asked.
    pub own: Own,
}

/// Makes an asset; the words are those behind `kinfold make`.
///
/// # Errors
/// [`Complaint`], as the command line tells it.
pub fn make(
    words: impl IntoIterator<Item = OsString>,
    party: Party<'_>,
) -> Result<Answer, Complaint> {
    let Command::Make(args) = understood("make", words)? else { return Err(other("make")) };
    let Party { observer, cancel, own } = party;
    make::with(&MakeArgs { own, ..args }, Company::Program(observer, cancel))
}

/// How many stages making an asset with these words takes, all told.
///
/// # Errors
/// [`Complaint`] where the words are not understood.
pub fn stages(words: impl IntoIterator<Item = OsString>) -> Result<usize, Complaint> {
    let Command::Make(args) = understood("make", words)? else { return Err(other("make")) };
    Ok(crate::image_to_urdf::of_any_photo(&args.exports()).stages())
}

/// Checks models; the words are those behind `kinfold check`.
///
/// # Errors
/// [`Complaint`], as the command line tells it.
pub fn check(words: impl IntoIterator<Item = OsString>) -> Result<Answer, Complaint> {
    match understood("check", words)? {
        Command::Check(args) => checking::check(&args),
        _ => Err(other("check")),
    }
}

/// Mends a model; the words are those behind `kinfold fix`.
///
/// # Errors
/// [`Complaint`], as the command line tells it.
pub fn fix(words: impl IntoIterator<Item = OsString>) -> Result<Answer, Complaint> {
    match understood("fix", words)? {
        Command::Fix(args) => fixing::fix(&args),
        _ => Err(other("fix")),
    }
}

/// Measures an articulator; the words are those behind `kinfold eval`.
///
/// # Errors
/// [`Complaint`], as the command line tells it.
pub fn eval(words: impl IntoIterator<Item = OsString>) -> Result<Answer, Complaint> {
    match understood("eval", words)? {
        Command::Eval(args) => evaluating::eval(&args),
        _ => Err(other("eval")),
    }
}

/// Makes many assets; the words are those behind `kinfold batch`. Whoever looks on is told of each item, and
/// the program stops it by itself.
///
/// # Errors
/// [`Complaint`], as the command line tells it.
pub fn batch(
    words: impl IntoIterator<Item = OsString>,
    onlooker: Arc<dyn Onlooker + Send + Sync>,
    cancel: Cancel,
) -> Result<Answer, Complaint> {
    match understood("batch", words)? {
        Command::Batch(args) => batches::with(&args, batches::Company::Program(onlooker, cancel)),
        _ => Err(other("batch")),
    }
}

/// Runs the flow of a trace again, or takes something out of it, which may take that; the words are those
/// behind `kinfold trace`. Its bounds are not watched over: that would end the program that asks.
///
/// # Errors
/// [`Complaint`], as the command line tells it.
pub fn trace(words: impl IntoIterator<Item = OsString>) -> Result<Answer, Complaint> {
    match understood("trace", words)? {
        Command::Trace(TraceCommand::Replay { file, out, json, .. }) => {
            trace_replay::replay(&meant(&file), out.as_deref(), json)
        }
        Command::Trace(TraceCommand::Extract { file, name, out, force, .. }) => {
            trace_extract::extract(&meant(&file), name.as_deref(), out.as_deref(), force)
        }
        _ => Err(other("trace replay")),
    }
}

fn understood(verb: &str, words: impl IntoIterator<Item = OsString>) -> Result<Command, Complaint> {
    layers::read_apart();
    let both = ["kinfold", verb].map(OsString::from).into_iter();
    let words: Vec<_> = both.chain(words).collect();
    Cli::try_parse_from(&words).map(|cli| cli.command).map_err(|error| {
        let told = super::misused(&error, &words);
        let mut lines = told.lines().map(str::trim).filter(|line| !line.is_empty());
        let first = lines.next().unwrap_or_default();
        let mut complaint = Complaint::misused(first.trim_start_matches("error: "));
        // What follows is usage of a command line, which a program does not see.
        complaint.causes =
            lines.take_while(|line| !line.starts_with("Usage:")).map(Into::into).collect();
        complaint
    })
}

fn other(verb: &str) -> Complaint {
    Complaint::misused(format!("the words are not those of `kinfold {verb}`"))
}
