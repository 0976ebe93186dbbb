//! Seeing and editing: the state, the mesh, the condition, labels and joints.

use std::sync::Arc;

use axum::Json;
use axum::body::Body;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use model::Note;
use object::mesh::FileFrame;
use object::{Condition, DVec3, JointKind, Range};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::answers::{Asked, FaultLine, Refusal, faults};
use super::building::{BuildAnswer, BuiltAnswer};
use super::room::{Inner, Room, Turn, apart, locked};
use crate::desk::{Articulated, Desk, Found, Labels};
use crate::paper::{Paper, PaperError};

/// An axis lies no farther from the mesh than this many of its diagonals, as in a condition.
const FAR: f64 = 2.0;

/// What the page is about, and how far it is.
#[derive(Serialize, JsonSchema)]
pub(crate) struct StateAnswer {
    /// Version of the program.
    version: String,
    /// What the object is called.
    title: String,
    #[serde(flatten)]
    condition: ConditionAnswer,
    /// The text of the condition file.
    text: String,
    /// The condition file.
    path: String,
    /// Whether it has comments, which are lost when it is written anew.
    has_comments: bool,
    /// Whether there is a photo.
    photo: bool,
    /// Whether assets can be built here.
    can_build: bool,
    /// Why not, where not.
    why_not: Option<String>,
    /// Whether somebody can be asked for a condition.
    can_draft: bool,
    /// The mesh.
    mesh: MeshAnswer,
    /// The rotation from the object frame to the condition file's frame, by rows.
    to_file: [[f64; 3]; 3],
    /// Where an asset goes.
    out: String,
    /// How the last build ended.
    built: Option<BuiltAnswer>,
    /// What is being built.
    building: Option<BuildAnswer>,
}

/// What a condition file says.
#[derive(Serialize, JsonSchema)]
pub(crate) struct ConditionAnswer {
    /// Names what stands in the file.
    revision: String,
    /// What it says, as JSON.
    document: Value,
    /// All that is wrong with it.
    faults: Vec<FaultLine>,
    /// Metres of one unit of the mesh, as the condition's size has it; 1 where it says none.
    scale: f64,
}

/// The mesh on the screen.
#[derive(Serialize, JsonSchema)]
pub(crate) struct MeshAnswer {
    /// Its file.
    name: String,
    /// Its digest, which painted faces are counted against.
    digest: String,
    /// Its vertices.
    vertices: usize,
    /// Its faces.
    faces: usize,
    /// How many faces are drawn.
    shown_faces: usize,
    /// The smallest corner of its box, object frame, its own unit.
    low: [f64; 3],
    /// The largest corner.
    high: [f64; 3],
    /// What else there is to say.
    notes: Vec<String>,
}

/// Another text for the condition file.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct WriteBody {
    /// The text.
    text: String,
    /// The revision that was changed.
    base: String,
}

/// A question about a condition.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct AskBody {
    /// The revision that is asked about.
    revision: String,
}

/// A question about an axis.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RangeBody {
    /// The revision that is asked about.
    revision: String,
    /// The part.
    part: String,
    /// Which of its joints.
    #[serde(default)]
    index: usize,
    /// The axis, object frame.
    axis: [f64; 3],
    /// A point on it, object frame, the mesh's unit.
    pivot: [f64; 3],
}

/// How far a joint is free.
#[derive(Serialize, JsonSchema)]
pub(crate) struct RangeAnswer {
    /// Both ends, radians or metres of the finished object; 0 is the pose the mesh shows.
    range: [f64; 2],
}

