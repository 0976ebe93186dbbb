//! How clean, tight and fast the collision pieces of the development cases are, with the true
//! labels and joints: `measure_collision [case...]`, cases under `$KINFOLD_SHARED/data/cases/dev`.
//!
//! Measures with parry's contact query on the finished pieces, independently of how they were made.
#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::path::{Path, PathBuf};

use asset::collision::clearance::{ClearanceOptions, Cleared, clear};
use asset::collision::hulls::decompose;
use asset::collision::piece::ConvexPiece;
use glamx::{DPose3, DVec3};
use object::pose::part_poses;
use object::sample::sample_surface;
use object::{ArticulatedObject, Configuration, JointMotion, KinematicTree, Mesh, Part};
use parry3d_f64::query::{PointQuery, contact, distance};
use parry3d_f64::shape::{ConvexPolyhedron, TriMesh};
use rayon::prelude::*;
use serde_json::Value;

use truth::motion;

#[path = "shared/truth.rs"]
mod truth;

type Failure = Box<dyn std::error::Error + Send + Sync>;

fn main() -> Result<(), Failure> {
    let shared = std::env::var("KINFOLD_SHARED").unwrap_or_else(|_| "../shared".into());
    let folder = Path::new(&shared).join("data/cases/dev");
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let mut cases: Vec<PathBuf> =
        std::fs::read_dir(folder)?.filter_map(|e| Some(e.ok()?.path())).collect();
    cases.sort();
    let name = |p: &Path| p.file_name().map_or(String::new(), |n| n.to_string_lossy().into());
    cases.retain(|p| {
        let name = name(p);
        if wanted.is_empty() {
            !name.ends_with("-fused")
        } else {
            wanted.iter().any(|w| {
                name.contains(w.trim_end_matches('$'))
                    && (!w.ends_with('$') || !name.ends_with("-fused"))
            })
        }
    });
    println!("{}", Row::HEADER);
    let mut bad = 0;
    for case in &cases {
        match measure(case) {
            Ok(row) => {
                bad += usize::from(!row.is_clean());
                println!("{} {}", row.print(), name(case));
            }
            Err(e) => {
                bad += 1;
                println!("failed: {e} {}", name(case));
            }
        }
    }
    println!("{} cases, {bad} not clean", cases.len());
    Ok(())
}

/// Figures of one case; lengths as shares of the diagonal, in per mille.
#[derive(Default)]
struct Row {
    diagonal: f64,
    parts: usize,
    pieces: usize,
    most: usize,
    unsound: usize,
    rest: f64,
    sweep: f64,
    combined: f64,
    /// Largest distance of a visual sample from its link's pieces, over the tolerance.
    cover: f64,
    /// Largest share of samples of a link farther than the tolerance.
    bare: f64,
    /// The same before clearing.
    bare_before: f64,
    /// Share of collision volume that fills a cavity.
    filled: f64,
    /// Worst growth of the gap of a hinge, over its allowance.
    growth: f64,
    /// Mean and largest share of a range lost.
    lost: f64,
    lost_most: f64,
    seconds: [f64; 2],
    /// Growth of hinge gaps before clearing.
    growth_before: f64,
    bound: f64,
}

impl Row {
    const HEADER: &'static str = "clean | diag parts pieces most unsound | rest sweep combo permille | cover/tol bare% before% filled% | gap/allow before | lost% most% | hulls s clear s";

    fn is_clean(&self) -> bool {
        let deepest = self.rest.max(self.sweep).max(self.combined);
        deepest <= self.bound && self.unsound == 0
    }

    fn print(&self) -> String {
        let mille = 1e3 / self.diagonal;
        format!(
            "{} {} | {:.2} {:2} {:3} {:2} {} | {:.2} {:.2} {:.2} | {:.2} {:.2} {:.2} {:.1} | {:.1} {:.1} | {:.1} {:.0} | {:.2} {:.2}",
            if self.is_clean() { "ok " } else { "BAD" },
            if self.cover <= 1.0 && self.filled < 0.05 { "ok " } else { "BAD" },
            self.diagonal,
            self.parts,
            self.pieces,
            self.most,
            self.unsound,
            self.rest * mille,
            self.sweep * mille,
            self.combined * mille,
            self.cover,
            self.bare * 100.0,
            self.bare_before * 100.0,
            self.filled * 100.0,
            self.growth,
            self.growth_before,
            self.lost * 100.0,
            self.lost_most * 100.0,
            self.seconds[0],
            self.seconds[1],
        )
    }
}

