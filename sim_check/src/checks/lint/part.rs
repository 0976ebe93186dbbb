//! The links of a robot made ready for geometric questions: surfaces, collision hulls, poses.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use glamx::{DMat3, DPose3, DSymmetricEigen3, DVec3};
use object::Mesh;
use object::mesh::Bounds;
use parry3d_f64::transformation::try_convex_hull;

use super::surface::{Topology, merged};
use super::winding::WindingTree;
use crate::checks::study::Study;
use crate::geometry::convex::own_hull;
use crate::geometry::near::BoxTree;
use crate::geometry::tessellate::tessellated;
use crate::profile::subject::Subject;
use crate::robot::{Geometry, Link, Robot, Shape};

/// A piece of more vertices is judged by its extreme points in [`DIRECTIONS`] directions.
const MANY_POINTS: usize = 2048;
const DIRECTIONS: u32 = 256;

/// A robot and the geometry of its links at rest.
pub(crate) struct Parts<'a> {
    pub robot: &'a Robot,
    /// What it is judged as.
    pub subject: Subject,
    /// One per link, in the robot's order.
    pub parts: Vec<Part<'a>>,
    /// Rest poses of the links, root frame.
    pub poses: Vec<DPose3>,
    /// Box around everything seen (or, if nothing is, touched) at rest, root frame.
    pub bounds: Bounds,
    /// Its diagonal, metres; 0 if there is no geometry.
    pub diagonal: f64,
}

/// A link's geometry, link frame.
pub(crate) struct Part<'a> {
    pub link: &'a Link,
    /// One per `<visual>`.
    pub visuals: Vec<Surface<'a>>,
    /// One per `<collision>`.
    pub pieces: Vec<Piece<'a>>,
    /// All visuals as one surface.
    pub skin: Option<Skin>,
}

/// A shape's surface, its own frame.
#[derive(Clone)]
pub(crate) struct Surface<'a> {
    pub shape: &'a Shape,
    /// The surface and how it hangs together, or why there is none.
    pub body: Result<Arc<(Arc<Mesh>, Topology)>, String>,
}

/// A collision shape: its surface, and its hull as simulators take it.
pub(crate) struct Piece<'a> {
    pub surface: Surface<'a>,
    pub hull: Result<Hull, String>,
}

/// All visuals of a link as one surface, link frame.
pub(crate) struct Skin {
    pub mesh: Mesh,
    pub winding: WindingTree,
    near: Arc<BoxTree>,
}

/// Squared distance of two unit normals of faces in one plane.
const SAME_DIRECTION: f64 = 1e-20;

/// A convex hull, link frame.
pub(crate) struct Hull {
    pub mesh: Mesh,
    pub volume: f64,
    pub bounds: Bounds,
    /// Outward unit normals and offsets: inside where n·p <= d for all.
    pub planes: Vec<(DVec3, f64)>,
    near: BoxTree,
}

impl<'a> Parts<'a> {
    /// Prepares every link; meshes that several shapes share are looked at once.
    pub(crate) fn new(study: &Study<'a>) -> Self {
        let (robot, mut known) = (study.robot, Known::default());
        let part = |l: usize| Part::new(&robot.links[l], &mut known, || study.seen(l));
        let parts: Vec<_> = (0..robot.links.len()).map(part).collect();
        let poses = robot.link_poses(&[]);
        let mut all = Self {
            robot,
            subject: study.subject,
            parts,
            poses,
            bounds: Bounds { min: DVec3::ZERO, max: DVec3::ZERO },
            diagonal: 0.0,
        };
        let seen = Bounds::of(all.all_points(|p| p.skin.iter().map(|s| &s.mesh).collect()));
        let touched = Bounds::of(all.all_points(Part::hull_meshes));
        if let Some(bounds) = [seen, touched].into_iter().find(|b| b.min.x <= b.max.x) {
            all.diagonal = bounds.diagonal();
            all.bounds = bounds;
        }
        all
    }

    fn all_points(&self, of: impl for<'p> Fn(&'p Part<'a>) -> Vec<&'p Mesh>) -> Vec<DVec3> {
        let mut points = Vec::new();
        for (part, pose) in self.parts.iter().zip(&self.poses) {
            for mesh in of(part) {
                points.extend(mesh.vertices().iter().map(|&v| pose.transform_point(v)));
            }
        }
        points
    }

    /// The link, or the nearest ancestor of it that has geometry.
    pub(crate) fn with_geometry_above(&self, link: usize) -> Option<usize> {
        let mut walk = Some(link);
        while let Some(l) = walk {
            if self.parts[l].has_geometry() {
                return Some(l);
            }
            walk = self.robot.parent(l);
        }
        None
    }

