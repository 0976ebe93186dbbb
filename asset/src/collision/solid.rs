//! A convex polyhedron that can be cut: corners, flat sides, and the distances between them.

use glamx::DVec3;
use object::mesh::Bounds;
use object::weld::nearest_on_triangle;

use super::piece::ConvexPiece;
use super::quickhull::{GivenUp, Hull, Inside, hull, hull_unless};

/// Most corners a working polyhedron keeps; a piece may have [`super::piece::MAX_VERTICES`].
pub(crate) const MAX_CORNERS: usize = 60;

/// Corners this close to a side's plane lie on it, as a share of the diagonal.
const LEVEL: f64 = 4e-6;

/// One flat side: its outward unit normal n, its offset (n · x of its points) and its corners,
/// counter-clockwise seen from outside.
#[derive(Clone, Debug)]
pub(crate) struct Facet {
    pub(crate) normal: DVec3,
    pub(crate) offset: f64,
    pub(crate) ring: Vec<u32>,
}

/// A convex polyhedron, object frame, metres.
#[derive(Clone, Debug)]
pub(crate) struct Solid {
    pub(crate) vertices: Vec<DVec3>,
    pub(crate) facets: Vec<Facet>,
    pub(crate) bounds: Bounds,
}

impl Solid {
    /// The hull of some points, from inside: at most `limit` corners, points up to `error` outside.
    /// `None` if they are flat.
    pub(crate) fn of(points: &[DVec3], limit: usize, error: f64) -> Option<Self> {
        let Shell { vertices, planes, bounds } = Shell::of(&hull(points, limit, error)?)?;
        let side = |((normal, offset), ring): (Plane, Vec<u32>)| Facet {
            normal,
            offset,
            ring: around(&vertices, ring, normal),
        };
        let facets = planes.into_iter().map(side).collect();
        Some(Self { vertices, facets, bounds })
    }

    /// The planes of the sides of what [`Solid::of`] makes of the same, which is told sooner; given up
    /// where a body well inside it is enough.
    pub(crate) fn planes_unless(
        points: &[DVec3],
        grown: (usize, f64),
        is_enough: impl FnMut(&Inside) -> bool,
    ) -> Result<Option<Vec<Plane>>, GivenUp> {
        let shell = hull_unless(points, grown, is_enough)?.and_then(|hull| Shell::of(&hull));
        Ok(shell.map(|shell| shell.planes.into_iter().map(|(plane, _)| plane).collect()))
    }

    /// The part where `normal` · x ≤ `offset`; `None` if nothing, or nothing thick, is left.
    pub(crate) fn below(&self, normal: DVec3, offset: f64) -> Option<Self> {
        let snap = 1e-9 * self.bounds.diagonal();
        let height = |v: &DVec3| {
            let h = normal.dot(*v) - offset;
            if h.abs() < snap { 0.0 } else { h }
        };
        let heights: Vec<f64> = self.vertices.iter().map(height).collect();
        if heights.iter().all(|&h| h <= 0.0) {
            return Some(self.clone());
        }
        if heights.iter().all(|&h| h >= 0.0) {
            return None;
        }
        let mut cut = Cut::new(self, &heights);
        let facets = self.facets.iter().filter_map(|f| cut.facet(f)).collect::<Vec<_>>();
        cut.close(facets, normal, offset).limited()
    }

    fn limited(self) -> Option<Self> {
        if self.facets.len() < 4 || self.vertices.len() < 4 {
            return None;
        }
        if self.vertices.len() > MAX_CORNERS {
            Self::of(&self.vertices, MAX_CORNERS, 0.0)
        } else {
            Some(self)
        }
    }

    /// Enclosed volume, m³.
    pub(crate) fn volume(&self) -> f64 {
        let apex = self.vertices[0];
        let pyramid = |f: &Facet| self.area(f) * (f.offset - f.normal.dot(apex)) / 3.0;
        self.facets.iter().map(pyramid).sum()
    }

    /// Area of one side, m².
    pub(crate) fn area(&self, facet: &Facet) -> f64 {
        let at = |i: &u32| self.vertices[*i as usize];
        let Some(first) = facet.ring.first().map(at) else { return 0.0 };
        let fan = facet.ring.windows(2).map(|w| (at(&w[0]) - first).cross(at(&w[1]) - first));
        fan.sum::<DVec3>().dot(facet.normal) / 2.0
    }

    /// Largest `direction` · x over the corners.
    pub(crate) fn support(&self, direction: DVec3) -> f64 {
        support(&self.vertices, direction)
    }