fn measure(case: &Path) -> Result<Row, Failure> {
    let object = read_case(case)?;
    let diagonal = object.mesh().bounds().diagonal();
    let options = ClearanceOptions::for_diagonal(diagonal);
    let parts = object.tree().len();
    let links: Vec<Mesh> =
        (0..parts).map(|p| object.mesh().submesh(object.faces_of(p))).collect::<Result<_, _>>()?;
    let start = cpu_seconds();
    let pieces: Vec<_> =
        links.iter().map(|l| decompose(l, options.tolerance)).collect::<Result<_, _>>()?;
    let hulls = cpu_seconds() - start;
    let start = cpu_seconds();
    let cleared = clear(&object, pieces.clone(), &options);
    let seconds = [hulls, cpu_seconds() - start];
    if std::env::var("KINFOLD_CHANGES").is_ok() {
        cleared.changes.iter().for_each(|c| eprintln!("{c:?}"));
    }
    let moved = object.clone().with_joints(cleared.joints.clone())?;
    let mut row = Row { diagonal, parts, seconds, ..Row::default() };
    row.bound = (0.002 * diagonal).max(if std::env::var("STRICT").is_ok() { 0.0 } else { 0.001 });
    row.pieces = cleared.pieces.iter().map(Vec::len).sum();
    row.most = cleared.pieces.iter().map(Vec::len).max().unwrap_or(0);
    contacts(&moved, &cleared, &mut row);
    covers(&links, &cleared, &options, &mut row);
    let before = Cleared { pieces, ..cleared.clone() };
    let mut first = Row::default();
    covers(&links, &before, &options, &mut first);
    row.bare_before = first.bare;
    let shapes: Vec<Vec<_>> = before
        .pieces
        .iter()
        .map(|ps| ps.iter().filter_map(|p| shape(p, &mut first)).collect())
        .collect();
    for p in 0..parts {
        for k in 0..moved.joints(p).len() {
            row.growth_before = row.growth_before.max(growth(&moved, &shapes, (p, k), diagonal));
        }
    }
    ranges(&object, &moved, &mut row);
    Ok(row)
}

/// CPU time of the main thread, seconds, as Linux counts it.
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/schedstat").unwrap_or_default();
    let nanoseconds = stat.split(' ').next().and_then(|n| n.parse::<f64>().ok());
    nanoseconds.unwrap_or(f64::NAN) * 1e-9
}

/// The case as an articulated object, metres, true labels and joints.
fn read_case(case: &Path) -> Result<ArticulatedObject, Failure> {
    let mesh = object::glb::read(&std::fs::read(case.join("mesh.glb"))?)?;
    let truth: Value = serde_json::from_slice(&std::fs::read(case.join("truth.json"))?)?;
    let labels = std::fs::read(case.join("face_labels.u16le"))?;
    let labels = labels.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
    let parts = truth["parts"].as_array().ok_or("no parts")?;
    let motions: Vec<Vec<JointMotion>> = parts.iter().map(motions).collect();
    let part = |(i, p): (usize, &Value)| Part {
        name: format!("part_{i}"),
        text: p["name"].as_str().unwrap_or("").into(),
        parent: p["parent"].as_u64().map(|p| p as usize),
        joints: motions[i].iter().map(|m| m.kind).collect(),
    };
    let tree = KinematicTree::new(parts.iter().enumerate().map(part).collect())?;
    let object = ArticulatedObject::new(mesh, tree, labels, motions.clone())?;
    let condition: Value = serde_json::from_slice(&std::fs::read(case.join("condition.json"))?)?;
    let size = object.mesh().bounds().size().max_element();
    let metric = truth["units"].as_str().is_some_and(|u| u.starts_with('m'));
    let real = condition["real_size_m"]["largest_extent"].as_f64();
    let scale = real.map_or(1.0, |r| if metric { 1.0 } else { r / size });
    Ok(object.scaled(scale, DVec3::ZERO)?)
}

fn motions(part: &Value) -> Vec<JointMotion> {
    let joints = part["joints"].as_array().cloned().unwrap_or_default();
    let mut found: Vec<JointMotion> = joints.iter().filter_map(motion).collect();
    let mut seen = [false; 2];
    found.retain(|m| !std::mem::replace(&mut seen[usize::from(m.kind.turns())], true));
    found
}

