//! Layers read by somebody else: the library that reads them may run for ever or break down on a broken one,
//! and in a process of its own that is the end of nobody else.
//!
//! Whoever starts processes says so once, with [`read_layers_by`]; the process itself gives [`answer`] back.
//! Without it layers are read here, in a thread that is given up after a time.

use std::borrow::Cow;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use super::error::UsdError;
use super::scene::{Scene, Surface};
use super::stage;

/// Gives a layer's bytes to [`answer`] in another process and returns what it says; else why there is none.
pub type Reader = fn(&[u8]) -> Result<Vec<u8>, String>;

static READER: OnceLock<Reader> = OnceLock::new();

/// From now on layers are read by `reader`; the first that is named stays.
pub fn read_layers_by(reader: Reader) {
    let _ = READER.set(reader);
}

/// What came of a layer.
#[derive(Serialize, Deserialize)]
enum Answer {
    Scene(Scene),
    Unreadable(String),
    Rule { prim: String, rule: String, found: String },
}

/// What stands in a layer of any form, for the process that asked: CBOR, which has all numbers.
pub fn answer(layer: Vec<u8>) -> Vec<u8> {
    let answer = match stage::scene(layer) {
        Ok(scene) => Answer::Scene(scene),
        Err(UsdError::Rule { prim, rule, found }) => {
            Answer::Rule { prim, rule: rule.into_owned(), found }
        }
        Err(UsdError::Unreadable(why)) => Answer::Unreadable(why),
        Err(UsdError::Mesh(why)) => Answer::Unreadable(why.to_string()),
    };
    let mut bytes = Vec::new();
    match ciborium::into_writer(&answer, &mut bytes) {
        Ok(()) => bytes,
        // Nothing in it cannot be written; what is empty is no answer.
        Err(_) => Vec::new(),
    }
}

/// What stands in a layer.
pub(super) fn scene(layer: Vec<u8>) -> Result<Scene, UsdError> {
    let Some(reader) = READER.get() else { return stage::scene(layer) };
    taken(&reader(&layer).map_err(UsdError::Unreadable)?)
}

/// What an answer says, if it can be.
pub(super) fn taken(answer: &[u8]) -> Result<Scene, UsdError> {
    match ciborium::from_reader(answer) {
        Ok(Answer::Scene(scene)) if is_whole(&scene) => Ok(scene),
        Ok(Answer::Unreadable(why)) => Err(UsdError::Unreadable(why)),
        Ok(Answer::Rule { prim, rule, found }) => {
            Err(UsdError::Rule { prim, rule: Cow::Owned(rule), found })
        }
        Ok(Answer::Scene(_)) | Err(_) => {
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
