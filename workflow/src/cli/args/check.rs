//! Arguments of `kinfold check`.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use forecast::Client;
use sim_check::Tier;

use super::parse::{argument, at_least_one, package, seconds, tier, variable, waiver};

const CHECK_HELP: &str = "\
Examples:
  kinfold check robot.urdf                        what fails, what follows from it, how to mend it
  kinfold check robot.urdf --tier dynamic -v      asked for more, with every check and finding
  kinfold check model.xml --json                  an MJCF model, for a program
  kinfold check robot.urdf --for mujoco,drake     what each of them will do with it
  kinfold check robots/ --junit report.xml        every model below a folder, for a build server
  kinfold check . --sarif report.sarif --changed-since origin/main
                                                  what a change touches, beside its lines
  kinfold check robots/ --baseline known.json     only what is new fails
  kinfold check arm.xacro --package arm=../arm    macros expanded, package://arm found there
  kinfold check crate.urdf --as object            judged as an object, whatever is found
  kinfold check robot.urdf --waive C1=\"the pin sits in its hole\"
  kinfold explain C1                              why that rule matters, and how it is measured";

/// When a result is shown in colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum When {
    /// On a terminal, unless NO_COLOR is set
    #[default]
    Auto,
    /// Always
    Always,
    /// Never
    Never,
}

/// What a model is judged as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// It must rest on the floor, have labels, and no two of its parts may overlap
    Object,
    /// Its drives hold it, and neighbours may touch
    Robot,
}

/// Whether the base is tied to the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Standing {
    /// It is
    Fixed,
    /// It may fall
    Free,
}

/// Clients that a forecast is asked for.
#[derive(Clone, Debug)]
pub struct Clients(pub Vec<Client>);

fn clients(text: &str) -> Result<Clients, String> {
    Client::list(text).map(Clients).map_err(|e| e.to_string())
}

/// Arguments of `kinfold explain`.
#[derive(Args, Debug)]
pub struct ExplainArgs {
    /// Rules by their ids, such as C1; all are listed without one
    #[arg(value_name = "ID")]
    pub ids: Vec<String>,
    /// Colour: auto (on a terminal, unless NO_COLOR is set), always, never
    #[arg(long, value_name = "WHEN", value_enum, default_value = "auto")]
    #[arg(hide_possible_values = true)]
    pub color: When,
    /// Answer in JSON
    #[arg(long)]
    pub json: bool,
}

const SCAN_HELP: &str = "\
Examples:
  kinfold scan models/                            how far they get, and what keeps most of them back
  kinfold scan models/ --html board.html          the same as a page, every model in it
  kinfold scan models/ --tier static --jobs 2     no check above it runs
Exit codes: 0 all reach the tier, 3 some do not, 1 failed, 2 misused";

/// Arguments of `kinfold scan`.
#[derive(Args, Debug)]
#[command(after_help = SCAN_HELP)]
pub struct ScanArgs {
    /// Models that are named as farthest from the tier
    #[arg(long, value_name = "N", default_value_t = 20)]
    pub top: usize,
    /// How each is checked.
    #[command(flatten)]
    pub check: CheckArgs,
}

/// Arguments of `kinfold check`.
#[derive(Args, Debug)]
#[command(after_help = CHECK_HELP)]
pub struct CheckArgs {
    /// URDF, xacro, MJCF, SDFormat or USD files, or folders to look through for models
    #[arg(value_name = "PATH", required = true)]
    pub paths: Vec<PathBuf>,
    /// Answer in JSON: a verdict, or for several files a line each
    #[arg(long)]
    pub json: bool,
    /// Tell every check and every finding of one file
    #[arg(long, short)]
    pub verbose: bool,
    /// Colour: auto (on a terminal, unless NO_COLOR is set), always, never
    #[arg(long, value_name = "WHEN", value_enum, default_value = "auto")]
    #[arg(hide_possible_values = true)]
    pub color: When,
    /// The tier asked for: exit 0 if it is reached, 3 if only a lower one is, 1 if none; of several
    /// files the worst decides. No check above it runs. Unless given, kinematic decides and the
    /// simulation runs too
    #[arg(long, value_name = "TIER", value_parser = tier)]
    pub tier: Option<Tier>,
    /// Let a failure pass that you answer for, such as --waive C1="a pin sits in its hole"; it
    /// stands in the verdict. What is unknown cannot be waived
    #[arg(long, value_name = "ID=REASON", value_parser = waiver)]
    pub waive: Vec<(String, String)>,
    /// Let meshes lie outside the file's folder
    #[arg(long)]
    pub allow_outside: bool,
    /// Judge as an `object` or as a `robot` [default: as what is found, which is said first]
    #[arg(long = "as", value_name = "WHAT", value_enum, hide_possible_values = true)]
    pub subject: Option<Kind>,
    /// Judge with a base that is `fixed` or `free` [default: as what is found]
    #[arg(long, value_name = "HOW", value_enum, hide_possible_values = true)]
    pub base: Option<Standing>,
    /// Where a package lies that `package://NAME` or `$(find NAME)` names; without it, it is looked for
    /// at, above and beside the file
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
    /// The SRDF that says which links may meet and where a robot is at home [default: the one of the
    /// file's name beside it]
    #[arg(long, value_name = "FILE")]
    pub srdf: Option<PathBuf>,
    /// Say what clients will do with the file, by written rules and without running them: `all`, or a
    /// list of mujoco, pybullet, drake, newton, isaac, sapien, genesis, rerun
    #[arg(long = "for", value_name = "LIST", value_parser = clients)]
    pub clients: Option<Clients>,
    /// Exit 3 where one of the clients of --for refuses the file, or moves, weighs or touches otherwise
    /// than it says, or where no rules are known; of all clients, unless --for names some
    #[arg(long)]
    pub portable: bool,
    /// Write a JUnit report for build servers, too
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
    /// Write a SARIF 2.1.0 report for code hosts, too: findings beside the lines they are about
    #[arg(long, value_name = "FILE")]
    pub sarif: Option<PathBuf>,
    /// Write a Markdown report for pull requests and job summaries, too
    #[arg(long, value_name = "FILE")]
    pub markdown: Option<PathBuf>,
    /// Write a page for browsers, too: who gets how far, and what fails most
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Let pass what this file knows, so that only new findings fail
    #[arg(long, value_name = "FILE")]
    pub baseline: Option<PathBuf>,
    /// Write what fails today, for --baseline
    #[arg(long, value_name = "FILE")]
    pub write_baseline: Option<PathBuf>,
    /// Of the files found, check those that differ from this commit of Git, or name a file that does
    #[arg(long, value_name = "REF")]
    pub changed_since: Option<String>,
    /// Settings of a repository [default: kinfold-check.toml, here or above within the repository]
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Look for no settings
    #[arg(long, conflicts_with = "config")]
    pub no_config: bool,
    /// Files to check at a time; threads, where there are fewer files [default: one per core]
    #[arg(long, value_name = "N", value_parser = at_least_one)]
    pub jobs: Option<usize>,
    /// Longest time for one file; one that takes longer is unknown, which is a failure
    #[arg(long, value_name = "SECONDS", default_value = "120", value_parser = seconds)]
    pub deadline: Duration,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Check in this very process
    #[arg(long, hide = true)]
    pub here: bool,
}
