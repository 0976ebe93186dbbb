//! The verbs.

use clap::{Parser, Subcommand};
use clap_complete::Shell;

use super::begin::{InitArgs, PointsArgs};
use super::bulk::{AuditArgs, BatchArgs, StoreCommand};
use super::check::{CheckArgs, ExplainArgs, ScanArgs};
use super::engines::WorkerArgs;
use super::fix::FixArgs;
use super::learning::{EvalArgs, TrainArgs, WeightsCommand};
use super::make::MakeArgs;
use super::mutate::{BenchArgs, MutateArgs};
use super::providers::{DoctorArgs, ProvidersArgs, TrustArgs};
use super::serve::ServeArgs;
use super::studio::StudioArgs;
use super::trace::TraceCommand;
use super::view::ViewArgs;

const EXIT_CODES: &str = "\
Exit codes: 0 done, 1 failed, 2 misused, 3 done with losses or below the tier, 130 interrupted (run it again to go on)";

/// One photo in, one articulated, simulation-ready URDF out, checked and traced.
#[derive(Debug, Parser)]
#[command(name = "kinfold", version, after_help = EXIT_CODES)]
#[command(subcommand_required = true, arg_required_else_help = true)]
pub struct Cli {
    /// What is asked for.
    #[command(subcommand)]
    pub command: Command,
}

/// What can be asked for.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Write a condition and a kinfold.toml to begin with, every field explained
    Init(InitArgs),
    /// Show where points of a mesh are: views with a grid, and a table of pixels and points
    Points(PointsArgs),
    /// Make a URDF from a photo, and MJCF, USD and GLB of it
    Make(MakeArgs),
    /// Make many: a manifest of photos, killed and resumed at any moment
    Batch(BatchArgs),
    /// Do stages for batches on other machines
    Worker(WorkerArgs),
    /// Check any URDF, MJCF, SDFormat or USD models and say how far they get
    Check(CheckArgs),
    /// Check every model of a library and say what keeps most of them back
    Scan(ScanArgs),
    /// Mend a URDF or MJCF model by the smallest changes of its text, and show them as a diff
    Fix(FixArgs),
    /// Plant defects of known kinds in a sound model, each in a folder of its own
    Mutate(MutateArgs),
    /// Say what a checker finds of planted defects: `kinfold check` itself, or any program
    BenchCheck(BenchArgs),
    /// Say why a check matters, how it is measured and how to mend what fails it
    Explain(ExplainArgs),
    /// Make a page that shows any URDF or MJCF model in a browser, and what a check finds in it
    View(ViewArgs),
    /// See, steer and correct one object on a page of this machine, and build it there
    Studio(StudioArgs),
    /// Make assets for programs that ask over the network, and for several people
    Serve(ServeArgs),
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

/// Files that have a schema.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub enum SchemaOf {
    /// The kinematic condition
    Condition,
}
