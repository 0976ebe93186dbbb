//! Cutting a surface into patches whose hulls fill no hollow: cut and hull, worst patch first.

use glamx::DVec3;
use object::mesh::Bounds;

use super::emptiness::Emptiness;
use super::solid::{MAX_CORNERS, Solid};

/// Most patches of one link before merging.
const MAX_CELLS: usize = 44;
/// A hull may hold this share of hollow volume and still count as clean.
const CLEAN: f64 = 0.015;
/// Points thrown into a hull to find hollows.
const THROWN: usize = 300;
/// Triangles looked at when cuts are compared.
const LOOKED_AT: usize = 700;

/// What a hull is held against.
#[derive(Clone, Copy)]
pub(crate) struct Gate<'a> {
    /// How empty the space around the link's surface is.
    pub(crate) empty: &'a Emptiness<'a>,
    /// A point outside the solid and farther than this from the surface is hollow, metres.
    pub(crate) clearance: f64,
}

impl Gate<'_> {
    /// Points of the hull that are hollow, out of `count` spread evenly, and the volume of each.
    fn hollow(&self, solid: &Solid, count: usize) -> (Vec<DVec3>, f64) {
        let (points, share) = spread(solid, count);
        (points.into_iter().filter(|&p| self.is_hollow(p)).collect(), share)
    }

    fn is_hollow(&self, p: DVec3) -> bool {
        self.empty.depth(p) >= self.clearance
    }

    /// Whether no more than a sliver of the hull is hollow.
    pub(crate) fn passes(&self, solid: &Solid) -> bool {
        let (points, share) = spread(solid, THROWN / 2);
        let allowed = (CLEAN * solid.volume() / share) as usize;
        points.into_iter().filter(|&p| self.is_hollow(p)).nth(allowed).is_none()
    }
}

/// `count` points evenly through a convex body, and the volume each stands for.
fn spread(solid: &Solid, count: usize) -> (Vec<DVec3>, f64) {
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
    let points = if wedges.is_empty() { Vec::new() } else { (0..count).map(place).collect() };
    (points, total / count as f64)
}

/// A patch of surface and its hull.
struct Cell {
    triangles: Vec<[DVec3; 3]>,
    /// `None` if the patch is flat.
    solid: Option<Solid>,
    /// Hollow points of the hull.
    hollow: Vec<DVec3>,
    /// Volume they stand for; 0 once the cell needs no more cutting.
    excess: f64,
}

impl Cell {
    fn new(triangles: Vec<[DVec3; 3]>, gate: &Gate) -> Self {
        let points: Vec<_> = triangles.iter().flatten().copied().collect();
        let solid = Solid::of(&points, MAX_CORNERS, 0.1 * gate.clearance);
        let mut cell = Self { triangles, solid, hollow: Vec::new(), excess: 0.0 };
        if let Some(solid) = &cell.solid
            && solid.bounds.diagonal() > 2.0 * gate.clearance
            && !cell.is_its_hull(solid)
        {
            let (hollow, share) = gate.hollow(solid, THROWN);
            let excess = hollow.len() as f64 * share;
            if excess > CLEAN * solid.volume() {
                (cell.hollow, cell.excess) = (hollow, excess);
            }
        }
        cell
    }

    /// Whether the patch encloses as much as its hull: closed and convex, no need to look closer.
    fn is_its_hull(&self, solid: &Solid) -> bool {
        let origin = solid.centre();
        let cone = |t: &[DVec3; 3]| (t[0] - origin).dot((t[1] - origin).cross(t[2] - origin)) / 6.0;
        let cones: Vec<f64> = self.triangles.iter().map(cone).collect();
        let (sum, size) = (cones.iter().sum::<f64>(), cones.iter().map(|c| c.abs()).sum::<f64>());
        let hull = solid.volume();
        (sum - hull).abs() < 0.02 * hull && size < 1.02 * hull
    }
}

