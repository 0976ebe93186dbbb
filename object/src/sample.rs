//! Points spread evenly over a surface, the same for the same seed.

use glamx::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::mesh::Mesh;

/// A point on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Where, object frame, metres.
    pub position: DVec3,
    /// Unit normal of its face, outward.
    pub normal: DVec3,
    /// Its face.
    pub face: u32,
}

/// `count` points, uniform by area, from the seed's generator. Empty if the mesh has no area.
pub fn sample_surface(mesh: &Mesh, count: usize, seed: u64) -> Vec<SurfacePoint> {
    let point = |(face, position): (usize, DVec3)| SurfacePoint {
        position,
        normal: mesh.normal(face),
        face: face as u32,
    };
    drawn(mesh, count, seed).into_iter().map(point).collect()
}

/// Where the same points lie, without more about them: object frame, metres.
pub fn sample_positions(mesh: &Mesh, count: usize, seed: u64) -> Vec<DVec3> {
    drawn(mesh, count, seed).into_iter().map(|(_, position)| position).collect()
}

/// Faces, each with a point of it.
fn drawn(mesh: &Mesh, count: usize, seed: u64) -> Vec<(usize, DVec3)> {
    let mut total = 0.0;
    let add = |f| {
        total += mesh.area(f);
        total
    };
    let cumulative: Vec<f64> = (0..mesh.faces().len()).map(add).collect();
    if total <= 0.0 {
        return Vec::new();
    }
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut draw = || {
        let [pick, s, t] = [rng.random::<f64>(), rng.random(), rng.random()];
        let face = cumulative.partition_point(|&c| c <= pick * total).min(cumulative.len() - 1);
        (face, point_on(mesh, face, s, t))
    };
    (0..count).map(|_| draw()).collect()
}

/// The point of a face that two uniform numbers in [0, 1) pick, uniform by area.
pub fn point_on(mesh: &Mesh, face: usize, s: f64, t: f64) -> DVec3 {
    let [a, b, c] = mesh.corners(face);
    let far = s.sqrt();
    let (u, v) = (1.0 - far, t * far);
    a * u + b * (1.0 - u - v) + c * v
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_fall_by_area_and_repeat_with_the_seed() {
        let v = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (3.0, 0.0), (0.0, 3.0)];
        let v = v.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec();
        let mesh = Mesh::new(v, vec![[0, 1, 2], [0, 3, 4]]).unwrap();
        let points = sample_surface(&mesh, 10_007, 7);
        let small = points.iter().filter(|p| p.face == 0).count() as f64 / 10_007.0;
        assert!((small - 0.1).abs() < 0.01, "a ninth of the other's area, got {small}");
        let inside = |p: DVec3| p.x >= 0.0 && p.y >= 0.0 && p.x + p.y <= 3.0;
        assert!(points.iter().all(|p| inside(p.position) && p.normal == DVec3::Z));
        assert_eq!(points, sample_surface(&mesh, 10_007, 7));
        let places: Vec<DVec3> = points.iter().map(|p| p.position).collect();
        assert_eq!(places, sample_positions(&mesh, 10_007, 7));
        assert_ne!(points, sample_surface(&mesh, 10_007, 8));
    }
}
