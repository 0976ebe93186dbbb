//! How the segments of a surface touch: area in contact, area swallowed, smallest gap.

use std::collections::BTreeMap;

use object::mesh::Bounds;
use object::sample::{SurfacePoint, sample_surface};
use object::weld::Weld;
use object::{DVec3, Mesh};
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::{TriMesh, TriMeshFlags};
use rayon::prelude::*;

/// Two surfaces closer than this share of the mesh's diagonal touch.
pub(crate) const TOUCH: f64 = 0.002;
/// Two surfaces further apart than this share of the diagonal have nothing to do with each other.
pub(crate) const REACH: f64 = 0.015;
/// Sample points over the whole surface, shared out by area.
const SAMPLES: f64 = 16_000.0;
/// Sample points a component gets at least and at most.
const SAMPLES_EACH: (f64, f64) = (64.0, 4_000.0);

/// One component of the surface, ready to be asked for distances.
#[derive(Debug)]
pub(crate) struct Body {
    /// Its faces, ascending, as indices into the mesh.
    pub faces: Vec<u32>,
    /// Its box, object frame, metres.
    pub bounds: Bounds,
    /// Its surface area, m².
    pub area: f64,
    samples: Vec<SurfacePoint>,
    shape: Option<TriMesh>,
    closed: bool,
}

/// What passes between two segments, seen from the first one's surface: shares of its area.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch {
    /// Area of the first within [`TOUCH`] of the second or inside it, m².
    pub touching: f64,
    /// Area of the first inside the second, m².
    pub inside: f64,
    /// Area of the first within [`REACH`] of the second or inside it, m².
    pub reaching: f64,
    /// Smallest distance found, metres; zero if anything is inside.
    pub gap: f64,
    /// How deep the first is in the second, metres.
    pub depth: f64,
    /// Distance of what is within [`REACH`] and not inside, summed over its area, m³.
    pub apart: f64,
    /// Box of what touches, object frame, metres.
    pub bounds: Bounds,
    /// Normals of what touches, summed over its area, m².
    pub normal: DVec3,
}

impl Touch {
    /// Nothing passes.
    pub(crate) const NONE: Self = Self {
        touching: 0.0,
        inside: 0.0,
        reaching: 0.0,
        gap: f64::INFINITY,
        depth: 0.0,
        apart: 0.0,
        bounds: Bounds { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY },
        normal: DVec3::ZERO,
    };
}

/// The components of the surface as bodies, in order of first face.
pub(crate) fn bodies(mesh: &Mesh, weld: &Weld) -> (Vec<u32>, Vec<Body>) {
    let (component, count) = weld.components();
    let mut faces = vec![Vec::new(); count];
    for (face, &c) in component.iter().enumerate() {
        faces[c as usize].push(face as u32);
    }
    let total: f64 = (0..mesh.faces().len()).map(|f| mesh.area(f)).sum();
    let bodies = faces.into_par_iter().map(|f| body(mesh, weld, f, total)).collect();
    (component, bodies)
}

fn body(mesh: &Mesh, weld: &Weld, faces: Vec<u32>, total: f64) -> Body {
    let area: f64 = faces.iter().map(|&f| mesh.area(f as usize)).sum();
    let corners = faces.iter().flat_map(|&f| mesh.corners(f as usize));
    let bounds = Bounds::of(corners);
    let (least, most) = SAMPLES_EACH;
    let wanted = (SAMPLES * area / total.max(f64::MIN_POSITIVE)).clamp(least, most) as usize;
    let samples = mesh.submesh(faces.iter().map(|&f| f as usize));
    let samples = samples.map_or(Vec::new(), |s| sample_surface(&s, wanted, 1));
    let closed = is_closed(weld, &faces);
    let shape = shape(weld, &faces, closed);
    Body { faces, bounds, area, samples, shape, closed }
}

/// Whether every edge has exactly two faces, run through once in each direction.
fn is_closed(weld: &Weld, faces: &[u32]) -> bool {
    let mut edges: Vec<[u32; 2]> = Vec::with_capacity(faces.len() * 3);
    for &f in faces {
        let [a, b, c] = weld.faces[f as usize];
        edges.extend([[a, b], [b, c], [c, a]].into_iter().filter(|[p, q]| p != q));
    }
    edges.sort_unstable();
    let once = edges.windows(2).all(|w| w[0] != w[1]);
    once && edges.iter().all(|&[a, b]| edges.binary_search(&[b, a]).is_ok())
}

