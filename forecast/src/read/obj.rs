//! As much of an OBJ as the rules need: corners, triangles, materials.

use std::collections::BTreeSet;

use crate::read::mesh::{Mesh, Point};

/// Most corners that are looked at; a guess with room.
const MAX_CORNERS: usize = 4_000_000;
/// Most triangles that are looked at; a guess with room.
const MAX_FACES: usize = 8_000_000;

/// Notes what an OBJ says; lines that are none are passed over.
pub(crate) fn look(bytes: &[u8], mesh: &mut Mesh) {
    let (mut corners, mut faces) = (Vec::<Point>::new(), Vec::new());
    let mut materials = BTreeSet::new();
    let mut current = None;
    for line in bytes.split(|b| *b == b'\n') {
        let Ok(line) = std::str::from_utf8(line) else { continue };
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") if corners.len() < MAX_CORNERS => {
                let numbers: Vec<f64> = words.take(3).map_while(|w| w.parse().ok()).collect();
                if let [x, y, z] = numbers[..] {
                    corners.push([x, y, z]);
                }
            }
            Some("f") if faces.len() < MAX_FACES => {
                fan(words, corners.len(), &mut faces);
                materials.extend(current.clone());
            }
            Some("usemtl") => current = words.next().map(str::to_string),
            _ => {}
        }
    }
    mesh.measure(&corners, &faces);
    mesh.materials = materials.len();
}

/// The triangles of a face, around its first corner. Indices count from 1, negative ones backwards.
fn fan<'w>(words: impl Iterator<Item = &'w str>, corners: usize, faces: &mut Vec<[usize; 3]>) {
    let index = |word: &str| {
        let number: i64 = word.split('/').next()?.parse().ok()?;
        let corners = i64::try_from(corners).ok()?;
        usize::try_from(if number < 0 { corners + number } else { number - 1 }).ok()
    };
    let (mut first, mut last) = (None, None);
    for at in words.map_while(index).take(1000) {
        if let (Some(first), Some(last)) = (first, last) {
            faces.push([first, last, at]);
        }
        if first.is_none() {
            first = Some(at);
        } else {
            last = Some(at);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_fan_out_and_materials_count_once() {
        let mut mesh = Mesh::named("a.obj");
        let text = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nusemtl a\nf 1/1 2/2 3/3 4/4\n\
                     usemtl b\nf -1 -2 -3\nusemtl a\nf 1 2 5\nf 1 x 2\nf\nv 1\n\xff\n";
        look(text, &mut mesh);
        assert_eq!((mesh.faces, mesh.materials), (4, 2));
        assert_eq!(mesh.bounds, Some([[0.0; 3], [1.0; 3]]));
    }
}
