//! Building, and what was built.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use axum::Json;
use axum::extract::{Path, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use object::condition::plain;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::answers::{Asked, Refusal};
use super::building::{BuildAnswer, BuiltAnswer};
use super::room::{Inner, Room, apart, locked};
use super::told::Event;
use crate::house::{Artefact, Built, Failure, Order, Outcome, StageState};

/// What is to be built.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BuildBody {
    /// The revision of the condition that is to be built.
    revision: String,
    /// Formats besides URDF: `mjcf`, `usd`, `glb`.
    #[serde(default)]
    export: Vec<String>,
}

/// What is to be checked.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CheckBody {
    /// A URDF or MJCF file of this machine.
    path: String,
}

/// The files of an asset.
#[derive(Serialize, JsonSchema)]
pub(crate) struct ArtefactsAnswer {
    /// Where it stands.
    out: String,
    /// Its files.
    files: Vec<Artefact>,
}

/// A condition that somebody drafted.
#[derive(Serialize, JsonSchema)]
pub(crate) struct DraftAnswer {
    /// The text of a condition file.
    text: String,
    /// What it says, as JSON.
    document: Value,
}

pub(super) async fn build(
    State(room): State<Room>,
    Asked(body): Asked<BuildBody>,
) -> Result<(StatusCode, Json<BuildAnswer>), Refusal> {
    let known = ["mjcf", "usd", "glb"];
    if let Some(other) = body.export.iter().find(|format| !known.contains(&format.as_str())) {
        let what = format!("expected formats of {}, found `{other}`", known.join(", "));
        return Err(Refusal::new(StatusCode::BAD_REQUEST, what));
    }
    if let Some(why) = room.setup.house.why_not() {
        return Err(Refusal::new(StatusCode::UNPROCESSABLE_ENTITY, why));
    }
    let (revision, condition) = {
        let mut paper = locked(&room.paper);
        paper.look()?;
        if paper.revision() != body.revision {
            return Err(Refusal::new(StatusCode::CONFLICT, "the condition is another by now"));
        }
        paper.condition()?.check_points(room.setup.desk.mesh())?;
        (body.revision, paper.text().to_owned())
    };
    let (number, stop) = {
        let mut building = locked(&room.building);
        if building.running.is_some() {
            let refusal = Refusal::new(StatusCode::CONFLICT, "an asset is being built already");
            return Err(refusal.hint("wait for it, or stop it with /api/build/cancel"));
        }
        let stop = Arc::new(AtomicBool::new(false));
        building.count += 1;
        building.running = Some(Arc::clone(&stop));
        (building.count, stop)
    };
    let order = Order { condition, export: body.export };
    let here = Arc::clone(&room);
    tokio::spawn(async move {
        let inside = Arc::clone(&here);
        let ended = apart(move || built_by_house(&inside, number, &order, &stop)).await;
        let ended = ended.unwrap_or_else(|_| Err(Failure::new("the build broke off")));
        finished(&here, number, revision, ended);
    });
    Ok((StatusCode::ACCEPTED, Json(BuildAnswer { build: number })))
}

fn built_by_house(
    room: &Inner,
    build: u64,
    order: &Order,
    stop: &AtomicBool,
) -> Result<Outcome, Failure> {
    let (done, of) = (std::sync::atomic::AtomicUsize::new(0), room.setup.house.stages(order));
    let tell = |stage: &'static str, state: StageState| {
        let is_end = state != StageState::Running;
        let done = done.fetch_add(usize::from(is_end), Ordering::SeqCst) + usize::from(is_end);
        room.tell(Event::Stage { build, stage: stage.to_owned(), state, done, of });
    };
    room.setup.house.build(order, &tell, &|| stop.load(Ordering::SeqCst))
}

fn finished(room: &Inner, build: u64, revision: String, ended: Result<Outcome, Failure>) {
    let built = match ended {
        Ok(Outcome { exit, tier, remarks, out }) => {
            BuiltAnswer { revision, exit, tier, message: remarks.join("; "), out }
        }
        Err(Failure { message, hint }) => {
            let message = hint.map_or(message.clone(), |hint| format!("{message}; {hint}"));
            BuiltAnswer { revision, exit: 1, tier: None, message, out: room.setup.out.clone() }
        }
    };
    {
        let mut building = locked(&room.building);
        building.running = None;
        building.last = Some(built.clone());
    }
    let BuiltAnswer { exit, tier, message, out, .. } = built;
    room.tell(Event::Built { build, exit, tier, message, out });
}

pub(super) async fn cancel(State(room): State<Room>) -> Json<Option<BuildAnswer>> {
    let building = locked(&room.building);
    building.stop();
    Json(building.told().1)
}

pub(super) async fn built(State(room): State<Room>) -> Result<Json<Built>, Refusal> {
    let built = apart(move || room.setup.house.built()).await??;
    built.map(Json).ok_or_else(|| {
        Refusal::new(StatusCode::NOT_FOUND, "nothing was built yet").hint("ask /api/build first")
    })
}

pub(super) async fn artefacts(State(room): State<Room>) -> Result<Json<ArtefactsAnswer>, Refusal> {
    let out = room.setup.out.clone();
    let files = apart(move || room.setup.house.artefacts()).await??;
    Ok(Json(ArtefactsAnswer { out, files }))
}

pub(super) async fn artefact(
    State(room): State<Room>,
    Path(name): Path<String>,
) -> Result<Response, Refusal> {
    let asked = name.clone();
    let bytes = apart(move || room.setup.house.artefact(&asked)).await??;
    let Some(bytes) = bytes else {
        return Err(Refusal::new(StatusCode::NOT_FOUND, format!("the asset has no file `{name}`"))
            .hint("/api/artefacts lists its files"));
    };
    // Nothing of an asset is run here, whatever it says it is.
    let kind = [
        (header::CONTENT_TYPE, "application/octet-stream"),
        (header::CONTENT_DISPOSITION, "attachment"),
    ];
    Ok((kind, bytes).into_response())
}

pub(super) async fn check(
    State(room): State<Room>,
    Asked(body): Asked<CheckBody>,
) -> Result<Json<Value>, Refusal> {
    Ok(Json(apart(move || room.setup.house.check(&body.path)).await??))
}

pub(super) async fn draft(State(room): State<Room>) -> Result<Json<DraftAnswer>, Refusal> {
    if !room.setup.house.can_draft() {
        let what = "nobody is configured who could be asked for a condition";
        return Err(Refusal::new(StatusCode::UNPROCESSABLE_ENTITY, what)
            .hint("name a server with --vlm URL --model NAME, or in kinfold.toml"));
    }
    let text = apart(move || room.setup.house.draft()).await??;
    let document = plain(&text)?.document;
    Ok(Json(DraftAnswer { text, document }))
}
