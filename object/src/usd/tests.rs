use super::*;
use crate::beside::Found;
use crate::glb::{linear_of_srgb, srgb_of_linear};
use crate::mesh::MeshError;
use glamx::DVec3;

/// The same scene three times, as usd-core 26 writes it: a box of 1 m whose top is red and whose sides have a
/// picture, a triangle with colours, and one that is hidden; centimetres, z up, the root turned and shifted.
const TEXT: &[u8] = include_bytes!("../../fuzz/seeds/usd/boxes.usda");
const BINARY: &[u8] = include_bytes!("../../fuzz/seeds/usd/boxes.usdc");
const PACKED: &[u8] = include_bytes!("../../fuzz/seeds/usd/boxes.usdz");

fn picture(name: &str) -> Result<Found, String> {
    assert_eq!(name, "./tex.png");
    let bytes = crate::appearance::Pixels::filled(4, 4, [10, 20, 30, 255]).png()?;
    Ok(Found { name: name.into(), bytes })
}

fn nothing(name: &str) -> Result<Found, String> {
    panic!("{name} is in the archive")
}

#[test]
fn text_binary_and_packed_usd_give_the_same_boxes() {
    let text = read(TEXT.to_vec(), UpAxis::Y, &mut picture).unwrap();
    let binary = read(BINARY.to_vec(), UpAxis::Y, &mut picture).unwrap();
    let packed = read(PACKED.to_vec(), UpAxis::Y, &mut nothing).unwrap();
    assert_eq!(text, binary);
    assert_eq!((&text.mesh, &text.notes), (&packed.mesh, &packed.notes));
    assert_eq!(text.notes, ["/World/hidden is hidden and left out"]);
    let bounds = text.mesh.bounds();
    assert!((bounds.min - DVec3::new(-0.4, -0.5, -0.5)).length() < 1e-6, "{bounds:?}");
    assert!((bounds.max - DVec3::new(0.6, 0.5, 0.6)).length() < 1e-6, "{bounds:?}");
    assert_eq!((text.mesh.faces().len(), text.mesh.frame().up), (13, UpAxis::Z));
    let appearance = text.appearance.unwrap();
    let (sides, corners) = appearance.of_face(0).unwrap();
    assert_eq!((sides.name.as_str(), sides.roughness), ("mat", 0.25));
    assert!(sides.base_texture.is_some());
    assert_eq!(corners, [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0]]);
    assert_eq!(appearance.of_face(2).unwrap().0.base_colour, [1.0, 0.0, 0.0, 1.0]);
    assert_eq!(appearance.of_face(12), None);
    let colours = text.mesh.colours().unwrap();
    let [a, b, c] = text.mesh.faces()[12].map(|v| colours[v as usize]);
    assert_eq!([a, b, c], [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255]]);
    let own = packed.appearance.unwrap().pictures()[0].pixels().unwrap().at(1, 2);
    assert_eq!(own, [60, 120, 128, 255]);
}

#[test]
fn what_a_usd_gives_goes_on_as_one_glb_with_the_same_looks() {
    let taken =
        crate::meshfile::take_in(PACKED.to_vec(), (false, UpAxis::Y), &mut nothing).unwrap();
    let again = crate::meshfile::read_noted(&taken.file).unwrap();
    let first = read(PACKED.to_vec(), UpAxis::Y, &mut nothing).unwrap();
    assert_eq!(again.notes, first.notes);
    for face in 0..13 {
        let (a, b) = (first.mesh.corners(face), again.mesh.corners(face));
        assert!(a.iter().zip(b).all(|(a, b)| (*a - b).length() < 1e-6), "{face}");
        let (one, other) = (first.appearance.as_ref().unwrap(), again.appearance.as_ref().unwrap());
        assert_eq!(
            one.of_face(face).map(|(m, c)| (m.base_colour, c)),
            other
                .of_face(face)
                .filter(|(m, _)| !m.name.is_empty())
                .map(|(m, c)| (m.base_colour, c)),
            "{face}"
        );
    }
    let top = again.mesh.faces()[2].map(|v| again.mesh.colours().unwrap()[v as usize]);
    assert_eq!(top, [[255, 0, 0, 255]; 3]);
    assert!((srgb_of_linear(linear_of_srgb(0.3)) - 0.3).abs() < 1e-12);
}

#[test]
fn a_layer_read_in_a_process_apart_gives_the_same_boxes() {
    let here = read(TEXT.to_vec(), UpAxis::Y, &mut picture).unwrap();
    let answer = apart::answer(TEXT.to_vec());
    assert_eq!(of_answer(&answer, UpAxis::Y, &mut picture), Ok(here));
    let refused = apart::answer(b"#usda 1.0\ndef Mesh \"a\" {".to_vec());
    let error = of_answer(&refused, UpAxis::Y, &mut picture).unwrap_err().to_string();
    assert!(error.starts_with("USD: ") && !error.contains("whole"), "{error}");
    for broken in [&answer[..answer.len() / 2], b"", b"{}"] {
        let error = of_answer(broken, UpAxis::Y, &mut picture).unwrap_err().to_string();
        assert!(error.contains("not whole"), "{error}");
    }
}

#[test]
fn a_move_or_a_connection_that_names_no_path_is_refused_at_once() {
    let text = String::from_utf8(TEXT.to_vec()).unwrap();
    for (sound, broken, word) in [
        ("\"xformOp:translate\"", "\"xformOp:trans/la.te\"", "words of letters"),
        ("\"st\"", "\"s.t\"", "names no coordinates"),
    ] {
        let broken = text.replacen(sound, broken, 1);
        assert_ne!(text, broken, "{sound}");
        let error = read(broken.into_bytes(), UpAxis::Y, &mut picture).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
}

#[test]
fn broken_usd_is_refused_in_words() {
    let error =
        |bytes: &[u8]| read(bytes.to_vec(), UpAxis::Y, &mut picture).unwrap_err().to_string();
    assert!(error(b"#usda 1.0\ndef Mesh \"a\" {").starts_with("USD: "));
    assert!(error(&BINARY[..BINARY.len() / 2]).starts_with("USD: "));
    assert!(error(b"PK\x03\x04").contains("USDZ archive"));
    assert_eq!(error(b"#usda 1.0\n"), MeshError::Empty.to_string());
    let text = String::from_utf8(TEXT.to_vec()).unwrap();
    let beyond = text.replace("[3, 2, 1, 0,", "[3, 2, 1, 99,");
    assert_ne!(beyond, text);
    assert!(error(beyond.as_bytes()).contains("an index must name a point, found 99 of 8"));
    let uneven = text.replace("[4, 4, 4, 4, 4, 4]", "[4, 4, 4, 4, 4, 9]");
    assert!(error(uneven.as_bytes()).contains("add up"), "{}", error(uneven.as_bytes()));
}
