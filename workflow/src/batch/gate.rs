//! Places of a batch: how many stages run at once on each resource.

use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::time::Duration;

use runner::{Cancel, Entry, Gate, Resource, Stage as _, Wish};

use super::manifest::Item;
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

/// The gate of one item.
pub struct ItemGate {
    /// Whether its mesh was given.
    pub mesh_given: bool,
    /// Whether its condition was given.
    pub condition_given: bool,
    /// Where it may work.
    pub places: Arc<Places>,
    /// The wish to stop.
    pub cancel: Cancel,
}

impl ItemGate {
    /// The gate of an item.
    pub fn new(item: &Item, places: &Arc<Places>, cancel: &Cancel) -> Self {
        Self {
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
        let sort = self.sort(stage);
        match self.places.take(sort, &self.cancel) {
            Some(place) => Entry::Open(Box::new(place)),
            None => Entry::Closed,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    fn gate(places: &Arc<Places>, cancel: &Cancel) -> ItemGate {
        ItemGate::new(&Item { id: "kettle".into(), ..Item::default() }, places, cancel)
    }

    #[test]
    fn no_more_than_the_limit_are_in_at_once() {
        let places = Places::new(AtOnce { cpu: 2, mesh: 1, condition: 1 });
        let cancel = Cancel::default();
        let (now, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    let Entry::Open(_place) =
                        gate(&places, &cancel).enter("articulate", Resource::Cpu)
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
    fn a_critique_takes_the_place_of_a_condition_and_a_file_none_of_them() {
        let places = Places::new(AtOnce { cpu: 1, mesh: 1, condition: 1 });
        let cancel = Cancel::default();
        let held = gate(&places, &cancel).enter("criticise", Resource::Network);
        assert_eq!(places.taken(), [0, 0, 1]);
        drop(held);
        let item = Item { mesh: Some("m.glb".into()), ..Item::default() };
        let gate = ItemGate::new(&item, &places, &cancel);
        let held = gate.enter("generate-mesh", Resource::Network);
        assert_eq!(places.taken(), [1, 0, 0]);
        drop(held);
    }

    #[test]
    fn who_waits_when_everything_stops_is_let_go() {
        let places = Places::new(AtOnce { cpu: 1, mesh: 1, condition: 1 });
        let cancel = Cancel::default();
        let held = gate(&places, &cancel).enter("articulate", Resource::Cpu);
        cancel.press();
        assert!(matches!(gate(&places, &cancel).enter("articulate", Resource::Cpu), Entry::Closed));
        drop(held);
        assert_eq!(places.taken(), [0, 0, 0]);
    }
}
