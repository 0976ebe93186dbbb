//! Cutting a surface into patches whose hulls fill no hollow: cut and hull, worst patch first.

use std::collections::HashMap;
use std::f64::consts::FRAC_1_SQRT_2;
use std::sync::atomic::{AtomicU64, Ordering};

use glamx::DVec3;
use object::mesh::Bounds;
use rayon::prelude::*;

use super::emptiness::Emptiness;
use crate::collision::quickhull::{GivenUp, Inside};
use crate::collision::solid::{MAX_CORNERS, Plane, Solid};

/// Most patches of one link before merging.
const MAX_CELLS: usize = 44;
/// Most patches a link is cut into while some hull lies too deep in a hollow.
const MAX_DEEP: usize = 150;
/// A hull may hold this share of hollow volume and still count as clean.
const CLEAN: f64 = 0.015;
/// Points thrown into a hull to find hollows.
const THROWN: usize = 300;
/// Triangles looked at when cuts are compared.
const LOOKED_AT: usize = 500;
/// The outermost plane is worth a cut if it holds this share of the surface.
const LID: f64 = 0.12;
/// Most corners of the hulls by which cuts are compared.
const ROUGH_CORNERS: usize = 32;
/// A cut with a score above this does no good.
const POOR: f64 = 1.99;
/// A cut with a score below this is taken without looking at others in its direction.
const GOOD: f64 = 0.03;

/// What a hull is held against.
#[derive(Clone, Copy)]
pub(crate) struct Gate<'a> {
    /// How empty the space around the link's surface is.
    pub(crate) empty: &'a Emptiness,
    /// A point outside the solid and farther than this from the surface is hollow, metres.
    pub(crate) clearance: f64,
    /// No place on a hull may lie deeper than this in hollow space, metres.
    pub(crate) deepest: f64,
    /// Places on a hull's sides that are looked at.
    pub(crate) looked_at: usize,
    /// Hulls are made at least this thick, metres.
    pub(crate) width: f64,
}

impl Gate<'_> {
    /// Points of the hull that are hollow, the volume they stand for beyond a sliver, and whether
    /// a place on the hull lies too deep.
    fn hollow(&self, solid: &Solid) -> (Vec<DVec3>, f64, bool) {
        let volume = solid.volume();
        let inside =
            spread(solid, THROWN).into_par_iter().with_min_len(50).filter(|&p| self.is_hollow(p));
        let mut hollow: Vec<DVec3> = inside.collect();
        let share = hollow.len() as f64 / THROWN as f64;
        let mut excess = if share > CLEAN { share * volume } else { 0.0 };
        let skin = skin(solid, self.looked_at)
            .into_par_iter()
            .with_min_len(50)
            .filter(|&p| self.is_deep(p));
        let deep: Vec<DVec3> = skin.collect();
        if !deep.is_empty() {
            excess = excess.max(deep.len() as f64 / self.looked_at as f64 * volume);
        }
        let is_deep = !deep.is_empty();
        hollow.extend(deep);
        (hollow, excess, is_deep)
    }

    fn is_hollow(&self, p: DVec3) -> bool {
        self.empty.is_empty(p, self.clearance)
    }

    fn is_deep(&self, p: DVec3) -> bool {
        self.empty.is_empty(p, self.deepest)
    }

    /// Whether no more than a sliver of the hull is hollow and no place on it too deep.
    pub(crate) fn passes(&self, solid: &Solid) -> bool {
        let allowed = (CLEAN * (THROWN / 2) as f64) as usize;
        !skin(solid, self.looked_at).into_par_iter().with_min_len(50).any(|p| self.is_deep(p))
            && spread(solid, THROWN / 2)
                .into_par_iter()
                .with_min_len(50)
                .filter(|&p| self.is_hollow(p))
                .count()
                <= allowed
    }
}

