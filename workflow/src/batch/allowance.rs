//! What a batch may spend over all its runs, and what its requests cost.
//!
//! The budget of `kinfold.toml` holds besides, and wherever else its state directory is used; the
//! account of each service keeps it. Whichever is spent first ends the asking.

use adapters::book::COMMAND;
use adapters::budget::Budget;
use runner::Stage as _;

use super::ledger::Sent;
use crate::stages::{Criticise, GenerateMesh, ProposeCondition};

/// Questions of which a condition is made, where no answer has to be repaired.
const QUESTIONS: f64 = 3.0;

/// What may be spent, over all runs of a batch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Allowance {
    /// The most: requests that may cost, repairs and repeats included, and money. Tokens and credits
    /// are for services' accounts to count.
    pub most: Budget,
    /// What requests cost.
    pub prices: Prices,
}

/// What a result costs, in any currency, the same for every limit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Prices {
    /// A mesh.
    pub mesh: f64,
    /// A condition; a critique costs as much.
    pub condition: f64,
}

impl Allowance {
    /// At most so many requests and so much money, where they are limited, at these prices.
    pub fn new(calls: Option<u64>, money: Option<f64>, prices: Prices) -> Self {
        Self { most: Budget { calls, money, ..Budget::default() }, prices }
    }

    /// Whether there is anything to keep.
    pub fn is_limited(&self) -> bool {
        self.most.calls.is_some() || self.most.money.is_some()
    }

    /// What one request costs: a third of a condition for each of its questions, so that repairs and
    /// repeats count; a whole mesh for its submit or its program.
    pub fn price(&self, step: &str) -> f64 {
        match stage(step) {
            Criticise::NAME => self.prices.condition,
            ProposeCondition::NAME => self.prices.condition / QUESTIONS,
            _ if step == COMMAND || step.ends_with(".submit") => self.prices.mesh,
            _ => 0.0,
        }
    }

    /// What some stages' requests cost; one of kinfold 0.1.0 stands for all of a stage's.
    pub fn cost(&self, sent: &[Sent]) -> f64 {
        let old_price = |stage: &str| match stage {
            GenerateMesh::NAME => self.prices.mesh,
            ProposeCondition::NAME | Criticise::NAME => self.prices.condition,
            _ => 0.0,
        };
        sent.iter().fold(0.0, |sum, s| sum + s.cost + old_price(&s.stage) * s.old as f64)
    }
}

/// The stage that a request is sent for.
pub(super) fn stage(step: &str) -> &'static str {
    match step {
        step if step.starts_with("vlm.critic/") => Criticise::NAME,
        step if step.starts_with("vlm.") => ProposeCondition::NAME,
        _ => GenerateMesh::NAME,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_condition_costs_its_price_repairs_cost_more_and_a_critique_as_much() {
        let allowance = Allowance::new(None, None, Prices { mesh: 1.0, condition: 0.3 });
        let price = |step| (allowance.price(step) * 1e6_f64).round() / 1e6;
        let steps = ["vlm.kinematics/0", "vlm.points/0", "vlm.points/1", "vlm.physical/0"];
        assert_eq!(steps.map(price), [0.1; 4]);
        assert_eq!(price("vlm.critic/0"), 0.3);
        assert_eq!([COMMAND, "fal.submit", "gradio.call"].map(price), [1.0, 1.0, 0.0]);
    }
}
