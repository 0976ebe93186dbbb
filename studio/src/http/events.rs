//! What a page is told without asking: server-sent events.

use std::convert::Infallible;
use std::pin::Pin;
use std::sync::atomic::Ordering;
use std::task::{Context, Poll};
use std::time::Duration;

use axum::extract::State;
use axum::response::sse::{self, KeepAlive, KeepAliveStream, Sse};
use futures_core::Stream;
use schemars::JsonSchema;
use serde::Serialize;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::{broadcast, mpsc};

use super::Room;
use crate::house::StageState;

/// Something that happened; its name is the event's.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[serde(untagged)]
pub(crate) enum Event {
    /// `stage`: a stage of a build.
    Stage {
        /// The build's number.
        build: u64,
        /// The stage.
        stage: String,
        /// What became of it.
        state: StageState,
        /// How many stages are done.
        done: usize,
        /// How many there are.
        of: usize,
    },
    /// `built`: a build ended.
    Built {
        /// The build's number.
        build: u64,
        /// As the command line's exit code.
        exit: u8,
        /// The tier it reaches.
        tier: Option<String>,
        /// How it went, in a line.
        message: String,
        /// Where it stands.
        out: String,
    },
    /// `condition`: somebody else changed the condition file.
    Condition {
        /// What stands there now.
        revision: String,
    },
    /// `tabs`: so many pages are open.
    Tabs {
        /// Their number.
        count: usize,
    },
    /// `lost`: the page fell behind, and should ask for the state.
    Lost {
        /// What was lost.
        what: String,
    },
}

impl Event {
    fn name(&self) -> &'static str {
        match self {
            Self::Stage { .. } => "stage",
            Self::Built { .. } => "built",
            Self::Condition { .. } => "condition",
            Self::Tabs { .. } => "tabs",
            Self::Lost { .. } => "lost",
        }
    }
}

/// A page that listens.
pub(super) struct Listening {
    incoming: mpsc::Receiver<sse::Event>,
    _here: Here,
}

/// One open page; its going is told.
struct Here(Room);

impl Here {
    fn new(room: Room) -> Self {
        let count = room.tabs.fetch_add(1, Ordering::SeqCst) + 1;
        room.tell(Event::Tabs { count });
        Self(room)
    }
}

impl Drop for Here {
    fn drop(&mut self) {
        let count = self.0.tabs.fetch_sub(1, Ordering::SeqCst).saturating_sub(1);
        self.0.tell(Event::Tabs { count });
    }
}

impl Stream for Listening {
    type Item = Result<sse::Event, Infallible>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        self.incoming.poll_recv(context).map(|event| event.map(Ok))
    }
}

/// Tells a page what happens from now on.
pub(super) async fn stream(State(room): State<Room>) -> Sse<KeepAliveStream<Listening>> {
    let (sender, incoming) = mpsc::channel(16);
    let events = room.events.subscribe();
    let here = Here::new(room);
    tokio::spawn(passed_on(events, sender));
    let keep = KeepAlive::new().interval(Duration::from_secs(10));
    Sse::new(Listening { incoming, _here: here }).keep_alive(keep)
}

async fn passed_on(mut events: broadcast::Receiver<Event>, sender: mpsc::Sender<sse::Event>) {
    loop {
        let event = tokio::select! {
            event = events.recv() => event,
            () = sender.closed() => return,
        };
        let event = match event {
            Ok(event) => event,
            Err(RecvError::Lagged(count)) => Event::Lost { what: format!("{count} events") },
            Err(RecvError::Closed) => return,
        };
        let Ok(told) = sse::Event::default().event(event.name()).json_data(&event) else {
            continue;
        };
        if sender.send(told).await.is_err() {
            return;
        }
    }
}
