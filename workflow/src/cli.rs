//! The command line: what can be asked, and how the program answers.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use adapters::terms::Policy;
use clap::error::ErrorKind;
use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use serde::de::IgnoredAny;
use sim_check::Tier;
use sim_check::profile::RULES;
use trace::Time;

mod bulk;
mod engines;
mod learning;
mod looks;

pub use bulk::{AuditArgs, AuditCommand, BatchArgs, BatchCommand, StoreCommand};
pub use engines::{EngineArgs, EngineName, WorkerArgs};
pub use learning::{
    ArticulatorName, EvalArgs, Labels, ModeName, PrecisionName, SetName, TrainArgs, WeightsCommand,
    Withheld,
};
pub use looks::BoundsArgs;

use crate::commands;
use crate::moment;
use crate::speech::{Answer, Complaint, Exit};
use crate::stages::Export;

const EXIT_CODES: &str = "\
Exit codes: 0 done, 1 failed, 2 misused, 3 done with losses or below the tier, 130 interrupted (run it again to go on)";

/// One photo in, one articulated, simulation-ready URDF out, checked and traced.
#[derive(Debug, Parser)]
#[command(name = "kinfold", version, after_help = EXIT_CODES)]
#[command(subcommand_required = true, arg_required_else_help = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Make a URDF from a photo, and MJCF, USD and GLB of it
    Make(MakeArgs),
    /// Make many: a manifest of photos, killed and resumed at any moment
    Batch(BatchArgs),
    /// Do stages for batches on other machines
    Worker(WorkerArgs),
    /// Check any URDFs or MJCF models and say how far they get
    Check(CheckArgs),
    /// Say whether a batch still is what it was, or what stands in its ledger
    Audit(AuditArgs),
    /// Tidy up what is kept of finished stages, or look for what rotted
    #[command(subcommand)]
    Store(StoreCommand),
    /// Look into a trace
    #[command(subcommand)]
    Trace(TraceCommand),
    /// List whom `kinfold.toml` can name, what each needs, and what its licence allows
    Providers(ProvidersArgs),
    /// Say what is configured, what answers, whether the model can point, and what is missing
    Doctor(DoctorArgs),
    /// Approve a `kinfold.toml` found in a folder, once you read it
    Trust(TrustArgs),
    /// Measure an articulator on objects whose parts and joints are known
    Eval(EvalArgs),
    /// Prepare weights for the articulation model
    #[command(subcommand)]
    Weights(WeightsCommand),
    /// Train weights for the articulation model
    Train(TrainArgs),
    /// Print a JSON Schema, for editors
    Schema {
        /// Which file's schema
        #[arg(value_enum)]
        of: SchemaOf,
    },
    /// Print completions for a shell
    Completions {
        /// The shell
        #[arg(value_enum)]
        shell: Shell,
    },
}

