//! One photo to one checked asset: the flow of `kinfold make`, and what of it Python has to hear and do.

use std::ffi::OsString;
use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use runner::observe::What;
use runner::{Cancel, Event, ObserveError, Observer};
use workflow::cli::args::Own;
use workflow::cli::asked::{self, Party};

use crate::ask::{Told, told};
use crate::callables::{Asked, Callable, Question};
use crate::errors::Wrong;
use crate::threads::{begin, next};

/// How long a run that was told to stop is waited for; then it is left to end by itself. A guess: what runs
/// is dropped within a twentieth of a second; a folder that is being written takes longer, and a run that
/// waits for another one hears of it only when its turn comes.
const GRACE: Duration = Duration::from_secs(3);

/// What the thread that makes the asset says.
enum Message {
    /// What became of a stage.
    Stage(&'static str, &'static str),
    /// A question for a callable.
    Asked(Asked),
    /// How it ended.
    Ended(Result<Told, Wrong>),
}

/// Passes on what becomes of stages.
struct Telling(Sender<Message>);

impl Observer for Telling {
    fn notice(&mut self, event: &Event) -> Result<(), ObserveError> {
        let is_input = event.identity.is_none() && event.inputs.is_empty();
        let state = match &event.what {
            What::Started => "running",
            What::Retry { .. } => "again",
            What::Finished { recalled: true, .. } => "kept",
            What::Finished { .. } => "done",
            What::Failed(_) => "failed",
        };
        if !is_input {
            // Who asked may have left; then the run is stopped, too.
            drop(self.0.send(Message::Stage(event.stage, state)));
        }
        Ok(())
    }
}

/// Makes an asset; `words` are those behind `kinfold make`.
///
/// `notice` is told of every stage and how many there are; `ask` starts a callable on a question and gives
/// its answer to a `Reply`. `own` are the identities of callables for meshes and for conditions, and how
/// many seconds each may take.
#[pyfunction]
pub(crate) fn make(
    py: Python<'_>,
    words: Vec<OsString>,
    notice: Py<PyAny>,
    ask: Py<PyAny>,
    own: (Option<String>, Option<String>, f64),
) -> PyResult<Told> {
    let stages = asked::stages(words.clone()).map_err(|c| Wrong::from(c).raised(py))?;
    let (sender, mut receiver) = channel();
    let cancel = Cancel::default();
    let (observer, own) = (Telling(sender.clone()), callables(own, &sender));
    let (work, stop) = (cancel.clone(), || {
        // At once: what is finished is kept, and what runs is done again.
        cancel.press();
        cancel.press();
    });
    let begun = begin(
        sender,
        move || Message::Ended(made(words, observer, work, own)),
        |wrong| Message::Ended(Err(wrong)),
    );
    begun.map_err(|wrong| wrong.raised(py))?;
    let mut stopped: Option<(PyErr, Instant)> = None;
    loop {
        let heard = match next(py, &mut receiver)? {
            Some(Message::Ended(ended)) => {
                return match stopped {
                    Some((why, _)) => Err(why),
                    None => ended.map_err(|wrong| wrong.raised(py)),
                };
            }
            Some(Message::Stage(stage, state)) if stopped.is_none() => {
                notice.call1(py, (stage, state, stages)).map(drop)
            }
            Some(Message::Asked(asked)) if stopped.is_none() => start(py, &ask, asked),
            _ => Ok(()),
        };
        match (&stopped, heard.and_then(|()| py.check_signals())) {
            (None, Err(why)) => {
                stop();
                stopped = Some((why, Instant::now()));
            }
            (Some((why, since)), _) if since.elapsed() > GRACE => return Err(why.clone_ref(py)),
            _ => {}
        }
    }
}

fn made(
    words: Vec<OsString>,
    mut observer: Telling,
    cancel: Cancel,
    own: Own,
) -> Result<Told, Wrong> {
    Ok(told(asked::make(words, Party { observer: &mut observer, cancel, own })?))
}

/// The callables with these identities, whose questions go to whoever waits.
fn callables(
    (mesh, condition, seconds): (Option<String>, Option<String>, f64),
    sender: &Sender<Message>,
) -> Own {
    let deadline = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
    let callable = |identity: String| {
        let sender = sender.clone();
        let pass_on = Box::new(move |asked| sender.send(Message::Asked(asked)).is_ok());
        Arc::new(Callable { identity, deadline, pass_on })
    };
    Own { image_to_3d: mesh.map(|m| callable(m) as _), vlm: condition.map(|c| callable(c) as _) }
}

/// Has a callable started on a question.
fn start(py: Python<'_>, ask: &Py<PyAny>, asked: Asked) -> PyResult<()> {
    let Asked { question, reply } = asked;
    match question {
        Question::Mesh(picture, seed) => {
            ask.call1(py, ("mesh", PyBytes::new(py, &picture), seed, reply))
        }
        Question::Condition(picture, views) => {
            let views: Vec<_> =
                views.iter().map(|v| (v.name.clone(), PyBytes::new(py, &v.png))).collect();
            ask.call1(py, ("condition", PyBytes::new(py, &picture), views, reply))
        }
    }
    .map(drop)
}
