//! Meshes as a screen needs them: each point once, and no more faces than it can draw at ease.

use std::collections::BTreeMap;

use object::Mesh;
use object::simplify::{Triangles, simpler};

/// Most faces of what is seen, of all links together; a guess at what a phone turns smoothly.
pub const MOST_FACES: usize = 200_000;
/// Most faces of what is touched, of all links together.
const MOST_COLLIDERS: usize = 60_000;

/// Meshes of one kind for the screen, and how many faces they had where some had to go.
pub(crate) struct Lean {
    pub meshes: Vec<Option<Mesh>>,
    pub fewer: Option<[usize; 2]>,
}

/// What is seen.
pub(crate) fn seen<'a>(meshes: impl Iterator<Item = Option<&'a Mesh>>) -> Lean {
    lean(meshes.collect(), MOST_FACES)
}

/// What is touched.
pub(crate) fn touched<'a>(meshes: impl Iterator<Item = Option<&'a Mesh>>) -> Lean {
    lean(meshes.collect(), MOST_COLLIDERS)
}

fn lean(meshes: Vec<Option<&Mesh>>, most: usize) -> Lean {
    let count = |m: &Mesh| m.faces().len();
    let had: usize = meshes.iter().flatten().map(|m| count(m)).sum();
    if had <= most {
        return Lean {
            meshes: meshes.into_iter().map(Option::<&Mesh>::cloned).collect(),
            fewer: None,
        };
    }
    let one = |mesh: &Mesh| {
        let target = count(mesh) as f64 * most as f64 / had as f64;
        let welded = welded(mesh);
        simpler(&welded, target.ceil() as usize, Triangles::Any).unwrap_or(welded)
    };
    let meshes: Vec<_> = meshes.into_iter().map(|m| m.map(one)).collect();
    let has = meshes.iter().flatten().map(count).sum();
    Lean { meshes, fewer: Some([had, has]) }
}

/// The same surface with each point of one colour once: what was split for its shading is one again.
fn welded(mesh: &Mesh) -> Mesh {
    let mut known = BTreeMap::new();
    let (mut vertices, mut colours, mut new) = (Vec::new(), Vec::new(), Vec::new());
    for (i, v) in mesh.vertices().iter().enumerate() {
        let colour = mesh.colours().and_then(|c| c.get(i).copied());
        let key = ((*v + glamx::DVec3::ZERO).to_array().map(f64::to_bits), colour);
        let index = *known.entry(key).or_insert_with(|| {
            vertices.push(*v);
            colours.extend(colour);
            vertices.len() as u32 - 1
        });
        new.push(index);
    }
    let corner = |v: u32| new.get(v as usize).copied().unwrap_or_default();
    let faces = mesh.faces().iter().map(|f| f.map(corner));
    let faces = faces.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    let built = Mesh::new(vertices, faces).ok();
    let colours = mesh.colours().map(|_| colours);
    built.and_then(|m| m.with_colours(colours).ok()).unwrap_or_else(|| mesh.clone())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pack::tests::ball;

    #[test]
    fn what_is_too_fine_is_thinned_and_said_so() {
        let fine = ball(250, 1.0);
        let faces = fine.faces().len();
        let all = seen([Some(&fine), None].into_iter());
        let [had, has] = all.fewer.unwrap();
        assert!(had == faces && faces > MOST_FACES && has <= MOST_FACES, "{had} {has}");
        assert!(has > MOST_FACES / 2 && all.meshes[1].is_none());
    }

    #[test]
    fn what_was_split_for_its_shading_can_be_thinned_too() {
        let fine = ball(30, 1.0);
        let corners: Vec<_> = (0..fine.faces().len()).map(|f| fine.corners(f)).collect();
        let soup = Mesh::of_triangles(&corners).unwrap();
        assert_eq!(welded(&soup).vertices().len(), fine.vertices().len());
        let thin = lean(vec![Some(&soup)], 1000);
        assert!(thin.fewer.unwrap()[1] <= 1000);
    }
}
