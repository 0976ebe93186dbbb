//! Mass and inertia: missing, zero, impossible.

use std::collections::{BTreeMap, BTreeSet};

use crate::find::place::{at, at_link};
use crate::read::urdf::{Geometry, Inertial, Link, Urdf};
use crate::rule::Place;

/// Share by which moments may differ and be taken for alike; a guess, as is what is worth a line.
const ALIKE: f64 = 0.2;
/// Share of the largest moment by which A + B may fall short of C: the rounding of numbers with six
/// digits.
const ROUNDING: f64 = 1e-6;

impl Inertial {
    fn trace(&self) -> f64 {
        self.inertia[..3].iter().sum()
    }

    /// Its moments about its own axes, smallest first, by the closed form for symmetric matrices.
    fn principal(&self) -> [f64; 3] {
        let [xx, yy, zz, xy, xz, yz] = self.inertia;
        let mean = (xx + yy + zz) / 3.0;
        let off = xy * xy + xz * xz + yz * yz;
        let [a, b, c] = [xx - mean, yy - mean, zz - mean];
        let p = ((a * a + b * b + c * c + 2.0 * off) / 6.0).sqrt();
        if p <= f64::MIN_POSITIVE {
            return [mean; 3];
        }
        let [a, b, c, xy, xz, yz] = [a / p, b / p, c / p, xy / p, xz / p, yz / p];
        let det = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz);
        let angle = (det / 2.0).clamp(-1.0, 1.0).acos() / 3.0;
        let turn = 2.0 * std::f64::consts::FRAC_PI_3;
        let high = mean + 2.0 * p * angle.cos();
        let low = mean + 2.0 * p * (angle + turn).cos();
        [low, 3.0 * mean - high - low, high]
    }

    fn breaks_triangle(&self) -> bool {
        let [a, b, c] = self.principal();
        self.mass > 0.0 && a > 0.0 && a + b < c * (1.0 - ROUNDING)
    }

    fn is_nothing(&self) -> bool {
        self.mass == 0.0 && self.inertia.iter().all(|i| *i == 0.0)
    }
}

fn at_inertial(link: &Link, inertial: &Inertial, found: &str) -> Place {
    at("inertial", &link.name, inertial.line, found)
}

fn weighed(urdf: &Urdf) -> impl Iterator<Item = (&Link, &Inertial)> {
    urdf.links.iter().filter_map(|l| Some((l, l.inertial.as_ref()?)))
}

/// Links that move, one by one.
fn moving(urdf: &Urdf) -> impl Iterator<Item = &Link> {
    urdf.moving().into_values().flatten()
}

/// Links that a joint moves, not those that are fixed to one.
fn carried(urdf: &Urdf) -> impl Iterator<Item = &Link> {
    let links: BTreeMap<_, _> = urdf.links.iter().map(|l| (l.name.as_str(), l)).collect();
    let moved = urdf.joints.iter().filter(|j| j.moves());
    moved.filter_map(move |j| links.get(j.child.as_str()).copied())
}

/// Moments with A + B < C, which no body has.
pub(crate) fn triangle(urdf: &Urdf) -> Vec<Place> {
    let broken = weighed(urdf).filter(|(_, i)| i.breaks_triangle());
    let found = |i: &Inertial| {
        let [a, b, c] = i.principal();
        format!("moments {a:.4e}, {b:.4e}, {c:.4e}")
    };
    broken.map(|(l, i)| at_inertial(l, i, &found(i))).collect()
}

/// Links that move as one, weighed as nothing: all their masses or moments add up to 0 or less.
pub(crate) fn group_without_mass(urdf: &Urdf) -> Vec<Place> {
    let mut places = Vec::new();
    for links in urdf.moving().into_values() {
        let weights: Vec<_> =
            links.iter().filter_map(|l| Some((l, l.inertial.as_ref()?))).collect();
        let derived = links.iter().any(|l| l.inertial.is_none() && !l.collisions.is_empty());
        let mass: f64 = weights.iter().map(|(_, i)| i.mass).sum();
        let trace: f64 = weights.iter().map(|(_, i)| i.trace()).sum();
        if let (false, Some((link, inertial))) = (derived, weights.first())
            && (mass <= 0.0 || trace <= 0.0)
        {
            places.push(at_inertial(
                link,
                inertial,
                &format!("mass {mass}, moments {trace} in all"),
            ));
        }
    }
    places
}

/// Links that move as one, and of which nothing says what they weigh.
pub(crate) fn group_of_nothing(urdf: &Urdf) -> Vec<Place> {
    let is_nothing = |l: &&Link| l.inertial.is_none() && l.collisions.is_empty();
    let groups = urdf.moving().into_values().filter(|links| links.iter().all(is_nothing));
    groups.filter_map(|links| Some(at_link(links.first()?, "no inertial, no collision"))).collect()
}

/// Links at the end of a chain that weigh nothing.
pub(crate) fn end_without_mass(urdf: &Urdf) -> Vec<Place> {
    let is_nothing = |l: &&Link| l.inertial.is_none_or(|i| i.is_nothing());
    let moved = urdf.joints.iter().filter(|j| j.moves());
    let parents: BTreeSet<_> = moved.map(|j| j.parent.as_str()).collect();
    let carries = |l: &Link| parents.contains(l.name.as_str());
    let groups = urdf.moving().into_values();
    let light = groups.filter(|g| g.iter().all(is_nothing) && !g.iter().any(|l| carries(l)));
    light.filter_map(|links| Some(at_link(links.first()?, "no mass"))).collect()
}

/// Moving links without `<inertial>`, with shapes to weigh.
pub(crate) fn shaped_without_inertial(urdf: &Urdf) -> Vec<Place> {
    let bare = moving(urdf).filter(|l| l.inertial.is_none() && !l.collisions.is_empty());
    bare.map(|l| at_link(l, "no inertial")).collect()
}