/// Corners of a convex body and `count` points spread evenly over its sides.
pub(crate) fn skin(solid: &Solid, count: usize) -> Vec<DVec3> {
    let mut fans: Vec<([DVec3; 3], f64)> = Vec::new();
    let mut total = 0.0;
    for facet in &solid.facets {
        let at = |i: u32| solid.vertices[i as usize];
        for w in facet.ring[1..].windows(2) {
            let t = [at(facet.ring[0]), at(w[0]), at(w[1])];
            total += area(&t);
            fans.push((t, total));
        }
    }
    let place = |i: usize| {
        // The R3 sequence: powers of the inverse of the root of x⁴ = x + 1.
        let u = [0.819_172_51, 0.671_043_61, 0.549_700_48]
            .map(|a: f64| (0.5 + a * (i + 1) as f64).fract());
        let fan = fans.partition_point(|(_, sum)| *sum <= u[0] * total).min(fans.len() - 1);
        let s = u[1].sqrt();
        let [a, b, c] = fans[fan].0;
        a * (1.0 - s) + b * (s * (1.0 - u[2])) + c * (s * u[2])
    };
    let count = if fans.is_empty() { 0 } else { count };
    solid.vertices.iter().copied().chain((0..count).map(place)).collect()
}

/// `count` points evenly through a convex body.
fn spread(solid: &Solid, count: usize) -> Vec<DVec3> {
    let apex = solid.centre();
    let mut wedges: Vec<([DVec3; 3], f64)> = Vec::new();
    let mut total = 0.0;
    for facet in &solid.facets {
        let at = |i: u32| solid.vertices[i as usize];
        for w in facet.ring[1..].windows(2) {
            let t = [at(facet.ring[0]), at(w[0]), at(w[1])];
            total += ((t[0] - apex).cross(t[1] - apex).dot(t[2] - apex) / 6.0).abs();
            wedges.push((t, total));
        }
    }
    let place = |i: usize| {
        // The R4 sequence: powers of the inverse of the root of x⁵ = x + 1.
        let u = [0.856_674_88, 0.733_891_86, 0.628_706_7, 0.538_597_3]
            .map(|a| (0.5 + a * (i + 1) as f64).fract());
        let wedge = wedges.partition_point(|(_, sum)| *sum <= u[0] * total).min(wedges.len() - 1);
        let (r, s) = (u[1].cbrt(), u[2].sqrt());
        let [a, b, c] = wedges[wedge].0;
        let base = a * (1.0 - s) + b * (s * (1.0 - u[3])) + c * (s * u[3]);
        apex + (base - apex) * r
    };
    if wedges.is_empty() { Vec::new() } else { (0..count).map(place).collect() }
}

/// A patch of surface and its hull.
struct Cell {
    triangles: Vec<[DVec3; 3]>,
    /// `None` if the patch has no area to speak of.
    solid: Option<Solid>,
    /// Hollow points of the hull.
    hollow: Vec<DVec3>,
    /// Volume they stand for; 0 once the cell needs no more cutting.
    excess: f64,
    /// Whether a place on the hull lies too deep in hollow space.
    deep: bool,
}

impl Cell {
    fn new(triangles: Vec<[DVec3; 3]>, gate: &Gate) -> Self {
        let solid = thick(&triangles, gate.width, 0.1 * gate.clearance);
        let mut cell = Self { triangles, solid, hollow: Vec::new(), excess: 0.0, deep: false };
        if let Some(solid) = &cell.solid
            && solid.bounds.diagonal() > 2.0 * gate.clearance
        {
            (cell.hollow, cell.excess, cell.deep) = gate.hollow(solid);
        }
        cell
    }

    /// No more is to be cut off it.
    fn leave(&mut self) {
        self.excess = 0.0;
    }
}

