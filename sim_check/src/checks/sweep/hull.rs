//! A collision piece as simulators see it: the convex hull of some points; and how far apart or how
//! deep inside each other two of them are.

use std::f64::consts::TAU;

use glamx::{DPose3, DVec3};
use object::Mesh;
use object::mesh::Bounds;
use parry3d_f64::shape::{ConvexPolyhedron, SupportMap};
use parry3d_f64::transformation::try_convex_hull;

use super::facets::Facets;
use super::round::Round;
use crate::geometry::convex::own_hull;
use crate::robot::Geometry;

/// Sides of the prism that stands for a cylinder; its hull leaves the cylinder by 0.12 % of the
/// radius at most.
const CYLINDER_SIDES: usize = 64;
/// Rings of the polyhedron that stands for a ball (0.5 % of the radius at most).
const SPHERE_RINGS: usize = 16;

/// Most products spent to prove that a hull holds its points.
const PROOF_LIMIT: usize = 50_000_000;

/// The convex hull of a piece, in the piece's own frame, metres.
#[derive(Clone, Debug)]
pub struct Hull {
    points: Vec<DVec3>,
    /// Triangles of its surface; none if the hull builder failed.
    faces: Vec<[u32; 3]>,
    facets: Facets,
    bounds: Bounds,
    /// What it is exactly, if that is a ball or a capsule.
    round: Option<Round>,
    /// Half axes, metres, of an ellipsoid: how far it reaches follows from them.
    half: Option<DVec3>,
}

/// Why no hull could be made of a piece.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HullError {
    /// The shape was not read.
    #[error("{0}")]
    Unread(String),
    /// A size that is not positive and finite.
    #[error("its size must be positive and finite, found {0}")]
    Size(String),
    /// No volume, so no inside to tell from outside.
    #[error("its hull has no volume: its points lie in one plane")]
    Flat,
}

/// How two hulls stand to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Distance in metres; negative: the depth, the shortest way out of each other.
    pub distance: f64,
    /// Unit direction from the first to the second, in the first one's frame.
    pub normal: DVec3,
}

impl Hull {
    /// The hull of a shape, as simulators take it: a concave mesh is judged by its hull.
    ///
    /// # Errors
    /// [`HullError`] if there is nothing to take a hull of.
    pub fn of(geometry: &Geometry) -> Result<Self, HullError> {
        match geometry {
            Geometry::Box { size } => Self::of_box(*size),
            Geometry::Cylinder { radius, length } => Self::of_cylinder(*radius, *length),
            Geometry::Sphere { radius } => Self::of_round(*radius, 0.0),
            Geometry::Ellipsoid { half } => Self::of_ellipsoid(*half),
            Geometry::Capsule { radius, length } => Self::of_round(*radius, *length),
            Geometry::Mesh(mesh) => Self::of_mesh(mesh),
            Geometry::Unread { reason } => Err(HullError::Unread(reason.clone())),
        }
    }

    fn of_mesh(mesh: &Mesh) -> Result<Self, HullError> {
        if let Some((points, faces)) = own_hull(mesh)
            && let Some(facets) = Facets::of(&points, &faces)
        {
            let bounds = Bounds::of(points.iter().copied());
            return Ok(Self { points, faces, facets, bounds, round: None, half: None });
        }
        let used = mesh.faces().iter().flatten();
        Self::of_points(used.map(|&v| mesh.vertices()[v as usize]).collect())
    }

    /// The hull of a box centred on its frame.
    ///
    /// # Errors
    /// [`HullError::Size`] unless every side is positive and finite.
    pub fn of_box(size: DVec3) -> Result<Self, HullError> {
        check_size(&size.to_array())?;
        let sign = |i: usize, bit: usize| if i >> bit & 1 == 1 { 0.5 } else { -0.5 };
        let corner = |i| size * DVec3::new(sign(i, 0), sign(i, 1), sign(i, 2));
        Self::of_points((0..8).map(corner).collect())
    }

    fn of_cylinder(radius: f64, length: f64) -> Result<Self, HullError> {
        check_size(&[radius, length])?;
        let side = |i: usize| {
            let angle = TAU * i as f64 / CYLINDER_SIDES as f64;
            [-0.5, 0.5].map(|z| DVec3::new(radius * angle.cos(), radius * angle.sin(), z * length))
        };
        Self::of_points((0..CYLINDER_SIDES).flat_map(side).collect())
    }

