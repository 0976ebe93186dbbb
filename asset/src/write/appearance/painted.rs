//! Faces by the colour of their vertices, for formats that give a mesh one colour.

use std::collections::BTreeMap;

use object::Mesh;

/// Most colours of a link that are kept apart. A guess: what a person paints has fewer, what a
/// generator paints has thousands.
const MOST_COLOURS: usize = 16;

/// A colour, sRGB and opacity from 0 to 1, and the faces that have it.
pub(crate) type Painted = ([f64; 4], Vec<u32>);

/// Faces by colour, sRGB and opacity from 0 to 1; all of the mean colour, and so said, where they have
/// too many colours. `otherwise` is the colour of a surface without any.
pub(crate) fn painted(mesh: &Mesh, faces: &[u32], otherwise: [f64; 4]) -> (Vec<Painted>, bool) {
    let Some(colours) = mesh.colours() else { return (vec![(otherwise, faces.to_vec())], false) };
    let corners = |face: u32| mesh.faces()[face as usize].map(|v| colours[v as usize]);
    let mut by_colour: BTreeMap<[u8; 4], Vec<u32>> = BTreeMap::new();
    for &face in faces {
        let [a, b, c] = corners(face).map(|colour| colour.map(u32::from));
        let mean = std::array::from_fn(|k| ((a[k] + b[k] + c[k] + 1) / 3) as u8);
        by_colour.entry(mean).or_default().push(face);
    }
    if by_colour.len() <= MOST_COLOURS {
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
}
