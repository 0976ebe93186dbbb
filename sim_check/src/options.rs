//! What to check and what is known besides the file.
//!
//! ```
//! use sim_check::{CheckOptions, Tier};
//! let quick = CheckOptions { up_to: Tier::Static, ..CheckOptions::default() };
//! assert_eq!((quick.seed, quick.expected), (0, None));
//! ```

use std::collections::BTreeMap;

use crate::profile::Tier;
use crate::profile::subject::{Base, Subject};
use crate::read::meshes::Outside;
use crate::read::places::Places;

/// What to check and what is known besides the file.
#[derive(Clone, Debug)]
pub struct CheckOptions {
    /// Seed of every random choice.
    pub seed: u64,
    /// The highest tier to check for; more costs more time.
    pub up_to: Tier,
    /// Counts the kinematic condition promises; without it T4 does not apply.
    pub expected: Option<Expected>,
    /// What the caller knows of the asset's provenance; without it P1 and P2 are unknown.
    pub provenance: Provenance,
    /// Failures somebody answers for: id of the check to reason. They stand in the verdict and do
    /// not lower the tier. What is unknown cannot be waived.
    pub waivers: BTreeMap<String, String>,
    /// Whether meshes may lie outside the URDF's folder.
    pub outside: Outside,
    /// What the model is judged as.
    pub subject: Asked,
    /// Whether its base is fixed or free; by what is found without it.
    pub base: Option<Base>,
    /// Where `package://`, `model://`, `$(find …)` and `$(env …)` lead.
    pub places: Places,
}

/// What a model is to be judged as.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Asked {
    /// An asset that must keep every rule of the profile.
    #[default]
    Asset,
    /// This, whatever is found.
    As(Subject),
    /// What is found, which is said.
    Found,
}

/// Counts a kinematic condition promises.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Expected {
    /// Parts; links with visual or collision geometry.
    pub links: usize,
    /// Joints that move.
    pub joints: usize,
}

/// What only the caller can know: this crate reads no traces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Provenance {
    /// What a reader of the trace found wrong with it; empty if it is complete. `None`: nobody
    /// read it.
    pub trace_faults: Option<Vec<String>>,
    /// Licences (SPDX names, lower case) that the policy allows. `None`: no policy given.
    pub allowed_licences: Option<Vec<String>>,
}

impl Default for CheckOptions {
    /// Seed 0, everything up to `audited`, no expectations, no waivers, nothing outside.
    fn default() -> Self {
        Self {
            seed: 0,
            up_to: Tier::Audited,
            expected: None,
            provenance: Provenance::default(),
            waivers: BTreeMap::new(),
            outside: Outside::default(),
            subject: Asked::default(),
            base: None,
            places: Places::default(),
        }
    }
}
