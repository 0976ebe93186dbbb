//! Where an object meets level ground, and what each place bears.

use std::ops::Range;

use glamx::{DQuat, DVec2, DVec3};
use nalgebra::{Cholesky, Matrix3, Vector3};

use crate::collision::piece::ConvexPiece;
use crate::collision::quickhull::hull;

/// Gravity the rules reckon with, m/s², along −z.
pub(crate) const GRAVITY: f64 = 9.81;
/// Thickness of what counts as touching the ground, as a share of the object's diagonal.
const LAYER: f64 = 0.002;
/// The same for a side of the hull, which is to be met exactly.
const FINE: f64 = 3e-4;
/// What the hull that is looked at for sides to stand on may leave out, as a share of the diagonal.
const COARSE: f64 = 2e-4;

/// A place that stands on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Foot {
    /// The part whose place it is.
    pub(crate) part: usize,
    /// Asset frame, metres.
    pub(crate) at: DVec3,
    /// What it bears, newtons, up.
    pub(crate) force: f64,
}

/// All corners an object may stand on, each with its part; asset frame, metres.
pub(crate) struct Ground {
    corners: Vec<(usize, DVec3)>,
    /// The box's diagonal, metres.
    pub(crate) diagonal: f64,
}

impl Ground {
    /// The corners of all parts' collision pieces.
    pub(crate) fn new(pieces: &[Vec<ConvexPiece>]) -> Self {
        let of = |(part, pieces): (usize, &Vec<ConvexPiece>)| {
            let corners: Vec<_> = pieces.iter().flat_map(|p| &p.vertices).copied().collect();
            corners.into_iter().map(move |at| (part, at))
        };
        let corners: Vec<_> = pieces.iter().enumerate().flat_map(of).collect();
        let bounds = object::mesh::Bounds::of(corners.iter().map(|c| c.1));
        Self { corners, diagonal: bounds.diagonal() }
    }

    /// The outline of what touches the ground where `down` is down, each corner with its part; `layer`
    /// is how thick that is, as a share of the diagonal.
    fn outline(&self, down: DVec3, layer: f64) -> Vec<(usize, DVec3)> {
        let depth = |at: &DVec3| at.dot(down);
        let lowest = self.corners.iter().map(|c| depth(&c.1)).fold(f64::NEG_INFINITY, f64::max);
        let touches = |c: &&(usize, DVec3)| depth(&c.1) >= lowest - layer * self.diagonal;
        let level = DQuat::from_rotation_arc(down, DVec3::NEG_Z);
        let flat = |c: &(usize, DVec3)| (level * c.1).truncate();
        around(self.corners.iter().filter(touches).copied().collect(), flat)
    }

    /// How far inside the outline of what touches the ground a point stands, metres, seen along
    /// `down`; negative outside, minus infinity where nothing can be stood on.
    pub(crate) fn margin(&self, down: DVec3, centre: DVec3) -> f64 {
        inside(&self.edges(down), centre)
    }

    /// The same of what touches the ground exactly, or all but.
    pub(crate) fn firm_margin(&self, down: DVec3, centre: DVec3) -> f64 {
        inside(&self.edges_within(down, FINE), centre)
    }

    /// The heights of what counts as touching the ground, metres.
    pub(crate) fn touching(&self) -> Range<f64> {
        let lowest = self.corners.iter().map(|c| c.1.z).fold(f64::INFINITY, f64::min);
        lowest..lowest + LAYER * self.diagonal
    }

    /// The edges of that outline; none if it has no area.
    pub(crate) fn edges(&self, down: DVec3) -> Vec<Edge> {
        self.edges_within(down, LAYER)
    }

    fn edges_within(&self, down: DVec3, layer: f64) -> Vec<Edge> {
        let corners = self.outline(down, layer);
        if corners.len() < 3 {
            return Vec::new();
        }
        let next = corners.iter().cycle().skip(1);
        let edge = |(a, b): (&(usize, DVec3), &(usize, DVec3))| {
            let inward = down.cross(a.1 - b.1).normalize_or_zero();
            Edge { from: a.1, inward, offset: inward.dot(a.1) }
        };
        corners.iter().zip(next).map(edge).collect()
    }

    /// Directions in which a side of the hull faces on which an object with its centre of mass at
    /// `centre` can stand, those nearest straight down first, with the angle to it, up to `most`
    /// radians.
    pub(crate) fn sides(&self, centre: DVec3, most: f64) -> Vec<(f64, DVec3)> {
        let points: Vec<DVec3> = self.corners.iter().map(|c| c.1).collect();
        let Some(hull) = hull(&points, points.len(), COARSE * self.diagonal) else {
            return Vec::new();
        };
        let corner = |i: u32| hull.vertices[i as usize];
        let faces = hull.faces.iter().map(|f| f.map(corner));
        let normals = faces.map(|[a, b, c]| (b - a).cross(c - a).normalize_or_zero());
        let leaning = normals.map(|n| (n.angle_between(DVec3::NEG_Z), n));
        let bears = |down| self.firm_margin(down, centre) > 0.0;
        let mut sides: Vec<_> = leaning.filter(|s| s.0 <= most && bears(s.1)).collect();
        sides.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.x.total_cmp(&b.1.x)));
        sides
    }

    /// What each corner of the outline bears where an object of this weight (newtons) stands on it
    /// with its centre of mass at `centre`; nothing where it does not stand. Of all the ways to
    /// share a weight out, the most even one.
    pub(crate) fn feet(&self, weight: f64, centre: DVec3) -> Vec<Foot> {
        let mut corners = self.outline(DVec3::NEG_Z, LAYER);
        if self.margin(DVec3::NEG_Z, centre) <= 0.0 {
            return Vec::new();
        }
        while corners.len() >= 3 {
            let Some(forces) = shared(weight, centre, &corners) else { break };
            if forces.iter().all(|f| *f >= 0.0) {
                let foot = |(&(part, at), &force)| Foot { part, at, force };
                return corners.iter().zip(&forces).map(foot).collect();
            }
            let mut pushes = forces.iter().map(|f| *f >= 0.0);
            corners.retain(|_| pushes.next().unwrap_or(true));
        }
        Vec::new()
    }
}

