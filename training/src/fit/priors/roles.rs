//! What parts of a role look like: a conditional choice among the candidates of each part, or none of them,
//! by logistic regression.
//!
//! Points do not count: a part is looked for as one that has none. A candidate is right if it is most like
//! the part and covers it well enough; like-worded parts share what is right of each of them, for words do
//! not tell them apart by looks.

use std::collections::BTreeSet;

use model::classic::learned::pack::{Form, Table};
use model::classic::segment::RoleSheet;
use model::classic::segment::prompts::roles::{KIND, TABLE, WEIGHTS, names, rows};
use model::classic::segment::role_sheet;
use object::weld::Weld;
use serde::Deserialize;

use super::super::data::Subject;
use super::super::recipe::{Families, Model, counted};
use super::super::segments::prompted;
use super::super::{Bench, FitError, Fits, Fitted};
use super::choice::{Choice, ChoiceOption, Weights, fitted};
use super::contacts::ridge;
use super::{areas, read, section};

/// The least IoU, by area, of a candidate that is taken for a part.
const COVERS: f64 = 0.5;

/// How roles are fitted: the table `model` of a recipe.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Roles {
    /// At most so many objects of the shards; all where it is not given.
    #[serde(default)]
    pub objects: Option<usize>,
    /// Objects of our own families.
    #[serde(default)]
    pub families: Families,
    /// Objects with more candidates than this are left out.
    pub candidates: usize,
    /// What a squared weight costs, in choices.
    pub ridge: f64,
}

impl Model for Roles {
    fn families(&self) -> Vec<&Families> {
        vec![&self.families]
    }

    fn check(&self) -> Result<(), String> {
        counted("model.candidates", self.candidates, [2, 1 << 20])?;
        ridge(self.ridge)
    }
}

impl Fits for Roles {
    const READS: &'static [&'static str] = &["contacts", "sizes"];

    fn fitted(&self, bench: &Bench<'_>) -> Result<Fitted, FitError> {
        let one = |subject: &Subject| choices(subject, self.candidates);
        let [train, validation] = read((self.objects, &self.families), bench, one)?;
        if train.is_empty() {
            return Err(FitError::Nothing("looks of roles"));
        }
        let (features, rows) = (names(), rows());
        let shape = (rows.len(), features.len());
        let weights = fitted(&train, shape, self.ridge, |round, loss| {
            bench.watcher.say(&format!("roles, round {round}: loss {loss:.4}"));
        });
        let mut result = Fitted::of(KIND, vec![Table::new(TABLE, features)]);
        for (row, name) in rows.into_iter().enumerate() {
            result.sections.push(section(name, TABLE, (Form::Single, weights.row(row))));
        }
        for (what, choices) in [("train", &train), ("validation", &validation)] {
            if !choices.is_empty() {
                let (right, of) = (right(&weights, choices), choices.len());
                bench.watcher.say(&format!("{what}: {:.1} % of {of} parts", 100.0 * right));
                result.metrics.insert(format!("{what}: parts"), of as f64);
                result.metrics.insert(format!("{what}: share of parts right"), right);
                result.metrics.insert(format!("{what}: loss"), weights.loss(choices));
            }
        }
        Ok(result)
    }
}

/// The parts of an object: which candidate is each? Nothing of an object of too many candidates.
fn choices(subject: &Subject, most: usize) -> Vec<Choice> {
    let object = &subject.specimen.object;
    let mesh = object.mesh();
    let condition = prompted((object, mesh), &subject.category, None);
    let Some(sheet) = role_sheet(mesh, &Weld::new(mesh), &condition, most) else {
        return Vec::new();
    };
    let units = sheet.unit_of_face.iter().max().map_or(0, |u| *u as usize + 1);
    let areas = areas(object, &sheet.unit_of_face, units);
    let mut whole = vec![0.0; object.tree().len()];
    areas.iter().flatten().for_each(|(&part, area)| whole[part] += area);
    let overlap = |candidate: &Vec<u32>, part: usize| {
        let (mut own, mut both) = (0.0, 0.0);
        for &unit in candidate {
            let areas = &areas[unit as usize];
            own += areas.values().sum::<f64>();
            both += areas.get(&part).copied().unwrap_or(0.0);
        }
        both / (own + whole[part] - both).max(f64::MIN_POSITIVE)
    };
    let found: Vec<Option<usize>> = (0..whole.len())
        .map(|part| {
            let all = sheet.candidates.iter().map(|c| overlap(c, part)).enumerate();
            let best = all.reduce(|a, b| if b.1 > a.1 { b } else { a });
            best.filter(|(_, iou)| *iou >= COVERS).map(|(c, _)| c)
        })
        .collect();
    of_sheet(&sheet, &found)
}