/// Arguments of `kinfold make`.
#[derive(Args, Debug)]
pub struct MakeArgs {
    /// The photo: PNG, JPEG or WebP
    #[arg(value_name = "PHOTO")]
    pub photo: PathBuf,
    /// A mesh of the object, GLB or OBJ with y up, instead of a generator's
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,
    /// A kinematic condition, instead of a vision-language model's
    #[arg(long, value_name = "FILE")]
    pub condition: Option<PathBuf>,
    /// Who else is asked for them [default: ./kinfold.toml, where there is one]
    #[arg(long, value_name = "FILE", env = "KINFOLD_CONFIG")]
    pub config: Option<PathBuf>,
    /// Let a kinfold.toml found here act this once, without approving it
    #[arg(long)]
    pub trust_config: bool,
    /// What the asset is meant for: any, or words of commercial, eu, uk and kr with - between, such as
    /// commercial-eu; providers that are not known to allow it are refused before anything is spent
    #[arg(long, value_name = "POLICY", default_value = "any", env = "KINFOLD_POLICY")]
    pub policy: Policy,
    /// Where the asset goes [default: ./<photo's name>.kinfold]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Formats to write, with commas between: urdf (always written), mjcf, usd, glb
    #[arg(long, value_name = "FORMAT", value_enum, value_delimiter = ',', default_value = "urdf")]
    #[arg(hide_possible_values = true)]
    pub export: Vec<Export>,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// The tier asked for: an asset below it exits 3, and takes no better one's place
    #[arg(long, value_name = "TIER", default_value = "kinematic", value_parser = bulk::made_tier)]
    pub tier: Tier,
    /// Where finished stages are kept [default: ~/.cache/kinfold]
    #[arg(long, value_name = "DIR", env = "KINFOLD_STATE")]
    pub state: Option<PathBuf>,
    /// Where another run is at work in one of the folders, be refused instead of waiting for it
    #[arg(long)]
    pub no_wait: bool,
    /// Say which stages would run, and why; change nothing
    #[arg(long, conflicts_with = "graph")]
    pub dry_run: bool,
    /// Print the flow as Graphviz and stop
    #[arg(long)]
    pub graph: bool,
    /// Answer in JSON
    #[arg(long)]
    pub json: bool,
    /// Time written into the trace, for runs that repeat byte for byte: RFC 3339 or nanoseconds
    #[arg(long, value_name = "TIME", value_parser = moment::parse)]
    pub clock: Option<Time>,
    /// Say nothing on the way
    #[arg(long, short)]
    pub quiet: bool,
}

/// Arguments of `kinfold check`.
#[derive(Args, Debug)]
pub struct CheckArgs {
    /// URDF or MJCF files, or folders to look through for URDFs
    #[arg(value_name = "PATH", required = true)]
    pub paths: Vec<PathBuf>,
    /// Answer in JSON: a verdict, or for several files a line each
    #[arg(long)]
    pub json: bool,
    /// The tier asked for: exit 0 if it is reached, 3 if only a lower one is, 1 if none; of several
    /// files the worst decides
    #[arg(long, value_name = "TIER", default_value = "kinematic", value_parser = tier)]
    pub tier: Tier,
    /// Let a failure pass that you answer for, such as --waive C1="a pin sits in its hole"; it
    /// stands in the verdict. What is unknown cannot be waived
    #[arg(long, value_name = "ID=REASON", value_parser = waiver)]
    pub waive: Vec<(String, String)>,
    /// Let meshes lie outside the file's folder
    #[arg(long)]
    pub allow_outside: bool,
    /// Write a JUnit report for build servers, too
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
    /// Files to check at a time; threads, where there are fewer files [default: one per core]
    #[arg(long, value_name = "N", value_parser = at_least_one)]
    pub jobs: Option<usize>,
    /// Longest time for one file; one that takes longer is unknown, which is a failure
    #[arg(long, value_name = "SECONDS", default_value = "120", value_parser = seconds)]
    pub deadline: Duration,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Check in this very process
    #[arg(long, hide = true)]
    pub here: bool,
}

