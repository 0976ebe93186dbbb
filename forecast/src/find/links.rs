//! Links: roots, names.

use std::collections::BTreeSet;

use crate::find::place::{at, at_joint, at_link};
use crate::read::urdf::Urdf;
use crate::rule::Place;

/// The links that no joint carries.
pub(crate) fn roots(urdf: &Urdf) -> Vec<Place> {
    urdf.roots().map(|l| at_link(l, "root")).collect()
}

/// The same, but for one that is called `world`: several clients take it for their own.
pub(crate) fn bodies_at_root(urdf: &Urdf) -> Vec<Place> {
    urdf.roots().filter(|l| l.name != "world").map(|l| at_link(l, "root")).collect()
}

/// Root links, of files in which something moves.
pub(crate) fn roots_of_moving(urdf: &Urdf) -> Vec<Place> {
    if urdf.joints.iter().any(|j| j.moves()) { bodies_at_root(urdf) } else { Vec::new() }
}

/// Links whose name another one has already.
pub(crate) fn twice(urdf: &Urdf) -> Vec<Place> {
    let mut seen = BTreeSet::new();
    let again = urdf.links.iter().filter(|l| !seen.insert(l.name.as_str()));
    again.map(|l| at_link(l, "the second of that name")).collect()
}

/// Names that USD does not allow: it wants `[A-Za-z_][A-Za-z0-9_]*`.
pub(crate) fn odd_names(urdf: &Urdf) -> Vec<Place> {
    let is_odd = |name: &str| {
        let starts = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
        !starts || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    let links = urdf.links.iter().filter(|l| is_odd(&l.name)).map(|l| at_link(l, &l.name));
    let joints = urdf.joints.iter().filter(|j| is_odd(&j.name)).map(|j| at_joint(j, &j.name));
    links.chain(joints).collect()
}

/// Where three or more links can touch something: then two of them can meet that no joint ties.
pub(crate) fn could_meet(urdf: &Urdf) -> Vec<Place> {
    let felt: Vec<_> = urdf.links.iter().filter(|l| !l.collisions.is_empty()).collect();
    let [first, _, _, ..] = &felt[..] else { return Vec::new() };
    vec![at("robot", "", first.line, &format!("{} links with collisions", felt.len()))]
}
