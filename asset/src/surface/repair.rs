//! Makes a part's surface fit to be drawn and weighed: welded, without degenerate or repeated
//! faces, oriented the same way all over and outward.
//!
//! Nothing visible is lost: only faces without area and exact copies go, and every count is kept.
//!
//! ```
//! use asset::surface::repair::repair;
//! use object::{DVec3, Mesh};
//! let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
//! let one_turned_over = vec![[0, 1, 2], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
//! let surface = repair(&Mesh::new(corners, one_turned_over)?, None)?;
//! assert_eq!((surface.report.flipped, surface.patches[0].volume), (1, Some(1.0 / 6.0)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::{BTreeMap, BTreeSet};

use object::Mesh;
use object::mesh::MeshError;
use object::weld::Weld;

use crate::surface::orient::{self, Scene};
use crate::surface::patches::Patches;
use crate::surface::repaired::{FLAT, Report, Surface, is_flat};

/// Repairs one part's surface; `scene` is the whole object's, without it only closed patches are
/// turned outward.
///
/// # Errors
/// [`MeshError::Empty`] if no face has any area.
pub fn repair(part: &Mesh, scene: Option<&Scene>) -> Result<Surface, MeshError> {
    let weld = Weld::new(part);
    let sound = with_area(part, &weld);
    let kept = without_copies(part, &weld, &sound);
    let mut found = patches_of(part, &weld, &kept);
    let places: Vec<_> = kept.iter().map(|&f| weld.faces[f]).collect();
    let corners: Vec<_> = places.iter().map(|f| f.map(|p| weld.places[p as usize])).collect();
    let closed = found.closed(&places);
    let patches = orient::outward(&corners, &mut found, &closed, scene);
    let report = Report {
        degenerate: part.faces().len() - sound.len(),
        repeated: sound.len() - kept.len(),
        flipped: found.flipped.iter().filter(|&&f| f).count(),
        conflicts: found.conflicts,
    };
    let mesh = assembled(part, &weld, &kept, &found)?;
    Ok(Surface { mesh, patches, report })
}

fn patches_of(part: &Mesh, weld: &Weld, faces: &[usize]) -> Patches {
    let places: Vec<_> = faces.iter().map(|&f| weld.faces[f]).collect();
    let vertices: Vec<_> = faces.iter().map(|&f| part.faces()[f]).collect();
    let area: Vec<f64> = faces.iter().map(|&f| part.area(f)).collect();
    Patches::new(&places, &vertices, &area)
}

fn with_area(part: &Mesh, weld: &Weld) -> Vec<usize> {
    let flat = part.bounds().diagonal() * FLAT;
    let is_sound = |&f: &usize| !is_flat(weld.faces[f].map(|p| weld.places[p as usize]), flat);
    (0..part.faces().len()).filter(is_sound).collect()
}

/// The faces without exact copies. A face that closes a body of its own is no copy, even where
/// another body has the same one: only whole bodies and faces of open patches are dropped.
fn without_copies(part: &Mesh, weld: &Weld, faces: &[usize]) -> Vec<usize> {
    let mut listed = BTreeSet::new();
    let once: Vec<usize> =
        faces.iter().copied().filter(|&f| listed.insert(from_smallest(part.faces()[f]))).collect();
    let found = patches_of(part, weld, &once);
    let places: Vec<_> = once.iter().map(|&f| weld.faces[f]).collect();
    let closed = found.closed(&places);
    let key = |f: u32| from_smallest(places[f as usize]);
    let (mut seen, mut kept) = (BTreeSet::new(), Vec::new());
    let (whole, open): (Vec<usize>, Vec<usize>) = (0..closed.len()).partition(|&p| closed[p]);
    for patch in whole {
        let faces = &found.faces[patch];
        if !faces.iter().all(|&f| seen.contains(&key(f))) {
            kept.extend_from_slice(faces);
            seen.extend(faces.iter().map(|&f| key(f)));
        }
    }
    for face in open.iter().flat_map(|&p| &found.faces[p]) {
        if seen.insert(key(*face)) {
            kept.push(*face);
        }
    }
    kept.sort_unstable();
    kept.into_iter().map(|f| once[f as usize]).collect()
}

