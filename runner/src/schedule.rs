//! What runs next: plain functions over plain state; time is an argument.
//!
//! ```
//! use std::time::Duration;
//!
//! use runner::schedule::{Schedule, Slot, Status};
//! use runner::{Limits, Patience, Resource};
//!
//! let slot = |inputs| {
//!     let (resource, patience) = (Resource::Cpu, Patience::default());
//!     Slot { inputs, resource, patience, status: Status::Waiting }
//! };
//! let mut schedule = Schedule::new(vec![slot(vec![]), slot(vec![0])], Limits::default());
//! assert_eq!(schedule.startable(Duration::ZERO), [0]);
//! schedule.start(0);
//! schedule.done(0);
//! assert_eq!(schedule.startable(Duration::ZERO), [1]);
//! ```

use std::time::Duration;

use super::failure::Again;
use super::needs::{Patience, Resource};

/// Most stages at once, per resource.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Stages that compute. One by default: each uses all processors by itself.
    pub cpu: usize,
    /// Stages that wait for a service.
    pub network: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { cpu: 1, network: 4 }
    }
}

/// Where a node stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// For its inputs, or for a free resource.
    Waiting,
    /// Since a moment, in its n-th attempt.
    Running {
        /// Counted from 1.
        attempt: u32,
        /// Since when.
        since: Duration,
    },
    /// Failed its n-th attempt, tries again at a moment.
    Resting {
        /// The attempt that failed.
        attempt: u32,
        /// When to try again.
        until: Duration,
    },
    /// Its artefact is in the store.
    Done,
    /// It gave up.
    Failed,
}

/// What follows from a failed attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum After {
    /// Another attempt, after a pause.
    Retry(Duration),
    /// Nothing: the stage has failed.
    GaveUp,
}

/// A node as the schedule sees it.
#[derive(Clone, Debug)]
pub struct Slot {
    /// The nodes it needs.
    pub inputs: Vec<usize>,
    /// What it occupies.
    pub resource: Resource,
    /// How long and how often it may try.
    pub patience: Patience,
    /// Where it stands.
    pub status: Status,
}

/// Who waits, runs and is done. Times are since the start of the run.
#[derive(Clone, Debug)]
pub struct Schedule {
    slots: Vec<Slot>,
    limits: Limits,
}

impl Schedule {
    /// A schedule of these nodes.
    pub fn new(slots: Vec<Slot>, limits: Limits) -> Self {
        Self { slots, limits }
    }

    /// Where a node stands; a node that is not there counts as failed.
    pub fn status(&self, node: usize) -> Status {
        self.slots.get(node).map_or(Status::Failed, |s| s.status)
    }

    /// Nodes whose inputs are done and that wait for their first attempt, in graph order.
    pub fn ready(&self) -> Vec<usize> {
        let fresh = |n: &usize| self.status(*n) == Status::Waiting && self.inputs_done(*n);
        (0..self.slots.len()).filter(fresh).collect()
    }

    /// Nodes that may start an attempt now, in graph order, within the limits.
    pub fn startable(&self, now: Duration) -> Vec<usize> {
        let free = |resource| self.limit(resource).saturating_sub(self.running_on(resource));
        let (mut cpu, mut network) = (free(Resource::Cpu), free(Resource::Network));
        let mut chosen = Vec::new();
        for (n, slot) in self.slots.iter().enumerate() {
            let due = match slot.status {
                Status::Waiting => self.inputs_done(n),
                Status::Resting { until, .. } => until <= now,
                _ => false,
            };
            let left = if slot.resource == Resource::Cpu { &mut cpu } else { &mut network };
            if due && *left > 0 {
                *left -= 1;
                chosen.push(n);
            }
        }
        chosen
    }

    fn inputs_done(&self, node: usize) -> bool {
        let slot = self.slots.get(node);
        slot.is_some_and(|s| s.inputs.iter().all(|&i| self.status(i) == Status::Done))
    }

    fn limit(&self, resource: Resource) -> usize {
        match resource {
            Resource::Cpu => self.limits.cpu.max(1),
            Resource::Network => self.limits.network.max(1),
        }
    }

    fn running_on(&self, resource: Resource) -> usize {
        let runs = |s: &&Slot| matches!(s.status, Status::Running { .. }) && s.resource == resource;
        self.slots.iter().filter(runs).count()
    }

    /// Begins an attempt, whose time counts once it has its place; returns its number.
    pub fn start(&mut self, node: usize) -> u32 {
        let attempt = match self.status(node) {
            Status::Resting { attempt, .. } => attempt + 1,
            _ => 1,
        };
        self.set(node, Status::Running { attempt, since: Duration::MAX });
        attempt
    }

    /// An attempt got its place: its time counts from now.
    pub fn begun(&mut self, node: usize, now: Duration) {
        if let Status::Running { attempt, .. } = self.status(node) {
            self.set(node, Status::Running { attempt, since: now });
        }
    }

