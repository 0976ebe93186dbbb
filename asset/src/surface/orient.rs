//! Which side of a surface is outside: by volume where it is closed, by sight where it is open.
//!
//! ```
//! use asset::surface::orient::Scene;
//! use asset::surface::repair::repair;
//! use object::{DVec3, Mesh};
//! let (corners, face) = (vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[0, 1, 2]]);
//! let sheet = Mesh::new(corners, face)?;
//! // Both its sides see as much of the outside: it stays as it is.
//! let surface = repair(&sheet, Scene::new(&sheet).as_ref())?;
//! assert_eq!(surface.report.flipped, 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use glamx::DVec3;
use object::Mesh;
use object::mesh::Bounds;
use parry3d_f64::query::{Ray, RayCast};
use parry3d_f64::shape::TriMesh;

use crate::surface::patches::Patches;
use crate::surface::repaired::Patch;

/// An open patch is turned over when its back sees this much more of the outside than its front.
const CLEARLY_OUTSIDE: f64 = 0.25;
/// A closed patch encloses something when its volume exceeds this share of area^1.5.
const ENCLOSES: f64 = 1e-7;
/// Open patches below this share of the part's area keep the file's side.
const NEGLIGIBLE: f64 = 1e-3;
/// Places from which one patch looks around.
const LOOKOUTS: usize = 12;

type Corners = [DVec3; 3];

/// The whole object, to tell the outside of an open surface from its inside.
pub struct Scene {
    surface: TriMesh,
    reach: f64,
}

impl Scene {
    /// The scene of a mesh; `None` if no search tree can be built over it.
    pub fn new(mesh: &Mesh) -> Option<Self> {
        let surface = TriMesh::new(mesh.vertices().to_vec(), mesh.faces().to_vec()).ok()?;
        Some(Self { surface, reach: mesh.bounds().diagonal() * 2.0 })
    }

    /// Share of directions on the side of `normal` in which a ray from `point` meets nothing.
    fn openness(&self, point: DVec3, normal: DVec3) -> f64 {
        let start = point + normal * (self.reach * 1e-4);
        let free = |d: DVec3| {
            let hit = self.surface.cast_local_ray(&Ray::new(start, d), self.reach, false);
            f64::from(u8::from(hit.is_none()))
        };
        let ahead = directions().filter(|d| d.dot(normal) > 0.15);
        let (sum, count) = ahead.fold((0.0, 0.0), |(s, n), d| (s + free(d), n + 1.0));
        if count > 0.0 { sum / count } else { 0.0 }
    }
}

/// Directions spread evenly over the sphere, on a Fibonacci spiral.
fn directions() -> impl Iterator<Item = DVec3> {
    let (n, golden) = (26, std::f64::consts::PI * (3.0 - 5.0_f64.sqrt()));
    (0..n).map(move |i| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(n);
        let (sin, cos) = (golden * f64::from(i) + 0.3).sin_cos();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * cos, r * sin, z)
    })
}

/// Turns whole patches outward, in `found.flipped`, and describes them as they then are.
pub(crate) fn outward(
    corners: &[Corners],
    found: &mut Patches,
    closed: &[bool],
    scene: Option<&Scene>,
) -> Vec<Patch> {
    let patches: Vec<Patch> = (0..closed.len())
        .map(|p| {
            let volume = closed[p].then(|| volume(corners, found, p)).flatten();
            Patch { faces: found.faces[p].clone(), volume, hollows: None }
        })
        .collect();
    let mut patches = with_cavities(corners, found, patches);
    for patch in patches.iter_mut().filter(|p| p.volume.is_some()) {
        let is_outward = patch.volume.is_some_and(|v| v > 0.0);
        if is_outward == patch.hollows.is_some() {
            turn(found, patch);
        }
    }
    if let Some(scene) = scene {
        orient_sheets(corners, found, &patches, scene);
    }
    patches
}

fn turn(found: &mut Patches, patch: &mut Patch) {
    patch.faces.iter().for_each(|&f| found.flipped[f as usize] ^= true);
    patch.volume = patch.volume.map(|v| -v);
}

/// A face's corners, as turned.
fn turned(corners: &[Corners], found: &Patches, face: u32) -> Corners {
    let [a, b, c] = corners[face as usize];
    if found.flipped[face as usize] { [a, c, b] } else { [a, b, c] }
}

