//! How large parts usually are: mean and spread of the logarithm of a part's share of the surface, by what
//! its words say.

use model::classic::learned::pack::{Form, Table};
use model::classic::lexicon::sizes::{CLASSES, KIND, NAMES, TABLE, size_class};
use serde::Deserialize;

use super::super::data::Subject;
use super::super::recipe::{Families, Model};
use super::super::{Bench, FitError, Fits, Fitted};
use super::{areas, read, section};

/// A share of the surface is told from none down to this.
const LEAST: f64 = 1e-7;
/// No spread is less than this, log₁₀ of a share.
const LEAST_SPREAD: f64 = 0.05;

/// How sizes are fitted: the table `model` of a recipe.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sizes {
    /// At most so many objects of the shards; all where it is not given.
    #[serde(default)]
    pub objects: Option<usize>,
    /// Objects of our own families.
    #[serde(default)]
    pub families: Families,
}

impl Model for Sizes {
    fn families(&self) -> Vec<&Families> {
        vec![&self.families]
    }

    fn check(&self) -> Result<(), String> {
        Ok(())
    }
}

/// A part's class, as a place in [`CLASSES`], and log₁₀ of its share of the surface.
type Part = (usize, f64);

impl Fits for Sizes {
    const READS: &'static [&'static str] = &[];

    fn fitted(&self, bench: &Bench<'_>) -> Result<Fitted, FitError> {
        let [train, validation] = read((self.objects, &self.families), bench, parts)?;
        let mut result = Fitted::of(KIND, vec![Table::new(TABLE, NAMES)]);
        for (class, name) in CLASSES.into_iter().enumerate() {
            let [mean, spread] = usual(&train, class)
                .ok_or(FitError::Nothing("sizes of tiny, small and ordinary parts and bases"))?;
            bench.watcher.say(&format!("{name}: mean {mean:.3}, spread {spread:.3}"));
            result.sections.push(section(name, TABLE, (Form::Double, &[mean, spread])));
            let count = |of: &[Part]| of.iter().filter(|p| p.0 == class).count() as f64;
            result.metrics.insert(format!("train, {name}: parts"), count(&train));
            if let Some([mean, spread]) = usual(&validation, class) {
                result.metrics.insert(format!("validation, {name}: mean"), mean);
                result.metrics.insert(format!("validation, {name}: spread"), spread);
            }
        }
        Ok(result)
    }
}

/// The parts of an object.
fn parts(subject: &Subject) -> Vec<Part> {
    let object = &subject.specimen.object;
    let tree = object.tree();
    let whole = areas(object, &vec![0; object.part_of_face().len()], 1);
    let total: f64 = whole[0].values().sum();
    let one = |(&part, area): (&usize, &f64)| {
        let class = size_class(&tree.parts()[part].text, part == tree.root());
        (class, (area / total).max(LEAST).log10())
    };
    whole[0].iter().map(one).collect()
}

/// Mean and spread of a class; nothing where there is no part of it.
fn usual(parts: &[Part], class: usize) -> Option<[f64; 2]> {
    let own: Vec<f64> = parts.iter().filter(|p| p.0 == class).map(|p| p.1).collect();
    if own.is_empty() {
        return None;
    }
    let count = own.len() as f64;
    let mean = own.iter().sum::<f64>() / count;
    let spread = (own.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt();
    Some([mean, spread.max(LEAST_SPREAD)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedural::{Id, worded};

    #[test]
    fn mean_and_spread_are_those_of_the_class_alone() {
        let parts = [(0, -2.0), (1, 9.0), (0, -3.0)];
        assert_eq!(usual(&parts, 0), Some([-2.5, 0.5]));
        assert_eq!(usual(&parts, 1), Some([9.0, LEAST_SPREAD]));
        assert_eq!(usual(&parts, 2), None);
    }

    #[test]
    fn the_shares_of_an_objects_parts_add_up_to_its_surface() {
        let specimen = worded(Id::new("control_box", 1).unwrap(), 3).unwrap();
        let parts = parts(&Subject { specimen, category: String::new() });
        let sum: f64 = parts.iter().map(|p| 10f64.powf(p.1)).sum();
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
        assert_eq!(parts.iter().filter(|p| CLASSES[p.0] == "base").count(), 1);
        assert!(parts.iter().any(|p| CLASSES[p.0] == "tiny"));
    }
}
