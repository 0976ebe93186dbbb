//! Surfaces as few bytes: positions as 16-bit steps of the mesh's box, each as its difference from
//! the one before; corners by how long ago their point was first used.
//!
//! A mesh is, byte after byte: for each of x, y and z the low and then the high bytes of its
//! differences (zigzag); for each of red, green and blue its differences, where it has colours of its
//! own; then its corners as LEB128 numbers: the count of points so far minus the index, 0 for a new one.

use std::collections::BTreeMap;

use glamx::DVec3;
use object::Mesh;
use serde::Serialize;

/// Steps along each side of a mesh's box.
const STEPS: f64 = 65_535.0;

/// Where a mesh lies among the packed bytes, and what it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Packed {
    /// First byte.
    pub at: usize,
    pub vertices: usize,
    pub faces: usize,
    /// The smallest corner of its box, metres.
    pub low: [f32; 3],
    /// The sides of its box, metres.
    pub size: [f32; 3],
    /// The colour of all of it, where that is one; its vertices have their own otherwise.
    pub colour: Option<[u8; 3]>,
}

/// A point after rounding, and its colour.
type Point = ([u16; 3], [u8; 3]);

/// Packs a mesh behind what is packed already. `plain` is the colour of a mesh without any.
pub(crate) fn pack(bytes: &mut Vec<u8>, mesh: &Mesh, plain: [u8; 3]) -> Packed {
    let bounds = mesh.bounds();
    let at = bytes.len();
    let (points, corners) = rounded(mesh, plain);
    let first = points.first().map_or(plain, |p| p.1);
    let colour = points.iter().all(|p| p.1 == first).then_some(first);
    for axis in 0..3 {
        differences(bytes, points.iter().map(|p| p.0[axis]));
    }
    if colour.is_none() {
        for channel in 0..3 {
            let values = points.iter().map(|p| p.1[channel]);
            let mut before = 0u8;
            bytes.extend(values.map(|v| v.wrapping_sub(std::mem::replace(&mut before, v))));
        }
    }
    let mut known = 0u32;
    for corner in &corners {
        number(bytes, known - corner);
        known = known.max(corner + 1);
    }
    let narrow = |v: DVec3| v.to_array().map(|x| x as f32);
    let (low, size) = (narrow(bounds.min), narrow(bounds.size()));
    Packed { at, vertices: points.len(), faces: corners.len() / 3, low, size, colour }
}

/// Points in the order of their first use, each once, and three corners a face; faces that rounding
/// left without area are left out.
fn rounded(mesh: &Mesh, plain: [u8; 3]) -> (Vec<Point>, Vec<u32>) {
    let bounds = mesh.bounds();
    let scale = bounds.size().to_array().map(|s| if s > 0.0 { STEPS / s } else { 0.0 });
    let scale = DVec3::from_array(scale);
    let step = |v: &DVec3| ((*v - bounds.min) * scale).to_array().map(|x| x.round() as u16);
    let steps: Vec<[u16; 3]> = mesh.vertices().iter().map(step).collect();
    let colour = |v: usize| match mesh.colours() {
        Some(colours) => colours.get(v).map_or(plain, |&[r, g, b, _]| [r, g, b]),
        None => plain,
    };
    let mut known: BTreeMap<Point, u32> = BTreeMap::new();
    let (mut points, mut corners) = (Vec::new(), Vec::new());
    for face in mesh.faces() {
        let all =
            face.map(|v| (steps.get(v as usize).copied().unwrap_or_default(), colour(v as usize)));
        let [a, b, c] = all.map(|p| p.0);
        if a == b || b == c || c == a {
            continue;
        }
        for point in all {
            corners.push(*known.entry(point).or_insert_with(|| {
                points.push(point);
                points.len() as u32 - 1
            }));
        }
    }
    (points, corners)
}

/// Low bytes of all differences, then their high bytes.
fn differences(bytes: &mut Vec<u8>, values: impl Iterator<Item = u16>) {
    let mut before = 0u16;
    let zigzag = |v: u16| {
        let d = v.wrapping_sub(std::mem::replace(&mut before, v)) as i16;
        ((d << 1) ^ (d >> 15)) as u16
    };
    let all: Vec<[u8; 2]> = values.map(zigzag).map(u16::to_le_bytes).collect();
    bytes.extend(all.iter().map(|b| b[0]));
    bytes.extend(all.iter().map(|b| b[1]));
}