    /// A ball of a radius, pulled apart by a length along z: its points are those of a polyhedron,
    /// what it does with others follows from what it is.
    fn of_round(radius: f64, length: f64) -> Result<Self, HullError> {
        let hull = Self::of_ball(DVec3::splat(radius), length)?;
        let half = DVec3::new(radius, radius, radius + length / 2.0);
        let bounds = Bounds { min: -half, max: half };
        Ok(Self { bounds, round: Some(Round { half: length / 2.0, radius }), ..hull })
    }

    fn of_ellipsoid(half: DVec3) -> Result<Self, HullError> {
        let hull = Self::of_ball(half, 0.0)?;
        Ok(Self { bounds: Bounds { min: -half, max: half }, half: Some(half), ..hull })
    }

    /// A ball with these half axes, pulled apart by a length along z.
    fn of_ball(half: DVec3, length: f64) -> Result<Self, HullError> {
        check_size(&half.to_array())?;
        if !(length.is_finite() && length >= 0.0) {
            return Err(HullError::Size(length.to_string()));
        }
        let point = |i: usize| {
            let (ring, side) = (i / (2 * SPHERE_RINGS), i % (2 * SPHERE_RINGS));
            let polar = (ring as f64 + 0.5) * TAU / 2.0 / SPHERE_RINGS as f64;
            let turn = TAU * side as f64 / (2 * SPHERE_RINGS) as f64;
            let (s, c) = polar.sin_cos();
            DVec3::new(s * turn.cos(), s * turn.sin(), c) * half
                + DVec3::Z * (length / 2.0 * c.signum())
        };
        Self::of_points((0..2 * SPHERE_RINGS * SPHERE_RINGS).map(point).collect())
    }

    /// The hull of some points. Points the hull builder loses to rounding are kept, so the hull
    /// holds every point whatever the builder says.
    ///
    /// # Errors
    /// [`HullError`] if a point is not finite or all lie in one plane.
    pub fn of_points(mut points: Vec<DVec3>) -> Result<Self, HullError> {
        if let Some(p) = points.iter().find(|p| !p.is_finite()) {
            return Err(HullError::Size(format!("{p}")));
        }
        points.sort_by(|a, b| {
            a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
        });
        points.dedup();
        let bounds = Bounds::of(points.iter().copied());
        if is_flat(&points) {
            return Err(HullError::Flat);
        }
        let hull = match build(&points) {
            Some((corners, faces, facets)) => {
                Self { points: corners, faces, facets, bounds, round: None, half: None }
            }
            None => Self::of_unknown_faces(Vec::new(), bounds),
        };
        let work = hull.facets.normals.len() * (points.len() + hull.points.len());
        if work <= PROOF_LIMIT && holds(&hull, &points) {
            return Ok(hull);
        }
        Ok(Self::of_unknown_faces(points, bounds))
    }

    fn of_unknown_faces(points: Vec<DVec3>, bounds: Bounds) -> Self {
        Self {
            points,
            faces: Vec::new(),
            facets: Facets::default(),
            bounds,
            round: None,
            half: None,
        }
    }

    /// The same as if no builder had found its faces.
    #[cfg(test)]
    pub(super) fn without_faces(&self) -> Self {
        Self::of_unknown_faces(self.points.clone(), self.bounds)
    }

    /// The hull's points: its corners, in its own frame.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// What it is exactly, if that is a ball or a capsule.
    pub fn round(&self) -> Option<Round> {
        self.round
    }

    /// Its faces and edges; empty if the hull builder failed and the points stand for the hull.
    pub fn facets(&self) -> &Facets {
        &self.facets
    }

    /// Diagonal of its box, metres.
    pub fn size(&self) -> f64 {
        self.bounds.diagonal()
    }

    /// Centre of its box and half its diagonal, metres: the box of the hull, however turned, lies
    /// in the cube of twice that side about the centre.
    pub fn ball_at(&self, pose: &DPose3) -> (DVec3, f64) {
        (pose.transform_point(self.bounds.centre()), self.bounds.diagonal() / 2.0)
    }

    /// Box of the posed hull, never smaller than the hull.
    pub fn bounds_at(&self, pose: &DPose3) -> Bounds {
        let centre = pose.transform_point(self.bounds.centre());
        let half = self.bounds.size() / 2.0;
        let axis = |unit: DVec3, h: f64| (pose.rotation * (unit * h)).abs();
        let half = axis(DVec3::X, half.x) + axis(DVec3::Y, half.y) + axis(DVec3::Z, half.z);
        Bounds { min: centre - half, max: centre + half }
    }

