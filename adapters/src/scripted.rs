//! Answers given beforehand, for tests: the in-memory twin of every provider.

use object::Condition;

use crate::critic::Remark;
use crate::{
    AdapterError, Critic, CritiqueQuestion, GeneratedMesh, ImageTo3d, KinematicQuestion, Photo, Vlm,
};

/// Answers every question with what it was given.
#[derive(Clone, Debug)]
pub struct Scripted {
    /// What it is called; part of the stage key.
    pub name: String,
    /// The mesh it makes.
    pub mesh: GeneratedMesh,
    /// The condition it proposes.
    pub condition: Condition,
    /// What it remarks.
    pub remarks: Vec<Remark>,
}

impl ImageTo3d for Scripted {
    fn identity(&self) -> Result<String, AdapterError> {
        Ok(format!("scripted/1 {}", self.name))
    }

    fn generate(&self, _photo: &Photo, _seed: u64) -> Result<GeneratedMesh, AdapterError> {
        Ok(self.mesh.clone())
    }
}

impl Vlm for Scripted {
    fn identity(&self) -> Result<String, AdapterError> {
        Ok(format!("scripted/1 {}", self.name))
    }

    fn propose(&self, question: &KinematicQuestion<'_>) -> Result<Condition, AdapterError> {
        let path = format!("scripted {}", self.name);
        let off = |source| AdapterError::Condition { path, source };
        self.condition.check_points(question.mesh).map_err(off)?;
        Ok(self.condition.clone())
    }
}

impl Critic for Scripted {
    fn identity(&self) -> Result<String, AdapterError> {
        Ok(format!("scripted/1 {}", self.name))
    }

    fn criticise(&self, _question: &CritiqueQuestion<'_>) -> Result<Vec<Remark>, AdapterError> {
        Ok(self.remarks.clone())
    }
}