/// Arguments of `kinfold providers`.
#[derive(Args, Debug)]
pub struct ProvidersArgs {
    /// The configuration whose providers are marked [default: ./kinfold.toml, where there is one]
    #[arg(long, value_name = "FILE", env = "KINFOLD_CONFIG")]
    pub config: Option<PathBuf>,
    /// Answer in JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `kinfold trust`.
#[derive(Args, Debug)]
pub struct TrustArgs {
    /// The configuration [default: ./kinfold.toml]
    #[arg(value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// List what was approved
    #[arg(long, conflicts_with_all = ["file", "remove"])]
    pub list: bool,
    /// Take the approval back
    #[arg(long)]
    pub remove: bool,
    /// Answer in JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `kinfold doctor`.
#[derive(Args, Debug)]
pub struct DoctorArgs {
    /// The configuration [default: ./kinfold.toml, where there is one]
    #[arg(long, value_name = "FILE", env = "KINFOLD_CONFIG")]
    pub config: Option<PathBuf>,
    /// Let a kinfold.toml found here act this once, without approving it
    #[arg(long)]
    pub trust_config: bool,
    /// Where finished stages, calls and accounts are kept [default: ~/.cache/kinfold]
    #[arg(long, value_name = "DIR", env = "KINFOLD_STATE")]
    pub state: Option<PathBuf>,
    /// Ask nobody anything: no network, no program, no key is used; only what stands in the
    /// configuration and on this machine is looked at
    #[arg(long)]
    pub offline: bool,
    /// Ask the model nothing; the test of its pointing is one short call, which may cost a little
    #[arg(long)]
    pub free: bool,
    /// Answer in JSON
    #[arg(long)]
    pub json: bool,
}

/// `kinfold trace ...`
#[derive(Debug, Subcommand)]
pub enum TraceCommand {
    /// Show what happened in a run, and how far it went
    Show {
        /// The trace, an MCAP file
        #[arg(value_name = "FILE")]
        file: PathBuf,
        /// Answer in JSON
        #[arg(long)]
        json: bool,
        /// How long it may take, and how much memory
        #[command(flatten)]
        bounds: BoundsArgs,
    },
    /// Run a trace's whole flow again, without a network, and compare every artefact
    ///
    /// The photo, the condition and everything a service answered stand in the trace. Exit 1 and the
    /// first stage that differs, if one does.
    Replay {
        /// The trace, an MCAP file
        #[arg(value_name = "FILE")]
        file: PathBuf,
        /// Write the files here, too, with the trace they follow from
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
        /// Answer in JSON
        #[arg(long)]
        json: bool,
        /// How long it may take, and how much memory
        #[command(flatten)]
        bounds: BoundsArgs,
    },
    /// Prove that the files beside a trace follow from it, digest by digest
    ///
    /// Every bit of the trace must be as it was sealed, every stage's inputs what stages before it
    /// made, every file the one that the trace names, and no file of ours there that it does not
    /// name. Exit 1 and the first difference otherwise. A seal gives damage away; against forgery
    /// ask for a signature with --key, or run the trace again (`kinfold trace replay`).
    Verify {
        /// The trace, an MCAP file
        #[arg(value_name = "FILE")]
        file: PathBuf,
        /// Where the files lie [default: beside the trace]
        #[arg(long, value_name = "DIR")]
        files: Option<PathBuf>,
        /// A public key that FILE.minisig must be made with: a file of minisign, or of
        /// `kinfold trace keygen`
        #[arg(long, value_name = "PUBLIC")]
        key: Option<PathBuf>,
        /// Answer in JSON
        #[arg(long)]
        json: bool,
        /// How long it may take, and how much memory
        #[command(flatten)]
        bounds: BoundsArgs,
    },
    /// Sign a trace, so that others can tell who made it; FILE.minisig lies beside it
    ///
    /// `minisign -V` judges it, and `kinfold trace verify --key PUBLIC`.
    Sign {
        /// The trace, an MCAP file
        #[arg(value_name = "FILE")]
        file: PathBuf,
        /// The secret key: of minisign without a password, or of `kinfold trace keygen`
        #[arg(long, value_name = "SECRET")]
        key: PathBuf,
        /// Time that stands in the signature; none does without it
        #[arg(long, value_name = "TIME", value_parser = moment::parse)]
        clock: Option<Time>,
        /// Answer in JSON
        #[arg(long)]
        json: bool,
    },
    /// Draw a key to sign with: NAME.key, to be kept secret, and NAME.pub, to be given away
    Keygen {
        /// How the files begin
        #[arg(value_name = "NAME")]
        name: PathBuf,
        /// Answer in JSON
        #[arg(long)]
        json: bool,
    },
    /// Say which input, stage, request or number differs between two traces; exit 1 if one does
    Diff {
        /// A trace
        #[arg(value_name = "A")]
        a: PathBuf,
        /// Another
        #[arg(value_name = "B")]
        b: PathBuf,
        /// Answer in JSON
        #[arg(long)]
        json: bool,
        /// How long it may take, and how much memory
        #[command(flatten)]
        bounds: BoundsArgs,
    },
    /// Write an artefact of a run to a file, or list them
    Extract {
        /// The trace, an MCAP file
        #[arg(value_name = "FILE")]
        file: PathBuf,
        /// Which artefact, such as condition.json; all are listed without it
        #[arg(value_name = "NAME")]
        name: Option<String>,
        /// Where it goes [default: ./ and its own name]
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
        /// Write over a file that is there
        #[arg(long)]
        force: bool,
        /// How long it may take, and how much memory
        #[command(flatten)]
        bounds: BoundsArgs,
    },
}

impl MakeArgs {
    /// The formats asked for, each once, in a fixed order; URDF always.
    pub fn exports(&self) -> Vec<Export> {
        let asked = self.export.iter().copied().chain([Export::Urdf]);
        asked.collect::<BTreeSet<_>>().into_iter().collect()
    }
}

/// Files that have a schema.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub enum SchemaOf {
    /// The kinematic condition
    Condition,
}

fn tier(text: &str) -> Result<Tier, String> {
    let known = || Tier::ALL.into_iter().skip(1);
    known().find(|t| t.name() == text).ok_or_else(|| {
        let names: Vec<_> = known().map(Tier::name).collect();
        format!("expected one of {}, found `{text}`", names.join(", "))
    })
}

fn waiver(text: &str) -> Result<(String, String), String> {
    let (id, reason) = text.split_once('=').unwrap_or((text, ""));
    if !RULES.iter().any(|r| r.id == id) {
        let ids: Vec<_> = RULES.iter().map(|r| r.id).collect();
        return Err(format!(
            "expected the id of a check, found `{id}`; there are {}",
            ids.join(" ")
        ));
    }
    match reason.trim() {
        "" => Err(format!("expected a reason, as in {id}=\"why this may be\"")),
        reason => Ok((id.to_owned(), reason.to_owned())),
    }
}

fn at_least_one(text: &str) -> Result<usize, String> {
    let number = text.parse().ok().filter(|&n| n > 0);
    number.ok_or_else(|| format!("expected a number of at least 1, found `{text}`"))
}

fn seconds(text: &str) -> Result<Duration, String> {
    let number = text.parse::<f64>().ok().filter(|s| *s > 0.0);
    let duration = number.and_then(|s| Duration::try_from_secs_f64(s).ok());
    duration.ok_or_else(|| format!("expected a number of seconds above 0, found `{text}`"))
}

/// Reads the command line, does what it says, and tells the shell how it went.
pub fn main() -> ExitCode {
    // A program of the user's is looked after by this one, started once more.
    if let Some(code) = adapters::keeper::asked(std::env::args_os()) {
        return code;
    }
    let exit = match Cli::try_parse() {
        Ok(cli) => match answer(cli.command) {
            Ok(answer) => speak(&answer.result, &answer.remarks, answer.exit),
            Err(complaint) => speak(&complaint.result, &complaint.lines(), complaint.exit),
        },
        Err(error) => {
            let asked = matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion);
            // Nobody may be listening; then there is nobody to tell.
            let _ = if error.use_stderr() {
                write!(std::io::stderr(), "{}", misused(&error))
            } else {
                error.print()
            };
            if asked { Exit::Done } else { Exit::Misused }
        }
    };
    ExitCode::from(exit as u8)
}

