//! Arguments of what learns and of what measures it.

use std::path::PathBuf;
use std::str::FromStr;

use adapters::terms::Policy;
use clap::{Args, Subcommand};
use model::Choice;
use model::choice::ChoiceError;
use model::net::Precision;
use training::evaluate::{Mode, Set};

use super::parse::{Words, one_of};

/// Arguments of `kinfold eval`.
#[derive(Args, Debug)]
#[command(after_help = EVAL_HELP)]
pub struct EvalArgs {
    /// A folder of case folders: mesh.glb, condition.json, truth.json, face_labels.u16le, and for
    /// `--mode mesh` and `image` a picture, image.png or render.png
    #[arg(value_name = "CASES_DIR")]
    pub cases: PathBuf,
    /// What is given; whom the configuration names is asked for the rest
    #[arg(long, value_name = "MODE", default_value = "mesh+kinematic", value_parser = one_of::<Mode>(MODES))]
    pub mode: Mode,
    /// Who is asked [default: ./kinfold.toml, where there is one]
    #[arg(long, value_name = "FILE", env = "KINFOLD_CONFIG")]
    pub config: Option<PathBuf>,
    /// Let a kinfold.toml found here act this once, without approving it
    #[arg(long)]
    pub trust_config: bool,
    /// What answers are meant for, as in `kinfold make`
    #[arg(long, value_name = "POLICY", default_value = "any", env = "KINFOLD_POLICY")]
    pub policy: Policy,
    /// Where what was asked for is kept, so that it is paid for once [default: ~/.cache/kinfold]
    #[arg(long, value_name = "DIR", env = "KINFOLD_STATE")]
    pub state: Option<PathBuf>,
    /// Who answers
    #[arg(long, value_name = "WHO", default_value = "default", value_parser = one_of::<Who>(ARTICULATORS))]
    pub articulator: Who,
    /// The network's weights, for `--articulator net` and `particulate`
    #[arg(long, value_name = "FILE")]
    pub weights: Option<PathBuf>,
    /// The weights of PartField, whose point features Particulate reads
    #[arg(long, value_name = "FILE")]
    pub point_features: Option<PathBuf>,
    /// A CLIP checkpoint the network reads texts with, where its weights were trained with one
    #[arg(long, value_name = "DIR")]
    pub text_features: Option<PathBuf>,
    /// What numbers the network multiplies; the answer's identity says which [default: best]
    #[arg(long, value_name = "WHICH", value_parser = one_of::<Precision>(PRECISIONS))]
    pub precision: Option<Precision>,
    /// Take the true labels and measure the joints alone
    #[arg(long, value_name = "WHOSE", value_enum)]
    pub labels: Option<Labels>,
    /// Keep something back from the articulator
    #[arg(long, value_name = "WHAT", value_enum, value_delimiter = ',')]
    pub without: Vec<Withheld>,
    /// Where the point prompts lie
    #[arg(long, value_name = "WHERE", value_enum, default_value_t = Prompted::AsGiven)]
    pub prompts: Prompted,
    /// Only cases of this set
    #[arg(long, value_name = "SET", value_parser = one_of::<Set>(SETS), value_delimiter = ',')]
    pub set: Vec<Set>,
    /// Only cases whose name holds this
    #[arg(long, value_name = "TEXT")]
    pub filter: Option<String>,
    /// Cases at a time, one thread each
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: u16,
    /// Points drawn on each surface
    #[arg(long, value_name = "N", default_value_t = 100_000, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub points: u32,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Measure as the public code of the paper's predecessor does, its defects included
    #[arg(long)]
    pub ref_compat: bool,
    /// Everything in full, as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// One line per case, for spreadsheets
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// A picture of the worst cases, true and predicted side by side
    #[arg(long, value_name = "FILE.png")]
    pub sheet: Option<PathBuf>,
    /// How many cases the picture shows
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u16).range(1..=200))]
    pub worst: u16,
    /// Say nothing on the way
    #[arg(long, short)]
    pub quiet: bool,
}

const EVAL_HELP: &str = "\
The table: Prec. and Rec. of matched parts, gIoU, PC (Chamfer) and box mIoU of parts at rest, point
IoU, gIoU of moved boxes (a-gIoU), gIoU of boxes around moved points (a-pts), PC and OC (whole
object), AE (degrees) and LE of axes, the share of joints within 15 degrees and 0.05 of the true
line, and of objects that are fully right: every part's point IoU at least 0.75, every joint found
and opening the true way. Joints are at their upper ends, for a-pts at the end farther from the pose
shown. Lengths are in the unit cube. First with parts matched by their number, where the condition
is given, then by centroid.

Below, joints one by one: those that truly go one way and whose axis is found, and how many of them
open that way, both ways or the other way.

