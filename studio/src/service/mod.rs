//! A service: jobs come in over the network, are made by the house, and are told of.
//!
//! It is served on the loopback interface alone; whoever is elsewhere comes through something that speaks TLS.
//! A request names no program, no path, no address and no key: files are named by their digests.

mod body;
mod described;
mod files;
mod follow;
mod gate;
mod jobs;
mod patient;
mod rates;
mod room;

use std::net::TcpListener;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::http::{StatusCode, header};
use axum::middleware::from_fn_with_state;
use axum::response::IntoResponse;
use axum::routing::{MethodRouter, get, post};

use self::patient::Patience;
use self::room::{Desk, LISTED, desk};
use crate::http::Stop;
use crate::http::answers::Refusal;

pub use self::described::described as openapi;
pub use self::room::{Bell, Limits, Service};

/// Serves until `stop`, on a listener of the loopback interface.
///
/// # Errors
/// What the operating system says where it cannot serve.
pub fn serve(listener: TcpListener, service: Service, stop: &Stop) -> std::io::Result<()> {
    let address = listener.local_addr()?;
    if !address.ip().is_loopback() {
        return Err(std::io::Error::other(format!("{address} is not of this machine alone")));
    }
    listener.set_nonblocking(true)?;
    let limits = service.limits;
    let desk = desk(service);
    let runtime =
        tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()?;
    let ended = runtime.block_on(async {
        let listener = tokio::net::TcpListener::from_std(listener)?;
        let listener = Patience::new(listener, limits.connections, 3 * limits.patience);
        tokio::select! {
            ended = axum::serve(listener, router(desk)) => ended,
            () = stop.wished() => Ok(()),
        }
    });
    runtime.shutdown_timeout(Duration::from_secs(5));
    ended
}

/// What can be asked, by path: the same list as in [`openapi`].
fn routes() -> Vec<(&'static str, MethodRouter<Desk>)> {
    vec![
        ("/v1/about", get(jobs::about)),
        ("/v1/files", post(files::upload)),
        ("/v1/jobs", get(jobs::list).post(jobs::submit)),
        ("/v1/jobs/{id}", get(jobs::one)),
        ("/v1/jobs/{id}/events", get(follow::events)),
        ("/v1/jobs/{id}/artefacts/{digest}", get(files::artefact)),
        ("/v1/openapi.json", get(document)),
    ]
}

fn router(desk: Desk) -> Router {
    let router =
        routes().into_iter().fold(Router::new(), |all, (path, answer)| all.route(path, answer));
    router
        .fallback(|| async {
            Refusal::new(StatusCode::NOT_FOUND, "nothing is asked for like that").hint(LISTED)
        })
        .method_not_allowed_fallback(|| async {
            Refusal::new(StatusCode::METHOD_NOT_ALLOWED, "it is not asked for in this way")
                .hint(LISTED)
        })
        .layer(from_fn_with_state(Arc::clone(&desk), gate::guarded))
        .with_state(desk)
}

async fn document() -> impl IntoResponse {
    let text = format!("{:#}\n", openapi());
    ([(header::CONTENT_TYPE, "application/json")], text)
}

#[cfg(test)]
mod tests;