fn answer(command: Command) -> Result<Answer, Complaint> {
    let _watch = looks::watch(&command);
    match command {
        Command::Make(args) => commands::make::make(&args),
        Command::Batch(args) => commands::batch::batch(&args),
        Command::Worker(args) => commands::worker::worker(&args),
        Command::Audit(args) => commands::audit::audit(&args),
        Command::Store(command) => commands::store::store(&command),
        Command::Check(args) => commands::check::check(&args),
        Command::Providers(args) => commands::provider_list::list(&args),
        Command::Doctor(args) => commands::doctor::doctor(&args),
        Command::Trust(args) => commands::trust::trust(&args),
        Command::Eval(args) => commands::eval::eval(&args),
        Command::Trace(command) => trace_answer(command),
        Command::Weights(WeightsCommand::Convert { file, out, state_dict_only }) => {
            commands::weights::convert(&file, out.as_deref(), state_dict_only)
        }
        Command::Train(args) => commands::train::run(&args),
        Command::Schema { of: SchemaOf::Condition } => commands::schema::condition(),
        Command::Completions { shell } => Ok(commands::completions::completions(shell)),
    }
}

fn trace_answer(command: TraceCommand) -> Result<Answer, Complaint> {
    match command {
        TraceCommand::Show { file, json, .. } => commands::trace::show(&file, json),
        TraceCommand::Replay { file, out, json, .. } => {
            commands::trace_replay::replay(&file, out.as_deref(), json)
        }
        TraceCommand::Verify { file, files, key, json, .. } => {
            commands::trace_verify::verify(&file, files.as_deref(), key.as_deref(), json)
        }
        TraceCommand::Sign { file, key, clock, json } => {
            commands::signing::sign_trace(&file, &key, clock, json)
        }
        TraceCommand::Keygen { name, json } => commands::signing::keygen(&name, json),
        TraceCommand::Diff { a, b, json, .. } => commands::trace_diff::diff(&a, &b, json),
        TraceCommand::Extract { file, name, out, force, .. } => {
            commands::trace_extract::extract(&file, name.as_deref(), out.as_deref(), force)
        }
    }
}

