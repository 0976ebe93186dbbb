//! Arguments that say where stages run: in this process, or on many machines.

use std::net::SocketAddr;

use clap::{Args, ValueEnum};
use runner::Address;

use super::parse::{at_least_one, url};

/// Who decides what runs next, and where.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EngineName {
    /// This process, on its own threads
    Embedded,
    /// Restate, on the workers it knows
    Restate,
}

/// Arguments of `kinfold batch` about engines.
#[derive(Args, Debug)]
pub struct EngineArgs {
    /// Where stages that compute run: embedded (in this process) or restate (on `kinfold worker`s,
    /// which share its --store)
    #[arg(long, value_name = "ENGINE", value_enum, default_value = "embedded")]
    #[arg(hide_possible_values = true)]
    pub engine: EngineName,
    /// Restate's front door
    #[arg(long, value_name = "URL", default_value = "http://127.0.0.1:8080", value_parser = url)]
    pub ingress: String,
    /// Restate's administration
    #[arg(long, value_name = "URL", default_value = "http://127.0.0.1:9070", value_parser = url)]
    pub admin: String,
    /// Where Restate reaches the workers: one of them, or what stands before them; made known to it
    /// first
    #[arg(long, value_name = "URL", value_parser = url)]
    pub workers: Option<String>,
}

const WORKER_HELP: &str = "\
Does single stages that compute, from the shared store to the shared store; Restate says which.
Any number of them, behind anything that balances HTTP/2 and asks GET /health:

    kinfold worker --engine restate --listen 0.0.0.0:9080 --identity-key publickeyv1_… --store s3://ours/stages
    kinfold batch m.jsonl --out out --store s3://ours/stages --engine restate --workers http://lb:9080

A worker that others reach obeys signed requests alone: give Restate a key
(RESTATE_REQUEST_IDENTITY_PRIVATE_KEY_PEM_FILE; openssl genpkey -algorithm ed25519 makes one), and the
worker the public key that Restate says when it starts. GET /health is then answered with 401.

Services are asked, and paid, by the batch itself. Ctrl-C ends a worker; what it had begun, another
does.

Exit codes: 0 ended as wished, 1 it could not go on, 2 misused";

/// Arguments of `kinfold worker`.
#[derive(Args, Debug)]
#[command(after_help = WORKER_HELP)]
pub struct WorkerArgs {
    /// Who says what is to be done: restate
    #[arg(long, value_name = "ENGINE", value_enum, default_value = "restate")]
    #[arg(hide_possible_values = true)]
    pub engine: EngineName,
    /// Where it listens for Restate
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:9080")]
    pub listen: SocketAddr,
    /// Restate's public key: nobody else is obeyed. Must be given to listen to more than this machine
    /// itself; several while a key is changed
    #[arg(long, value_name = "publickeyv1_KEY")]
    pub identity_key: Vec<String>,
    /// What it shares with the batch: a folder, or s3://BUCKET/PREFIX, gs://BUCKET/PREFIX,
    /// az://CONTAINER/PREFIX with keys from the environment
    #[arg(long, value_name = "ADDRESS")]
    pub store: Address,
    /// Stages at a time [default: one per core]
    #[arg(long, value_name = "N", value_parser = at_least_one)]
    pub jobs: Option<usize>,
    /// Say nothing on the way
    #[arg(long, short)]
    pub quiet: bool,
}
