//! `mutants.json`: what was planted, where, and what a right checker should say.

use serde::{Deserialize, Serialize};

/// Its name in the folder.
pub const FILE: &str = "mutants.json";
/// What it says that it is.
pub const SCHEMA: &str = "kinfold-mutants/1";
/// The folder of the model without a defect.
pub const ORIGINAL: &str = "original";
/// Most bytes of it that are read; a guess: a diff for each of some seventy kinds.
pub const MOST: u64 = 64 << 20;

/// All of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// [`SCHEMA`].
    pub schema: String,
    /// The file of the model in each folder.
    pub model: String,
    /// What it is written in.
    pub format: String,
    /// The seed.
    pub seed: u64,
    /// How many names of files are other ones than in the model as it stands.
    pub renamed: usize,
    /// The model without a defect.
    pub original: Original,
    /// One for each kind that applies.
    pub mutants: Vec<Mutant>,
    /// Kinds that do not apply, and why.
    pub not_applicable: Vec<NotApplicable>,
}

/// The model without a defect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Original {
    /// Its folder.
    pub folder: String,
    /// What it was judged as.
    pub judged: String,
    /// The tier that it reaches.
    pub tier: String,
    /// Its checks that fail or are unknown and lower the tier.
    pub failing: Vec<String>,
}

/// A model with one defect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mutant {
    /// Its kind.
    pub kind: String,
    /// Its folder.
    pub folder: String,
    /// What it is about.
    pub subject: String,
    /// Its line in the model without the defect.
    pub line: u32,
    /// What was changed.
    pub change: String,
    /// What is wrong then.
    pub wrong: String,
    /// The rules one of which should find it; any where there is none.
    pub rules: Vec<String>,
    /// Files with other bytes than in the model without the defect.
    pub files: Vec<String>,
    /// The change of the text; empty where only files changed.
    pub diff: String,
}

/// A kind that does not apply.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct NotApplicable {
    /// The kind.
    pub kind: String,
    /// Why not.
    pub why: String,
}