/// Results to stdout, everything else to stderr: whatever words of strangers stand in it, it is
/// inert, and a remark is one line. A reader who went away is no failure, a disk that
/// is full behind stdout is.
fn speak(result: &str, remarks: &[String], exit: Exit) -> Exit {
    let mut stderr = std::io::stderr().lock();
    for remark in remarks {
        let _ = writeln!(stderr, "{}", guard::text::shown(remark));
    }
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(printable(result).as_bytes()).and_then(|()| stdout.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            let _ = writeln!(stderr, "error: the result cannot be printed: {e}");
            Exit::Failed
        }
        _ => exit,
    }
}

/// What is wrong with the command line. It quotes arguments, which may be names of files that
/// somebody else chose: the same is said of arguments that are inert.
fn misused(error: &clap::Error) -> String {
    let words: Vec<_> = std::env::args_os().map(|a| a.to_string_lossy().into_owned()).collect();
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
    if is_json { guard::text::json(result) } else { guard::text::lines(result) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn a_waiver_names_a_check_and_a_reason() {
        assert_eq!(waiver("C1=a = b"), Ok(("C1".into(), "a = b".into())));
        assert!(waiver("C9=why").unwrap_err().contains("found `C9`; there are F1 F2"));
        assert!(waiver("C1").unwrap_err().contains("C1=\"why this may be\""));
        assert!(waiver("C1= ").is_err());
    }

    #[test]
    fn a_deadline_is_a_time_above_nothing() {
        assert_eq!(seconds("0.5"), Ok(Duration::from_millis(500)));
        assert!(["0", "-1", "nan", "1e300", "soon"].iter().all(|t| seconds(t).is_err()));
    }

    #[test]
    fn a_tier_is_read_by_its_name() {
        assert_eq!(tier("dynamic"), Ok(Tier::Dynamic));
        assert!(tier("great").unwrap_err().contains("parse, static, kinematic, dynamic, audited"));
    }
}
