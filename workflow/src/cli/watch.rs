//! Looking at what strangers sent ends: a deadline and a cap of memory for the whole program.
//!
//! Every reader has caps of its own. This is what holds where none of them does.

use std::io::Write as _;
use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use runner::ours::scratch;

use crate::cli::speech::Exit;

/// How often the memory is looked at.
const PAUSE: Duration = Duration::from_millis(25);

/// What the program may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// The longest time.
    pub deadline: Duration,
    /// Most memory, bytes. Looked at on Linux alone; elsewhere there is no such cap.
    pub memory: u64,
    /// How the program ends that takes more.
    pub exit: i32,
}

impl Bounds {
    /// Most memory that looking takes, bytes (8 GiB): a guess; a replay of the largest case measured
    /// takes 2 GiB.
    pub const MEMORY: u64 = 8 << 30;
}

/// Ends the program when it takes too long or too much, until it is let go.
#[derive(Debug)]
pub struct Watch(Arc<(Mutex<bool>, Condvar)>);

impl Watch {
    /// Begins to watch; `what` is what the error is about, such as a command.
    pub fn begin(what: String, bounds: Bounds) -> Self {
        let over = Arc::new((Mutex::new(false), Condvar::new()));
        let (shared, begun) = (Arc::clone(&over), Instant::now());
        std::thread::spawn(move || {
            let mut done = locked(&shared.0);
            while !*done {
                if let Some((found, hint)) = exceeded(begun, bounds) {
                    end(&format!("error: {what} {found}\nhint: {hint}"), bounds.exit);
                }
                done =
                    shared.1.wait_timeout(done, PAUSE).map_or_else(|e| e.into_inner().0, |w| w.0);
            }
        });
        Self(over)
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        *locked(&self.0.0) = true;
        self.0.1.notify_all();
    }
}

fn locked<A>(mutex: &Mutex<A>) -> MutexGuard<'_, A> {
    mutex.lock().unwrap_or_else(|e| e.into_inner())
}

fn exceeded(begun: Instant, bounds: Bounds) -> Option<(String, &'static str)> {
    if begun.elapsed() > bounds.deadline {
        let found = format!("took longer than {} s and was stopped", bounds.deadline.as_secs_f64());
        return Some((found, "--deadline SECONDS gives it more"));
    }
    let memory = memory().filter(|&bytes| bytes > bounds.memory)?;
    let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
    let (most, memory) = (gib(bounds.memory), gib(memory));
    let found = format!("takes {memory:.1} GiB of memory, more than {most} GiB, and was stopped");
    Some((found, "--memory GIB gives it more"))
}

/// The memory of this process, bytes.
fn memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:"))?;
    let kib: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    kib.checked_mul(1024)
}

/// Says why and ends the program; folders that were to be gone with it go.
fn end(words: &str, exit: i32) -> ! {
    scratch::remove_all();
    let _ = writeln!(std::io::stderr(), "{words}");
    std::process::exit(exit)
}

/// How a command ends that took too much.
pub const STOPPED: i32 = Exit::Failed as i32;

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]
mod tests {
    use super::*;

    const ENDLESS: Bounds = Bounds { deadline: Duration::MAX, memory: u64::MAX, exit: STOPPED };

    #[test]
    fn what_is_exceeded_is_named_with_its_cap() {
        let begun = Instant::now();
        assert_eq!(exceeded(begun, ENDLESS), None);
        let (found, hint) =
            exceeded(begun, Bounds { deadline: Duration::ZERO, ..ENDLESS }).unwrap();
        assert_eq!(found, "took longer than 0 s and was stopped");
        assert!(hint.starts_with("--deadline"));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn memory_is_seen() {
        let (found, _) = exceeded(Instant::now(), Bounds { memory: 1 << 20, ..ENDLESS }).unwrap();
        assert!(found.contains("more than 0.0009765625 GiB"), "{found}");
    }

    #[test]
    fn one_that_is_let_go_ends_nothing() {
        let watch = Watch::begin("a test".into(), ENDLESS);
        drop(watch);
        assert!(scratch::folder().unwrap().path().is_dir());
    }
}