/// Signed volume of a closed patch; `None` if it is folded flat.
fn volume(corners: &[Corners], found: &Patches, patch: usize) -> Option<f64> {
    let faces = &found.faces[patch];
    let origin = faces.first().map_or(DVec3::ZERO, |&f| corners[f as usize][0]);
    let (mut volume, mut area) = (0.0, 0.0);
    for &face in faces {
        let [a, b, c] = turned(corners, found, face).map(|p| p - origin);
        volume += a.dot(b.cross(c)) / 6.0;
        area += (b - a).cross(c - a).length() / 2.0;
    }
    (volume.abs() > ENCLOSES * area.powf(1.5)).then_some(volume)
}

/// Marks as cavities the closed patches that lie in a body and face the other way in the file.
fn with_cavities(corners: &[Corners], found: &Patches, mut patches: Vec<Patch>) -> Vec<Patch> {
    let bounds: Vec<Bounds> = patches
        .iter()
        .map(|p| Bounds::of(p.faces.iter().flat_map(|&f| corners[f as usize])))
        .collect();
    let size = |p: usize, ps: &[Patch]| ps[p].volume.map_or(0.0, f64::abs);
    let mut largest_first: Vec<usize> =
        (0..patches.len()).filter(|&p| patches[p].volume.is_some()).collect();
    largest_first.sort_by(|&a, &b| size(b, &patches).total_cmp(&size(a, &patches)));
    for (n, &inner) in largest_first.iter().enumerate() {
        let Some(own) = patches[inner].volume else { continue };
        let probe = probe(corners, &patches[inner]);
        let container = largest_first[..n].iter().rev().copied().find(|&outer| {
            holds(&bounds[outer], &bounds[inner])
                && winding(corners, &patches[outer], found, probe).abs() > 0.75
        });
        patches[inner].hollows = container.filter(|&o| {
            let is_body = patches[o].hollows.is_none();
            is_body && patches[o].volume.is_some_and(|v| v * own < 0.0)
        });
    }
    patches
}

fn holds(outer: &Bounds, inner: &Bounds) -> bool {
    outer.min.cmple(inner.min).all() && outer.max.cmpge(inner.max).all()
}

/// A point of the patch: the centroid of its first face.
fn probe(corners: &[Corners], patch: &Patch) -> DVec3 {
    let [a, b, c] = patch.faces.first().map_or([DVec3::ZERO; 3], |&f| corners[f as usize]);
    (a + b + c) / 3.0
}

/// How often a closed patch winds round a point: ±1 inside, 0 outside (van Oosterom and Strackee).
fn winding(corners: &[Corners], patch: &Patch, found: &Patches, point: DVec3) -> f64 {
    let solid_angle = |&face: &u32| {
        let [a, b, c] = turned(corners, found, face).map(|p| p - point);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * a.dot(b.cross(c)).atan2(below)
    };
    patch.faces.iter().map(solid_angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

fn orient_sheets(corners: &[Corners], found: &mut Patches, patches: &[Patch], scene: &Scene) {
    let area = |f: u32| {
        let [a, b, c] = corners[f as usize];
        (b - a).cross(c - a).length() / 2.0
    };
    let total: f64 = (0..corners.len() as u32).map(area).sum();
    for patch in patches.iter().filter(|p| p.volume.is_none()) {
        let own: f64 = patch.faces.iter().map(|&f| area(f)).sum();
        if own < NEGLIGIBLE * total {
            continue;
        }
        let shows_back = |f: u32| {
            let [a, b, c] = turned(corners, found, f);
            let (at, normal) = ((a + b + c) / 3.0, (b - a).cross(c - a).normalize_or_zero());
            scene.openness(at, -normal) - scene.openness(at, normal)
        };
        let lookouts = spread(&patch.faces, area, own);
        let mean = lookouts.iter().map(|&f| shows_back(f)).sum::<f64>() / lookouts.len() as f64;
        if mean > CLEARLY_OUTSIDE {
            patch.faces.iter().for_each(|&f| found.flipped[f as usize] ^= true);
        }
    }
}

/// [`LOOKOUTS`] faces of a patch, evenly spread by area.
fn spread(faces: &[u32], area: impl Fn(u32) -> f64, total: f64) -> Vec<u32> {
    let step = total / LOOKOUTS as f64;
    let (mut sum, mut next, mut chosen) = (0.0, step / 2.0, Vec::new());
    for &face in faces {
        sum += area(face);
        while sum >= next && chosen.len() < LOOKOUTS {
            chosen.push(face);
            next += step;
        }
    }
    if chosen.is_empty() { faces.first().copied().into_iter().collect() } else { chosen }
}
