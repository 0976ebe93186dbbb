//! `kinfold fix`: the smallest changes of a model's text that the checks approve of.
//!
//! Strangers' files are read, checked and mended in a process apart; this one shows the difference, or
//! writes it.

mod asked;
mod here;
mod told;
mod written;

use std::ffi::OsString;
use std::path::Path;

use self::asked::options;
use self::told::{Line, Made};
use crate::cli::args::{FixArgs, Kind, Standing};
use crate::cli::isolated::{Checker, Isolation};
use crate::cli::program;
use crate::cli::speech::{Answer, Complaint, Exit};
use crate::fix::remedies::REMEDIES;

/// Mends a model: shows the difference, or writes it.
///
/// # Errors
/// [`Complaint`] when there is no such file, it is no model, or it cannot be written.
pub fn fix(args: &FixArgs) -> Result<Answer, Complaint> {
    if args.list {
        return Ok(Answer::done(told::list(args.json)));
    }
    let Some(file) = &args.file else { return Err(Complaint::misused("names no file")) };
    known(&args.only)?;
    if args.here {
        return apart(args);
    }
    let failed = |e: std::io::Error| Complaint::failed(format!("{}: {e}", file.display()));
    if std::fs::metadata(file).map_err(failed)?.is_dir() {
        let message = format!("{} is a folder: one file is mended at a time", file.display());
        return Err(Complaint::misused(message).hint("`kinfold check` looks through folders"));
    }
    let isolation = isolation(args)?;
    let line = isolation.line(words(file, args)).map_err(|reason| {
        let complaint = Complaint::failed(format!("{}: {reason}", file.display()));
        complaint.hint("give it more time with --deadline, or less to do with --only")
    })?;
    let line: Line = serde_json::from_str(&line)
        .map_err(|e| Complaint::failed(format!("the answer of the other process is odd: {e}")))?;
    let made = match line {
        Line::Made(made) => made,
        Line::Complaint { message, hints } => {
            return Err(hints.into_iter().fold(Complaint::failed(message), Complaint::hint));
        }
    };
    let mut remarks = Vec::new();
    let written = args.write && made.new != made.old;
    if written {
        written::write(file, &made)?;
        remarks.extend(judged_again(file, &made, &isolation, args));
    }
    let result =
        if args.json { told::json(file, &made, written) } else { shown(file, &made, written) };
    remarks.extend(told::remarks(file, &made, args, written));
    Ok(Answer { result, remarks, exit: exit(&made) })
}

/// The part of it that a process apart does.
///
/// # Errors
/// [`Complaint`] when no file is named, or this process cannot be bounded.
pub(in crate::cli) fn apart(args: &FixArgs) -> Result<Answer, Complaint> {
    let Some(file) = &args.file else { return Err(Complaint::misused("names no file")) };
    here::answer(file, args)
}

/// Nothing is asked for that no way mends.
fn known(only: &[String]) -> Result<(), Complaint> {
    let rules: Vec<&str> = REMEDIES.iter().flat_map(|r| r.rules.iter().copied()).collect();
    match only.iter().find(|id| !rules.contains(&id.as_str())) {
        None => Ok(()),
        Some(id) => {
            let mut all = rules;
            all.sort_unstable();
            all.dedup();
            let complaint = Complaint::misused(format!("nothing mends what {id} finds"));
            let hint = format!(
                "--only takes {}; `kinfold explain {id}` says what a person can do",
                all.join(" ")
            );
            Err(complaint.hint(hint))
        }
    }
}

fn isolation(args: &FixArgs) -> Result<Isolation, Complaint> {
    let program = program::apart()
        .map_err(|e| Complaint::failed(format!("this program cannot find itself: {e}")))?;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    Ok(Isolation { program, deadline: args.deadline, threads })
}

/// The words that ask this program to mend a file, apart.
fn words(file: &Path, args: &FixArgs) -> Vec<OsString> {
    let mut all: Vec<String> = ["fix", "--here", "--seed"].map(String::from).into();
    all.push(args.seed.to_string());
    all.extend(["--deadline".into(), args.deadline.as_secs_f64().to_string()]);
    all.extend(args.only.iter().flat_map(|id| ["--only".to_owned(), id.clone()]));
    let set =
        [(args.flags, "--flags"), (args.allow_outside, "--allow-outside"), (args.ros, "--ros")];
    all.extend(set.into_iter().filter(|(is, _)| *is).map(|(_, word)| word.to_owned()));
    let subject = args.subject.map(|kind| match kind {
        Kind::Object => "object",
        Kind::Robot => "robot",
    });
    all.extend(subject.into_iter().flat_map(|word| ["--as".to_owned(), word.to_owned()]));
    let base = args.base.map(|base| match base {
        Standing::Fixed => "fixed",
        Standing::Free => "free",
    });
    all.extend(base.into_iter().flat_map(|word| ["--base".to_owned(), word.to_owned()]));
    for (name, value) in &args.env {
        all.extend(["--env".into(), format!("{name}={value}")]);
    }
    for (name, value) in &args.args {
        all.extend(["--arg".into(), format!("{name}={value}")]);
    }
    let mut all: Vec<OsString> = all.into_iter().map(OsString::from).collect();
    for (name, folder) in &args.packages {
        let mut told = OsString::from(format!("{name}="));
        told.push(folder);
        all.extend(["--package".into(), told]);
    }
    all.extend(args.srdf.iter().flat_map(|path| ["--srdf".into(), path.clone().into_os_string()]));
    all.extend(["--".into(), file.as_os_str().to_owned()]);
    all
}

/// The difference, or nothing where it was written.
fn shown(file: &Path, made: &Made, written: bool) -> String {
    if written { String::new() } else { told::diff(file, &made.old, &made.new) }
}

/// What was promised of the file that was written, asked once more of the file itself.
fn judged_again(file: &Path, made: &Made, isolation: &Isolation, args: &FixArgs) -> Option<String> {
    let options = options(args);
    let verdict = Checker::new(isolation, &options).check(file);
    let told = |v: &sim_check::Verdict| -> Vec<(String, sim_check::Status)> {
        v.checks.iter().map(|c| (c.id.clone(), c.status)).collect()
    };
    (told(&verdict) != told(&made.after)).then(|| {
        format!(
            "warning: the file as written reaches tier {}, not {} as was promised",
            verdict.tier.name(),
            made.after.tier.name()
        )
    })
}

fn exit(made: &Made) -> Exit {
    match made.after.failures().next() {
        None => Exit::Done,
        Some(_) if made.is_model => Exit::Losses,
        Some(_) => Exit::Failed,
    }
}
