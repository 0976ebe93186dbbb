//! A batch that never ends: items come one by one, each of somebody, and are made until everything is to stop.
//!
//! Everything else is a batch's: the ledger says what became of an item, the store what is done. What came is
//! in the ledger before anybody is told so, so a service that was killed goes on with the items that have no
//! outcome yet.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use adapters::budget::Budget;
use runner::Cancel;
use trace::{Clock, Digest};

use super::engine::{Embedded, Engine as _};
use super::error::BatchError;
use super::feed::{Arrivals, Pending};
use super::item::Onlooker;
use super::ledger::{Ledger, LedgerError};
use super::manifest::Item;
use super::progress::Board;
use super::purse::{Purse, Shares};
use super::record::Record;
use super::run::{Hall, Opened, Order, Under};
use crate::recording::VERSION;

/// The name of the plan that items are added to.
const PLAN: &str = "what kinfold serve was asked for";

/// A batch that items are added to while it runs.
pub struct Service {
    ledger: Arc<Ledger>,
    plan: i64,
    run: i64,
    digest: Digest,
    purse: Arc<Purse>,
    arrivals: Arrivals,
}

impl Service {
    /// Begins a run; items that came before and have no outcome are made in it. Paths of items are relative to
    /// the folder `base`.
    ///
    /// # Errors
    /// [`BatchError`] when the ledger cannot be read or written.
    pub fn begin(
        (order, opened): (&Order, &Opened),
        shares: Shares,
        base: &Path,
        clock: &Arc<dyn Clock>,
    ) -> Result<Self, BatchError> {
        let ledger = opened.ledger();
        let words = order.settings.words();
        let run = ledger.begin(VERSION, &words, clock.now())?;
        let plan = ledger.growing_plan(PLAN)?;
        let own = (run, Arc::clone(&ledger));
        let purse = Purse::shared(order.allowance, shares, own, Arc::clone(clock))?;
        let arrivals = Arrivals { base: base.to_path_buf(), count: Arc::new(AtomicU64::new(1)) };
        let digest = Digest::of(words.as_bytes());
        Ok(Self { ledger, plan, run, digest, purse, arrivals })
    }

    /// Makes items until everything is to stop.
    ///
    /// # Errors
    /// [`BatchError`] when it cannot go on at all; everything that has an outcome keeps it.
    pub fn work(
        &self,
        (order, opened): (&Order, &Opened),
        onlooker: &dyn Onlooker,
        cancel: &Cancel,
        clock: Arc<dyn Clock>,
    ) -> Result<(), BatchError> {
        let own = (&*self.ledger, self.plan, self.run);
        let feed = Pending::growing(own, self.arrivals.clone(), cancel);
        let board = Board::new(0, 0, true);
        let (digest, onlooker) = (self.digest.clone(), Some(onlooker));
        let under = Under { run: self.run, digest, workers: None, onlooker };
        let hall = Hall { feed: &feed, purse: &self.purse, board: &board, cancel, clock };
        let bench = opened.bench(order, under, hall);
        let at_once = order.at_once;
        let hands = at_once.cpu.saturating_add(at_once.mesh).saturating_add(at_once.condition);
        Embedded { hands }.run(&feed, &bench)
    }

    /// Adds an item; false where it is there already. It is in the ledger when this returns.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be written.
    pub fn add(&self, item: &Item) -> Result<bool, LedgerError> {
        let is_new = self.ledger.order(self.plan, item)?;
        if is_new {
            self.arrivals.count.fetch_add(1, Ordering::SeqCst);
        }
        Ok(is_new)
    }

    /// An item by its id.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn item(&self, id: &str) -> Result<Option<Item>, LedgerError> {
        Ok(self.ledger.ordered(self.plan, id)?.map(|planned| planned.item))
    }

    /// The latest outcome of an item.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn outcome(&self, id: &str) -> Result<Option<Record>, LedgerError> {
        self.ledger.latest(id)
    }

    /// The ids of an owner's items, the newest first: at most so many of those before the item `before`.
    ///
    /// # Errors
    /// [`LedgerError`] when they cannot be read.
    pub fn items(
        &self,
        owner: &str,
        before: Option<&str>,
        most: usize,
    ) -> Result<Vec<String>, LedgerError> {
        self.ledger.orders(self.plan, owner, before, most)
    }

    /// How many of an owner's items have no outcome that stands.
    ///
    /// # Errors
    /// [`LedgerError`] when they cannot be counted.
    pub fn unsettled(&self, owner: &str) -> Result<u64, LedgerError> {
        self.ledger.unsettled_orders(self.plan, owner)
    }

    /// What an owner's items may spend.
    pub fn share_of(&self, owner: &str) -> Budget {
        self.purse.share_of(owner)
    }

    /// What an owner's items sent to whom it may have cost: how many requests, and their cost.
    pub fn spent_by(&self, owner: &str) -> (u64, f64) {
        let spent = self.purse.spent_by(owner);
        (spent.calls, spent.cost)
    }
}
