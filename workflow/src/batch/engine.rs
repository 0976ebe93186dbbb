//! Who decides which item is next, and where. What is done is decided by the store alone, so any
//! engine may stop, repeat or race another: the results are the same bytes.

use std::sync::{Arc, Mutex};

use runner::Workers;

use super::error::BatchError;
use super::ledger::Planned;
use super::plan::Share;

/// Stack of a hand, bytes; the stages themselves run on threads of their own.
const STACK: usize = 4 << 20;

/// Where items come from.
pub trait Feed: Sync {
    /// The next item, `None` when there are no more. May wait.
    ///
    /// # Errors
    /// [`BatchError`] when the ledger cannot be read.
    fn next(&self) -> Result<Option<Planned>, BatchError>;

    /// Hands out nothing any more, because something broke.
    fn stop(&self);
}

/// What is done with an item.
pub trait Work: Sync {
    /// Takes an item to its outcome and writes that down.
    ///
    /// # Errors
    /// [`BatchError`] when no other item would fare better either.
    fn perform(&self, item: Planned) -> Result<(), BatchError>;
}

/// Has work done on every item of a feed.
///
/// Promise: an item is handed to [`Work::perform`] at least once if the feed gave it, and the first
/// error stops the feed and is returned once everything under way has come back.
pub trait Engine {
    /// Its name.
    fn name(&self) -> &'static str;

    /// Which items of a manifest are its own.
    fn share(&self) -> Share {
        Share::ALL
    }

    /// Who does the stages that compute; this process, if nobody else.
    fn workers(&self) -> Option<Arc<dyn Workers>> {
        None
    }

    /// Has it done.
    ///
    /// # Errors
    /// The first [`BatchError`] of feed or work.
    fn run(&self, feed: &dyn Feed, work: &dyn Work) -> Result<(), BatchError>;
}

/// Items on threads of this process.
#[derive(Clone, Copy, Debug)]
pub struct Embedded {
    /// Items under way at a time, at least one.
    pub hands: usize,
}

impl Engine for Embedded {
    fn name(&self) -> &'static str {
        "embedded"
    }

    fn run(&self, feed: &dyn Feed, work: &dyn Work) -> Result<(), BatchError> {
        let first: Mutex<Option<BatchError>> = Mutex::new(None);
        let keep = |error| {
            feed.stop();
            first.lock().unwrap_or_else(|e| e.into_inner()).get_or_insert(error);
        };
        std::thread::scope(|scope| {
            for n in 0..self.hands.max(1) {
                let hand = std::thread::Builder::new().name(format!("hand {n}")).stack_size(STACK);
                let begun = hand.spawn_scoped(scope, || {
                    if let Err(error) = until_empty(feed, work) {
                        keep(error);
                    }
                });
                if let Err(source) = begun {
                    let (doing, path) = ("start a thread for", "the batch".into());
                    keep(BatchError::Io { doing, path, source });
                }
            }
        });
        first.into_inner().unwrap_or_else(|e| e.into_inner()).map_or(Ok(()), Err)
    }
}

/// One share of the items on threads of this process; what others made is found in a shared store.
#[derive(Clone, Copy, Debug)]
pub struct Shard {
    /// Which share.
    pub share: Share,
    /// Items under way at a time, at least one.
    pub hands: usize,
}

impl Engine for Shard {
    fn name(&self) -> &'static str {
        "shard"
    }

    fn share(&self) -> Share {
        self.share
    }

    fn run(&self, feed: &dyn Feed, work: &dyn Work) -> Result<(), BatchError> {
        Embedded { hands: self.hands }.run(feed, work)
    }
}

fn until_empty(feed: &dyn Feed, work: &dyn Work) -> Result<(), BatchError> {
    while let Some(item) = feed.next()? {
        work.perform(item)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};

    use trace::Digest;

    use super::super::manifest::Item;
    use super::*;

    struct Numbers {
        next: AtomicI64,
        end: i64,
        stopped: AtomicBool,
    }

    impl Feed for Numbers {
        fn next(&self) -> Result<Option<Planned>, BatchError> {
            let n = self.next.fetch_add(1, Ordering::SeqCst);
            let question = Digest::of(b"q");
            let gone = n >= self.end || self.stopped.load(Ordering::SeqCst);
            Ok((!gone).then(|| Planned { n, line: 1, item: Item::default(), question }))
        }

        fn stop(&self) {
            self.stopped.store(true, Ordering::SeqCst);
        }
    }

    struct Tally {
        done: Mutex<Vec<i64>>,
        breaks_at: i64,
    }

    impl Work for Tally {
        fn perform(&self, item: Planned) -> Result<(), BatchError> {
            if item.n == self.breaks_at {
                return Err(BatchError::Down { items: 1, last: "gone".into() });
            }
            self.done.lock().unwrap().push(item.n);
            Ok(())
        }
    }

    fn played(hands: usize, breaks_at: i64) -> (Result<(), BatchError>, Vec<i64>) {
        let feed = Numbers { next: AtomicI64::new(0), end: 100, stopped: AtomicBool::new(false) };
        let work = Tally { done: Mutex::default(), breaks_at };
        let ran = Embedded { hands }.run(&feed, &work);
        let mut done = work.done.into_inner().unwrap();
        done.sort_unstable();
        (ran, done)
    }

    #[test]
    fn every_item_is_done_once_on_any_number_of_hands() {
        for hands in [0, 1, 7] {
            let (ran, done) = played(hands, -1);
            ran.unwrap();
            assert_eq!(done, (0..100).collect::<Vec<_>>());
        }
    }

    #[test]
    fn what_breaks_the_house_stops_the_feed_and_is_told() {
        let (ran, done) = played(3, 20);
        assert_eq!(
            ran.unwrap_err().to_string(),
            "1 items in a row met a passing trouble, the last: gone"
        );
        assert!(done.len() < 90, "{}", done.len());
    }
}
