//! COLLADA as exporters write it.

use glamx::DVec3;

use super::{DaeError, read};

/// A file whose geometry holds four points, these primitives, and whose scene holds these nodes.
fn file(unit: &str, primitives: &str, scene: &str) -> String {
    let scene = match scene {
        "" => String::new(),
        nodes => format!(
            "<library_visual_scenes><visual_scene id='s'>{nodes}</visual_scene></library_visual_scenes>\
             <scene><instance_visual_scene url='#s'/></scene>"
        ),
    };
    format!(
        "<?xml version='1.0'?><COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema'>\
         <asset><unit meter='{unit}'/><up_axis>Y_UP</up_axis></asset><library_geometries>\
         <geometry id='g'><mesh><source id='p'><float_array>0 0 0 1 0 0 1 1 0 0 1 0</float_array>\
         <technique_common><accessor stride='3'/></technique_common></source>\
         <vertices id='v'><input semantic='POSITION' source='#p'/></vertices>{primitives}</mesh>\
         </geometry></library_geometries>{scene}</COLLADA>"
    )
}

const SQUARE: &str = "<polylist><input semantic='VERTEX' source='#v' offset='0'/>\
    <input semantic='NORMAL' source='#n' offset='1'/><vcount>4</vcount><p>0 9 1 9 2 9 3 9</p></polylist>";

#[test]
fn every_kind_of_polygon_covers_the_square_once_and_looks_up() {
    let input = "<input semantic='VERTEX' source='#v' offset='0'/>";
    for primitives in [
        SQUARE.to_owned(),
        format!("<triangles>{input}<p>0 1 2 0 2 3</p></triangles>"),
        format!("<polygons>{input}<p>0 1 2 3</p></polygons>"),
        format!("<trifans>{input}<p>0 1 2 3</p></trifans>"),
        format!("<tristrips>{input}<p>0 1 3 2</p></tristrips>"),
    ] {
        let mesh = read(file("1", &primitives, "").as_bytes()).unwrap();
        let area: f64 = (0..mesh.faces().len()).map(|f| mesh.area(f)).sum();
        assert!((area - 1.0).abs() < 1e-12, "{primitives}: {area}");
        assert!((0..2).all(|f| mesh.normal(f) == DVec3::Z), "{primitives}");
    }
}

#[test]
fn nodes_move_turn_and_scale_what_stands_in_them_and_the_unit_is_taken() {
    let node = "<node><translate>0 0 3</translate><node><rotate>0 0 1 90</rotate><scale>2 1 1</scale>\
                <instance_geometry url='#g'/></node></node>";
    let mesh = read(file("0.01", SQUARE, node).as_bytes()).unwrap();
    let bounds = mesh.bounds();
    assert!((bounds.min - DVec3::new(-0.01, 0.0, 0.03)).length() < 1e-12, "{bounds:?}");
    assert!((bounds.max - DVec3::new(0.0, 0.02, 0.03)).length() < 1e-12, "{bounds:?}");
    let matrix = "<node><matrix>1 0 0 5  0 0 -1 6  0 1 0 7  0 0 0 1</matrix>\
                  <instance_geometry url='#g'/></node>";
    let mesh = read(file("1", SQUARE, matrix).as_bytes()).unwrap();
    assert!((mesh.bounds().min - DVec3::new(5.0, 6.0, 7.0)).length() < 1e-12);
    assert!((mesh.bounds().max - DVec3::new(6.0, 6.0, 8.0)).length() < 1e-12);
}

#[test]
fn a_node_that_mirrors_leaves_faces_outward() {
    let node = "<node><scale>-1 1 1</scale><instance_geometry url='#g'/></node>";
    let mesh = read(file("1", SQUARE, node).as_bytes()).unwrap();
    assert_eq!(mesh.normal(0), DVec3::Z);
    assert_eq!(mesh.bounds().min.x, -1.0);
}

#[test]
fn a_node_of_the_library_stands_wherever_it_is_named() {
    let text = file(
        "1",
        SQUARE,
        "<node><instance_node url='#n'/></node><node><translate>4 0 0</translate>\
                    <instance_node url='#n'/></node>",
    );
    let library =
        "<library_nodes><node id='n'><instance_geometry url='#g'/></node></library_nodes>";
    let text = text.replace("<scene>", &format!("{library}<scene>"));
    let mesh = read(text.as_bytes()).unwrap();
    assert_eq!((mesh.faces().len(), mesh.bounds().max.x), (4, 5.0));
}

#[test]
fn what_is_broken_is_said_and_never_guessed() {
    let fails = |text: &str| read(text.as_bytes()).unwrap_err().to_string();
    assert!(fails("<x").contains("not XML"));
    assert!(fails("<robot/>").contains("expected `COLLADA`"));
    let lost = SQUARE.replace("2 9 3 9", "2 9 7 9");
    assert!(fails(&file("1", &lost, "")).contains("names a point that is not there"));
    let more = SQUARE.replace("<vcount>4", "<vcount>5");
    assert!(fails(&file("1", &more, "")).contains("counts more corners"));
    let loops = file("1", SQUARE, "<node id='n'><instance_node url='#n'/></node>");
    assert!(fails(&loops).contains("nest at most"), "a node within itself");
    assert!(fails(&file("nought", SQUARE, "")).contains("meter must be"));
    let look = file("1", SQUARE, "<node><lookat>1</lookat><instance_geometry url='#g'/></node>");
    assert!(fails(&look).contains("not read"));
    assert!(matches!(read(file("1", "", "").as_bytes()), Err(DaeError::Mesh(_))));
}
