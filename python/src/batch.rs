//! A batch that runs while Python goes through its results, one by one.

use std::ffi::OsString;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use runner::observe::What;
use runner::{Cancel, Event};
use serde_json::json;
use workflow::batch::Record;
use workflow::batch::item::Onlooker;
use workflow::cli::asked;

use crate::ask::{Told, told};
use crate::errors::Wrong;
use crate::threads::{GLANCE, begin};

/// How long a batch that was told to stop is waited for: as a run.
const GRACE: Duration = Duration::from_secs(3);

/// What the thread that makes assets says.
enum Message {
    /// Something of an item, as JSON.
    Item(String),
    /// How it ended.
    Ended(Result<Told, Wrong>),
}

/// Passes on what becomes of items.
struct Telling(Mutex<Sender<Message>>);

impl Telling {
    fn tell(&self, what: serde_json::Value) {
        let sender = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // Who asked may have left; then the batch is stopped, too.
        drop(sender.send(Message::Item(what.to_string())));
    }
}

impl Onlooker for Telling {
    fn stage(&self, id: &str, event: &Event) {
        let is_input = event.identity.is_none() && event.inputs.is_empty();
        if let (false, What::Started) = (is_input, &event.what) {
            self.tell(json!({ "item": id, "stage": event.stage }));
        }
    }

    fn settled(&self, record: &Record) {
        self.tell(json!({ "item": record.id, "record": record }));
    }
}

/// A batch that runs. It is stopped when nobody holds it any more.
#[pyclass(frozen, module = "kinfold._kinfold")]
pub(crate) struct Batch {
    receiver: Mutex<Receiver<Message>>,
    cancel: Cancel,
    ended: Mutex<Option<Told>>,
}

#[pymethods]
impl Batch {
    /// Begins a batch; the words are those behind `kinfold batch`.
    #[new]
    fn new(py: Python<'_>, words: Vec<OsString>) -> PyResult<Self> {
        let (sender, receiver) = channel();
        let cancel = Cancel::default();
        let (work, telling) = (cancel.clone(), Arc::new(Telling(Mutex::new(sender.clone()))));
        let begun = begin(
            sender,
            move || {
                let answer = asked::batch(words, telling, work);
                Message::Ended(answer.map(told).map_err(Wrong::from))
            },
            |wrong| Message::Ended(Err(wrong)),
        );
        begun.map_err(|wrong| wrong.raised(py))?;
        Ok(Self { receiver: Mutex::new(receiver), cancel, ended: Mutex::new(None) })
    }

    /// The next news, as JSON: `item` and its `stage`, or its `record`; none when the batch is over.
    fn next(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let mut stopped: Option<(PyErr, Instant)> = None;
        loop {
            let heard = py.detach(|| {
                self.receiver.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(GLANCE)
            });
            match (heard, &stopped) {
                (Ok(Message::Ended(_)), Some((why, _))) => return Err(why.clone_ref(py)),
                (Ok(Message::Ended(ended)), None) => {
                    let ended = ended.map_err(|wrong| wrong.raised(py))?;
                    *self.ended.lock().unwrap_or_else(PoisonError::into_inner) = Some(ended);
                    return Ok(None);
                }
                (Ok(Message::Item(item)), None) => return Ok(Some(item)),
                (Err(RecvTimeoutError::Disconnected), _) => return Ok(None),
                _ => {}
            }
            match (py.check_signals(), &stopped) {
                (Err(why), None) => {
                    self.stop();
                    stopped = Some((why, Instant::now()));
                }
                (_, Some((why, since))) if since.elapsed() > GRACE => return Err(why.clone_ref(py)),
                _ => {}
            }
        }
    }

    /// How it ended; none before.
    fn answer(&self) -> Option<Told> {
        self.ended.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Stops it at once: what is finished is kept, and what runs is done again.
    fn stop(&self) {
        self.cancel.press();
        self.cancel.press();
    }
}

impl Drop for Batch {
    fn drop(&mut self) {
        self.stop();
    }
}
