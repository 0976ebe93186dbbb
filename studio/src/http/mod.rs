//! The server: who may ask, what is asked, what goes out by itself.

pub(crate) mod answers;
pub(crate) mod building;
pub(crate) mod edit;
mod events;
pub(crate) mod guard;
pub(crate) mod room;
mod token;
pub(crate) mod told;
pub(crate) mod work;

use std::net::{SocketAddr, TcpListener};
use std::sync::atomic::AtomicUsize;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use axum::Router;
use axum::extract::{DefaultBodyLimit, State};
use axum::http::{StatusCode, header};
use axum::middleware::from_fn_with_state;
use axum::response::{Html, IntoResponse};
use axum::routing::{MethodRouter, get, post};
use tokio::sync::{Notify, broadcast};

use self::answers::Refusal;

use self::building::Building;
use self::told::Event;

pub use self::room::Setup;
use self::room::{Inner, Room, Turn, apart, locked};
pub use self::token::Token;

use crate::screen::Screen;

/// How often the condition file is looked at.
const LOOK: Duration = Duration::from_millis(700);
/// Most bytes of a question: a condition file and its wrapping.
const MOST: usize = 4 << 20;
/// The port of the web.
const WEB: u16 = 80;
/// Events that a page may fall behind.
const BEHIND: usize = 256;

/// Ends a server from another thread.
#[derive(Clone, Default)]
pub struct Stop(Arc<Notify>);

impl Stop {
    /// Ends it, and stops what it builds.
    pub fn stop(&self) {
        self.0.notify_one();
    }

    /// Waits until somebody ends it.
    pub(crate) async fn wished(&self) {
        self.0.notified().await;
    }
}

/// Serves until `stop`, on a listener of the loopback interface.
///
/// # Errors
/// What the operating system says where it cannot serve.
pub fn serve(
    listener: TcpListener,
    token: Token,
    setup: Setup,
    stop: &Stop,
) -> std::io::Result<()> {
    let address = listener.local_addr()?;
    if !address.ip().is_loopback() {
        return Err(std::io::Error::other(format!("{address} is not of this machine alone")));
    }
    listener.set_nonblocking(true)?;
    let room = room(setup, token, address);
    let early = Arc::clone(&room);
    // Whoever asks first would wait for it.
    std::thread::spawn(move || early.setup.desk.prepare().is_ok());
    let runtime =
        tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()?;
    let ended = runtime.block_on(async {
        let listener = tokio::net::TcpListener::from_std(listener)?;
        let served = axum::serve(listener, router(Arc::clone(&room)));
        tokio::select! {
            ended = served => ended,
            () = watched(Arc::clone(&room)) => Ok(()),
            () = stop.wished() => Ok(()),
        }
    });
    locked(&room.building).stop();
    // What still labels is not waited for: nothing of it would be kept.
    runtime.shutdown_timeout(Duration::from_secs(5));
    ended
}

fn room(setup: Setup, token: Token, address: SocketAddr) -> Room {
    let port = address.port();
    let names = ["127.0.0.1", "localhost", "[::1]"];
    let mut hosts = names.map(|name| format!("{name}:{port}")).to_vec();
    if port == WEB {
        // An address leaves out the port that the web has of itself.
        hosts.extend(names.map(String::from));
    }
    let screen = Screen::of(setup.desk.mesh());
    let paper = Mutex::new(setup.paper.clone());
    let standing = setup.house.built().ok().flatten();
    let building = Mutex::new(Building::over(standing, &setup.out));
    Arc::new(Inner {
        paper,
        screen,
        setup,
        token,
        hosts,
        events: broadcast::Sender::new(BEHIND),
        tabs: AtomicUsize::new(0),
        labels: Turn::default(),
        joints: Turn::default(),
        ranges: Turn::default(),
        building,
    })
}

/// Looks at the condition file now and then, and tells when somebody else changed it.
async fn watched(room: Room) {
    loop {
        tokio::time::sleep(LOOK).await;
        let here = Arc::clone(&room);
        let look = move || {
            let mut paper = locked(&here.paper);
            let changed = paper.look().unwrap_or(false);
            changed.then(|| paper.revision().to_owned())
        };
        if let Ok(Some(revision)) = apart(look).await {
            room.tell(Event::Condition { revision });
        }
    }
}

/// What can be asked, by path: the same list as in [`crate::openapi()`].
fn routes() -> Vec<(&'static str, MethodRouter<Room>)> {
    vec![
        ("/api/state", get(edit::state)),
        ("/api/mesh", get(edit::mesh)),
        ("/api/photo", get(edit::photo)),
        ("/api/condition", get(edit::condition).put(edit::write)),
        ("/api/labels", post(edit::labels)),
        ("/api/articulate", post(edit::articulate)),
        ("/api/free-range", post(edit::free_range)),
        ("/api/draft", post(work::draft)),
        ("/api/build", post(work::build)),
        ("/api/build/cancel", post(work::cancel)),
        ("/api/events", get(events::stream)),
        ("/api/built", get(work::built)),
        ("/api/artefacts", get(work::artefacts)),
        ("/api/artefacts/{*name}", get(work::artefact)),
        ("/api/check", post(work::check)),
        ("/api/openapi.json", get(described)),
    ]
}

fn router(room: Room) -> Router {
    let mut router = Router::new().route("/", get(page));
    for (path, answer) in routes() {
        router = router.route(path, answer);
    }
    let unknown = || async {
        let refusal = Refusal::new(StatusCode::NOT_FOUND, "nothing is asked for like that");
        refusal.hint("`/api/openapi.json` lists what can be asked")
    };
    router
        .fallback(unknown)
        .method_not_allowed_fallback(|| async {
            Refusal::new(StatusCode::METHOD_NOT_ALLOWED, "it is not asked for in this way")
                .hint("`/api/openapi.json` lists what can be asked")
        })
        .layer(DefaultBodyLimit::max(MOST))
        .layer(from_fn_with_state(Arc::clone(&room), guard::guarded))
        .with_state(room)
}

async fn page(State(room): State<Room>) -> impl IntoResponse {
    Html(room.setup.page.clone())
}

async fn described() -> impl IntoResponse {
    let text = format!("{:#}\n", crate::openapi());
    ([(header::CONTENT_TYPE, "application/json")], text)
}

#[cfg(test)]
mod tests;