    /// An attempt never began: the node waits again.
    pub fn put_back(&mut self, node: usize) {
        self.set(node, Status::Waiting);
    }

    /// A node's artefact is there.
    pub fn done(&mut self, node: usize) {
        self.set(node, Status::Done);
    }

    /// A node can never be done.
    pub fn give_up(&mut self, node: usize) {
        self.set(node, Status::Failed);
    }

    /// An attempt failed.
    pub fn failed(&mut self, node: usize, again: Again, now: Duration) -> After {
        let (Some(slot), Again::Later(asked)) = (self.slots.get_mut(node), again) else {
            self.give_up(node);
            return After::GaveUp;
        };
        let Status::Running { attempt, .. } = slot.status else { return After::GaveUp };
        if attempt >= slot.patience.attempts {
            slot.status = Status::Failed;
            return After::GaveUp;
        }
        let doubled = slot.patience.pause.saturating_mul(1 << (attempt - 1).min(10));
        let pause = asked.unwrap_or_default().max(doubled);
        slot.status = Status::Resting { attempt, until: now + pause };
        After::Retry(pause)
    }

    /// Nodes whose attempt takes longer than it may.
    pub fn overdue(&self, now: Duration) -> Vec<usize> {
        let late = |s: &Slot| matches!(s.status, Status::Running { since, .. } if now.saturating_sub(since) > s.patience.timeout);
        (0..self.slots.len()).filter(|&n| self.slots.get(n).is_some_and(late)).collect()
    }

    /// Whether an attempt is under way.
    pub fn is_running(&self) -> bool {
        self.slots.iter().any(|s| matches!(s.status, Status::Running { .. }))
    }

    /// Whether a node will try again later.
    pub fn is_resting(&self) -> bool {
        self.slots.iter().any(|s| matches!(s.status, Status::Resting { .. }))
    }

    fn set(&mut self, node: usize, status: Status) {
        if let Some(slot) = self.slots.get_mut(node) {
            slot.status = status;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn s(n: u64) -> Duration {
        Duration::from_secs(n)
    }

    fn slot(inputs: &[usize], resource: Resource) -> Slot {
        let patience = Patience { timeout: s(10), attempts: 3, pause: s(1) };
        Slot { inputs: inputs.to_vec(), resource, patience, status: Status::Waiting }
    }

    /// 0 → 1, 2, 3 (network) and 4, 5 (cpu).
    fn fan(limits: Limits) -> Schedule {
        use Resource::{Cpu, Network};
        let mut slots = vec![slot(&[], Cpu)];
        slots.extend([Network, Network, Network, Cpu, Cpu].map(|r| slot(&[0], r)));
        Schedule::new(slots, limits)
    }

    #[test]
    fn a_node_starts_when_its_inputs_are_done_and_never_above_the_limit() {
        let mut plan = fan(Limits { cpu: 1, network: 2 });
        assert_eq!(plan.startable(s(0)), [0]);
        plan.start(0);
        assert!(plan.startable(s(0)).is_empty());
        plan.done(0);
        assert_eq!(plan.startable(s(1)), [1, 2, 4]);
        for n in [1, 2, 4] {
            assert_eq!(plan.start(n), 1);
        }
        assert!(plan.startable(s(1)).is_empty());
        plan.done(2);
        assert_eq!(plan.startable(s(2)), [3]);
    }

    #[test]
    fn a_passing_trouble_is_tried_again_with_doubled_pauses_and_then_given_up() {
        let mut plan = fan(Limits::default());
        plan.start(0);
        assert_eq!(plan.failed(0, Again::Later(None), s(5)), After::Retry(s(1)));
        assert!(plan.startable(s(5)).is_empty() && plan.is_resting());
        assert_eq!(plan.startable(s(6)), [0]);
        assert_eq!(plan.start(0), 2);
        assert_eq!(plan.failed(0, Again::Later(Some(s(7))), s(6)), After::Retry(s(7)));
        assert_eq!(plan.start(0), 3);
        assert_eq!(plan.failed(0, Again::Later(None), s(13)), After::GaveUp);
        assert_eq!(plan.status(0), Status::Failed);
        assert!(plan.startable(s(99)).is_empty(), "nothing downstream of a failure runs");
    }

    #[test]
    fn a_lasting_trouble_is_given_up_at_once_and_a_late_attempt_is_noticed() {
        let mut plan = fan(Limits::default());
        plan.start(0);
        assert!(plan.overdue(s(99)).is_empty(), "waiting for a place is not being late");
        plan.begun(0, s(0));
        assert!(plan.overdue(s(10)).is_empty());
        assert_eq!(plan.overdue(s(11)), [0]);
        assert_eq!(plan.failed(0, Again::Never, s(11)), After::GaveUp);
        assert!(!plan.is_running());
    }
}
