//! Closed-form shapes whose pieces are known.

use glamx::DVec3;
use object::mesh::Mesh;

use super::{COARSE, ConvexPiece, Decomposer, HullError, MAX_VERTICES, decompose};

type Soup = (Vec<DVec3>, Vec<[u32; 3]>);

/// Adds an axis-aligned box, twelve outward triangles.
pub(crate) fn add_box(soup: &mut Soup, min: [f64; 3], max: [f64; 3]) {
    let at = soup.0.len() as u32;
    let corner = |i: usize| {
        let pick = |axis: usize| if i >> axis & 1 == 1 { max[axis] } else { min[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    };
    soup.0.extend((0..8).map(corner));
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    for [a, b, c, d] in quads {
        soup.1.extend([[at + a, at + b, at + c], [at + a, at + c, at + d]]);
    }
}

fn boxes(list: &[([f64; 3], [f64; 3])]) -> Mesh {
    let mut soup = Soup::default();
    list.iter().for_each(|&(min, max)| add_box(&mut soup, min, max));
    Mesh::new(soup.0, soup.1).unwrap()
}

/// An open-topped box of outer size 0.4 × 0.5 × 0.2 with walls of `wall`, as one closed surface.
fn drawer(wall: f64) -> Mesh {
    let (outer, inner) = ([0.4, 0.5, 0.2], [0.4 - wall, 0.5 - wall, 0.2]);
    let ring = |lo: f64, hi: [f64; 3], z: f64| {
        [[lo, lo], [hi[0], lo], [hi[0], hi[1]], [lo, hi[1]]].map(|[x, y]| DVec3::new(x, y, z))
    };
    let rings = [
        ring(0.0, outer, 0.0),
        ring(0.0, outer, 0.2),
        ring(wall, inner, 0.2),
        ring(wall, inner, wall),
    ];
    let vertices = rings.into_iter().flatten().collect();
    let mut faces = vec![[0, 2, 1], [0, 3, 2], [12, 13, 14], [12, 14, 15]];
    for r in 0..3 {
        for k in 0..4 {
            let [a, b] = [4 * r + k, 4 * r + (k + 1) % 4];
            faces.extend([[a, b, b + 4], [a, b + 4, a + 4]]);
        }
    }
    Mesh::new(vertices, faces).unwrap()
}

#[test]
fn pieces_that_keep_closer_to_a_small_cup_fill_less_than_it_has_room_for() {
    let cup = drawer(0.02);
    let space = cup.signed_volume();
    let loose = Decomposer::new(&cup, 0.6).unwrap();
    let close = loose.keeping(0.02);
    assert!(!loose.is_closer() && close.is_closer());
    let [loose, close] = [loose, close].map(|d| d.pieces(COARSE).unwrap());
    let held = |pieces: &[ConvexPiece]| pieces.iter().map(volume).sum::<f64>() / space;
    assert!(held(&loose) > 1.2, "{}", held(&loose));
    assert!(held(&close) < 1.1 && close.len() < 12, "{} of {}", held(&close), close.len());
}

#[test]
fn a_piece_too_many_goes_where_others_serve_its_surface() {
    let plate = ([0.0; 3], [0.2, 0.2, 0.02]);
    let rib = ([0.0, 0.0, 0.01], [0.2, 0.05, 0.025]);
    let leg = ([0.0, 0.0, -0.2], [0.02, 0.02, 0.0]);
    let mesh = boxes(&[plate, rib, leg]);
    let one = |b| decompose(&boxes(&[b]), 0.02).unwrap().remove(0);
    let pieces = [plate, rib, leg].map(one);
    let of = Decomposer::new(&mesh, 0.02).unwrap();
    let left = |bounds| of.thinned(pieces.to_vec(), bounds);
    let all: f64 = pieces.iter().map(volume).sum();
    let needed = [pieces[0].clone(), pieces[2].clone()];
    assert_eq!(left((0.0, 0.0)), needed);
    assert_eq!(left((0.0, all)), pieces, "they fill no more than they may");
    assert_eq!(left((0.99 * all, 0.0)), pieces, "what is left would be too little");
}

pub(crate) fn volume(piece: &ConvexPiece) -> f64 {
    let at = |i: u32| piece.vertices[i as usize];
    let cone = |f: &[u32; 3]| at(f[0]).dot(at(f[1]).cross(at(f[2]))) / 6.0;
    piece.faces.iter().map(cone).sum()
}

fn assert_sound(piece: &ConvexPiece) {
    assert!(piece.vertices.len() <= MAX_VERTICES && volume(piece) > 0.0);
    assert_eq!(piece.faces.len(), 2 * piece.vertices.len() - 4, "closed");
    for f in &piece.faces {
        let [a, b, c] = f.map(|i| piece.vertices[i as usize]);
        let n = (b - a).cross(c - a).normalize();
        assert!(piece.vertices.iter().all(|&v| n.dot(v - a) < 1e-6), "convex");
    }
}

#[test]
fn a_box_is_one_piece_of_its_own_volume() {
    let pieces = decompose(&boxes(&[([0.1, 0.2, 0.3], [0.4, 0.7, 1.0])]), 0.02).unwrap();
    assert_eq!(pieces.len(), 1);
    assert_sound(&pieces[0]);
    assert!((volume(&pieces[0]) - 0.3 * 0.5 * 0.7).abs() < 1e-12);
}

#[test]
fn a_thin_walled_drawer_becomes_its_five_panels_and_stays_hollow() {
    let wall = 0.006;
    let pieces = decompose(&drawer(wall), 0.0134).unwrap();
    pieces.iter().for_each(assert_sound);
    let solid = 0.4 * 0.5 * 0.2 - (0.4 - 2.0 * wall) * (0.5 - 2.0 * wall) * (0.2 - wall);
    let sum: f64 = pieces.iter().map(volume).sum();
    assert_eq!(pieces.len(), 5);
    assert!((sum / solid - 1.0).abs() < 1e-6, "pieces {sum}, true {solid}");
}

#[test]
fn a_flat_sheet_gets_thickness_inward() {
    let v = [[0.0, 0.0], [0.5, 0.0], [0.5, 0.3], [0.0, 0.3]].map(|[x, y]| DVec3::new(x, y, 1.0));
    let sheet = Mesh::new(v.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let pieces = decompose(&sheet, 0.012).unwrap();
    assert_eq!(pieces.len(), 1);
    assert_sound(&pieces[0]);
    let z = pieces[0].vertices.iter().map(|v| v.z);
    let (low, high) = (z.clone().fold(9.0, f64::min), z.fold(0.0, f64::max));
    assert!(high == 1.0 && (0.001..0.002).contains(&(1.0 - low)), "{low} to {high}");
}

#[test]
fn an_l_of_two_boxes_is_two_pieces() {
    let l = boxes(&[([0.0; 3], [1.0, 0.2, 0.2]), ([0.0, 0.2, 0.0], [0.2, 1.0, 0.2])]);
    assert_eq!(decompose(&l, 0.02).unwrap().len(), 2);
}

#[test]
fn what_has_no_area_or_no_tolerance_is_refused() {
    let line = Mesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::X * 2.0], vec![[0, 1, 2]]).unwrap();
    assert_eq!(decompose(&line, 0.01), Err(HullError::NoArea { faces: 1 }));
    assert!(matches!(decompose(&line, f64::NAN), Err(HullError::Tolerance(_))));
}
