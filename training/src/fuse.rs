//! An object as one closed skin, the way generators deliver meshes, with labels carried over.
//!
//! The distance to the surface is laid on a grid; what cannot be reached from outside counts as
//! inside; the skin is drawn where the distance is a little more than half a cell (naive surface
//! nets, Gibson 1998). Rooms that are shut stay shut, and parts that lie in them are lost. What has more
//! faces than are wanted is then decimated.

mod field;
mod nets;

use object::articulated::ObjectError;
use object::kinematics::TreeError;
use object::mesh::MeshError;
use object::simplify::simpler;
use object::weld::{nearest_face, nearest_on_triangle};
use object::{ArticulatedObject, DVec3, JointMotion, Mesh};

use crate::dataset::Specimen;
use field::Field;

/// Why an object cannot be fused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FuseError {
    /// The skin.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// What is left of the tree.
    #[error(transparent)]
    Tree(#[from] TreeError),
    /// What is left of the object.
    #[error(transparent)]
    Object(#[from] ObjectError),
    /// Too coarse or too fine a grid.
    #[error("a skin needs between 8 and 256 cells along its longest side, found {0}")]
    Cells(usize),
    /// Parts no face of the skin belongs to.
    #[error("only {left} of {parts} parts can be seen from outside")]
    Hidden {
        /// Parts that are left.
        left: usize,
        /// Parts there were.
        parts: usize,
    },
}

/// The specimen as one skin over a grid with this many cells along its longest side, of at most about
/// `most` faces. Parts that nothing of the skin lies near are left out; what hung on them hangs on their
/// parents.
///
/// # Errors
/// [`FuseError`], also when fewer than two parts, or less than half of them, are left.
pub fn fused(specimen: &Specimen, cells: usize, most: usize) -> Result<Specimen, FuseError> {
    if !(8..=256).contains(&cells) {
        return Err(FuseError::Cells(cells));
    }
    let object = &specimen.object;
    let field = Field::of(object.mesh(), cells);
    let (vertices, faces) = nets::surface(&field);
    let mesh = Mesh::new(vertices, faces)?.with_frame(object.mesh().frame());
    let mesh = if mesh.faces().len() > most { simpler(&mesh, most)? } else { mesh };
    let labels = (0..mesh.faces().len()).map(|f| label(object, &field, mesh.corners(f)));
    let labels: Vec<u16> = labels.collect();
    keep_seen(specimen, mesh, &labels)
}

/// The part of the surface nearest the middle of a face of the skin; a face may be so large that its
/// middle is near no node that knows the surface.
fn label(object: &ArticulatedObject, field: &Field, corners: [DVec3; 3]) -> u16 {
    let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
    let near = field.faces_near(middle);
    let distance = |&face: &u32| {
        let at = nearest_on_triangle(middle, object.mesh().corners(face as usize));
        (at - middle).length_squared()
    };
    let nearest = near.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let face = nearest.map_or_else(|| nearest_face(object.mesh(), middle).0, |&f| f as usize);
    object.part_of_face()[face]
}

fn keep_seen(specimen: &Specimen, mesh: Mesh, labels: &[u16]) -> Result<Specimen, FuseError> {
    let object = &specimen.object;
    let parts = object.tree().len();
    let mut lost = vec![true; parts];
    labels.iter().for_each(|&l| lost[usize::from(l)] = false);
    let left = lost.iter().filter(|l| !**l).count();
    if left < parts.min(2) || 2 * left < parts {
        return Err(FuseError::Hidden { left, parts });
    }
    let (tree, new) = object.tree().without(&lost)?;
    let mut joints: Vec<Vec<JointMotion>> = vec![vec![]; tree.len()];
    let mut wordings = vec![vec![]; tree.len()];
    for (old, new) in new.iter().enumerate() {
        if let &Some(new) = new {
            let kinds = tree.parts()[new].joints.len();
            joints[new] = object.joints(old)[..kinds.min(object.joints(old).len())].to_vec();
            wordings[new] = specimen.wordings[old].clone();
        }
    }
    let labels = labels.iter().map(|&l| new[usize::from(l)].unwrap_or(0) as u16).collect();
    let object = ArticulatedObject::new(mesh, tree, labels, joints)?;
    Ok(Specimen { id: specimen.id.clone(), object, wordings })
}

#[cfg(test)]
mod tests {
    use object::weld::Weld;

    use super::*;
    use crate::procedural::generate;

    /// The first family: a cabinet with a drawer and a door.
    fn cabinet() -> Specimen {
        generate(0, 0).unwrap()
    }

    #[test]
    fn the_skin_is_closed_in_one_piece_and_lies_close_outside() {
        let (cabinet, cells) = (cabinet(), 60);
        let skin = fused(&cabinet, cells, usize::MAX).unwrap();
        let mesh = skin.object.mesh();
        let weld = Weld::new(mesh);
        let mut edges = std::collections::BTreeMap::<[u32; 2], i32>::new();
        for f in &weld.faces {
            for (a, b) in [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])] {
                *edges.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
            }
        }
        assert!(edges.values().all(|&n| n == 0), "every edge both ways");
        assert!(mesh.signed_volume() > 0.0, "faces look outward");
        let cell = cabinet.object.mesh().bounds().size().max_element() / cells as f64;
        for v in mesh.vertices().iter().step_by(41) {
            let (_, apart) = nearest_face(cabinet.object.mesh(), *v);
            assert!(apart < 1.3 * cell, "{apart} of {cell}");
        }
    }

    #[test]
    fn with_fewer_faces_it_is_the_same_skin() {
        let cabinet = cabinet();
        let [fine, coarse] = [usize::MAX, 3000].map(|most| fused(&cabinet, 60, most).unwrap());
        let [fine, coarse] = [&fine, &coarse].map(|s| s.object.mesh());
        assert!(coarse.faces().len() <= 3000 && fine.faces().len() > 6000);
        assert!((coarse.signed_volume() / fine.signed_volume() - 1.0).abs() < 0.005);
        assert!(coarse.vertices().len() * 2 <= coarse.faces().len() + 8, "closed, no vertex alone");
    }

    #[test]
    fn labels_and_joints_are_carried_over() {
        let cabinet = cabinet();
        let skin = fused(&cabinet, 60, usize::MAX).unwrap();
        assert_eq!(skin.object.tree(), cabinet.object.tree());
        assert_eq!(skin.object.joints(2), cabinet.object.joints(2));
        let mesh = skin.object.mesh();
        let (mut right, mut all) = (0, 0);
        for (face, &label) in skin.object.part_of_face().iter().enumerate().step_by(97) {
            let (near, _) = nearest_face(cabinet.object.mesh(), mesh.centroid(face));
            right += usize::from(cabinet.object.part_of_face()[near] == label);
            all += 1;
        }
        assert!(right * 50 >= all * 49, "only seams are open to doubt: {right} of {all}");
    }

    #[test]
    fn a_part_shut_in_is_left_out_and_the_rest_closes_up() {
        let mut cabinet = cabinet();
        let object = &cabinet.object;
        let mesh = object.mesh();
        let middle = object.mesh().bounds().centre();
        let hidden: std::collections::BTreeSet<u32> =
            object.faces_of(1).flat_map(|f| mesh.faces()[f]).collect();
        let vertices = mesh.vertices().iter().enumerate().map(|(i, &v)| {
            if hidden.contains(&(i as u32)) { middle + (v - middle) * 0.05 } else { v }
        });
        let mesh = Mesh::new(vertices.collect(), mesh.faces().to_vec()).unwrap();
        let joints = (0..3).map(|p| object.joints(p).to_vec()).collect();
        let labels = object.part_of_face().to_vec();
        cabinet.object =
            ArticulatedObject::new(mesh, object.tree().clone(), labels, joints).unwrap();
        let skin = fused(&cabinet, 60, usize::MAX);
        if let Ok(skin) = skin {
            assert_eq!(skin.wordings.len(), skin.object.tree().len());
        }
        assert_eq!(fused(&cabinet, 3, usize::MAX).unwrap_err(), FuseError::Cells(3));
    }
}
