//! Descriptions of regions of a surface: connected components, and patches between sharp edges.

use std::collections::BTreeMap;

use object::weld::{DisjointSets, Neighbour, Weld};
use object::{DVec3, Mesh};

use super::UnitCube;
use super::moments::Moments;

/// Numbers that describe a point by its region.
pub const WIDTH: usize = 12;
/// Faces whose normals differ by more than this many degrees are apart.
const SHARP_DEGREES: f64 = 30.0;

/// For each face its region, and for each region its box, size and likeness to others.
#[derive(Clone, Debug)]
pub struct Regions {
    of_face: Vec<u32>,
    regions: Vec<Region>,
}

#[derive(Clone, Copy, Debug)]
struct Region {
    low: DVec3,
    high: DVec3,
    moments: Moments,
    /// How many regions have its size, itself included.
    twins: usize,
}

/// For each face, the patch it lies in: faces joined across edges that are not sharp.
pub fn smooth_patches(mesh: &Mesh, neighbours: &[Neighbour]) -> (Vec<u32>, usize) {
    let count = mesh.faces().len();
    let normals: Vec<_> = (0..count).map(|f| mesh.normal(f)).collect();
    let limit = SHARP_DEGREES.to_radians().cos();
    let mut sets = DisjointSets::new(count);
    for n in neighbours {
        if normals[n.first as usize].dot(normals[n.second as usize]) >= limit {
            sets.join(n.first, n.second);
        }
    }
    let mut number = BTreeMap::new();
    let mut numbered = |root| {
        let next = number.len() as u32;
        *number.entry(root).or_insert(next)
    };
    let patch: Vec<u32> = (0..count as u32).map(|f| numbered(sets.root(f))).collect();
    let patches = number.len();
    (patch, patches)
}

impl Regions {
    /// The connected components of a welded mesh.
    pub fn components(mesh: &Mesh, weld: &Weld, frame: UnitCube) -> Self {
        Self::new(mesh, frame, weld.components())
    }

    /// The patches between sharp edges of a welded mesh.
    pub fn patches(mesh: &Mesh, weld: &Weld, frame: UnitCube) -> Self {
        Self::new(mesh, frame, smooth_patches(mesh, &weld.neighbours()))
    }

    fn new(mesh: &Mesh, frame: UnitCube, (of_face, count): (Vec<u32>, usize)) -> Self {
        let empty = Region {
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
            moments: Moments::default(),
            twins: 0,
        };
        let mut regions = vec![empty; count];
        for (face, &region) in of_face.iter().enumerate() {
            let region = &mut regions[region as usize];
            let corners = mesh.corners(face).map(|c| frame.inside(c));
            let area = (corners[1] - corners[0]).cross(corners[2] - corners[0]).length() / 2.0;
            region.moments.add(&Moments::triangle(corners, area), 1.0);
            for corner in corners {
                region.low = region.low.min(corner);
                region.high = region.high.max(corner);
            }
        }
        count_twins(&mut regions);
        Self { of_face, regions }
    }

    /// [`WIDTH`] numbers for a point (unit cube) of a face: size of the region's box, place in that
    /// box from −1 to 1, spread along its own axes, root of its area, logarithm of its twins, and
    /// one over the number of regions.
    pub fn describe(&self, face: usize, point: DVec3) -> [f32; WIDTH] {
        let region = &self.regions[self.of_face[face] as usize];
        let size = region.high - region.low;
        let centre = (region.high + region.low) / 2.0;
        let place = ((point - centre) / (size / 2.0).max(DVec3::splat(1e-3)))
            .clamp(-DVec3::ONE, DVec3::ONE);
        let [a, b, c] = region.moments.deviations();
        let twins = (region.twins as f64).log2() / 4.0;
        let area = region.moments.weight.sqrt();
        let share = 1.0 / self.regions.len() as f64;
        let all = [
            size.x,
            size.y,
            size.z,
            place.x,
            place.y,
            place.z,
            2.0 * a,
            2.0 * b,
            2.0 * c,
            area,
            twins,
            share,
        ];
        all.map(|v| v as f32)
    }
}

/// Regions are twins when size and area round to the same half percent of the unit cube.
fn count_twins(regions: &mut [Region]) {
    let key = |r: &Region| {
        let size = ((r.high - r.low) * 200.0).round();
        [size.x, size.y, size.z, (r.moments.weight.sqrt() * 200.0).round()].map(|v| v as i64)
    };
    let mut count: BTreeMap<[i64; 4], usize> = BTreeMap::new();
    regions.iter().for_each(|r| *count.entry(key(r)).or_default() += 1);
    regions.iter_mut().for_each(|r| r.twins = count[&key(r)]);
}
