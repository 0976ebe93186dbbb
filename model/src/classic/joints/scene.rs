//! The parts of a labelled mesh as bodies one can measure: samples, boxes, nearest points.
//!
//! Inside a scene lengths are shares of the object's diagonal and the origin is the centre of its
//! box, so every tolerance is a plain number and nothing depends on the unit.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use object::mesh::Bounds;
use object::sample::{SurfacePoint, sample_surface};
use object::weld::Weld;
use object::{DVec3, Mesh};
use parry3d_f64::shape::TrianglePointLocation;
use rayon::prelude::*;

use crate::classic::joints::labelled::Labelled;
use crate::classic::joints::looks::{Look, Surface};

/// Points sampled on each part for its shape.
const SHAPE_SAMPLES: usize = 600;
/// A look from a surface begins this far before it.
const AHEAD: f64 = 1e-3;
/// As far as an object reaches, and farther.
const FAR: f64 = 2.0;
/// Directions are asked about in steps of one in so many along each coordinate: 1.3° at most, and those along
/// the frame's axes as they are.
const STEPS: f64 = 32.0;
/// Extra points at corners far apart, so that tips are never missed.
const TIPS: usize = 48;

/// All parts of one object.
pub struct Scene {
    /// Length of the object's diagonal in the mesh's unit.
    pub unit: f64,
    /// Centre of the object's box, mesh frame.
    pub origin: DVec3,
    /// One body per part.
    pub bodies: Vec<Arc<Body>>,
    whole: Option<Arc<Surface>>,
    part_of_face: Vec<u16>,
}

/// What one looks at.
#[derive(Clone, Copy, Debug)]
pub struct Sight {
    /// How far it is.
    pub distance: f64,
    /// Unit normal of its face, either way round.
    pub normal: DVec3,
    /// Its part.
    pub part: u16,
}

/// One part: its surface, points on it and its box.
pub struct Body {
    /// Points spread by area.
    pub samples: Vec<SurfacePoint>,
    /// Points that may bump into things: by area, then corners far apart.
    pub probes: Vec<DVec3>,
    /// Its box.
    pub bounds: Bounds,
    /// Its area.
    pub area: f64,
    /// Mean of its samples.
    pub centroid: DVec3,
    mesh: Mesh,
    surface: Option<Surface>,
    /// For each face, which of its edges (0–1, 1–2, 0–2) no other face of the part shares.
    open: Vec<[bool; 3]>,
    around: Around,
    /// What [`Body::shown_along`] was told, by direction in [`STEPS`].
    shown: Mutex<HashMap<[i32; 3], f64>>,
}

/// The faces of a part around each of its welded corners.
#[derive(Default)]
struct Around {
    /// The corners of each face, by number within the part.
    corners: Vec<[u32; 3]>,
    /// Where the faces of each corner begin; one more at the end.
    begins: Vec<u32>,
    faces: Vec<u32>,
}

impl Around {
    fn new(faces: &[usize], weld: &Weld) -> Self {
        let mut known: Vec<u32> = faces.iter().flat_map(|&f| weld.faces[f]).collect();
        known.sort_unstable();
        known.dedup();
        let number = |v: u32| known.partition_point(|&k| k < v) as u32;
        let corners: Vec<[u32; 3]> = faces.iter().map(|&f| weld.faces[f].map(number)).collect();
        let mut pairs: Vec<(u32, u32)> =
            (0..).zip(&corners).flat_map(|(f, corners)| corners.map(|v| (v, f))).collect();
        pairs.sort_unstable();
        let begins = (0..=known.len() as u32).map(|v| pairs.partition_point(|p| p.0 < v) as u32);
        let begins = begins.collect();
        Self { corners, begins, faces: pairs.into_iter().map(|(_, f)| f).collect() }
    }

    /// The faces that share the edge or corner on which a place of a face lies; none of a place inside it.
    fn sharing(&self, face: u32, place: TrianglePointLocation) -> impl Iterator<Item = u32> {
        let own = self.corners.get(face as usize);
        let corner = |i: usize| own.and_then(|c| c.get(i)).copied();
        let (at, beside) = match place {
            TrianglePointLocation::OnVertex(v) => (corner(v as usize), None),
            TrianglePointLocation::OnEdge(0, _) => (corner(0), corner(1)),
            TrianglePointLocation::OnEdge(1, _) => (corner(1), corner(2)),
            TrianglePointLocation::OnEdge(_, _) => (corner(0), corner(2)),
            _ => (None, None),
        };
        let range = at.and_then(|at| {
            let [from, to] = [at, at + 1].map(|v| self.begins.get(v as usize).copied());
            Some(from? as usize..to? as usize)
        });
        let all = self.faces.get(range.unwrap_or_default()).unwrap_or_default();
        let holds = move |&f: &u32| {
            beside.is_none_or(|v| self.corners.get(f as usize).is_some_and(|c| c.contains(&v)))
        };
        all.iter().copied().filter(holds)
    }
}

