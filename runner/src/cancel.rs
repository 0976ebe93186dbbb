//! The wish to stop: first finish what runs, then drop everything.
//!
//! ```
//! use runner::{Cancel, Wish};
//!
//! let cancel = Cancel::default();
//! assert_eq!(cancel.wish(), Wish::Go);
//! assert_eq!([cancel.press(), cancel.press()], [Wish::Drain, Wish::Abort]);
//! ```

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

/// How urgently somebody wants the run to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Wish {
    /// Go on.
    Go,
    /// Start nothing new, let running stages finish and be recorded.
    Drain,
    /// Leave at once; what runs is lost, what is recorded stays.
    Abort,
}

/// A wish that may be shared between threads and only grows more urgent.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicU8>);

impl Cancel {
    /// The wish now.
    pub fn wish(&self) -> Wish {
        match self.0.load(Ordering::SeqCst) {
            0 => Wish::Go,
            1 => Wish::Drain,
            _ => Wish::Abort,
        }
    }

    /// One step more urgent, as each Ctrl-C does; returns the new wish.
    pub fn press(&self) -> Wish {
        let _ =
            self.0.fetch_update(Ordering::SeqCst, Ordering::SeqCst, |n| (n < 2).then_some(n + 1));
        self.wish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_press_drains_and_the_second_aborts() {
        let cancel = Cancel::default();
        let other = cancel.clone();
        assert_eq!(cancel.wish(), Wish::Go);
        assert_eq!(
            [cancel.press(), other.press(), cancel.press()],
            [Wish::Drain, Wish::Abort, Wish::Abort]
        );
        assert_eq!(other.wish(), Wish::Abort);
    }
}
