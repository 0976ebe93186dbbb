//! The purse of a batch: how many requests that may cost there may be, and each of them in the ledger
//! before it is sent.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard};

use adapters::AdapterError;
use adapters::budget::{Book, Budget, Entry, Fate, Unbooked};
use trace::Clock;

use super::allowance::{Allowance, stage};
use super::error::BatchError;
use super::ledger::{Call, Ledger, LedgerError, Sent};

/// What was spent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    /// Requests that were sent, or may have been.
    pub calls: u64,
    /// Their cost.
    pub cost: f64,
}

/// What was spent: by all, and by each owner of a share.
#[derive(Clone, Debug, Default)]
struct Desk {
    all: Spent,
    own: BTreeMap<String, Spent>,
}

/// What of all of it each owner of items may spend: whose an item is stands in its id, before the first dot.
pub type Shares = BTreeMap<String, Budget>;

/// The purse of a batch: a request is written into the ledger before it is sent.
pub struct Purse {
    allowance: Allowance,
    shares: Shares,
    spent: Mutex<Desk>,
    run: i64,
    ledger: Arc<Ledger>,
    clock: Arc<dyn Clock>,
}

impl Purse {
    /// A purse out of which the ledger's requests were paid already.
    ///
    /// # Errors
    /// [`BatchError`] when the ledger cannot be read, or its requests were changed and there is a
    /// budget to keep.
    pub fn open(
        allowance: Allowance,
        run: i64,
        ledger: Arc<Ledger>,
        clock: Arc<dyn Clock>,
    ) -> Result<Arc<Self>, BatchError> {
        Self::shared(allowance, Shares::new(), (run, ledger), clock)
    }

    /// The same purse, of which each of these owners may spend a share.
    ///
    /// # Errors
    /// As [`Purse::open`].
    pub fn shared(
        allowance: Allowance,
        shares: Shares,
        (run, ledger): (i64, Arc<Ledger>),
        clock: Arc<dyn Clock>,
    ) -> Result<Arc<Self>, BatchError> {
        let is_limited = |share: &Budget| share.calls.is_some() || share.money.is_some();
        if allowance.is_limited() || shares.values().any(is_limited) {
            let broken = ledger.broken_calls()?;
            broken.map_or(Ok(()), |found| Err(BatchError::Spending { found }))?;
        }
        let spent = |sent: Vec<Sent>| Spent {
            calls: sent.iter().map(|s| s.requests).sum(),
            cost: allowance.cost(&sent),
        };
        let mut desk = Desk { all: spent(ledger.calls(None)?), ..Desk::default() };
        for owner in shares.keys() {
            desk.own.insert(owner.clone(), spent(ledger.calls_of(owner)?));
        }
        let spent = Mutex::new(desk);
        Ok(Arc::new(Self { allowance, shares, spent, run, ledger, clock }))
    }

    /// What was spent so far.
    pub fn spent(&self) -> Spent {
        self.lock().all
    }

    /// What was spent so far by an owner of a share.
    pub fn spent_by(&self, owner: &str) -> Spent {
        self.lock().own.get(owner).copied().unwrap_or_default()
    }

    /// What an owner may spend.
    pub fn share_of(&self, owner: &str) -> Budget {
        self.shares.get(owner).copied().unwrap_or_default()
    }

    fn lock(&self) -> MutexGuard<'_, Desk> {
        self.spent.lock().unwrap_or_else(|e| e.into_inner())
    }

    fn call<'a>(&self, id: &'a str, step: &str, cost: f64) -> Call<'a> {
        Call { run: self.run, id, stage: stage(step), cost, at: self.clock.now() }
    }

    fn pay(&self, id: &str, entry: &Entry) -> Result<i64, Unbooked> {
        let mut spent = self.lock();
        let price = self.allowance.price(&entry.step);
        let own =
            owner(id).and_then(|owner| Some((self.shares.get(owner)?, spent.own.get(owner)?)));
        let why = too_much("budget", &self.allowance.most, &spent.all, price)
            .or_else(|| own.and_then(|(share, own)| too_much("token's budget", share, own, price)));
        if let Some(why) = why {
            return Err(Unbooked::Refused(why));
        }
        let noted = self.ledger.call(&self.call(id, &entry.step, price), entry);
        let row = noted.map_err(unwritten)?;
        spent.each(id, |spent| {
            spent.calls += 1;
            spent.cost += price;
        });
        Ok(row)
    }

    fn settle(&self, id: &str, row: i64, entry: &Entry) -> Result<(), AdapterError> {
        let mut spent = self.lock();
        let price = self.allowance.price(&entry.step);
        let free = matches!(entry.fate, Fate::Unsent | Fate::Refused);
        let cost = if free { 0.0 } else { price };
        let call = self.call(id, &entry.step, cost);
        self.ledger.settle(row, &call, entry).map_err(unwritten)?;
        spent.each(id, |spent| {
            spent.cost -= price - cost;
            if entry.fate == Fate::Unsent {
                spent.calls = spent.calls.saturating_sub(1);
            }
        });
        Ok(())
    }
}