/// A part for every face that is drawn.
#[derive(Serialize, JsonSchema)]
pub(crate) struct LabelsAnswer {
    /// The revision that was asked about.
    revision: String,
    /// The parts, in the condition's order.
    parts: Vec<String>,
    /// Bytes of one label, 1 or 2.
    width: usize,
    /// Base64: for each drawn face the index of its part, little endian.
    faces: String,
    /// Base64: for each drawn face how sure that is, 0 to 255.
    confidence: String,
    /// What was noticed.
    notes: Vec<NoteAnswer>,
    /// How long it took, milliseconds.
    took_ms: u64,
    /// Joints, where they were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    joints: Option<Vec<JointAnswer>>,
    /// The question whose answer would help most, where joints were asked for and anything is in doubt.
    #[serde(skip_serializing_if = "Option::is_none")]
    question: Option<crate::question::Asked>,
}

/// Something a person should know about a part.
#[derive(Serialize, JsonSchema)]
pub(crate) struct NoteAnswer {
    /// The part.
    part: String,
    /// What happened.
    message: String,
    /// Whether something asked for is missing.
    loss: bool,
}

/// A joint that was found, or given.
#[derive(Serialize, JsonSchema)]
pub(crate) struct JointAnswer {
    /// The part that it moves.
    part: String,
    /// Which of the part's joints.
    index: usize,
    /// `revolute`, `continuous` or `prismatic`.
    kind: &'static str,
    /// Unit direction, object frame.
    axis: [f64; 3],
    /// A point on it, object frame, the mesh's unit.
    pivot: [f64; 3],
    /// Both ends, radians or metres of the finished object; none without end.
    range: Option<[f64; 2]>,
    /// Other axes that might be it, the best first.
    candidates: Vec<CandidateAnswer>,
}

/// An axis that might be a joint's.
#[derive(Serialize, JsonSchema)]
pub(crate) struct CandidateAnswer {
    /// Unit direction, object frame.
    axis: [f64; 3],
    /// A point on it, object frame, the mesh's unit.
    pivot: [f64; 3],
    /// How likely it is, 0 to 1.
    score: f64,
}

pub(super) async fn state(State(room): State<Room>) -> Json<StateAnswer> {
    let (condition, text, path, has_comments, frame) = {
        let paper = locked(&room.paper);
        let frame = paper.condition().map_or(room.setup.desk.mesh().frame(), |c| c.frame);
        let told = answer(&paper, &room.setup.desk);
        (told, paper.text().to_owned(), paper.shown(), paper.has_comments(), frame)
    };
    let (built, building) = locked(&room.building).told();
    let why_not = room.setup.house.why_not();
    Json(StateAnswer {
        version: room.setup.version.clone(),
        title: room.setup.title.clone(),
        condition,
        text,
        path,
        has_comments,
        photo: room.setup.photo.is_some(),
        can_build: why_not.is_none(),
        why_not,
        can_draft: room.setup.house.can_draft(),
        mesh: mesh_answer(&room),
        to_file: to_file(frame),
        out: room.setup.out.clone(),
        built,
        building,
    })
}

fn mesh_answer(room: &Room) -> MeshAnswer {
    let mesh = room.setup.desk.mesh();
    let bounds = mesh.bounds();
    let (faces, shown_faces) = (mesh.faces().len(), room.screen.shown);
    let mut notes = Vec::new();
    if shown_faces < faces {
        notes.push(format!(
            "of the mesh's {faces} faces {shown_faces} are drawn; labels and the asset are of all"
        ));
    }
    MeshAnswer {
        name: room.setup.mesh_name.clone(),
        digest: mesh.digest(),
        vertices: mesh.vertices().len(),
        faces,
        shown_faces,
        low: bounds.min.to_array(),
        high: bounds.max.to_array(),
        notes,
    }
}

fn to_file(frame: FileFrame) -> [[f64; 3]; 3] {
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|v| frame.point_to_file(v));
    [[x.x, y.x, z.x], [x.y, y.y, z.y], [x.z, y.z, z.z]]
}

