//! Callables of Python that are asked for meshes and conditions, as any other provider is.
//!
//! Each question goes to the thread that waits for the asset, which starts the callable on a thread of
//! Python's and goes on waiting. So a callable that hangs or raises costs its answer and nothing else.

use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use adapters::{
    AdapterError, GeneratedMesh, ImageTo3d, KinematicQuestion, MeshFile, Photo, RenderedView, Vlm,
};
use object::mesh::UpAxis;
use object::{Condition, Origin};
use pyo3::prelude::*;

/// What is asked of a callable.
pub(crate) enum Question {
    /// A mesh of this picture, PNG, with this seed.
    Mesh(Vec<u8>, u64),
    /// The parts of what this picture and these views show.
    Condition(Vec<u8>, Vec<RenderedView>),
}

/// A question on its way, with where its answer goes.
pub(crate) struct Asked {
    /// The question.
    pub(crate) question: Question,
    /// Who answers.
    pub(crate) reply: Reply,
}

/// Takes one answer: a mesh file's path, or a condition as text; or why there is none.
#[pyclass(frozen, module = "kinfold._kinfold")]
pub(crate) struct Reply(Mutex<Option<Sender<Result<String, String>>>>);

#[pymethods]
impl Reply {
    /// Gives the answer. Only the first counts.
    fn answer(&self, answer: String) {
        self.send(Ok(answer));
    }

    /// Says why there is none. Only the first word counts.
    fn refuse(&self, why: String) {
        self.send(Err(why));
    }
}

impl Reply {
    fn send(&self, answer: Result<String, String>) {
        let sender = self.0.lock().unwrap_or_else(|e| e.into_inner()).take();
        // The run may have been given up meanwhile.
        sender.map(|sender| sender.send(answer).ok());
    }
}

/// Whoever takes questions for a callable.
pub(crate) struct Callable {
    /// What it is called, with its version: part of the stage key.
    pub(crate) identity: String,
    /// How long it may take.
    pub(crate) deadline: Duration,
    /// Passes a question on; false where nobody takes it any more.
    pub(crate) pass_on: Box<dyn Fn(Asked) -> bool + Send + Sync>,
}

impl Callable {
    fn ask(&self, question: Question) -> Result<String, AdapterError> {
        let (sender, receiver): (_, Receiver<Result<String, String>>) = channel();
        let reply = Reply(Mutex::new(Some(sender)));
        if !(self.pass_on)(Asked { question, reply }) {
            return Err(self.failed("was not asked: nobody waits for the asset any more"));
        }
        match receiver.recv_timeout(self.deadline) {
            Ok(answer) => answer.map_err(|why| self.failed(&why)),
            Err(RecvTimeoutError::Timeout) => {
                let seconds = self.deadline.as_secs_f64();
                Err(self.failed(&format!("gave no answer in {seconds} s")))
            }
            Err(RecvTimeoutError::Disconnected) => Err(self.failed("ended without an answer")),
        }
    }

    fn failed(&self, found: &str) -> AdapterError {
        AdapterError::Program { program: self.identity.clone(), found: found.into() }
    }
}

impl ImageTo3d for Callable {
    fn identity(&self) -> Result<String, AdapterError> {
        Ok(self.identity.clone())
    }

    fn generate(&self, photo: &Photo, seed: u64) -> Result<GeneratedMesh, AdapterError> {
        let picture = adapters::sent::sent(photo)?.bytes;
        let path = PathBuf::from(self.ask(Question::Mesh(picture, seed))?);
        MeshFile { path, up: UpAxis::Y }.read()
    }
}

impl Vlm for Callable {
    fn identity(&self) -> Result<String, AdapterError> {
        Ok(self.identity.clone())
    }

    fn propose(&self, question: &KinematicQuestion<'_>) -> Result<Condition, AdapterError> {
        let picture = adapters::sent::sent(question.photo)?.bytes;
        let text = self.ask(Question::Condition(picture, question.views.to_vec()))?;
        let wrong = |source| AdapterError::Condition { path: self.identity.clone(), source };
        let condition = Condition::from_json(&text).map_err(wrong)?;
        condition.check_points(question.mesh).map_err(wrong)?;
        Ok(Condition { origin: Origin::Vlm, ..condition })
    }
}
