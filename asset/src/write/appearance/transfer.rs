//! Where the faces of a finished surface lie on the surface that they were made from.
//!
//! Between the two a surface is repaired, simplified, capped and cut. A face that lies on the old
//! surface takes material and texture coordinates from the face it lies on: exactly where it is one of
//! the old faces or a piece of one. A face that lies across several, after simplifying, takes each
//! corner's coordinates from the old vertex there, on the same chart: simplifying keeps seams where they
//! are. A back takes what its front has. A cap has nothing below it and takes one colour of its rim.

use std::collections::BTreeMap;

use glamx::DVec3;
use object::Mesh;
use object::appearance::Surfacing;
use object::weld::{DisjointSets, Weld};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::query::PointQueryWithLocation as _;
use parry3d_f64::shape::TriMesh;

/// Welding moves a corner by no more than this share of the diagonal: ten times its tolerance.
const TOLERANCE: f64 = 1e-5;
/// What lies farther off than this share of the diagonal is no simplified face. Simplifying moves a
/// surface by 0.005 of its largest side at first; further steps are seldom. Tuned by eye.
const NEAR: f64 = 0.01;
/// A sheet's back lies no farther off: its wall is at most 0.02 of the diagonal.
const BACK: f64 = 0.03;
/// Cosines up to which a face agrees with what it lies near: 60° for a simplified one, 37° for a back.
const AGREES: [f64; 2] = [0.5, 0.8];
/// A barycentric coordinate so close to 1 is the corner itself.
const CORNER: f64 = 1e-4;
/// How far outside of a triangle a point still counts as on it, in barycentric coordinates.
const OUTSIDE: f64 = 1e-3;

/// A part's surface as it came, and how it looks.
pub(crate) struct Source {
    surface: TriMesh,
    corners: Vec<[DVec3; 3]>,
    normals: Vec<DVec3>,
    looks: Vec<Surfacing>,
    /// The chart of each face: faces that hang together on the texture, too.
    charts: Vec<u32>,
    /// Places by cell, with the charts that meet there and their coordinates.
    wedges: BTreeMap<[i64; 3], Vec<Wedge>>,
    diagonal: f64,
}

/// A place of one chart.
#[derive(Clone, Copy)]
struct Wedge {
    at: DVec3,
    chart: u32,
    uv: [f32; 2],
}

