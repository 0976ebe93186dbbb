//! Convex hull of points, grown farthest point first, so that stopping early leaves a hull inside.
//!
//! Points are shaken by ten times the rounding of single precision first, so that no four of them
//! are level and every step is simple; corners are handed back where they were.

use std::sync::LazyLock;

use glamx::DVec3;

/// How far points are shaken, as a share of their extent.
const SHAKE: f64 = 3e-7;
/// Least height, as a share of the extent, at which a point counts as outside.
const LEAST: f64 = 1.5e-6;
/// Offsets that are worked out once: most clouds of points are smaller.
const KEPT_SHAKES: usize = 4096;
/// With so many corners a hull is looked at before it is finished (tuned for speed alone).
const EARLY: usize = 8;
/// Well inside is this share of the extent: hundreds of times what points are shaken, tens of times
/// what may be between sides that count as one.
const WELL: f64 = 1e-4;

/// A closed convex surface, faces counter-clockwise seen from outside.
#[derive(Clone, Debug)]
pub(crate) struct Hull {
    /// Corners, each used by a face.
    pub(crate) vertices: Vec<DVec3>,
    /// Triangles.
    pub(crate) faces: Vec<[u32; 3]>,
}

/// The hull of some points with at most `limit` corners, all of them input points; points may stay
/// up to `error` metres outside (more once the limit is reached). `None` if the points are flat.
pub(crate) fn hull(points: &[DVec3], limit: usize, error: f64) -> Option<Hull> {
    hull_unless(points, (limit, error), |_| false).ok().flatten()
}

/// It was given up, since what it holds so far is enough.
pub(crate) struct GivenUp;

/// The same, but given up if `is_enough` says so of a body well inside it: once there are
/// [`EARLY`] corners, and once more at twice as many.
pub(crate) fn hull_unless(
    points: &[DVec3],
    (limit, error): (usize, f64),
    mut is_enough: impl FnMut(&Inside) -> bool,
) -> Result<Option<Hull>, GivenUp> {
    let size = extent(points);
    let shaken: Vec<_> = points.iter().zip(shakes()).map(|(&p, shake)| p + shake * size).collect();
    let Some(mut growing) = Growing::start(&shaken, error.max(LEAST * size), LEAST * size) else {
        return Ok(None);
    };
    while growing.corners < limit && growing.grow() {
        let is_asked = growing.corners == EARLY || growing.corners == 2 * EARLY;
        if is_asked && is_enough(&Inside { planes: &growing.planes, depth: WELL * size }) {
            return Err(GivenUp);
        }
    }
    Ok(growing.finish(points))
}

/// A body well inside of a hull that is not finished, and so of the finished one, too: by much more
/// than points are shaken, and than sides may be apart to count as one.
pub(crate) struct Inside<'a> {
    planes: &'a [Plane],
    depth: f64,
}

impl Inside<'_> {
    /// Whether it holds a point.
    pub(crate) fn holds(&self, p: DVec3) -> bool {
        self.planes.iter().all(|plane| plane.height(p) < -self.depth)
    }
}

/// Small offsets, the same for the same index, spread evenly over a cube.
fn shakes() -> impl Iterator<Item = DVec3> {
    static FIRST: LazyLock<Vec<DVec3>> = LazyLock::new(|| (0..KEPT_SHAKES).map(shake).collect());
    FIRST.iter().copied().chain((KEPT_SHAKES..).map(shake))
}

fn shake(index: usize) -> DVec3 {
    let part = |step: f64| (0.5 + step * (index + 1) as f64).fract() - 0.5;
    DVec3::new(part(0.819_172_513_4), part(0.671_043_606_7), part(0.549_700_477_9)) * SHAKE
}

/// No further point in a list.
const NONE: u32 = u32::MAX;

/// The plane of a facet: outward unit normal, and offset (n · x of its points).
#[derive(Clone, Copy)]
struct Plane {
    normal: DVec3,
    offset: f64,
}

impl Plane {
    fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }
}

/// What else is known of a facet.
#[derive(Clone, Copy)]
struct Facet {
    corners: [u32; 3],
    /// First and last of the points outside; what follows each stands in [`Growing::next`].
    outside: [u32; 2],
    /// Rank of the farthest point outside, and its index.
    far: (f64, u32),
}

impl Facet {
    fn new(corners: [u32; 3]) -> Self {
        Self { corners, outside: [NONE; 2], far: (0.0, 0) }
    }
}

struct Growing<'a> {
    points: &'a [DVec3],
    /// The facets' planes, apart from what is asked less often.
    planes: Vec<Plane>,
    facets: Vec<Facet>,
    /// For each point the next one outside of the same facet.
    next: Vec<u32>,
    error: f64,
    corners: usize,
    /// What a step works with, kept for the next one.
    seen: Vec<bool>,
    rim: Vec<[u32; 2]>,
    cone: Vec<(Facet, Plane)>,
}