    /// The smallest and largest reach of the posed hull along a direction, metres.
    pub fn extent_along(&self, pose: &DPose3, direction: DVec3) -> (f64, f64) {
        if let Some(half) = self.half {
            let reach = (half * (pose.rotation.inverse() * direction)).length();
            let at = pose.translation.dot(direction);
            return (at - reach, at + reach);
        }
        let reach = self.points.iter().map(|p| pose.transform_point(*p).dot(direction));
        reach.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), r| (lo.min(r), hi.max(r)))
    }

    /// How far an ellipsoid's surface lies beyond its points at most, metres; 0 for all else that
    /// has no radius.
    pub(super) fn beyond_points(&self) -> f64 {
        // No direction is farther than half a ring and half a side from a point's.
        let step = TAU / 4.0 / SPHERE_RINGS as f64;
        self.half.map_or(0.0, |half| half.max_element() * (1.0 - step.cos().powi(2)))
    }

    /// The hull as a solid the physics engine takes; `None` if it refuses.
    pub fn to_polyhedron(&self) -> Option<ConvexPolyhedron> {
        let whole = ConvexPolyhedron::from_convex_mesh(self.points.clone(), &self.faces);
        let is_whole = |solid: &ConvexPolyhedron| solid.faces().len() >= 4;
        whole.filter(is_whole).or_else(|| ConvexPolyhedron::from_convex_hull(&self.points))
    }

    /// Distance between the two when pushed apart along a unit direction alone: never more than
    /// the true distance, never less deep than the true depth.
    pub fn gap_along(&self, other: &Self, pose: &DPose3, normal: DVec3) -> Gap {
        let there =
            pose.transform_point(other.local_support_point(pose.rotation.inverse() * -normal));
        Gap { distance: normal.dot(there) - normal.dot(self.local_support_point(normal)), normal }
    }
}

impl SupportMap for Hull {
    fn local_support_point(&self, direction: DVec3) -> DVec3 {
        if let Some(half) = self.half
            && let Some(along) = (direction * half).try_normalize()
        {
            return along * half;
        }
        let further = |best: (f64, DVec3), &p: &DVec3| {
            let reach = p.dot(direction);
            if reach > best.0 { (reach, p) } else { best }
        };
        self.points.iter().fold((f64::NEG_INFINITY, DVec3::ZERO), further).1
    }
}

fn check_size(sizes: &[f64]) -> Result<(), HullError> {
    let bad = sizes.iter().find(|s| !(s.is_finite() && **s > 0.0));
    bad.map_or(Ok(()), |s| Err(HullError::Size(s.to_string())))
}

/// Whether some points span no volume to speak of (a millionth of a millionth of their size).
fn is_flat(points: &[DVec3]) -> bool {
    let Some(&a) = points.first() else { return true };
    let farthest = |score: &dyn Fn(DVec3) -> f64| {
        points
            .iter()
            .fold((0.0, a), |best, &p| if score(p) > best.0 { (score(p), p) } else { best })
    };
    let (length, b) = farthest(&|p| p.distance(a));
    let along = (b - a).normalize_or_zero();
    let (width, c) = farthest(&|p| (p - a).reject_from_normalized(along).length());
    let normal = along.cross(c - a).normalize_or_zero();
    let (height, _) = farthest(&|p| (p - a).dot(normal).abs());
    !(width > 1e-12 * length && height > 1e-9 * length)
}

/// Whether the hull is known to hold all the points.
fn holds(hull: &Hull, points: &[DVec3]) -> bool {
    let tolerance = 1e-9 * hull.size();
    let within = |n: &DVec3| {
        let reach = n.dot(hull.local_support_point(*n)) + tolerance;
        points.iter().all(|p| n.dot(*p) <= reach)
    };
    hull.facets().normals.len() >= 4 && hull.facets().normals.iter().all(within)
}

