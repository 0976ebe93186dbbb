//! Layers read by somebody else: the library that reads them may run for ever or break down on a broken one,
//! and in a process of its own that is the end of nobody else.
//!
//! Whoever starts processes says so once, with [`read_layers_by`]; the process itself gives [`answer`] back.
//! Without it layers are read here, in a thread that is given up after a time.

use std::borrow::Cow;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use super::error::UsdError;
use super::prims::{Bundle, Polygons, Told};
use super::scene::{Scene, Surface};
use super::{stage, walk};

/// Gives a layer's bytes to [`answer`] in another process and returns what it says; else why there is none.
pub type Reader = fn(&[u8]) -> Result<Vec<u8>, String>;

static READER: OnceLock<Reader> = OnceLock::new();

/// From now on layers are read by `reader`; the first that is named stays.
pub fn read_layers_by(reader: Reader) {
    let _ = READER.set(reader);
}

/// How a question begins that is not a layer alone.
const BUNDLE: &[u8] = b"kinfold-usd-bundle\0";

/// What came of a layer.
#[derive(Serialize, Deserialize)]
enum Answer {
    Scene(Scene),
    Told(Told),
    Unreadable(String),
    Unanswered(String),
    Rule { prim: String, rule: String, found: String },
}

/// What stands in a layer of any form, for the process that asked: CBOR, which has all numbers.
pub fn answer(layer: Vec<u8>) -> Vec<u8> {
    let made = match layer.strip_prefix(BUNDLE) {
        Some(bundle) => prims(bundle).map(Answer::Told),
        None => stage::scene(layer).map(Answer::Scene),
    };
    let answer = match made {
        Ok(answer) => answer,
        Err(UsdError::Rule { prim, rule, found }) => {
            Answer::Rule { prim, rule: rule.into_owned(), found }
        }
        Err(UsdError::Unreadable(why)) => Answer::Unreadable(why),
        Err(UsdError::Unanswered(why)) => Answer::Unanswered(why),
        Err(UsdError::Mesh(why)) => Answer::Unreadable(why.to_string()),
    };
    let mut bytes = Vec::new();
    match ciborium::into_writer(&answer, &mut bytes) {
        Ok(()) => bytes,
        // Nothing in it cannot be written; what is empty is no answer.
        Err(_) => Vec::new(),
    }
}

fn prims(bundle: &[u8]) -> Result<Told, UsdError> {
    let size = bundle.len();
    let bundle: Bundle = ciborium::from_reader(bundle)
        .map_err(|_| UsdError::Unreadable("what was asked of it is not whole".into()))?;
    stage::within_time(size, move || walk::told(bundle))
}

/// What stands in the stage of a bundle, or which files it lacks.
///
/// # Errors
/// [`UsdError`], the first broken rule.
pub(super) fn told(bundle: &Bundle) -> Result<Told, UsdError> {
    let mut question = BUNDLE.to_vec();
    let odd = |_| UsdError::Unreadable("its files cannot be handed over".into());
    ciborium::into_writer(bundle, &mut question).map_err(odd)?;
    let answer = match READER.get() {
        Some(reader) => reader(&question).map_err(UsdError::Unanswered)?,
        None => answer(question),
    };
    match ciborium::from_reader(&answer[..]) {
        Ok(Answer::Told(told)) if is_told_whole(&told) => Ok(told),
        Ok(Answer::Unreadable(why)) => Err(UsdError::Unreadable(why)),
        Ok(Answer::Unanswered(why)) => Err(UsdError::Unanswered(why)),
        Ok(Answer::Rule { prim, rule, found }) => {
            Err(UsdError::Rule { prim, rule: Cow::Owned(rule), found })
        }
        Ok(_) | Err(_) => Err(UsdError::Unreadable("what was read of it is not whole".into())),
    }
}

/// Whether every index leads somewhere: to a prim before, to a point.
fn is_told_whole(told: &Told) -> bool {
    let Told::Stage(stage) = told else { return true };
    stage.prims.iter().enumerate().all(|(index, prim)| {
        let is_sound = |surface: &Polygons| {
            surface.faces.iter().flatten().all(|p| (*p as usize) < surface.points.len())
        };
        prim.above.is_none_or(|above| above < index) && prim.surface.as_ref().is_none_or(is_sound)
    })
}

/// What stands in a layer.
pub(super) fn scene(layer: Vec<u8>) -> Result<Scene, UsdError> {
    let Some(reader) = READER.get() else { return stage::scene(layer) };
    taken(&reader(&layer).map_err(UsdError::Unanswered)?)
}

/// What an answer says, if it can be.
pub(super) fn taken(answer: &[u8]) -> Result<Scene, UsdError> {
    match ciborium::from_reader(answer) {
        Ok(Answer::Scene(scene)) if is_whole(&scene) => Ok(scene),
        Ok(Answer::Unreadable(why)) => Err(UsdError::Unreadable(why)),
        Ok(Answer::Unanswered(why)) => Err(UsdError::Unanswered(why)),
        Ok(Answer::Rule { prim, rule, found }) => {
            Err(UsdError::Rule { prim, rule: Cow::Owned(rule), found })
        }
        Ok(Answer::Scene(_) | Answer::Told(_)) | Err(_) => {
            Err(UsdError::Unreadable("what was read of it is not whole".into()))
        }
    }
}

/// Whether every index leads somewhere.
fn is_whole(scene: &Scene) -> bool {
    let is_look = |index: &usize| *index < scene.looks.len();
    scene.surfaces.iter().all(|Surface { points, polygons, bound, .. }| {
        // Each corner is its point and its own number.
        let named = polygons.iter().flat_map(|corners| corners.iter().step_by(2));
        named.into_iter().all(|point| (*point as usize) < points.len())
            && bound.whole.iter().chain(bound.of_face.iter().flatten()).all(is_look)
    })
}