/// The nearest point of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    /// Where.
    pub point: DVec3,
    /// Unit normal of its face.
    pub normal: DVec3,
    /// How far.
    pub distance: f64,
    /// Whether the point lies on the rim of an opening, where there is no inside.
    pub on_rim: bool,
}

impl Nearest {
    /// Whether `x` lies behind the face it is nearest to.
    pub fn is_behind(&self, x: DVec3) -> bool {
        !self.on_rim && (x - self.point).dot(self.normal) < 0.0
    }
}

impl Scene {
    /// Builds a body for every part.
    pub fn new(from: &Labelled, seed: u64) -> Self {
        Self::beside(&[], from, seed)
    }

    /// The same, of the mesh of other scenes, which may have other labels. What would be made as it is in one
    /// of them is shared: the whole object, and the body of a part that has the same faces.
    pub fn beside(others: &[&Self], from: &Labelled, seed: u64) -> Self {
        let Labelled { mesh, weld, tree, part_of_face, .. } = *from;
        let bounds = mesh.bounds();
        let (unit, origin) = (bounds.diagonal(), bounds.centre());
        let mut shared: Vec<Option<&Arc<Body>>> = vec![None; tree.len()];
        for other in others {
            let is_same = same_parts(part_of_face, &other.part_of_face, tree.len());
            let theirs = other.bodies.iter().zip(is_same).map(|(b, is_same)| is_same.then_some(b));
            shared.iter_mut().zip(theirs).for_each(|(known, body)| *known = known.or(body));
        }
        let mut faces = vec![Vec::new(); tree.len()];
        for (face, &part) in part_of_face.iter().enumerate() {
            faces[usize::from(part)].push(face);
        }
        let body = |(faces, shared): (&Vec<usize>, &Option<&Arc<Body>>)| {
            if let Some(body) = shared {
                return Arc::clone(body);
            }
            let (open, around) = (open_edges(faces, weld), Around::new(faces, weld));
            Arc::new(Body { open, around, ..Body::new(mesh, faces, unit, origin, seed) })
        };
        let whole = others.iter().find_map(|other| other.whole.clone()).or_else(|| {
            let corners = mesh.vertices().iter().map(|&v| (v - origin) / unit).collect();
            Surface::new(corners, mesh.faces().to_vec()).map(Arc::new)
        });
        let bodies = faces.par_iter().zip(&shared).map(body).collect();
        Self { unit, origin, bodies, whole, part_of_face: part_of_face.to_vec() }
    }

    /// The first surface one meets who looks from a point along `d`, if strictly within `reach`.
    pub fn look(&self, from: DVec3, d: DVec3, reach: f64) -> Option<Sight> {
        let whole = self.whole.as_ref()?;
        let (face, distance, normal) = Look::new(from, d).first(whole, reach)?;
        let part = *self.part_of_face.get(face as usize)?;
        (distance < reach).then_some(Sight { distance, normal, part })
    }

    /// Whether nothing of the object stands before a point on its surface, looking along `d`.
    pub fn is_open_along(&self, point: DVec3, d: DVec3) -> bool {
        let look = Look::new(point + d * AHEAD, d);
        self.whole.as_ref().is_none_or(|whole| !look.meets(whole, FAR))
    }

    /// The nearest point on any of `parts`, if within `reach`.
    pub fn nearest(&self, parts: &[usize], x: DVec3, reach: f64) -> Option<Nearest> {
        let mut best: Option<Nearest> = None;
        for &p in parts {
            let reach = best.map_or(reach, |b| b.distance);
            best = self.bodies[p].nearest(x, reach).or(best);
        }
        best
    }
}

impl Body {
    fn new(mesh: &Mesh, faces: &[usize], unit: f64, origin: DVec3, seed: u64) -> Self {
        let own = mesh.submesh(faces.iter().copied()).ok();
        let own = own.and_then(|m| m.map_vertices(|v| (v - origin) / unit).ok());
        own.map_or_else(|| Self::speck(mesh, faces, unit, origin), |m| Self::of(m, seed))
    }