impl<'a> Growing<'a> {
    fn start(points: &'a [DVec3], error: f64, flat: f64) -> Option<Self> {
        let [a, b, c, d] = simplex(points, flat)?;
        let (planes, facets) = (Vec::with_capacity(128), Vec::with_capacity(128));
        let (seen, rim, cone) = (Vec::new(), Vec::new(), Vec::new());
        let next = vec![NONE; points.len()];
        let mut growing = Self { points, planes, facets, next, error, corners: 4, seen, rim, cone };
        let centre = [a, b, c, d].map(|i| points[i as usize]).iter().sum::<DVec3>() / 4.0;
        for [p, q, r] in [[a, b, c], [a, b, d], [a, c, d], [b, c, d]] {
            let plane = growing.plane([p, q, r])?;
            let inward = plane.height(centre) > 0.0;
            let corners = if inward { [p, r, q] } else { [p, q, r] };
            let plane = if inward { growing.plane(corners)? } else { plane };
            growing.facets.push(Facet::new(corners));
            growing.planes.push(plane);
        }
        (0..points.len() as u32).for_each(|i| growing.share_out(i, 0));
        Some(growing)
    }

    fn plane(&self, corners: [u32; 3]) -> Option<Plane> {
        let [a, b, c] = corners.map(|i| self.points[i as usize]);
        let normal = (b - a).cross(c - a).try_normalize()?;
        Some(Plane { normal, offset: normal.dot(a + b + c) / 3.0 })
    }

    /// Gives a point to the first facet from `from` on that it lies outside of.
    fn share_out(&mut self, point: u32, from: usize) {
        let p = self.points[point as usize];
        for (at, plane) in self.planes.iter().enumerate().skip(from) {
            let height = plane.height(p);
            if height > self.error {
                let facet = &mut self.facets[at];
                match facet.outside[1] {
                    NONE => facet.outside[0] = point,
                    last => self.next[last as usize] = point,
                }
                facet.outside[1] = point;
                self.next[point as usize] = NONE;
                let rank = rank(height, p, self.points[facet.corners[0] as usize]);
                if rank > facet.far.0 {
                    facet.far = (rank, point);
                }
                return;
            }
        }
    }

    /// Takes in the farthest point; false when none is left outside.
    fn grow(&mut self) -> bool {
        let by_rank =
            |(_, a): &(usize, &Facet), (_, b): &(usize, &Facet)| a.far.0.total_cmp(&b.far.0);
        let Some((at, facet)) = self.facets.iter().enumerate().max_by(by_rank) else {
            return false;
        };
        if facet.outside[0] == NONE {
            return false;
        }
        let apex = facet.far.1;
        if self.take_in(apex).is_none() {
            self.forget(at, apex);
        }
        true
    }

    /// Replaces the facets that see the apex by a cone; `None`, and nothing changed, if rounding
    /// would make the surface fold.
    fn take_in(&mut self, apex: u32) -> Option<()> {
        let p = self.points[apex as usize];
        self.seen.clear();
        self.seen.extend(self.planes.iter().map(|f| f.height(p) > 0.0));
        self.find_rim()?;
        self.cone.clear();
        for at in 0..self.rim.len() {
            let [a, b] = self.rim[at];
            let plane = self.plane([a, b, apex])?;
            self.cone.push((Facet::new([a, b, apex]), plane));
        }
        // Points outside of what goes, one list after the other.
        let (mut orphans, mut last, mut kept) = (NONE, NONE, 0);
        for at in 0..self.facets.len() {
            let facet = self.facets[at];
            if !self.seen[at] {
                (self.facets[kept], self.planes[kept]) = (facet, self.planes[at]);
                kept += 1;
            } else if facet.outside[0] != NONE {
                match last {
                    NONE => orphans = facet.outside[0],
                    last => self.next[last as usize] = facet.outside[0],
                }
                last = facet.outside[1];
            }
        }
        self.facets.truncate(kept);
        self.planes.truncate(kept);
        self.facets.extend(self.cone.iter().map(|(facet, _)| *facet));
        self.planes.extend(self.cone.iter().map(|(_, plane)| *plane));
        while orphans != NONE {
            let point = orphans;
            orphans = self.next[point as usize];
            if point != apex {
                self.share_out(point, kept);
            }
        }
        self.corners += 1;
        Some(())
    }

