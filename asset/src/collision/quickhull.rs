//! Convex hull of points, grown farthest point first, so that stopping early leaves a hull inside.
//!
//! Points are shaken by ten times the rounding of single precision first, so that no four of them
//! are level and every step is simple; corners are handed back where they were.

use glamx::DVec3;

/// How far points are shaken, as a share of their extent.
const SHAKE: f64 = 3e-7;
/// Least height, as a share of the extent, at which a point counts as outside.
const LEAST: f64 = 1.5e-6;

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
    let size = extent(points);
    let shaken: Vec<_> = points.iter().enumerate().map(|(i, &p)| p + shake(i) * size).collect();
    let mut growing = Growing::start(&shaken, error.max(LEAST * size), LEAST * size)?;
    while growing.corners < limit && growing.grow() {}
    growing.finish(points)
}

/// A small offset, the same for the same index, spread evenly over a cube.
fn shake(index: usize) -> DVec3 {
    let part = |step: f64| (0.5 + step * (index + 1) as f64).fract() - 0.5;
    DVec3::new(part(0.819_172_513_4), part(0.671_043_606_7), part(0.549_700_477_9)) * SHAKE
}

struct Facet {
    corners: [u32; 3],
    normal: DVec3,
    offset: f64,
    outside: Vec<u32>,
    /// Rank of the farthest point outside, and its index.
    far: (f64, u32),
}

impl Facet {
    fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }
}

struct Growing<'a> {
    points: &'a [DVec3],
    facets: Vec<Facet>,
    error: f64,
    corners: usize,
}

impl<'a> Growing<'a> {
    fn start(points: &'a [DVec3], error: f64, flat: f64) -> Option<Self> {
        let [a, b, c, d] = simplex(points, flat)?;
        let mut growing = Self { points, facets: Vec::new(), error, corners: 4 };
        let centre = [a, b, c, d].map(|i| points[i as usize]).iter().sum::<DVec3>() / 4.0;
        for [p, q, r] in [[a, b, c], [a, b, d], [a, c, d], [b, c, d]] {
            let facet = growing.facet([p, q, r])?;
            let inward = facet.height(centre) > 0.0;
            growing.facets.push(if inward { growing.facet([p, r, q])? } else { facet });
        }
        let all = (0..points.len() as u32).collect();
        growing.share_out(all, 0);
        Some(growing)
    }

    fn facet(&self, corners: [u32; 3]) -> Option<Facet> {
        let [a, b, c] = corners.map(|i| self.points[i as usize]);
        let normal = (b - a).cross(c - a).try_normalize()?;
        let offset = normal.dot(a + b + c) / 3.0;
        Some(Facet { corners, normal, offset, outside: Vec::new(), far: (0.0, 0) })
    }

    /// Gives each point to the first facet from `from` on that it lies outside of.
    fn share_out(&mut self, points: Vec<u32>, from: usize) {
        for i in points {
            let p = self.points[i as usize];
            let mut facets = self.facets[from..].iter_mut();
            if let Some(facet) = facets.find(|f| f.height(p) > self.error) {
                facet.outside.push(i);
                let rank = rank(self.points, facet, i);
                if rank > facet.far.0 {
                    facet.far = (rank, i);
                }
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
        if facet.outside.is_empty() {
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
        let seen: Vec<bool> = self.facets.iter().map(|f| f.height(p) > 0.0).collect();
        let rim = self.rim(&seen)?;
        let cone = rim.iter().map(|&[a, b]| self.facet([a, b, apex]));
        let cone = cone.collect::<Option<Vec<_>>>()?;
        let mut orphans = Vec::new();
        let mut at = 0;
        self.facets.retain_mut(|f| {
            at += 1;
            if seen[at - 1] {
                orphans.append(&mut f.outside);
            }
            !seen[at - 1]
        });
        let from = self.facets.len();
        self.facets.extend(cone);
        orphans.retain(|&i| i != apex);
        self.share_out(orphans, from);
        self.corners += 1;
        Some(())
    }

    /// The border of the seen facets as one closed loop of directed edges.
    fn rim(&self, seen: &[bool]) -> Option<Vec<[u32; 2]>> {
        let mut edges: Vec<[u32; 2]> = Vec::new();
        for (facet, _) in self.facets.iter().zip(seen).filter(|(_, s)| **s) {
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
        (walk == first).then_some(edges)
    }

    fn forget(&mut self, at: usize, apex: u32) {
        let facet = &mut self.facets[at];
        facet.outside.retain(|&i| i != apex);
        facet.far = (0.0, 0);
        for &i in &facet.outside {
            let rank = rank(self.points, facet, i);
            if rank > facet.far.0 {
                facet.far = (rank, i);
            }
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
fn rank(points: &[DVec3], facet: &Facet, i: u32) -> f64 {
    let (p, corner) = (points[i as usize], points[facet.corners[0] as usize]);
    facet.height(p) + 1e-3 * p.distance(corner)
}

fn extent(points: &[DVec3]) -> f64 {
    object::mesh::Bounds::of(points.iter().copied()).size().max_element()
}

/// Four points far apart: two extremes, the farthest from their line, the farthest from the plane;
/// among level ones, one at the end.
fn simplex(points: &[DVec3], flat: f64) -> Option<[u32; 4]> {
    let farthest = |height: &dyn Fn(DVec3) -> f64, from: DVec3| {
        let rank = |p: DVec3| height(p) + 1e-3 * p.distance(from);
        let all = points.iter().enumerate().map(|(i, &p)| (rank(p), height(p), i as u32));
        let (_, height, i) = all.fold((0.0, 0.0, 0), |a, b| if b.0 > a.0 { b } else { a });
        (height, i)
    };
    let origin = *points.first()?;
    let (_, a) = farthest(&|p| p.distance(origin), origin);
    let pa = points[a as usize];
    let (length, b) = farthest(&|p| p.distance(pa), pa);
    if length.is_nan() || length <= flat {
        return None;
    }
    let along = (points[b as usize] - pa) / length;
    let (breadth, c) = farthest(&|p| (p - pa).reject_from_normalized(along).length(), pa);
    if breadth <= flat {
        return None;
    }
    let normal = along.cross(points[c as usize] - pa).normalize_or_zero();
    let (height, d) = farthest(&|p| (p - pa).dot(normal).abs(), pa);
    (height > flat).then_some([a, b, c, d])
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