/// Deepest overlaps at rest, along each joint, and in combinations; hinge gaps.
fn contacts(object: &ArticulatedObject, cleared: &Cleared, row: &mut Row) {
    let shapes: Vec<Vec<ConvexPolyhedron>> =
        cleared.pieces.iter().map(|ps| ps.iter().filter_map(|p| shape(p, row)).collect()).collect();
    let rest = Configuration::rest(object.tree());
    let groups = rigid_groups(object);
    row.rest = deepest(object, &shapes, &groups, &rest);
    let joints: Vec<(usize, usize)> = (0..object.tree().len())
        .flat_map(|p| (0..object.joints(p).len()).map(move |k| (p, k)))
        .collect();
    let ends = |&(p, k): &(usize, usize)| object.joints(p)[k].range.ends();
    let mut poses = Vec::new();
    for &(p, k) in &joints {
        let (low, high) = ends(&(p, k));
        let steps = steps(object, p, &object.joints(p)[k]);
        poses.extend(
            (0..=steps)
                .map(|i| rest.clone().with(p, k, low + (high - low) * i as f64 / steps as f64)),
        );
        row.growth = row.growth.max(growth(object, &shapes, (p, k), row.diagonal));
    }
    let depth = |q: &Configuration| deepest(object, &shapes, &groups, q);
    row.sweep = poses.par_iter().map(depth).reduce(|| 0.0, f64::max);
    let mut poses = Vec::new();
    for (i, a) in joints.iter().enumerate() {
        for b in &joints[i + 1..] {
            for corner in 0..9 {
                let at = |e: (f64, f64), c: i32| [e.0, 0.0, e.1][c as usize];
                let q = rest.clone().with(a.0, a.1, at(ends(a), corner % 3));
                poses.push(q.with(b.0, b.1, at(ends(b), corner / 3)));
            }
        }
    }
    let mut random = 88_172_645_463_325_252_u64;
    for _ in 0..if joints.len() > 1 { 96 } else { 0 } {
        let mut q = rest.clone();
        for &(p, k) in &joints {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            let (low, high) = ends(&(p, k));
            q.0[p][k] = low + (high - low) * ((random >> 11) as f64 / (1u64 << 53) as f64);
        }
        poses.push(q);
    }
    row.combined = poses.par_iter().map(depth).reduce(|| 0.0, f64::max);
}

fn shape(piece: &ConvexPiece, row: &mut Row) -> Option<ConvexPolyhedron> {
    let hull = ConvexPolyhedron::from_convex_hull(&piece.vertices);
    let given = ConvexPolyhedron::from_convex_mesh(piece.vertices.clone(), &piece.faces);
    let thin = thickness(piece) < 0.001f64.min(0.002 * row.diagonal);
    if piece.vertices.len() > 64 || given.is_none() || hull.is_none() || thin {
        row.unsound += 1;
    }
    given.or(hull)
}

fn thickness(piece: &ConvexPiece) -> f64 {
    let breadth = |f: &[u32; 3]| {
        let [a, b, c] = f.map(|i| piece.vertices[i as usize]);
        let n = (b - a).cross(c - a).normalize();
        piece.vertices.iter().map(|v| n.dot(a - *v)).fold(0.0, f64::max)
    };
    piece.faces.iter().map(breadth).fold(f64::INFINITY, f64::min)
}

/// For each part, the first part it is fixed to.
fn rigid_groups(object: &ArticulatedObject) -> Vec<usize> {
    let tree = object.tree();
    let mut group: Vec<usize> = (0..tree.len()).collect();
    for &p in tree.root_first() {
        if let (Some(parent), true) = (tree.parent(p), object.joints(p).is_empty()) {
            group[p] = group[parent];
        }
    }
    group
}

fn steps(object: &ArticulatedObject, part: usize, joint: &JointMotion) -> usize {
    let arm = |v: &DVec3| {
        if joint.kind.turns() {
            (*v - joint.pivot).reject_from_normalized(joint.axis).length()
        } else {
            1.0
        }
    };
    let mesh = object.mesh();
    let points = object.faces_of(part).flat_map(|f| mesh.corners(f));
    let arm = points.map(|v| arm(&v)).fold(0.0, f64::max);
    let step = 0.002f64.max(0.002 * mesh.bounds().diagonal());
    ((arm * joint.range.span() / step).ceil() as usize).clamp(8, 600)
}

fn deepest(
    object: &ArticulatedObject,
    shapes: &[Vec<ConvexPolyhedron>],
    groups: &[usize],
    q: &Configuration,
) -> f64 {
    let poses = part_poses(object, q);
    let mut worst = 0.0f64;
    let boxes: Vec<Vec<_>> = shapes
        .iter()
        .zip(&poses)
        .map(|(s, pose)| {
            s.iter()
                .map(|s| {
                    parry3d_f64::bounding_volume::Aabb::from_points(
                        s.points().iter().map(|&p| *pose * p),
                    )
                })
                .collect()
        })
        .collect();
    for a in 0..shapes.len() {
        for b in a + 1..shapes.len() {
            if groups[a] == groups[b] {
                continue;
            }
            for (i, x) in shapes[a].iter().enumerate() {
                for (j, y) in shapes[b].iter().enumerate() {
                    use parry3d_f64::bounding_volume::BoundingVolume;
                    if boxes[a][i].intersects(&boxes[b][j])
                        && let Ok(Some(c)) = contact(&poses[a], x, &poses[b], y, 0.0)
                    {
                        worst = worst.max(-c.dist);
                    }
                }
            }
        }
    }
    worst
}

