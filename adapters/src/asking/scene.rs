//! A mesh as its views show it: the surface behind a pixel.

use object::{DVec3, Mesh, weld};
use view::{Camera, Unprojector};

/// A point this near to the surface's outline still means the surface, pixels of a 1024-pixel view.
const NEAR_MISS: f64 = 8.0;
/// Side of the square of places that are written as one pixel.
const SQUARE: f64 = 1.0;
/// What is nearer by this share of the diagonal stands in front.
const IN_FRONT: f64 = 0.02;
/// A place no further off than this share of the diagonal lies on the surface.
const ON_SURFACE: f64 = 0.002;

/// A mesh and where it is seen from.
pub struct Scene<'a> {
    mesh: &'a Mesh,
    /// Where it is seen from, in the order of the views.
    pub(super) cameras: &'a [Camera],
    pub(super) rays: Unprojector,
    /// Of the mesh's bounds, in its own unit.
    pub(super) diagonal: f64,
}

impl<'a> Scene<'a> {
    /// Sorts the mesh for quick search.
    pub fn new(mesh: &'a Mesh, cameras: &'a [Camera]) -> Self {
        let (rays, diagonal) = (Unprojector::new(mesh), mesh.bounds().diagonal());
        Self { mesh, cameras, rays, diagonal }
    }

    /// Whether a place lies on the surface, to a few thousandths of the diagonal.
    pub(super) fn is_on_surface(&self, place: DVec3) -> bool {
        weld::nearest_face(self.mesh, place).1 <= ON_SURFACE * self.diagonal
    }

    /// The surface at a pixel, or the nearest within a few pixels of it.
    pub(super) fn surface(&self, camera: &Camera, pixel: [f64; 2]) -> Option<DVec3> {
        let reach = NEAR_MISS * f64::from(camera.size[0]) / 1024.0;
        if let Some(place) = self.in_square(camera, pixel) {
            return Some(place);
        }
        let rings = [0.25, 0.5, 0.75, 1.0].into_iter();
        rings.map(|share| share * reach).find_map(|radius| {
            let around = (0..16).map(|i| f64::from(i) / 16.0);
            around.map(|turn| (turn * std::f64::consts::TAU).sin_cos()).find_map(|(sin, cos)| {
                let [x, y] = [pixel[0] + radius * cos, pixel[1] + radius * sin];
                Some(self.rays.pixel(camera, [x, y])?.position)
            })
        })
    }

    /// What the square shows that a whole number stands for: the surface at its middle, or what
    /// stands well in front of that, for it may be thinner than the square.
    fn in_square(&self, camera: &Camera, [x, y]: [f64; 2]) -> Option<DVec3> {
        let seen = |x: f64, y: f64| Some(self.rays.pixel(camera, [x, y])?.position);
        let far = |p: &DVec3| p.distance(camera.eye);
        let steps =
            (0..25).filter(|&i| i != 12).map(|i| (f64::from(i % 5 - 2), f64::from(i / 5 - 2)));
        let others = steps.filter_map(|(i, j)| seen(x + i * SQUARE / 4.0, y + j * SQUARE / 4.0));
        let nearest = others.min_by(|a, b| far(a).total_cmp(&far(b)));
        let middle = seen(x, y);
        let in_front = |m: &DVec3| nearest.filter(|n| far(n) + IN_FRONT * self.diagonal < far(m));
        middle.and_then(|m| in_front(&m).or(middle)).or(nearest)
    }
}
