//! What a batch would do and ask for, without doing any of it.

use trace::Digest;

use super::error::BatchError;
use super::ledger::{self, Ledger, Settled};
use super::plan::{Share, plan};
use super::run::{Order, TOLD};

/// Items that are looked up at once.
const AT_ONCE: u32 = 1000;

/// What a batch would do.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Estimate {
    /// Items of the manifest.
    pub items: u64,
    /// Lines that are no items.
    pub bad_lines: u64,
    /// The first of them, each with the reason.
    pub told: Vec<(u64, String)>,
    /// Items that have an outcome.
    pub settled: u64,
    /// Items that have none.
    pub todo: u64,
    /// Meshes that may have to be asked for.
    pub meshes: u64,
    /// Conditions that may have to be asked for.
    pub conditions: u64,
    /// Critiques that may have to be asked for.
    pub critiques: u64,
    /// Requests that those take at least; repairs and repeats come on top.
    pub requests: u64,
    /// What that costs at the prices given, without repairs and repeats.
    pub cost: f64,
    /// Time to compute, from the items made so far, seconds.
    pub seconds: Option<f64>,
}

/// Reads the manifest and looks up which items have an outcome. Changes nothing.
///
/// # Errors
/// [`BatchError`] when manifest or ledger cannot be read.
pub fn estimate(order: &Order, share: Share) -> Result<Estimate, BatchError> {
    let passing = Ledger::passing()?;
    let plan = plan(&order.manifest, share, &passing)?.number;
    let settings = Digest::of(order.settings.words().as_bytes());
    let known = Ledger::open_to_read(&order.out.join(ledger::FILE))?;
    let standing = passing.standing(plan, &settings)?;
    let (items, bad_lines) = (standing.planned, standing.bad);
    let told = passing.bad_lines(plan, TOLD)?;
    let mut estimate = Estimate { items, bad_lines, told, ..Estimate::default() };
    let everything = Settled { plan, settings: Some(&settings), again: &[], run: 0 };
    let mut after = 0;
    loop {
        let page = passing.pending(&everything, after, AT_ONCE)?;
        let Some(last) = page.last() else { break };
        after = last.n;
        for planned in &page {
            let is_settled = match &known {
                Some(ledger) => ledger.is_settled(planned, &settings, &order.retry)?,
                None => false,
            };
            if is_settled {
                estimate.settled += 1;
                continue;
            }
            estimate.todo += 1;
            estimate.meshes += u64::from(planned.item.mesh.is_none());
            estimate.conditions += u64::from(planned.item.condition.is_none());
        }
    }
    if order.settings.critic.is_some() {
        estimate.critiques = estimate.conditions;
    }
    // A condition is three questions; a mesh and a critique are one each.
    estimate.requests = estimate.meshes + 3 * estimate.conditions + estimate.critiques;
    let prices = order.allowance.prices;
    estimate.cost = prices.mesh * estimate.meshes as f64
        + prices.condition * (estimate.conditions + estimate.critiques) as f64;
    let each = known.map_or(Ok(None), |ledger| ledger.mean_seconds())?;
    estimate.seconds = each.map(|s| s * estimate.todo as f64);
    Ok(estimate)
}
