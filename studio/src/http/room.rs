//! All that answers need, and whose turn it is.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::broadcast;

use super::answers::Refusal;
use super::building::Building;
use super::token::Token;
use super::told::Event;
use crate::Picture;
use crate::desk::Desk;
use crate::house::House;
use crate::paper::Paper;
use crate::screen::Screen;

/// What the studio is about.
pub struct Setup {
    /// What the object is called.
    pub title: String,
    /// The version of the program.
    pub version: String,
    /// The page, as HTML.
    pub page: String,
    /// The mesh's file, as it may be printed.
    pub mesh_name: String,
    /// The mesh.
    pub desk: Desk,
    /// The photo.
    pub photo: Option<Picture>,
    /// The condition file.
    pub paper: Paper,
    /// Where an asset goes, as it may be printed.
    pub out: String,
    /// Who builds.
    pub house: Arc<dyn House>,
}

/// All that answers need.
pub(super) struct Inner {
    pub(super) setup: Setup,
    pub(super) paper: Mutex<Paper>,
    pub(super) screen: Screen,
    pub(super) token: Token,
    pub(super) hosts: Vec<String>,
    pub(super) events: broadcast::Sender<Event>,
    pub(super) tabs: AtomicUsize,
    pub(super) labels: Turn,
    pub(super) joints: Turn,
    pub(super) ranges: Turn,
    pub(super) building: Mutex<Building>,
}

pub(super) type Room = Arc<Inner>;

/// Questions of one kind, one at a time, of which only the newest is worth answering.
#[derive(Default)]
pub(super) struct Turn {
    newest: AtomicU64,
    busy: Mutex<()>,
}

impl Turn {
    /// Does it when it is its turn; nothing where a newer question was asked before that.
    pub(super) fn take<T>(&self, number: u64, work: impl FnOnce() -> T) -> Option<T> {
        let _busy = locked(&self.busy);
        (self.newest.load(Ordering::SeqCst) == number).then(work)
    }

    /// Asks.
    pub(super) fn number(&self) -> u64 {
        self.newest.fetch_add(1, Ordering::SeqCst) + 1
    }
}

/// What a thread that panicked left is as good as before: nothing is changed in halves.
pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Does what takes long apart from the threads that answer.
pub(crate) async fn apart<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Refusal> {
    let done = tokio::task::spawn_blocking(work).await;
    done.map_err(|_| Refusal::broken("what was asked for broke off; nothing is changed by it"))
}

impl Inner {
    pub(super) fn tell(&self, event: Event) {
        // Nobody may be listening.
        let _ = self.events.send(event);
    }
}