    /// The link, or the first link hanging on it that has geometry.
    pub(crate) fn with_geometry_below(&self, link: usize) -> Option<usize> {
        let mut under = self.robot.root_first().iter().copied();
        under.find(|&l| self.parts[l].has_geometry() && self.robot.is_under(l, link))
    }
}

impl<'a> Part<'a> {
    fn new(link: &'a Link, known: &mut Known, seen: impl FnOnce() -> Arc<BoxTree>) -> Self {
        let visuals: Vec<_> = link.visuals.iter().map(|s| Surface::new(s, known)).collect();
        let pieces = link.collisions.iter().map(|s| Piece::new(Surface::new(s, known))).collect();
        let bodies = visuals.iter().filter_map(|v| Some((v.mesh()?, v.shape.origin)));
        let skin = merged(bodies).map(|mesh| Skin::new(mesh, seen()));
        Self { link, visuals, pieces, skin }
    }

    /// Whether anything of it is seen or touched.
    pub(crate) fn has_geometry(&self) -> bool {
        !self.visuals.is_empty() || !self.pieces.is_empty()
    }

    /// The hulls of its collision pieces that could be had.
    pub(crate) fn hulls(&self) -> impl Iterator<Item = &Hull> {
        self.pieces.iter().filter_map(|p| p.hull.as_ref().ok())
    }

    fn hull_meshes(&self) -> Vec<&Mesh> {
        self.hulls().map(|h| &h.mesh).collect()
    }

    /// What could not be read of it, if anything.
    pub(crate) fn unread(&self) -> Option<&str> {
        let pieces = self.pieces.iter().map(|p| &p.surface);
        self.visuals.iter().chain(pieces).find_map(|s| s.body.as_ref().err().map(String::as_str))
    }

    /// Distance of a point (link frame) to the link's geometry, 0 inside; infinite without any.
    pub(crate) fn distance(&self, p: DVec3) -> f64 {
        let hull = self.hull_distance(p);
        match &self.skin {
            Some(skin) if hull > 0.0 => hull.min(skin.solid_distance(p)),
            _ => hull,
        }
    }

    /// The same, but to the surface alone where the point is in no collision piece; or `at_most`
    /// where that is less.
    pub(crate) fn surface_distance(&self, p: DVec3, at_most: f64) -> f64 {
        let hull = self.hull_distance_beyond(p, 0.0, at_most);
        self.skin.as_ref().map_or(hull, |s| if hull > 0.0 { s.near.distance(p, hull) } else { 0.0 })
    }

    /// Distance of a point (link frame) to the nearest collision piece, 0 inside; infinite without.
    pub(crate) fn hull_distance(&self, p: DVec3) -> f64 {
        self.hull_distance_beyond(p, 0.0, f64::INFINITY)
    }

    /// The same where that is more than `enough` (where it is not, any figure up to that), or
    /// `at_most` where that is less.
    pub(crate) fn hull_distance_beyond(&self, p: DVec3, enough: f64, at_most: f64) -> f64 {
        // The nearest box first: what is far from it needs no closer look.
        let mut first: Option<(f64, &Hull)> = None;
        for hull in self.hulls() {
            let apart = hull.box_distance_squared(p);
            if apart <= 0.0 && hull.contains(p, 0.0) {
                return 0.0;
            }
            if first.is_none_or(|(least, _)| apart < least) {
                first = Some((apart, hull));
            }
        }
        let look = |h: &Hull, least: f64| h.near.distance_beyond(p, enough, least);
        let mut best = first.map_or(at_most, |(_, h)| look(h, at_most));
        for hull in self.hulls() {
            if best <= enough {
                break;
            }
            if hull.box_distance_squared(p) < best * best {
                best = look(hull, best);
            }
        }
        best
    }

    /// Vertices of everything seen and touched, link frame.
    pub(crate) fn points(&self) -> impl Iterator<Item = DVec3> {
        let meshes = self.skin.iter().map(|s| &s.mesh).chain(self.hulls().map(|h| &h.mesh));
        meshes.flat_map(|m| m.vertices().iter().copied())
    }
}

/// Surfaces already looked at, by the address of their mesh.
#[derive(Default)]
struct Known(BTreeMap<usize, Arc<(Arc<Mesh>, Topology)>>);

impl<'a> Surface<'a> {
    fn new(shape: &'a Shape, known: &mut Known) -> Self {
        let look = |mesh: Arc<Mesh>| {
            let topology = Topology::of(&mesh);
            Arc::new((mesh, topology))
        };
        let body = match &shape.geometry {
            Geometry::Mesh(mesh) => {
                let made = known.0.entry(Arc::as_ptr(mesh) as usize);
                Ok(made.or_insert_with(|| look(mesh.clone())).clone())
            }
            other => tessellated(other).map(Arc::new).map(look),
        };
        Self { shape, body }
    }

