//! Answers out of a trace: what was given by hand or made by a program, as it was.

use object::Condition;

use crate::critic::Remark;
use crate::{
    AdapterError, Critic, Critique, CritiqueQuestion, GeneratedMesh, ImageTo3d, KinematicQuestion,
    Photo, Vlm,
};

/// An answer and who gave it.
#[derive(Clone, Debug)]
pub struct Kept<A> {
    /// Who gave it, as the trace says.
    pub identity: String,
    /// What it was.
    pub answer: A,
}

impl ImageTo3d for Kept<GeneratedMesh> {
    fn identity(&self) -> Result<String, AdapterError> {
        Ok(self.identity.clone())
    }

    fn generate(&self, _photo: &Photo, _seed: u64) -> Result<GeneratedMesh, AdapterError> {
        Ok(self.answer.clone())
    }
}

impl Vlm for Kept<Condition> {
    fn identity(&self) -> Result<String, AdapterError> {
        Ok(self.identity.clone())
    }

    fn propose(&self, question: &KinematicQuestion<'_>) -> Result<Condition, AdapterError> {
        let path = self.identity.clone();
        let wrap = |source| AdapterError::Condition { path, source };
        self.answer.check_points(question.mesh).map_err(wrap)?;
        Ok(self.answer.clone())
    }
}

impl Critic for Kept<Critique> {
    fn identity(&self) -> Result<String, AdapterError> {
        Ok(self.identity.clone())
    }

    fn criticise(&self, _question: &CritiqueQuestion<'_>) -> Result<Vec<Remark>, AdapterError> {
        match &self.answer {
            Critique::Given(remarks) => Ok(remarks.clone()),
            Critique::Lost(why) => Err(AdapterError::NoCritique(why.clone())),
        }
    }
}
