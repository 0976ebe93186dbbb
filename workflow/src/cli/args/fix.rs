//! Arguments of `kinfold fix`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use super::check::{Kind, Standing};
use super::parse::{argument, package, rule, seconds, variable};

const FIX_HELP: &str = "\
Examples:
  kinfold fix robot.urdf                     what would be changed, as a diff; nothing is written
  kinfold fix robot.urdf > mended.diff       the same for `git apply` or `patch -p1`
  kinfold fix robot.urdf --write             change the file; new meshes go beside those it has
  kinfold fix robot.urdf --only J2 --only M3 mend what these rules found, and nothing else
  kinfold fix robot.urdf --flags             mend what is a warning only, too
  kinfold fix --list                         what can be mended, rule by rule

A change stays only if the checks find less for it and none is worse. What stays is said, with why.
Exit codes: 0 nothing fails any more, 3 something still fails, 1 the file cannot be read as a model.";

/// Arguments of `kinfold fix`.
#[derive(Args, Debug)]
#[command(after_help = FIX_HELP)]
pub struct FixArgs {
    /// A URDF or MJCF file
    #[arg(value_name = "FILE", required_unless_present = "list")]
    pub file: Option<PathBuf>,
    /// Show the changes as a diff and write nothing, which is the default
    #[arg(long, conflicts_with = "write")]
    pub diff: bool,
    /// Write the changes into the file, in one step; new meshes are written beside
    #[arg(long)]
    pub write: bool,
    /// Mend what this rule found, warnings of it too, and nothing else; may be given again
    #[arg(long, value_name = "RULE", value_parser = rule)]
    pub only: Vec<String>,
    /// Mend what is a warning only, too
    #[arg(long)]
    pub flags: bool,
    /// List what can be mended, and how
    #[arg(long, conflicts_with_all = ["file", "write", "only"])]
    pub list: bool,
    /// Answer in JSON
    #[arg(long)]
    pub json: bool,
    /// Let meshes lie outside the file's folder
    #[arg(long)]
    pub allow_outside: bool,
    /// Judge as an `object` or as a `robot` [default: as what is found]
    #[arg(long = "as", value_name = "WHAT", value_enum, hide_possible_values = true)]
    pub subject: Option<Kind>,
    /// Judge with a base that is `fixed` or `free` [default: as what is found]
    #[arg(long, value_name = "HOW", value_enum, hide_possible_values = true)]
    pub base: Option<Standing>,
    /// Where a package lies that `package://NAME` or `$(find NAME)` names
    #[arg(long = "package", value_name = "NAME=DIR", value_parser = package)]
    pub packages: Vec<(String, PathBuf)>,
    /// Look for packages where ROS_PACKAGE_PATH and AMENT_PREFIX_PATH say, too
    #[arg(long)]
    pub ros: bool,
    /// What `$(env NAME)` of a xacro is; without a value, that of this environment
    #[arg(long = "env", value_name = "NAME[=VALUE]", value_parser = variable)]
    pub env: Vec<(String, String)>,
    /// What `$(arg NAME)` of a xacro is
    #[arg(long = "arg", value_name = "NAME=VALUE", value_parser = argument)]
    pub args: Vec<(String, String)>,
    /// The SRDF that goes with the file [default: the one of the file's name beside it]
    #[arg(long, value_name = "FILE")]
    pub srdf: Option<PathBuf>,
    /// Longest time; two thirds of it are for trying changes, and what was not tried then is said
    #[arg(long, value_name = "SECONDS", default_value = "300", value_parser = seconds)]
    pub deadline: Duration,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Mend in this very process
    #[arg(long, hide = true)]
    pub here: bool,
}
