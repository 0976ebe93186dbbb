//! Evaluation: objects with known parts and joints, what an articulator makes of them, and what that
//! is worth.
//!
//! A case is read, answered, measured and let go of before its worker takes the next; only its
//! [`Row`] stays. Rows depend on the case, the solver and [`How`] alone, not on the number of jobs.

pub mod case;
pub mod csv;
pub mod doubts;
pub mod given;
pub mod how;
pub mod outcome;
pub mod report;
pub mod sheet;
pub mod solver;
pub mod summary;
pub mod table;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use model::Articulation;
use model::features::UnitCube;
use object::confidence::PartConfidence;
use object::sample::sample_surface;
use object::{Confidence, Mesh};
use rayon::ThreadPool;
use serde::Serialize;

use crate::metrics::{
    Body, BodyError, Comparer, Comparison, JointComparison, Link, Motion, Scores, compare_joints,
    moved_points_giou, point_ious,
};

pub use case::{Case, CaseError, Set};
pub use given::{Given, Mode, Supply, SupplyError};
pub use how::{How, Prompts, Without};
pub use report::Report;
pub use solver::{Answer, AnswerError, Solver};
pub use summary::Summary;

/// What one case came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Its name.
    pub case: String,
    /// Where it belongs.
    pub set: Set,
    /// Why there is no prediction, if there is none; the scores are then the worst there are.
    pub error: Option<String>,
    /// True parts.
    pub parts: usize,
    /// Names of parts the prediction has no face for.
    pub lost: Vec<String>,
    /// Scores when parts of the same number go together; none where numbers say nothing.
    pub identity: Option<Scores>,
    /// Scores when parts go together by their centroids, as in the paper.
    pub hungarian: Scores,
    /// The point IoU of every true part with points, in the order of their numbers, parts together as
    /// for `joints`; empty where the two surfaces are not the same.
    pub points: Vec<PartPoints>,
    /// Every true joint and what became of it, parts of the same number together, or by centroid where
    /// numbers say nothing.
    pub joints: Vec<NamedJoint>,
    /// How likely the articulator found the whole to be right, 0 to 1; none where it does not say.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub confidence: Option<f64>,
    /// Which predicted part goes with which true one, where numbers do not say it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub pairs: Vec<(u16, u16)>,
}

impl Row {
    /// The main figures: by number, or by centroid where numbers say nothing.
    pub fn scores(&self) -> &Scores {
        self.identity.as_ref().unwrap_or(&self.hungarian)
    }
}

/// How well the points of a true part were found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PartPoints {
    /// Its number.
    pub part: u16,
    /// What the condition calls it.
    pub text: String,
    /// IoU of its points, 0 to 1.
    pub iou: f64,
    /// How likely the articulator found it to be right, 0 to 1; none where it does not say.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub confidence: Option<f64>,
}

/// A joint of a part that has a name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NamedJoint {
    /// What the condition calls the part.
    pub text: String,
    /// How the joint fared.
    #[serde(flatten)]
    pub joint: JointComparison,
    /// How likely the articulator found it to be right, 0 to 1; none where it does not say.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub confidence: Option<f64>,
}

