use super::*;

const HEAD: &str = "comment made by hand\nelement vertex 4\nproperty float x\nproperty float y\n\
                    property float z\nproperty float nx\nproperty uchar red\n\
                    property uchar green\nproperty uchar blue\nelement face 1\n\
                    property uchar flags\nproperty list uchar int vertex_indices\nend_header\n";
const POINTS: [[f32; 4]; 4] =
    [[0.0, 0.0, 0.0, 9.0], [2.0, 0.0, 0.0, 9.0], [2.0, 0.0, 1.5, 9.0], [0.0, 0.0, 1.5, 9.0]];
const COLOURS: [[u8; 3]; 4] = [[255, 0, 0], [0, 255, 0], [1, 2, 3], [10, 20, 30]];

fn text() -> Vec<u8> {
    let mut text = format!("ply\nformat ascii 1.0\n{HEAD}");
    for ([x, y, z, n], [r, g, b]) in POINTS.iter().zip(COLOURS) {
        text += &format!("{x} {y} {z} {n} {r} {g} {b}\n");
    }
    (text + "7 4 0 1 2 3\n").into_bytes()
}

fn binary(is_big: bool) -> Vec<u8> {
    let name = if is_big { "big" } else { "little" };
    let mut bytes = format!("ply\r\nformat binary_{name}_endian 1.0\r\n{HEAD}").into_bytes();
    for (numbers, colour) in POINTS.iter().zip(COLOURS) {
        let word = |n: &f32| if is_big { n.to_be_bytes() } else { n.to_le_bytes() };
        bytes.extend(numbers.iter().flat_map(word));
        bytes.extend(colour);
    }
    bytes.extend([10, 4]);
    let word = |n: i32| if is_big { n.to_be_bytes() } else { n.to_le_bytes() };
    bytes.extend([0, 1, 2, 3].into_iter().flat_map(word));
    bytes
}

#[test]
fn text_and_both_byte_orders_give_the_same_coloured_square() {
    let (mesh, left_out) = read(&text(), UpAxis::Z).unwrap();
    assert_eq!(mesh.faces(), [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.vertices()[2], DVec3::new(2.0, 0.0, 1.5));
    assert_eq!(mesh.colours().unwrap()[3], [10, 20, 30, 255]);
    assert!(left_out.is_empty(), "{left_out:?}");
    for is_big in [false, true] {
        assert_eq!(read(&binary(is_big), UpAxis::Z).unwrap().0, mesh);
    }
    let turned = read(&text(), UpAxis::Y).unwrap().0;
    assert_eq!(turned.vertices()[2], DVec3::new(2.0, -1.5, 0.0));
}

#[test]
fn what_is_no_surface_says_what_it_is() {
    let error = |text: &str| read(text.as_bytes(), UpAxis::Z).unwrap_err().to_string();
    let head = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
                property float z\n";
    assert!(error(&format!("{head}end_header\n0 0 0\n")).contains("points alone"));
    let splats = format!("{head}property float f_dc_0\nend_header\n0 0 0 1\n");
    assert!(error(&splats).contains("Gaussian splats"));
    let quads = format!("{head}element face 1\nproperty list uchar float vertex_indices\n");
    assert!(error(&format!("{quads}end_header\n")).contains("a list `vertex_indices`"));
    let faces =
        format!("{head}element face 1\nproperty list uchar int vertex_indices\nend_header\n");
    assert_eq!(
        error(&format!("{faces}0 0 zero\n")),
        "PLY vertex 0: a row has a number for each property, found `zero`"
    );
    assert!(error(&format!("{faces}0 0 0\n2 0 0\n")).contains("at least 3 corners, found 2"));
    assert!(error(&format!("{faces}0 0 0\n3 0 -1 0\n")).contains("a vertex's number, found -1"));
    assert!(error(&format!("{faces}0 0 0\n3 0 1 0\n")).contains("uses vertex 1"));
    assert!(error(&format!("{faces}0 0 0\n3 0")).contains("the end of the file"));
    assert!(error("ply\nformat ascii 1.0\n").contains("`end_header`"));
    assert!(error("plyx\n").contains("PLY line 1: the first line must be `ply`"));
    assert!(error("ply\nelement vertex 18446744073709551616\n").contains("whole count"));
}

#[test]
fn a_promise_of_more_than_the_file_holds_takes_no_memory() {
    let head = "ply\nformat binary_little_endian 1.0\nelement vertex 4000000\nproperty double x\n\
                property double y\nproperty double z\nelement face 1\n\
                property list uint int vertex_indices\nend_header\n";
    assert!(read(head.as_bytes(), UpAxis::Z).unwrap_err().to_string().contains("vertex 0"));
    let many = head.replace("4000000", "5000001");
    assert!(read(many.as_bytes(), UpAxis::Z).unwrap_err().to_string().contains("at most 5000000"));
}

#[test]
fn textures_and_colours_of_faces_are_said_to_be_left_out() {
    let text = String::from_utf8(text())
        .unwrap()
        .replace("comment made by hand", "comment TextureFile a.png");
    let text = text.replace("property uchar flags", "property uchar red");
    let (_, left_out) = read(text.as_bytes(), UpAxis::Z).unwrap();
    assert_eq!(left_out.len(), 2, "{left_out:?}");
}
