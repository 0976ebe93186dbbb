//! One provider for many runs at once.

use std::sync::Arc;

use adapters::critic::Remark;
use adapters::{
    AdapterError, Critic, CritiqueQuestion, GeneratedMesh, ImageTo3d, KinematicQuestion, Photo, Vlm,
};
use object::Condition;

/// A provider that all runs share.
pub struct Shared<A: ?Sized>(pub Arc<A>);

impl ImageTo3d for Shared<dyn ImageTo3d> {
    fn identity(&self) -> Result<String, AdapterError> {
        self.0.identity()
    }

    fn generate(&self, photo: &Photo, seed: u64) -> Result<GeneratedMesh, AdapterError> {
        self.0.generate(photo, seed)
    }
}

impl Vlm for Shared<dyn Vlm> {
    fn identity(&self) -> Result<String, AdapterError> {
        self.0.identity()
    }

    fn propose(&self, question: &KinematicQuestion<'_>) -> Result<Condition, AdapterError> {
        self.0.propose(question)
    }
}

impl Critic for Shared<dyn Critic> {
    fn identity(&self) -> Result<String, AdapterError> {
        self.0.identity()
    }

    fn criticise(&self, question: &CritiqueQuestion<'_>) -> Result<Vec<Remark>, AdapterError> {
        self.0.criticise(question)
    }
}