/// Moving links without `<inertial>`.
pub(crate) fn without_inertial(urdf: &Urdf) -> Vec<Place> {
    moving(urdf).filter(|l| l.inertial.is_none()).map(|l| at_link(l, "no inertial")).collect()
}

/// Moving links without `<inertial>` and without shapes.
pub(crate) fn nothing(urdf: &Urdf) -> Vec<Place> {
    let bare = moving(urdf).filter(|l| l.inertial.is_none() && l.collisions.is_empty());
    bare.map(|l| at_link(l, "no inertial, no collision")).collect()
}

/// A mass below 0, or of 0 with moments.
pub(crate) fn impossible(urdf: &Urdf) -> Vec<Place> {
    let odd = weighed(urdf).filter(|(_, i)| i.mass < 0.0 || (i.mass == 0.0 && !i.is_nothing()));
    odd.map(|(l, i)| at_inertial(l, i, &format!("mass {}", i.mass))).collect()
}

/// Links that a joint moves, with a mass of 0.
pub(crate) fn zero(urdf: &Urdf) -> Vec<Place> {
    let light = carried(urdf).filter_map(|l| Some((l, l.inertial.as_ref()?)));
    let light = light.filter(|(_, i)| i.mass == 0.0);
    light.map(|(l, i)| at_inertial(l, i, "mass 0")).collect()
}

/// The same, or nothing that says what they weigh.
pub(crate) fn zero_or_nothing(urdf: &Urdf) -> Vec<Place> {
    let bare = carried(urdf).filter(|l| l.inertial.is_none() && l.collisions.is_empty());
    zero(urdf).into_iter().chain(bare.map(|l| at_link(l, "no inertial, no collision"))).collect()
}

/// Moving links with a mass or all moments of 0, and shapes.
pub(crate) fn shaped_zero(urdf: &Urdf) -> Vec<Place> {
    let shaped = moving(urdf).filter(|l| !l.collisions.is_empty());
    let light = shaped.filter_map(|l| Some((l, l.inertial.as_ref()?)));
    let light = light.filter(|(_, i)| i.mass == 0.0 || i.inertia.iter().all(|x| *x == 0.0));
    light.map(|(l, i)| at_inertial(l, i, &format!("mass {}", i.mass))).collect()
}

/// Links whose moments are not those of the box around their collisions, as far as both are known.
pub(crate) fn unlike_its_box(urdf: &Urdf) -> Vec<Place> {
    let mut places = Vec::new();
    for (link, inertial) in weighed(urdf).filter(|(_, i)| i.mass > 0.0) {
        let Some(boxed) = box_moments(link) else { continue };
        let [x, y, z, ..] = inertial.inertia;
        let differs = |(file, made): (f64, f64)| (file - made).abs() > ALIKE * file.max(made);
        let skew = inertial.inertia[3..].iter().any(|p| p.abs() > ALIKE * inertial.trace());
        if skew || [x, y, z].into_iter().zip(boxed).any(differs) {
            let [a, b, c] = boxed;
            let found = format!("{x:.3e} {y:.3e} {z:.3e} becomes about {a:.3e} {b:.3e} {c:.3e}");
            places.push(at_inertial(link, inertial, &found));
        }
    }
    places
}

/// The moments of a solid box of a link's collisions; `None` where it is turned or not known.
fn box_moments(link: &Link) -> Option<[f64; 3]> {
    let inertial = link.inertial.as_ref().filter(|i| !i.is_turned())?;
    let mut ends = [(f64::INFINITY, f64::NEG_INFINITY); 3];
    for shape in &link.collisions {
        let [low, high] = shape.bounds?;
        for (end, (low, high)) in ends.iter_mut().zip(low.into_iter().zip(high)) {
            *end = (end.0.min(low), end.1.max(high));
        }
    }
    if link.collisions.is_empty() {
        return None;
    }
    let [x, y, z] = ends.map(|(low, high)| (high - low).powi(2));
    let (mass, twelfth) = (inertial.mass, inertial.mass / 12.0);
    if let [only] = &link.collisions[..]
        && matches!(only.geometry, Geometry::Primitive("sphere"))
    {
        return Some([0.1 * mass * x; 3]); // 2/5 m r², and x is 4 r²
    }
    Some([twelfth * (y + z), twelfth * (x + z), twelfth * (x + y)])
}

/// Links that a joint moves, with a mass and without shapes.
pub(crate) fn weighed_without_shape(urdf: &Urdf) -> Vec<Place> {
    let bare = carried(urdf).filter(|l| l.collisions.is_empty());
    let bare = bare.filter_map(|l| Some((l, l.inertial.as_ref()?))).filter(|(_, i)| i.mass > 0.0);
    bare.map(|(l, i)| at_inertial(l, i, "no collision")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_come_out_of_a_turned_tensor() {
        let inertial = |inertia| Inertial { line: 1, mass: 1.0, inertia, ..Inertial::default() };
        let turned = inertial([2.0, 2.0, 5.0, 1.0, 0.0, 0.0]).principal();
        for (found, expected) in turned.into_iter().zip([1.0, 3.0, 5.0]) {
            assert!((found - expected).abs() < 1e-9, "{turned:?}");
        }
        assert_eq!(inertial([0.0; 6]).principal(), [0.0; 3]);
        assert!(inertial([2.0, 2.0, 5.0, 1.0, 0.0, 0.0]).breaks_triangle());
        assert!(!inertial([1.0, 1.0, 2.0, 0.0, 0.0, 0.0]).breaks_triangle(), "a thin plate");
    }
}
