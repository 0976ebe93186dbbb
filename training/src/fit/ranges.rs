//! How far a joint goes: boosted trees, for turns and for slides.
//!
//! Every joint with limits is asked about with its true axis, on the object as it is and, where a recipe
//! says how, fused.

mod end;

use model::classic::joints::axis_model::{JOINTS, forest_section};
use model::classic::joints::range_model::{FOLDS, INPUTS, KIND, TABLE, likeliest, names};
use model::classic::learned::forest::{Forest, mean_chances};
use model::classic::learned::pack::{Ensemble, Form, Section, Table};
use serde::Deserialize;

use super::data::{Split, of_families};
use super::recipe::{Families, Model};
use super::{Bench, FitError, Fits, Fitted};
use crate::forest::{Bins, Growth, Lessons};
use crate::fuse;
use end::{End, seen};

/// A seed that nothing else is made with.
const FAMILY_SEED: u64 = 53;
/// Bins are chosen by every so many ends.
const SAMPLED: usize = 4;
/// Ends are right if they are off by at most this, and roughly right by this.
const OFF: [f64; 3] = [0.05, 0.1, 0.3];

/// How ranges are fitted: the table `model` of a recipe.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ranges {
    /// At most so many objects of the shards; all where it is not given.
    #[serde(default)]
    pub objects: Option<usize>,
    /// How objects are fused; they are not where it is not given.
    #[serde(default)]
    pub fused: Option<fuse::Recipe>,
    /// Objects of our own families.
    #[serde(default)]
    pub families: Families,
    /// How trees grow.
    pub growth: Growth,
}

impl Model for Ranges {
    fn families(&self) -> Vec<&Families> {
        vec![&self.families]
    }

    fn check(&self) -> Result<(), String> {
        self.growth.check().map_err(|what| format!("model.growth: {what}"))
    }
}

impl Fits for Ranges {
    const READS: &'static [&'static str] = &[];

    fn fitted(&self, bench: &Bench<'_>) -> Result<Fitted, FitError> {
        let fused = self.fused.as_ref();
        let read = |split| bench.data.of_shards(split, self.objects, |s| seen(s, fused));
        let mut train = read(Split::Train)?;
        train.extend(of_families(&self.families, FAMILY_SEED, |s| seen(s, fused))?);
        let validation = read(Split::Validation)?;
        let mut fitted = Fitted::of(KIND, vec![Table::new(TABLE, names())]);
        for (turns, name) in JOINTS.into_iter().enumerate() {
            let of_kind = |e: &&End| usize::from(e.turns) == turns;
            let own: Vec<&End> = train.iter().filter(of_kind).collect();
            let judged: Vec<&End> = validation.iter().filter(of_kind).collect();
            if own.is_empty() {
                return Err(FitError::Nothing("the ranges of turns and slides"));
            }
            let forests = self.forests(name, &own, bench)?;
            for (fold, forest) in forests.iter().enumerate() {
                let mut bytes = Vec::new();
                forest.write(&mut bytes);
                let section = Section::new(forest_section(name, fold), TABLE, Form::Forest);
                fitted.sections.push((section, bytes));
            }
            fitted.ensembles.push(Ensemble { folds: forests.len(), rounds: 1 });
            tell(name, (&own, &judged), &forests, (bench, &mut fitted));
        }
        Ok(fitted)
    }
}

impl Ranges {
    /// A forest for each fold.
    fn forests(
        &self,
        name: &str,
        ends: &[&End],
        bench: &Bench<'_>,
    ) -> Result<Vec<Forest<INPUTS>>, FitError> {
        let bins = Bins::of(ends.iter().step_by(SAMPLED).flat_map(|e| &e.asked.numbers));
        let mut lessons = Lessons::new(&bins);
        ends.iter().for_each(|e| lessons.add(std::slice::from_ref(&e.asked)));
        let grow = |fold: usize| {
            let growth = Growth { seed: self.growth.seed + fold as u64, ..self.growth };
            let knows = |end: usize| ends[end].fold != fold;
            bench.kept.forest(&forest_section(name, fold), (&lessons, &growth), knows)
        };
        (0..FOLDS).map(grow).collect()
    }
}

/// Reports how far off the found ends are, and takes it for the pack.
fn tell(
    name: &str,
    (own, judged): (&[&End], &[&End]),
    forests: &[Forest<INPUTS>],
    (bench, fitted): (&Bench<'_>, &mut Fitted),
) {
    let said = |forests: &[Forest<INPUTS>], both: &[&End]| {
        let asked = |way: usize| mean_chances(forests, &both[way].asked.numbers);
        likeliest(both[0].turns, &[asked(0), asked(1)])
    };
    let usual = |both: &[&End]| [0, 1].map(|way: usize| both[way].usual.min(both[way].free));
    let mut told = |what: &str, ends: &[&End], said: &dyn Fn(&[&End]) -> [f64; 2]| {
        fitted.metrics.extend(report(bench, &format!("{name}, {what}"), ends, said));
    };
    told("out of fold", own, &|both| said(&forests[both[0].fold..=both[0].fold], both));
    told("out of fold, as is usual", own, &usual);
    told("validation", judged, &|both| said(forests, both));
    told("validation, as is usual", judged, &usual);
}

/// Reports on joints, each two ends one after the other: the share whose end is off by at most 0.3.
fn report(
    bench: &Bench<'_>,
    what: &str,
    ends: &[&End],
    said: impl Fn(&[&End]) -> [f64; 2],
) -> Vec<(String, f64)> {
    let mut metrics = Vec::new();
    for (fused, sight) in [(false, "as it is"), (true, "fused")] {
        let joints: Vec<&[&End]> =
            ends.chunks_exact(2).filter(|e| e[0].is_fused == fused).collect();
        if joints.is_empty() {
            continue;
        }
        let said: Vec<[f64; 2]> = joints.iter().map(|both| said(both)).collect();
        for (way, side) in [(0, "ahead"), (1, "back")] {
            let off = |(both, said): (&&[&End], &[f64; 2])| {
                (said[way] - both[way].wanted).abs() * both[way].length
            };
            let off: Vec<f64> = joints.iter().zip(&said).map(off).collect();
            let count = off.len() as f64;
            let share = |most: f64| off.iter().filter(|o| **o <= most).count() as f64 / count;
            let [a, b, c] = OFF.map(share);
            let mean = off.iter().map(|o| o.min(1.0)).sum::<f64>() / count;
            let still = joints.iter().zip(&said);
            let still = still.filter(|(b, s)| s[way] == 0.0 && b[way].wanted > 0.1).count();
            bench.watcher.say(&format!(
                "{what}, {sight}, {side}: {count} joints, {:.1} {:.1} {:.1} %, off by {mean:.3}, \
                 {still} that move do not",
                100.0 * a,
                100.0 * b,
                100.0 * c
            ));
            metrics.push((format!("{what}, {sight}, {side}: within {}", OFF[2]), c));
        }
    }
    metrics
}
