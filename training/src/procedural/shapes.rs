//! Boxes, cylinders and turned profiles: closed surfaces with outward faces.

use std::f64::consts::TAU;

use object::mesh::{FileFrame, MeshError, UpAxis};
use object::{DPose3, DVec3, Mesh};

/// A closed coloured surface in the making; object frame, metres.
#[derive(Clone, Debug, Default)]
pub(super) struct Shape {
    pub vertices: Vec<DVec3>,
    pub faces: Vec<[u32; 3]>,
    pub colours: Vec<[u8; 4]>,
}

impl Shape {
    pub(super) fn add(&mut self, other: &Self) {
        let base = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        self.colours.extend(&other.colours);
        self.faces.extend(other.faces.iter().map(|f| f.map(|v| v + base)));
    }

    pub(super) fn with(mut self, other: Self) -> Self {
        self.add(&other);
        self
    }

    pub(super) fn moved(mut self, pose: DPose3) -> Self {
        self.vertices.iter_mut().for_each(|v| *v = pose * *v);
        self
    }

    pub(super) fn at(self, x: f64, y: f64, z: f64) -> Self {
        self.moved(DPose3::from_translation(DVec3::new(x, y, z)))
    }

    pub(super) fn mesh(self) -> Result<Mesh, MeshError> {
        let mesh = Mesh::new(self.vertices, self.faces)?;
        mesh.with_frame(FileFrame { up: UpAxis::Y }).with_colours(Some(self.colours))
    }
}

/// A box between two corners.
pub(super) fn block(min: [f64; 3], max: [f64; 3], colour: [u8; 3]) -> Shape {
    let corner = |i: usize| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { min[axis] } else { max[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    };
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    paint((0..8).map(corner).collect(), faces, colour)
}

/// A profile of (radius, height) pairs turned about z; it starts and ends on the axis or is closed
/// there by a flat cap, and runs upward on the outside.
pub(super) fn turned(profile: &[(f64, f64)], sides: u32, colour: [u8; 3]) -> Shape {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for &(r, z) in profile {
        let on_ring = |i: u32| {
            let angle = TAU * f64::from(i) / f64::from(sides);
            DVec3::new(r * angle.cos(), r * angle.sin(), z)
        };
        vertices.extend((0..sides).map(on_ring));
    }
    for ring in 0..profile.len() as u32 - 1 {
        for i in 0..sides {
            let (j, low, high) = ((i + 1) % sides, ring * sides, (ring + 1) * sides);
            faces.extend([[low + i, low + j, high + j], [low + i, high + j, high + i]]);
        }
    }
    let (first, last) = (profile[0].1, profile[profile.len() - 1].1);
    let (bottom, top) = (vertices.len() as u32, vertices.len() as u32 + 1);
    vertices.extend([DVec3::new(0.0, 0.0, first), DVec3::new(0.0, 0.0, last)]);
    let high = (profile.len() as u32 - 1) * sides;
    for i in 0..sides {
        let j = (i + 1) % sides;
        faces.extend([[bottom, j, i], [top, high + i, high + j]]);
    }
    paint(vertices, faces, colour)
}

/// A ring about z around the origin: a square bar, `thick` wide and high, bent to this radius.
pub(super) fn hoop(radius: f64, thick: f64, sides: u32, colour: [u8; 3]) -> Shape {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for i in 0..sides {
        let angle = TAU * f64::from(i) / f64::from(sides);
        for [out, up] in [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]] {
            let r = radius + out * thick;
            vertices.push(DVec3::new(r * angle.cos(), r * angle.sin(), up * thick));
        }
        for k in 0..4 {
            let ([a, b], next) = ([k, (k + 1) % 4].map(|c| 4 * i + c), 4 * ((i + 1) % sides));
            let [c, d] = [next + k, next + (k + 1) % 4];
            faces.extend([[a, c, d], [a, d, b]]);
        }
    }
    paint(vertices, faces, colour)
}

/// A cylinder about z from `low` to `high`.
pub(super) fn cylinder(radius: f64, low: f64, high: f64, colour: [u8; 3]) -> Shape {
    turned(&[(radius, low), (radius, high)], 48, colour)
}

fn paint(vertices: Vec<DVec3>, faces: Vec<[u32; 3]>, [r, g, b]: [u8; 3]) -> Shape {
    let colours = vec![[r, g, b, 255]; vertices.len()];
    Shape { vertices, faces, colours }
}