/// Corners, faces and edges of the hull, if the hull builder manages.
fn build(points: &[DVec3]) -> Option<(Vec<DVec3>, Vec<[u32; 3]>, Facets)> {
    let build = || try_convex_hull(points).ok();
    let (corners, faces) = std::panic::catch_unwind(build).ok()??;
    let facets = Facets::of(&corners, &faces)?;
    Some((corners, faces, facets))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_4;

    use rand::{RngExt, SeedableRng};

    use super::*;
    use crate::checks::sweep::sat::widest_gap;

    fn cube(side: f64) -> Hull {
        Hull::of_box(DVec3::splat(side)).unwrap()
    }

    #[test]
    fn two_boxes_ten_millimetres_into_each_other_read_ten() {
        let pose = DPose3::translation(0.99, 0.3, -0.2);
        let gap = cube(1.0).gap(&cube(1.0), &pose, None);
        assert!((gap.distance + 0.010).abs() < 1e-12, "{gap:?}");
        assert!((gap.normal - DVec3::X).length() < 1e-9);
    }

    #[test]
    fn boxes_apart_read_their_distance_whatever_the_guess() {
        let pose = DPose3::translation(2.0, 2.0, 0.1);
        for guess in [None, Some(DVec3::Z), Some(DVec3::NEG_X)] {
            let gap = cube(1.0).gap(&cube(1.0), &pose, guess);
            assert!((gap.distance - 2f64.sqrt()).abs() < 1e-9, "{gap:?}");
        }
    }

    #[test]
    fn a_corner_pushed_through_a_face_reads_its_depth_along_the_normal() {
        let turned = DPose3::from_parts(
            DVec3::new(0.0, 0.0, 0.5 + 3f64.sqrt() / 2.0 - 0.01),
            glamx::DQuat::from_rotation_arc(DVec3::ONE.normalize(), DVec3::NEG_Z),
        );
        let gap = cube(1.0).gap(&cube(1.0), &turned, None);
        assert!((gap.distance + 0.01).abs() < 1e-9, "{gap:?}");
    }

    #[test]
    fn coinciding_boxes_are_as_deep_as_they_are_thin() {
        let plate = Hull::of_box(DVec3::new(1.0, 0.7, 0.02)).unwrap();
        let gap = plate.gap(&plate, &DPose3::identity(), None);
        assert!((gap.distance + 0.02).abs() < 1e-9, "{gap:?}");
    }

    #[test]
    fn two_crossed_beams_are_pushed_apart_across_their_edges() {
        let beam = Hull::of_box(DVec3::new(1.0, 0.1, 0.1)).unwrap();
        let on_edge = glamx::DQuat::from_rotation_x(FRAC_PI_4);
        let up = 0.1 * 2f64.sqrt() - 0.01;
        let across = glamx::DQuat::from_rotation_z(1.1) * on_edge;
        let [a, b] = [(0.0, on_edge), (up, across)]
            .map(|(z, r)| DPose3::from_parts(DVec3::new(0.0, 0.0, z), r));
        let gap = beam.gap(&beam, &a.inv_mul(&b), None);
        assert!((gap.distance + 0.01).abs() < 1e-12, "{gap:?}");
    }

    #[test]
    fn search_and_proof_agree_on_random_polyhedra() {
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(5);
        let mut point = || DVec3::from_array([(); 3].map(|_| rng.random_range(-1.0..1.0)));
        for _ in 0..60 {
            let [a, b] =
                [(); 2].map(|_| Hull::of_points((0..40).map(|_| point()).collect()).unwrap());
            let pose = DPose3::new(point() * 1.6, point());
            let (gap, exact) = (a.gap(&b, &pose, None), widest_gap(&a, &b, &pose));
            let agree = (gap.distance - exact.distance).abs() < 1e-3 * exact.distance.abs() + 1e-9;
            assert!(agree || gap.distance > exact.distance.max(0.0), "{gap:?} {exact:?}");
        }
    }

    #[test]
    fn points_inside_are_dropped_and_flat_ones_refused() {
        let mut points = cube(1.0).points().to_vec();
        points.extend([DVec3::ZERO, DVec3::new(0.1, 0.2, 0.3)]);
        assert_eq!(Hull::of_points(points).unwrap().points().len(), 8);
        let flat = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.0)];
        assert_eq!(Hull::of_points(flat).unwrap_err(), HullError::Flat);
        assert!(Hull::of_box(DVec3::new(1.0, 0.0, 1.0)).is_err());
    }

    #[test]
    fn a_cylinder_and_a_sphere_keep_their_size() {
        let can = Hull::of(&Geometry::Cylinder { radius: 0.1, length: 0.4 }).unwrap();
        let (low, high) = can.extent_along(&DPose3::identity(), DVec3::Z);
        assert_eq!((low, high), (-0.2, 0.2));
        let ball = Hull::of(&Geometry::Sphere { radius: 1.0 }).unwrap();
        let (low, high) = ball.extent_along(&DPose3::identity(), DVec3::new(0.6, 0.0, 0.8));
        assert!(low > -1.0 && low < -0.99 && high < 1.0 && high > 0.99);
    }
}