    /// The side seen along which the body is thinnest, and its breadth there, metres.
    pub(crate) fn narrowest(&self) -> (DVec3, f64) {
        let breadth = |f: &Facet| (f.normal, f.offset + self.support(-f.normal));
        let all = self.facets.iter().map(breadth);
        all.fold((DVec3::Z, f64::INFINITY), |a, b| if b.1 < a.1 { b } else { a })
    }

    /// Smallest breadth over the directions of its sides, metres.
    pub(crate) fn width(&self) -> f64 {
        self.narrowest().1
    }

    /// Mean of the corners; inside.
    pub(crate) fn centre(&self) -> DVec3 {
        self.vertices.iter().sum::<DVec3>() / self.vertices.len() as f64
    }

    /// Whether a point lies inside by more than `depth` metres.
    pub(crate) fn holds(&self, p: DVec3, depth: f64) -> bool {
        self.facets.iter().all(|f| f.normal.dot(p) <= f.offset - depth)
    }

    /// Whether a body lies inside this one or no farther than `depth` metres from it.
    pub(crate) fn is_around(&self, small: &Self, depth: f64) -> bool {
        let near = self.bounds.grown(depth);
        near.min.cmple(small.bounds.min).all()
            && near.max.cmpge(small.bounds.max).all()
            && small.vertices.iter().all(|&v| self.distance(v, depth) <= depth)
    }

    /// Distance from a point, 0 inside; some value above `beyond` where it is farther than that.
    pub(crate) fn distance(&self, p: DVec3, beyond: f64) -> f64 {
        let height = |f: &Facet| f.normal.dot(p) - f.offset;
        let mut highest: Option<(f64, &Facet)> = None;
        for facet in &self.facets {
            let height = height(facet);
            if highest.is_none_or(|(most, _)| height > most) {
                highest = Some((height, facet));
            }
        }
        let Some((most, facet)) = highest else { return f64::INFINITY };
        if most <= 0.0 {
            return 0.0;
        }
        if most > beyond {
            return most;
        }
        // No side is nearer than the plane of this one.
        let straight = self.distance_to(facet, p);
        if straight <= most * (1.0 + 1e-12) {
            return straight;
        }
        let facing = self.facets.iter().filter(|f| height(f) > 0.0);
        facing.map(|f| self.distance_to(f, p)).fold(straight, f64::min)
    }

    fn distance_to(&self, facet: &Facet, p: DVec3) -> f64 {
        let at = |i: &u32| self.vertices[*i as usize];
        let Some(first) = facet.ring.first().map(at) else { return f64::INFINITY };
        let fan = facet.ring[1..].windows(2).map(|w| [first, at(&w[0]), at(&w[1])]);
        fan.map(|t| nearest_on_triangle(p, t).distance(p)).fold(f64::INFINITY, f64::min)
    }

    /// The smallest hull around two, from inside.
    pub(crate) fn around_both(&self, other: &Self) -> Option<Self> {
        let both: Vec<_> = self.vertices.iter().chain(&other.vertices).copied().collect();
        Self::of(&both, MAX_CORNERS, 0.0)
    }

    /// The finished piece: corners that matter only, triangulated. `None` if it is flat.
    pub(crate) fn to_piece(&self) -> Option<ConvexPiece> {
        let error = 1e-5 * self.bounds.diagonal();
        let found = hull(&self.vertices, MAX_CORNERS, error)?;
        Some(ConvexPiece { vertices: found.vertices, faces: found.faces })
    }
}

/// Outward unit normal and offset (n · x of its points) of a side.
pub(crate) type Plane = (DVec3, f64);

/// The corners and sides of a hull before the corners of a side stand in order.
struct Shell {
    vertices: Vec<DVec3>,
    /// Each side with its corners.
    planes: Vec<(Plane, Vec<u32>)>,
    bounds: Bounds,
}

