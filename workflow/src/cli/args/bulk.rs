//! Arguments of the commands that work on many assets.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Subcommand};
use runner::Address;
use sim_check::Tier;
use trace::{Time, moment};

use super::bounds::BoundsArgs;
use super::engines::EngineArgs;
use super::parse::{amount, at_least_one, made_tier, probability, seconds, share};
use crate::batch::Class;
use crate::batch::plan::Share;
use crate::stages::Export;

const BATCH_HELP: &str = "\
Examples:
  kinfold batch items.jsonl --out assets --dry-run         what would be made, asked for and paid
  kinfold batch items.jsonl --out assets --jobs 4          make them; again, to go on where it was
  kinfold batch photos/ --out assets --max-calls 200       a folder of photos, at most 200 requests
  kinfold batch items.jsonl --out assets --retry provider  ask once more what was lost
  kinfold batch report assets                              one page about it: report.html

A line of the manifest, as JSON (or the same as columns of a .csv file; or a folder of photos):

    {\"id\": \"kettle-7\", \"photo\": \"kettle.jpg\", \"category\": \"kettle\", \"license\": \"CC0-1.0\"}

Only `photo` must; `mesh`, `condition`, `seed` and `min_confidence` may stand in it, too. Paths are
relative to the manifest. DIR then holds assets/ID as `kinfold make` writes it, quarantine/ID with the
reason for what was not accepted, ledger.sqlite with every outcome, and index.parquet.

Run the same command again to go on: an item with an outcome is not looked at again, a finished
stage never repeated, and a question that was answered never asked again. Items that met a passing
trouble or an empty purse are tried again by themselves, those of other classes with --retry CLASS.
A request whose answer was lost may have been charged, so --retry provider alone asks once more.

What was accepted stays until something better than a failure takes its place, and files of yours
beside it stay, too. One batch at a time works in DIR: another one waits, and says for whom.

Exit codes: 0 everything was accepted, 1 it could not go on, 2 misused, 3 some items or lines were
not accepted, 130 interrupted";

/// `kinfold batch ...`
#[derive(Debug, Subcommand)]
pub enum BatchCommand {
    /// Write index.parquet and report.html of a batch: yield, failures, cost, times, gallery
    Report {
        /// The batch's folder
        #[arg(value_name = "DIR")]
        folder: PathBuf,
        /// Answer in JSON
        #[arg(long)]
        json: bool,
    },
}

/// Arguments of `kinfold batch`.
#[derive(Args, Debug)]
#[command(after_help = BATCH_HELP)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct BatchArgs {
    /// What else can be asked of a batch
    #[command(subcommand)]
    pub command: Option<BatchCommand>,
    /// The manifest: JSON Lines, a .csv file, or a folder of photos
    #[arg(value_name = "MANIFEST", required = true)]
    pub manifest: Option<PathBuf>,
    /// Where assets, quarantine and ledger go
    #[arg(long, value_name = "DIR", required = true)]
    pub out: Option<PathBuf>,
    /// Who is asked for meshes and conditions [default: ./kinfold.toml, where there is one]
    #[arg(long, value_name = "FILE", env = "KINFOLD_CONFIG")]
    pub config: Option<PathBuf>,
    /// Let a kinfold.toml found here act this once, without approving it
    #[arg(long)]
    pub trust_config: bool,
    /// Formats to write, with commas between: urdf (always written), mjcf, usd, usdz, glb, sdf, ros,
    /// isaaclab, simready
    #[arg(long, value_name = "FORMAT", value_enum, value_delimiter = ',', default_value = "urdf")]
    #[arg(hide_possible_values = true)]
    pub export: Vec<Export>,
    /// Write for each asset, as `kinfold make` does, a page, `viewer.html`, and pictures of its parts and
    /// its motion, `parts.png` and `motion.webp`; the report links to them
    #[arg(long)]
    pub pages: bool,
    /// The tier an asset is accepted from
    #[arg(long, value_name = "TIER", default_value = "kinematic", value_parser = made_tier)]
    pub tier: Tier,
    /// The probability asked for that every part and joint is right, 0 to 1, of items that name none in
    /// `min_confidence`: what is less sure is not accepted
    #[arg(long, value_name = "P", value_parser = probability)]
    pub min_confidence: Option<f64>,
    /// Seed of items that name none
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Stages that compute at a time [default: one per core; on Restate 32]
    #[arg(long, value_name = "N", value_parser = at_least_one)]
    pub jobs: Option<usize>,
    /// Meshes asked for at a time
    #[arg(long, value_name = "N", default_value = "4", value_parser = at_least_one)]
    pub mesh_calls: usize,
    /// Conditions asked for at a time
    #[arg(long, value_name = "N", default_value = "4", value_parser = at_least_one)]
    pub condition_calls: usize,
    /// Most requests that may cost, over all runs of this batch: a mesh is one, a condition three,
    /// a critique one, and each repair and each repeat one more; lost and killed ones count
    #[arg(long, value_name = "N")]
    pub max_calls: Option<u64>,
    /// Most cost of them, in the currency of the prices
    #[arg(long, value_name = "AMOUNT", value_parser = amount)]
    pub max_cost: Option<f64>,
    /// What a mesh costs
    #[arg(long, value_name = "AMOUNT", default_value = "0", value_parser = amount)]
    pub mesh_price: f64,
    /// What a condition costs; each of its requests counts as a third of it, a critique as one
    #[arg(long, value_name = "AMOUNT", default_value = "0", value_parser = amount)]
    pub condition_price: f64,
    /// Classes of failures to try again: input, provider, model, geometry, verdict
    #[arg(long, value_name = "CLASS", value_enum, value_delimiter = ',')]
    #[arg(hide_possible_values = true)]
    pub retry: Vec<Class>,
    /// Only the K-th of N shares, K from 0: for array jobs; goes to DIR/shard-K-of-N
    #[arg(long, value_name = "K/N", value_parser = share)]
    pub shard: Option<Share>,
    /// Where finished stages are kept [default: DIR/state]
    #[arg(long, value_name = "DIR")]
    pub state: Option<PathBuf>,
    /// What several machines share: finished stages of all of them are found there. A folder, or
    /// s3://BUCKET/PREFIX, gs://BUCKET/PREFIX, az://CONTAINER/PREFIX with keys from the environment
    #[arg(long, value_name = "ADDRESS")]
    pub store: Option<Address>,
    /// Where stages run
    #[command(flatten)]
    pub engines: EngineArgs,
    /// Say what would be done and asked for; change nothing
    #[arg(long)]
    pub dry_run: bool,
    /// Answer in JSON
    #[arg(long)]
    pub json: bool,
    /// Time written into traces and ledger, for runs that repeat byte for byte
    #[arg(long, value_name = "TIME", value_parser = moment::parse)]
    pub clock: Option<Time>,
    /// Where another batch is at work in one of the folders, be refused instead of waiting for it
    #[arg(long)]
    pub no_wait: bool,
    /// Say nothing on the way
    #[arg(long, short)]
    pub quiet: bool,
}

