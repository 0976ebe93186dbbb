//! Hands out the items that have no outcome yet: first in the order of the plan, then those that
//! met a passing trouble once more.

use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard};
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
    settings: Option<&'a Digest>,
    again: Vec<&'static str>,
    cancel: &'a Cancel,
    more: Option<Arrivals>,
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
    come: u64,
}

/// Items that may still come.
#[derive(Clone, Debug)]
pub struct Arrivals {
    /// What the paths of the items are relative to.
    pub base: PathBuf,
    /// How many have come so far.
    pub count: Arc<AtomicU64>,
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
        let settings = Some(settings);
        Self { ledger, plan, run, settings, again, cancel, more: None, desk, news }
    }

    /// What is pending of a plan that grows, whatever it was asked for under; it waits for more until
    /// everything is to stop.
    pub fn growing(
        (ledger, plan, run): (&'a Ledger, i64, i64),
        arrivals: Arrivals,
        cancel: &'a Cancel,
    ) -> Self {
        let (desk, news, more) = (Mutex::default(), Condvar::new(), Some(arrivals));
        Self { ledger, plan, run, settings: None, again: vec![], cancel, more, desk, news }
    }

    /// Whether it waits for more.
    pub fn is_growing(&self) -> bool {
        self.more.is_some()
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
        if let Some(more) = &self.more {
            let come = more.count.load(Ordering::SeqCst);
            desk.whole &= come == desk.come;
            desk.come = come;
        }
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
        let next = match desk.page.pop_front() {
            Some(next) => Some(next),
            None => match desk.troubled.pop_front() {
                Some(n) => self.ledger.planned(n)?,
                None => None,
            },
        };
        Ok(next.map(|planned| match &self.more {
            Some(more) => Planned { item: planned.item.found_from(&more.base), ..planned },
            None => planned,
        }))
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
            if desk.out == 0 && self.more.is_none() {
                return Ok(None);
            }
            // Whatever is out may come back troubled, and more may come.
            let waited = self.news.wait_timeout(desk, GLANCE);
            desk = waited.unwrap_or_else(|e| e.into_inner()).0;
        }
    }
}
