//! How likely parts and joints are right: boosted trees over what speaks for them, and their calibration.
//!
//! Objects of validation and of our own families, made from a seed that nothing else is made with, are
//! articulated as the program does it: as they are, fused, cut up and half open, with points in the middle of
//! parts and anywhere on them. What comes out is compared with the truth. Folds leave out objects, and what they say
//! of those is what slope and offset are fitted to.

mod case;
mod logistic;

use model::classic::confidence::{
    FOLDS, JOINT_INPUTS, KIND, OBJECT, OBJECT_INPUTS, PART_INPUTS, QUESTIONS, calibrated,
    joint_names, object_names, part_names, section, settings,
};
use model::classic::learned::forest::Forest;
use model::classic::learned::pack::{Ensemble, Form, Section, Table};
use serde::Deserialize;

use super::data::{Split, of_ids, together};
use super::recipe::{Families, Model, counted};
use super::{Bench, FitError, Fits, Fitted};
use crate::forest::{Bins, Growth, Lessons, Question};
use crate::fuse;
use crate::metrics::calibration::{Calibration, Told};
use case::{Fate, How, SIGHTS, Seen, seen};

/// A seed that nothing else is made with.
const FAMILY_SEED: u64 = 57;

/// How confidence is fitted: the table `model` of a recipe.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Confidence {
    /// At most so many objects of validation; all where it is not given.
    #[serde(default)]
    pub objects: Option<usize>,
    /// How often each object is drawn, of each way to see it.
    pub draws: u64,
    /// The ways to fuse it, beside how it is.
    pub fused: Vec<fuse::Recipe>,
    /// Objects of our own families.
    #[serde(default)]
    pub families: Families,
    /// How trees grow.
    pub growth: Growth,
}

impl Model for Confidence {
    const LEARNS_FROM_VALIDATION: bool = true;

    fn families(&self) -> Vec<&Families> {
        vec![&self.families]
    }

    fn check(&self) -> Result<(), String> {
        counted("model.draws", self.draws as usize, [1, 64])?;
        self.growth.check().map_err(|what| format!("model.growth: {what}"))
    }
}

impl Fits for Confidence {
    const READS: &'static [&'static str] = &[
        "axes",
        "contacts",
        "fused_unary",
        "ranges",
        "roles",
        "segments",
        "segments_fused",
        "sizes",
    ];

    fn fitted(&self, bench: &Bench<'_>) -> Result<Fitted, FitError> {
        let all = self.read(bench)?;
        let tables = [("part", part_names()), ("joint", joint_names()), (OBJECT, object_names())];
        let tables = tables.into_iter().map(|(name, features)| Table::new(name, features));
        let mut fitted = Fitted::of(KIND, tables.collect());
        let mut to = (bench, &mut fitted);
        let labels = self.answered(0, &of_parts(&all), &mut to)?;
        let ways: [fn(&Fate, bool) -> Option<bool>; 4] = [
            |fate, _| Some(fate.axis),
            |fate, _| fate.line,
            |fate, is_endless| fate.way(is_endless),
            |fate, _| Some(fate.joint),
        ];
        let mut joints = Vec::new();
        for (question, right) in (1..).zip(ways) {
            joints = self.answered(question, &of_joints(&all, right), &mut to)?;
        }
        of_objects(&all, (&labels, &joints), &mut to);
        Ok(fitted)
    }
}

/// What is asked about one sighting: rows, and whether what they are about was right.
struct Asked<'a, const N: usize> {
    seen: &'a Seen,
    rows: Vec<([f32; N], bool)>,
}

fn of_parts<'a>(all: &'a [Seen]) -> Vec<Asked<'a, PART_INPUTS>> {
    let asked = |seen: &'a Seen| {
        let Seen { parts, is_part_right, .. } = seen;
        Asked { seen, rows: whole(parts).zip(is_part_right.iter().copied()).collect() }
    };
    all.iter().map(asked).collect()
}

fn of_joints<'a>(
    all: &'a [Seen],
    right: impl Fn(&Fate, bool) -> Option<bool>,
) -> Vec<Asked<'a, JOINT_INPUTS>> {
    let endless = joint_names().iter().position(|name| name == "endless").unwrap_or(usize::MAX);
    let asked = |seen: &'a Seen| {
        let Seen { joints, outcomes, .. } = seen;
        let rows = whole(joints).zip(outcomes).filter_map(|(row, fate)| {
            let is_endless = row.get(endless).is_some_and(|&number| number > 0.5);
            Some((row, right(fate, is_endless)?))
        });
        Asked { seen, rows: rows.collect() }
    };
    all.iter().map(asked).collect()
}

