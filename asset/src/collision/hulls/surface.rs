//! A surface one can ask how far away it is and whether it encloses a point.

use glamx::DVec3;
use object::mesh::{Bounds, Mesh};
use object::weld::nearest_on_triangle;

/// Triangles in a leaf of the tree.
const LEAF: usize = 6;
/// A cluster this many radii away counts as one dipole (Barill et al. 2018, fast winding numbers).
const FAR: f64 = 2.0;

/// Triangles in a bounding-volume tree.
#[derive(Debug)]
pub(crate) struct Surface {
    triangles: Vec<[DVec3; 3]>,
    /// A ball around each triangle.
    balls: Vec<(DVec3, f64)>,
    nodes: Vec<Node>,
    /// What of each node counts from afar.
    dipoles: Vec<Dipole>,
}

#[derive(Debug)]
struct Node {
    bounds: Bounds,
    /// Triangles of a leaf; for a fork, its two children.
    first: u32,
    last: u32,
    leaf: bool,
}

/// A cluster of triangles seen from afar.
#[derive(Debug)]
struct Dipole {
    /// Area-weighted centre.
    centre: DVec3,
    /// Sum of area vectors.
    vector: DVec3,
    /// Square of the distance from the centre beyond which the cluster counts as one dipole.
    near: f64,
}

impl Surface {
    /// The tree over a mesh's faces.
    pub(crate) fn new(mesh: &Mesh) -> Self {
        Self::of((0..mesh.faces().len()).map(|f| mesh.corners(f)).collect())
    }

    fn of(triangles: Vec<[DVec3; 3]>) -> Self {
        let (balls, nodes, dipoles) = (Vec::new(), Vec::new(), Vec::new());
        let mut surface = Self { triangles, balls, nodes, dipoles };
        surface.build(0, surface.triangles.len());
        surface.balls = surface.triangles.iter().map(ball).collect();
        surface
    }

    fn build(&mut self, first: usize, last: usize) -> u32 {
        let index = self.nodes.len();
        let triangles = &self.triangles[first..last];
        let bounds = Bounds::of(triangles.iter().flatten().copied());
        self.dipoles.push(dipole(triangles, &bounds));
        self.nodes.push(Node { bounds, first: first as u32, last: last as u32, leaf: true });
        if last - first > LEAF {
            let size = self.nodes[index].bounds.size();
            let axis = size.to_array().iter().position(|&s| s >= size.max_element()).unwrap_or(0);
            let middle = (last - first) / 2;
            let key = |t: &[DVec3; 3]| t[0][axis] + t[1][axis] + t[2][axis];
            self.triangles[first..last].sort_by(|a, b| key(a).total_cmp(&key(b)));
            let left = self.build(first, first + middle);
            let right = self.build(first + middle, last);
            let node = &mut self.nodes[index];
            (node.first, node.last, node.leaf) = (left, right, false);
        }
        index as u32
    }

    /// Distance from a point to the surface; `beyond` if it is not nearer than that.
    #[cfg(test)]
    fn distance(&self, p: DVec3, beyond: f64) -> f64 {
        self.distance_between(p, 0.0, beyond)
    }

    /// Distance from a point to the surface; some value below `enough` if it is below that,
    /// `beyond` if it is not nearer than that.
    pub(crate) fn distance_between(&self, p: DVec3, enough: f64, beyond: f64) -> f64 {
        let to = |i: u32| box_distance_squared(&self.nodes[i as usize].bounds, p);
        let mut best = beyond * beyond;
        let mut away = best.sqrt();
        // The tree is halved at each fork: it is never deeper than this.
        let (mut stack, mut open) = ([(0, 0.0); 64], 1);
        stack[0] = (0, to(0));
        while open > 0 {
            open -= 1;
            let (index, reach) = stack[open];
            if reach >= best {
                continue;
            }
            let node: &Node = &self.nodes[index as usize];
            if node.leaf {
                for at in node.first as usize..node.last as usize {
                    let (centre, radius) = self.balls[at];
                    let reach = away + radius;
                    if centre.distance_squared(p) < reach * reach {
                        let nearest = nearest_on_triangle(p, self.triangles[at]);
                        let squared = nearest.distance_squared(p);
                        if squared < best {
                            (best, away) = (squared, squared.sqrt());
                        }
                    }
                }
                if best < enough * enough {
                    break;
                }
                continue;
            }
            let [a, b] = [node.first, node.last].map(|i| (i, to(i)));
            let (near, far) = if a.1 <= b.1 { (a, b) } else { (b, a) };
            stack[open] = far;
            stack[open + 1] = near;
            open += 2;
        }
        away
    }

