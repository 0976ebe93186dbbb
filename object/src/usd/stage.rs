//! One layer opened as a stage, in a thread that is given up after a time.

use std::io::{self, Cursor};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;

use openusd::ar::{Asset, ResolvedPath, Resolver};
use openusd::usd::Stage;

use super::error::{UsdError, shortened};
use super::extract::scene as extracted;
use super::scene::Scene;

/// How long reading may take, seconds: at any size, and more for each MiB. Guesses with room for a busy machine;
/// a sound layer takes below a tenth of a second per MiB.
const READING: [f64; 2] = [20.0, 2.0];
const MIB: f64 = 1_048_576.0;
/// Stack of the thread, bytes.
const STACK: usize = 32 << 20;

/// The one layer there is: every other path leads nowhere.
struct Alone {
    name: &'static str,
    bytes: Vec<u8>,
}

impl Resolver for Alone {
    fn create_identifier(&self, asset_path: &str, _anchor: Option<&ResolvedPath>) -> String {
        asset_path.to_owned()
    }

    fn resolve(&self, asset_path: &str) -> Option<ResolvedPath> {
        (asset_path == self.name).then(|| ResolvedPath::new(asset_path))
    }

    fn resolve_for_new_asset(&self, _asset_path: &str) -> Option<ResolvedPath> {
        None
    }

    fn open_asset(&self, resolved_path: &ResolvedPath) -> io::Result<Box<dyn Asset>> {
        if resolved_path.to_str() != Some(self.name) {
            return Err(io::ErrorKind::NotFound.into());
        }
        Ok(Box::new(Cursor::new(self.bytes.clone())))
    }

    fn get_modification_timestamp(
        &self,
        _: &str,
        _: &ResolvedPath,
    ) -> Option<std::time::SystemTime> {
        None
    }
}

/// What the layer's stage shows.
pub(super) fn scene(bytes: Vec<u8>) -> Result<Scene, UsdError> {
    let size = bytes.len();
    within_time(size, move || opened(bytes))
}

/// What comes of reading so many bytes, in a thread that is given up after a time.
pub(super) fn within_time<T: Send + 'static>(
    size: usize,
    read: impl FnOnce() -> Result<T, UsdError> + Send + 'static,
) -> Result<T, UsdError> {
    let deadline = Duration::from_secs_f64(READING[0] + READING[1] * size as f64 / MIB);
    let (sender, receiver) = std::sync::mpsc::sync_channel(1);
    let work = move || {
        let read = catch_unwind(AssertUnwindSafe(read));
        let gave_up = || Err(UsdError::Unanswered("the reader gave up on it".into()));
        // Nobody may be waiting any more.
        let _ = sender.send(read.unwrap_or_else(|_| gave_up()));
    };
    let unreadable = |why: String| UsdError::Unreadable(why);
    let thread = std::thread::Builder::new().name("usd".into()).stack_size(STACK).spawn(work);
    thread.map_err(|e| unreadable(format!("no thread could be started: {e}")))?;
    receiver.recv_timeout(deadline).unwrap_or_else(|_| {
        let most = deadline.as_secs_f64();
        Err(UsdError::Unanswered(format!("it takes longer than the {most:.0} s it may")))
    })
}

fn opened(bytes: Vec<u8>) -> Result<Scene, UsdError> {
    let is_text = bytes.starts_with(b"#usda");
    if !is_text {
        super::bounds::bounded(&bytes).map_err(UsdError::Unreadable)?;
    }
    let name = if is_text { "layer.usda" } else { "layer.usdc" };
    let broken = |e: anyhow::Error| UsdError::Unreadable(shortened(&e));
    let stage = Stage::builder().resolver(Alone { name, bytes }).open(name).map_err(broken)?;
    extracted(&stage)
}