fn shape(weld: &Weld, faces: &[u32], closed: bool) -> Option<TriMesh> {
    let mut index = BTreeMap::new();
    let mut vertices = Vec::new();
    let mut local = |p: u32| {
        *index.entry(p).or_insert_with(|| {
            vertices.push(weld.places[p as usize]);
            vertices.len() as u32 - 1
        })
    };
    let triangles = faces.iter().map(|&f| weld.faces[f as usize].map(&mut local)).collect();
    let flags = if closed { TriMeshFlags::ORIENTED } else { TriMeshFlags::empty() };
    TriMesh::with_flags(vertices, triangles, flags).ok()
}

/// A sample point of a component that comes near another one or lies inside it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    /// The component.
    body: u32,
    /// Which of its sample points.
    sample: u32,
    /// The face of the mesh that is nearest on the other.
    face: u32,
    /// Whether it is inside.
    inside: bool,
    /// How far that face is, metres.
    distance: f64,
}

/// All sample points within [`REACH`] of another component (a share of `diagonal`) or inside it, by component,
/// then by the other.
pub(crate) fn near(bodies: &[Body], diagonal: f64) -> Vec<Near> {
    let reach = REACH * diagonal;
    let near =
        |a: usize, b: usize| a != b && bodies[a].bounds.grown(reach).intersects(&bodies[b].bounds);
    let pairs: Vec<(usize, usize)> = (0..bodies.len())
        .flat_map(|a| (0..bodies.len()).map(move |b| (a, b)))
        .filter(|&(a, b)| near(a, b))
        .collect();
    let of_pair = |&(a, b): &(usize, usize)| {
        let (samples, other) = (bodies[a].samples.iter().enumerate(), &bodies[b]);
        let found = samples.filter_map(|(sample, point)| {
            let (distance, inside, face) = other.nearest(point.position, reach)?;
            let (body, sample, face) = (a as u32, sample as u32, other.faces[face as usize]);
            Some(Near { body, sample, face, inside, distance })
        });
        found.collect::<Vec<Near>>()
    };
    let found: Vec<Vec<Near>> = pairs.par_iter().map(of_pair).collect();
    found.concat()
}

/// For every ordered pair of segments within [`REACH`] of each other (shares of `diagonal`), how the
/// first touches the second. A segment is a component or a patch of one (`segment_of_face`); patches
/// of one component are not compared.
pub(crate) fn touches(
    (bodies, near): (&[Body], &[Near]),
    segment_of_face: &[u32],
    diagonal: f64,
) -> BTreeMap<(u32, u32), Touch> {
    let mut touches = BTreeMap::new();
    for &Near { body, sample, face, inside, distance } in near {
        let first = &bodies[body as usize];
        let sample = &first.samples[sample as usize];
        let share = first.area / first.samples.len().max(1) as f64;
        let here = segment_of_face[first.faces[sample.face as usize] as usize];
        let there = segment_of_face[face as usize];
        let touch = touches.entry((here, there)).or_insert(Touch::NONE);
        touch.reaching += share;
        touch.inside += if inside { share } else { 0.0 };
        touch.gap = touch.gap.min(if inside { 0.0 } else { distance });
        if inside {
            touch.depth = touch.depth.max(distance);
        } else {
            touch.apart += share * distance;
        }
        if inside || distance < TOUCH * diagonal {
            touch.touching += share;
            touch.normal += sample.normal * share;
            let (b, x) = (&touch.bounds, sample.position);
            touch.bounds = Bounds { min: b.min.min(x), max: b.max.max(x) };
        }
    }
    touches
}

impl Body {
    /// Distance, whether inside, and the body's own number of the nearest face; `None` if further
    /// than `reach` and outside.
    fn nearest(&self, p: DVec3, reach: f64) -> Option<(f64, bool, u32)> {
        if !self.bounds.grown(reach).intersects(&Bounds { min: p, max: p }) {
            return None;
        }
        let shape = self.shape.as_ref()?;
        if !self.closed {
            let (found, (face, _)) =
                shape.project_local_point_and_get_location_with_max_dist(p, false, reach)?;
            return Some((found.point.distance(p), false, face));
        }
        let (found, (face, _)) = shape.project_local_point_and_get_location(p, false);
        let distance = found.point.distance(p);
        (found.is_inside || distance <= reach).then_some((distance, found.is_inside, face))
    }
}
