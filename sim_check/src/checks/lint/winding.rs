//! How often a surface winds round a point: 1 inside a closed surface, 0 outside, in between where
//! it is open. Far groups of faces count as one dipole (Barill et al., Fast Winding Numbers for
//! Soups and Clouds, 2018, first order).

use std::f64::consts::PI;
use std::ops::Range;
use std::sync::Arc;

use glamx::DVec3;

use crate::geometry::near::BoxTree;
use crate::geometry::near::triangle::Triangle;

/// A group counts as one dipole beyond this many of its radii.
const FAR: f64 = 2.0;
/// Most faces of a group that is not divided further.
const LEAF: usize = 8;

/// A half angle of less than this is taken from the first terms of its series, good to 1e-10.
const SMALL: f64 = 0.1;

/// A tree of face groups, each followed by the groups within it.
#[derive(Clone, Debug)]
pub(crate) struct WindingTree {
    faces: Arc<BoxTree>,
    groups: Vec<Group>,
}

#[derive(Clone, Debug)]
struct Group {
    centre: DVec3,
    /// Squared distance beyond which it counts as one dipole.
    far: f64,
    /// Sum of the faces' area vectors, m².
    dipole: DVec3,
    /// Its faces.
    faces: Range<u32>,
    /// The first group that is not within it.
    next: u32,
    is_leaf: bool,
}

impl WindingTree {
    /// Groups the faces of a surface as its boxes do.
    pub(crate) fn new(faces: Arc<BoxTree>) -> Self {
        let mut tree = Self { faces: faces.clone(), groups: Vec::new() };
        let leaning: Vec<Leaning> = faces.triangles().iter().map(Leaning::of).collect();
        tree.build(&leaning, 0);
        tree
    }

    /// Builds the group of a box and those within it.
    fn build(&mut self, leaning: &[Leaning], at: usize) {
        let Some(faces) = self.faces.range(at) else { return };
        let within = self.faces.children(at).filter(|_| faces.len() > LEAF);
        let index = self.groups.len();
        self.groups.push(summary(self.faces.triangles(), leaning, faces, within.is_none()));
        within.into_iter().flatten().for_each(|child| self.build(leaning, child));
        self.groups[index].next = self.groups.len() as u32;
    }

    /// The winding number at a point.
    pub(crate) fn at(&self, p: DVec3) -> f64 {
        let (mut sum, mut index) = (0.0, 0);
        while let Some(group) = self.groups.get(index) {
            let away = group.centre - p;
            let squared = away.length_squared();
            let is_far = squared > group.far && squared > 0.0;
            if is_far {
                sum += group.dipole.dot(away) / (squared * squared.sqrt());
            } else if group.is_leaf {
                let faces = group.faces.start as usize..group.faces.end as usize;
                sum += self.faces.triangles()[faces].iter().map(|c| solid_angle(p, c)).sum::<f64>();
            }
            index = if is_far || group.is_leaf { group.next as usize } else { index + 1 };
        }
        sum / (4.0 * PI)
    }
}

/// What a face adds to its groups.
struct Leaning {
    /// Direction of the normal, length the area.
    vector: DVec3,
    area: f64,
    /// Its centre times its area.
    moment: DVec3,
}

impl Leaning {
    fn of(corners: &Triangle) -> Self {
        let vector = area_vector(corners);
        let area = vector.length();
        Self { vector, area, moment: centroid(corners) * area }
    }
}

fn summary(
    triangles: &[Triangle],
    leaning: &[Leaning],
    faces: Range<usize>,
    is_leaf: bool,
) -> Group {
    let mine = &triangles[faces.clone()];
    let (mut dipole, mut moment, mut area) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for of in &leaning[faces.clone()] {
        dipole += of.vector;
        moment += of.moment;
        area += of.area;
    }
    let first = mine.first().map_or(DVec3::ZERO, centroid);
    let centre = if area > 0.0 { moment / area } else { first };
    let radius = mine.iter().flatten().map(|c| c.distance_squared(centre)).fold(0.0, f64::max);
    let (far, faces) = (FAR * FAR * radius, faces.start as u32..faces.end as u32);
    Group { centre, far, dipole, faces, next: 0, is_leaf }
}

fn centroid([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (*a + *b + *c) / 3.0
}

/// Direction of the normal, length the area.
fn area_vector([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (*b - *a).cross(*c - *a) / 2.0
}

/// Signed solid angle of a triangle seen from `p` (van Oosterom and Strackee, 1983).
fn solid_angle(p: DVec3, corners: &[DVec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|v| v - p);
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let numerator = a.dot(b.cross(c));
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    let ratio = numerator / denominator;
    if denominator > 0.0 && ratio.abs() < SMALL {
        let squared = ratio * ratio;
        return 2.0 * ratio * (1.0 - squared * (1.0 / 3.0 - squared * (0.2 - squared / 7.0)));
    }
    2.0 * numerator.atan2(denominator)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::tessellate::tessellated;
    use crate::robot::Geometry;
    use object::Mesh;

    fn of(mesh: &Mesh) -> WindingTree {
        WindingTree::new(Arc::new(BoxTree::of_mesh(mesh)))
    }

    #[test]
    fn it_is_one_inside_and_nought_outside_a_sphere() {
        let tree = of(&tessellated(&Geometry::Sphere { radius: 1.0 }).unwrap());
        for (r, expected) in [(0.0, 1.0), (0.5, 1.0), (0.97, 1.0), (1.02, 0.0), (3.0, 0.0)] {
            let at = tree.at(DVec3::new(0.6, 0.0, 0.8) * r);
            assert!((at - expected).abs() < 0.05, "at {r}: {at}");
        }
    }

    #[test]
    fn the_series_of_a_small_angle_meets_the_angle() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        for height in [0.3, 1.0, 1.8, 1.9, 5.0, 40.0] {
            let [a, b, c] = corners.map(|v| v - DVec3::Z * height);
            let sides = [a, b, c].map(|v| v.normalize());
            let cosine = |i: usize, j: usize| sides[i].dot(sides[j]);
            let numerator = sides[0].dot(sides[1].cross(sides[2]));
            let exact = 2.0 * numerator.atan2(1.0 + cosine(0, 1) + cosine(1, 2) + cosine(2, 0));
            let found = solid_angle(DVec3::Z * height, &corners);
            assert!((found - exact).abs() < 1e-9, "{height}: {found} {exact}");
        }
    }

    #[test]
    fn an_open_cup_winds_more_deep_inside_than_at_its_mouth() {
        let whole = tessellated(&Geometry::Cylinder { radius: 1.0, length: 4.0 }).unwrap();
        let no_top = (0..whole.faces().len()).filter(|&f| whole.normal(f).z < 0.9);
        let tree = of(&whole.submesh(no_top).unwrap());
        let (deep, mouth) = (tree.at(DVec3::new(0.0, 0.0, -1.5)), tree.at(DVec3::Z * 2.0));
        assert!(deep > 0.9 && (mouth - 0.5).abs() < 0.05, "{deep} {mouth}");
        assert!(tree.at(DVec3::Z * 4.0) < 0.2);
    }
}