/// The hull of a patch, at least `width` metres thick; `None` if the patch has no area to speak of.
pub(crate) fn thick(patch: &[[DVec3; 3]], width: f64, error: f64) -> Option<Solid> {
    let vectors = patch.iter().map(|t| (t[1] - t[0]).cross(t[2] - t[0]));
    let facing: DVec3 = vectors.clone().sum();
    let one_sided = facing.length() > 0.3 * vectors.map(DVec3::length).sum::<f64>();
    let mut points: Vec<_> = patch.iter().flatten().copied().collect();
    let error = error.min(0.1 * width);
    for round in 0..4 {
        let hull = Solid::of(&points, MAX_CORNERS, error);
        let (thin, breadth) = match &hull {
            Some(solid) => solid.narrowest(),
            None => (largest_normal(patch)?, 0.0),
        };
        if breadth >= width {
            return hull;
        }
        let missing = 1.15 * width - breadth;
        let inward = if facing.dot(thin) > 0.0 { -thin } else { thin };
        let front = if one_sided && round == 0 { 0.0 } else { missing / 2.0 };
        let back = missing - front;
        let moved = points.iter().flat_map(|&p| [p + inward * back, p - inward * front]);
        points = moved.collect();
    }
    None
}

fn largest_normal(patch: &[[DVec3; 3]]) -> Option<DVec3> {
    let vectors = patch.iter().map(|t| (t[1] - t[0]).cross(t[2] - t[0]));
    let largest = vectors.fold(DVec3::ZERO, |a, b| if b.length() > a.length() { b } else { a });
    largest.try_normalize()
}

/// Cuts the components of a surface into patches whose hulls are clean as far as [`MAX_CELLS`]
/// and [`MAX_DEEP`] allow, and gives the hulls.
pub(crate) fn split(components: Vec<Vec<[DVec3; 3]>>, gate: &Gate) -> Vec<Solid> {
    let limit = components.len().max(8) + MAX_CELLS;
    let deep_limit = components.len() + MAX_DEEP;
    let mut cells: Vec<Cell> = components.into_par_iter().map(|c| Cell::new(c, gate)).collect();
    let rank = |c: &Cell| (c.excess > 0.0 && c.deep, c.excess);
    while let Some(worst) = (0..cells.len()).max_by(|&a, &b| {
        let (a, b) = (rank(&cells[a]), rank(&cells[b]));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    }) {
        let (deep, excess) = rank(&cells[worst]);
        if excess <= 0.0 || cells.len() >= if deep { deep_limit } else { limit } {
            break;
        }
        match best_cut(&cells[worst], gate) {
            Some((normal, offset)) => {
                let cell = cells.swap_remove(worst);
                let (below, above) = cut_all(&cell.triangles, normal, offset);
                let halves = rayon::join(|| Cell::new(below, gate), || Cell::new(above, gate));
                let mut halves = [halves.0, halves.1];
                if halves.iter().any(|h| h.solid.is_none()) {
                    // Nothing but a sliver came off: more of the same would not end.
                    halves.iter_mut().filter(|h| h.excess >= cell.excess).for_each(Cell::leave);
                }
                cells.extend(halves);
            }
            None => cells[worst].leave(),
        }
    }
    cells.into_iter().filter_map(|c| c.solid).collect()
}

/// How roughly hulls are made while cuts are compared.
#[derive(Clone, Copy, Debug)]
struct Rough {
    /// Points may lie so far outside, metres.
    error: f64,
    /// A flat patch is made about this thick, metres.
    width: f64,
}

/// The plane (normal, offset) after which least surface hangs on unclean hulls and least hollow
/// is left; a lid is taken off only where no other plane does any good. `None` if none does any.
fn best_cut(cell: &Cell, gate: &Gate) -> Option<(DVec3, f64)> {
    let stride = cell.triangles.len().div_ceil(LOOKED_AT);
    let looked_at = Sketch::new(cell.triangles.iter().step_by(stride).copied().collect());
    let rough = Rough { error: 0.3 * gate.clearance, width: gate.width };
    let across = best_of(cell, &looked_at, rough, offsets);
    let good = |cut: &(f64, DVec3, f64)| cut.0 < POOR;
    let lid = || best_of(cell, &looked_at, rough, lids).filter(good);
    across.filter(good).or_else(lid).map(|(_, normal, offset)| (normal, offset))
}

