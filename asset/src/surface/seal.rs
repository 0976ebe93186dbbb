//! Closes what is still open when everything else is done: a corner that stands on the edge of
//! another face is joined to it, and the borders that remain are filled.

use std::collections::{BTreeMap, BTreeSet};

use glamx::DVec3;
use object::Mesh;
use object::mesh::Bounds;
use object::weld::Weld;

use crate::surface::borders::{loops, surplus};
use crate::surface::polygon::triangles;
use crate::surface::repaired::is_flat;

/// A corner this close to an edge stands on it, as a share of the diagonal.
const ON_EDGE: f64 = 5e-6;
/// A lid lower than this share of the diagonal has no area to speak of.
pub(crate) const FLAT: f64 = 1e-8;
/// Most times that lids are laid.
const ROUNDS: usize = 4;
/// Most edges of borders that are looked at; a surface with more is no body with a few holes.
const MOST: usize = 5000;

/// The surface without borders; none if it has too many of them.
///
/// No vertex is added: lids lie on the borders' own.
pub(crate) fn sealed(mesh: &Mesh) -> Option<Mesh> {
    let weld = Weld::new(mesh);
    let diagonal = mesh.bounds().diagonal();
    let mut faces = mesh.faces().to_vec();
    for _ in 0..ROUNDS {
        faces = joined_to_edges(faces, &weld, diagonal)?;
        let (lids, is_whole) = lids(&faces, &weld)?;
        faces.extend(lids);
        if is_whole {
            return with_faces(mesh, faces);
        }
    }
    None
}

/// The surface with every corner of a border that stands on a border's edge joined to it; none if it
/// has more borders than a body with a few holes.
pub(crate) fn joined(mesh: &Mesh) -> Option<Mesh> {
    let weld = Weld::new(mesh);
    with_faces(mesh, joined_to_edges(mesh.faces().to_vec(), &weld, mesh.bounds().diagonal())?)
}

fn with_faces(mesh: &Mesh, faces: Vec<[u32; 3]>) -> Option<Mesh> {
    let new = Mesh::new(mesh.vertices().to_vec(), faces).ok()?.with_frame(mesh.frame());
    new.with_colours(mesh.colours().map(<[_]>::to_vec)).ok()
}

/// Faces over the borders of `faces`, and whether those are left without any; all hold vertices.
/// What would have no area is left out: its corners stand on the edge of another lid.
fn lids(faces: &[[u32; 3]], weld: &Weld) -> Option<(Vec<[u32; 3]>, bool)> {
    let place = |v: &u32| weld.place_of_vertex[*v as usize];
    let vertex_at: BTreeMap<u32, u32> = faces.iter().flatten().map(|v| (place(v), *v)).collect();
    let flat = Bounds::of(weld.places.iter().copied()).diagonal() * FLAT;
    let (mut lids, mut is_whole) = (Vec::new(), true);
    for border in loops(faces.iter().map(|f| f.map(|v| place(&v)))) {
        let points: Vec<DVec3> = border.iter().map(|&p| weld.places[p as usize]).collect();
        for lid in triangles(&points) {
            if is_flat(lid.map(|i| points[i]), flat) {
                is_whole = false;
                continue;
            }
            let [a, b, c] = lid.map(|i| vertex_at.get(&border[i]).copied());
            lids.push([a?, b?, c?]);
        }
    }
    Some((lids, is_whole))
}

