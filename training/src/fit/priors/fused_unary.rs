//! Which part a segment of a fused mesh is of: a multinomial logistic regression over the parts.
//!
//! Half the weight of an object goes to its segments by area, half to its parts alike, so that small parts
//! count. Objects that are not fused all through are passed over.

use std::collections::BTreeMap;

use model::classic::learned::pack::{Form, Table};
use model::classic::segment::Sheet;
use model::classic::segment::grow::fused_unary::{
    BASE_BIAS, FEATURES as NUMBERS, Features, KIND, NAMES, SECTIONS, TABLE,
};
use model::classic::segment::sheet;
use object::ArticulatedObject;
use object::weld::Weld;
use serde::Deserialize;

use super::super::data::Subject;
use super::super::recipe::{Families, Model};
use super::super::segments::prompted;
use super::super::{Bench, FitError, Fits, Fitted};
use super::choice::{Choice, ChoiceOption, Weights, fitted};
use super::contacts::ridge;
use super::{areas, most, read, section};
use crate::fuse;

/// How the weights are fitted: the table `model` of a recipe.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FusedUnary {
    /// At most so many objects of the shards; all where it is not given.
    #[serde(default)]
    pub objects: Option<usize>,
    /// How objects are fused.
    pub fused: fuse::Recipe,
    /// Objects of our own families.
    #[serde(default)]
    pub families: Families,
    /// What a squared weight costs, in objects.
    pub ridge: f64,
}

impl Model for FusedUnary {
    fn families(&self) -> Vec<&Families> {
        vec![&self.families]
    }

    fn check(&self) -> Result<(), String> {
        ridge(self.ridge)
    }
}

impl Fits for FusedUnary {
    const READS: &'static [&'static str] = &["contacts", "sizes", "roles"];

    fn fitted(&self, bench: &Bench<'_>) -> Result<Fitted, FitError> {
        let one = |subject: &Subject| match fuse::fused(&subject.specimen, &self.fused) {
            Ok(fused) => choices(&fused.object, &subject.category),
            Err(why) => {
                bench.watcher.say(&format!("{}, fused, is left out: {why}", subject.specimen.id));
                Vec::new()
            }
        };
        let [train, validation] = read((self.objects, &self.families), bench, one)?;
        if train.is_empty() {
            return Err(FitError::Nothing("segments of fused meshes"));
        }
        let weights = fitted(&train, (SECTIONS.len(), FEATURES), self.ridge, |round, loss| {
            bench.watcher.say(&format!("fused_unary, round {round}: loss {loss:.4}"));
        });
        let mut result = Fitted::of(KIND, vec![Table::new(TABLE, NAMES)]);
        for (row, name) in SECTIONS.into_iter().enumerate() {
            let numbers = &weights.row(row)[..NUMBERS];
            result.sections.push(section(name, TABLE, (Form::Double, numbers)));
        }
        result.settings.insert(BASE_BIAS.into(), weights.row(BASE)[NUMBERS]);
        for (what, choices) in [("train", &train), ("validation", &validation)] {
            if !choices.is_empty() {
                let right = right(&weights, choices);
                bench.watcher.say(&format!("{what}: {:.2} % right by weight", 100.0 * right));
                result.metrics.insert(format!("{what}: share right by weight"), right);
                result.metrics.insert(format!("{what}: loss"), weights.loss(choices));
            }
        }
        Ok(result)
    }
}

/// The row of the base; that of the others is the first.
const BASE: usize = 1;
/// The features, and whether a part is the base.
const FEATURES: usize = NUMBERS + 1;

/// The segments of a fused object: which part is each of? Nothing if it is not fused all through.
fn choices(object: &ArticulatedObject, category: &str) -> Vec<Choice> {
    let mesh = object.mesh();
    let condition = prompted((object, mesh), category, None);
    let Some(sheet) = sheet(mesh, &condition, &Weld::new(mesh)) else { return Vec::new() };
    let areas = areas(object, &sheet.segment_of_face, sheet.share.len());
    let truth: Vec<usize> = areas.iter().map(|a| most(a).unwrap_or(0)).collect();
    of_sheet(&sheet, &truth, object.tree().root())
}