/// The cut of least score, with its score, among those that `offsets` gives in any direction.
fn best_of(
    cell: &Cell,
    looked_at: &Sketch,
    rough: Rough,
    offsets: fn(&[[DVec3; 3]], &Solid, DVec3) -> Vec<f64>,
) -> Option<(f64, DVec3, f64)> {
    let solid = cell.solid.as_ref()?;
    // Scores are 0 or more: as bits they are in order. What is sure to be worse than the best so
    // far, wherever that was found, need not be known to the end.
    let least = AtomicU64::new(f64::INFINITY.to_bits());
    let along = |normal: DVec3| {
        let heights = looked_at.heights(normal);
        let mut best: Option<(f64, DVec3, f64)> = None;
        for offset in offsets(&looked_at.triangles, solid, normal) {
            let enough = f64::from_bits(least.load(Ordering::Relaxed)).max(GOOD);
            let score = score(cell, looked_at, rough, (&heights, offset, enough));
            least.fetch_min(score.to_bits(), Ordering::Relaxed);
            if best.is_none_or(|b| score < b.0) {
                best = Some((score, normal, offset));
            }
            if score < GOOD {
                break;
            }
        }
        best
    };
    let each: Vec<_> = directions(&looked_at.triangles).into_par_iter().filter_map(along).collect();
    each.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Share of surface on unclean hulls plus share of hollow points left: 2 for a cut that does
/// nothing, 0 for one that leaves two clean sides; infinite where it is above `enough`.
fn score(
    cell: &Cell,
    looked_at: &Sketch,
    rough: Rough,
    (heights, offset, enough): (&[f64], f64, f64),
) -> f64 {
    let sides = [1.0, -1.0].map(|sign| looked_at.side(heights, (sign, offset)));
    if sides.iter().any(|(points, _)| points.is_empty()) {
        return 2.0;
    }
    let total = looked_at.areas.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    // What so many hollow points left on one side count, and the surface there if that is unclean.
    let shares = |left: usize, part: f64| {
        let is_unclean = left * 50 > cell.hollow.len();
        let share = left as f64 / cell.hollow.len().max(1) as f64;
        [share, if is_unclean { part / total } else { 0.0 }]
    };
    let sum_of = |found: [[f64; 2]; 2]| found.iter().flatten().fold(0.0, |sum, share| sum + share);
    // The larger side is asked first: it alone may say that there is too much.
    let first = usize::from(sides[0].1 < sides[1].1);
    let mut found = [[0.0; 2]; 2];
    let mut sides = sides.map(Some);
    for side in [first, 1 - first] {
        let Some((points, part)) = sides[side].take() else { continue };
        let with = |left: usize| {
            let mut all = found;
            all[side] = shares(left, part);
            sum_of(all)
        };
        let count =
            |is_held: &dyn Fn(DVec3) -> bool| cell.hollow.iter().filter(|p| is_held(**p)).count();
        let is_enough = |inside: &Inside| with(count(&|p| inside.holds(p))) > enough;
        let Ok(hull) = hull_or_slab(points, rough, is_enough) else { return f64::INFINITY };
        let Some(hull) = hull else { continue };
        let holds = |p: DVec3| hull.iter().all(|(normal, offset)| normal.dot(p) <= *offset);
        found[side] = shares(count(&holds), part);
        if sum_of(found) > enough {
            return f64::INFINITY;
        }
    }
    sum_of(found)
}

/// The sides of the rough hull of some points, with a little thickness if they are flat; given up
/// where a body well inside it is enough.
fn hull_or_slab(
    mut points: Vec<DVec3>,
    Rough { error, width }: Rough,
    is_enough: impl Fn(&Inside) -> bool,
) -> Result<Option<Vec<Plane>>, GivenUp> {
    let hull = Solid::planes_unless(&points, (ROUGH_CORNERS, error), is_enough)?;
    if hull.is_some() {
        return Ok(hull);
    }
    let Some(lift) = lift(&points) else { return Ok(None) };
    let lift = lift * (0.5 * width);
    points = points.iter().flat_map(|&p| [p + lift, p - lift]).collect();
    Solid::planes_unless(&points, (ROUGH_CORNERS, error.min(0.1 * width)), |_| false)
}

/// The direction across the plane in which points lie.
fn lift(points: &[DVec3]) -> Option<DVec3> {
    let first = *points.first()?;
    let far = |from: DVec3| {
        points
            .iter()
            .copied()
            .max_by(|a, b| from.distance_squared(*a).total_cmp(&from.distance_squared(*b)))
    };
    let along = far(first)? - first;
    let across = points.iter().map(|p| along.cross(*p - first));
    let across = across.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
    across.try_normalize()
}

/// The triangles by which cuts are compared, and each of their corners once.
struct Sketch {
    triangles: Vec<[DVec3; 3]>,
    areas: Vec<f64>,
    corners: Vec<[u32; 3]>,
    points: Vec<DVec3>,
}

impl Sketch {
    fn new(triangles: Vec<[DVec3; 3]>) -> Self {
        let (mut known, mut points) = (HashMap::new(), Vec::new());
        let mut number = |p: DVec3| {
            *known.entry(p.to_array().map(f64::to_bits)).or_insert_with(|| {
                points.push(p);
                points.len() as u32 - 1
            })
        };
        let corners = triangles.iter().map(|t| t.map(&mut number)).collect();
        let areas = triangles.iter().map(area).collect();
        Self { triangles, areas, corners, points }
    }

    /// How high each point lies along a direction.
    fn heights(&self, normal: DVec3) -> Vec<f64> {
        self.points.iter().map(|p| normal.dot(*p)).collect()
    }

    /// Corners of what lies below a plane across a direction, or with −1 above it, crossings included,
    /// and its area as centroids have it.
    fn side(&self, heights: &[f64], (sign, offset): (f64, f64)) -> (Vec<DVec3>, f64) {
        let height = |i: u32| sign * (heights[i as usize] - offset);
        let all = self.points.iter().zip(heights);
        let below = all.filter(|(_, h)| sign * (*h - offset) <= 0.0);
        let mut points: Vec<DVec3> = Vec::with_capacity(2 * self.points.len());
        points.extend(below.map(|(p, _)| *p));
        let mut sum = 0.0;
        for (corners, area) in self.corners.iter().zip(&self.areas) {
            let h = corners.map(height);
            if h.iter().sum::<f64>() <= 0.0 {
                sum += area;
            }
            for (i, j) in [(0, 1), (1, 2), (2, 0)] {
                if h[i] * h[j] < 0.0 {
                    let [p, q] = [i, j].map(|k| self.points[corners[k] as usize]);
                    points.push(p + (q - p) * (h[i] / (h[i] - h[j])));
                }
            }
        }
        (points, sum)
    }
}

fn area(t: &[DVec3; 3]) -> f64 {
    (t[1] - t[0]).cross(t[2] - t[0]).length() / 2.0
}

/// The axes of the frame, those half way between them, and what most flat surface faces.
fn directions(triangles: &[[DVec3; 3]]) -> Vec<DVec3> {
    let mut flats: Vec<(f64, DVec3)> = Vec::new();
    for t in triangles {
        let vector = (t[1] - t[0]).cross(t[2] - t[0]);
        let Some(n) = vector.try_normalize() else { continue };
        match flats.iter().position(|(_, m)| m.dot(n).abs() > 0.999) {
            Some(at) => flats[at].0 += vector.length(),
            None if flats.len() < 200 => flats.push((vector.length(), n)),
            None => {}
        }
    }
    flats.sort_by(|a, b| b.0.total_cmp(&a.0));
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z];
    let slant = [x + y, x - y, y + z, y - z, z + x, z - x].map(|n| n * FRAC_1_SQRT_2);
    let mut found = vec![x, y, z];
    found.extend(slant);
    for (_, n) in flats {
        if found.len() < 12 && found.iter().all(|m| m.dot(n).abs() < 0.98) {
            found.push(n);
        }
    }
    found
}

