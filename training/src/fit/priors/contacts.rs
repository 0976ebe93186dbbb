//! How likely two components that touch are one part: logistic regression over pairs of neighbours.

use model::classic::learned::pack::{Form, Table};
use model::classic::segment::contact_sheet;
use model::classic::segment::grow::evidence::{KIND, NAMES, SECTION, TABLE};
use object::weld::Weld;
use serde::Deserialize;

use super::super::data::Subject;
use super::super::recipe::{Families, Model};
use super::super::{Bench, FitError, Fits, Fitted};
use super::choice::{Choice, ChoiceOption, Weights, fitted};
use super::{areas, most, read, section};

/// How contacts are fitted: the table `model` of a recipe.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Contacts {
    /// At most so many objects of the shards; all where it is not given.
    #[serde(default)]
    pub objects: Option<usize>,
    /// Objects of our own families.
    #[serde(default)]
    pub families: Families,
    /// What a squared weight costs, in pairs.
    pub ridge: f64,
}

impl Model for Contacts {
    fn families(&self) -> Vec<&Families> {
        vec![&self.families]
    }

    fn check(&self) -> Result<(), String> {
        ridge(self.ridge)
    }
}

/// Refuses a ridge that is none.
pub(super) fn ridge(ridge: f64) -> Result<(), String> {
    if ridge.is_finite() && ridge > 0.0 {
        return Ok(());
    }
    Err(format!("`model.ridge` must be above 0, found {ridge}"))
}

impl Fits for Contacts {
    const READS: &'static [&'static str] = &[];

    fn fitted(&self, bench: &Bench<'_>) -> Result<Fitted, FitError> {
        let [train, validation] = read((self.objects, &self.families), bench, pairs)?;
        if train.is_empty() {
            return Err(FitError::Nothing("contacts"));
        }
        let mut result = Fitted::of(KIND, vec![Table::new(TABLE, NAMES)]);
        let weights = fitted(&train, (1, NAMES.len()), self.ridge, |round, loss| {
            bench.watcher.say(&format!("contacts, round {round}: loss {loss:.4}"));
        });
        result.sections.push(section(SECTION, TABLE, (Form::Double, weights.row(0))));
        for (what, pairs) in [("train", &train), ("validation", &validation)] {
            if !pairs.is_empty() {
                let name = |metric: &str| format!("{what}: {metric}");
                let right = right(&weights, pairs);
                let of = pairs.len();
                bench.watcher.say(&format!("{what}: {:.2} % of {of} pairs right", 100.0 * right));
                result.metrics.extend([
                    (name("pairs"), of as f64),
                    (name("share of pairs right"), right),
                    (name("loss"), weights.loss(pairs)),
                ]);
            }
        }
        Ok(result)
    }
}

/// The contacts of an object: are both of one part?
fn pairs(subject: &Subject) -> Vec<Choice> {
    let object = &subject.specimen.object;
    let sheet = contact_sheet(object.mesh(), &Weld::new(object.mesh()));
    let components = sheet.component_of_face.iter().max().map_or(0, |c| *c as usize + 1);
    let areas = areas(object, &sheet.component_of_face, components);
    let of = |component: u32| most(&areas[component as usize]);
    let pair = |contact: &model::classic::segment::Contact| {
        let [a, b] = contact.components;
        choice(&contact.features, of(a) == of(b))
    };
    sheet.contacts.iter().map(pair).collect()
}

fn choice(features: &[f64], is_one: bool) -> Choice {
    let truth = f64::from(u8::from(is_one));
    let option = ChoiceOption { rows: vec![0], features: features.to_vec(), truth };
    Choice { weight: 1.0, options: vec![option], may_be_none: true }
}

/// The share of pairs that the weights are right about, 0 to 1.
fn right(weights: &Weights, pairs: &[Choice]) -> f64 {
    let is_right = |pair: &&Choice| {
        let option = &pair.options[0];
        (weights.score(option) > 0.0) == (option.truth > 0.5)
    };
    pairs.iter().filter(is_right).count() as f64 / pairs.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weight_of_a_feature_is_its_log_odds() {
        // Of four pairs with the feature three are one, of four without it one is.
        let pair = |meets: f64, is_one: bool| choice(&[1.0, meets], is_one);
        let pairs: Vec<Choice> =
            (0..4).flat_map(|k| [pair(1.0, k < 3), pair(0.0, k < 1)]).collect();
        let found = fitted(&pairs, (1, 2), 1e-9, |_, _| ());
        let [constant, meets] = found.row(0) else { panic!("two weights") };
        assert!((constant - (1f64 / 3.0).ln()).abs() < 1e-4, "{constant}");
        assert!((meets - 9f64.ln()).abs() < 1e-4, "{meets}");
        assert_eq!(right(&found, &pairs), 0.75);
    }
}