impl Desk {
    /// Counts for all, and for the owner of an item.
    fn each(&mut self, id: &str, count: impl Fn(&mut Spent)) {
        count(&mut self.all);
        if let Some(own) = owner(id).and_then(|owner| self.own.get_mut(owner)) {
            count(own);
        }
    }
}

/// Whose an item is, if anybody's.
fn owner(id: &str) -> Option<&str> {
    id.split_once('.').map(|(owner, _)| owner)
}

/// Why a request of this price is one too many; none if it is not.
fn too_much(what: &str, most: &Budget, spent: &Spent, price: f64) -> Option<String> {
    if let Some(most) = most.calls.filter(|most| spent.calls >= *most) {
        return Some(format!("the {what} of {most} requests is spent"));
    }
    // A hair of slack: ten times 0.1 is within 1.
    let cost = most.money.filter(|most| spent.cost + price > most * (1.0 + 1e-9));
    cost.map(|most| format!("the {what} of {most} is spent: {:.2} so far", spent.cost))
}

fn unwritten(error: LedgerError) -> AdapterError {
    let path = error.path.display().to_string();
    AdapterError::Io { path, source: std::io::Error::other(error.to_string()) }
}

/// The account book of one item: what stands in it stands in the ledger, too, under the item.
pub struct ItemBook {
    inner: Arc<dyn Book>,
    purse: Arc<Purse>,
    id: String,
    rows: Mutex<BTreeMap<u64, i64>>,
}

impl ItemBook {
    /// The book of an item over the one of the state directory.
    pub fn new(inner: &Arc<dyn Book>, purse: &Arc<Purse>, id: &str) -> Self {
        let (inner, purse) = (Arc::clone(inner), Arc::clone(purse));
        Self { inner, purse, id: id.to_owned(), rows: Mutex::default() }
    }

    fn rows(&self) -> MutexGuard<'_, BTreeMap<u64, i64>> {
        self.rows.lock().unwrap_or_else(|e| e.into_inner())
    }
}

impl Book for ItemBook {
    fn entries(&self) -> Result<Vec<Entry>, AdapterError> {
        self.inner.entries()
    }

    fn ask(&self, entry: &Entry, judge: adapters::book::Judge<'_>) -> Result<u64, Unbooked> {
        let number = self.inner.ask(entry, judge)?;
        match self.purse.pay(&self.id, entry) {
            Ok(row) => {
                self.rows().insert(number, row);
                Ok(number)
            }
            Err(why) => {
                let unsent = Entry { fate: Fate::Unsent, money: Some(0.0), ..entry.clone() };
                self.inner.settle(number, &unsent)?;
                Err(why)
            }
        }
    }

    fn settle(&self, number: u64, entry: &Entry) -> Result<(), AdapterError> {
        self.inner.settle(number, entry)?;
        let row = self.rows().remove(&number);
        let ledger = &self.purse.ledger;
        // One that a killed run asked stands in the ledger under whichever item asked it.
        let row = match row {
            Some(row) => Some((row, self.id.clone())),
            None => ledger.unsettled(entry).map_err(unwritten)?,
        };
        row.map_or(Ok(()), |(row, id)| self.purse.settle(&id, row, entry))
    }