/// Offsets worth trying along a direction: the planes most surface lies in, and an even few.
fn offsets(triangles: &[[DVec3; 3]], solid: &Solid, normal: DVec3) -> Vec<f64> {
    let (low, high) = (-solid.support(-normal), solid.support(normal));
    let margin = 0.01 * (high - low);
    let mut planes: Vec<(f64, f64)> = Vec::new();
    for t in triangles {
        let at = normal.dot(t[0] + t[1] + t[2]) / 3.0;
        if at > low + margin && at < high - margin && is_level(t, normal) {
            match planes.iter_mut().find(|(_, p)| (p - at).abs() < 0.1 * margin) {
                Some(plane) => plane.0 += area(t),
                None => planes.push((area(t), at)),
            }
        }
    }
    planes.sort_by(|a, b| b.0.total_cmp(&a.0));
    let even = (1..6).map(|i| low + (high - low) * f64::from(i) / 6.0);
    planes.iter().take(5).map(|p| p.1).chain(even).collect()
}

/// Offsets just within the ends where a flat side lies: a cut there takes off a lid.
fn lids(triangles: &[[DVec3; 3]], solid: &Solid, normal: DVec3) -> Vec<f64> {
    let (low, high) = (-solid.support(-normal), solid.support(normal));
    let margin = 0.01 * (high - low);
    let total: f64 = triangles.iter().map(area).sum();
    let is_lid = |end: f64| {
        let lies_there = |t: &&[DVec3; 3]| t.iter().all(|v| (normal.dot(*v) - end).abs() < margin);
        let lid: f64 = triangles.iter().filter(lies_there).map(area).sum();
        lid > LID * total
    };
    let ends = [(low, low + 0.1 * margin), (high, high - 0.1 * margin)];
    ends.into_iter().filter(|(end, _)| is_lid(*end)).map(|(_, offset)| offset).collect()
}