    /// The surface, if it could be had.
    pub(crate) fn mesh(&self) -> Option<&Mesh> {
        self.body.as_ref().ok().map(|b| b.0.as_ref())
    }

    /// What to call it in evidence.
    pub(crate) fn label(&self) -> String {
        format!("`{}` (line {})", self.shape.source, self.shape.line)
    }
}

impl<'a> Piece<'a> {
    fn new(surface: Surface<'a>) -> Self {
        let origin = surface.shape.origin;
        let placed = |points: &[DVec3]| points.iter().map(|&p| origin.transform_point(p)).collect();
        let hull =
            surface.body.as_ref().map_err(Clone::clone).and_then(|body| match own_hull(&body.0) {
                Some((points, faces)) => Hull::of_surface(placed(&points), faces),
                None => Hull::of(placed(&body.1.places)),
            });
        Self { surface, hull }
    }
}

impl Skin {
    fn new(mesh: Mesh, near: Arc<BoxTree>) -> Self {
        let winding = WindingTree::new(near.clone());
        Self { mesh, winding, near }
    }

    /// Its faces, in boxes.
    pub(crate) fn near(&self) -> Arc<BoxTree> {
        self.near.clone()
    }

    /// Distance to the surface.
    pub(crate) fn distance(&self, p: DVec3) -> f64 {
        self.near.distance(p, f64::INFINITY)
    }

    /// The same where that is more than `enough` (where it is not, any figure up to that), or
    /// `at_most` where that is less.
    pub(crate) fn distance_beyond(&self, p: DVec3, enough: f64, at_most: f64) -> f64 {
        self.near.distance_beyond(p, enough, at_most)
    }

    /// Whether it is nearer than that.
    pub(crate) fn is_near(&self, p: DVec3, than: f64) -> bool {
        self.near.distance_beyond(p, than.next_down(), than) < than
    }

    /// Distance to the solid: 0 inside.
    pub(crate) fn solid_distance(&self, p: DVec3) -> f64 {
        if self.winding.at(p) > 0.5 { 0.0 } else { self.distance(p) }
    }
}

impl Hull {
    /// The hull of some points.
    pub(crate) fn of(points: Vec<DVec3>) -> Result<Self, String> {
        let points = if points.len() > MANY_POINTS { extreme_points(&points) } else { points };
        let rounded = Rounding::of(&points).ok_or("all its points lie in one plane")?;
        let ball: Vec<DVec3> = points.iter().map(|&p| rounded.inward(p)).collect();
        // The hull builder is known to panic on some inputs: a panic is a hull that failed.
        let built = catch_unwind(AssertUnwindSafe(|| try_convex_hull(&ball)))
            .map_err(|_| "the hull builder gave up".to_owned())?;
        let (vertices, faces) = built.map_err(|e| format!("it has no hull: {e:?}"))?;
        let vertices = vertices.into_iter().map(|p| rounded.outward(p)).collect();
        Self::of_surface(vertices, faces)
    }

    /// The hull with that surface.
    fn of_surface(points: Vec<DVec3>, faces: Vec<[u32; 3]>) -> Result<Self, String> {
        let mesh = Mesh::new(points, faces).map_err(|e| e.to_string())?;
        let near = BoxTree::of_mesh(&mesh);
        let planes = planes_of(&mesh);
        let (volume, bounds) = (mesh.signed_volume(), mesh.bounds());
        if planes.len() < 4 || volume <= 0.0 {
            return Err("its hull has no volume".into());
        }
        Ok(Self { mesh, volume, bounds, planes, near })
    }

    /// How far inside a point lies, metres; negative outside (then less than the true distance).
    pub(crate) fn depth(&self, p: DVec3) -> f64 {
        self.planes.iter().map(|(n, d)| d - n.dot(p)).fold(f64::INFINITY, f64::min)
    }

    /// Whether a point lies inside, deeper than `margin`.
    pub(crate) fn contains(&self, p: DVec3, margin: f64) -> bool {
        self.is_in_box(p) && self.planes.iter().all(|(n, d)| d - n.dot(p) >= margin)
    }

    /// The smallest extent, taken along the face normals, metres.
    pub(crate) fn thickness(&self) -> f64 {
        let extent = |(n, d): &(DVec3, f64)| {
            let reach = self.mesh.vertices().iter().map(|v| n.dot(*v));
            d - reach.fold(f64::INFINITY, f64::min)
        };
        self.planes.iter().map(extent).fold(f64::INFINITY, f64::min)
    }

    fn is_in_box(&self, p: DVec3) -> bool {
        self.bounds.min.cmple(p).all() && p.cmple(self.bounds.max).all()
    }

    fn box_distance_squared(&self, p: DVec3) -> f64 {
        (self.bounds.min - p).max(p - self.bounds.max).max(DVec3::ZERO).length_squared()
    }
}

