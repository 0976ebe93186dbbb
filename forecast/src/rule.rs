//! What a rule is: whom it is about, what it says, where that is known from, and what it looks for.

use serde::Serialize;

use crate::client::Client;
use crate::read::mjcf::Mjcf;
use crate::read::urdf::Urdf;
use crate::read::usda::Stage;

/// How much follows from a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The client loads nothing, or stops at the first step.
    Refused,
    /// It moves, weighs or touches otherwise than the file says.
    Behaves,
    /// It looks otherwise than the file says.
    Looks,
    /// Good to know; true of most files.
    Note,
}

impl Severity {
    /// The word that is shown for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Refused => "refused",
            Self::Behaves => "behaves",
            Self::Looks => "looks",
            Self::Note => "note",
        }
    }
}

/// Where a rule is known from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    /// A test of this script asks the real engine, under the rule's id.
    Measured(&'static str),
    /// Read in the client's documentation or source; no test asks it.
    Read(&'static str),
}

/// Where in the file a rule applies.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Place {
    /// The element's name, such as `joint`.
    pub element: &'static str,
    /// What its `name` attribute says; empty if it has none.
    pub name: String,
    /// Line of the file, from 1.
    pub line: u32,
    /// What was found there, such as a file name; may be empty.
    pub found: String,
}

/// What a rule looks for in a file of its format.
#[derive(Clone, Copy, Debug)]
pub enum Find {
    /// In a URDF.
    Urdf(fn(&Urdf) -> Vec<Place>),
    /// In an MJCF model.
    Mjcf(fn(&Mjcf) -> Vec<Place>),
    /// In a USD stage, as text.
    Usd(fn(&Stage) -> Vec<Place>),
}

impl Find {
    /// The format it reads.
    pub fn format(self) -> &'static str {
        match self {
            Self::Urdf(_) => "URDF",
            Self::Mjcf(_) => "MJCF",
            Self::Usd(_) => "USD",
        }
    }
}

/// A written rule.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// The client's name, a dot, and the peculiarity: `mujoco.range-zero`.
    pub id: &'static str,
    /// Whom it is about.
    pub client: Client,
    /// How much follows.
    pub severity: Severity,
    /// What was asked or read, with its version: `mujoco 4.0.0`.
    pub version: &'static str,
    /// Where it is known from.
    pub source: Source,
    /// What will happen.
    pub sentence: &'static str,
    /// What to do about it.
    pub remedy: &'static str,
    /// What it looks for.
    pub find: Find,
}

/// A client whose rules one script asks the real engine about.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tested {
    /// The client.
    pub client: Client,
    /// What is asked, with its version.
    pub version: &'static str,
    /// The script, from this crate's folder.
    pub script: &'static str,
}

impl Tested {
    /// One of its rules.
    pub(crate) const fn rule(
        self,
        id: &'static str,
        severity: Severity,
        find: Find,
        sentence: &'static str,
        remedy: &'static str,
    ) -> Rule {
        let Self { client, version, script } = self;
        let source = Source::Measured(script);
        Rule { id, client, severity, version, source, sentence, remedy, find }
    }
}
