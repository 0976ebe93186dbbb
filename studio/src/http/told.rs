//! What a page is told without asking.

use schemars::JsonSchema;
use serde::Serialize;

use crate::house::StageState;

/// Something that happened; its name is the event's.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[serde(untagged)]
pub(crate) enum Event {
    /// `stage`: a stage of a build.
    Stage {
        /// The build's number.
        build: u64,
        /// The stage.
        stage: String,
        /// What became of it.
        state: StageState,
        /// How many stages are done.
        done: usize,
        /// How many there are.
        of: usize,
    },
    /// `built`: a build ended.
    Built {
        /// The build's number.
        build: u64,
        /// As the command line's exit code.
        exit: u8,
        /// The tier it reaches.
        tier: Option<String>,
        /// How it went, in a line.
        message: String,
        /// Where it stands.
        out: String,
    },
    /// `condition`: somebody else changed the condition file.
    Condition {
        /// What stands there now.
        revision: String,
    },
    /// `tabs`: so many pages are open.
    Tabs {
        /// Their number.
        count: usize,
    },
    /// `lost`: the page fell behind, and should ask for the state.
    Lost {
        /// What was lost.
        what: String,
    },
}

impl Event {
    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::Stage { .. } => "stage",
            Self::Built { .. } => "built",
            Self::Condition { .. } => "condition",
            Self::Tabs { .. } => "tabs",
            Self::Lost { .. } => "lost",
        }
    }
}
