//! Places and purse of a batch: how many stages run at once on each resource, and how many calls of
//! providers there may be.

use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::time::Duration;

use trace::Clock;

use super::ledger::Ledger;
use super::manifest::Item;
use crate::dag::{Blame, Cancel, Entry, Gate, Resource, Stage as _, StageError, Wish};
use crate::stages::{Criticise, GenerateMesh, ProposeCondition};

/// How often the wish to stop is looked at while waiting.
const GLANCE: Duration = Duration::from_millis(50);

/// Most stages at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AtOnce {
    /// Stages that compute.
    pub cpu: usize,
    /// Calls of whoever makes meshes.
    pub mesh: usize,
    /// Calls of whoever makes conditions.
    pub condition: usize,
}

/// What may be spent, over all runs of a batch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Budget {
    /// Most calls of providers.
    pub calls: Option<u64>,
    /// Most cost, in the currency of the prices.
    pub cost: Option<f64>,
    /// Price of a mesh.
    pub mesh_price: f64,
    /// Price of a condition, and of a critique.
    pub condition_price: f64,
}

impl Budget {
    /// What calls of a stage cost.
    pub fn price(&self, stage: &str) -> f64 {
        match stage {
            GenerateMesh::NAME => self.mesh_price,
            ProposeCondition::NAME | Criticise::NAME => self.condition_price,
            _ => 0.0,
        }
    }

    /// What some calls cost.
    pub fn cost(&self, calls: &[(String, u64)]) -> f64 {
        calls.iter().fold(0.0, |sum, (stage, times)| sum + self.price(stage) * *times as f64)
    }
}

/// What was spent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    /// Calls of providers.
    pub calls: u64,
    /// Their cost.
    pub cost: f64,
}

/// The places of a batch, shared by all its items.
pub struct Places {
    limits: AtOnce,
    taken: Mutex<[usize; 3]>,
    free: Condvar,
}

/// Which of the places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sort {
    Cpu = 0,
    Mesh = 1,
    Condition = 2,
}

impl Places {
    /// So many.
    pub fn new(limits: AtOnce) -> Arc<Self> {
        Arc::new(Self { limits, taken: Mutex::default(), free: Condvar::new() })
    }

    /// How many are taken: to compute, for meshes, for conditions.
    pub fn taken(&self) -> [usize; 3] {
        *self.lock()
    }

    fn lock(&self) -> MutexGuard<'_, [usize; 3]> {
        self.taken.lock().unwrap_or_else(|e| e.into_inner())
    }

    fn limit(&self, sort: Sort) -> usize {
        let AtOnce { cpu, mesh, condition } = self.limits;
        [cpu, mesh, condition][sort as usize].max(1)
    }

    /// Waits for a place; none when everything is to stop.
    fn take(self: &Arc<Self>, sort: Sort, cancel: &Cancel) -> Option<Taken> {
        let mut taken = self.lock();
        loop {
            if cancel.wish() != Wish::Go {
                return None;
            }
            if taken[sort as usize] < self.limit(sort) {
                taken[sort as usize] += 1;
                return Some(Taken { places: Arc::clone(self), sort });
            }
            let waited = self.free.wait_timeout(taken, GLANCE);
            taken = waited.unwrap_or_else(|e| e.into_inner()).0;
        }
    }
}

/// A place that is taken until this is dropped.
struct Taken {
    places: Arc<Places>,
    sort: Sort,
}

impl Drop for Taken {
    fn drop(&mut self) {
        let mut taken = self.places.lock();
        taken[self.sort as usize] = taken[self.sort as usize].saturating_sub(1);
        self.places.free.notify_all();
    }
}

/// The purse of a batch: a call is written into the ledger before it is made.
pub struct Purse {
    budget: Budget,
    spent: Mutex<Spent>,
    run: i64,
    ledger: Arc<Ledger>,
    clock: Arc<dyn Clock>,
}

impl Purse {
    /// A purse out of which the ledger's calls were paid already.
    ///
    /// # Errors
    /// [`super::LedgerError`] when the ledger cannot be read.
    pub fn open(
        budget: Budget,
        run: i64,
        ledger: Arc<Ledger>,
        clock: Arc<dyn Clock>,
    ) -> Result<Arc<Self>, super::LedgerError> {
        let calls = ledger.calls(None)?;
        let all = calls.iter().map(|(_, times)| times).sum();
        let spent = Mutex::new(Spent { calls: all, cost: budget.cost(&calls) });
        Ok(Arc::new(Self { budget, spent, run, ledger, clock }))
    }

    /// What was spent so far.
    pub fn spent(&self) -> Spent {
        *self.spent.lock().unwrap_or_else(|e| e.into_inner())
    }

    fn too_much(&self, spent: &Spent, price: f64) -> Option<String> {
        let calls = self.budget.calls.filter(|most| spent.calls >= *most);
        if let Some(most) = calls {
            return Some(format!("the budget of {most} calls is spent"));
        }
        // A hair of slack: ten times 0.1 is within 1.
        let cost = self.budget.cost.filter(|most| spent.cost + price > most * (1.0 + 1e-9));
        cost.map(|most| format!("the budget of {most} is spent: {:.2} so far", spent.cost))
    }

    fn pay(&self, id: &str, stage: &str) -> Result<(), StageError> {
        let mut spent = self.spent.lock().unwrap_or_else(|e| e.into_inner());
        let price = self.budget.price(stage);
        if let Some(why) = self.too_much(&spent, price) {
            return Err(StageError::new(why).blamed_on(Blame::Budget));
        }
        let noted = self.ledger.call(self.run, id, stage, self.clock.now());
        noted.map_err(|e| StageError::from_error(&e).blamed_on(Blame::House))?;
        spent.calls += 1;
        spent.cost += price;
        Ok(())
    }
}