/// Fits how the probabilities of parts and joints, one after another, as folds have it that do not know them,
/// make that of the object.
fn of_objects(
    all: &[Seen],
    (labels, joints): (&[f64], &[f64]),
    (bench, fitted): &mut (&Bench<'_>, &mut Fitted),
) {
    const WEIGHTS: usize = OBJECT_INPUTS + 1;
    let (mut labels, mut joints) = (labels, joints);
    let row = |seen: &Seen| -> ([f64; WEIGHTS], bool) {
        let (own, rest) = labels.split_at(seen.parts.len());
        labels = rest;
        let (turns, rest) = joints.split_at(seen.joints.len());
        joints = rest;
        let known = seen.evidence().of_object(own, (turns, &seen.moves));
        let number = |i: usize| known.get(i).copied().unwrap_or(1.0);
        (std::array::from_fn(number), seen.is_right)
    };
    let rows: Vec<([f64; WEIGHTS], bool)> = all.iter().map(row).collect();
    // As if all kinds were right or wrong apart from each other.
    let begin = std::array::from_fn(|i| f64::from(u8::from(i == 0)));
    let without = |fold: usize| {
        let known = rows.iter().zip(all).filter(|(_, seen)| seen.fold != fold);
        logistic::weights(&known.map(|(row, _)| *row).collect::<Vec<_>>(), begin)
    };
    let folds: Vec<[f64; WEIGHTS]> = (0..FOLDS).map(without).collect();
    let said = |(seen, (row, is_right)): (&Seen, &([f64; WEIGHTS], bool))| {
        let score = row.iter().zip(&folds[seen.fold]).map(|(x, w)| x * w).sum();
        vec![(calibrated(score, [1.0, 0.0]), *is_right)]
    };
    let chances: Vec<Vec<Told>> = all.iter().zip(&rows).map(said).collect();
    tell(OBJECT, all.iter().zip(&chances), (bench, fitted));
    let weights = logistic::weights(&rows, begin);
    let bytes = weights.iter().flat_map(|w| w.to_le_bytes()).collect();
    fitted.sections.push((Section::new(OBJECT, OBJECT, Form::Double), bytes));
}

/// Rows of as many numbers as trees ask about.
fn whole<const N: usize>(rows: &[Vec<f32>]) -> impl Iterator<Item = [f32; N]> {
    rows.iter().map(|row| std::array::from_fn(|i| row.get(i).copied().unwrap_or_default()))
}

impl Confidence {
    /// Fits what answers a question; returns the probability of every row, as folds have it that do not know
    /// its object.
    fn answered<const N: usize>(
        &self,
        number: usize,
        asked: &[Asked<'_, N>],
        (bench, fitted): &mut (&Bench<'_>, &mut Fitted),
    ) -> Result<Vec<f64>, FitError> {
        let (question, table) = QUESTIONS[number];
        let rows = asked.iter().flat_map(|a| &a.rows);
        if rows.clone().count() == 0 {
            return Err(FitError::Nothing("confidence"));
        }
        let bins = Bins::of(rows.map(|(row, _)| row));
        let mut lessons = Lessons::new(&bins);
        for Asked { rows, .. } in asked {
            let question = |(row, is_right): &([f32; N], bool)| {
                let right = f32::from(u8::from(*is_right));
                Question { weight: 1.0, truth: vec![right, 1.0 - right], numbers: vec![*row] }
            };
            lessons.add(&rows.iter().map(question).collect::<Vec<_>>());
        }
        let grow = |fold: usize| {
            let growth = Growth { seed: self.growth.seed + fold as u64, ..self.growth };
            let knows = |one: usize| asked[one].seen.fold != fold;
            bench.kept.forest(&section(question, fold), (&lessons, &growth), knows)
        };
        let forests: Vec<Forest<N>> = (0..FOLDS).map(grow).collect::<Result<_, _>>()?;
        let said = |a: &Asked<'_, N>| {
            let fold = &forests[a.seen.fold];
            a.rows.iter().map(|(row, right)| (f64::from(fold.score(row)), *right)).collect()
        };
        let scores: Vec<Vec<Told>> = asked.iter().map(said).collect();
        let line = logistic::line(scores.iter().flatten().copied());
        let chance = |(score, right): &Told| (calibrated(*score, line), *right);
        let chances: Vec<Vec<Told>> =
            scores.iter().map(|all| all.iter().map(chance).collect()).collect();
        tell(question, asked.iter().map(|a| a.seen).zip(&chances), (bench, fitted));
        for (fold, forest) in forests.iter().enumerate() {
            let mut bytes = Vec::new();
            forest.write(&mut bytes);
            let section = Section::new(section(question, fold), table, Form::Forest);
            fitted.sections.push((section, bytes));
        }
        fitted.ensembles.push(Ensemble { folds: FOLDS, rounds: 1 });
        fitted.settings.extend(settings(question).into_iter().zip(line));
        Ok(chances.iter().flatten().map(|told| told.0).collect())
    }

    fn read(&self, bench: &Bench<'_>) -> Result<Vec<Seen>, FitError> {
        let how = How { draws: self.draws, fused: &self.fused };
        let mut all = Vec::new();
        let mut left = self.objects.unwrap_or(usize::MAX);
        for shard in bench.data.shards(Split::Validation)? {
            if left == 0 {
                break;
            }
            let objects = crate::dataset::shards::read_shard(&shard)?.len().min(left);
            let make = || {
                let one = |s: &super::data::Subject| seen(s, false, &how, bench.watcher);
                Ok(bench.data.of_shard((&shard, Split::Validation), left, one)?.1)
            };
            all.extend(self.kept(&super::data::called(&shard), left, bench, make)?);
            left -= objects;
        }
        for ids in together(&self.families) {
            let make = || of_ids(&ids, FAMILY_SEED, |s| seen(s, true, &how, bench.watcher));
            let what = format!("families from {}", ids[0]);
            all.extend(self.kept(&what, ids.len(), bench, make)?);
        }
        if all.is_empty() { Err(FitError::Nothing("confidence")) } else { Ok(all) }
    }

    /// Sightings as they were kept, or as they are made, and then kept.
    fn kept(
        &self,
        what: &str,
        count: usize,
        bench: &Bench<'_>,
        make: impl FnOnce() -> Result<Vec<Seen>, FitError>,
    ) -> Result<Vec<Seen>, FitError> {
        let inputs = bench.inputs(&format!("{what} {count} {} {:?}", self.draws, self.fused));
        let found = bench.kept.find(what, &inputs);
        let seen = match found.and_then(|bytes| serde_json::from_slice(&bytes).ok()) {
            Some(seen) => seen,
            None => {
                let seen = make()?;
                let bytes =
                    serde_json::to_vec(&seen).map_err(|e| FitError::Broken(e.to_string()))?;
                bench.kept.keep(what, &inputs, &bytes)?;
                seen
            }
        };
        bench.watcher.say(&format!("{what}: seen {} times", seen.len()));
        Ok(seen)
    }
}

/// Reports how well the probabilities agree with the truth, out of fold, by where objects come from.
fn tell<'a>(
    question: &str,
    told: impl Iterator<Item = (&'a Seen, &'a Vec<Told>)>,
    (bench, fitted): (&Bench<'_>, &mut Fitted),
) {
    let told: Vec<(&Seen, &Vec<Told>)> = told.collect();
    for (own, whose) in [(false, "validation"), (true, "own families")] {
        for (sight, how) in SIGHTS.into_iter().enumerate() {
            let is_of = |seen: &Seen| seen.is_own == own && seen.sight == sight;
            let some = told.iter().filter(|(seen, _)| is_of(seen)).flat_map(|(_, all)| *all);
            let some: Vec<Told> = some.copied().collect();
            let Calibration { count, right, ece, auroc, .. } = Calibration::of(&some);
            let percent = |x: Option<f64>| x.map_or("none".into(), |x| format!("{:.3}", x));
            bench.watcher.say(&format!(
                "{question}, {whose}, {how}: {count}, right {}, calibration error {}, AUROC {}",
                percent(right),
                percent(ece),
                percent(auroc)
            ));
            let name = |what: &str| format!("{question}, out of fold, {whose}, {how}: {what}");
            let metrics = [("right", right), ("calibration error", ece), ("AUROC", auroc)];
            let metrics =
                metrics.into_iter().filter_map(|(what, value)| Some((name(what), value?)));
            fitted.metrics.extend(metrics);
        }
    }
}
