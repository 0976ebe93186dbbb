//! Where joint frames sit: on the axis, close to both parts they join.

use glamx::DVec3;
use object::{ArticulatedObject, JointMotion, Mesh};
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::TriMesh;

use crate::repair::Surface;

/// A pivot this close to both parts stays as it was fitted, as a share of the asset's diagonal.
const NEAR: f64 = 0.02;
/// A pivot moves only for a gain of this share of the nearness wanted.
const WORTH: f64 = 0.1;
/// Places tried along an axis, or over a part.
const TRIES: usize = 128;

/// Distances to the parts of an object.
pub(crate) struct Pivots {
    shapes: Vec<Option<TriMesh>>,
    near: f64,
}

impl Pivots {
    pub(crate) fn new(object: &ArticulatedObject, surfaces: &[Surface]) -> Self {
        let shape =
            |s: &Surface| TriMesh::new(s.mesh.vertices().to_vec(), s.mesh.faces().to_vec()).ok();
        let near = NEAR * object.mesh().bounds().diagonal();
        Self { shapes: surfaces.iter().map(shape).collect(), near }
    }

    fn distance(&self, part: usize, point: DVec3) -> f64 {
        let shape = self.shapes.get(part).and_then(Option::as_ref);
        shape.map_or(0.0, |s| s.distance_to_local_point(point, false))
    }

    /// Distance of a point to the farther of two parts.
    fn reach(&self, pair: [usize; 2], point: DVec3) -> f64 {
        self.distance(pair[0], point).max(self.distance(pair[1], point))
    }

    /// The pivot of a motion between two parts: as fitted if it is near both, else moved to where
    /// it is nearest both, which for a hinge is along the axis and changes no motion.
    pub(crate) fn settle(&self, motion: &JointMotion, pair: [usize; 2], child: &Mesh) -> DVec3 {
        if self.reach(pair, motion.pivot) <= self.near {
            return motion.pivot;
        }
        if !motion.kind.turns() {
            return self.contact(pair, child);
        }
        let along = |p: DVec3| (p - motion.pivot).dot(motion.axis);
        let ends = child.vertices().iter().map(|&v| along(v));
        let (low, high) =
            ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| (l.min(t), h.max(t)));
        let step = (high - low) / (TRIES - 1) as f64;
        let tries = (0..TRIES).map(|i| motion.pivot + motion.axis * (low + step * i as f64));
        self.nearest(pair, std::iter::once(motion.pivot).chain(tries), motion.pivot)
    }

    /// The point of a child that lies nearest to its parent.
    pub(crate) fn contact(&self, pair: [usize; 2], child: &Mesh) -> DVec3 {
        let vertices = child.vertices();
        let stride = vertices.len().div_ceil(TRIES * 8).max(1);
        let some = vertices.iter().step_by(stride).copied();
        let first = vertices.first().copied().unwrap_or(DVec3::ZERO);
        self.nearest(pair, some, first)
    }

    fn nearest(
        &self,
        pair: [usize; 2],
        candidates: impl Iterator<Item = DVec3>,
        start: DVec3,
    ) -> DVec3 {
        let mut best = (self.reach(pair, start), start);
        for point in candidates {
            let reach = self.reach(pair, point);
            if reach < best.0 - self.near * WORTH {
                best = (reach, point);
            }
        }
        best.1
    }
}
