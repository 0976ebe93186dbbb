//! An object as one closed skin, the way generators deliver meshes, with labels carried over.
//!
//! The distance to the surface is laid on a grid; what cannot be reached from outside counts as
//! inside; the skin is drawn at a distance of a little more than half a cell (naive surface nets,
//! Gibson 1998). Rooms that are shut stay shut, and parts that lie in them are lost. What has more
//! faces than are wanted is then decimated.

mod error;
mod field;
mod nets;
mod recipe;

use object::simplify::simpler;
use object::weld::{nearest_face, nearest_on_triangle};
use object::{ArticulatedObject, DVec3, JointMotion, Mesh};

use crate::dataset::Specimen;
pub use error::FuseError;
use field::Field;
pub use recipe::Recipe;

/// The specimen as one skin. Parts that nothing of the skin lies near are left out; what hung on them
/// hangs on their parents.
///
/// # Errors
/// [`FuseError`], also when fewer than two parts, or less than half of them, are left.
pub fn fused(specimen: &Specimen, recipe: &Recipe) -> Result<Specimen, FuseError> {
    recipe.check()?;
    let object = &specimen.object;
    let field = Field::of(object.mesh(), recipe);
    let (vertices, faces) = nets::surface(&field);
    let mesh = Mesh::new(vertices, faces)?.with_frame(object.mesh().frame());
    let mesh = if mesh.faces().len() > recipe.faces {
        simpler(&mesh, recipe.faces, recipe.triangles)?
    } else {
        mesh
    };
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
    use object::simplify::Triangles;
    use object::weld::Weld;

    use super::*;
    use crate::procedural::{Id, generate};

    /// The first family: a cabinet with a drawer and a door.
    fn cabinet() -> Specimen {
        generate(Id::new("cabinet", 0).unwrap(), 0).unwrap()
    }

    #[test]
    fn the_skin_is_closed_in_one_piece_and_lies_close_outside() {
        let (cabinet, cells) = (cabinet(), 60);
        let skin = fused(&cabinet, &Recipe::plain(cells)).unwrap();
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
        let [fine, coarse] = [usize::MAX, 3000]
            .map(|faces| fused(&cabinet, &Recipe { faces, ..Recipe::plain(60) }).unwrap());
        let [fine, coarse] = [&fine, &coarse].map(|s| s.object.mesh());
        assert!(coarse.faces().len() <= 3000 && fine.faces().len() > 6000);
        assert!((coarse.signed_volume() / fine.signed_volume() - 1.0).abs() < 0.005);
        assert!(coarse.vertices().len() * 2 <= coarse.faces().len() + 8, "closed, no vertex alone");
    }

    #[test]
    fn what_lies_farther_out_and_shuts_gaps_holds_more() {
        let cabinet = cabinet();
        let volume = |offset, clearance| {
            let skin = fused(&cabinet, &Recipe { offset, clearance, ..Recipe::plain(60) }).unwrap();
            skin.object.mesh().signed_volume()
        };
        let (near, far, shut) = (volume(0.55, 0.0), volume(0.85, 0.0), volume(0.85, 2.5));
        assert!(near < far && far < shut, "{near} {far} {shut}");
        let grown = cabinet.object.mesh().bounds().size() * (1.0 + 4.0 / 60.0);
        assert!(shut < grown.element_product(), "what is outside stays outside: {shut}");
    }

    #[test]
    fn recipes_are_read() {
        let read = |written: &str| written.parse::<Recipe>();
        assert_eq!(read("64"), Ok(Recipe::plain(64)));
        let triangles = Triangles::Even;
        let whole = Recipe { cells: 160, faces: 35_000, offset: 0.85, clearance: 1.5, triangles };
        assert_eq!(read("160:35000:0.85:1.5:even"), Ok(whole));
        for wrong in ["", "64:", "64:1:x", "64:1:1:1:odd", "64:1:1:1:even:1"] {
            assert_eq!(read(wrong), Err(FuseError::Recipe(wrong.into())));
        }
        assert_eq!(read("64:1:0.5"), Err(FuseError::Distances(0.5, 0.0)));
        assert_eq!(read("64:1:0.6:2.6"), Err(FuseError::Distances(0.6, 2.6)));
        assert_eq!(read("64:1:NaN").map_err(|e| e.to_string().len() > 20), Err(true));
        assert_eq!(read("4"), Err(FuseError::Cells(4)));
    }

    #[test]
    fn labels_and_joints_are_carried_over() {
        let cabinet = cabinet();
        let skin = fused(&cabinet, &Recipe::plain(60)).unwrap();
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
        cabinet.object = object.with_surface(mesh, object.part_of_face().to_vec()).unwrap();
        let skin = fused(&cabinet, &Recipe::plain(60));
        if let Ok(skin) = skin {
            assert_eq!(skin.wordings.len(), skin.object.tree().len());
        }
        assert_eq!(fused(&cabinet, &Recipe::plain(3)).unwrap_err(), FuseError::Cells(3));
    }
}
