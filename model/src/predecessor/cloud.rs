//! The points Particulate sees: half of them on sharp edges, where there are any.

use object::sample::{point_on, sample_surface};
use object::weld::Weld;
use object::{DVec3, Mesh};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::features::UnitCube;

/// Faces on either side of a sharp edge meet at an angle between these, degrees.
const SHARP: [f64; 2] = [30.0, 150.0];

/// Points of a surface, unit cube.
#[derive(Clone, Debug, Default)]
pub(super) struct Sample {
    /// Where.
    pub positions: Vec<[f32; 3]>,
    /// Normals: of the face, or the mean of both faces of an edge, which is shorter.
    pub normals: Vec<[f32; 3]>,
    /// Their faces.
    pub faces: Vec<u32>,
}

impl Sample {
    fn add(&mut self, position: DVec3, normal: DVec3, face: u32) {
        let single = |v: DVec3| v.to_array().map(|x| x as f32);
        self.positions.push(single(position));
        self.normals.push(single(normal));
        self.faces.push(face);
    }
}

/// A surface and its sharp edges.
pub(super) struct Surface<'a> {
    mesh: &'a Mesh,
    frame: UnitCube,
    edges: Vec<Edge>,
    /// Length of all edges up to and including each.
    lengths: Vec<f64>,
}

/// A sharp edge and its two faces.
struct Edge {
    ends: [DVec3; 2],
    faces: [u32; 2],
}

impl<'a> Surface<'a> {
    /// Looks for sharp edges.
    pub(super) fn new(mesh: &'a Mesh, weld: &Weld, frame: UnitCube) -> Self {
        let [least, most] = SHARP.map(|degrees| degrees.to_radians().cos());
        let normals: Vec<_> = (0..mesh.faces().len()).map(|f| mesh.normal(f)).collect();
        let mut pairs = weld.neighbours();
        pairs.retain(|n| {
            let cosine = normals[n.first as usize].dot(normals[n.second as usize]);
            most < cosine && cosine < least
        });
        // Of an edge with more than two faces, the first pair.
        pairs.sort_unstable_by_key(|n| (n.edge, n.first, n.second));
        pairs.dedup_by_key(|n| n.edge);
        let place = |p: u32| weld.places[p as usize];
        let edges: Vec<_> = pairs
            .iter()
            .map(|n| Edge { ends: n.edge.map(place), faces: [n.first, n.second] })
            .collect();
        let mut total = 0.0;
        let add = |e: &Edge| {
            total += e.ends[0].distance(e.ends[1]);
            total
        };
        let lengths = edges.iter().map(add).collect();
        Self { mesh, frame, edges, lengths }
    }

    /// `count` points: half on sharp edges by length, then one on `each` face, if all have room, then the
    /// rest by area. Without sharp edges none is on them.
    pub(super) fn sample(&self, count: usize, each: bool, seed: u64) -> Sample {
        let mut sample = Sample::default();
        let sharp = if self.edges.is_empty() { 0 } else { count / 2 };
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        for _ in 0..sharp {
            let pick = rng.random::<f64>() * self.lengths.last().copied().unwrap_or(0.0);
            let edge = self.lengths.partition_point(|&l| l <= pick).min(self.edges.len() - 1);
            let Edge { ends: [a, b], faces } = self.edges[edge];
            let normal = (self.normal(faces[0]) + self.normal(faces[1])) / 2.0;
            let face = faces[usize::from(rng.random::<bool>())];
            sample.add(self.frame.inside(a.lerp(b, rng.random())), normal, face);
        }
        let faces = self.mesh.faces().len();
        if each && faces <= count - sharp {
            for face in 0..faces as u32 {
                let point = point_on(self.mesh, face as usize, rng.random(), rng.random());
                sample.add(self.frame.inside(point), self.normal(face), face);
            }
        }
        let rest = count - sample.faces.len();
        for p in sample_surface(self.mesh, rest, seed.wrapping_add(1)) {
            sample.add(self.frame.inside(p.position), p.normal, p.face);
        }
        sample
    }

    fn normal(&self, face: u32) -> DVec3 {
        self.mesh.normal(face as usize)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Boxes of two by one by one, each with its lowest corner at one of these places.
    pub(in super::super) fn blocks(places: &[DVec3]) -> Mesh {
        let corner = |i: u32| {
            DVec3::new(f64::from(i & 1) * 2.0, f64::from(i >> 1 & 1), f64::from(i >> 2 & 1))
        };
        let quads =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        for &place in places {
            let first = vertices.len() as u32;
            vertices.extend((0..8).map(|i| corner(i) + place));
            let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
            faces.extend(triangles.map(|t| t.map(|v| v + first)));
        }
        Mesh::new(vertices, faces).unwrap()
    }

    fn sample(mesh: &Mesh, count: usize, each: bool, seed: u64) -> Sample {
        Surface::new(mesh, &Weld::new(mesh), UnitCube::of(mesh)).sample(count, each, seed)
    }

    #[test]
    fn half_lies_on_edges_and_every_face_has_a_point() {
        let found = sample(&blocks(&[DVec3::ZERO]), 1_000, true, 3);
        assert_eq!(found.faces.len(), 1_000);
        let ends = [0.5, 0.25, 0.25];
        let at_end = |p: &[f32; 3]| (0..3).filter(|&i| (p[i].abs() - ends[i]).abs() < 1e-6).count();
        assert!(found.positions[..500].iter().all(|p| at_end(p) >= 2));
        let length = |n: &[f32; 3]| n.iter().map(|x| x * x).sum::<f32>().sqrt();
        assert!(found.normals[..500].iter().all(|n| (length(n) - 0.5_f32.sqrt()).abs() < 1e-6));
        // Four of twelve edges are twice as long: half of all length.
        let along = found.positions[..500].iter().filter(|p| (p[0].abs() - 0.5).abs() > 1e-6);
        assert!((200..300).contains(&along.count()));
        assert_eq!(found.faces[500..512], (0..12).collect::<Vec<u32>>());
        assert!(found.positions[500..].iter().all(|p| at_end(p) >= 1));
        assert!(found.normals[500..].iter().all(|n| (length(n) - 1.0).abs() < 1e-6));
        assert_eq!(found.positions, sample(&blocks(&[DVec3::ZERO]), 1_000, true, 3).positions);
        assert_ne!(found.positions, sample(&blocks(&[DVec3::ZERO]), 1_000, true, 4).positions);
    }

    #[test]
    fn a_surface_without_edges_or_with_many_faces_is_drawn_by_area() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y].to_vec();
        let flat = Mesh::new(corners, vec![[0, 1, 2]]).unwrap();
        let found = sample(&flat, 10, true, 1);
        assert_eq!(found.normals, [[0.0, 0.0, 1.0]; 10]);
        let crowded = sample(&blocks(&[DVec3::ZERO]), 20, true, 1);
        assert_eq!(crowded.faces.len(), 20);
        assert_ne!(crowded.faces[10..20], (0..10).collect::<Vec<u32>>());
    }
}
