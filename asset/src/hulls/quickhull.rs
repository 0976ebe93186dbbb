//! Convex hull of points, grown farthest point first, so that stopping early leaves a hull inside.

use glamx::DVec3;

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
    let mut growing = Growing::start(points, error)?;
    while growing.corners < limit && growing.grow() {}
    growing.finish()
}

struct Facet {
    corners: [u32; 3],
    normal: DVec3,
    offset: f64,
    outside: Vec<u32>,
    far: (f64, u32),
}

struct Growing<'a> {
    points: &'a [DVec3],
    facets: Vec<Facet>,
    error: f64,
    flat: f64,
    corners: usize,
}

impl<'a> Growing<'a> {
    fn start(points: &'a [DVec3], error: f64) -> Option<Self> {
        let size = extent(points);
        let flat = 1e-9 * size;
        let [a, b, c, d] = simplex(points, flat.max(1e-7 * size))?;
        let error = error.max(2.0 * flat);
        let mut growing = Self { points, facets: Vec::new(), error, flat, corners: 4 };
        let centre = [a, b, c, d].map(|i| points[i as usize]).iter().sum::<DVec3>() / 4.0;
        for [p, q, r] in [[a, b, c], [a, b, d], [a, c, d], [b, c, d]] {
            let facet = growing.facet([p, q, r])?;
            let inward = facet.normal.dot(centre) > facet.offset;
            growing.facets.push(if inward { growing.facet([p, r, q])? } else { facet });
        }
        let all = (0..points.len() as u32).collect();
        growing.share_out(all, 0);
        Some(growing)
    }

    fn facet(&self, corners: [u32; 3]) -> Option<Facet> {
        let [a, b, c] = corners.map(|i| self.points[i as usize]);
        let cross = (b - a).cross(c - a);
        let longest = (b - a).length().max((c - a).length()).max((c - b).length());
        if cross.length() <= self.flat * longest {
            return None;
        }
        let normal = cross.normalize();
        let offset = normal.dot(a + b + c) / 3.0;
        Some(Facet { corners, normal, offset, outside: Vec::new(), far: (0.0, 0) })
    }

    /// Gives each point to the first facet from `from` on that it lies outside of.
    fn share_out(&mut self, points: Vec<u32>, from: usize) {
        for i in points {
            let p = self.points[i as usize];
            for facet in &mut self.facets[from..] {
                let height = facet.normal.dot(p) - facet.offset;
                if height > self.error {
                    facet.outside.push(i);
                    if height > facet.far.0 {
                        facet.far = (height, i);
                    }
                    break;
                }
            }
        }
    }

    /// Takes in the farthest point; false when none is left outside.
    fn grow(&mut self) -> bool {
        let by_height =
            |(_, a): &(usize, &Facet), (_, b): &(usize, &Facet)| a.far.0.total_cmp(&b.far.0);
        let Some((at, facet)) = self.facets.iter().enumerate().max_by(by_height) else {
            return false;
        };
        if facet.far.0 <= self.error {
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
        let sees = |f: &Facet| f.normal.dot(p) - f.offset > self.flat;
        let seen: Vec<bool> = self.facets.iter().map(sees).collect();
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
        let (normal, offset, points) = (facet.normal, facet.offset, self.points);
        let height = |&i: &u32| (normal.dot(points[i as usize]) - offset, i);
        let heights = facet.outside.iter().map(height);
        facet.far = heights.fold((0.0, 0), |a, b| if b.0 > a.0 { b } else { a });
    }

    fn finish(self) -> Option<Hull> {
        let mut used: Vec<u32> = self.facets.iter().flat_map(|f| f.corners).collect();
        used.sort_unstable();
        used.dedup();
        let place = |i: u32| used.binary_search(&i).ok().map(|at| at as u32);
        let face = |f: &Facet| {
            let [a, b, c] = f.corners;
            Some([place(a)?, place(b)?, place(c)?])
        };
        let faces = self.facets.iter().map(face).collect::<Option<Vec<_>>>()?;
        let vertices = used.iter().map(|&i| self.points[i as usize]).collect();
        Some(Hull { vertices, faces })
    }
}

fn extent(points: &[DVec3]) -> f64 {
    object::mesh::Bounds::of(points.iter().copied()).size().max_element()
}

/// Four points far apart: two extremes, the farthest from their line, the farthest from the plane.
fn simplex(points: &[DVec3], flat: f64) -> Option<[u32; 4]> {
    let farthest = |height: &dyn Fn(DVec3) -> f64| {
        let all = points.iter().enumerate().map(|(i, &p)| (height(p), i as u32));
        all.fold((0.0, 0), |a, b| if b.0 > a.0 { b } else { a })
    };
    let origin = *points.first()?;
    let (_, a) = farthest(&|p| p.distance(origin));
    let pa = points[a as usize];
    let (length, b) = farthest(&|p| p.distance(pa));
    if length.is_nan() || length <= flat {
        return None;
    }
    let along = (points[b as usize] - pa) / length;
    let (breadth, c) = farthest(&|p| (p - pa).reject_from_normalized(along).length());
    if breadth <= flat {
        return None;
    }
    let normal = along.cross(points[c as usize] - pa).normalize_or_zero();
    let (height, d) = farthest(&|p| (p - pa).dot(normal).abs());
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
            assert!(hull.vertices.iter().all(|&v| n.dot(v - a) < 1e-9));
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
    fn flat_or_too_few_points_have_no_hull() {
        assert!(hull(&[], 64, 0.0).is_none());
        let flat: Vec<_> = ball(50).iter().map(|p| DVec3::new(p.x, p.y, 0.3)).collect();
        assert!(hull(&flat, 64, 0.0).is_none());
        assert!(hull(&[DVec3::ONE; 9], 64, 0.0).is_none());
    }
}
