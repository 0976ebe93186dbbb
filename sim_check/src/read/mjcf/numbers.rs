//! Numbers of an MJCF element, each checked as it is read.

use glamx::DVec3;

use super::attributes::Element;
use super::model::Model;
use crate::read::draft::MAX_LENGTH;

impl Model<'_, '_> {
    /// The numbers of an attribute, at least `least` of them; `None` if it is not there or broken.
    pub(super) fn numbers(
        &mut self,
        element: &Element,
        name: &str,
        least: usize,
    ) -> Option<Vec<f64>> {
        let text = element.get(name)?;
        let words: Vec<&str> = text.split_whitespace().collect();
        if words.len() < least {
            let found = words.len();
            self.reader
                .fault(element.node, format!("{name}: expected {least} numbers, found {found}"));
            return None;
        }
        let numbers = words.into_iter().map(|w| self.reader.parse(element.node, name, w));
        let numbers: Vec<Option<f64>> = numbers.collect();
        numbers.into_iter().collect()
    }

    /// One number.
    pub(super) fn number(&mut self, element: &Element, name: &str) -> Option<f64> {
        self.numbers(element, name, 1).map(|n| n[0])
    }

    /// Three lengths.
    pub(super) fn vector(&mut self, element: &Element, name: &str) -> Option<DVec3> {
        let numbers = self.numbers(element, name, 3)?;
        let vector = DVec3::new(numbers[0], numbers[1], numbers[2]);
        if vector.abs().max_element() <= MAX_LENGTH {
            return Some(vector);
        }
        self.reader.fault(element.node, format!("{name}: {vector} is beyond {MAX_LENGTH:e}"));
        None
    }
}
