//! Naive surface nets: one vertex in every cell the skin passes, one quad across every grid edge it
//! cuts.

use object::DVec3;

use super::field::Field;

/// The four cells around an edge along each axis, seen against the axis, as steps down the two
/// other axes.
const AROUND: [[usize; 2]; 4] = [[1, 1], [0, 1], [0, 0], [1, 0]];

/// Vertices and outward triangles of the skin.
pub(super) fn surface(field: &Field) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let size = field.size();
    let mut vertex_of = vec![u32::MAX; size.iter().product()];
    let mut vertices = Vec::new();
    for cell in nodes(size.map(|n| n - 1)) {
        if let Some(vertex) = crossing(field, cell) {
            vertex_of[field.index(cell)] = vertices.len() as u32;
            vertices.push(vertex);
        }
    }
    let mut faces = Vec::new();
    for node in nodes(size) {
        for axis in 0..3 {
            quad(field, node, axis, &vertex_of, &mut faces);
        }
    }
    (vertices, faces)
}

fn nodes([x, y, z]: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..z).flat_map(move |k| (0..y).flat_map(move |j| (0..x).map(move |i| [i, j, k])))
}

/// The mean of the points where the skin cuts the edges of a cell.
fn crossing(field: &Field, cell: [usize; 3]) -> Option<DVec3> {
    let corner = |c: usize| std::array::from_fn(|i| cell[i] + (c >> i & 1));
    let (mut sum, mut count) = (DVec3::ZERO, 0.0);
    for c in 0..8usize {
        for axis in (0..3).filter(|axis| c >> axis & 1 == 0) {
            let [a, b] = [corner(c), corner(c | 1 << axis)];
            let [va, vb] = [a, b].map(|n| field.value(n));
            if (va < 0.0) != (vb < 0.0) {
                let [pa, pb] = [a, b].map(|n| field.position(n));
                sum += pa + (pb - pa) * (va / (va - vb));
                count += 1.0;
            }
        }
    }
    (count > 0.0).then(|| sum / count)
}

/// Two triangles across the edge from a node along an axis, if the skin cuts it.
fn quad(
    field: &Field,
    node: [usize; 3],
    axis: usize,
    vertex_of: &[u32],
    faces: &mut Vec<[u32; 3]>,
) {
    let (size, [u, v]) = (field.size(), [(axis + 1) % 3, (axis + 2) % 3]);
    let mut end = node;
    end[axis] += 1;
    if end[axis] >= size[axis] || node[u] == 0 || node[v] == 0 {
        return;
    }
    let (inside, beyond) = (field.value(node) < 0.0, field.value(end) < 0.0);
    if inside == beyond {
        return;
    }
    let corner = |[du, dv]: [usize; 2]| {
        let mut cell = node;
        (cell[u], cell[v]) = (node[u] - du, node[v] - dv);
        vertex_of[field.index(cell)]
    };
    let [a, b, c, d] = AROUND.map(corner);
    if inside {
        faces.extend([[a, b, c], [a, c, d]]);
    } else {
        faces.extend([[a, c, b], [a, d, c]]);
    }
}
