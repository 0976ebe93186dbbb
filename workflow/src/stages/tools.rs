//! What the steps reach the outside through.

use std::path::PathBuf;

use adapters::{AdapterError, ConditionFile, Critic, ImageTo3d, MeshFile, Vlm};
use model::Choice;
use runner::failure::is_of_the_house;
use runner::{Blame, StageError};

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
    /// What stages that compute work with; none of them asks anybody.
    pub fn computing(seed: u64, scratch: PathBuf) -> Self {
        let (image_to_3d, vlm) = (
            MeshFile { path: "".into(), ..Default::default() },
            ConditionFile { path: "".into(), ..Default::default() },
        );
        Self {
            image_to_3d: Box::new(image_to_3d),
            vlm: Box::new(vlm),
            critic: None,
            articulate: model::articulator(Choice::default()),
            seed,
            scratch,
        }
    }
}

/// An adapter's error as a stage's.
pub(super) fn adapter_error(error: &AdapterError) -> StageError {
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