impl Shell {
    /// `None` if it is flat.
    fn of(hull: &Hull) -> Option<Self> {
        let bounds = Bounds::of(hull.vertices.iter().copied());
        let level = LEVEL * bounds.diagonal();
        let (planes, on) = planes(hull, level);
        let mut sides = vec![0_u32; hull.vertices.len()];
        for row in on.chunks(sides.len().max(1)) {
            sides.iter_mut().zip(row).for_each(|(sides, is_on)| *sides += u32::from(*is_on));
        }
        // A corner is where three sides meet.
        let mut vertices = Vec::with_capacity(sides.len());
        let mut number = |(v, sides): (&DVec3, &u32)| {
            let is_corner = *sides > 2;
            is_corner.then(|| {
                vertices.push(*v);
                vertices.len() as u32 - 1
            })
        };
        let numbers: Vec<Option<u32>> = hull.vertices.iter().zip(&sides).map(&mut number).collect();
        let rows = on.chunks(numbers.len().max(1));
        let ring = |(plane, row): (Plane, &[bool])| {
            let ring = numbers.iter().zip(row).filter(|(_, on)| **on).filter_map(|(i, _)| *i);
            let ring: Vec<u32> = ring.collect();
            (ring.len() > 2).then_some((plane, ring))
        };
        let planes: Vec<_> = planes.into_iter().zip(rows).filter_map(ring).collect();
        (vertices.len() > 3 && planes.len() > 3).then_some(Self { vertices, planes, bounds })
    }
}

/// Normal and offset of each flat side of a hull, and for each of them and each corner whether that lies
/// on it: triangles, largest first, join a side found before if their corners are level with it.
fn planes(hull: &Hull, level: f64) -> (Vec<Plane>, Vec<bool>) {
    let corners = |f: &[u32; 3]| f.map(|i| hull.vertices[i as usize]);
    let vector = |f: &[u32; 3]| {
        let [a, b, c] = corners(f);
        (b - a).cross(c - a)
    };
    let faces = hull.faces.iter().map(|f| (vector(f), corners(f)));
    let mut faces: Vec<_> = faces.map(|(v, corners)| (v.length_squared(), v, corners)).collect();
    faces.sort_by(|a, b| b.0.total_cmp(&a.0));
    let columns = Columns::new(&hull.vertices);
    let mut heights = vec![0.0; hull.vertices.len()];
    let mut planes: Vec<Plane> = Vec::with_capacity(faces.len());
    let mut on = Vec::with_capacity(faces.len() * heights.len());
    for (_, vector, corners) in faces {
        let Some(normal) = vector.try_normalize() else { continue };
        let joins = |(n, o): &Plane| {
            corners.iter().all(|c| (n.dot(*c) - o).abs() <= level) && n.dot(normal) > 0.0
        };
        if !planes.iter().any(joins) {
            columns.heights(normal, &mut heights);
            let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            planes.push((normal, highest));
            on.extend(heights.iter().map(|h| (h - highest).abs() <= level));
        }
    }
    (planes, on)
}

/// Coordinates of points axis by axis, as loops over them are fastest.
struct Columns([Vec<f64>; 3]);

impl Columns {
    fn new(points: &[DVec3]) -> Self {
        Self([0, 1, 2].map(|axis| points.iter().map(|p| p[axis]).collect()))
    }

    /// `direction` · x of every point.
    fn heights(&self, direction: DVec3, into: &mut [f64]) {
        let [x, y, z] = &self.0;
        for (((h, x), y), z) in into.iter_mut().zip(x).zip(y).zip(z) {
            *h = direction.x * x + direction.y * y + direction.z * z;
        }
    }
}

/// Largest `direction` · x over some points. Four at a time: the maximum waits for nothing then.
pub(crate) fn support(points: &[DVec3], direction: DVec3) -> f64 {
    let larger = |best: f64, v: &DVec3| {
        let height = v.dot(direction);
        if height > best { height } else { best }
    };
    let mut best = [f64::NEG_INFINITY; 4];
    let (fours, rest) = points.as_chunks::<4>();
    for four in fours {
        for (best, v) in best.iter_mut().zip(four) {
            *best = larger(*best, v);
        }
    }
    let best = best.into_iter().fold(f64::NEG_INFINITY, f64::max);
    rest.iter().fold(best, larger)
}

/// Corners of a convex side in order around its normal, each once.
fn around(vertices: &[DVec3], mut ring: Vec<u32>, normal: DVec3) -> Vec<u32> {
    ring.sort_unstable();
    ring.dedup();
    let at = |i: u32| vertices[i as usize];
    let centre = ring.iter().map(|&i| at(i)).sum::<DVec3>() / ring.len().max(1) as f64;
    let (u, v) = normal.any_orthonormal_pair();
    let angle = |i: u32| (at(i) - centre).dot(v).atan2((at(i) - centre).dot(u));
    let mut turned: Vec<(f64, u32)> = ring.into_iter().map(|i| (angle(i), i)).collect();
    turned.sort_by(|a, b| a.0.total_cmp(&b.0));
    turned.into_iter().map(|(_, i)| i).collect()
}

