//! Places of a batch: how many stages run at once on each resource, and how many items that ask nobody.
//!
//! A free place goes to the oldest item that waits for one. An item that asks no service begins only when it
//! may compute to its end. So the first outcomes come early, and few meshes are in memory. No item waits
//! for a place that another keeps from stage to stage: of items with the same stage, one may run it for all.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::time::Duration;

use runner::{Cancel, Entry, Gate, Resource, Stage as _, Wish};

use super::manifest::Item;
use crate::stages::{Criticise, GenerateMesh, ProposeCondition};

/// How often the wish to stop is looked at while waiting.
const GLANCE: Duration = Duration::from_millis(50);

/// Most of each kind at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AtOnce {
    /// Stages that compute, and items that do nothing else.
    pub cpu: usize,
    /// Calls of whoever makes meshes.
    pub mesh: usize,
    /// Calls of whoever makes conditions.
    pub condition: usize,
}

/// The places of a batch, shared by all its items.
pub struct Places {
    limits: AtOnce,
    desk: Mutex<Desk>,
    free: Condvar,
}

/// Who works and who waits.
#[derive(Default)]
struct Desk {
    taken: [usize; SORTS],
    /// Who waits for each sort of place: the item, the oldest first, and the order of coming, since several
    /// stages of an item may wait.
    waiting: [BTreeSet<(i64, u64)>; SORTS],
    /// How many have come.
    come: u64,
    /// The stage that each item began last, by the item's place in the plan.
    stages: BTreeMap<i64, (String, &'static str)>,
}

/// Which of the places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sort {
    Cpu = 0,
    Mesh = 1,
    Condition = 2,
    /// From an item's first stage to its last.
    Item = 3,
}

/// How many sorts of places there are.
const SORTS: usize = 4;

impl Places {
    /// So many.
    pub fn new(limits: AtOnce) -> Arc<Self> {
        Arc::new(Self { limits, desk: Mutex::default(), free: Condvar::new() })
    }

    /// How many are taken: to compute, for meshes, for conditions.
    pub fn taken(&self) -> [usize; 3] {
        let [cpu, mesh, condition, _] = self.desk().taken;
        [cpu, mesh, condition]
    }

    /// The items that have a place, oldest first, each with its id and its stage.
    pub fn at_work(&self) -> Vec<(String, &'static str)> {
        self.desk().stages.values().cloned().collect()
    }

    fn desk(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(|e| e.into_inner())
    }

    fn limit(&self, sort: Sort) -> usize {
        let AtOnce { cpu, mesh, condition } = self.limits;
        [cpu, mesh, condition, cpu][sort as usize].max(1)
    }

    /// Waits until an item that asks nobody may begin; none when everything is to stop.
    pub fn begin(self: &Arc<Self>, n: i64, cancel: &Cancel) -> Option<Taken> {
        self.take(Sort::Item, n, cancel)
    }

    /// Waits until a place is free and no older item waits for one; none when everything is to stop.
    fn take(self: &Arc<Self>, sort: Sort, n: i64, cancel: &Cancel) -> Option<Taken> {
        let mut desk = self.desk();
        let own = (n, desk.come);
        desk.come += 1;
        desk.waiting[sort as usize].insert(own);
        let is_open = loop {
            if cancel.wish() != Wish::Go {
                break false;
            }
            let is_next = desk.waiting[sort as usize].first() == Some(&own);
            if is_next && desk.taken[sort as usize] < self.limit(sort) {
                break true;
            }
            let waited = self.free.wait_timeout(desk, GLANCE);
            desk = waited.unwrap_or_else(|e| e.into_inner()).0;
        };
        desk.waiting[sort as usize].remove(&own);
        desk.taken[sort as usize] += usize::from(is_open);
        // Whoever is next may find another place free.
        self.free.notify_all();
        is_open.then(|| Taken { places: Arc::clone(self), sort })
    }
}

/// A place that is taken until this is dropped.
pub struct Taken {
    places: Arc<Places>,
    sort: Sort,
}

impl Drop for Taken {
    fn drop(&mut self) {
        let mut desk = self.places.desk();
        desk.taken[self.sort as usize] = desk.taken[self.sort as usize].saturating_sub(1);
        self.places.free.notify_all();
    }
}

/// The gate of one item.
pub struct ItemGate {
    /// The item's place in the plan: the smallest is the oldest.
    n: i64,
    id: String,
    mesh_given: bool,
    condition_given: bool,
    places: Arc<Places>,
    cancel: Cancel,
}

impl ItemGate {
    /// The gate of an item at some place of the plan.
    pub fn new((n, item): (i64, &Item), places: &Arc<Places>, cancel: &Cancel) -> Self {
        Self {
            n,
            id: item.id.clone(),
            mesh_given: item.mesh.is_some(),
            condition_given: item.condition.is_some(),
            places: Arc::clone(places),
            cancel: cancel.clone(),
        }
    }

    /// Which place a stage needs; a file that is read asks nobody.
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
        let taken = self.places.take(self.sort(stage), self.n, &self.cancel);
        let Some(place) = taken else { return Entry::Closed };
        self.places.desk().stages.insert(self.n, (self.id.clone(), stage));
        Entry::Open(Box::new(place))
    }
}