    fn of(mesh: Mesh, seed: u64) -> Self {
        let samples = sample_surface(&mesh, SHAPE_SAMPLES, seed);
        let bounds = mesh.bounds();
        let sum: DVec3 = samples.iter().map(|s| s.position).sum();
        let centroid =
            if samples.is_empty() { bounds.centre() } else { sum / samples.len() as f64 };
        let mut probes: Vec<_> =
            samples.iter().take(SHAPE_SAMPLES / 3).map(|s| s.position).collect();
        probes.extend(spread(mesh.vertices(), TIPS));
        let area = (0..mesh.faces().len()).map(|f| mesh.area(f)).sum();
        let surface = Surface::new(mesh.vertices().to_vec(), mesh.faces().to_vec());
        let (open, around, shown) = (Vec::new(), Around::default(), Mutex::default());
        Self { samples, probes, bounds, area, centroid, mesh, surface, open, around, shown }
    }

    /// A part too small to be a mesh of its own: a point that touches nothing.
    fn speck(mesh: &Mesh, faces: &[usize], unit: f64, origin: DVec3) -> Self {
        let corner = faces.first().map_or(origin, |&f| mesh.centroid(f));
        let at = (corner - origin) / unit;
        let bounds = Bounds { min: at, max: at };
        let (samples, probes) = (Vec::new(), vec![at]);
        let (mesh, surface) = (mesh.clone(), None);
        let (open, around, shown) = (Vec::new(), Around::default(), Mutex::default());
        let (area, centroid) = (0.0, at);
        Self { samples, probes, bounds, area, centroid, mesh, surface, open, around, shown }
    }

    /// Whether the part was cut out of a fused mesh: edges of it are shared with no face of its own.
    pub fn is_open(&self) -> bool {
        self.open.iter().any(|edges| edges.contains(&true))
    }

    /// What follows from this part, the whole object and a direction, asked once for all directions that are
    /// nearly the same.
    pub(crate) fn shown_along(&self, d: DVec3, found: impl FnOnce(DVec3) -> f64) -> f64 {
        let steps = (d * STEPS).round();
        let key = steps.to_array().map(|c| c as i32);
        let known = || self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(value) = known().get(&key) {
            return *value;
        }
        let value = found(steps.try_normalize().unwrap_or(d));
        known().insert(key, value);
        value
    }

    /// The nearest point of this body, if strictly within `reach`.
    pub fn nearest(&self, x: DVec3, reach: f64) -> Option<Nearest> {
        let surface = self.surface.as_ref()?;
        let outside = (x - x.clamp(self.bounds.min, self.bounds.max)).length();
        if outside >= reach {
            return None;
        }
        let (face, point, place) = surface.nearest(x, reach)?;
        let distance = point.distance(x);
        let normal = self.facing(x, point, face, place);
        let open = self.open.get(face as usize).copied().unwrap_or_default();
        let on_rim = match place {
            TrianglePointLocation::OnEdge(e, _) => open[(e as usize).min(2)],
            TrianglePointLocation::OnVertex(0) => open[0] || open[2],
            TrianglePointLocation::OnVertex(1) => open[0] || open[1],
            TrianglePointLocation::OnVertex(_) => open[1] || open[2],
            _ => false,
        };
        (distance < reach).then_some(Nearest { point, normal, distance, on_rim })
    }

    /// The normal of the face nearest to `x`. Where faces share the edge or corner that is nearest, the one
    /// that looks most towards `x` or away from it: it alone tells before from behind.
    fn facing(&self, x: DVec3, point: DVec3, face: u32, place: TrianglePointLocation) -> DVec3 {
        let normal = self.mesh.normal(face as usize);
        let faced = |normal: DVec3| (x - point).dot(normal).abs();
        let mut best = (faced(normal), normal);
        for other in self.around.sharing(face, place).filter(|&other| other != face) {
            let normal = self.mesh.normal(other as usize);
            let faced = faced(normal);
            if faced > best.0 {
                best = (faced, normal);
            }
        }
        best.1
    }

    /// Up to `count` points by area on the faces that come within `margin` of `near`.
    pub fn samples_near(
        &self,
        near: Bounds,
        margin: f64,
        count: usize,
        seed: u64,
    ) -> Vec<SurfacePoint> {
        let near = near.grown(margin);
        let close = |&f: &usize| Bounds::of(self.mesh.corners(f)).intersects(&near);
        let faces = (0..self.mesh.faces().len()).filter(close);
        let patch = self.mesh.submesh(faces).ok();
        patch.map_or_else(Vec::new, |m| sample_surface(&m, count, seed))
    }