const AUDIT_HELP: &str = "\
Every file of every asset must follow from its trace, every trace from its row of the ledger, every
row from the one before it: outcomes, requests, runs, plans and items, and every line of the account
book. Rows that kinfold 0.1.0 did not chain are told as not known, with exit code 3.

    kinfold audit query DIR \"SELECT provider, count(*) FROM items WHERE license = 'CC0-1.0' GROUP BY 1\"

asks the ledger in SQL: the table is `items`, its columns those of index.parquet. `kinfold audit query
DIR .schema` lists all tables and columns.

Exit codes: 0 everything holds, 1 something does not, 2 misused, 3 some of it is not known";

/// Arguments of `kinfold audit`.
#[derive(Args, Debug)]
#[command(after_help = AUDIT_HELP)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct AuditArgs {
    /// What else can be asked
    #[command(subcommand)]
    pub command: Option<AuditCommand>,
    /// The batch's folder
    #[arg(value_name = "DIR", required = true)]
    pub folder: Option<PathBuf>,
    /// A public key that every statement must be signed with: a file of minisign, or of
    /// `kinfold trace keygen`
    #[arg(long, value_name = "PUBLIC")]
    pub key: Option<PathBuf>,
    /// Look at the files of about N items only, always the same ones
    #[arg(long, value_name = "N")]
    pub sample: Option<u64>,
    /// How long it may take, and how much memory
    #[command(flatten)]
    pub bounds: BoundsArgs,
    /// Answer in JSON
    #[arg(long)]
    pub json: bool,
}

/// `kinfold audit ...`
#[derive(Debug, Subcommand)]
pub enum AuditCommand {
    /// Sign the statement beside every asset, where everything holds
    ///
    /// Each goes into a DSSE envelope, attestation.dsse.json, which `kinfold audit DIR --key PUBLIC`
    /// judges, and tools of in-toto. Sign when the batch is done: what is made again is signed again.
    Sign {
        /// The batch's folder
        #[arg(value_name = "DIR")]
        folder: PathBuf,
        /// The secret key, as `kinfold trace keygen` makes it
        #[arg(long, value_name = "SECRET")]
        key: PathBuf,
        /// Answer in JSON
        #[arg(long)]
        json: bool,
    },
    /// Ask the ledger in SQL
    Query {
        /// The batch's folder
        #[arg(value_name = "DIR")]
        folder: PathBuf,
        /// The question, nothing can be changed by it; or .schema, for the tables and their columns
        #[arg(value_name = "SQL")]
        sql: String,
        /// Rows that are shown at most
        #[arg(long, value_name = "N", default_value_t = 1000)]
        limit: usize,
        /// Longest time it may take
        #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = seconds)]
        deadline: Duration,
        /// Answer in JSON, an object per line
        #[arg(long)]
        json: bool,
    },
}

/// `kinfold store ...`
#[derive(Debug, Subcommand)]
pub enum StoreCommand {
    /// Remove what no ledger, no trace and no recent run names
    Gc {
        /// A batch's folder, or a state directory
        #[arg(value_name = "DIR")]
        folder: PathBuf,
        /// Keep what traces in this folder name, too
        #[arg(long, value_name = "DIR")]
        keep: Vec<PathBuf>,
        /// Keep what was made or used in the last so many days
        #[arg(long, value_name = "DAYS", default_value_t = 30)]
        older_than: u64,
        /// Say what would be removed; change nothing
        #[arg(long)]
        dry_run: bool,
        /// Where somebody is at work with it, be refused instead of waiting
        #[arg(long)]
        no_wait: bool,
        /// How long the --dry-run may take, and how much memory
        #[command(flatten)]
        bounds: BoundsArgs,
        /// Answer in JSON
        #[arg(long)]
        json: bool,
    },
    /// Hash everything and say what rotted; nothing is changed
    Verify {
        /// A batch's folder, or a state directory
        #[arg(value_name = "DIR")]
        folder: PathBuf,
        /// Take out what rotted, too, so that the next run makes it again
        #[arg(long)]
        repair: bool,
        /// Where somebody is at work with it, be refused by --repair instead of waiting
        #[arg(long)]
        no_wait: bool,
        /// How long it may take, and how much memory
        #[command(flatten)]
        bounds: BoundsArgs,
        /// Answer in JSON
        #[arg(long)]
        json: bool,
    },
}
