//! Brings an object within its budget of faces, part by part, so that each keeps its share.

use meshopt::{SimplifyOptions, simplify_decoder};
use object::mesh::MeshError;
use object::{ArticulatedObject, Mesh};

use crate::build::{AssetError, motions, whole_surface};
use crate::change::Change;

/// Most faces of all visuals together (G1 of the profile).
pub(crate) const FACE_BUDGET: usize = 48_000;
/// Parts with fewer faces are left alone.
const SMALL: usize = 200;
/// Collapses may move the surface by this share of the part's largest extent, tried in turn.
const ERRORS: [f32; 3] = [0.005, 0.02, 0.1];
const WHY: &str = "the visuals of an asset have at most 50,000 faces (G1)";

/// The object with at most `budget` faces, as far as its parts can be simplified without
/// moving far; borders of parts stay where they are.
pub(crate) fn simplified(
    object: ArticulatedObject,
    budget: usize,
) -> Result<(ArticulatedObject, Vec<Change>), AssetError> {
    let total = object.mesh().faces().len();
    if total <= budget {
        return Ok((object, Vec::new()));
    }
    let parts = object.tree().len();
    let counts: Vec<usize> = (0..parts).map(|p| object.faces_of(p).count()).collect();
    let small: usize = counts.iter().filter(|&&c| c <= SMALL).sum();
    let share = budget.saturating_sub(small) as f64 / (total - small).max(1) as f64;
    let (mut meshes, mut changes) = (Vec::new(), Vec::new());
    for (part, &count) in counts.iter().enumerate() {
        let mesh = object.mesh().submesh(object.faces_of(part)).map_err(whole_surface)?;
        if count <= SMALL {
            meshes.push(mesh);
            continue;
        }
        let simpler = simpler(&mesh, (count as f64 * share) as usize).map_err(whole_surface)?;
        let faces = |n: usize| format!("{n} faces");
        let (before, after) = (faces(count), faces(simpler.faces().len()));
        changes.push(Change::new(&object.tree().parts()[part].name, "faces", before, after, WHY));
        meshes.push(simpler);
    }
    let (mesh, labels) = joined(&meshes.iter().collect::<Vec<_>>()).map_err(whole_surface)?;
    let object = ArticulatedObject::new(mesh, object.tree().clone(), labels, motions(&object))?;
    Ok((object, changes))
}

/// A mesh with about `target` faces, chosen so that the surface moves least.
fn simpler(mesh: &Mesh, target: usize) -> Result<Mesh, MeshError> {
    let bounds = mesh.bounds();
    let unit = bounds.size().max_element();
    let relative = |v: &glamx::DVec3| ((*v - bounds.min) / unit).as_vec3().to_array();
    let positions: Vec<[f32; 3]> = mesh.vertices().iter().map(relative).collect();
    let mut indices: Vec<u32> = mesh.faces().iter().flatten().copied().collect();
    for error in ERRORS {
        if indices.len() > 3 * target {
            let options = SimplifyOptions::LockBorder;
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

/// Meshes one after the other, and for each face the mesh it comes from.
pub(crate) fn joined(meshes: &[&Mesh]) -> Result<(Mesh, Vec<u16>), MeshError> {
    let (mut vertices, mut colours) = (Vec::new(), Vec::new());
    let (mut faces, mut labels) = (Vec::new(), Vec::new());
    for (label, mesh) in meshes.iter().enumerate() {
        let first = vertices.len() as u32;
        vertices.extend_from_slice(mesh.vertices());
        colours.extend(mesh.colours().into_iter().flatten().copied());
        faces.extend(mesh.faces().iter().map(|f| f.map(|v| v + first)));
        labels.extend(mesh.faces().iter().map(|_| label as u16));
    }
    let colours = (colours.len() == vertices.len()).then_some(colours);
    Ok((Mesh::new(vertices, faces)?.with_colours(colours)?, labels))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glamx::DVec3;

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
    fn a_ball_with_a_tenth_of_its_faces_is_still_a_closed_ball() {
        let fine = ball(40);
        let coarse = simpler(&fine, fine.faces().len() / 10).unwrap();
        assert!(coarse.faces().len() <= fine.faces().len() / 10);
        assert!((coarse.signed_volume() / fine.signed_volume() - 1.0).abs() < 0.03);
        assert_eq!(coarse, simpler(&fine, fine.faces().len() / 10).unwrap());
    }
}