Exit codes: 0 done, 1 failed, 2 misused, 3 some cases got no answer (they count as the worst)";

/// What a case gives.
const MODES: Words = &[
    ("mesh+kinematic", "Its mesh and its kinematic condition; nobody else is asked"),
    ("mesh", "Its mesh and its picture; a vision-language model says what the parts are"),
    ("image", "Its picture; a generator makes the mesh, too"),
];

/// Who can be asked.
const ARTICULATORS: Words = &[
    ("default", "What `kinfold make` uses: geometry, with labels by the trees that ship"),
    ("geometric", "Geometry alone"),
    ("net", "The network, with --weights"),
    (
        "particulate",
        "Its predecessor, which finds what the parts are by itself: --mode mesh, with --weights and \
         --point-features, safetensors under the names of the published checkpoints",
    ),
];

/// What numbers the network multiplies.
const PRECISIONS: Words = &[
    ("best", "Half where the processor multiplies bf16 tiles (AMX), else full"),
    ("full", "f32"),
    ("half", "bf16, summed as f32: the same answer on every machine, and slow without AMX"),
];

/// Sets of cases.
const SETS: Words = &[
    ("cad", "articraft__*"),
    ("simulation", "Assets made for simulators"),
    ("fused", "*-fused"),
    ("paper", "paper__*"),
];

/// Who answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Who {
    /// One that needs nothing but what ships.
    Ships(Choice),
    /// The network.
    Net,
    /// Its predecessor.
    Particulate,
}

impl FromStr for Who {
    type Err = ChoiceError;

    fn from_str(text: &str) -> Result<Self, ChoiceError> {
        match text {
            "net" => Ok(Self::Net),
            "particulate" => Ok(Self::Particulate),
            text => text.parse().map(Self::Ships),
        }
    }
}

/// Whose labels joints are fitted to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Labels {
    /// The true ones
    Truth,
}

/// Where point prompts lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Prompted {
    /// Where the condition has them
    AsGiven,
    /// Anywhere on the true part, drawn by --seed
    Anywhere,
}

/// What can be kept back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Withheld {
    /// Texts and names of parts, and the category
    Text,
    /// Point prompts
    Points,
}

const TRAIN_HELP: &str = "\
A recipe with the field `fit` (segments, axes, ranges, roles, contacts, sizes, fused_unary) makes a pack
of what ships; those are in training/recipes. Every finished model is kept in its folder `out`, so a run
that was killed goes on with the same command and ends with the same bytes.

Without that field the articulation network is trained. A run lives in the folder `out` of its
configuration: checkpoint, weights, curves. Killed at any moment, the same command goes on from the last
checkpoint and ends with the same bytes.

The least a configuration says (paths are relative to it):

    out = \"run\"
    cache = \"samples\"
    steps = 1000
    [[source]]
    name = \"ours\"
    procedural = 200";

/// Arguments of `kinfold train`.
#[derive(Args, Debug)]
#[command(after_help = TRAIN_HELP)]
pub struct TrainArgs {
    /// The recipe: a TOML file
    #[arg(value_name = "CONFIG")]
    pub config: PathBuf,
    /// Stop after this many minutes, with everything saved; a fit ends between two models
    #[arg(long, value_name = "N")]
    pub minutes: Option<f64>,
    /// Answer in JSON
    #[arg(long)]
    pub json: bool,
    /// Say nothing on the way
    #[arg(long, short)]
    pub quiet: bool,
}

/// `kinfold weights ...`
#[derive(Debug, Subcommand)]
pub enum WeightsCommand {
    /// Turn a PyTorch checkpoint into safetensors, without running anything it says
    Convert {
        /// The checkpoint: a `.pt` or `.ckpt` file
        #[arg(value_name = "FILE")]
        file: PathBuf,
        /// Where the weights go [default: beside the checkpoint, as `.safetensors`]
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
        /// Pass over a trainer's settings that stand beside the tensors
        #[arg(long)]
        state_dict_only: bool,
    },
    /// Tell what a pack of fitted models holds, which features it asks about and where it came from
    Show {
        /// The pack: a `.pack` file
        #[arg(value_name = "FILE")]
        file: PathBuf,
        /// Its head as JSON
        #[arg(long)]
        json: bool,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all_read<T: FromStr>(words: Words) -> bool {
        words.iter().all(|(word, _)| word.parse::<T>().is_ok())
    }

    #[test]
    fn every_word_that_help_lists_is_one_the_library_knows() {
        assert!(all_read::<Mode>(MODES) && all_read::<Set>(SETS));
        assert!(all_read::<Who>(ARTICULATORS) && all_read::<Precision>(PRECISIONS));
        assert_eq!("geometric".parse(), Ok(Who::Ships(Choice::Geometric)));
        assert_eq!(SETS.len(), Set::ALL.len());
    }
}
