//! Arguments of `kinfold serve`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use sim_check::Tier;

use super::parse::{amount, at_least_one, made_tier, probability, rate, seconds};
use crate::stages::Export;

/// The port that is listened on where nobody names one.
const SERVICE_PORT: u16 = 7412;

const SERVE_HELP: &str = "\
Examples:
  kinfold serve jobs                                one token, made and printed; jobs ask nobody
  kinfold serve jobs --config kinfold.toml --max-calls 200        asks whom it names, 200 requests in all
  kinfold serve jobs --tokens tokens.toml --export mjcf,usd       for several, each with a budget
  python -c 'import kinfold; print(kinfold.connect(\"http://127.0.0.1:7412\", token=\"…\").about())'

tokens.toml names whoever may ask. A token itself stands in the environment, never in the file:

    [tokens.ann]
    env = \"KINFOLD_TOKEN_ANN\"
    max_calls = 100          # requests that may cost
    max_cost = 5.0           # in the currency of the prices
    max_waiting = 50         # jobs without an outcome

DIR is a batch's folder: `kinfold audit DIR` and `kinfold batch report DIR` read it. What was answered
survives a kill: start the same command again. The same question is the same job, made once.

It listens to this machine alone. For others put something before it that speaks TLS and limits who may
come. `/v1/openapi.json` describes what can be asked; from Python it is `kinfold.connect`.

Exit codes: 0 ended as wished, 1 it could not go on, 2 misused";

/// Arguments of `kinfold serve`.
#[derive(Args, Clone, Debug)]
#[command(after_help = SERVE_HELP)]
pub struct ServeArgs {
    /// Where jobs, assets and ledger go
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Who may ask, and what each may spend [default: one token, that of KINFOLD_TOKEN, or one that is kept
    /// in DIR/token]
    #[arg(long, value_name = "FILE")]
    pub tokens: Option<PathBuf>,
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
    /// Write a page and pictures for each asset, too
    #[arg(long)]
    pub pages: bool,
    /// The tier an asset is accepted from
    #[arg(long, value_name = "TIER", default_value = "kinematic", value_parser = made_tier)]
    pub tier: Tier,
    /// The probability asked for that every part and joint is right, 0 to 1, of jobs that name none
    #[arg(long, value_name = "P", value_parser = probability)]
    pub min_confidence: Option<f64>,
    /// Seed of jobs that name none
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Stages that compute at a time [default: one per core]
    #[arg(long, value_name = "N", value_parser = at_least_one)]
    pub jobs: Option<usize>,
    /// Meshes asked for at a time
    #[arg(long, value_name = "N", default_value = "4", value_parser = at_least_one)]
    pub mesh_calls: usize,
    /// Conditions asked for at a time
    #[arg(long, value_name = "N", default_value = "4", value_parser = at_least_one)]
    pub condition_calls: usize,
    /// Most requests that may cost, over all tokens and runs
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
    /// Most mebibytes of a file
    #[arg(long, value_name = "MIB", default_value = "64", value_parser = at_least_one)]
    pub max_upload: usize,
    /// Most gibibytes of a token's files; they stay as long as the jobs that they are for
    #[arg(long, value_name = "GIB", default_value = "16", value_parser = at_least_one)]
    pub max_stored: usize,
    /// Most requests a second of a token; twice as many may come at once
    #[arg(long, value_name = "N", default_value = "50", value_parser = rate)]
    pub max_rate: f64,
    /// Most jobs of a token without an outcome, where its own number says no other
    #[arg(long, value_name = "N", default_value = "1000", value_parser = at_least_one)]
    pub max_waiting: usize,
    /// Connections at a time
    #[arg(long, value_name = "N", default_value = "128", value_parser = at_least_one)]
    pub connections: usize,
    /// How long a body may dawdle, seconds; a connection that does nothing for three times as long is let go
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = seconds)]
    pub patience: Duration,
    /// The port of this machine that is listened on, 0 for any
    #[arg(long, value_name = "N", default_value_t = SERVICE_PORT)]
    pub port: u16,
    /// Print the address and the token as JSON
    #[arg(long)]
    pub json: bool,
    /// Where another one is at work in the folder, be refused instead of waiting for it
    #[arg(long)]
    pub no_wait: bool,
    /// Say nothing on the way
    #[arg(long, short)]
    pub quiet: bool,
}
