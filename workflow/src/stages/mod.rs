//! The steps of the flow, and what they reach the outside through.

pub mod artefacts;
mod articulate;
mod build_asset;
pub mod bundle;
mod check_in_sim;
mod code;
mod criticise;
mod exports;
mod generate_mesh;
mod motion_views;
mod propose_condition;
mod render_views;
pub mod repair;
mod shared;
mod write_urdf;

use std::path::PathBuf;

use adapters::{AdapterError, Critic, ImageTo3d, Vlm};

use crate::dag::stage::is_of_the_house;
use crate::dag::{Blame, StageError};

pub use artefacts::{Checked, Frame, Glb, LinkPose, Mjcf, UrdfPackage, Usd, Views};
pub use articulate::Articulate;
pub use build_asset::BuildAsset;
pub use check_in_sim::CheckInSim;
pub use criticise::Criticise;
pub use exports::{Export, WriteGlb, WriteMjcf, WriteUsd};
pub use generate_mesh::GenerateMesh;
pub use propose_condition::ProposeCondition;
pub use render_views::RenderViews;
pub use shared::Shared;
pub use write_urdf::WriteUrdf;

/// What the stages work with: whoever they ask, the seed, and a folder for passing files.
pub struct Tools {
    /// Makes a mesh from a photo.
    pub image_to_3d: Box<dyn ImageTo3d>,
    /// Says what the parts are.
    pub vlm: Box<dyn Vlm>,
    /// Says what looks wrong, where that is asked for.
    pub critic: Option<Box<dyn Critic>>,
    /// Labels faces and fits joints.
    pub articulate: Box<dyn model::Articulate + Send + Sync>,
    /// Seed of everything random.
    pub seed: u64,
    /// A folder for files that live no longer than a stage.
    pub scratch: PathBuf,
}

impl Tools {
    /// The stage that asks the critic, where there is one.
    pub fn criticise(&self) -> Option<Criticise> {
        self.critic.as_ref().map(|_| Criticise)
    }
}

/// An adapter's error as a stage's.
fn adapter_error(error: &AdapterError) -> StageError {
    let mut stage_error = StageError::from_error(error);
    if let Some(hint) = error.hint() {
        stage_error = stage_error.hint(hint);
    }
    if let AdapterError::Io { source, .. } = error
        && is_of_the_house(source)
    {
        stage_error = stage_error.blamed_on(Blame::House);
    }
    if error.is_over_budget() {
        stage_error = stage_error.blamed_on(Blame::Budget);
    }
    if error.is_transient() { stage_error.later(None) } else { stage_error }
}