    fn tell(&self, entry: &Entry) -> Result<(), AdapterError> {
        self.inner.tell(entry)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use adapters::budget::{Leave, MemoryBook};
    use adapters::usage::Usage;
    use trace::{Digest, FixedClock};

    use super::super::allowance::Prices;
    use super::*;

    fn entry(step: &str, fate: Fate) -> Entry {
        let (question, usage) = (Digest::of(b"q"), Usage::default());
        Entry { question, step: step.into(), work: true, fate, usage, money: None }
    }

    fn go(_: &[Entry], _: &BTreeSet<u64>) -> Leave {
        Leave::Go
    }

    fn purse(allowance: Allowance, ledger: &Arc<Ledger>) -> Arc<Purse> {
        Purse::open(allowance, 1, Arc::clone(ledger), Arc::new(FixedClock(1))).unwrap()
    }

    fn book(purse: &Arc<Purse>) -> ItemBook {
        let inner: Arc<dyn Book> = Arc::new(MemoryBook::default());
        ItemBook::new(&inner, purse, "kettle")
    }

    #[test]
    fn a_request_beyond_the_budget_is_refused_and_costs_nothing() {
        let ledger = Arc::new(Ledger::passing().unwrap());
        let prices = Prices { mesh: 0.2, ..Prices::default() };
        let purse = purse(Allowance::new(None, Some(0.5), prices), &ledger);
        let book = book(&purse);
        let ask = || book.ask(&entry("meshy.submit", Fate::Asked), &go);
        ask().unwrap();
        ask().unwrap();
        let Err(Unbooked::Refused(why)) = ask() else { panic!("it was sent") };
        assert_eq!(why, "the budget of 0.5 is spent: 0.40 so far");
        assert_eq!(purse.spent().calls, 2);
        assert_eq!(book.entries().unwrap()[2].fate, Fate::Unsent, "and none in the book");
    }

    #[test]
    fn one_token_that_spends_its_share_leaves_the_others_theirs() {
        let ledger = Arc::new(Ledger::passing().unwrap());
        let few = |calls| Budget { calls: Some(calls), ..Budget::default() };
        let shares: Shares = [("ann".to_owned(), few(1)), ("bob".to_owned(), few(2))].into();
        let opened = || {
            let clock = Arc::new(FixedClock(1));
            Purse::shared(Allowance::default(), shares.clone(), (1, Arc::clone(&ledger)), clock)
        };
        let purse = opened().unwrap();
        let inner: Arc<dyn Book> = Arc::new(MemoryBook::default());
        let ask =
            |id| ItemBook::new(&inner, &purse, id).ask(&entry("meshy.submit", Fate::Asked), &go);
        ask("ann.1").unwrap();
        let Err(Unbooked::Refused(why)) = ask("ann.2") else { panic!("it was sent") };
        assert_eq!(why, "the token's budget of 1 requests is spent");
        ask("bob.1").unwrap();
        assert_eq!(opened().unwrap().spent_by("ann").calls, 1, "the same from the ledger");
        assert_eq!((purse.spent_by("bob").calls, purse.spent().calls), (1, 2));
    }

    #[test]
    fn what_was_sent_counts_over_all_runs_whatever_became_of_it() {
        let ledger = Arc::new(Ledger::passing().unwrap());
        let prices = Prices { condition: 3.0, ..Prices::default() };
        let allowance = Allowance::new(None, None, prices);
        let first = purse(allowance, &ledger);
        let book = book(&first);
        for fate in [Fate::Answered, Fate::Lost, Fate::Refused, Fate::Unsent] {
            let number = book.ask(&entry("vlm.points/0", Fate::Asked), &go).unwrap();
            book.settle(number, &entry("vlm.points/0", fate)).unwrap();
        }
        book.ask(&entry("vlm.physical/0", Fate::Asked), &go).unwrap();
        let spent = Spent { calls: 4, cost: 3.0 };
        assert_eq!(first.spent(), spent, "refused costs nothing, unsent is no request");
        assert_eq!(purse(allowance, &ledger).spent(), spent, "the same from the ledger");
        assert!(ledger.broken_links().unwrap().is_empty());
    }

    #[test]
    fn an_answer_found_on_record_settles_what_a_killed_run_asked() {
        let ledger = Arc::new(Ledger::passing().unwrap());
        let purse = purse(Allowance::default(), &ledger);
        let killed = book(&purse);
        killed.ask(&entry("vlm.points/0", Fate::Asked), &go).unwrap();
        assert_eq!(ledger.unsettled(&entry("vlm.points/0", Fate::Asked)).unwrap().unwrap().0, 1);
        let next = ItemBook::new(&killed.inner, &purse, "kettle");
        next.settle(0, &entry("vlm.points/0", Fate::Answered)).unwrap();
        assert!(ledger.unsettled(&entry("vlm.points/0", Fate::Asked)).unwrap().is_none());
        assert_eq!(purse.spent().calls, 1);
    }
}
