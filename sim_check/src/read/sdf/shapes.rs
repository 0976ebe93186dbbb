//! Visuals and collisions of an SDFormat link, and what they weigh where nothing else says it.

use std::sync::Arc;

use glamx::{DPose3, DVec3};
use object::Mesh;

use super::numbers::{due, flaw, vector};
use super::tree::{Element, beside};
use crate::mass::solid::Solid;
use crate::read::cone::cone;
use crate::read::draft::Faults;
use crate::read::meshes::Shelf;
use crate::read::rgba::rgba;
use crate::read::xml::shown;
use crate::robot::{Geometry, Shape};

/// What a collision may touch where nothing is said, and whom it counts as.
const ALL: u32 = 0xffff;
/// Most points of an outline, since each pair of its edges is looked at; a guess with room.
const MOST_POINTS: usize = 2048;

/// Reads shapes: meshes come from the shelf.
pub(super) struct Shapes<'w> {
    pub shelf: &'w mut Shelf,
    pub faults: &'w mut Faults,
}

impl Shapes<'_> {
    /// The shape of a `visual` or `collision` that stands at `origin` in its link; none of a plane, which is
    /// the ground and no part of anything, nor of what is empty.
    pub(super) fn shape(&mut self, of: &Element, origin: DPose3) -> Option<Shape> {
        let line = of.line;
        let mut shape = Shape {
            origin,
            geometry: Geometry::Unread { reason: format!("line {line}: no geometry") },
            scale: DVec3::ONE,
            source: String::new(),
            colour: colour(of),
            mask: mask(of),
            line,
        };
        let told = of.child("geometry").and_then(|g| g.children.first());
        let Some(kind) = told else {
            flaw(self.faults, of, "has no geometry");
            return Some(shape);
        };
        if matches!(kind.tag.as_str(), "plane" | "empty") {
            return None;
        }
        let known = self.faults.numbers.len();
        shape.source.clone_from(&kind.tag);
        shape.geometry = self.geometry(kind, &mut shape.scale, &mut shape.source);
        if let Some(reason) = self.faults.numbers.get(known).cloned() {
            shape.geometry = Geometry::Unread { reason };
        }
        Some(shape)
    }

    fn geometry(&mut self, of: &Element, scale: &mut DVec3, source: &mut String) -> Geometry {
        let line = of.line;
        let mut due = |tag| due(self.faults, of, tag);
        match of.tag.as_str() {
            "box" => match self.three(of, "size") {
                Some(size) => Geometry::Box { size },
                None => unread(of, "a box without size"),
            },
            "ellipsoid" => match self.three(of, "radii") {
                Some(half) => Geometry::Ellipsoid { half },
                None => unread(of, "an ellipsoid without radii"),
            },
            "sphere" => Geometry::Sphere { radius: due("radius") },
            "cylinder" => Geometry::Cylinder { radius: due("radius"), length: due("length") },
            "capsule" => Geometry::Capsule { radius: due("radius"), length: due("length") },
            "cone" => cone(due("radius"), due("length"), line),
            "polyline" => self.polyline(of),
            "mesh" => self.mesh(of, scale, source),
            other => unread(of, &format!("a shape of kind `{}` is not read here", shown(other))),
        }
    }

    fn three(&mut self, of: &Element, tag: &str) -> Option<DVec3> {
        match of.child(tag) {
            Some(told) => vector(self.faults, told),
            None => {
                flaw(self.faults, of, format!("has no `{tag}`"));
                None
            }
        }
    }

    fn mesh(&mut self, of: &Element, scale: &mut DVec3, source: &mut String) -> Geometry {
        if of.child("scale").is_some() {
            *scale = self.three(of, "scale").unwrap_or(DVec3::ONE);
        }
        let uri = of.said("uri").or(of.said("filename")).unwrap_or_default();
        *source = beside(&of.file.folder, uri);
        if of.child("submesh").is_some() {
            return unread(of, "a part of a mesh file (`submesh`) is not read here");
        }
        let mut faults = Vec::new();
        let geometry = self.shelf.geometry(source, *scale, &mut faults);
        let line = of.line;
        self.faults.files.extend(faults.into_iter().map(|f| format!("line {line}: {f}")));
        geometry
    }

    /// A prism over an outline.
    fn polyline(&mut self, of: &Element) -> Geometry {
        let height = due(self.faults, of, "height");
        if of.children.len() > MOST_POINTS {
            let words = format!("an outline of more than {MOST_POINTS} points is not read here");
            return unread(of, &words);
        }
        let mut points = Vec::new();
        for point in of.all("point") {
            match super::numbers::numbers(self.faults, point, 2) {
                Some(xy) => points.push([xy[0], xy[1]]),
                None => return unread(of, "a point that is none"),
            }
        }
        match prism(points, height) {
            Some(mesh) => Geometry::Mesh(Arc::new(mesh)),
            None => unread(of, "an outline that crosses itself or encloses nothing"),
        }
    }
}