/// Cuts the components of a surface into patches whose hulls are clean as far as [`MAX_CELLS`]
/// allows; each patch is the points of its triangles' corners.
pub(crate) fn split(components: Vec<Vec<[DVec3; 3]>>, gate: &Gate) -> Vec<Vec<[DVec3; 3]>> {
    let limit = components.len().max(8) + MAX_CELLS;
    let mut cells: Vec<Cell> = components.into_iter().map(|c| Cell::new(c, gate)).collect();
    while cells.len() < limit {
        let excesses = cells.iter().map(|c| c.excess).enumerate();
        let (worst, excess) = excesses.fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
        if excess <= 0.0 {
            break;
        }
        match best_cut(&cells[worst], gate) {
            Some((normal, offset)) => {
                let cell = cells.swap_remove(worst);
                let (below, above) = cut_all(&cell.triangles, normal, offset);
                cells.extend([below, above].map(|t| Cell::new(t, gate)));
            }
            None => cells[worst].excess = 0.0,
        }
    }
    cells.into_iter().map(|c| c.triangles).collect()
}

/// The plane (normal, offset) after which least surface hangs on unclean hulls and least hollow
/// is left; `None` if no plane does any good.
fn best_cut(cell: &Cell, gate: &Gate) -> Option<(DVec3, f64)> {
    let solid = cell.solid.as_ref()?;
    let stride = cell.triangles.len().div_ceil(LOOKED_AT);
    let looked_at: Vec<_> = cell.triangles.iter().step_by(stride).copied().collect();
    let mut best: Option<(f64, DVec3, f64)> = None;
    for normal in directions(&looked_at) {
        for offset in offsets(&looked_at, solid, normal) {
            let score = score(cell, &looked_at, gate, (normal, offset));
            if best.is_none_or(|b| score < b.0) {
                best = Some((score, normal, offset));
            }
        }
    }
    best.filter(|b| b.0 < 1.99).map(|(_, normal, offset)| (normal, offset))
}

/// Share of surface on unclean hulls plus share of hollow points left: 2 for a cut that does
/// nothing, 0 for one that leaves two clean sides.
fn score(cell: &Cell, looked_at: &[[DVec3; 3]], gate: &Gate, plane: (DVec3, f64)) -> f64 {
    let (normal, offset) = plane;
    let total: f64 = looked_at.iter().map(area).sum();
    let mut sum = 0.0;
    for sign in [1.0, -1.0] {
        let (points, part) = side(looked_at, normal * sign, offset * sign);
        if points.is_empty() {
            return 2.0;
        }
        let Some(hull) = Solid::of(&points, 32, 0.3 * gate.clearance) else { continue };
        let left = cell.hollow.iter().filter(|&&p| hull.holds(p, 0.0)).count();
        sum += left as f64 / cell.hollow.len().max(1) as f64;
        if left * 50 > cell.hollow.len() {
            sum += part / total.max(f64::MIN_POSITIVE);
        }
    }
    sum
}

/// Corners of what lies below a plane, crossings included, and its area as centroids have it.
fn side(triangles: &[[DVec3; 3]], normal: DVec3, offset: f64) -> (Vec<DVec3>, f64) {
    let (mut points, mut sum) = (Vec::new(), 0.0);
    for t in triangles {
        let h = t.map(|v| normal.dot(v) - offset);
        if h.iter().sum::<f64>() <= 0.0 {
            sum += area(t);
        }
        for i in 0..3 {
            let j = (i + 1) % 3;
            if h[i] <= 0.0 {
                points.push(t[i]);
            }
            if h[i] * h[j] < 0.0 {
                points.push(t[i] + (t[j] - t[i]) * (h[i] / (h[i] - h[j])));
            }
        }
    }
    (points, sum)
}

fn area(t: &[DVec3; 3]) -> f64 {
    (t[1] - t[0]).cross(t[2] - t[0]).length() / 2.0
}

/// The axes of the frame and the directions most flat surface faces.
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
    let mut found = vec![DVec3::X, DVec3::Y, DVec3::Z];
    for (_, n) in flats {
        if found.len() < 6 && found.iter().all(|m| m.dot(n).abs() < 0.98) {
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
        let vector = (t[1] - t[0]).cross(t[2] - t[0]);
        let at = normal.dot(t[0] + t[1] + t[2]) / 3.0;
        let within = at > low + margin && at < high - margin;
        if within && vector.dot(normal).abs() > 0.995 * vector.length() {
            match planes.iter_mut().find(|(_, p)| (p - at).abs() < 0.1 * margin) {
                Some(plane) => plane.0 += vector.length(),
                None => planes.push((vector.length(), at)),
            }
        }
    }
    planes.sort_by(|a, b| b.0.total_cmp(&a.0));
    let even = (1..6).map(|i| low + (high - low) * f64::from(i) / 6.0);
    planes.iter().take(5).map(|p| p.1).chain(even).collect()
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
