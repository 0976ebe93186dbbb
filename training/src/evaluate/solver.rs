//! Who answers: a whole articulator, on what the case gives or on what is supplied, or the joint fit
//! alone on true labels; and the question asked.

use model::classic::joints::{Joints, Labelled, fit_joints};
use model::fit::survive::{Survivors, survivors};
use model::{Articulate, ArticulateError, Articulation, Predecessor, Proposal};
use object::weld::Weld;
use object::{ArticulatedObject, Condition};

use super::case::Case;
use super::given::{Given, Mode, Supply, SupplyError};
use super::how::How;
use crate::metrics::{Link, Motion};

/// Who answers a case.
pub enum Solver {
    /// Labels and joints by an articulator.
    Whole(Box<dyn Articulate + Send + Sync>),
    /// The same on a mesh and a condition that are not, or not both, the case's.
    Supplied(Box<dyn Articulate + Send + Sync>, Box<dyn Supply>),
    /// Labels, joints and what parts there are by Particulate, which is given nothing but the mesh.
    Alone(Box<Predecessor>),
    /// True labels, joints by the geometric solver.
    JointsOnTrueLabels,
}

/// What was answered.
#[derive(Debug)]
pub struct Answer {
    /// The object.
    pub made: Articulation,
    /// What it was asked about, with all that was kept from the solver.
    pub asked: Condition,
}

/// Why nothing was answered.
#[derive(Debug, thiserror::Error)]
pub enum AnswerError {
    /// The articulator's.
    #[error(transparent)]
    Articulate(#[from] ArticulateError),
    /// What the case does not give was not supplied.
    #[error(transparent)]
    Supply(#[from] SupplyError),
}

impl Solver {
    /// Name and version of who answers.
    pub fn identity(&self) -> String {
        match self {
            Self::Whole(articulator) => articulator.identity(),
            Self::Supplied(articulator, supply) => {
                format!("{}, {}", articulator.identity(), supply.identity())
            }
            Self::Alone(predecessor) => predecessor.identity(),
            Self::JointsOnTrueLabels => format!("{}, true labels", model::Geometric.identity()),
        }
    }

    /// What it takes from a case.
    pub fn mode(&self) -> Mode {
        match self {
            Self::Whole(_) | Self::JointsOnTrueLabels => Mode::MeshAndKinematic,
            Self::Supplied(_, supply) => supply.mode(),
            Self::Alone(_) => Mode::Mesh,
        }
    }

    /// Articulates a case, told no more than `how` allows.
    ///
    /// # Errors
    /// [`AnswerError`], the articulator's own, or that of whoever supplies what the case does not give.
    pub fn answer(&self, case: &Case, how: &How) -> Result<Answer, AnswerError> {
        let told = |condition| how.without.strip(condition).map_err(ArticulateError::from);
        let own = || case.condition.clone();
        let (made, asked) = match self {
            Self::Whole(articulator) => {
                (articulator.articulate(&case.mesh, &told(&case.condition)?, how.seed)?, own())
            }
            Self::Supplied(articulator, supply) => {
                let Given { mesh, condition } = supply.given(&case.folder)?;
                (articulator.articulate(&mesh, &told(&condition)?, how.seed)?, condition)
            }
            Self::Alone(predecessor) => {
                let Proposal { condition, articulation } =
                    predecessor.propose(&case.mesh, how.seed)?;
                (articulation, condition)
            }
            Self::JointsOnTrueLabels => {
                (joints_alone(case, &told(&case.condition)?, how.seed)?, own())
            }
        };
        Ok(Answer { made, asked })
    }
}

fn joints_alone(
    case: &Case,
    condition: &Condition,
    seed: u64,
) -> Result<Articulation, ArticulateError> {
    let Survivors { tree, part_of_condition, part_of_face } =
        survivors(condition, &case.part_of_face)?;
    let (mesh, weld) = (&case.mesh, &Weld::new(&case.mesh));
    let category = condition.category.as_str();
    let from =
        Labelled { mesh, weld, tree: &tree, part_of_face: &part_of_face, category, given: &[] };
    let Joints { motions, notes } = fit_joints(&from, &[], seed);
    let object = ArticulatedObject::new(mesh.clone(), tree, part_of_face, motions)?;
    Ok(Articulation { object, part_of_condition, notes, confidence: None })
}

/// For each part of the object, its number in the condition.
fn condition_numbers(made: &Articulation) -> Vec<usize> {
    let mut number = vec![0; made.object.tree().len()];
    for (condition, part) in made.part_of_condition.iter().enumerate() {
        if let Some(slot) = part.and_then(|p| number.get_mut(p)) {
            *slot = condition;
        }
    }
    number
}

/// The part of each face by its number in the condition.
pub fn labels_by_condition(made: &Articulation) -> Vec<u16> {
    let number = condition_numbers(made);
    made.object.part_of_face().iter().map(|&p| number[usize::from(p)] as u16).collect()
}

/// Parents and motions by number in the condition, the mesh's unit; a lost part hangs on nothing and
/// does not move.
pub fn links(made: &Articulation) -> Vec<Link> {
    let number = condition_numbers(made);
    let mut links = vec![Link::default(); made.part_of_condition.len()];
    for (part, &place) in number.iter().enumerate() {
        let motion = |m: &object::JointMotion| {
            let (lower, upper) = m.range.ends();
            Motion { kind: m.kind, axis: m.axis, pivot: m.pivot, lower, upper }
        };
        links[place] = Link {
            parent: made.object.tree().parent(part).map(|p| number[p]),
            motions: made.object.joints(part).iter().map(motion).collect(),
        };
    }
    links
}
