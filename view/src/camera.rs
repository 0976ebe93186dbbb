//! Where a picture is taken from: points to pixels, pixels to rays, and eight good standpoints.

use glamx::DVec3;
use object::mesh::Bounds;

/// Opening angle of the standard views, top to bottom: 30°, a calm lens with little distortion.
pub const FIELD_OF_VIEW: f64 = std::f64::consts::PI / 6.0;
/// Share of the picture left free around an object in a standard view, on every side.
pub const MARGIN: f64 = 0.07;

/// A pinhole camera in the object frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it stands, metres.
    pub eye: DVec3,
    /// A point in the middle of the picture, metres.
    pub target: DVec3,
    /// What should point up in the picture; not along the view.
    pub up: DVec3,
    /// Opening angle from the top to the bottom edge, radians, between 0 and π.
    pub fov_y: f64,
    /// Pixels across and down.
    pub size: [u32; 2],
}

/// A camera with a name people and models can speak of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Such as `front_right`.
    pub name: &'static str,
    /// Where it is seen from.
    pub camera: Camera,
}

/// A camera's own axes, unit and at right angles, and its focal length in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes {
    /// To the right in the picture.
    pub right: DVec3,
    /// Upward in the picture.
    pub up: DVec3,
    /// Into the picture.
    pub forward: DVec3,
    /// Focal length, pixels.
    pub focal: f64,
}

/// A point as a camera sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Where in the picture, pixels; may lie outside it.
    pub pixel: [f64; 2],
    /// Distance along the view axis, metres, positive.
    pub depth: f64,
}

impl Camera {
    /// The camera's axes; where `up` runs along the view, another upward direction stands in.
    pub fn axes(&self) -> Axes {
        let forward = (self.target - self.eye).try_normalize().unwrap_or(DVec3::Y);
        let right = forward.cross(self.up).try_normalize();
        let right = right.unwrap_or_else(|| forward.any_orthonormal_vector());
        let focal = f64::from(self.size[1]) / 2.0 / (self.fov_y / 2.0).tan();
        Axes { right, up: right.cross(forward), forward, focal }
    }

    /// Where a point appears; none if it is not in front of the camera.
    pub fn project(&self, point: DVec3) -> Option<Projection> {
        let axes = self.axes();
        let [x, y, depth] = axes.local(point - self.eye);
        if depth <= 0.0 {
            return None;
        }
        let [cx, cy] = self.centre();
        let scale = axes.focal / depth;
        Some(Projection { pixel: [cx + x * scale, cy - y * scale], depth })
    }

    /// The ray through a pixel: the eye, and the unit direction into the scene.
    pub fn ray(&self, pixel: [f64; 2]) -> (DVec3, DVec3) {
        (self.eye, self.axes().direction(self.centre(), pixel).normalize())
    }

    /// Middle of the picture, pixels.
    pub fn centre(&self) -> [f64; 2] {
        self.size.map(|n| f64::from(n) / 2.0)
    }

    /// Whether a pixel position lies in the picture.
    pub fn holds(&self, [x, y]: [f64; 2]) -> bool {
        let inside = |v: f64, n: u32| (0.0..f64::from(n)).contains(&v);
        inside(x, self.size[0]) && inside(y, self.size[1])
    }
}

impl Axes {
    /// An offset from the eye as right, up and forward parts, metres.
    pub fn local(&self, offset: DVec3) -> [f64; 3] {
        [self.right, self.up, self.forward].map(|axis| axis.dot(offset))
    }

    /// The direction through a pixel whose forward part is one.
    pub fn direction(&self, centre: [f64; 2], pixel: [f64; 2]) -> DVec3 {
        let [x, y] = [pixel[0] - centre[0], centre[1] - pixel[1]];
        self.forward + self.right * (x / self.focal) + self.up * (y / self.focal)
    }
}

/// Names of the standard views with the camera's azimuth from the front, counter-clockwise seen
/// from above, and its elevation, degrees. Straight views stand low to show a side squarely, the
/// ones between stand higher to show the top.
const STANDPOINTS: [(&str, f64, f64); 8] = [
    ("front", 0.0, 16.0),
    ("front_right", 45.0, 28.0),
    ("right", 90.0, 16.0),
    ("back_right", 135.0, 28.0),
    ("back", 180.0, 16.0),
    ("back_left", 225.0, 28.0),
    ("left", 270.0, 16.0),
    ("front_left", 315.0, 28.0),
];

/// Eight square pictures of `size` pixels a side around an object, the front (−y) first, each
/// framed as tightly as the box allows. `right` is what a person facing the front has to the right.
pub fn eight_views(bounds: &Bounds, size: u32) -> Vec<View> {
    let view = |(name, azimuth, elevation): (&'static str, f64, f64)| {
        let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
        let flat = DVec3::new(azimuth.sin(), -azimuth.cos(), 0.0);
        let towards_eye = flat * elevation.cos() + DVec3::Z * elevation.sin();
        View { name, camera: framed(bounds, towards_eye, [size, size]) }
    };
    STANDPOINTS.into_iter().map(view).collect()
}