/// The same walk round a face, started at its smallest place.
pub(crate) fn from_smallest([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// The kept faces, turned as found, over vertices merged by place and colour within each patch.
fn assembled(part: &Mesh, weld: &Weld, kept: &[usize], found: &Patches) -> Result<Mesh, MeshError> {
    let mut vertex_of = BTreeMap::new();
    let (mut vertices, mut colours, mut faces) = (Vec::new(), Vec::new(), Vec::new());
    for (face, &source) in kept.iter().enumerate() {
        let [a, b, c] = part.faces()[source].map(|v| {
            let place = weld.place_of_vertex[v as usize];
            let colour = part.colours().map(|c| c[v as usize]);
            *vertex_of.entry((found.patch_of_face[face], place, colour)).or_insert_with(|| {
                vertices.push(weld.places[place as usize]);
                colours.extend(colour);
                vertices.len() as u32 - 1
            })
        });
        faces.push(if found.flipped[face] { [a, c, b] } else { [a, b, c] });
    }
    let colours = part.colours().is_some().then_some(colours);
    Mesh::new(vertices, faces)?.with_frame(part.frame()).with_colours(colours)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{block, joined, reversed};
    use glamx::DVec3;

    fn volumes(s: &Surface) -> Vec<f64> {
        s.patches.iter().filter_map(|p| p.volume).map(|v| (v * 1e9).round() / 1e9).collect()
    }

    #[test]
    fn a_block_with_slivers_copies_and_one_face_turned_is_whole_again() {
        let cube = block(DVec3::ONE, DVec3::ZERO);
        let mut faces = cube.faces().to_vec();
        faces[5].swap(0, 1);
        faces.extend([[0, 0, 1], cube.faces()[2]]);
        let broken = Mesh::new(cube.vertices().to_vec(), faces).unwrap();
        let fixed = repair(&broken, None).unwrap();
        let expected = Report { degenerate: 1, repeated: 1, flipped: 1, conflicts: 0 };
        assert_eq!(fixed.report, expected);
        assert_eq!(volumes(&fixed), [1.0]);
        assert!((fixed.mesh.signed_volume() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn boards_that_share_a_face_stay_closed_but_a_second_copy_goes() {
        let (a, b) = (DVec3::new(1.0, 1.0, 0.2), DVec3::new(0.3, 1.0, 0.2));
        let (a, b) = (block(a, DVec3::ZERO), block(b, DVec3::X * 0.35));
        let fixed = repair(&joined(&[a.clone(), b.clone(), a]), None).unwrap();
        assert_eq!((volumes(&fixed), fixed.report.repeated), (vec![0.2, 0.06], 12));
    }

    #[test]
    fn an_object_turned_inside_out_is_turned_back() {
        let fixed = repair(&reversed(&block(DVec3::ONE, DVec3::X)), None).unwrap();
        assert_eq!((volumes(&fixed), fixed.report.flipped), (vec![1.0], 12));
    }

    #[test]
    fn a_cavity_stays_a_cavity_and_an_inner_body_a_body() {
        let (outer, inner) =
            (block(DVec3::ONE, DVec3::ZERO), block(DVec3::splat(0.5), DVec3::ZERO));
        let hollow = joined(&[outer.clone(), reversed(&inner)]);
        let fixed = repair(&hollow, None).unwrap();
        assert_eq!(volumes(&fixed), [1.0, -0.125]);
        assert_eq!(fixed.patches[1].hollows, Some(0));
        let inside_out = repair(&reversed(&hollow), None).unwrap();
        assert_eq!(volumes(&inside_out), [1.0, -0.125]);
        let nested = repair(&joined(&[outer, inner]), None).unwrap();
        assert_eq!(volumes(&nested), [1.0, 0.125]);
    }

    #[test]
    fn an_open_box_that_shows_its_back_is_turned_round() {
        let open = joined(&[block(DVec3::new(1.0, 1.0, 0.5), DVec3::ZERO)]);
        let lidless = open.submesh((0..12).filter(|&f| open.normal(f).z < 0.5)).unwrap();
        let wrong = reversed(&lidless);
        let scene = Scene::new(&wrong);
        let fixed = repair(&wrong, scene.as_ref()).unwrap();
        assert_eq!(fixed.report.flipped, 10);
        let kept = repair(&lidless, Scene::new(&lidless).as_ref()).unwrap();
        assert_eq!(kept.report.flipped, 0);
        assert_eq!(fixed.patches[0].volume, None);
    }

    #[test]
    fn a_surface_without_area_is_an_error() {
        let line = Mesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::X * 2.0], vec![[0, 1, 2]]).unwrap();
        assert_eq!(repair(&line, None).unwrap_err(), MeshError::Empty);
    }
}
