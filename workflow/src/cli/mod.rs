//! The command line: what can be asked, and how the program answers. Nothing outside of this folder
//! knows of it.
//!
//! [`args`] reads what is asked, [`commands`] do it, and what they say ends in a
//! [`speech::Answer`] or a [`speech::Complaint`].

use std::borrow::Cow;
use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;

use clap::Parser as _;
use clap::error::ErrorKind;
use serde::de::IgnoredAny;

pub mod apart;
pub mod args;
pub mod asked;
mod colour;
pub mod commands;
pub mod isolated;
mod layers;
mod looks;
pub mod program;
pub mod progress;
pub mod speech;
pub mod trust;
pub mod watch;

use args::{Cli, Command, SchemaOf, TraceCommand, WeightsCommand};
use commands::sealed::meant;
use speech::{Answer, Complaint, Exit};

/// Reads the command line, does what it says, and tells the shell how it went.
pub fn main() -> ExitCode {
    // A program of the user's is looked after by this one, started once more.
    if let Some(code) = adapters::keeper::asked(std::env::args_os()) {
        return code;
    }
    if let Some(code) = layers::asked(std::env::args_os()) {
        return code;
    }
    ExitCode::from(with(std::env::args_os().collect()) as u8)
}

/// The same with these words, the first of which is the program's name, inside another program: reads them, has
/// them answered, and says what there is to say.
pub fn with(words: Vec<OsString>) -> Exit {
    layers::read_apart();
    match Cli::try_parse_from(&words) {
        Ok(cli) => {
            let in_colour = colour::wanted(&cli.command);
            match answer(cli.command) {
                Ok(answer) => speak(&answer.result, &answer.remarks, (answer.exit, in_colour)),
                Err(told) => speak(&told.result, &told.lines(), (told.exit, false)),
            }
        }
        Err(error) => {
            let asked = matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion);
            // Nobody may be listening; then there is nobody to tell.
            let _ = if error.use_stderr() {
                write!(std::io::stderr(), "{}", misused(&error, &words))
            } else {
                error.print()
            };
            if asked { Exit::Done } else { Exit::Misused }
        }
    }
}

fn answer(command: Command) -> Result<Answer, Complaint> {
    let _watch = looks::watch(&command);
    match command {
        Command::Init(args) => commands::init::init(&args.folder, args.json),
        Command::Points(args) => commands::points::points(&args),
        Command::Make(args) => commands::make::make(&args),
        Command::Batch(args) => commands::batch::batch(&args),
        Command::Worker(args) => commands::worker::worker(&args),
        Command::Audit(args) => commands::audit::audit(&args),
        Command::Store(command) => commands::store::store(&command),
        Command::Check(args) => commands::check::check(&args),
        Command::Scan(args) => commands::check::scan(&args),
        Command::Fix(args) => commands::fix::fix(&args),
        Command::Mutate(args) => commands::mutate::mutate(&args),
        Command::BenchCheck(args) => commands::bench_check::bench(&args),
        Command::Explain(args) => commands::explain::explain(&args),
        Command::View(args) => commands::view::view(&args),
        Command::Studio(args) => commands::studio::studio(&args),
        Command::Serve(args) => commands::serve::serve(&args),
        Command::Providers(args) => commands::provider_list::list(&args),
        Command::Doctor(args) => commands::doctor::doctor(&args),
        Command::Trust(args) => commands::trust::trust(&args),
        Command::Eval(args) => commands::eval::eval(&args),
        Command::Trace(command) => trace_answer(command),
        Command::Weights(WeightsCommand::Convert { file, out, state_dict_only }) => {
            commands::weights::convert(&file, out.as_deref(), state_dict_only)
        }
        Command::Weights(WeightsCommand::Show { file, json }) => {
            commands::weights::show(&file, json)
        }
        Command::Train(args) => commands::train::run(&args),
        Command::Schema { of: SchemaOf::Condition } => commands::schema::condition(),
        Command::Completions { shell } => Ok(commands::completions::completions(shell)),
    }
}

