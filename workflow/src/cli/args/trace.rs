//! Arguments of `kinfold trace ...`.

use std::path::PathBuf;

use clap::Subcommand;
use trace::{Time, moment};

use super::bounds::BoundsArgs;

/// `kinfold trace ...`
#[derive(Debug, Subcommand)]
pub enum TraceCommand {
    /// Show what happened in a run, and how far it went
    Show {
        /// The trace, an MCAP file, or the folder of its asset
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
        /// The trace, an MCAP file, or the folder of its asset
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
        /// The trace, an MCAP file, or the folder of its asset
        #[arg(value_name = "FILE")]
        file: PathBuf,
        /// Where the files lie [default: beside the trace]
        #[arg(long, value_name = "DIR")]
        files: Option<PathBuf>,
        /// A public key that FILE.minisig must be made with: a file of minisign, or of
        /// `kinfold trace keygen`
        #[arg(long, value_name = "PUBLIC")]
        key: Option<PathBuf>,
        /// List the files, each with its digest
        #[arg(long, short)]
        verbose: bool,
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
        /// The trace, an MCAP file, or the folder of its asset
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
