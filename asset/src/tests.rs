//! Small bodies with known volume and inertia, shared by the tests of this crate.

use glamx::DVec3;
use object::Mesh;

/// A closed block of 12 outward triangles.
pub(crate) fn block(size: DVec3, centre: DVec3) -> Mesh {
    let corner = |i: u32| {
        let sign = |bit: u32| if i >> bit & 1 == 1 { 0.5 } else { -0.5 };
        centre + size * DVec3::new(sign(0), sign(1), sign(2))
    };
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    Mesh::new((0..8).map(corner).collect(), faces).unwrap()
}

/// A closed upright cylinder around the origin, `n` sides.
pub(crate) fn cylinder(radius: f64, height: f64, n: u32) -> Mesh {
    let ring = |z: f64| {
        (0..n).map(move |i| {
            let a = std::f64::consts::TAU * f64::from(i) / f64::from(n);
            DVec3::new(radius * a.cos(), radius * a.sin(), z)
        })
    };
    let mut vertices: Vec<_> = ring(-height / 2.0).chain(ring(height / 2.0)).collect();
    vertices.extend([DVec3::Z * (-height / 2.0), DVec3::Z * (height / 2.0)]);
    let side = |i: u32| {
        let j = (i + 1) % n;
        [[i, j, n + j], [i, n + j, n + i], [2 * n, j, i], [2 * n + 1, n + i, n + j]]
    };
    Mesh::new(vertices, (0..n).flat_map(side).collect()).unwrap()
}

/// Several surfaces as one mesh, vertices kept apart.
pub(crate) fn joined(meshes: &[Mesh]) -> Mesh {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for m in meshes {
        let base = vertices.len() as u32;
        vertices.extend_from_slice(m.vertices());
        faces.extend(m.faces().iter().map(|f| f.map(|v| v + base)));
    }
    Mesh::new(vertices, faces).unwrap()
}

/// The same surface with every face turned over.
pub(crate) fn reversed(mesh: &Mesh) -> Mesh {
    let faces = mesh.faces().iter().map(|&[a, b, c]| [a, c, b]).collect();
    Mesh::new(mesh.vertices().to_vec(), faces).unwrap()
}
