//! Fewer faces for the same skin, as generators deliver it.

use meshopt::{SimplifyOptions, simplify_decoder};
use object::DVec3;

/// How far collapses may move the surface, as shares of its longest side: no more than is needed.
const ERRORS: [f32; 3] = [0.001, 0.005, 0.02];

/// At most about `most` faces over the same surface, as far as that is possible without moving it far
/// (quadric error metrics, Garland and Heckbert 1997); vertices that no face has any more are left out.
pub(super) fn decimated(
    vertices: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    most: usize,
) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    if faces.len() <= most {
        return (vertices, faces);
    }
    let low = vertices.iter().copied().reduce(DVec3::min).unwrap_or_default();
    let high = vertices.iter().copied().reduce(DVec3::max).unwrap_or_default();
    let unit = (high - low).max_element().max(f64::MIN_POSITIVE);
    let positions: Vec<[f32; 3]> =
        vertices.iter().map(|v| ((*v - low) / unit).as_vec3().to_array()).collect();
    let mut indices = faces.concat();
    for error in ERRORS {
        if indices.len() > 3 * most {
            let options = SimplifyOptions::None;
            let fewer = simplify_decoder(&indices, &positions, 3 * most, error, options, None);
            indices = if fewer.is_empty() { indices } else { fewer };
        }
    }
    compact(&vertices, &indices)
}

/// The vertices that faces have, in the order of faces, and the faces over them.
fn compact(vertices: &[DVec3], indices: &[u32]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (mut now, mut kept) = (vec![u32::MAX; vertices.len()], Vec::new());
    let mut place = |v: u32| {
        let new = &mut now[v as usize];
        if *new == u32::MAX {
            *new = kept.len() as u32;
            kept.push(vertices[v as usize]);
        }
        *new
    };
    let faces = indices.chunks_exact(3).map(|f| [place(f[0]), place(f[1]), place(f[2])]).collect();
    (kept, faces)
}