    /// The border of the seen facets as one closed loop of directed edges.
    fn find_rim(&mut self) -> Option<()> {
        let Self { rim: edges, facets, seen, .. } = self;
        edges.clear();
        for (facet, _) in facets.iter().zip(seen).filter(|(_, s)| **s) {
            let [a, b, c] = facet.corners;
            for [p, q] in [[a, b], [b, c], [c, a]] {
                match edges.iter().position(|&e| e == [q, p]) {
                    Some(twin) => {
                        edges.swap_remove(twin);
                    }
                    None => edges.push([p, q]),
                }
            }
        }
        let mut walk = edges.first()?[0];
        let first = walk;
        for step in 1..=edges.len() {
            let from = walk;
            let mut leaving = edges.iter().filter(|e| e[0] == from);
            walk = leaving.next()?[1];
            if leaving.next().is_some() || (walk == first && step < edges.len()) {
                return None;
            }
        }
        (walk == first).then_some(())
    }

    /// A facet without one of the points outside of it.
    fn forget(&mut self, at: usize, apex: u32) {
        let mut point = self.facets[at].outside[0];
        let facet = &mut self.facets[at];
        let (plane, corner) = (self.planes[at], self.points[facet.corners[0] as usize]);
        *facet = Facet::new(facet.corners);
        while point != NONE {
            let following = self.next[point as usize];
            if point != apex {
                match facet.outside[1] {
                    NONE => facet.outside[0] = point,
                    last => self.next[last as usize] = point,
                }
                facet.outside[1] = point;
                self.next[point as usize] = NONE;
                let p = self.points[point as usize];
                let rank = rank(plane.height(p), p, corner);
                if rank > facet.far.0 {
                    facet.far = (rank, point);
                }
            }
            point = following;
        }
    }

    fn finish(self, points: &[DVec3]) -> Option<Hull> {
        let mut used: Vec<u32> = self.facets.iter().flat_map(|f| f.corners).collect();
        used.sort_unstable();
        used.dedup();
        let place = |i: u32| used.binary_search(&i).ok().map(|at| at as u32);
        let face = |f: &Facet| {
            let [a, b, c] = f.corners;
            Some([place(a)?, place(b)?, place(c)?])
        };
        let faces = self.facets.iter().map(face).collect::<Option<Vec<_>>>()?;
        let vertices = used.iter().map(|&i| points[i as usize]).collect();
        Some(Hull { vertices, faces })
    }
}

/// Height above a facet, and a little for lying far out: among level points, one at the end.
fn rank(height: f64, p: DVec3, corner: DVec3) -> f64 {
    height + 1e-3 * p.distance(corner)
}

fn extent(points: &[DVec3]) -> f64 {
    object::mesh::Bounds::of(points.iter().copied()).size().max_element()
}

/// Four points far apart: two extremes, the farthest from their line, the farthest from the plane;
/// among level ones, one at the end.
fn simplex(points: &[DVec3], flat: f64) -> Option<[u32; 4]> {
    let origin = *points.first()?;
    let (_, a) = farthest(points, |p| p.distance(origin), origin);
    let pa = points[a as usize];
    let (length, b) = farthest(points, |p| p.distance(pa), pa);
    if length.is_nan() || length <= flat {
        return None;
    }
    let along = (points[b as usize] - pa) / length;
    let (breadth, c) = farthest(points, |p| (p - pa).reject_from_normalized(along).length(), pa);
    if breadth <= flat {
        return None;
    }
    let normal = along.cross(points[c as usize] - pa).normalize_or_zero();
    let (height, d) = farthest(points, |p| (p - pa).dot(normal).abs(), pa);
    (height > flat).then_some([a, b, c, d])
}