/// The gate of one item.
pub struct ItemGate {
    /// The item's id.
    pub id: String,
    /// Whether its mesh was given.
    pub mesh_given: bool,
    /// Whether its condition was given.
    pub condition_given: bool,
    /// Where it may work.
    pub places: Arc<Places>,
    /// What its calls are paid from.
    pub purse: Arc<Purse>,
    /// The wish to stop.
    pub cancel: Cancel,
}

impl ItemGate {
    /// The gate of an item.
    pub fn new(item: &Item, places: &Arc<Places>, purse: &Arc<Purse>, cancel: &Cancel) -> Self {
        Self {
            id: item.id.clone(),
            mesh_given: item.mesh.is_some(),
            condition_given: item.condition.is_some(),
            places: Arc::clone(places),
            purse: Arc::clone(purse),
            cancel: cancel.clone(),
        }
    }

    /// Which place a stage needs; a file that is read is no call.
    fn sort(&self, stage: &str) -> Sort {
        match stage {
            GenerateMesh::NAME if !self.mesh_given => Sort::Mesh,
            ProposeCondition::NAME if !self.condition_given => Sort::Condition,
            Criticise::NAME => Sort::Condition,
            _ => Sort::Cpu,
        }
    }
}

impl Gate for ItemGate {
    fn enter(&self, stage: &'static str, _resource: Resource) -> Entry {
        let sort = self.sort(stage);
        let Some(place) = self.places.take(sort, &self.cancel) else { return Entry::Closed };
        let paid = if sort == Sort::Cpu { Ok(()) } else { self.purse.pay(&self.id, stage) };
        match paid {
            Ok(()) => Entry::Open(Box::new(place)),
            Err(error) => Entry::Refused(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use trace::FixedClock;

    use super::*;

    fn purse(budget: Budget) -> Arc<Purse> {
        let ledger = Arc::new(Ledger::passing().unwrap());
        Purse::open(budget, 1, ledger, Arc::new(FixedClock(1))).unwrap()
    }

    fn gate(places: &Arc<Places>, purse: &Arc<Purse>, cancel: &Cancel) -> ItemGate {
        ItemGate::new(&Item { id: "kettle".into(), ..Item::default() }, places, purse, cancel)
    }

    #[test]
    fn no_more_than_the_limit_are_in_at_once() {
        let places = Places::new(AtOnce { cpu: 2, mesh: 1, condition: 1 });
        let (purse, cancel) = (purse(Budget::default()), Cancel::default());
        let (now, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    let Entry::Open(_place) =
                        gate(&places, &purse, &cancel).enter("articulate", Resource::Cpu)
                    else {
                        panic!("kept out")
                    };
                    most.fetch_max(now.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                    std::thread::sleep(Duration::from_millis(5));
                    now.fetch_sub(1, Ordering::SeqCst);
                });
            }
        });
        assert_eq!((most.into_inner(), places.taken()), (2, [0, 0, 0]));
    }

    #[test]
    fn a_call_beyond_the_budget_is_refused_and_costs_nothing() {
        let places = Places::new(AtOnce { cpu: 1, mesh: 1, condition: 1 });
        let budget = Budget { cost: Some(0.5), mesh_price: 0.2, ..Budget::default() };
        let (purse, cancel) = (purse(budget), Cancel::default());
        let gate = gate(&places, &purse, &cancel);
        let enter = || gate.enter("generate-mesh", Resource::Network);
        assert!(matches!(enter(), Entry::Open(_)) && matches!(enter(), Entry::Open(_)));
        let Entry::Refused(error) = enter() else { panic!("it went in") };
        assert_eq!(error.blame, Blame::Budget);
        assert_eq!(error.line(), "the budget of 0.5 is spent: 0.40 so far");
        assert_eq!((purse.spent().calls, places.taken()), (2, [0, 0, 0]));
    }

    #[test]
    fn a_critique_is_a_call_of_whoever_makes_conditions() {
        let places = Places::new(AtOnce { cpu: 1, mesh: 1, condition: 1 });
        let budget = Budget { condition_price: 0.3, ..Budget::default() };
        let (purse, cancel) = (purse(budget), Cancel::default());
        let held = gate(&places, &purse, &cancel).enter("criticise", Resource::Network);
        assert_eq!((places.taken(), purse.spent().cost), ([0, 0, 1], 0.3));
        drop(held);
    }

    #[test]
    fn a_file_that_is_given_is_no_call() {
        let places = Places::new(AtOnce { cpu: 1, mesh: 1, condition: 1 });
        let purse = purse(Budget { calls: Some(0), ..Budget::default() });
        let item = Item { mesh: Some("m.glb".into()), ..Item::default() };
        let gate = ItemGate::new(&item, &places, &purse, &Cancel::default());
        assert!(matches!(gate.enter("generate-mesh", Resource::Network), Entry::Open(_)));
    }

    #[test]
    fn who_waits_when_everything_stops_is_let_go() {
        let places = Places::new(AtOnce { cpu: 1, mesh: 1, condition: 1 });
        let (purse, cancel) = (purse(Budget::default()), Cancel::default());
        let held = gate(&places, &purse, &cancel).enter("articulate", Resource::Cpu);
        cancel.press();
        assert!(matches!(
            gate(&places, &purse, &cancel).enter("articulate", Resource::Cpu),
            Entry::Closed
        ));
        drop(held);
        assert_eq!(places.taken(), [0, 0, 0]);
    }
}