/// The camera that looks along −`towards_eye` and stands as near as it can while the whole box
/// stays in the picture, with [`MARGIN`] to spare.
pub fn framed(bounds: &Bounds, towards_eye: DVec3, size: [u32; 2]) -> Camera {
    let centre = bounds.centre();
    let at = |eye| Camera { eye, target: centre, up: DVec3::Z, fov_y: FIELD_OF_VIEW, size };
    let axes = at(centre + towards_eye).axes();
    let corners: Vec<[f64; 3]> = corners(bounds).map(|c| axes.local(c - centre)).collect();
    let slope_y = (FIELD_OF_VIEW / 2.0).tan() * (1.0 - 2.0 * MARGIN);
    let slope_x = slope_y * f64::from(size[0]) / f64::from(size[1].max(1));
    let (x, across) = fit(&corners, 0, slope_x);
    let (y, down) = fit(&corners, 1, slope_y);
    let distance = across.max(down).max(f64::MIN_POSITIVE);
    let eye = centre + axes.right * x + axes.up * y - axes.forward * distance;
    Camera { target: eye + axes.forward * distance, ..at(eye) }
}

/// Along one axis of the picture: the eye's offset and its distance from the centre's plane so that
/// the outermost points both touch the edge of the picture.
fn fit(points: &[[f64; 3]], axis: usize, slope: f64) -> (f64, f64) {
    let most = |sign: f64| {
        let reach = points.iter().map(|p| sign * p[axis] - slope * p[2]);
        reach.fold(f64::NEG_INFINITY, f64::max)
    };
    let (high, low) = (most(1.0), most(-1.0));
    ((high - low) / 2.0, (high + low) / (2.0 * slope))
}

fn corners(b: &Bounds) -> impl Iterator<Item = DVec3> + use<> {
    let ends = [b.min, b.max];
    (0..8usize).map(move |i| DVec3::new(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2].z))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        let (eye, target) = (DVec3::new(0.3, -4.0, 1.0), DVec3::new(0.1, 0.2, 0.4));
        Camera { eye, target, up: DVec3::Z, fov_y: 0.7, size: [640, 480] }
    }

    #[test]
    fn the_target_is_in_the_middle_of_the_picture() {
        let seen = camera().project(camera().target).unwrap();
        assert!((seen.pixel[0] - 320.0).abs() < 1e-9 && (seen.pixel[1] - 240.0).abs() < 1e-9);
        assert!((seen.depth - camera().eye.distance(camera().target)).abs() < 1e-12);
    }

    #[test]
    fn a_ray_goes_where_its_pixel_came_from() {
        let p = DVec3::new(-0.4, 0.7, 0.9);
        let (eye, direction) = camera().ray(camera().project(p).unwrap().pixel);
        assert!((direction.cross((p - eye).normalize())).length() < 1e-12);
        assert!(camera().project(camera().eye - direction).is_none());
    }

    #[test]
    fn the_top_edge_is_half_the_opening_angle_away() {
        let (_, middle) = camera().ray([320.0, 240.0]);
        let (_, top) = camera().ray([320.0, 0.0]);
        assert!((middle.angle_between(top) - 0.35).abs() < 1e-9);
    }

    #[test]
    fn every_view_holds_the_whole_box_and_touches_its_margin() {
        for max in [DVec3::new(0.1, 0.2, 3.0), DVec3::new(4.0, 0.5, 0.2), DVec3::ONE] {
            let bounds = Bounds { min: DVec3::new(-1.0, 0.0, 0.0), max };
            for view in eight_views(&bounds, 512) {
                let seen = corners(&bounds).map(|c| view.camera.project(c).unwrap().pixel);
                let reach = seen.flat_map(|[x, y]| [256.0 - x, x - 256.0, 256.0 - y, y - 256.0]);
                let furthest = reach.fold(0.0, f64::max);
                let expected = 256.0 * (1.0 - 2.0 * MARGIN);
                assert!((furthest - expected).abs() < 1e-6, "{} {furthest}", view.name);
            }
        }
    }

    #[test]
    fn the_front_view_looks_at_the_side_that_faces_minus_y() {
        let bounds = Bounds { min: -DVec3::ONE, max: DVec3::ONE };
        let views = eight_views(&bounds, 100);
        let eye = |name| views.iter().find(|v| v.name == name).unwrap().camera.eye;
        assert!(eye("front").y < -3.0 && eye("front").x.abs() < 1e-9 && eye("front").z > 0.5);
        assert!(eye("right").x > 3.0 && eye("left").x < -3.0 && eye("back").y > 3.0);
        let front = views[0].camera;
        let x = |p| front.project(p).unwrap().pixel[0];
        assert!(x(DVec3::X) > x(-DVec3::X), "+x is to the right of someone facing the front");
    }
}