/// How much the gap between a hinge's part and its parent grows, over what is allowed.
fn growth(
    object: &ArticulatedObject,
    shapes: &[Vec<ConvexPolyhedron>],
    (part, k): (usize, usize),
    diagonal: f64,
) -> f64 {
    let motion = object.joints(part)[k];
    let Some(parent) = object.tree().parent(part).filter(|_| motion.kind.turns()) else {
        return 0.0;
    };
    let (low, high) = motion.range.ends();
    let gap = |q: f64| {
        let poses = [object::pose::joint_pose(&motion, q), DPose3::identity()];
        let mut least = f64::INFINITY;
        for x in &shapes[part] {
            for y in &shapes[parent] {
                least = least.min(
                    distance(&poses[0], x, &poses[1], y).map_or(f64::INFINITY, |d| d.distance),
                );
            }
        }
        least
    };
    let rest = gap(0.0);
    let most = (0..=12).map(|i| gap(low + (high - low) * f64::from(i) / 12.0)).fold(0.0, f64::max);
    (most - rest) / 0.003f64.max(0.003 * diagonal)
}

/// Two-sided cover, and cavities filled.
fn covers(links: &[Mesh], cleared: &Cleared, options: &ClearanceOptions, row: &mut Row) {
    let (mut filled, mut total) = (0.0, 0.0);
    for (link, pieces) in links.iter().zip(&cleared.pieces) {
        let mut unused = Row::default();
        let shapes: Vec<_> = pieces.iter().filter_map(|p| shape(p, &mut unused)).collect();
        let samples = sample_surface(link, 2_000, 77);
        let reach = |p: DVec3| {
            let all = shapes.iter().map(|s| s.distance_to_local_point(p, true));
            all.fold(f64::INFINITY, f64::min)
        };
        let distances: Vec<f64> = samples.iter().map(|s| reach(s.position)).collect();
        let worst = distances.iter().copied().fold(0.0, f64::max);
        row.cover = row.cover.max(worst / options.tolerance);
        let bare = distances.iter().filter(|d| **d > options.tolerance).count();
        row.bare = row.bare.max(bare as f64 / samples.len().max(1) as f64);
        let Ok(surface) = TriMesh::new(link.vertices().to_vec(), link.faces().to_vec()) else {
            continue;
        };
        for piece in pieces {
            let (volume, points) = inner_points(piece);
            let hollow = |p: &&DVec3| {
                surface.distance_to_local_point(**p, false) > options.tolerance
                    && winding(link, **p) < 0.5
            };
            filled += volume * points.iter().filter(hollow).count() as f64 / points.len() as f64;
            total += volume;
        }
    }
    row.filled = filled / total;
}

/// Volume and 40 points inside a piece.
fn inner_points(piece: &ConvexPiece) -> (f64, Vec<DVec3>) {
    let at = |i: u32| piece.vertices[i as usize];
    let centre = piece.vertices.iter().sum::<DVec3>() / piece.vertices.len() as f64;
    let volume =
        |f: &[u32; 3]| (at(f[0]) - centre).dot((at(f[1]) - centre).cross(at(f[2]) - centre)) / 6.0;
    let total: f64 = piece.faces.iter().map(volume).sum();
    let mut points = Vec::new();
    for i in 0..40 {
        let u = [0.8566, 0.7338, 0.6287, 0.5385].map(|a: f64| (0.5 + a * f64::from(i + 1)).fract());
        let mut left = u[0] * total;
        let pick = |f: &&[u32; 3]| {
            left -= volume(f);
            left <= 0.0
        };
        let Some(f) = piece.faces.iter().find(pick) else { continue };
        let s = u[2].sqrt();
        let base = at(f[0]) * (1.0 - s) + at(f[1]) * (s * (1.0 - u[3])) + at(f[2]) * (s * u[3]);
        points.push(centre + (base - centre) * u[1].cbrt());
    }
    (total, points)
}

fn winding(mesh: &Mesh, p: DVec3) -> f64 {
    let angle = |f: usize| {
        let [a, b, c] = mesh.corners(f).map(|v| v - p);
        let [la, lb, lc] = [a, b, c].map(DVec3::length);
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        a.dot(b.cross(c)).atan2(below)
    };
    (0..mesh.faces().len()).map(angle).sum::<f64>() / std::f64::consts::TAU
}

fn ranges(object: &ArticulatedObject, moved: &ArticulatedObject, row: &mut Row) {
    let mut lost = Vec::new();
    for p in 0..object.tree().len() {
        for (a, b) in object.joints(p).iter().zip(moved.joints(p)) {
            lost.push(1.0 - b.range.span() / a.range.span());
        }
    }
    row.lost_most = lost.iter().copied().fold(0.0, f64::max);
    row.lost = lost.iter().sum::<f64>() / lost.len().max(1) as f64;
}