    /// The generalised winding number of a point: 1 in what the surface encloses, 0 outside.
    pub(crate) fn winding(&self, p: DVec3) -> f64 {
        let (mut far, mut near) = (0.0, 0.0);
        // The tree is halved at each fork: it is never deeper than this.
        let (mut stack, mut open) = ([0u32; 64], 1);
        while open > 0 {
            open -= 1;
            let index = stack[open] as usize;
            let dipole = &self.dipoles[index];
            let to = dipole.centre - p;
            let squared = to.length_squared();
            if squared > dipole.near {
                far += dipole.vector.dot(to) / (squared * squared.sqrt());
                continue;
            }
            let node = &self.nodes[index];
            if node.leaf {
                let leaf = &self.triangles[node.first as usize..node.last as usize];
                near += leaf.iter().map(|t| solid_angle(p, t)).sum::<f64>();
                continue;
            }
            stack[open] = node.last;
            stack[open + 1] = node.first;
            open += 2;
        }
        far / (4.0 * std::f64::consts::PI) + near
    }
}

/// The ball around a triangle's centroid.
fn ball(t: &[DVec3; 3]) -> (DVec3, f64) {
    let centre = (t[0] + t[1] + t[2]) / 3.0;
    (centre, t.iter().map(|v| v.distance(centre)).fold(0.0, f64::max) * (1.0 + 1e-12))
}

fn dipole(triangles: &[[DVec3; 3]], bounds: &Bounds) -> Dipole {
    let of = |t: &[DVec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]) / 2.0;
    let (mut area, mut centre, mut vector) = (0.0, DVec3::ZERO, DVec3::ZERO);
    for t in triangles {
        let v = of(t);
        area += v.length();
        centre += (t[0] + t[1] + t[2]) * (v.length() / 3.0);
        vector += v;
    }
    let centre = if area > 0.0 { centre / area } else { bounds.centre() };
    let reach = triangles.iter().flatten().map(|v| v.distance(centre));
    let radius = FAR * reach.fold(0.0, f64::max);
    Dipole { centre, vector, near: radius * radius }
}

fn box_distance_squared(bounds: &Bounds, p: DVec3) -> f64 {
    (bounds.min - p).max(p - bounds.max).max(DVec3::ZERO).length_squared()
}

/// The share of the full sphere a triangle covers seen from a point (Van Oosterom and Strackee).
fn solid_angle(p: DVec3, t: &[DVec3; 3]) -> f64 {
    let [a, b, c] = t.map(|v| v - p);
    let [la, lb, lc] = [a, b, c].map(DVec3::length);
    let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    let above = a.dot(b.cross(c));
    let slope = above / below;
    let angle = if below > 0.0 && slope.abs() < 0.2 { arctan(slope) } else { above.atan2(below) };
    angle / (2.0 * std::f64::consts::PI)
}

/// The arc tangent by its series, within 2e-9 for slopes below 0.2; most triangles look that small.
fn arctan(x: f64) -> f64 {
    let q = x * x;
    x * (1.0 - q * (1.0 / 3.0 - q * (1.0 / 5.0 - q * (1.0 / 7.0 - q / 9.0))))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit cube as a shell of n × n squares on each side.
    fn cube(n: usize) -> Surface {
        let mut triangles = Vec::new();
        for side in 0..6 {
            let (axis, high) = (side / 2, (side % 2) as f64);
            let at = |u: usize, v: usize| {
                let mut p = [0.0; 3];
                p[axis] = high;
                p[(axis + 1) % 3] = u as f64 / n as f64;
                p[(axis + 2) % 3] = v as f64 / n as f64;
                DVec3::from_array(p)
            };
            for (u, v) in (0..n * n).map(|i| (i / n, i % n)) {
                let [a, b, c, d] = [at(u, v), at(u + 1, v), at(u + 1, v + 1), at(u, v + 1)];
                let pair = [[a, b, c], [a, c, d]];
                triangles
                    .extend(pair.map(|[p, q, r]| if high > 0.5 { [p, q, r] } else { [p, r, q] }));
            }
        }
        Surface::of(triangles)
    }

    #[test]
    fn a_closed_cube_encloses_its_inside_only() {
        let cube = cube(7);
        for (p, inside) in [(0.5, true), (0.97, true), (1.03, false), (-0.2, false), (4.0, false)] {
            assert_eq!(cube.winding(DVec3::new(p, 0.31, 0.44)) > 0.5, inside, "x = {p}");
        }
        assert!((cube.winding(DVec3::splat(0.4)) - 1.0).abs() < 0.02);
    }

    #[test]
    fn a_short_series_is_the_arc_tangent_of_small_slopes() {
        let worst = (-200..=200).map(|i| f64::from(i) * 1e-3).map(|x| (arctan(x) - x.atan()).abs());
        assert!(worst.fold(0.0, f64::max) < 2e-9);
    }

    #[test]
    fn distance_is_to_the_nearest_side_and_stops_where_told() {
        let cube = cube(5);
        assert!((cube.distance(DVec3::splat(0.4), 9.0) - 0.4).abs() < 1e-12);
        assert!((cube.distance(DVec3::new(0.5, 0.5, 3.0), 9.0) - 2.0).abs() < 1e-12);
        assert!((cube.distance(DVec3::new(0.5, 0.5, 3.0), 0.7) - 0.7).abs() < 1e-12);
    }
}
