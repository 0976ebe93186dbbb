//! From a pixel back to the surface: the first face its ray meets.

use glamx::DVec3;
use object::Mesh;
use object::mesh::Bounds;
use object::sample::SurfacePoint;
use parry3d_f64::query::Ray;
use parry3d_f64::shape::{CompositeShapeRef, TriMesh};

use crate::camera::Camera;

/// A point counts as visible if nothing stands more than this share of the mesh's diagonal in
/// front of it.
pub const VISIBLE_TOLERANCE: f64 = 1e-4;

/// Finds the first surface along rays; built once per mesh.
pub struct Unprojector {
    surface: Option<TriMesh>,
    normals: Vec<DVec3>,
    tolerance: f64,
    reach: Bounds,
}

impl Unprojector {
    /// Sorts a mesh's faces for quick search.
    pub fn new(mesh: &Mesh) -> Self {
        let surface = TriMesh::new(mesh.vertices().to_vec(), mesh.faces().to_vec()).ok();
        let normals = (0..mesh.faces().len()).map(|f| mesh.normal(f)).collect();
        let reach = mesh.bounds();
        Self { surface, normals, tolerance: VISIBLE_TOLERANCE * reach.diagonal(), reach }
    }

    /// The surface point seen at a pixel position, either side of a face; none where there is only
    /// background. The normal is the face's own, outward.
    pub fn pixel(&self, camera: &Camera, pixel: [f64; 2]) -> Option<SurfacePoint> {
        let (eye, direction) = camera.ray(pixel);
        self.first_along(eye, direction)
    }

    /// The first surface point along a ray; `direction` is a unit vector.
    pub fn first_along(&self, origin: DVec3, direction: DVec3) -> Option<SurfacePoint> {
        let furthest = origin.distance(self.reach.centre()) + self.reach.diagonal();
        let surface = CompositeShapeRef(self.surface.as_ref()?);
        let ray = Ray::new(origin, direction);
        let (face, distance) = surface.cast_local_ray(&ray, furthest, true)?;
        let normal = self.normals.get(face as usize).copied()?;
        Some(SurfacePoint { position: origin + direction * distance, normal, face })
    }

    /// Whether a point is in the picture and nothing stands in front of it.
    pub fn visible(&self, camera: &Camera, point: DVec3) -> bool {
        let Some(seen) = camera.project(point) else { return false };
        if !camera.holds(seen.pixel) {
            return false;
        }
        let distance = camera.eye.distance(point);
        let Some(direction) = (point - camera.eye).try_normalize() else { return true };
        let hit = self.first_along(camera.eye, direction);
        hit.is_none_or(|hit| camera.eye.distance(hit.position) >= distance - self.tolerance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::eight_views;
    use crate::raster::tests::unit_cube;

    #[test]
    fn unprojection_undoes_projection_on_the_front_of_a_box() {
        let mesh = unit_cube();
        let (rays, views) = (Unprojector::new(&mesh), eight_views(&mesh.bounds(), 300));
        let p = DVec3::new(0.31, 0.0, 0.72);
        let front = views[0].camera;
        let found = rays.pixel(&front, front.project(p).unwrap().pixel).unwrap();
        assert!((found.position - p).length() < 1e-12, "{}", found.position);
        assert_eq!(found.normal, DVec3::NEG_Y);
        assert!(mesh.corners(found.face as usize).iter().all(|c| c.y == 0.0));
        assert!(rays.pixel(&front, [1.0, 1.0]).is_none());
    }

    #[test]
    fn a_point_on_the_front_is_seen_from_the_front_and_not_from_behind() {
        let mesh = unit_cube();
        let (rays, views) = (Unprojector::new(&mesh), eight_views(&mesh.bounds(), 300));
        let p = DVec3::new(0.31, 0.0, 0.72);
        let seen: Vec<_> =
            views.iter().filter(|v| rays.visible(&v.camera, p)).map(|v| v.name).collect();
        assert_eq!(seen, ["front", "front_right", "front_left"]);
        assert!(!rays.visible(&views[0].camera, DVec3::new(50.0, 0.0, 0.0)), "outside the picture");
    }
}