fn trace_answer(command: TraceCommand) -> Result<Answer, Complaint> {
    match command {
        TraceCommand::Show { file, json, .. } => commands::trace::show(&meant(&file), json),
        TraceCommand::Replay { file, out, json, .. } => {
            commands::trace_replay::replay(&meant(&file), out.as_deref(), json)
        }
        TraceCommand::Verify { file, files, key, verbose, json, .. } => {
            let (file, told) = (meant(&file), (verbose, json));
            commands::trace_verify::verify(&file, files.as_deref(), key.as_deref(), told)
        }
        TraceCommand::Sign { file, key, clock, json } => {
            commands::signing::sign_trace(&file, &key, clock, json)
        }
        TraceCommand::Keygen { name, json } => commands::signing::keygen(&name, json),
        TraceCommand::Diff { a, b, json, .. } => {
            commands::trace_diff::diff(&meant(&a), &meant(&b), json)
        }
        TraceCommand::Extract { file, name, out, force, .. } => {
            commands::trace_extract::extract(&meant(&file), name.as_deref(), out.as_deref(), force)
        }
    }
}

/// Results to stdout, everything else to stderr: whatever words of strangers stand in it, it is
/// inert, and a remark is one line. A reader who went away is no failure, a disk that
/// is full behind stdout is.
fn speak(result: &str, remarks: &[String], (exit, in_colour): (Exit, bool)) -> Exit {
    let mut stderr = std::io::stderr().lock();
    for remark in remarks {
        let _ = writeln!(stderr, "{}", guard::text::shown(remark));
    }
    let mut stdout = std::io::stdout().lock();
    let mut text = printable(result);
    if in_colour {
        text = Cow::Owned(colour::painted(&text));
    }
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            let _ = writeln!(stderr, "error: the result cannot be printed: {e}");
            Exit::Failed
        }
        _ => exit,
    }
}

/// What is wrong with the command line. It quotes arguments, which may be names of files that
/// somebody else chose: the same is said of arguments that are inert.
fn misused(error: &clap::Error, words: &[OsString]) -> String {
    let words: Vec<_> = words.iter().map(|a| a.to_string_lossy().into_owned()).collect();
    let inert: Vec<_> = words.iter().map(|word| guard::text::shown(word)).collect();
    let told = if inert.iter().all(|word| matches!(word, Cow::Borrowed(_))) {
        error.render().to_string()
    } else {
        let again = Cli::try_parse_from(inert.iter().map(|word| word.as_ref()));
        let told = again.err().map(|e| e.render().to_string());
        told.unwrap_or_else(|| "error: an argument is not understood\n".into())
    };
    guard::text::lines(&told).into_owned()
}

/// A result as it may be printed: JSON with its own escapes, else lines.
fn printable(result: &str) -> Cow<'_, str> {
    let is_json = result.starts_with(['{', '['])
        && serde_json::Deserializer::from_str(result).into_iter::<IgnoredAny>().all(|v| v.is_ok());
    if is_json { guard::text::json(result) } else { lines(result) }
}

/// Lines as they may be printed. A diff of a file whose lines end as on Windows keeps those ends, or
/// nobody could apply it: before a line feed a carriage return does nothing.
fn lines(result: &str) -> Cow<'_, str> {
    if !(result.starts_with("--- ") && result.contains("\r\n")) {
        return guard::text::lines(result);
    }
    let told = result.split("\r\n").map(guard::text::lines);
    Cow::Owned(told.collect::<Vec<_>>().join("\r\n"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn a_diff_keeps_its_line_ends_and_nothing_else_that_acts() {
        assert_eq!(printable("--- a\n-x\r\n+\ry\u{1b}\r\n"), "--- a\n-x\r\n+\\u{d}y\\u{1b}\r\n");
        assert_eq!(printable("x\r\n"), "x\\u{d}\n");
    }

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
