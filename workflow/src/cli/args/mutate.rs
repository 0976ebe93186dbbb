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

const BENCH_HELP: &str = "\
Examples:
  kinfold bench-check --mutants mutants              what `kinfold check` finds
  kinfold bench-check --mutants mutants -- simcheck check --engine mujoco {}
  kinfold bench-check --mutants a --mutants b --markdown table.md -- mjcf-doctor check {}

A program is run once more than there are mutants: on the model without a defect first, twice. `{}` in its
arguments is the model's file; it comes last where no argument says so. How a mutant counts as found:
  exit    the exit code is not 0, and that of the original is 0
  output  a line of the output is a finding, and the original has no such line. A line is a finding
          where it holds one of the words of --marks; paths of the folder do not count, and of lines that
          differ between two runs on the original the numbers do not
  either  one of the two
Of kinfold itself a mutant counts as found where a rule of its kind finds what it did not find before.
Exit codes: 0 all found and no false alarm, 3 some missed, 1 failed";

/// How a mutant counts as found by a program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum FoundBy {
    /// By its exit code
    Exit,
    /// By what it says
    Output,
    /// By one of the two
    #[default]
    Either,
}

/// Arguments of `kinfold bench-check`.
#[derive(Args, Debug)]
#[command(after_help = BENCH_HELP)]
pub struct BenchArgs {
    /// The checker and its arguments, after `--` [default: `kinfold check`]
    #[arg(value_name = "PROGRAM")]
    pub program: Vec<String>,
    /// A folder that `kinfold mutate` wrote; may be given again
    #[arg(long, value_name = "DIR", required = true)]
    pub mutants: Vec<PathBuf>,
    /// How a mutant counts as found: exit, output or either
    #[arg(long, value_name = "HOW", value_enum, default_value = "either")]
    #[arg(hide_possible_values = true)]
    pub found_by: FoundBy,
    /// Words, with commas between, that make a line of output a finding, in either case
    #[arg(long, value_name = "WORDS", value_delimiter = ',')]
    #[arg(default_value = "error,warn,fail,fatal,invalid,critical,exception,refuse")]
    pub marks: Vec<String>,
    /// Ask of this kind and no other; may be given again
    #[arg(long = "kind", value_name = "KIND", value_parser = planted)]
    pub kinds: Vec<String>,
    /// Longest time for one file; what takes longer has no answer, which finds nothing
    #[arg(long, value_name = "SECONDS", default_value = "120", value_parser = seconds)]
    pub deadline: Duration,
    /// Write the table as Markdown, too
    #[arg(long, value_name = "FILE")]
    pub markdown: Option<PathBuf>,
    /// Answer in JSON
    #[arg(long)]
    pub json: bool,
}
