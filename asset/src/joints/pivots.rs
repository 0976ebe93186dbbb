//! Where joint frames sit: on the axis, close to both parts they join.

use glamx::DVec3;
use object::{ArticulatedObject, JointMotion, Mesh};
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::TriMesh;

use crate::surface::repaired::Surface;

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::repair::repair;
    use crate::surface::simplify::joined;
    use crate::tests::block;
    use object::{JointKind, KinematicTree, Part, Range};

    /// A post of a metre's breadth and a door beside it, x from 0.5 to 1.5.
    fn post_and_door() -> (Pivots, Mesh) {
        let post = block(DVec3::new(1.0, 1.0, 2.0), DVec3::ZERO);
        let door = block(DVec3::new(1.0, 0.1, 2.0), DVec3::X);
        let (mesh, labels) = joined(&[&post, &door]).unwrap();
        let part = |name: &str, parent| Part {
            name: name.into(),
            text: name.into(),
            parent,
            joints: vec![],
        };
        let tree = KinematicTree::new(vec![part("post", None), part("door", Some(0))]).unwrap();
        let object = ArticulatedObject::new(mesh, tree, labels, vec![vec![], vec![]]).unwrap();
        let surfaces = [&post, &door].map(|m| repair(m, None).unwrap());
        (Pivots::new(&object, &surfaces), door)
    }

    fn hinge(pivot: DVec3) -> JointMotion {
        let range = Range::Limits { lower: 0.0, upper: 1.0 };
        JointMotion { kind: JointKind::Revolute, axis: DVec3::Z, pivot, range }
    }

    #[test]
    fn a_pivot_near_both_parts_stays_to_the_last_bit() {
        let (pivots, door) = post_and_door();
        let fitted = DVec3::new(0.5, 0.05, 0.123);
        assert_eq!(pivots.settle(&hinge(fitted), [1, 0], &door), fitted);
    }

    #[test]
    fn a_pivot_far_along_its_axis_comes_back_along_it() {
        let (pivots, door) = post_and_door();
        let moved = pivots.settle(&hinge(DVec3::new(0.5, 0.05, 40.0)), [1, 0], &door);
        assert_eq!((moved.x, moved.y), (0.5, 0.05));
        assert!(moved.z.abs() <= 1.0 + 1e-9, "{moved}");
    }

    #[test]
    fn a_slide_has_its_frame_where_the_parts_meet() {
        let (pivots, door) = post_and_door();
        let slide = JointMotion { kind: JointKind::Prismatic, ..hinge(DVec3::splat(9.0)) };
        assert_eq!(pivots.settle(&slide, [1, 0], &door).x, 0.5);
    }
}
