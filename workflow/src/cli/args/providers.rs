//! Arguments of the commands about whom a configuration names.

use std::path::PathBuf;

use clap::Args;

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
