//! How a job goes, told without asking: server-sent events.

use std::convert::Infallible;
use std::pin::Pin;
use std::task::{Context, Poll};

use axum::Extension;
use axum::extract::{Path, State};
use axum::response::sse::{self, KeepAlive, KeepAliveStream, Sse};
use futures_core::Stream;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::{broadcast, mpsc};

use super::gate::Who;
use super::jobs;
use super::room::Desk;
use crate::http::answers::Refusal;
use crate::works::Job;

/// Whoever listens.
pub(super) struct Listening(mpsc::Receiver<sse::Event>);

impl Stream for Listening {
    type Item = Result<sse::Event, Infallible>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        self.0.poll_recv(context).map(|event| event.map(Ok))
    }
}

/// Tells how a job stands, whenever that changes, until it is over. The first word is how it stands now, so
/// whoever comes back has missed nothing.
pub(super) async fn events(
    State(desk): State<Desk>,
    Extension(Who(who)): Extension<Who>,
    Path(id): Path<String>,
) -> Result<Sse<KeepAliveStream<Listening>>, Refusal> {
    let news = desk.bell.0.subscribe();
    let job = jobs::found(&desk, who.clone(), id.clone()).await?;
    let (sender, incoming) = mpsc::channel(16);
    let patience = desk.limits.patience;
    tokio::spawn(passed_on(desk, (who, id), (job, news), sender));
    let keep = KeepAlive::new().interval(patience);
    Ok(Sse::new(Listening(incoming)).keep_alive(keep))
}

async fn passed_on(
    desk: Desk,
    (who, id): (String, String),
    (mut job, mut news): (Job, broadcast::Receiver<(String, String)>),
    sender: mpsc::Sender<sse::Event>,
) {
    loop {
        let Ok(told) = sse::Event::default().event("job").json_data(&job) else { return };
        if sender.send(told).await.is_err() || job.state.is_over() {
            return;
        }
        let before = job;
        job = loop {
            let heard = tokio::select! {
                heard = news.recv() => heard,
                () = sender.closed() => return,
            };
            match heard {
                Ok((whose, which)) if whose != who || which != id => continue,
                Err(RecvError::Closed) => return,
                Ok(_) | Err(RecvError::Lagged(_)) => {}
            }
            match jobs::found(&desk, who.clone(), id.clone()).await {
                Ok(job) if job != before => break job,
                Ok(_) => {}
                Err(_) => return,
            }
        };
    }
}
