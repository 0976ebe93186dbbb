//! Visuals and collisions that are no question of their meshes.

use std::collections::BTreeSet;

use crate::find::place::{at_link, at_shape};
use crate::read::urdf::{Geometry, Shape, Urdf};
use crate::rule::Place;

/// Links that are drawn.
pub(crate) fn drawn(urdf: &Urdf) -> Vec<Place> {
    let drawn = urdf.links.iter().filter(|l| !l.visuals.is_empty());
    drawn.map(|l| at_link(l, &format!("visuals: {}", l.visuals.len()))).collect()
}

/// Capsules, which URDF does not know.
pub(crate) fn capsules(urdf: &Urdf) -> Vec<Place> {
    let mut places = Vec::new();
    for link in &urdf.links {
        for (element, shapes) in [("visual", &link.visuals), ("collision", &link.collisions)] {
            let capsules = shapes.iter().filter(|s| matches!(s.geometry, Geometry::Capsule));
            places.extend(capsules.map(|s| at_shape(element, link, s, "capsule")));
        }
    }
    places
}

/// Visuals whose material is defined nowhere.
pub(crate) fn undefined(urdf: &Urdf) -> Vec<Place> {
    let mut places = Vec::new();
    for link in &urdf.links {
        for visual in &link.visuals {
            if let Some(name) = &visual.undefined {
                places.push(at_shape("visual", link, visual, name));
            }
        }
    }
    places
}

/// Visuals of one link with one name.
pub(crate) fn visuals_twice(urdf: &Urdf) -> Vec<Place> {
    twice(urdf, "visual", |_| "")
}

/// Collisions of one link with one name and one kind of shape.
pub(crate) fn collisions_twice(urdf: &Urdf) -> Vec<Place> {
    twice(urdf, "collision", |shape| match shape.geometry {
        Geometry::Primitive(tag) => tag,
        Geometry::Capsule => "capsule",
        Geometry::Mesh(_) => "mesh",
        Geometry::Other => "",
    })
}

fn twice(urdf: &Urdf, element: &'static str, kind: fn(&Shape) -> &'static str) -> Vec<Place> {
    let mut places = Vec::new();
    for link in &urdf.links {
        let mut seen = BTreeSet::new();
        let shapes = if element == "visual" { &link.visuals } else { &link.collisions };
        for shape in shapes {
            if let Some(name) = &shape.name
                && !seen.insert((name, kind(shape)))
            {
                places.push(at_shape(element, link, shape, name));
            }
        }
    }
    places
}
