//! The gap between two bodies as it is seen: between their visual surfaces.
//!
//! Collision pieces may leave the surface by millimetres, so a bound of 3 mm on a gap can only be
//! held against what is seen.

use glamx::{DPose3, DVec3};
use object::Mesh;
use object::sample::sample_surface;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::TriMesh;

use super::scene::Scene;
use crate::robot::Geometry;

/// Points taken of each body, besides its corners.
const POINTS: usize = 1500;
/// Corners taken of each body.
const CORNERS: usize = 1500;

/// The visual surface of one body: all visual meshes of its link.
pub struct Skin {
    link: usize,
    shapes: Vec<TriMesh>,
    points: Vec<DVec3>,
}

impl Skin {
    /// The skin of a body, link frame; `None` unless all its visuals are readable meshes.
    pub fn of(scene: &Scene, body: usize) -> Option<Self> {
        let link = scene.bodies.get(body)?.link;
        let visuals = &scene.robot.links.get(link)?.visuals;
        let (mut shapes, mut points) = (Vec::new(), Vec::new());
        for visual in visuals {
            let Geometry::Mesh(mesh) = &visual.geometry else { return None };
            let placed = mesh.map_vertices(|v| visual.origin * v).ok()?;
            points.extend(some_points(&placed));
            shapes.push(TriMesh::new(placed.vertices().to_vec(), placed.faces().to_vec()).ok()?);
        }
        (!shapes.is_empty()).then_some(Self { link, shapes, points })
    }

    fn distance(&self, point: DVec3) -> f64 {
        let to = |s: &TriMesh| s.distance_to_local_point(point, false);
        self.shapes.iter().map(to).fold(f64::INFINITY, f64::min)
    }
}

fn some_points(mesh: &Mesh) -> Vec<DVec3> {
    let stride = mesh.vertices().len().div_ceil(CORNERS).max(1);
    let corners = mesh.vertices().iter().step_by(stride).copied();
    corners.chain(sample_surface(mesh, POINTS, 0).into_iter().map(|p| p.position)).collect()
}

/// Two skins whose gap is measured, the points that move least about an axis first.
pub struct SeenGap {
    skins: [Skin; 2],
}

impl SeenGap {
    /// Skins of the guide and of what moves in it; the axis is given at rest, root frame.
    pub fn new(scene: &Scene, bodies: [usize; 2], axis: (DVec3, DVec3)) -> Option<Self> {
        let [mut a, mut b] = [Skin::of(scene, bodies[0])?, Skin::of(scene, bodies[1])?];
        let rest = scene.robot.link_poses(&scene.rest());
        for skin in [&mut a, &mut b] {
            let pose = rest.get(skin.link).copied()?;
            let off = |p: &DVec3| (pose * *p - axis.0).reject_from_normalized(axis.1).length();
            skin.points.sort_by(|p, q| off(p).total_cmp(&off(q)));
        }
        Some(Self { skins: [a, b] })
    }

    /// The gap at some joint values, metres; anything up to `enough` counts as `enough`.
    pub fn at(&self, scene: &Scene, values: &[f64], enough: f64) -> f64 {
        let links = scene.robot.link_poses(values);
        let pose = |s: &Skin| links.get(s.link).copied().unwrap_or(DPose3::identity());
        let [a, b] = &self.skins;
        let mut least = f64::INFINITY;
        for (from, to) in [(a, b), (b, a)] {
            let across = pose(to).inverse() * pose(from);
            for &p in &from.points {
                least = least.min(to.distance(across * p));
                if least <= enough {
                    return enough;
                }
            }
        }
        least
    }
}