fn unread(of: &Element, what: &str) -> Geometry {
    Geometry::Unread { reason: format!("line {}: {what}", of.line) }
}

/// The solid between an outline and the same one higher up; its ears are cut off one by one.
fn prism(mut points: Vec<[f64; 2]>, height: f64) -> Option<Mesh> {
    if points.len() > 1 && points.first() == points.last() {
        points.pop();
    }
    points.dedup();
    let cross = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let around = |p: &[[f64; 2]]| -> f64 {
        (1..p.len().saturating_sub(1)).map(|i| cross(p[0], p[i], p[i + 1])).sum()
    };
    if points.len() < 3 || height <= 0.0 {
        return None;
    }
    if around(&points) < 0.0 {
        points.reverse();
    }
    let count = points.len();
    let edge = |e: usize| (points[e], points[(e + 1) % count]);
    let crosses = |e: usize, f: usize| {
        let ((a, b), (c, d)) = (edge(e), edge(f));
        cross(a, b, c) * cross(a, b, d) < 0.0 && cross(c, d, a) * cross(c, d, b) < 0.0
    };
    if around(&points) <= 0.0 || (0..count).any(|e| (0..e).any(|f| crosses(e, f))) {
        return None;
    }
    let (mut left, mut lids): (Vec<usize>, Vec<[usize; 3]>) = ((0..count).collect(), Vec::new());
    while left.len() > 3 {
        let n = left.len();
        let ear = (0..n).find(|&i| {
            let [a, b, c] = [left[(i + n - 1) % n], left[i], left[(i + 1) % n]];
            let [pa, pb, pc] = [a, b, c].map(|v| points[v]);
            let is_inside = |v: &usize| {
                let p = points[*v];
                ![pa, pb, pc].contains(&p)
                    && cross(pa, pb, p) >= 0.0
                    && cross(pb, pc, p) >= 0.0
                    && cross(pc, pa, p) >= 0.0
            };
            cross(pa, pb, pc) > 0.0 && !left.iter().any(is_inside)
        })?;
        lids.push([left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]]);
        left.remove(ear);
    }
    lids.push([left[0], left[1], left[2]]);
    let level = |z: f64| points.iter().map(move |p| DVec3::new(p[0], p[1], z));
    let vertices = level(0.0).chain(level(height)).collect();
    let of = |v: [usize; 3]| v.map(|v| v as u32);
    let mut faces = Vec::new();
    for [a, b, c] in lids {
        faces.extend([of([a, c, b]), of([a + count, b + count, c + count])]);
    }
    for a in 0..count {
        let b = (a + 1) % count;
        faces.extend([of([a, b, b + count]), of([a, b + count, a + count])]);
    }
    Mesh::new(vertices, faces).ok()
}

/// The solid an element's geometry fills where that is known better than by its surface.
pub(super) fn solid(of: &Element, geometry: &Geometry) -> Option<Solid> {
    let kind = of.child("geometry")?.children.first()?;
    let said = |tag: &str| kind.said(tag)?.parse().ok();
    match kind.tag.as_str() {
        "cone" => Solid::cone(said("radius")?, said("length")?),
        _ => crate::mass::solid::solid(geometry),
    }
}

/// The colour of a shape; none where a picture or a script gives it.
fn colour(of: &Element) -> Option<[u8; 4]> {
    let material = of.child("material")?;
    let has_picture = material.child("pbr").is_some_and(|pbr| {
        let maps = pbr.children.iter().flat_map(|kind| &kind.children);
        maps.into_iter().any(|map| map.tag == "albedo_map")
    });
    let told = if has_picture { None } else { material.said("diffuse") };
    told.and_then(rgba)
}

/// What a shape counts as, and what it meets.
fn mask(of: &Element) -> [u32; 2] {
    let contact = of.child("surface").and_then(|s| s.child("contact"));
    let bits = |tag: &str| {
        let word = contact?.said(tag)?;
        let hex = word.strip_prefix("0x").or(word.strip_prefix("0X"));
        match hex {
            Some(hex) => u32::from_str_radix(hex, 16).ok(),
            None => word.parse().ok(),
        }
    };
    let meets = bits("collide_bitmask").unwrap_or(ALL);
    [bits("category_bitmask").unwrap_or(meets), meets]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_prism_over_an_outline_with_a_notch_is_closed_and_has_its_volume() {
        let outline = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 1.0], [0.0, 2.0]];
        let turned = outline.iter().rev().copied().collect();
        for points in [outline.clone(), turned] {
            let mesh = prism(points, 0.5).unwrap();
            assert!((mesh.signed_volume() - 1.5).abs() < 1e-12, "{}", mesh.signed_volume());
        }
        let crossed = vec![[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
        assert!(prism(crossed, 1.0).is_none() && prism(vec![[0.0; 2]; 5], 1.0).is_none());
    }
}