/// LEB128.
fn number(bytes: &mut Vec<u8>, mut value: u32) {
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A closed ball of n × 2n quads, poles closed by fans.
    pub(crate) fn ball(n: u32, radius: f64) -> Mesh {
        let m = 2 * n;
        let ring = |i: u32| {
            (0..m).map(move |j| {
                let polar = std::f64::consts::PI * f64::from(i) / f64::from(n);
                let around = std::f64::consts::TAU * f64::from(j) / f64::from(m);
                let (s, c) = polar.sin_cos();
                DVec3::new(s * around.cos(), s * around.sin(), c) * radius
            })
        };
        let mut vertices: Vec<_> = (1..n).flat_map(ring).collect();
        vertices.extend([DVec3::Z * radius, DVec3::NEG_Z * radius]);
        let (top, bottom) = (vertices.len() as u32 - 2, vertices.len() as u32 - 1);
        let at = |i: u32, j: u32| i * m + j % m;
        let mut faces = Vec::new();
        for j in 0..m {
            faces.extend([[top, at(0, j), at(0, j + 1)], [bottom, at(n - 2, j + 1), at(n - 2, j)]]);
            for i in 0..n - 2 {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                faces.extend([[a, b, c], [a, c, d]]);
            }
        }
        Mesh::new(vertices, faces).unwrap()
    }

    /// What the page's `decode.js` does.
    fn unpacked(bytes: &[u8], packed: &Packed) -> (Vec<[f64; 3]>, Vec<u32>) {
        let (n, mut at) = (packed.vertices, packed.at);
        let mut points = vec![[0.0; 3]; n];
        for axis in 0..3 {
            let mut value = 0u16;
            for (i, point) in points.iter_mut().enumerate() {
                let z = u16::from_le_bytes([bytes[at + i], bytes[at + n + i]]);
                value = value.wrapping_add((z >> 1) ^ (z & 1).wrapping_neg());
                let (low, size) = (f64::from(packed.low[axis]), f64::from(packed.size[axis]));
                point[axis] = low + size * f64::from(value) / STEPS;
            }
            at += 2 * n;
        }
        at += if packed.colour.is_none() { 3 * n } else { 0 };
        let (mut corners, mut known) = (Vec::new(), 0u32);
        while corners.len() < 3 * packed.faces {
            let (mut value, mut shift) = (0, 0);
            loop {
                let byte = bytes[at];
                at += 1;
                value |= u32::from(byte & 0x7f) << shift;
                shift += 7;
                if byte < 0x80 {
                    break;
                }
            }
            corners.push(known - value);
            known = known.max(known - value + 1);
        }
        (points, corners)
    }

    #[test]
    fn a_packed_surface_comes_back_within_a_step() {
        let ball = ball(12, 0.3).map_vertices(|v| v * DVec3::new(1.0, 2.0, 0.5)).unwrap();
        let mut bytes = vec![7; 3];
        let packed = pack(&mut bytes, &ball, [1, 2, 3]);
        let (points, corners) = unpacked(&bytes, &packed);
        assert_eq!(
            (packed.at, packed.faces, packed.colour),
            (3, ball.faces().len(), Some([1, 2, 3]))
        );
        for (face, corners) in ball.faces().iter().zip(corners.chunks(3)) {
            for (v, c) in face.iter().zip(corners) {
                let (was, is) = (ball.vertices()[*v as usize], points[*c as usize]);
                assert!((was - DVec3::from_array(is)).length() < 2.0 * 1.2 / STEPS);
            }
        }
    }

    #[test]
    fn colours_are_kept_where_they_differ_and_said_once_where_they_do_not() {
        let ball = ball(4, 1.0);
        let count = ball.vertices().len();
        let one = ball.clone().with_colours(Some(vec![[9, 8, 7, 255]; count])).unwrap();
        assert_eq!(pack(&mut vec![], &one, [0; 3]).colour, Some([9, 8, 7]));
        let many = (0..count).map(|i| [i as u8, 8, 7, 255]).collect();
        let many = ball.with_colours(Some(many)).unwrap();
        let mut bytes = Vec::new();
        assert_eq!(pack(&mut bytes, &many, [0; 3]).colour, None);
    }

    #[test]
    fn a_flat_face_and_a_face_without_area_do_no_harm() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X * (1.0 + 1e-9)];
        let mesh = Mesh::new(corners.into(), vec![[0, 1, 2], [0, 1, 3]]).unwrap();
        let mut bytes = Vec::new();
        let packed = pack(&mut bytes, &mesh, [0; 3]);
        assert_eq!((packed.vertices, packed.faces, packed.size[2]), (3, 1, 0.0));
    }
}
