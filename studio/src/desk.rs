//! Labels and joints of the mesh on the desk, as `make` finds them.

use std::sync::OnceLock;

use model::{ArticulateError, Note, PartLabels, Prepared};
use object::condition::ConditionError;
use object::{Condition, DVec3, JointMotion, Mesh, Range};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::question::{self, Asked};

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
    /// Nothing can be found on this mesh.
    #[error("nothing can be found on this mesh: {0}")]
    Mesh(String),
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

/// Labels and joints, and what to ask about them.
#[derive(Clone, Debug, PartialEq)]
pub struct Articulated {
    /// The part of every face.
    pub labels: Labels,
    /// The joints that were found.
    pub found: Vec<Found>,
    /// The question whose answer would help most, if anything is in doubt.
    pub question: Option<Asked>,
}

/// A mesh, and what is known of it whatever the condition says.
pub struct Desk {
    mesh: Mesh,
    prepared: OnceLock<Result<Prepared, String>>,
    labelling: OnceLock<Option<ThreadPool>>,
    jointing: OnceLock<Option<ThreadPool>>,
}

impl Desk {
    /// Puts a mesh on the desk.
    pub fn new(mesh: Mesh) -> Self {
        let (prepared, labelling, jointing) = Default::default();
        Self { mesh, prepared, labelling, jointing }
    }

    /// The mesh, object frame.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Metres that one unit of the mesh is in the finished object.
    pub fn scale(&self, condition: &Condition) -> f64 {
        condition.size.map_or(1.0, |size| size.scale_for(&self.mesh))
    }

    /// Makes the mesh ready, which takes seconds; whatever is asked does it, too, where nobody did.
    ///
    /// # Errors
    /// [`DeskError`] where nothing can be found on this mesh.
    pub fn prepare(&self) -> Result<&Prepared, DeskError> {
        let made =
            self.prepared.get_or_init(|| Prepared::new(&self.mesh).map_err(|e| e.to_string()));
        made.as_ref().map_err(|why| DeskError::Mesh(why.clone()))
    }

    /// The part of every face, as `make` labels them.
    ///
    /// # Errors
    /// [`DeskError`] when the condition does not fit the mesh, or nothing can be labelled.
    pub fn labels(&self, condition: &Condition) -> Result<Labels, DeskError> {
        let condition = condition.of_shape();
        let prepared = self.prepare()?;
        let found = within(&self.labelling, 1, || prepared.labels(&condition))?;
        let PartLabels { part_of_face, confidence, notes } = found;
        Ok(Labels { part_of_face, confidence, notes })
    }

    /// The joints, as `make` finds them, of those parts that have a face, and the question whose answer would
    /// help most.
    ///
    /// # Errors
    /// As [`Desk::labels`].
    pub fn articulate(&self, condition: &Condition) -> Result<Articulated, DeskError> {
        let labels = self.labels(condition)?;
        let size = condition.size;
        let condition = condition.of_shape();
        let prepared = self.prepare()?;
        let asked = || prepared.articulate(&condition, SEED);
        // Joints take seconds: half of the processors stay free for labels, which a person waits for.
        let (made, choices) = within(&self.jointing, 2, asked)?;
        let mut found = Vec::new();
        for (part, new) in made.part_of_condition.iter().enumerate() {
            let Some(new) = *new else { continue };
            for (index, motion) in made.object.joints(new).iter().enumerate() {
                let own = choices.iter().find(|c| (c.part, c.joint) == (part, index));
                let axes = own.into_iter().flat_map(|c| &c.axes);
                let candidates = axes.map(|a| (a.direction, a.pivot, a.probability)).collect();
                found.push(Found { part, index, motion: *motion, candidates });
            }
        }
        // What was found does not depend on the size; lengths that a question names do.
        let question = question::asked(&made, &Condition { size, ..condition });
        Ok(Articulated { labels: Labels { notes: made.notes, ..labels }, found, question })
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
        line: (DVec3, DVec3),
    ) -> Result<Range, DeskError> {
        let condition = condition.of_shape();
        let no_joint = || DeskError::Joint { part: part.to_owned(), index };
        let at = condition.tree.parts().iter().position(|p| p.name == part).ok_or_else(no_joint)?;
        let prepared = self.prepare()?;
        let asked = || prepared.free_range(&condition, (at, index), line, SEED);
        match within(&self.labelling, 1, asked) {
            Err(ArticulateError::NoJoint { .. }) => Err(no_joint()),
            found => Ok(found?),
        }
    }
}

/// Does something on threads of its own: one for each `share` processors.
fn within<T: Send>(
    pool: &OnceLock<Option<ThreadPool>>,
    share: usize,
    work: impl FnOnce() -> T + Send,
) -> T {
    let made = pool.get_or_init(|| {
        let all = std::thread::available_parallelism().map_or(1, usize::from);
        ThreadPoolBuilder::new().num_threads(all.div_ceil(share)).build().ok()
    });
    match made {
        Some(pool) => pool.install(work),
        None => work(),
    }
}
