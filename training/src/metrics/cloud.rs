//! The points of one part, ready to be asked for nearest neighbours; Chamfer distances.

use object::mesh::Bounds;
use object::{DPose3, DVec3};
use rstar::RTree;

use super::Body;

/// Points of one part at rest.
pub struct Cloud {
    /// The part.
    pub part: u16,
    /// Its points.
    pub points: Vec<DVec3>,
    /// The box around them.
    pub bounds: Bounds,
    /// Their mean.
    pub centroid: DVec3,
    nearest: RTree<[f64; 3]>,
}

impl Cloud {
    /// A cloud of at least one point; neighbours come to stand side by side, so that asking for one
    /// after the other finds them still in the cache.
    pub fn new(part: u16, mut points: Vec<DVec3>) -> Self {
        let bounds = Bounds::of(points.iter().copied());
        points.sort_by_cached_key(|&p| place_on_curve(&bounds, p));
        let centroid = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
        let nearest = RTree::bulk_load(points.iter().map(DVec3::to_array).collect());
        Self { part, points, bounds, centroid, nearest }
    }

    /// The parts of a body that have points, ascending.
    pub fn all_of(body: &Body) -> Vec<Self> {
        let mut of_part = vec![Vec::new(); body.links().len()];
        for (&point, &part) in body.points().iter().zip(body.part_of_point()) {
            of_part[usize::from(part)].push(point);
        }
        let numbered = (0..).zip(of_part);
        numbered.filter(|(_, points)| !points.is_empty()).map(|(p, c)| Self::new(p, c)).collect()
    }

    /// The box around the points in a pose.
    pub fn bounds_at(&self, pose: &DPose3) -> Bounds {
        Bounds::of(self.points.iter().map(|&p| *pose * p))
    }

    fn distance_squared(&self, to: DVec3) -> f64 {
        let found = self.nearest.nearest_neighbor_with_distance_2(to.to_array());
        found.map_or(f64::INFINITY, |(_, squared)| squared)
    }
}

/// Where a point comes on the Z-order curve through a box of 1,024 cells along each side.
fn place_on_curve(bounds: &Bounds, point: DVec3) -> u32 {
    let scale = 1023.0 / bounds.size().max_element().max(f64::MIN_POSITIVE);
    let cell = ((point - bounds.min) * scale).to_array().map(|x| x as u32);
    (0..10).fold(0, |key, bit| {
        (0..3).fold(key, |key, axis| key | (cell[axis] >> bit & 1) << (3 * bit + axis))
    })
}

/// Mean squared distance from each cloud to the nearest of the other, both directions added, each
/// cloud moved by its pose.
pub fn chamfer((a, pose_a): (&Cloud, DPose3), (b, pose_b): (&Cloud, DPose3)) -> f64 {
    one_way(a, b, pose_b.inv_mul(&pose_a)) + one_way(b, a, pose_a.inv_mul(&pose_b))
}

/// Mean squared distance of `from`'s points, taken into `to`'s rest frame, to the nearest of `to`.
fn one_way(from: &Cloud, to: &Cloud, there: DPose3) -> f64 {
    let squared = from.points.iter().map(|&p| to.distance_squared(there * p));
    squared.sum::<f64>() / from.points.len() as f64
}
