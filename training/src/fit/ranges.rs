//! How far a joint goes: boosted trees, for turns and for slides.
//!
//! Every joint with limits is asked about with its true axis, on the object as it is and, where a recipe
//! says how, fused: which ways it goes, and how far each way.

mod end;

use std::ops::Range;

use model::classic::joints::axis_model::{JOINTS, forest_section};
use model::classic::joints::range_model::{FOLDS, INPUTS, KIND, TABLE, likeliest, names};
use model::classic::joints::ways;
use model::classic::learned::forest::{Forest, mean_chances};
use model::classic::learned::pack::{Ensemble, Form, Section, Table};
use object::{DVec3, JointKind};
use serde::Deserialize;

use super::data::{Split, of_families};
use super::recipe::{Families, Model};
use super::{Bench, FitError, Fits, Fitted};
use crate::forest::{Bins, Growth, Lessons, Question};
use crate::fuse;
use crate::metrics::{Motion, Opening, OpeningShares};
use end::{Joint, seen};

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
    /// How many trees say which ways a joint goes.
    pub ways: usize,
}

impl Model for Ranges {
    fn families(&self) -> Vec<&Families> {
        vec![&self.families]
    }

    fn check(&self) -> Result<(), String> {
        self.growth.check().map_err(|what| format!("model.growth: {what}"))?;
        let ways = Growth { trees: self.ways, ..self.growth };
        ways.check().map_err(|what| format!("model.ways: {what}"))
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
        let tables = [(TABLE, names()), (ways::TABLE, ways::names())];
        let tables = tables.into_iter().map(|(name, features)| Table::new(name, features));
        let mut fitted = Fitted::of(KIND, tables.collect());
        let of = |all: &[Joint], turns: bool| -> Vec<usize> {
            (0..all.len()).filter(|&j| all[j].turns == turns).collect()
        };
        let mut grown = Vec::new();
        for (turns, name) in [false, true].into_iter().zip(JOINTS) {
            let own: Vec<&Joint> = of(&train, turns).into_iter().map(|j| &train[j]).collect();
            if own.is_empty() {
                return Err(FitError::Nothing("the ranges of turns and slides"));
            }
            // As many questions about ends as joints have, one after the other.
            let ends: Vec<_> = own.iter().flat_map(|j| &j.ends).map(|e| &e.asked).collect();
            let folds: Vec<usize> = own.iter().flat_map(|j| [j.fold; 2]).collect();
            let amounts = self.forests(name, (&ends, &folds), bench)?;
            put(&mut fitted, (name, TABLE), &amounts);
            grown.push(amounts);
        }
        for ((turns, name), amounts) in [false, true].into_iter().zip(ways::JOINTS).zip(grown) {
            let own: Vec<&Joint> = of(&train, turns).into_iter().map(|j| &train[j]).collect();
            let judged = of(&validation, turns).into_iter().map(|j| &validation[j]).collect();
            let asked: Vec<_> = own.iter().map(|j| &j.ways).collect();
            let folds: Vec<usize> = own.iter().map(|j| j.fold).collect();
            let growth = Growth { trees: self.ways, ..self.growth };
            let ways = Self { growth, ..self.clone() }.forests(name, (&asked, &folds), bench)?;
            put(&mut fitted, (name, ways::TABLE), &ways);
            let both = Grown { amounts, ways };
            tell(JOINTS[usize::from(turns)], (&own, &judged), &both, (bench, &mut fitted));
        }
        Ok(fitted)
    }
}

/// Puts an ensemble into a pack.
fn put<const N: usize>(fitted: &mut Fitted, (name, table): (&str, &str), forests: &[Forest<N>]) {
    for (fold, forest) in forests.iter().enumerate() {
        let mut bytes = Vec::new();
        forest.write(&mut bytes);
        let section = Section::new(forest_section(name, fold), table, Form::Forest);
        fitted.sections.push((section, bytes));
    }
    fitted.ensembles.push(Ensemble { folds: forests.len(), rounds: 1 });
}

/// The forests of turns or of slides.
struct Grown {
    amounts: Vec<Forest<INPUTS>>,
    ways: Vec<Forest<{ ways::INPUTS }>>,
}

impl Grown {
    /// How far a joint goes both ways by some of the folds.
    fn said(&self, joint: &Joint, folds: Range<usize>) -> [f64; 2] {
        let amounts = &self.amounts[folds.clone()];
        let amounts = joint.ends.each_ref().map(|e| mean_chances(amounts, &e.asked.numbers));
        let chances = mean_chances(&self.ways[folds], &joint.ways.numbers);
        let mut ways = [0.0; 3];
        ways.iter_mut().zip(chances).for_each(|(to, chance)| *to = f64::from(chance));
        likeliest(joint.turns, &amounts, &ways)
    }
}

