//! Work on threads of its own: without the interpreter's lock, stopped by Ctrl-C, and no panic leaves it.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use pyo3::prelude::*;

use crate::errors::Wrong;

/// How often the interpreter is asked whether somebody pressed Ctrl-C.
pub(crate) const GLANCE: Duration = Duration::from_millis(50);
/// Stack of a thread that works, bytes: that of a stage. Threads of Python may have far less.
const STACK: usize = 32 << 20;

/// The process in which work was done first; 0 before that.
static AT_WORK: AtomicU32 = AtomicU32::new(0);

/// Refuses work in a process that was forked off one where work was done: its pool of threads was not
/// forked along, and whoever waits for it would wait for ever.
fn not_forked() -> Result<(), Wrong> {
    let own = std::process::id();
    match AT_WORK.compare_exchange(0, own, Ordering::SeqCst, Ordering::SeqCst) {
        Ok(_) => Ok(()),
        Err(first) if first == own => Ok(()),
        Err(_) => Err(Wrong::input(
            "this process was forked off one in which kinfold had been at work: its threads are not here",
        )
        .of_class("RunError")
        .hint("start processes with multiprocessing.get_context(\"spawn\"), or fork before the first call")),
    }
}

/// What a panic said.
fn said(panic: &(dyn Any + Send)) -> Wrong {
    let text = panic.downcast_ref::<&str>().map(ToString::to_string);
    let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
    Wrong::fault(format!("kinfold broke off: {}", text.unwrap_or_default()))
}

/// Starts work on a thread of its own. Its last message is what came of it, or what a panic said.
pub(crate) fn begin<M: Send + 'static>(
    sender: Sender<M>,
    work: impl FnOnce() -> M + Send + 'static,
    broken: fn(Wrong) -> M,
) -> Result<(), Wrong> {
    not_forked()?;
    let body = move || {
        let ended = catch_unwind(AssertUnwindSafe(work));
        // Who asked may be gone; then nobody is told.
        drop(sender.send(ended.unwrap_or_else(|panic| broken(said(&*panic)))));
    };
    let thread = std::thread::Builder::new().name("kinfold".into()).stack_size(STACK);
    let begun = thread.spawn(body);
    begun.map(drop).map_err(|e| Wrong::fault(format!("no thread can be started: {e}")))
}

/// The next message; none when it is time to look around. The interpreter runs meanwhile.
pub(crate) fn next<M: Send>(py: Python<'_>, receiver: &mut Receiver<M>) -> PyResult<Option<M>> {
    match py.detach(move || receiver.recv_timeout(GLANCE)) {
        Ok(message) => Ok(Some(message)),
        Err(RecvTimeoutError::Timeout) => Ok(None),
        Err(RecvTimeoutError::Disconnected) => {
            Err(Wrong::fault("the thread that worked is gone").raised(py))
        }
    }
}

/// Does some work on a thread of its own. Ctrl-C leaves it to itself: it ends, and nobody hears of it.
pub(crate) fn alone<A: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<A, Wrong> + Send + 'static,
) -> PyResult<A> {
    let (sender, mut receiver) = channel();
    begin(sender, work, Err).map_err(|wrong| wrong.raised(py))?;
    loop {
        match next(py, &mut receiver)? {
            Some(ended) => return ended.map_err(|wrong| wrong.raised(py)),
            None => py.check_signals()?,
        }
    }
}
