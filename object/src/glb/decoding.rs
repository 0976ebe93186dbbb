//! What decoders may take: room, time, and no more of the process than their own thread.

use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;

use super::error::GlbError;

/// Most bytes compressed geometry may unpack to (512 MiB).
pub const MAX_DECODED_BYTES: usize = 512 << 20;
/// What a file may unpack to whatever its size, bytes, and how much more per byte of it: Draco comes
/// to some 30, a flat grid to some 1000, what is left out (accessors without a view) has no bound.
const UNPACKED_ANYWAY: usize = 16 << 20;
const UNPACKED_PER_BYTE: usize = 2000;
/// How long one compressed primitive may take, seconds: at any size, and more for each MiB of it. A
/// sound one takes well below a second per MiB; a guess with room for a busy machine.
const DECODING: [f64; 2] = [20.0, 10.0];
const MIB: f64 = 1_048_576.0;
/// Stack of a decoder, bytes: what the main thread has on Linux.
const STACK: usize = 8 << 20;

/// Most bytes that a file of so many may unpack to.
pub(super) fn most_unpacked(file: usize) -> usize {
    MAX_DECODED_BYTES.min(UNPACKED_ANYWAY.saturating_add(file.saturating_mul(UNPACKED_PER_BYTE)))
}

/// Runs a decoder we did not write. The Draco decoder is young: should a hostile stream make it
/// panic, the file is refused like any other broken one, and the caller's process lives on.
pub(super) fn guarded<T, E: Display>(
    place: &str,
    codec: &'static str,
    decode: impl FnOnce() -> Result<T, E>,
) -> Result<T, GlbError> {
    let failed = |reason| GlbError::Codec { place: place.into(), codec, reason };
    match catch_unwind(AssertUnwindSafe(decode)) {
        Ok(Ok(value)) => Ok(value),
        Ok(Err(error)) => Err(failed(error.to_string())),
        Err(_) => Err(failed("the decoder gave up".into())),
    }
}

/// The same with a deadline that grows with the bytes to decode. What is too slow is given up and
/// refused; its thread ends with it or with the program, whichever is first, for nothing can stop
/// it: a checker's process is ended, and a run that cannot read its mesh ends by itself.
pub(super) fn timed<T: Send + 'static, E: Display>(
    place: &str,
    codec: &'static str,
    bytes: usize,
    decode: impl FnOnce() -> Result<T, E> + Send + 'static,
) -> Result<T, GlbError> {
    let deadline = Duration::from_secs_f64(DECODING[0] + DECODING[1] * bytes as f64 / MIB);
    within(place, codec, deadline, decode)
}

pub(super) fn within<T: Send + 'static, E: Display>(
    place: &str,
    codec: &'static str,
    deadline: Duration,
    decode: impl FnOnce() -> Result<T, E> + Send + 'static,
) -> Result<T, GlbError> {
    let (sender, receiver) = std::sync::mpsc::sync_channel(1);
    let here = place.to_owned();
    let work = move || {
        // Nobody may be waiting any more.
        let _ = sender.send(guarded(&here, codec, decode));
    };
    let failed = |reason: String| GlbError::Codec { place: place.into(), codec, reason };
    let thread = std::thread::Builder::new().name(codec.into()).stack_size(STACK);
    let started = thread.spawn(work);
    started.map_err(|e| failed(format!("no thread could be started: {e}")))?;
    receiver.recv_timeout(deadline).unwrap_or_else(|_| {
        Err(failed(format!("it takes longer than the {} s it may", deadline.as_secs_f64())))
    })
}