fn of_sheet(sheet: &Sheet, truth: &[usize], root: usize) -> Vec<Choice> {
    let mut shares = BTreeMap::<usize, f64>::new();
    truth.iter().zip(&sheet.share).for_each(|(&t, s)| *shares.entry(t).or_default() += s);
    let parts = sheet.features.first().map_or(1, Vec::len) as f64;
    let choice = |segment: usize| {
        let each = 0.5 / (shares[&truth[segment]].max(1e-9) * parts);
        let option = |(part, x): (usize, &Option<Features>)| {
            let is_base = part == root;
            let features = x.as_ref()?.iter().copied().chain([f64::from(u8::from(is_base))]);
            let truth = f64::from(u8::from(part == truth[segment]));
            let rows = vec![if is_base { BASE } else { 0 }];
            Some(ChoiceOption { rows, features: features.collect(), truth })
        };
        let options: Vec<ChoiceOption> =
            sheet.features[segment].iter().enumerate().filter_map(option).collect();
        let weight = sheet.share[segment] * (0.5 + each);
        Choice { weight, options, may_be_none: false }
    };
    let all = (0..truth.len()).map(choice);
    all.filter(|c| c.options.iter().any(|o| o.truth > 0.5)).collect()
}

/// The share of choices that the weights are right about, by how much they count, 0 to 1.
fn right(weights: &Weights, choices: &[Choice]) -> f64 {
    let is_right = |choice: &&Choice| {
        let score = |o: &&ChoiceOption| weights.score(o);
        let best = choice.options.iter().max_by(|a, b| score(a).total_cmp(&score(b)));
        best.is_some_and(|b| b.truth > 0.5)
    };
    let sum = |of: &mut dyn Iterator<Item = &Choice>| of.map(|c| c.weight).sum::<f64>();
    sum(&mut choices.iter().filter(is_right)) / sum(&mut choices.iter()).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::super::choice::tests::by;
    use super::*;

    #[test]
    fn an_object_weighs_one_half_by_area_and_half_by_parts() {
        let row = || vec![Some([0.0; NUMBERS]); 2];
        let sheet = Sheet {
            segment_of_face: vec![],
            share: vec![0.5, 0.4, 0.1],
            features: vec![row(), row(), row()],
        };
        let choices = of_sheet(&sheet, &[0, 0, 1], 0);
        let weights: Vec<f64> = choices.iter().map(|c| c.weight).collect();
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{weights:?}");
        assert!((weights[2] - (0.05 + 0.25)).abs() < 1e-12, "{weights:?}");
        assert_eq!(choices[0].options[0].rows, [BASE]);
        assert_eq!(choices[2].options[1].truth, 1.0);
    }

    #[test]
    fn weights_of_child_base_and_bias_are_found_again() {
        let blank = |base: bool| ChoiceOption {
            rows: vec![usize::from(base)],
            features: vec![0.0; FEATURES],
            truth: 0.0,
        };
        let shape = |dice: &mut rand_pcg::Pcg64Mcg| {
            let mut options = vec![blank(true), blank(false), blank(false)];
            for option in &mut options {
                option.features[..NUMBERS].fill_with(|| dice.random::<f64>() - 0.5);
                option.features[NUMBERS] = option.rows[0] as f64;
            }
            Choice { weight: 1.0, options, may_be_none: false }
        };
        // Weights as a fit of other choices leaves them, so that nothing is special about them.
        let seed = fitted(&by(&Weights::new(2, FEATURES), shape), (2, FEATURES), 1.0, |_, _| ());
        assert!(seed.row(0).iter().all(|w| w.abs() < 1e-6), "choices at random teach nothing");
        let mut first = shape(&mut rand::SeedableRng::seed_from_u64(1));
        first.options[1].truth = 1.0;
        let known = fitted(&[first], (2, FEATURES), 0.05, |_, _| ());
        let found = fitted(&by(&known, shape), (2, FEATURES), 1e-9, |_, _| ());
        for (row, name) in SECTIONS.into_iter().enumerate() {
            for (a, b) in found.row(row).iter().zip(known.row(row)) {
                assert!((a - b).abs() < 2e-3, "{name}: {a} for {b}");
            }
        }
        assert!(known.row(BASE)[NUMBERS].abs() > 0.1, "a bias there is");
    }
}