/// The faces, cut wherever a corner of a border stands on a border's edge; none if there are too
/// many of them.
fn joined_to_edges(mut faces: Vec<[u32; 3]>, weld: &Weld, diagonal: f64) -> Option<Vec<[u32; 3]>> {
    let place = |v: u32| weld.place_of_vertex[v as usize];
    let mut open: BTreeSet<[u32; 2]> =
        surplus(faces.iter().map(|f| f.map(place))).into_keys().collect();
    if open.len() > MOST {
        return None;
    }
    let ends: BTreeSet<u32> = open.iter().flatten().copied().collect();
    let standing = faces.iter().flatten().filter(|v| ends.contains(&place(**v)));
    let corners: BTreeMap<u32, u32> = standing.map(|v| (place(*v), *v)).collect();
    let between = |[a, b, c]: [u32; 3]| {
        let (from, to) = (weld.places[place(a) as usize], weld.places[place(b) as usize]);
        let stands = |p: &u32| {
            let (along, off) = beside(weld.places[*p as usize], from, to);
            ![a, b, c].map(place).contains(p) && along && off <= ON_EDGE * diagonal
        };
        corners.iter().find_map(|(p, v)| stands(p).then_some(*v))
    };
    let mut face = 0;
    while face < faces.len() {
        let cut = (0..3).find_map(|side| {
            let [a, b, c] = [side, side + 1, side + 2].map(|i| faces[face][i % 3]);
            let middle = open.contains(&edge(place(a), place(b))).then(|| between([a, b, c]))??;
            Some([a, middle, b, c])
        });
        let Some([a, middle, b, c]) = cut else {
            face += 1;
            continue;
        };
        open.extend([edge(place(a), place(middle)), edge(place(middle), place(b))]);
        faces[face] = [a, middle, c];
        faces.push([middle, b, c]);
        if faces.len() > weld.faces.len() + 4 * MOST {
            return None;
        }
    }
    Some(faces)
}

/// Whether every edge is walked as often one way as the other.
pub(crate) fn is_closed(mesh: &Mesh) -> bool {
    surplus(Weld::new(mesh).faces.into_iter()).is_empty()
}

fn edge(p: u32, q: u32) -> [u32; 2] {
    [p.min(q), p.max(q)]
}

/// Whether a point lies beside the inside of an edge, and how far off.
fn beside(p: DVec3, from: DVec3, to: DVec3) -> (bool, f64) {
    let way = to - from;
    let along = (p - from).dot(way) / way.length_squared().max(f64::MIN_POSITIVE);
    (along > 0.0 && along < 1.0, p.distance(from + way * along))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::block;

    #[test]
    fn a_hole_is_filled_and_a_corner_on_an_edge_joined_to_it() {
        let cube = block(DVec3::ONE, DVec3::ZERO);
        let mut faces = cube.faces()[1..].to_vec();
        let mut corners = cube.vertices().to_vec();
        // One side's corner more, on the edge to a side that does not know of it.
        let [a, b, c] = faces[4];
        corners.push((corners[a as usize] + corners[b as usize]) / 2.0);
        let middle = corners.len() as u32 - 1;
        faces[4] = [a, middle, c];
        faces.push([middle, b, c]);
        let open = Mesh::new(corners, faces).unwrap();
        assert!(!is_closed(&open));
        let sealed = sealed(&open).unwrap();
        assert!(is_closed(&sealed));
        assert_eq!(sealed.faces().len(), 14);
        assert!((sealed.signed_volume() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_lid_with_a_corner_on_its_edge_is_laid_without_faces_of_no_area() {
        let cube = block(DVec3::ONE, DVec3::ZERO);
        let (mut corners, mut faces) = (cube.vertices().to_vec(), Vec::new());
        // An open box with a corner in the middle of every side of its rim.
        for (f, face) in cube.faces().iter().enumerate().filter(|(f, _)| cube.normal(*f).z < 0.5) {
            let is_rim = |k: usize| [k, k + 1].iter().all(|i| cube.corners(f)[i % 3].z > 0.4);
            let Some(k) = (0..3).find(|k| is_rim(*k)) else {
                faces.push(*face);
                continue;
            };
            let [a, b, c] = [k, k + 1, k + 2].map(|i| face[i % 3]);
            corners.push((corners[a as usize] + corners[b as usize]) / 2.0);
            let middle = corners.len() as u32 - 1;
            faces.extend([[a, middle, c], [middle, b, c]]);
        }
        let sealed = sealed(&Mesh::new(corners, faces).unwrap()).unwrap();
        assert!(is_closed(&sealed) && (sealed.signed_volume() - 1.0).abs() < 1e-12);
        assert!((0..sealed.faces().len()).all(|f| sealed.area(f) > 1e-3));
    }
}
