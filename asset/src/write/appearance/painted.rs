//! Faces by the colour of their vertices, for formats that give a mesh one colour.

use std::collections::BTreeMap;

use object::Mesh;
use object::weld::Weld;

/// Most colours of a link that are kept apart. A guess: what a person paints has fewer, what a
/// generator paints has thousands.
const MOST_COLOURS: usize = 16;

/// A colour, sRGB and opacity from 0 to 1, and the faces that have it.
pub(crate) type Painted = ([f64; 4], Vec<u32>);

/// Whether faces taken alone hold a closed surface that faces inward: a pocket that only the faces around it
/// make sound.
fn has_inverted(mesh: &Mesh, faces: &[u32]) -> bool {
    let Ok(own) = mesh.submesh(faces.iter().map(|&face| face as usize)) else { return false };
    let weld = Weld::new(&own);
    let (of_face, count) = weld.components();
    let mut volumes = vec![0.0; count];
    let mut edges: BTreeMap<[u32; 2], (u32, u32)> = BTreeMap::new();
    for (face, &component) in of_face.iter().enumerate() {
        let [a, b, c] = own.corners(face);
        volumes[component as usize] += a.dot(b.cross(c)) / 6.0;
        let points = weld.faces[face];
        for k in 0..3 {
            let (from, to) = (points[k], points[(k + 1) % 3]);
            let edge = edges.entry([from.min(to), from.max(to)]).or_insert((component, 0));
            edge.1 += 1;
        }
    }
    let mut is_closed = vec![true; count];
    edges.values().filter(|(_, n)| n % 2 == 1).for_each(|(c, _)| is_closed[*c as usize] = false);
    volumes.iter().zip(is_closed).any(|(volume, is_closed)| is_closed && *volume < 0.0)
}

/// Faces by colour, sRGB and opacity from 0 to 1; all of the mean colour, and so said, where they have
/// too many colours, or one colour alone would be a surface that faces inward. `otherwise` is the colour of a surface without any.
pub(crate) fn painted(mesh: &Mesh, faces: &[u32], otherwise: [f64; 4]) -> (Vec<Painted>, bool) {
    let Some(colours) = mesh.colours() else { return (vec![(otherwise, faces.to_vec())], false) };
    let corners = |face: u32| mesh.faces()[face as usize].map(|v| colours[v as usize]);
    let mut by_colour: BTreeMap<[u8; 4], Vec<u32>> = BTreeMap::new();
    for &face in faces {
        let [a, b, c] = corners(face).map(|colour| colour.map(u32::from));
        let mean = std::array::from_fn(|k| ((a[k] + b[k] + c[k] + 1) / 3) as u8);
        by_colour.entry(mean).or_default().push(face);
    }
    let stays_sound = || by_colour.len() == 1 || !by_colour.values().any(|f| has_inverted(mesh, f));
    if by_colour.len() <= MOST_COLOURS && stays_sound() {
        let shares = |c: [u8; 4]| c.map(|c| (f64::from(c) / 255.0 * 1e4).round() / 1e4);
        return (by_colour.into_iter().map(|(c, f)| (shares(c), f)).collect(), false);
    }
    let (mut sum, mut area) = ([0.0; 4], 0.0);
    for &face in faces {
        let own = mesh.area(face as usize);
        area += 3.0 * own;
        for colour in corners(face) {
            sum.iter_mut().zip(colour).for_each(|(s, c)| *s += own * f64::from(c));
        }
    }
    let mean =
        if area > 0.0 { sum.map(|s| (s / area / 255.0 * 1e4).round() / 1e4) } else { otherwise };
    (vec![(mean, faces.to_vec())], true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::block;
    use glamx::DVec3;

    #[test]
    fn a_red_face_on_a_blue_block_stays_red() {
        let cube = block(DVec3::ONE, DVec3::ZERO);
        let corners: Vec<_> = (0..12).map(|f| cube.corners(f)).collect();
        let colour = |v: usize| if v < 3 { [255, 0, 0, 255] } else { [0, 0, 255, 255] };
        let apart = Mesh::of_triangles(&corners).unwrap();
        let mesh = apart.with_colours(Some((0..36).map(colour).collect())).unwrap();
        let all: Vec<u32> = (0..12).collect();
        let (groups, is_mixed) = painted(&mesh, &all, [0.5; 4]);
        assert!(!is_mixed);
        assert_eq!(groups[1], ([1.0, 0.0, 0.0, 1.0], vec![0]));
        assert_eq!(groups[0].1.len(), 11);
        let many = |v: usize| [7 * v as u8, 0, 0, 255];
        let mesh = mesh.with_colours(Some((0..36).map(many).collect())).unwrap();
        let (groups, is_mixed) = painted(&mesh, &all[..], [0.5; 4]);
        assert_eq!((groups.len(), is_mixed), (12, false));
    }

    #[test]
    fn a_pocket_of_another_colour_is_not_shown_inside_out() {
        let (outer, inner) =
            (block(DVec3::ONE, DVec3::ZERO), block(DVec3::splat(0.5), DVec3::ZERO));
        let corners = (0..12).map(|f| outer.corners(f));
        let turned = (0..12).map(|f| inner.corners(f)).map(|[a, b, c]| [b, a, c]);
        let mesh = Mesh::of_triangles(&corners.chain(turned).collect::<Vec<_>>()).unwrap();
        let half = mesh.vertices().iter().map(|v| v.abs().max_element() < 0.4);
        let colours = half.map(|inner| if inner { [0, 0, 255, 255] } else { [255, 0, 0, 255] });
        let colours = colours.collect();
        let mesh = mesh.with_colours(Some(colours)).unwrap();
        let all: Vec<u32> = (0..24).collect();
        let (groups, is_mixed) = painted(&mesh, &all, [0.5; 4]);
        assert_eq!((groups.len(), is_mixed), (1, true));
        assert_eq!(painted(&mesh, &all[..12], [0.5; 4]).0.len(), 1);
    }
}