/// One edge of an outline.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    /// Its first corner, metres.
    pub(crate) from: DVec3,
    inward: DVec3,
    offset: f64,
}

impl Edge {
    /// How far inside a point stands, metres.
    pub(crate) fn inside(&self, point: DVec3) -> f64 {
        self.inward.dot(point) - self.offset
    }
}

/// How far inside all edges a point stands, metres; minus infinity where there are none.
fn inside(edges: &[Edge], point: DVec3) -> f64 {
    edges.iter().map(|e| e.inside(point)).min_by(f64::total_cmp).unwrap_or(f64::NEG_INFINITY)
}

/// The points that span the others, counter-clockwise (Andrew's monotone chain).
fn around<T: Copy>(mut points: Vec<T>, flat: impl Fn(&T) -> DVec2) -> Vec<T> {
    let before = |a: &T, b: &T| {
        let (a, b) = (flat(a), flat(b));
        a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y))
    };
    points.sort_by(before);
    points.dedup_by(|a, b| flat(a) == flat(b));
    if points.len() < 3 {
        return points;
    }
    let side = |points: &mut dyn Iterator<Item = T>| {
        let mut side: Vec<T> = Vec::new();
        for p in points {
            while let [.., a, b] = &side[..]
                && (flat(b) - flat(a)).perp_dot(flat(&p) - flat(b)) <= 0.0
            {
                side.pop();
            }
            side.push(p);
        }
        side.pop();
        side
    };
    let mut ring = side(&mut points.iter().copied());
    ring.extend(side(&mut points.iter().rev().copied()));
    ring
}

/// Forces of least squares that bear `weight` about `centre`: each is an affine function of its
/// place. `None` if the places lie in a line.
fn shared(weight: f64, centre: DVec3, corners: &[(usize, DVec3)]) -> Option<Vec<f64>> {
    let row = |at: DVec3| DVec3::new(1.0, at.x - centre.x, at.y - centre.y);
    let rows: Vec<DVec3> = corners.iter().map(|c| row(c.1)).collect();
    let of = |r: &DVec3| Vector3::from(r.to_array());
    let gram: Matrix3<f64> = rows.iter().map(|r| of(r) * of(r).transpose()).sum();
    let spread = rows.iter().map(|r| r.y * r.y + r.z * r.z).sum::<f64>();
    let usable = gram.determinant() > 1e-9 * spread * spread;
    let solver = Cholesky::new(gram).filter(|_| usable)?;
    let by = DVec3::from_array(solver.solve(&Vector3::new(weight, 0.0, 0.0)).into());
    Some(rows.iter().map(|r| r.dot(by)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::block;

    fn piece(size: DVec3, centre: DVec3) -> ConvexPiece {
        let mesh = block(size, centre);
        ConvexPiece { vertices: mesh.vertices().to_vec(), faces: mesh.faces().to_vec() }
    }

    fn table() -> Ground {
        let leg = |x, y| piece(DVec3::new(0.1, 0.1, 0.7), DVec3::new(x, y, 0.35));
        let top = piece(DVec3::new(1.2, 0.8, 0.05), DVec3::new(0.0, 0.0, 0.725));
        Ground::new(&[vec![top], vec![leg(0.5, 0.3), leg(0.5, -0.3)], vec![leg(-0.5, 0.0)]])
    }

    #[test]
    fn a_table_on_three_legs_stands_inside_their_outline() {
        let table = table();
        let margin = table.margin(DVec3::NEG_Z, DVec3::new(0.3, 0.0, 0.7));
        assert!((margin - 0.25).abs() < 1e-9, "{margin}");
        assert!(table.margin(DVec3::NEG_Z, DVec3::new(0.7, 0.0, 0.7)) < -0.1);
    }

    #[test]
    fn what_the_feet_bear_is_the_weight_about_the_centre() {
        let centre = DVec3::new(0.2, 0.05, 0.7);
        let feet = table().feet(100.0, centre);
        let sum: f64 = feet.iter().map(|f| f.force).sum();
        let moment: DVec3 = feet.iter().map(|f| (f.at - centre) * f.force).sum();
        assert!((sum - 100.0).abs() < 1e-9 && moment.truncate().length() < 1e-9, "{feet:?}");
        assert!(feet.iter().all(|f| f.force >= 0.0 && f.part != 0));
        assert!(table().feet(100.0, DVec3::X).is_empty(), "it does not stand");
    }

    #[test]
    fn a_wedge_has_the_side_it_leans_on() {
        let turn = DQuat::from_rotation_y(0.1);
        let mut leaning = piece(DVec3::new(0.4, 0.3, 0.2), DVec3::ZERO);
        leaning.vertices.iter_mut().for_each(|v| *v = turn * *v);
        let ground = Ground::new(&[vec![leaning]]);
        assert_eq!(
            ground.margin(DVec3::NEG_Z, DVec3::ZERO),
            f64::NEG_INFINITY,
            "an edge is no side"
        );
        let (lean, down) = ground.sides(DVec3::ZERO, 0.2)[0];
        assert!((lean - 0.1).abs() < 1e-5, "{lean}");
        assert!((ground.margin(down, DVec3::ZERO) - 0.15).abs() < 1e-5);
    }
}
