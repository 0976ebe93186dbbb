//! Brings an object within its budget of faces, part by part, so that each keeps its share.

use object::mesh::MeshError;
use object::simplify::{Triangles, simpler};
use object::{ArticulatedObject, Mesh};

use crate::change::Change;
use crate::error::{AssetError, whole_surface};

/// Most faces of all visuals together (G1 of the profile).
pub(crate) const FACE_BUDGET: usize = 48_000;
/// Parts with fewer faces are left alone.
const SMALL: usize = 200;
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
        let wanted = (count as f64 * share) as usize;
        let simpler = simpler(&mesh, wanted, Triangles::Any).map_err(whole_surface)?;
        let faces = |n: usize| format!("{n} faces");
        let (before, after) = (faces(count), faces(simpler.faces().len()));
        changes.push(Change::new(&object.tree().parts()[part].name, "faces", before, after, WHY));
        meshes.push(simpler);
    }
    let (mesh, labels) = joined(&meshes.iter().collect::<Vec<_>>()).map_err(whole_surface)?;
    let object = object.with_surface(mesh, labels)?;
    Ok((object, changes))
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
    use crate::tests::{block, cylinder};
    use glamx::DVec3;
    use object::{KinematicTree, Part};

    #[test]
    fn meshes_are_joined_in_order_and_labelled() {
        let (a, b) = (block(DVec3::ONE, DVec3::ZERO), block(DVec3::ONE, DVec3::X * 5.0));
        let (mesh, labels) = joined(&[&a, &b]).unwrap();
        assert_eq!((mesh.vertices().len(), mesh.faces().len()), (16, 24));
        assert_eq!(labels, [[0; 12], [1; 12]].concat());
        assert!((mesh.signed_volume() - 2.0).abs() < 1e-12);
    }

    #[test]
    fn only_large_parts_give_up_faces_and_say_so() {
        let (knob, drum) = (block(DVec3::ONE, DVec3::X * 3.0), cylinder(1.0, 1.0, 400));
        let (mesh, labels) = joined(&[&drum, &knob]).unwrap();
        let part = |name: &str, parent| Part {
            name: name.into(),
            text: name.into(),
            parent,
            joints: vec![],
        };
        let tree = KinematicTree::new(vec![part("drum", None), part("knob", Some(0))]).unwrap();
        let object = ArticulatedObject::new(mesh, tree, labels, vec![vec![], vec![]]).unwrap();
        let (same, none) = simplified(object.clone(), 2000).unwrap();
        assert_eq!((same.mesh().faces().len(), none.len()), (1612, 0));
        let (less, changes) = simplified(object, 800).unwrap();
        assert!(less.mesh().faces().len() <= 800, "{}", less.mesh().faces().len());
        assert_eq!(less.faces_of(1).count(), 12);
        assert_eq!((changes.len(), changes[0].part.as_str()), (1, "drum"));
        assert_eq!(changes[0].before, "1600 faces");
    }
}