/// Why there is nothing to measure.
#[derive(Debug, thiserror::Error)]
enum RowError {
    #[error(transparent)]
    Case(#[from] CaseError),
    #[error(transparent)]
    Answer(#[from] AnswerError),
    #[error("the points drawn on the {side} surface: {source}")]
    Body { side: &'static str, source: BodyError },
}

/// Half the diagonal of the unit cube, what a missing part's Chamfer distance is at most.
const HALF_DIAGONAL: f64 = 0.866_025_403_784_438_6;

/// Evaluates cases, `jobs` at a time with one thread each, and tells `heard` of every row as it
/// comes, with the time the case took; rows are returned in the order of `folders`.
///
/// # Errors
/// [`rayon::ThreadPoolBuildError`] when there are no threads to be had.
pub fn evaluate_all(
    folders: &[PathBuf],
    solver: &Solver,
    how: &How,
    jobs: usize,
    mut heard: impl FnMut(&Row, Duration),
) -> Result<Vec<Row>, rayon::ThreadPoolBuildError> {
    let pool = |_| rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pools =
        (0..jobs.clamp(1, folders.len().max(1))).map(pool).collect::<Result<Vec<_>, _>>()?;
    let next = AtomicUsize::new(0);
    let (send, receive) = mpsc::channel();
    let mut rows = thread::scope(|scope| {
        for pool in &pools {
            let (send, next) = (send.clone(), &next);
            scope.spawn(move || {
                let take = || next.fetch_add(1, Ordering::Relaxed);
                while let Some((place, folder)) =
                    Some(take()).and_then(|i| Some((i, folders.get(i)?)))
                {
                    let (row, time) = timed(pool, || evaluate(folder, solver, how));
                    // The receiver outlives the workers.
                    let _ = send.send((place, row, time));
                }
            });
        }
        drop(send);
        let mut rows = Vec::with_capacity(folders.len());
        for (place, row, time) in receive {
            heard(&row, time);
            rows.push((place, row));
        }
        rows
    });
    rows.sort_by_key(|(place, _)| *place);
    Ok(rows.into_iter().map(|(_, row)| row).collect())
}

fn timed(pool: &ThreadPool, work: impl FnOnce() -> Row + Send) -> (Row, Duration) {
    let start = Instant::now();
    let row = pool.install(work);
    (row, start.elapsed())
}

/// Reads a case, has it answered and measures the answer; a case that fails is a row, too.
pub fn evaluate(folder: &Path, solver: &Solver, how: &How) -> Row {
    let case = match Case::read_with(folder, how.prompts, how.seed) {
        Ok(case) => case,
        Err(error) => return unread(&case::name_of(folder), solver.mode(), &error),
    };
    let made = solver.answer(&case, how).map_err(RowError::from);
    match made.and_then(|made| measured(&case, &made, (solver.mode(), how))) {
        Ok(row) => row,
        Err(error) => unanswered(&case, solver.mode(), &error),
    }
}

/// Of a case that cannot be read not even the joints are known; none of them counts as found.
fn unread(name: &str, mode: Mode, error: &CaseError) -> Row {
    let mut nothing = Scores::nothing(HALF_DIAGONAL, mode.has_surface(), &[]);
    (nothing.joints.near, nothing.joints.found) = (Some(0.0), Some(0.0));
    Row {
        case: name.into(),
        set: Set::of(name),
        error: Some(error.to_string()),
        parts: 0,
        lost: Vec::new(),
        identity: mode.has_numbers().then(|| nothing.clone()),
        hungarian: nothing,
        points: Vec::new(),
        joints: Vec::new(),
        confidence: None,
        pairs: Vec::new(),
    }
}

fn unanswered(case: &Case, mode: Mode, error: &RowError) -> Row {
    let numbered = (0..).zip(&case.links);
    let missing = numbered.flat_map(|(part, link)| {
        link.motions.iter().map(move |m| JointComparison::missing(part, m))
    });
    let joints: Vec<_> = missing.collect();
    let half_diagonal = case.mesh.bounds().diagonal() / UnitCube::of(&case.mesh).side / 2.0;
    let nothing = Scores::nothing(half_diagonal, mode.has_surface(), &joints);
    let parts = case.condition.tree.parts();
    Row {
        case: case.name.clone(),
        set: Set::of(&case.name),
        error: Some(error.to_string()),
        parts: parts.len(),
        lost: parts.iter().map(|p| p.name.clone()).collect(),
        identity: mode.has_numbers().then(|| nothing.clone()),
        hungarian: nothing,
        points: Vec::new(),
        joints: named(case, joints),
        confidence: None,
        pairs: Vec::new(),
    }
}

fn measured(case: &Case, answer: &Answer, (mode, how): (Mode, &How)) -> Result<Row, RowError> {
    let sides = Sides::new(case, answer, (mode, how))?;
    let mut comparer =
        Comparer::new(sides.predicted.clone(), sides.truth.clone(), how.rules, how.seed);
    let by_centroid = comparer.by_centroid();
    let by_centroid = comparer.compare(&by_centroid);
    let centroids = sides.measure(&by_centroid);
    let hungarian = centroids.scores.clone();
    let (identity, own, pairs) = if mode.has_numbers() {
        let by_number = comparer.by_number();
        let own = sides.measure(&comparer.compare(&by_number));
        (Some(own.scores.clone()), own, Vec::new())
    } else {
        (None, centroids, pairs(&by_centroid))
    };
    let text = |part: u16| case.condition.text(usize::from(part)).to_owned();
    let sure = Sureness::of(&answer.made, mode);
    let points = own.points.into_iter().map(|(part, iou)| PartPoints {
        part,
        text: text(part),
        iou,
        confidence: sure.of_part(part).map(|sure| sure.labels),
    });
    let parts = answer.asked.tree.parts().iter().zip(&answer.made.part_of_condition);
    let lost = parts.filter(|(_, found)| found.is_none());
    Ok(Row {
        case: case.name.clone(),
        set: Set::of(&case.name),
        error: None,
        parts: case.condition.tree.len(),
        lost: lost.map(|(part, _)| part.name.clone()).collect(),
        identity,
        hungarian,
        points: points.collect(),
        joints: sure.named(case, own.joints),
        confidence: sure.0.map(|(_, sure)| sure.object),
        pairs,
    })
}

/// How sure an articulation is, by the numbers of parts, where these say anything.
struct Sureness<'a>(Option<(&'a Articulation, &'a Confidence)>);

impl<'a> Sureness<'a> {
    fn of(made: &'a Articulation, mode: Mode) -> Self {
        let said = made.confidence.as_ref().filter(|_| mode.has_numbers());
        Self(said.map(|confidence| (made, confidence)))
    }

    fn of_part(&self, part: u16) -> Option<&'a PartConfidence> {
        let (made, confidence) = self.0?;
        confidence.parts.get((*made.part_of_condition.get(usize::from(part))?)?)
    }

    /// Joints, each with how sure it is: those of a part come in order.
    fn named(&self, case: &Case, joints: Vec<JointComparison>) -> Vec<NamedJoint> {
        let mut named = named(case, joints);
        for first in 0..named.len() {
            let part = named[first].joint.part;
            let place = named[..first].iter().filter(|j| j.joint.part == part).count();
            let sure = self.of_part(part).and_then(|sure| sure.joints.get(place));
            named[first].confidence = sure.map(|sure| sure.joint);
        }
        named
    }
}

fn named(case: &Case, joints: Vec<JointComparison>) -> Vec<NamedJoint> {
    let text = |part: u16| case.condition.text(usize::from(part)).to_owned();
    joints
        .into_iter()
        .map(|joint| NamedJoint { text: text(joint.part), joint, confidence: None })
        .collect()
}

/// Who goes with whom: predicted parts and true ones.
fn pairs(comparison: &Comparison) -> Vec<(u16, u16)> {
    comparison.matched.iter().map(|m| (m.predicted, m.truth)).collect()
}

/// Both sides of a case, each in the unit cube, and what the prediction says at the truth's points,
/// where both are of one surface.
struct Sides {
    predicted: Body,
    truth: Body,
    predicted_at_truth: Option<Vec<u16>>,
}

impl Sides {
    fn new(case: &Case, answer: &Answer, (mode, how): (Mode, &How)) -> Result<Self, RowError> {
        let (mesh, made) = (answer.made.object.mesh(), &answer.made);
        let (labels, links) = (solver::labels_by_condition(made), solver::links(made));
        let truth = drawn(&case.mesh, how.points, how.seed, &case.part_of_face);
        let found = drawn(mesh, how.points, how.seed.wrapping_add(1), &labels);
        let at_truth = || truth.faces.iter().map(|&f| labels[f as usize]).collect();
        let predicted_at_truth = mode.has_surface().then(at_truth);
        let body = |side, (mesh, drawn): (&Mesh, Drawn), links: &[Link]| {
            let cube = UnitCube::of(mesh);
            let points = drawn.points.iter().map(|&p| cube.inside(p)).collect();
            let body = Body::new(points, drawn.labels, links_in(links, cube));
            body.map_err(|source| RowError::Body { side, source })
        };
        let predicted = body("predicted", (mesh, found), &links)?;
        let truth = body("true", (&case.mesh, truth), &case.links)?;
        Ok(Self { predicted, truth, predicted_at_truth })
    }

    fn measure(&self, comparison: &Comparison) -> Measured {
        let pairs = pairs(comparison);
        let mut parts = self.truth.part_of_point().to_vec();
        parts.sort_unstable();
        parts.dedup();
        let match_of = |t: u16| pairs.iter().find(|(_, truth)| *truth == t).map(|(p, _)| *p);
        let matched = parts.iter().map(|&t| (t, match_of(t)));
        let joints = compare_joints(&self.predicted, &self.truth, matched);
        let at_truth = self.predicted_at_truth.as_ref();
        let points = at_truth.map(|p| point_ious(p, self.truth.part_of_point(), &pairs));
        let moved = moved_points_giou(&self.predicted, &self.truth, &pairs);
        let scores = Scores::of(comparison, points.as_ref(), moved, &joints);
        Measured { scores, points: points.map(|p| p.of_true).unwrap_or_default(), joints }
    }
}

/// What two sides come to under one matching of their parts.
struct Measured {
    scores: Scores,
    points: BTreeMap<u16, f64>,
    joints: Vec<JointComparison>,
}

/// Points drawn on a surface, with their faces and the parts of those.
struct Drawn {
    points: Vec<object::DVec3>,
    faces: Vec<u32>,
    labels: Vec<u16>,
}

fn drawn(mesh: &Mesh, count: usize, seed: u64, part_of_face: &[u16]) -> Drawn {
    let sampled = sample_surface(mesh, count, seed);
    Drawn {
        points: sampled.iter().map(|s| s.position).collect(),
        labels: sampled.iter().map(|s| part_of_face[s.face as usize]).collect(),
        faces: sampled.iter().map(|s| s.face).collect(),
    }
}

/// Links in the unit cube: pivots moved, slides scaled.
fn links_in(links: &[Link], cube: UnitCube) -> Vec<Link> {
    let motion = |m: &Motion| {
        let scale = if m.kind.turns() { 1.0 } else { 1.0 / cube.side };
        let (lower, upper) = (m.lower * scale, m.upper * scale);
        Motion { pivot: cube.inside(m.pivot), lower, upper, ..*m }
    };
    let link = |l: &Link| Link { motions: l.motions.iter().map(motion).collect(), ..l.clone() };
    links.iter().map(link).collect()
}

#[cfg(test)]
mod tests;
