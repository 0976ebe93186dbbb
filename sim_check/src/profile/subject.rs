//! What is judged: an object or a robot, on a fixed or a free base.

use serde::{Deserialize, Serialize};

/// What a model is of, and so what is asked of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Subject {
    /// An asset: it must rest on the floor, have labels, bring no scale along, and no two of its
    /// parts may overlap anywhere.
    #[default]
    Object,
    /// A robot: its drives hold it, and its neighbours may touch.
    Robot,
}

/// Whether the root is tied to the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Base {
    /// It is.
    Fixed,
    /// It may fall.
    Free,
}

/// What a model was judged as, and why.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// An object or a robot.
    #[serde(rename = "as")]
    pub subject: Subject,
    /// Fixed or free.
    pub base: Base,
    /// What spoke for it.
    pub because: String,
}

impl Subject {
    /// Its name in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Object => "object",
            Self::Robot => "robot",
        }
    }
}

impl Base {
    /// Its name in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Free => "free",
        }
    }
}
