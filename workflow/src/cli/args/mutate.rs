//! Arguments of `kinfold mutate` and `kinfold bench-check`.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};

use super::check::Kind;
use super::parse::{package, planted, seconds};

const MUTATE_HELP: &str = "\
Examples:
  kinfold mutate robot.urdf --out mutants      a folder for every kind of defect that applies
  kinfold mutate robot.urdf --out mutants --kind axis-zero --kind mesh-missing
  kinfold mutate --list                        the kinds, and what a right checker says of each
  kinfold bench-check --mutants mutants        what `kinfold check` finds of them

The model itself is not touched. Each folder is complete: the model with one defect, and the files that
it needs. `original` holds the same without a defect.
Exit codes: 0 done, 3 done, but no kind applies or the model has findings of its own, 1 failed";

/// Arguments of `kinfold mutate`.
#[derive(Args, Debug)]
#[command(after_help = MUTATE_HELP)]
pub struct MutateArgs {
    /// A sound URDF or MJCF file
    #[arg(value_name = "MODEL", required_unless_present = "list")]
    pub model: Option<PathBuf>,
    /// The folder to write, new or written by this command before
    #[arg(long, value_name = "DIR", required_unless_present = "list")]
    pub out: Option<PathBuf>,
    /// Plant this kind and no other; may be given again
    #[arg(long = "kind", value_name = "KIND", value_parser = planted)]
    pub kinds: Vec<String>,
    /// Seed of which joint, link or mesh gets the defect
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// List the kinds
    #[arg(long, conflicts_with_all = ["model", "out", "kinds"])]
    pub list: bool,
    /// Answer in JSON
    #[arg(long)]
    pub json: bool,
    /// Let meshes lie outside the file's folder
    #[arg(long)]
    pub allow_outside: bool,
    /// Judge the original as an `object` or as a `robot` [default: as what is found]
    #[arg(long = "as", value_name = "WHAT", value_enum, hide_possible_values = true)]
    pub subject: Option<Kind>,
    /// Where a package lies that `package://NAME` names
    #[arg(long = "package", value_name = "NAME=DIR", value_parser = package)]
    pub packages: Vec<(String, PathBuf)>,
    /// Longest time for planting
    #[arg(long, value_name = "SECONDS", default_value = "120", value_parser = seconds)]
    pub deadline: Duration,
    /// Plant in this very process
    #[arg(long, hide = true)]
    pub here: bool,
}
