//! Ensembles of boosted trees that say which neighbouring segments are of one part, and which part each
//! segment is of.
//!
//! Every other draw of an object has its points in the middle of parts, the others anywhere on them; so
//! often more it is drawn cut up ([`crate::dataset::cut`]), if it is not fused. Three of each of our own
//! families, made from another seed and learned from by nothing, are asked about beside validation: what
//! families teach does not show on shards. Fused, objects are seen as each of the recipes says instead of
//! as they are; posed, every part is either at rest or anywhere in its range. Half the weight of an object
//! goes to its segments by the root of their area, half to its parts alike: small segments astray make
//! large boxes, and small parts count.

mod case;
mod ensemble;
mod grow;
mod iou;
mod measure;

pub(super) use case::{Draw, prompted};
pub use ensemble::Ensemble;

use model::classic::learned::pack;
use model::classic::learned::pack::{Head, Origin, Pack, Section, Table};
use model::classic::segment::classify::{
    KIND, PAIRWISE, ROUNDS, UNARY, pairwise_names, unary_names,
};
use serde::Deserialize;

use super::data::{Split, of_families};
use super::recipe::{Families, Model, counted};
use super::{Bench, FitError, Fits, Fitted};
use case::{Case, Seen};

/// A seed that nothing else is made with.
const FAMILY_SEED: u64 = 51;
/// The seed of those that ensembles are judged by, and how often each family is among them.
const JUDGED: (u64, usize) = (54, 3);

/// How segments are fitted: the table `model` of a recipe.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Segments {
    /// How often every segment is asked about; an ensemble of fewer rounds answers its last one again.
    pub rounds: usize,
    /// The ensembles, in the order in which they are asked.
    #[serde(rename = "ensemble")]
    pub ensembles: Vec<Ensemble>,
}

impl Model for Segments {
    fn families(&self) -> Vec<&Families> {
        self.ensembles.iter().map(|e| &e.families).collect()
    }

    fn check(&self) -> Result<(), String> {
        counted("model.rounds", self.rounds, [1, 16])?;
        counted("model.ensemble", self.ensembles.len(), [1, 16])?;
        let one = |(i, ensemble): (usize, &Ensemble)| {
            ensemble.check().map_err(|what| format!("model.ensemble, number {}: {what}", i + 1))
        };
        self.ensembles.iter().enumerate().try_for_each(one)
    }
}

impl Fits for Segments {
    const READS: &'static [&'static str] = &["contacts", "sizes", "roles", "fused_unary"];

    fn fitted(&self, bench: &Bench<'_>) -> Result<Fitted, FitError> {
        let mut fitted = Fitted::of(KIND, tables());
        fitted.settings.insert(ROUNDS.into(), self.rounds as f64);
        for ensemble in &self.ensembles {
            let bytes = whole_or_fitted(ensemble, bench)?;
            let kept = Pack::open("kept", &bytes).map_err(|e| FitError::Broken(e.to_string()))?;
            let first = fitted.ensembles.len();
            let mut content = kept.content();
            for section in &kept.head.sections {
                let (own, rest) = content.split_at(section.bytes as usize);
                content = rest;
                let name = renamed(&section.name, first);
                fitted.sections.push((Section { name, ..section.clone() }, own.to_vec()));
            }
            for (name, value) in &kept.head.origin.metrics {
                fitted.metrics.insert(renamed(name, first), *value);
            }
            fitted.ensembles.extend(&kept.head.ensembles);
        }
        Ok(fitted)
    }
}

fn tables() -> Vec<Table> {
    vec![Table::new(PAIRWISE, pairwise_names()), Table::new(UNARY, unary_names())]
}

/// A name that begins with the number of an ensemble, where so many come before.
fn renamed(name: &str, before: usize) -> String {
    let moved = || {
        let (number, rest) = name.strip_prefix("ensemble ")?.split_once(',')?;
        Some(format!("ensemble {},{rest}", number.parse::<usize>().ok()? + before))
    };
    moved().unwrap_or_else(|| name.to_owned())
}

/// An ensemble as a pack of its own, fitted or taken over.
fn whole_or_fitted(ensemble: &Ensemble, bench: &Bench<'_>) -> Result<Vec<u8>, FitError> {
    let inputs = bench.inputs(&format!("{ensemble:?}"));
    if let Some(bytes) = bench.kept.find("ensemble", &inputs) {
        bench.watcher.say("an ensemble is taken over whole");
        return Ok(bytes);
    }
    let train = read(ensemble, bench)?;
    let judged = judged(ensemble, bench)?;
    let grown = grow::grown((train, judged), ensemble, bench)?;
    let origin = Origin { metrics: grown.metrics, ..Origin::default() };
    let mut head = Head::new(KIND, tables(), origin);
    let folds = ensemble.folds / ensemble.split;
    head.ensembles = vec![pack::Ensemble { folds, rounds: ensemble.rounds }; ensemble.split];
    let bytes = pack::write(head, grown.sections)?;
    bench.kept.keep("ensemble", &inputs, &bytes)?;
    Ok(bytes)
}

/// What is learned from.
fn read(ensemble: &Ensemble, bench: &Bench<'_>) -> Result<Vec<Case>, FitError> {
    let seen = |draws| Seen { ensemble, draws, is_judged: false, watcher: bench.watcher };
    let shards = seen(ensemble.draws);
    let most = ensemble.objects;
    let mut train = bench.data.of_shards(Split::Train, most, |s| shards.cases(&s.specimen))?;
    let own = seen(ensemble.own_draws.unwrap_or(ensemble.draws));
    train.extend(of_families(&ensemble.families, FAMILY_SEED, |s| own.cases(&s.specimen))?);
    if train.is_empty() { Err(FitError::Nothing("segments")) } else { Ok(train) }
}

/// What the ensemble is judged by, and what that is called.
fn judged(
    ensemble: &Ensemble,
    bench: &Bench<'_>,
) -> Result<Vec<(&'static str, Vec<Case>)>, FitError> {
    let bare = Ensemble { cut: 0, ..ensemble.clone() };
    let seen = Seen { ensemble: &bare, draws: 2, is_judged: true, watcher: bench.watcher };
    let objects = ensemble.objects;
    let validation =
        bench.data.of_shards(Split::Validation, objects, |s| seen.cases(&s.specimen))?;
    let (seed, each) = JUDGED;
    let all = Families { each: each.min(ensemble.families.each), ..ensemble.families.clone() };
    let own = of_families(&all, seed, |s| seen.cases(&s.specimen))?;
    let judged = [("validation", validation), ("own families", own)];
    for (what, cases) in &judged {
        measure::report(bench.watcher, &format!("by merging, {what}"), cases, |c| c.merged);
        let best = |c: &Case| measure::iou_of(c, &c.truth());
        measure::report(bench.watcher, &format!("every segment right, {what}"), cases, best);
    }
    Ok(judged.into_iter().filter(|(_, cases)| !cases.is_empty()).collect())
}