/// The choices of a sheet, where these candidates are the parts.
fn of_sheet(sheet: &RoleSheet, found: &[Option<usize>]) -> Vec<Choice> {
    let choice = |part: &model::classic::segment::RolePart| {
        let right: BTreeSet<usize> = part.like.iter().filter_map(|&p| found[p]).collect();
        let may = part.features.iter().enumerate().filter_map(|(c, f)| Some((c, f.as_ref()?)));
        let may: Vec<_> = may.collect();
        let count = may.iter().filter(|(c, _)| right.contains(c)).count();
        let truth = |c: &usize| if right.contains(c) { 1.0 / count as f64 } else { 0.0 };
        let option = |(c, features): &(usize, &[f64; WEIGHTS])| ChoiceOption {
            rows: part.rows.clone(),
            features: features.to_vec(),
            truth: truth(c),
        };
        let options: Vec<ChoiceOption> = may.iter().map(option).collect();
        // Of many alike each tells nearly the same.
        let weight = (part.like.len().max(1) as f64).sqrt().recip();
        Choice { weight, options, may_be_none: true }
    };
    sheet.parts.iter().map(choice).filter(|c| !c.options.is_empty()).collect()
}

/// The share of parts of which the likeliest option, or none, is right, 0 to 1.
fn right(weights: &Weights, choices: &[Choice]) -> f64 {
    let is_right = |choice: &&Choice| {
        let score = |o: &&ChoiceOption| weights.score(o);
        let best = choice.options.iter().max_by(|a, b| score(a).total_cmp(&score(b)));
        let is_none = choice.options.iter().all(|o| o.truth == 0.0);
        best.is_some_and(|b| if score(&b) > 0.0 { b.truth > 0.0 } else { is_none })
    };
    choices.iter().filter(is_right).count() as f64 / choices.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use model::classic::segment::RolePart;
    use rand::RngExt;

    use super::super::choice::tests::by;
    use super::*;
    use crate::procedural::{Id, worded};

    #[test]
    fn weights_of_a_role_and_of_its_joint_are_told_apart() {
        let shape = |dice: &mut rand_pcg::Pcg64Mcg| {
            let (role, joint) = (1 + dice.random_range(0..2), 3 + dice.random_range(0..2));
            let mut option = || {
                let features = vec![dice.random::<f64>() * 4.0 - 2.0, 1.0];
                ChoiceOption { rows: vec![0, role, joint], features, truth: 0.0 }
            };
            Choice { weight: 1.0, options: vec![option(), option()], may_be_none: true }
        };
        // What roles look like is known only up to what all rows have in common; scores are not.
        let mut first: Vec<Choice> = by(&Weights::new(5, 2), shape);
        first.iter_mut().for_each(|c| {
            let is_right = (c.options[0].features[0] > 0.0) == (c.options[0].rows[1] == 1);
            (c.options[0].truth, c.options[1].truth) =
                if is_right { (1.0, 0.0) } else { (0.0, 0.0) };
        });
        let known = fitted(&first, (5, 2), 20.0, |_, _| ());
        let choices = by(&known, shape);
        let found = fitted(&choices, (5, 2), 1e-6, |_, _| ());
        for option in choices.iter().flat_map(|c| &c.options) {
            let (a, b) = (found.score(option), known.score(option));
            assert!((a - b).abs() < 1e-3, "{a} for {b}");
        }
        assert!((known.row(1)[0] - known.row(2)[0]).abs() > 0.2, "the two roles differ");
    }

    #[test]
    fn like_worded_parts_share_what_is_right_and_what_is_too_large_is_no_option() {
        let features = vec![Some([0.0; WEIGHTS]), None, Some([1.0; WEIGHTS])];
        let part = |like: Vec<usize>| RolePart { rows: vec![0], like, features: features.clone() };
        let sheet = RoleSheet {
            unit_of_face: vec![],
            candidates: vec![vec![0], vec![1], vec![2]],
            parts: vec![part(vec![0]), part(vec![1, 2]), part(vec![1, 2])],
        };
        let choices = of_sheet(&sheet, &[Some(1), Some(0), Some(2)]);
        let truth = |c: &Choice| c.options.iter().map(|o| o.truth).collect::<Vec<_>>();
        assert_eq!(truth(&choices[0]), [0.0, 0.0], "the right one is no option, so none is right");
        assert_eq!([truth(&choices[1]), truth(&choices[2])], [[0.5, 0.5], [0.5, 0.5]]);
        assert!((choices[1].weight - 0.5f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn the_parts_of_an_object_are_found_among_its_components() {
        let specimen = worded(Id::new("drawer_unit", 0).unwrap(), 3).unwrap();
        let parts = specimen.object.tree().len();
        let subject = Subject { specimen, category: "drawer unit".into() };
        let choices = choices(&subject, 10_000);
        assert_eq!(choices.len(), parts);
        let found = choices.iter().filter(|c| c.options.iter().any(|o| o.truth > 0.0)).count();
        assert!(2 * found >= parts, "{found} of {parts}");
        assert!(super::choices(&subject, 2).is_empty(), "too many candidates");
    }
}
