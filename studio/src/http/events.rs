//! What a page is told without asking: server-sent events.

use std::convert::Infallible;
use std::pin::Pin;
use std::sync::atomic::Ordering;
use std::task::{Context, Poll};
use std::time::Duration;

use axum::extract::State;
use axum::response::sse::{self, KeepAlive, KeepAliveStream, Sse};
use futures_core::Stream;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::{broadcast, mpsc};

use super::room::Room;
use super::told::Event;

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