/// A polyhedron being cut by a plane.
struct Cut<'a> {
    old: &'a Solid,
    heights: &'a [f64],
    /// New index of each old corner that stays.
    kept: Vec<Option<u32>>,
    vertices: Vec<DVec3>,
    /// Old edges cut through, and the corner made there.
    crossings: Vec<([u32; 2], u32)>,
    /// Corners on the plane.
    rim: Vec<u32>,
}

impl<'a> Cut<'a> {
    fn new(old: &'a Solid, heights: &'a [f64]) -> Self {
        let (mut vertices, mut rim) = (Vec::new(), Vec::new());
        let mut keep = |(v, &h): (&DVec3, &f64)| {
            let index = (h <= 0.0).then_some(vertices.len() as u32)?;
            vertices.push(*v);
            if h == 0.0 {
                rim.push(index);
            }
            Some(index)
        };
        let kept = old.vertices.iter().zip(heights).map(&mut keep).collect();
        Self { old, heights, kept, vertices, crossings: Vec::new(), rim }
    }

    fn facet(&mut self, facet: &Facet) -> Option<Facet> {
        let mut ring = Vec::with_capacity(facet.ring.len() + 2);
        for (i, &a) in facet.ring.iter().enumerate() {
            let b = facet.ring[(i + 1) % facet.ring.len()];
            ring.extend(self.kept[a as usize]);
            if self.heights[a as usize] * self.heights[b as usize] < 0.0 {
                ring.push(self.crossing(a, b));
            }
        }
        let flat = ring.iter().all(|i| self.rim.contains(i));
        (ring.len() >= 3 && !flat).then_some(Facet { ring, ..*facet })
    }

    fn crossing(&mut self, a: u32, b: u32) -> u32 {
        let edge = [a.min(b), a.max(b)];
        if let Some((_, corner)) = self.crossings.iter().find(|(e, _)| *e == edge) {
            return *corner;
        }
        let [p, q] = edge.map(|i| self.old.vertices[i as usize]);
        let [hp, hq] = edge.map(|i| self.heights[i as usize]);
        let corner = self.vertices.len() as u32;
        self.vertices.push(p + (q - p) * (hp / (hp - hq)));
        self.crossings.push((edge, corner));
        self.rim.push(corner);
        corner
    }

    fn close(self, mut facets: Vec<Facet>, normal: DVec3, offset: f64) -> Solid {
        if self.rim.len() >= 3 {
            let ring = around(&self.vertices, self.rim, normal);
            facets.push(Facet { normal, offset, ring });
        }
        let bounds = Bounds::of(self.vertices.iter().copied());
        Solid { vertices: self.vertices, facets, bounds }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> Solid {
        let corner = |i: usize| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64);
        Solid::of(&(0..8).map(corner).collect::<Vec<_>>(), 64, 0.0).unwrap()
    }

    #[test]
    fn a_cube_has_six_sides_volume_one_and_width_one() {
        let cube = cube();
        assert_eq!((cube.vertices.len(), cube.facets.len()), (8, 6));
        assert!((cube.volume() - 1.0).abs() < 1e-12 && (cube.width() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn cutting_a_cube_gives_two_solids_of_its_volume() {
        let n = DVec3::new(1.0, 2.0, -0.7).normalize();
        let (low, high) = (cube().below(n, 0.61).unwrap(), cube().below(-n, -0.61).unwrap());
        assert!((low.volume() + high.volume() - 1.0).abs() < 1e-12);
        assert!((low.support(n) - 0.61).abs() < 1e-12 && high.width() > 0.3);
        assert!(cube().below(DVec3::X, -0.1).is_none());
        assert_eq!(cube().below(DVec3::X, 1.1).unwrap().vertices.len(), 8);
    }

    #[test]
    fn a_corner_cut_through_existing_corners_stays_closed() {
        let n = DVec3::ONE.normalize();
        let half = cube().below(n, DVec3::X.dot(n)).unwrap();
        assert_eq!((half.vertices.len(), half.facets.len()), (4, 4));
        assert!((half.volume() - 1.0 / 6.0).abs() < 1e-12);
    }

    #[test]
    fn distance_is_to_the_side_the_edge_or_the_corner() {
        let d = |x, y, z| cube().distance(DVec3::new(x, y, z), 10.0);
        assert_eq!(d(0.5, 0.5, 0.5), 0.0);
        assert!((d(0.5, 0.25, 3.0) - 2.0).abs() < 1e-12);
        assert!((d(0.5, -3.0, -4.0) - 5.0).abs() < 1e-12);
        assert!((d(2.0, 2.0, 2.0) - 3f64.sqrt()).abs() < 1e-12);
    }
}