/// Whether a triangle lies across a direction.
fn is_level(t: &[DVec3; 3], normal: DVec3) -> bool {
    let vector = (t[1] - t[0]).cross(t[2] - t[0]);
    vector.dot(normal).abs() > 0.995 * vector.length()
}

type Patch = Vec<[DVec3; 3]>;

/// The triangles below and above a plane; those across it are cut, those in it go to the side
/// their back faces, where the solid is.
fn cut_all(triangles: &[[DVec3; 3]], normal: DVec3, offset: f64) -> (Patch, Patch) {
    let size = Bounds::of(triangles.iter().flatten().copied()).diagonal();
    let (mut below, mut above) = (Vec::new(), Vec::new());
    for t in triangles {
        let h =
            t.map(|v| normal.dot(v) - offset).map(|h| if h.abs() < 1e-7 * size { 0.0 } else { h });
        if h == [0.0; 3] {
            let facing = (t[1] - t[0]).cross(t[2] - t[0]).dot(normal);
            if facing > 0.0 { below.push(*t) } else { above.push(*t) }
        } else if h.iter().all(|&h| h <= 0.0) {
            below.push(*t);
        } else if h.iter().all(|&h| h >= 0.0) {
            above.push(*t);
        } else {
            fan(t, h, &mut below);
            fan(t, h.map(|h| -h), &mut above);
        }
    }
    (below, above)
}

/// Adds the part of a triangle of height ≤ 0 as triangles.
fn fan(t: &[DVec3; 3], h: [f64; 3], into: &mut Patch) {
    let mut ring = Vec::with_capacity(4);
    for i in 0..3 {
        let j = (i + 1) % 3;
        if h[i] <= 0.0 {
            ring.push(t[i]);
        }
        if h[i] * h[j] < 0.0 {
            ring.push(t[i] + (t[j] - t[i]) * (h[i] / (h[i] - h[j])));
        }
    }
    into.extend((2..ring.len()).map(|k| [ring[0], ring[k - 1], ring[k]]));
}
