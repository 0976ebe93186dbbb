//! Joints of an MJCF body: kinds, ranges, springs.

use glamx::{DPose3, DVec3};

use super::attributes::Element;
use super::bodies::fixed;
use super::model::Model;
use crate::robot::{Dynamics, Joint, Limit, Motion, Spring};

impl Model<'_, '_> {
    /// A joint whose frame stands at `frame` in its parent link's.
    pub(super) fn moving(&mut self, element: &Element, link: &str, frame: DPose3) -> Joint {
        let line = self.reader.line(element.node);
        let limits = self.range(element);
        let (kind, held) = match (element.get("type").unwrap_or("hinge"), limits) {
            ("hinge", Some(_)) => (Motion::Revolute, None),
            ("hinge", None) => (Motion::Continuous, None),
            ("slide", _) => (Motion::Prismatic, None),
            ("ball", _) => (Motion::Floating, Some("a ball, which has no single range".into())),
            ("free", _) => {
                let words = "a joint of type `free`".to_owned();
                self.foreign(element.node, &words);
                (Motion::Floating, Some(words))
            }
            (other, _) => {
                let at = self.reader.at(element.node);
                let words = format!("{at}: joint type `{other}` is unknown");
                self.reader.faults.types.push(words.clone());
                (Motion::Floating, Some(words))
            }
        };
        let axis_as_written = self.vector(element, "axis").unwrap_or(DVec3::Z);
        let effort = self.numbers(element, "actuatorfrcrange", 2);
        let effort = effort.map(|r| r[0].abs().max(r[1].abs()));
        let mut limit =
            limits.map_or(Limit::NONE, |[lower, upper]| Limit { lower, upper, ..Limit::NONE });
        limit.effort = effort;
        let has_limit = limits.is_some() || kind != Motion::Prismatic;
        let given = |n: Option<f64>| Some(n.unwrap_or(0.0));
        let damping = given(self.number(element, "damping"));
        let friction = given(self.number(element, "frictionloss"));
        let name = element.get("name").map_or_else(|| format!("{link}_joint"), str::to_owned);
        let name = self.unique_joint(name);
        let (width, zero) = (if kind == Motion::Floating { 4 } else { 1 }, self.zero(element));
        self.coordinates.push((Some(name.clone()), width, zero));
        // MuJoCo makes every axis one of length 1 as it reads it.
        let axis = axis_as_written.normalize_or_zero();
        Joint {
            name,
            kind,
            axis,
            axis_as_written: axis,
            limit: has_limit.then_some(limit),
            dynamics: Some(Dynamics { damping, friction }),
            spring: self.spring(element),
            held,
            ..fixed(link, frame, line)
        }
    }

    /// Radians per unit of a joint's own numbers, or 1 for metres.
    fn unit(&self, element: &Element) -> f64 {
        let turns = element.get("type").is_none_or(|t| t == "hinge");
        if turns { self.compiler.angle } else { 1.0 }
    }

    /// The value that stands for the pose the file is written in.
    fn zero(&mut self, element: &Element) -> f64 {
        self.number(element, "ref").unwrap_or(0.0) * self.unit(element)
    }

    fn spring(&mut self, element: &Element) -> Option<Spring> {
        let stiffness = self.number(element, "stiffness").filter(|k| *k > 0.0)?;
        let at = self.number(element, "springref").unwrap_or(0.0) * self.unit(element);
        Some(Spring { stiffness, at: at - self.zero(element) })
    }

    /// Lower and upper end from rest, radians or metres; `None` without limits.
    fn range(&mut self, element: &Element) -> Option<[f64; 2]> {
        let limited = match element.get("limited") {
            Some("true") => true,
            Some("false") => false,
            _ => self.compiler.autolimits && element.get("range").is_some(),
        };
        let (unit, zero) = (self.unit(element), self.zero(element));
        let range = self.numbers(element, "range", 2).filter(|_| limited)?;
        Some([range[0], range[1]].map(|end| end * unit - zero))
    }
}