fn answer(paper: &Paper, desk: &Desk) -> ConditionAnswer {
    let condition = paper.condition();
    let fits = |c: &Condition| c.check_points(desk.mesh());
    let wrong = condition.as_ref().map_or_else(|e| Some(e.clone()), |c| fits(c).err());
    ConditionAnswer {
        revision: paper.revision().to_owned(),
        document: paper.document(),
        faults: wrong.as_ref().map(faults).unwrap_or_default(),
        scale: condition.as_ref().map_or(1.0, |c| desk.scale(c)),
    }
}

pub(super) async fn mesh(State(room): State<Room>) -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "application/octet-stream")], Body::from(room.screen.bytes.clone()))
}

pub(super) async fn photo(State(room): State<Room>) -> Result<Response, Refusal> {
    let Some(photo) = &room.setup.photo else {
        return Err(Refusal::new(StatusCode::NOT_FOUND, "there is no photo"));
    };
    let kind = [(header::CONTENT_TYPE, photo.media_type.clone())];
    Ok((kind, photo.bytes.clone()).into_response())
}

/// The condition file as it lies on disk.
pub(super) async fn condition(State(room): State<Room>) -> impl IntoResponse {
    let text = locked(&room.paper).text().to_owned();
    ([(header::CONTENT_TYPE, "application/json")], text)
}

pub(super) async fn write(
    State(room): State<Room>,
    Asked(body): Asked<WriteBody>,
) -> Result<Json<ConditionAnswer>, Refusal> {
    apart(move || {
        let mut paper = locked(&room.paper);
        match paper.write(&body.text, &body.base) {
            Ok(()) => Ok(Json(answer(&paper, &room.setup.desk))),
            Err(error @ PaperError::Changed(_)) => Err(Refusal::from(error)
                .hint("take what stands there now, or write yours over it")
                .with("revision", json!(paper.revision()))
                .with("text", json!(paper.text()))
                .with("has_comments", json!(paper.has_comments()))
                .with("document", paper.document())),
            Err(error) => Err(error.into()),
        }
    })
    .await?
}

/// The condition of a revision, if that still is what stands in the file.
fn asked(room: &Room, revision: &str) -> Result<Condition, Refusal> {
    let paper = locked(&room.paper);
    if paper.revision() != revision {
        return Err(Refusal::superseded());
    }
    Ok(paper.condition()?)
}

pub(super) async fn labels(
    State(room): State<Room>,
    Asked(body): Asked<AskBody>,
) -> Result<Json<LabelsAnswer>, Refusal> {
    let number = room.labels.number();
    let work = move || {
        let condition = asked(&room, &body.revision)?;
        let labels = timed(&room.labels, number, || room.setup.desk.labels(&condition))?;
        Ok(Json(told(&room, (&body.revision, &condition), labels)))
    };
    apart(work).await?
}

pub(super) async fn articulate(
    State(room): State<Room>,
    Asked(body): Asked<AskBody>,
) -> Result<Json<LabelsAnswer>, Refusal> {
    let number = room.joints.number();
    let work = move || {
        let condition = asked(&room, &body.revision)?;
        let (made, took) = timed(&room.joints, number, || room.setup.desk.articulate(&condition))?;
        let Articulated { labels, found, question } = made;
        let mut answer = told(&room, (&body.revision, &condition), (labels, took));
        let scale = room.setup.desk.scale(&condition);
        answer.joints = Some(found.iter().map(|f| joint(f, &condition, scale)).collect());
        answer.question = question;
        Ok(Json(answer))
    };
    apart(work).await?
}

/// Does what is asked when it is its turn, with the milliseconds it took.
fn timed<T>(
    turn: &Turn,
    number: u64,
    work: impl FnOnce() -> Result<T, crate::DeskError>,
) -> Result<(T, u64), Refusal> {
    let timed = || {
        let begun = std::time::Instant::now();
        work().map(|done| (done, begun.elapsed().as_millis() as u64))
    };
    Ok(turn.take(number, timed).ok_or_else(Refusal::superseded)??)
}