impl Ranges {
    /// A forest for each fold, of questions with the folds that are not to know them.
    fn forests<const N: usize>(
        &self,
        name: &str,
        (asked, folds): (&[&Question<N>], &[usize]),
        bench: &Bench<'_>,
    ) -> Result<Vec<Forest<N>>, FitError> {
        let bins = Bins::of(asked.iter().step_by(SAMPLED).flat_map(|q| &q.numbers));
        let mut lessons = Lessons::new(&bins);
        asked.iter().for_each(|&q| lessons.add(std::slice::from_ref(q)));
        let grow = |fold: usize| {
            let growth = Growth { seed: self.growth.seed + fold as u64, ..self.growth };
            let knows = |question: usize| folds[question] != fold;
            bench.kept.forest(&forest_section(name, fold), (&lessons, &growth), knows)
        };
        (0..FOLDS).map(grow).collect()
    }
}

/// Reports how far off the found ends are and which ways joints are found to go, and takes it for the pack.
fn tell(
    name: &str,
    (own, judged): (&[&Joint], &Vec<&Joint>),
    grown: &Grown,
    (bench, fitted): (&Bench<'_>, &mut Fitted),
) {
    let usual = |joint: &Joint| joint.ends.each_ref().map(|end| end.usual.min(end.free));
    let mut told = |what: &str, joints: &[&Joint], said: &dyn Fn(&Joint) -> [f64; 2]| {
        fitted.metrics.extend(report(bench, &format!("{name}, {what}"), joints, said));
    };
    told("out of fold", own, &|joint| grown.said(joint, joint.fold..joint.fold + 1));
    told("out of fold, as is usual", own, &usual);
    told("validation", judged, &|joint| grown.said(joint, 0..FOLDS));
    told("validation, as is usual", judged, &usual);
}

/// Reports on joints: the share whose end is off by at most 0.3, and of those that go one way the shares that
/// are found to go that way, both ways and the other way.
fn report(
    bench: &Bench<'_>,
    what: &str,
    joints: &[&Joint],
    said: impl Fn(&Joint) -> [f64; 2],
) -> Vec<(String, f64)> {
    let mut metrics = Vec::new();
    for (fused, sight) in [(false, "as it is"), (true, "fused")] {
        let joints: Vec<&&Joint> = joints.iter().filter(|j| j.is_fused == fused).collect();
        if joints.is_empty() {
            continue;
        }
        let said: Vec<[f64; 2]> = joints.iter().map(|joint| said(joint)).collect();
        for (way, side) in [(0, "ahead"), (1, "back")] {
            let off = |(joint, said): (&&&Joint, &[f64; 2])| {
                (said[way] - joint.ends[way].wanted).abs() * joint.length
            };
            let off: Vec<f64> = joints.iter().zip(&said).map(off).collect();
            let count = off.len() as f64;
            let share = |most: f64| off.iter().filter(|o| **o <= most).count() as f64 / count;
            let [a, b, c] = OFF.map(share);
            let mean = off.iter().map(|o| o.min(1.0)).sum::<f64>() / count;
            let still = joints.iter().zip(&said);
            let still = still.filter(|(j, s)| s[way] == 0.0 && j.ends[way].wanted > 0.1).count();
            bench.watcher.say(&format!(
                "{what}, {sight}, {side}: {count} joints, {:.1} {:.1} {:.1} %, off by {mean:.3}, \
                 {still} that move do not",
                100.0 * a,
                100.0 * b,
                100.0 * c
            ));
            metrics.push((format!("{what}, {sight}, {side}: within {}", OFF[2]), c));
        }
        let opening = |(joint, [ahead, back]): (&&&Joint, &[f64; 2])| {
            let motion = |[ahead, back]: [f64; 2]| Motion {
                kind: if joint.turns { JointKind::Revolute } else { JointKind::Prismatic },
                axis: DVec3::X,
                pivot: DVec3::ZERO,
                lower: -back,
                upper: ahead,
            };
            let wanted = joint.ends.each_ref().map(|end| end.wanted);
            let (wanted, found) = (motion(wanted), motion([*ahead, *back]));
            Opening::of(&wanted, &found, [-back, *ahead])
        };
        let openings = joints.iter().zip(&said).filter_map(opening);
        let shares = OpeningShares::of(openings.map(|opening| (1.0, opening)));
        let named = [("right", shares.right), ("both", shares.both), ("wrong", shares.wrong)];
        for (which, share) in named {
            metrics.extend(share.map(|s| (format!("{what}, {sight}: opens {which}"), s)));
        }
        bench.watcher.say(&format!(
            "{what}, {sight}: of {} that go one way open right, both ways, wrong: {:?}",
            shares.joints,
            named.map(|(_, share)| share.map(|s| (s * 1000.0).round() / 1000.0))
        ));
    }
    metrics
}
