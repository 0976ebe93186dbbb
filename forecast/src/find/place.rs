//! Places in a file, as findings name them.

use crate::read::urdf::{Joint, Link, Shape};
use crate::rule::Place;

/// Most characters of what was found that a place keeps; a guess.
const SHOWN: usize = 120;

fn short(text: &str) -> String {
    text.chars().take(SHOWN).collect()
}

/// An element anywhere.
pub(crate) fn at(element: &'static str, name: &str, line: u32, found: &str) -> Place {
    Place { element, name: short(name), line, found: short(found) }
}

/// A link.
pub(crate) fn at_link(link: &Link, found: &str) -> Place {
    at("link", &link.name, link.line, found)
}

/// A joint.
pub(crate) fn at_joint(joint: &Joint, found: &str) -> Place {
    at("joint", &joint.name, joint.line, found)
}

/// A visual or collision, named by its link.
pub(crate) fn at_shape(element: &'static str, link: &Link, shape: &Shape, found: &str) -> Place {
    at(element, &link.name, shape.line, found)
}