pub(super) async fn free_range(
    State(room): State<Room>,
    Asked(body): Asked<RangeBody>,
) -> Result<Json<RangeAnswer>, Refusal> {
    let [axis, pivot] = [body.axis, body.pivot].map(DVec3::from_array);
    let Some(axis) = axis.try_normalize().filter(|_| pivot.is_finite()) else {
        let what = "expected an axis and a pivot of three finite numbers, the axis not zero";
        return Err(Refusal::new(StatusCode::BAD_REQUEST, what));
    };
    let bounds = room.setup.desk.mesh().bounds();
    let off = pivot.distance(pivot.clamp(bounds.min, bounds.max)) / bounds.diagonal();
    if off > FAR {
        let what = format!(
            "expected a pivot at most {FAR} of the object's diagonals off it, found one {off:.1} off"
        );
        return Err(Refusal::new(StatusCode::BAD_REQUEST, what));
    }
    let number = room.ranges.number();
    let work = move || {
        let condition = asked(&room, &body.revision)?;
        let of = (body.part.as_str(), body.index);
        let found = || room.setup.desk.free_range(&condition, of, (axis, pivot));
        let (range, _) = timed(&room.ranges, number, found)?;
        let slides = kind_of(&condition, &body.part, body.index) == Some(JointKind::Prismatic);
        let scale = if slides { room.setup.desk.scale(&condition) } else { 1.0 };
        Ok(Json(RangeAnswer { range: ends(range, scale).unwrap_or_default() }))
    };
    apart(work).await?
}

fn kind_of(condition: &Condition, part: &str, index: usize) -> Option<JointKind> {
    let part = condition.tree.parts().iter().find(|p| p.name == part)?;
    part.joints.get(index).copied()
}

fn told(
    room: &Arc<Inner>,
    (revision, condition): (&str, &Condition),
    (labels, took_ms): (Labels, u64),
) -> LabelsAnswer {
    let parts: Vec<String> = condition.tree.parts().iter().map(|p| p.name.clone()).collect();
    let width = if parts.len() > 256 { 2 } else { 1 };
    let shown = room.screen.shown(&labels.part_of_face);
    let bytes: Vec<u8> =
        shown.iter().flat_map(|p| p.to_le_bytes().into_iter().take(width)).collect();
    let sure = room.screen.shown(&labels.confidence);
    let sure: Vec<u8> = sure.iter().map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8).collect();
    let note =
        |n: &Note| NoteAnswer { part: n.part.clone(), message: n.message.clone(), loss: n.loss };
    LabelsAnswer {
        revision: revision.to_owned(),
        parts,
        width,
        faces: STANDARD.encode(bytes),
        confidence: STANDARD.encode(sure),
        notes: labels.notes.iter().map(note).collect(),
        took_ms,
        joints: None,
        question: None,
    }
}

fn joint(found: &Found, condition: &Condition, scale: f64) -> JointAnswer {
    let motion = &found.motion;
    let part = condition.tree.parts().get(found.part);
    let scale = if motion.kind.turns() { 1.0 } else { scale };
    let candidate = |&(axis, pivot, score): &(DVec3, DVec3, f64)| CandidateAnswer {
        axis: axis.to_array(),
        pivot: pivot.to_array(),
        score,
    };
    JointAnswer {
        part: part.map(|p| p.name.clone()).unwrap_or_default(),
        index: found.index,
        kind: match motion.kind {
            JointKind::Revolute => "revolute",
            JointKind::Continuous => "continuous",
            JointKind::Prismatic => "prismatic",
        },
        axis: motion.axis.to_array(),
        pivot: motion.pivot.to_array(),
        range: ends(motion.range, scale),
        candidates: found.candidates.iter().map(candidate).collect(),
    }
}

fn ends(range: Range, scale: f64) -> Option<[f64; 2]> {
    match range {
        Range::Limits { lower, upper } => Some([lower * scale, upper * scale]),
        Range::Continuous => None,
    }
}