impl Drop for ItemGate {
    fn drop(&mut self) {
        self.places.desk().stages.remove(&self.n);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::mpsc;

    use runner::Place;

    use super::*;

    fn gate(n: i64, places: &Arc<Places>, cancel: &Cancel) -> ItemGate {
        ItemGate::new((n, &Item { id: format!("kettle-{n}"), ..Item::default() }), places, cancel)
    }

    fn open(gate: &ItemGate, stage: &'static str) -> Place {
        let Entry::Open(place) = gate.enter(stage, Resource::Cpu) else { panic!("kept out") };
        place
    }

    #[test]
    fn no_more_than_the_limit_are_in_at_once() {
        let places = Places::new(AtOnce { cpu: 2, mesh: 1, condition: 1 });
        let cancel = Cancel::default();
        let (now, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
        std::thread::scope(|scope| {
            for n in 0..8 {
                let (places, cancel, now, most) = (&places, &cancel, &now, &most);
                scope.spawn(move || {
                    let gate = gate(n, places, cancel);
                    let _place = open(&gate, "articulate");
                    most.fetch_max(now.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                    std::thread::sleep(Duration::from_millis(5));
                    now.fetch_sub(1, Ordering::SeqCst);
                });
            }
        });
        assert_eq!((most.into_inner(), places.taken()), (2, [0, 0, 0]));
        assert_eq!(places.at_work(), []);
    }

    #[test]
    fn a_free_place_goes_to_the_oldest_item_that_waits() {
        let places = Places::new(AtOnce { cpu: 1, mesh: 1, condition: 1 });
        let cancel = Cancel::default();
        let first = gate(0, &places, &cancel);
        let held = open(&first, "articulate");
        let (told, order) = mpsc::channel();
        std::thread::scope(|scope| {
            for n in [3, 1, 2] {
                let (places, cancel, told) = (&places, &cancel, told.clone());
                scope.spawn(move || {
                    let gate = gate(n, places, cancel);
                    let _place = open(&gate, "articulate");
                    told.send(n).unwrap();
                });
            }
            while places.desk().waiting[Sort::Cpu as usize].len() < 3 {
                std::thread::yield_now();
            }
            drop((held, first));
        });
        drop(told);
        assert_eq!(order.iter().collect::<Vec<_>>(), [1, 2, 3]);
    }

    #[test]
    fn of_several_stages_of_one_item_that_wait_every_one_gets_its_turn() {
        let places = Places::new(AtOnce { cpu: 1, mesh: 1, condition: 1 });
        let cancel = Cancel::default();
        let item = gate(0, &places, &cancel);
        let held = open(&item, "articulate");
        std::thread::scope(|scope| {
            for stage in ["write-urdf", "write-page", "write-pictures"] {
                let item = &item;
                scope.spawn(move || drop(open(item, stage)));
            }
            while places.desk().waiting[Sort::Cpu as usize].len() < 3 {
                std::thread::yield_now();
            }
            drop(held);
        });
        assert_eq!(places.taken(), [0, 0, 0]);
    }

    #[test]
    fn a_place_is_given_back_with_its_stage_and_items_that_ask_nobody_begin_one_by_one() {
        let places = Places::new(AtOnce { cpu: 1, mesh: 1, condition: 1 });
        let cancel = Cancel::default();
        let item = gate(0, &places, &cancel);
        drop(open(&item, "render-views"));
        assert_eq!(places.taken(), [0, 0, 0]);
        let asked = open(&item, "propose-condition");
        assert_eq!(places.taken(), [0, 0, 1]);
        assert_eq!(places.at_work(), [("kettle-0".into(), "propose-condition")]);
        drop(asked);
        let begun = places.begin(0, &cancel).unwrap();
        let (told, order) = mpsc::channel();
        std::thread::scope(|scope| {
            for n in [2, 1] {
                let (places, cancel, told) = (&places, &cancel, told.clone());
                scope.spawn(move || {
                    let _begun = places.begin(n, cancel).unwrap();
                    told.send(n).unwrap();
                });
            }
            while places.desk().waiting[Sort::Item as usize].len() < 2 {
                std::thread::yield_now();
            }
            // Whoever has begun still finds a place for a stage.
            drop(open(&item, "articulate"));
            drop(begun);
        });
        drop(told);
        assert_eq!(order.iter().collect::<Vec<_>>(), [1, 2]);
    }

    #[test]
    fn a_critique_takes_the_place_of_a_condition_and_a_file_none_of_them() {
        let places = Places::new(AtOnce { cpu: 1, mesh: 1, condition: 1 });
        let cancel = Cancel::default();
        let held = gate(0, &places, &cancel).enter("criticise", Resource::Network);
        assert_eq!(places.taken(), [0, 0, 1]);
        drop(held);
        let item = Item { mesh: Some("m.glb".into()), ..Item::default() };
        let gate = ItemGate::new((1, &item), &places, &cancel);
        let held = gate.enter("generate-mesh", Resource::Network);
        assert_eq!(places.taken(), [1, 0, 0]);
        drop((held, gate));
        assert_eq!(places.taken(), [0, 0, 0]);
    }

    #[test]
    fn who_waits_when_everything_stops_is_let_go() {
        let places = Places::new(AtOnce { cpu: 1, mesh: 1, condition: 1 });
        let cancel = Cancel::default();
        let item = gate(0, &places, &cancel);
        let held = open(&item, "articulate");
        cancel.press();
        let late = gate(1, &places, &cancel).enter("articulate", Resource::Cpu);
        assert!(matches!(late, Entry::Closed));
        drop((held, item));
        assert_eq!(places.taken(), [0, 0, 0]);
    }
}