impl Source {
    /// A surface with what each of its faces has, in the same order; none where no face has an area.
    pub(crate) fn new(mesh: &Mesh, looks: &[Surfacing]) -> Option<Self> {
        let weld = Weld::new(mesh);
        let sound = (0..mesh.faces().len()).filter(|&f| mesh.normal(f) != DVec3::ZERO);
        let sound: Vec<usize> = sound.filter(|&f| f < looks.len()).collect();
        let corners: Vec<_> = sound.iter().map(|&f| mesh.corners(f)).collect();
        let looks: Vec<_> = sound.iter().map(|&f| looks[f]).collect();
        let faces = (0..sound.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        let surface = TriMesh::new(corners.concat(), faces).ok()?;
        let places: Vec<_> = sound.iter().map(|&f| weld.faces[f]).collect();
        let charts = charts(&places, &looks);
        let mut source = Self {
            surface,
            normals: sound.iter().map(|&f| mesh.normal(f)).collect(),
            corners,
            looks,
            charts,
            wedges: BTreeMap::new(),
            diagonal: mesh.bounds().diagonal(),
        };
        for (face, of) in places.iter().enumerate() {
            for (place, uv) in of.iter().zip(source.looks[face].corners) {
                let at = weld.places[*place as usize];
                let wedge = Wedge { at, chart: source.charts[face], uv };
                let cell = source.cell(at);
                let there = source.wedges.entry(cell).or_default();
                if !there.iter().any(|w| w.chart == wedge.chart && w.at == at && w.uv == uv) {
                    there.push(wedge);
                }
            }
        }
        Some(source)
    }

    /// What a face with these corners has of the old surface.
    pub(crate) fn of_face(&self, corners: [DVec3; 3]) -> Surfacing {
        let [a, b, c] = corners;
        let (middle, normal) = ((a + b + c) / 3.0, (b - a).cross(c - a).normalize_or_zero());
        let Some((face, off)) = self.below(middle, normal) else { return Surfacing::default() };
        let agrees = self.normals[face].dot(normal).abs();
        let is_on = off <= TOLERANCE * self.diagonal
            || off <= NEAR * self.diagonal && agrees >= AGREES[0]
            || off <= BACK * self.diagonal && agrees >= AGREES[1];
        if !is_on || agrees < AGREES[0] {
            return self.rim(corners, middle);
        }
        let material = self.looks[face].material;
        Surfacing { material, corners: corners.map(|p| self.uv(face, p)) }
    }

    /// The face a point lies on, or is nearest to, and how far off that is; of several the one that
    /// faces the same way.
    fn below(&self, p: DVec3, normal: DVec3) -> Option<(usize, f64)> {
        let slack = TOLERANCE * self.diagonal;
        if let Some(found) = self.best_within(p, normal, slack) {
            return Some(found);
        }
        let (nearest, _) = self.surface.project_local_point_and_get_location(p, false);
        self.best_within(p, normal, nearest.point.distance(p) + slack)
    }

    fn best_within(&self, p: DVec3, normal: DVec3, reach: f64) -> Option<(usize, f64)> {
        let near = Aabb::new(p - DVec3::splat(reach), p + DVec3::splat(reach));
        let mut best: Option<(f64, f64, usize)> = None;
        for face in self.surface.bvh().intersect_aabb(&near).map(|f| f as usize) {
            let Some(corners) = self.corners.get(face) else { continue };
            let off = object::weld::nearest_on_triangle(p, *corners).distance(p);
            // Rounding must not choose between faces that agree alike.
            let agrees = (self.normals[face].dot(normal) * 1e3).round();
            let is_better = |(a, o, f): (f64, f64, usize)| {
                (agrees, -off, -(face as f64)) > (a, -o, -(f as f64))
            };
            if off <= reach && best.is_none_or(is_better) {
                best = Some((agrees, off, face));
            }
        }
        best.map(|(_, off, face)| (face, off))
    }

    /// Where a point over a face lies on the texture.
    fn uv(&self, face: usize, p: DVec3) -> [f32; 2] {
        let weights = weights(p, self.corners[face]);
        if weights.iter().all(|w| *w >= -OUTSIDE) {
            return self.mixed(face, weights);
        }
        let chart = self.charts[face];
        if let Some(uv) = self.wedge(p, chart) {
            return uv;
        }
        let on = self.nearest_on(chart, p).unwrap_or(face);
        let at = object::weld::nearest_on_triangle(p, self.corners[on]);
        self.mixed(on, weights_within(at, self.corners[on]))
    }

    /// The face of a chart that is as near to a point as any face is, if there is one.
    fn nearest_on(&self, chart: u32, p: DVec3) -> Option<usize> {
        let (nearest, _) = self.surface.project_local_point_and_get_location(p, false);
        let reach = nearest.point.distance(p) + TOLERANCE * self.diagonal;
        let near = Aabb::new(p - DVec3::splat(reach), p + DVec3::splat(reach));
        let off = |f: usize| object::weld::nearest_on_triangle(p, self.corners[f]).distance(p);
        let own = self.surface.bvh().intersect_aabb(&near).map(|f| f as usize);
        let own = own.filter(|f| self.charts.get(*f) == Some(&chart)).map(|f| (off(f), f));
        let best = own.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?;
        (best.0 <= reach).then_some(best.1)
    }

    fn mixed(&self, face: usize, weights: [f64; 3]) -> [f32; 2] {
        let of = self.looks[face].corners;
        if let Some(k) = weights.iter().position(|w| *w > 1.0 - CORNER) {
            return of[k];
        }
        [0, 1].map(|axis| {
            let sum: f64 = (0..3).map(|k| weights[k] * f64::from(of[k][axis])).sum();
            sum as f32
        })
    }

    /// The coordinates of a chart at one of its corners.
    fn wedge(&self, p: DVec3, chart: u32) -> Option<[f32; 2]> {
        let [x, y, z] = self.cell(p);
        let around = (0..27).map(|n| [x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1]);
        let near = around.filter_map(|cell| self.wedges.get(&cell)).flatten();
        let own = near.filter(|w| w.chart == chart).map(|w| (w.at.distance(p), w.uv));
        let nearest = own.min_by(|a, b| a.0.total_cmp(&b.0))?;
        (nearest.0 <= TOLERANCE * self.diagonal).then_some(nearest.1)
    }

    fn cell(&self, p: DVec3) -> [i64; 3] {
        let size = (TOLERANCE * self.diagonal).max(f64::MIN_POSITIVE);
        p.to_array().map(|c| (c / size).floor() as i64)
    }

    /// One place of the old surface for a face that lies off it: at a corner on it, or nearest.
    fn rim(&self, corners: [DVec3; 3], middle: DVec3) -> Surfacing {
        let nearest = |p: DVec3| {
            let (found, (face, _)) = self.surface.project_local_point_and_get_location(p, false);
            (found.point.distance(p), found.point, face as usize)
        };
        let on = corners.map(nearest).into_iter().find(|n| n.0 <= TOLERANCE * self.diagonal);
        let (_, at, face) = on.unwrap_or_else(|| nearest(middle));
        let Some(of) = self.corners.get(face) else { return Surfacing::default() };
        let uv = self.mixed(face, weights_within(at, *of));
        Surfacing { material: self.looks[face].material, corners: [uv; 3] }
    }
}

/// Faces that share a place with the same coordinates on the same material are one chart.
fn charts(places: &[[u32; 3]], looks: &[Surfacing]) -> Vec<u32> {
    let mut sets = DisjointSets::new(places.len());
    let mut first = BTreeMap::new();
    for (face, (of, look)) in (0u32..).zip(places.iter().zip(looks)) {
        for (place, uv) in of.iter().zip(look.corners) {
            let key = (*place, look.material, uv.map(f32::to_bits));
            sets.join(face, *first.entry(key).or_insert(face));
        }
    }
    (0..places.len() as u32).map(|f| sets.root(f)).collect()
}

/// Barycentric coordinates of a point's foot in the plane of a triangle with an area.
fn weights(p: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let normal = ab.cross(ac);
    let whole = normal.length_squared().max(f64::MIN_POSITIVE);
    let v = ap.cross(ac).dot(normal) / whole;
    let w = ab.cross(ap).dot(normal) / whole;
    [1.0 - v - w, v, w]
}

/// The same, none below 0, adding up to 1.
fn weights_within(p: DVec3, of: [DVec3; 3]) -> [f64; 3] {
    let kept = weights(p, of).map(|w| if w.is_finite() { w.clamp(0.0, 1.0) } else { 0.0 });
    let sum: f64 = kept.iter().sum();
    if sum > 0.0 { kept.map(|w| w / sum) } else { [1.0, 0.0, 0.0] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of two squares in the plane z = 0, each a chart of its own on the same texture.
    fn strip() -> Source {
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let square = |x: f64| [p(x, 0.0), p(x + 1.0, 0.0), p(x + 1.0, 1.0), p(x, 1.0)];
        let vertices = [square(0.0), square(1.0)].concat();
        let faces = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        let look = |material, u: f32, corners: [[f32; 2]; 3]| Surfacing {
            material: Some(material),
            corners: corners.map(|[x, y]| [x * 0.25 + u, y]),
        };
        let [low, high] =
            [[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]];
        let looks = [look(0, 0.0, low), look(0, 0.0, high), look(1, 0.5, low), look(1, 0.5, high)];
        Source::new(&Mesh::new(vertices, faces).unwrap(), &looks).unwrap()
    }

    #[test]
    fn a_piece_of_a_face_has_its_place_on_the_texture() {
        let on = strip().of_face([
            DVec3::new(0.25, 0.0, 0.0),
            DVec3::new(0.75, 0.0, 0.0),
            DVec3::new(0.75, 0.5, 0.0),
        ]);
        assert_eq!(
            (on.material, on.corners),
            (Some(0), [[0.0625, 0.0], [0.1875, 0.0], [0.1875, 0.5]])
        );
    }

    #[test]
    fn a_face_across_two_old_ones_keeps_the_corners_of_its_own_chart() {
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.001);
        let on = strip().of_face([p(1.0, 0.0), p(2.0, 0.0), p(1.0, 1.0)]);
        assert_eq!(on.material, Some(1));
        let due = [[0.5, 0.0], [0.75, 0.0], [0.5, 1.0]];
        assert!(
            on.corners
                .iter()
                .flatten()
                .zip(due.iter().flatten())
                .all(|(a, b): (&f32, &f32)| (a - b).abs() < 1e-4),
            "{on:?}"
        );
    }

    #[test]
    fn a_cap_takes_one_colour_of_its_rim() {
        let on = strip().of_face([DVec3::X, DVec3::ZERO, DVec3::new(0.5, 0.0, -1.0)]);
        assert!(
            on.material.is_some()
                && on.corners[0] == on.corners[1]
                && on.corners[1] == on.corners[2]
        );
    }

    #[test]
    fn a_back_shows_what_its_front_shows() {
        let p = |x: f64, y: f64| DVec3::new(x, y, -0.04);
        let on = strip().of_face([p(0.0, 0.0), p(1.0, 1.0), p(1.0, 0.0)]);
        assert_eq!((on.material, on.corners), (Some(0), [[0.0, 0.0], [0.25, 1.0], [0.25, 0.0]]));
    }
}