    /// Smallest and largest coordinate of the samples and tips along `d`.
    pub fn extent(&self, d: DVec3) -> (f64, f64) {
        let fold = |(low, high): (f64, f64), t: f64| (low.min(t), high.max(t));
        self.probes.iter().map(|p| p.dot(d)).fold((f64::INFINITY, f64::NEG_INFINITY), fold)
    }
}

/// For each part, whether it has the same faces in two labellings.
fn same_parts(of_face: &[u16], of_face_there: &[u16], parts: usize) -> Vec<bool> {
    let mut is_same = vec![true; parts];
    for (&here, &there) in of_face.iter().zip(of_face_there).filter(|(here, there)| here != there) {
        is_same[usize::from(here)] = false;
        is_same[usize::from(there)] = false;
    }
    is_same
}

/// For each of the faces, which edges (0–1, 1–2, 0–2) no other of them shares.
fn open_edges(faces: &[usize], weld: &Weld) -> Vec<[bool; 3]> {
    let edges = |f: usize| {
        let [a, b, c] = weld.faces[f];
        [[a, b], [b, c], [a, c]].map(|[p, q]| [p.min(q), p.max(q)])
    };
    let mut all: Vec<[u32; 2]> = faces.iter().flat_map(|&f| edges(f)).collect();
    all.sort_unstable();
    let uses = |e: [u32; 2]| {
        let first = all.partition_point(|&o| o < e);
        all[first..].iter().take(2).take_while(|&&o| o == e).count()
    };
    faces.iter().map(|&f| edges(f).map(|e| uses(e) < 2)).collect()
}

/// `count` of the points, far apart: each next one is the farthest from those chosen.
fn spread(points: &[DVec3], count: usize) -> Vec<DVec3> {
    let stride = points.len() / 4000 + 1;
    let points: Vec<DVec3> = points.iter().copied().step_by(stride).collect();
    let Some(&first) = points.first() else { return Vec::new() };
    let mut gap: Vec<f64> = points.iter().map(|p| p.distance_squared(first)).collect();
    let mut chosen = Vec::with_capacity(count);
    while chosen.len() < count {
        let far =
            gap.iter().enumerate().fold((0, 0.0), |b, (i, &g)| if g > b.1 { (i, g) } else { b });
        if far.1 <= 0.0 {
            break;
        }
        let next = points[far.0];
        chosen.push(next);
        gap.iter_mut().zip(&points).for_each(|(g, p)| *g = g.min(p.distance_squared(next)));
    }
    chosen
}

#[cfg(test)]
mod tests {
    use object::{KinematicTree, Part};

    use super::*;

    /// A unit box whose faces come in an order that is turned by so many.
    fn cube(turned: usize) -> Mesh {
        let at = |i: usize| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64);
        let sides =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let mut triangles: Vec<[DVec3; 3]> = sides
            .iter()
            .flat_map(|&[a, b, c, d]| [[at(a), at(b), at(c)], [at(a), at(c), at(d)]])
            .collect();
        triangles.rotate_left(turned);
        Mesh::of_triangles(&triangles).unwrap()
    }

    #[test]
    fn beside_a_face_in_its_plane_one_is_before_the_box_whatever_face_is_found_first() {
        for turned in 0..12 {
            let mesh = cube(turned);
            let part =
                Part { name: "box".into(), text: String::new(), parent: None, joints: vec![] };
            let (tree, weld) = (KinematicTree::new(vec![part]).unwrap(), Weld::new(&mesh));
            let labels = [0; 12];
            let (category, given) = ("", &[][..]);
            let from = Labelled {
                mesh: &mesh,
                weld: &weld,
                tree: &tree,
                part_of_face: &labels,
                category,
                given,
            };
            let scene = Scene::new(&from, 1);
            let inside = |p: DVec3| (p - scene.origin) / scene.unit;
            // In the plane of the top and, by the last digit, below or above it; beyond the side x = 1.
            for off in [0.0, 1e-16, -1e-16] {
                let x = inside(DVec3::new(1.2, 0.4, 1.0)) + DVec3::Z * off;
                let near = scene.bodies[0].nearest(x, 1.0).unwrap();
                assert_eq!(near.normal, DVec3::X, "{turned} {off:e}");
                assert!(!near.is_behind(x));
            }
            // Beyond a corner, in the planes of two of its sides.
            let x = inside(DVec3::new(1.3, 1.0, 1.0));
            let near = scene.bodies[0].nearest(x, 1.0).unwrap();
            assert_eq!((near.normal, near.is_behind(x)), (DVec3::X, false), "{turned}");
        }
    }
}
