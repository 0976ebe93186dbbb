//! Hands out the items that have no outcome yet: first in the order of the plan, then those that
//! met a passing trouble once more.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Condvar, Mutex, MutexGuard};
use std::time::Duration;

use runner::{Cancel, Wish};
use trace::Digest;

use super::engine::Feed;
use super::error::BatchError;
use super::ledger::{Ledger, Planned, Settled};

/// Items that are fetched from the ledger at once.
const AT_ONCE: u32 = 200;
/// How often an item that meets passing troubles is tried in a run.
const TRIES: u32 = 3;
/// How often the wish to stop is looked at while there is nothing to hand out.
const GLANCE: Duration = Duration::from_millis(50);

/// The pending items of a plan.
pub struct Pending<'a> {
    ledger: &'a Ledger,
    plan: i64,
    run: i64,
    settings: &'a Digest,
    again: Vec<&'static str>,
    cancel: &'a Cancel,
    desk: Mutex<Desk>,
    news: Condvar,
}

#[derive(Default)]
struct Desk {
    page: VecDeque<Planned>,
    cursor: i64,
    whole: bool,
    closed: bool,
    out: u32,
    troubled: VecDeque<i64>,
    tries: BTreeMap<i64, u32>,
}

/// What became of an item that was handed out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Back {
    /// It has an outcome that stands.
    Settled,
    /// It met a trouble that passes.
    Troubled,
    /// It was put down unfinished, because everything is to stop.
    Unfinished,
}

impl<'a> Pending<'a> {
    /// What is pending under these settings.
    pub fn new(
        (ledger, plan, run): (&'a Ledger, i64, i64),
        settings: &'a Digest,
        again: Vec<&'static str>,
        cancel: &'a Cancel,
    ) -> Self {
        let (desk, news) = (Mutex::default(), Condvar::new());
        Self { ledger, plan, run, settings, again, cancel, desk, news }
    }

    fn desk(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(|e| e.into_inner())
    }

    /// Takes note of what became of an item.
    pub fn back(&self, n: i64, back: Back) {
        let mut desk = self.desk();
        desk.out = desk.out.saturating_sub(1);
        if back == Back::Troubled {
            let tries = desk.tries.entry(n).or_insert(0);
            *tries += 1;
            if *tries < TRIES {
                desk.troubled.push_back(n);
            }
        }
        self.news.notify_all();
    }

    fn fill(&self, desk: &mut Desk) -> Result<(), BatchError> {
        while desk.page.is_empty() && !desk.whole {
            let settled = Settled {
                plan: self.plan,
                settings: self.settings,
                again: &self.again,
                run: self.run,
            };
            let page = self.ledger.pending(&settled, desk.cursor, AT_ONCE)?;
            desk.whole = page.len() < AT_ONCE as usize;
            desk.cursor = page.last().map_or(desk.cursor, |p| p.n);
            desk.page.extend(page);
        }
        Ok(())
    }

    fn pick(&self, desk: &mut Desk) -> Result<Option<Planned>, BatchError> {
        self.fill(desk)?;
        if let Some(next) = desk.page.pop_front() {
            return Ok(Some(next));
        }
        match desk.troubled.pop_front() {
            Some(n) => Ok(self.ledger.planned(n)?),
            None => Ok(None),
        }
    }
}

impl Feed for Pending<'_> {
    fn stop(&self) {
        self.desk().closed = true;
        self.news.notify_all();
    }

    fn next(&self) -> Result<Option<Planned>, BatchError> {
        let mut desk = self.desk();
        loop {
            if desk.closed || self.cancel.wish() != Wish::Go {
                return Ok(None);
            }
            if let Some(next) = self.pick(&mut desk)? {
                desk.out += 1;
                return Ok(Some(next));
            }
            if desk.out == 0 {
                return Ok(None);
            }
            // Whatever is out may come back troubled.
            let waited = self.news.wait_timeout(desk, GLANCE);
            desk = waited.unwrap_or_else(|e| e.into_inner()).0;
        }
    }
}