/// A linear map that makes a cloud of points equally wide in all directions, so that a thin sheet
/// does not look flat to the hull builder. Keeps the hull's faces and their sense.
struct Rounding {
    centre: DVec3,
    axes: DMat3,
    widths: DVec3,
}

impl Rounding {
    /// `None` if the points lie in one plane.
    fn of(points: &[DVec3]) -> Option<Self> {
        let bounds = Bounds::of(points.iter().copied());
        let centre = bounds.centre();
        let mut spread = DMat3::ZERO;
        for p in points {
            let d = *p - centre;
            spread += DMat3::from_cols(d * d.x, d * d.y, d * d.z);
        }
        let axes = DSymmetricEigen3::new(spread).eigenvectors;
        let axes = if axes.determinant() < 0.0 { axes * -1.0 } else { axes };
        let width = |axis: DVec3| {
            let reach = points.iter().map(|p| axis.dot(*p - centre));
            let (low, high) = reach
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), r| (lo.min(r), hi.max(r)));
            high - low
        };
        let widths = DVec3::new(width(axes.col(0)), width(axes.col(1)), width(axes.col(2)));
        let is_solid = widths.is_finite() && widths.min_element() > 1e-9 * widths.max_element();
        let is_turn = (axes.determinant() - 1.0).abs() < 1e-6;
        (is_solid && is_turn).then_some(Self { centre, axes, widths })
    }

    fn inward(&self, p: DVec3) -> DVec3 {
        (self.axes.transpose() * (p - self.centre)) / self.widths
    }

    fn outward(&self, p: DVec3) -> DVec3 {
        self.axes * (p * self.widths) + self.centre
    }
}

/// Planes of the faces that are large enough to have a direction, each direction once.
fn planes_of(mesh: &Mesh) -> Vec<(DVec3, f64)> {
    let tiny = 1e-12 * mesh.bounds().diagonal().powi(2);
    let mut planes: Vec<(DVec3, f64)> = Vec::new();
    for f in (0..mesh.faces().len()).filter(|&f| mesh.area(f) > tiny) {
        let n = mesh.normal(f);
        if planes.iter().all(|(known, _)| known.distance_squared(n) > SAME_DIRECTION) {
            let reach = mesh.vertices().iter().map(|v| n.dot(*v)).fold(f64::NEG_INFINITY, f64::max);
            planes.push((n, reach));
        }
    }
    planes
}

/// The farthest points in directions spread evenly over the sphere (Fibonacci lattice).
fn extreme_points(points: &[DVec3]) -> Vec<DVec3> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let direction = |i: u32| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(DIRECTIONS);
        let (s, c) = (golden * f64::from(i)).sin_cos();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * c, r * s, z)
    };
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let directions = (0..DIRECTIONS).map(direction);
    let directions = directions.chain(axes).chain(axes.map(|a| -a));
    let farthest = |d: DVec3| {
        let by_reach = |a: &&DVec3, b: &&DVec3| d.dot(**a).total_cmp(&d.dot(**b));
        points.iter().max_by(by_reach).copied()
    };
    directions.filter_map(farthest).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hull_of_a_box_knows_inside_depth_and_thickness() {
        let cube = tessellated(&Geometry::Box { size: DVec3::new(1.0, 2.0, 3.0) });
        let hull = Hull::of(cube.unwrap().vertices().to_vec()).unwrap();
        assert!((hull.volume - 6.0).abs() < 1e-12);
        assert!((hull.thickness() - 1.0).abs() < 1e-12);
        assert!((hull.depth(DVec3::new(0.4, 0.0, 0.0)) - 0.1).abs() < 1e-12);
        assert!(hull.contains(DVec3::ZERO, 0.49) && !hull.contains(DVec3::ZERO, 0.51));
    }

    #[test]
    fn a_sheet_however_thin_and_turned_has_a_hull() {
        let sheet = tessellated(&Geometry::Box { size: DVec3::new(1.0, 2.0, 1e-5) });
        let turn = glamx::DQuat::from_euler(glamx::EulerRot::XYZ, 0.3, 0.7, -1.1);
        let hull = Hull::of(sheet.unwrap().vertices().iter().map(|v| turn * *v).collect()).unwrap();
        assert!((hull.volume / 2e-5 - 1.0).abs() < 1e-6, "{}", hull.volume);
        assert!((hull.thickness() / 1e-5 - 1.0).abs() < 1e-6, "{}", hull.thickness());
    }

    #[test]
    fn flat_points_have_no_hull() {
        let flat = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y];
        assert!(Hull::of(flat).is_err());
    }

    #[test]
    fn many_points_keep_their_extremes() {
        let ball = tessellated(&Geometry::Sphere { radius: 1.0 }).unwrap();
        let reach = extreme_points(ball.vertices()).len();
        assert_eq!(reach, DIRECTIONS as usize + 6);
    }
}
