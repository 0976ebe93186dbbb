//! Fewer faces for the same surface.

use meshopt::{SimplifyOptions, simplify_decoder};

use crate::DVec3;
use crate::mesh::{Mesh, MeshError};

/// Collapses may move the surface by this share of its largest extent, tried in turn.
const ERRORS: [f32; 3] = [0.005, 0.02, 0.1];

/// What triangles are left as.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Triangles {
    /// As they fall where the surface moves least: long and thin on what is flat.
    #[default]
    Any,
    /// Somewhat more even than that, for a somewhat larger error.
    Even,
}

/// The mesh with about `target` faces where it has more, chosen so that the surface moves least (quadric
/// error metrics, Garland and Heckbert 1997), as far as that moves it no farther than a tenth of its
/// largest extent. Open borders stay where they are, and vertices without a face are left out.
///
/// # Errors
/// [`MeshError`] where no faces are left.
pub fn simpler(mesh: &Mesh, target: usize, triangles: Triangles) -> Result<Mesh, MeshError> {
    let bounds = mesh.bounds();
    let unit = bounds.size().max_element();
    let relative = |v: &DVec3| ((*v - bounds.min) / unit).as_vec3().to_array();
    let positions: Vec<[f32; 3]> = mesh.vertices().iter().map(relative).collect();
    let mut indices: Vec<u32> = mesh.faces().iter().flatten().copied().collect();
    let options = match triangles {
        Triangles::Any => SimplifyOptions::LockBorder,
        Triangles::Even => SimplifyOptions::LockBorder | SimplifyOptions::RegularizeLight,
    };
    for error in ERRORS {
        if indices.len() / 3 > target {
            let fewer = simplify_decoder(&indices, &positions, 3 * target, error, options, None);
            indices = if fewer.is_empty() { indices } else { fewer };
        }
    }
    let faces: Vec<[u32; 3]> = indices.chunks_exact(3).map(|f| [f[0], f[1], f[2]]).collect();
    let all = Mesh::new(mesh.vertices().to_vec(), faces)?.with_frame(mesh.frame());
    let all = all.with_colours(mesh.colours().map(<[_]>::to_vec))?;
    let count = all.faces().len();
    all.submesh(0..count)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A closed ball of n × 2n quads, poles closed by fans.
    fn ball(n: u32) -> Mesh {
        let m = 2 * n;
        let ring = |i: u32| {
            (0..m).map(move |j| {
                let (polar, around) = (
                    std::f64::consts::PI * f64::from(i) / f64::from(n),
                    std::f64::consts::TAU * f64::from(j) / f64::from(m),
                );
                DVec3::new(polar.sin() * around.cos(), polar.sin() * around.sin(), polar.cos())
            })
        };
        let mut vertices: Vec<_> = (1..n).flat_map(ring).collect();
        vertices.extend([DVec3::Z, DVec3::NEG_Z]);
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

    #[test]
    fn even_triangles_are_nearer_to_equilateral() {
        let fine = ball(40).map_vertices(|v| v * DVec3::new(3.0, 1.0, 0.3)).unwrap();
        let shape = |triangles| {
            let mesh = simpler(&fine, fine.faces().len() / 4, triangles).unwrap();
            let one = |f: usize| {
                let [a, b, c] = mesh.corners(f);
                let sides = [b - a, c - b, a - c].map(|e| e.length_squared()).iter().sum::<f64>();
                mesh.area(f) / sides
            };
            (0..mesh.faces().len()).map(one).sum::<f64>() / mesh.faces().len() as f64
        };
        assert!(shape(Triangles::Even) > shape(Triangles::Any));
    }

    #[test]
    fn a_ball_with_a_tenth_of_its_faces_is_still_a_closed_ball() {
        let fine = ball(40);
        for triangles in [Triangles::Any, Triangles::Even] {
            let coarse = simpler(&fine, fine.faces().len() / 10, triangles).unwrap();
            assert!(coarse.faces().len() <= fine.faces().len() / 10);
            assert!((coarse.signed_volume() / fine.signed_volume() - 1.0).abs() < 0.03);
            assert_eq!(coarse, simpler(&fine, fine.faces().len() / 10, triangles).unwrap());
        }
    }
}
