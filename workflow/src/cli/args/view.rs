//! Arguments of `kinfold view`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use super::parse::seconds;

/// Arguments of `kinfold view`.
#[derive(Args, Debug)]
pub struct ViewArgs {
    /// A URDF or MJCF file, an asset's folder or any with one URDF in it, or a trace
    #[arg(value_name = "PATH")]
    pub path: PathBuf,
    /// Where the page goes [default: ./NAME.html]; only a page of ours is replaced
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Open the page in a browser
    #[arg(long, overrides_with = "no_open")]
    pub open: bool,
    /// Start no browser, which is the default
    #[arg(long, overrides_with = "open")]
    pub no_open: bool,
    /// Answer in JSON
    #[arg(long)]
    pub json: bool,
    /// Let meshes lie outside the file's folder
    #[arg(long)]
    pub allow_outside: bool,
    /// Longest time for the check; where it takes longer, the page shows the model without it
    #[arg(long, value_name = "SECONDS", default_value = "120", value_parser = seconds)]
    pub deadline: Duration,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Make the page in this very process
    #[arg(long, hide = true)]
    pub here: bool,
    /// Do not check, for this reason
    #[arg(long, hide = true, value_name = "REASON")]
    pub unchecked: Option<String>,
}
