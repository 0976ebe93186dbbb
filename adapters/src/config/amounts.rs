//! Budgets and prices that are amounts: a budget that is not a number would be one without limit.

use super::Config;
use crate::budget::Price;

/// The first amount of a configuration that is none, by the name of its field: not a number, without end,
/// or below zero.
pub(super) fn senseless(config: &Config) -> Option<&'static str> {
    let (budget, manners) = (&config.budget, &config.manners);
    let lost = budget.lost.unwrap_or_default();
    let prices = |price: Option<Price>| {
        price.map_or(vec![], |p| vec![p.call, p.credit, p.million_input, p.million_output])
    };
    let all = [
        ("budget.credits", budget.credits.into_iter().collect()),
        ("budget.money", budget.money.into_iter().collect()),
        ("budget.lost.credits", lost.credits.into_iter().collect()),
        ("budget.lost.money", lost.money.into_iter().collect()),
        ("manners.image_to_3d.price", prices(manners.image_to_3d.price)),
        ("manners.vlm.price", prices(manners.vlm.price)),
    ];
    let is_amount = |amount: &f64| amount.is_finite() && *amount >= 0.0;
    let wrong = |(_, amounts): &(&str, Vec<f64>)| !amounts.iter().all(is_amount);
    all.into_iter().find(wrong).map(|(name, _)| name)
}