/// The height and index of the point that lies highest, a little counting for lying far out.
fn farthest(points: &[DVec3], height: impl Fn(DVec3) -> f64, from: DVec3) -> (f64, u32) {
    let (mut best, mut found) = (0.0, (0.0, 0));
    for (i, &p) in points.iter().enumerate() {
        let height = height(p);
        let rank = height + 1e-3 * p.distance(from);
        if rank > best {
            (best, found) = (rank, (height, i as u32));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ball(count: usize) -> Vec<DVec3> {
        let turn = |i: usize| {
            let z = 1.0 - 2.0 * (i as f64 + 0.5) / count as f64;
            let (s, c) = (2.399_963 * i as f64).sin_cos();
            let r = (1.0 - z * z).sqrt();
            DVec3::new(r * c, r * s, z)
        };
        (0..count).map(turn).collect()
    }

    /// Euler's V − E + F = 2 with E = 3F/2, and no vertex above any face.
    fn assert_closed_and_convex(hull: &Hull) {
        assert_eq!(hull.faces.len(), 2 * hull.vertices.len() - 4);
        for f in &hull.faces {
            let [a, b, c] = f.map(|i| hull.vertices[i as usize]);
            let n = (b - a).cross(c - a).normalize();
            assert!(hull.vertices.iter().all(|&v| n.dot(v - a) < 2e-5));
        }
    }

    #[test]
    fn the_hull_of_a_box_with_points_on_its_faces_has_eight_corners() {
        let grid = |i: usize| DVec3::new((i % 5) as f64, (i / 5 % 5) as f64, (i / 25) as f64);
        let points: Vec<_> = (0..125).map(grid).collect();
        let hull = hull(&points, 64, 0.0).unwrap();
        assert_closed_and_convex(&hull);
        for corner in [DVec3::ZERO, DVec3::splat(4.0), DVec3::new(4.0, 0.0, 4.0)] {
            assert!(hull.vertices.contains(&corner));
        }
    }

    #[test]
    fn a_limited_hull_stays_inside_and_uses_the_points_given() {
        let points = ball(1_003);
        let small = hull(&points, 31, 0.0).unwrap();
        assert_closed_and_convex(&small);
        assert!(small.vertices.len() <= 31 && small.vertices.iter().all(|v| points.contains(v)));
        let fine = hull(&points, 5_000, 0.0).unwrap();
        assert_closed_and_convex(&fine);
        assert_eq!(fine.vertices.len(), 1_003);
    }

    #[test]
    fn what_lies_well_inside_an_unfinished_hull_lies_in_the_finished_one() {
        let points = ball(700);
        let whole = hull(&points, 32, 0.0).unwrap();
        let is_in = |p: DVec3| {
            whole.faces.iter().all(|f| {
                let [a, b, c] = f.map(|i| whole.vertices[i as usize]);
                (b - a).cross(c - a).dot(p - a) <= 0.0
            })
        };
        let grid = |i: usize| DVec3::new((i % 21) as f64, (i / 21 % 21) as f64, (i / 441) as f64);
        let places: Vec<DVec3> = (0..9261).map(|i| grid(i) / 10.0 - DVec3::ONE).collect();
        let mut counts = Vec::new();
        let finished = hull_unless(&points, (32, 0.0), |inside| {
            let held: Vec<_> = places.iter().filter(|p| inside.holds(**p)).collect();
            assert!(held.iter().all(|p| is_in(**p)));
            counts.push(held.len());
            false
        });
        let finished = finished.ok().flatten().unwrap();
        assert!(finished.vertices == whole.vertices && finished.faces == whole.faces);
        assert!(counts.len() == 2 && 0 < counts[0] && counts[0] < counts[1], "{counts:?}");
        assert!(hull_unless(&points, (32, 0.0), |_| true).is_err(), "it was given up");
    }

    #[test]
    fn a_prism_of_single_precision_keeps_its_volume() {
        // Twelve directions, two rings, points on every edge: rows of points level but for noise.
        for turn in 0..40 {
            let axis = DVec3::new(0.3, 0.1 * f64::from(turn), 0.9).normalize();
            let tilt = glamx::DQuat::from_rotation_arc(DVec3::Z, axis);
            let at = |i: u32, z: f64, out: f64| {
                let (s, c) = (f64::from(i) * std::f64::consts::TAU / 24.0).sin_cos();
                (tilt * DVec3::new(c * out, s * out * 0.4, z)).as_vec3().as_dvec3()
            };
            let edge = (std::f64::consts::TAU / 24.0).cos();
            let out = |i: u32| if i.is_multiple_of(2) { 1.0 } else { edge };
            let ring = (0..24).flat_map(|i| [0.0, 0.013, 0.02].map(|z| at(i, z, out(i))));
            let points: Vec<_> = ring.collect();
            let solid = crate::collision::solid::Solid::of(&points, 200, 0.0).unwrap();
            let true_volume = 0.02 * 0.4 * 6.0 * (std::f64::consts::TAU / 12.0).sin();
            assert!((solid.volume() / true_volume - 1.0).abs() < 1e-4, "turn {turn}");
            for error in [1e-7, 1e-6, 1e-5] {
                let again = crate::collision::solid::Solid::of(&solid.vertices, 60, error).unwrap();
                assert!((again.volume() / true_volume - 1.0).abs() < 1e-3, "turn {turn}, {error}");
            }
        }
    }

    #[test]
    fn flat_or_too_few_points_have_no_hull() {
        assert!(hull(&[], 64, 0.0).is_none());
        let flat: Vec<_> = ball(50).iter().map(|p| DVec3::new(p.x, p.y, 0.3)).collect();
        assert!(hull(&flat, 64, 0.0).is_none());
        assert!(hull(&[DVec3::ONE; 9], 64, 0.0).is_none());
    }
}
