//! SDFormat models of several files.

use glamx::DPose3;

use super::{evidence, hinge, link, names, of, stands, whole};
use crate::options::{Asked, CheckOptions};
use crate::read::formats::Place;
use crate::robot::Geometry;

const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
    endloop\nendfacet\nendsolid a\n";

#[test]
fn what_is_included_brings_its_meshes_and_takes_another_name_and_place() {
    let place = Place::new("include");
    let config = "<model><name>cup</name><sdf version='1.5'>old.sdf</sdf>\
        <sdf version='1.9'>model.sdf</sdf></model>";
    let mesh =
        "<visual name='v'><geometry><mesh><uri>meshes/a.stl</uri></mesh></geometry></visual>";
    let model =
        format!("<sdf version='1.9'><model name='cup'>{}</model></sdf>", link("l", "", mesh));
    place.write("cup/model.config", config);
    place.write("cup/model.sdf", &model);
    place.write("cup/meshes/a.stl", STL);
    let include = |uri: &str, more: &str| {
        format!("<include{more}><uri>{uri}</uri><name>mug</name><pose>0 0 3 0 0 0</pose></include>")
    };
    let text = |include: String| {
        format!(
            "<sdf version='1.9'><model name='m'>\n{}\n{include}\n{}</model></sdf>",
            link("a", "", ""),
            hinge("j", "fixed", ["a", if include.contains("merge") { "l" } else { "mug::l" }], "")
        )
    };
    for (uri, more, name) in [
        ("model://cup", "", "mug::l"),
        ("cup", "", "mug::l"),
        ("cup/model.sdf", "", "mug::l"),
        ("model://cup", " merge='true'", "l"),
    ] {
        let file = place.write("m.sdf", &text(include(uri, more)));
        let options = CheckOptions { subject: Asked::Found, ..CheckOptions::default() };
        let robot = whole(crate::read::load::read(&file, &options));
        assert_eq!(names(&robot), ["a", name], "{uri}{more}");
        assert!(matches!(robot.links[1].visuals[0].geometry, Geometry::Mesh(_)), "{uri}{more}");
        stands(&robot, name, DPose3::identity(), [0.0, 0.0, 3.0]);
        assert_eq!(robot.links[1].line, 3, "it stands where it is included");
    }
}

#[test]
fn what_cannot_be_included_is_said_and_leaves_the_rest_judged() {
    let world = |uri: &str| {
        let body = format!(
            "<include><uri>{uri}</uri></include><model name='m'>{}</model>",
            link("a", "", "")
        );
        of("1.9", &format!("<world name='w'>{body}</world>"))
    };
    for (uri, due) in [
        ("model://no_such_model", "is not at, above or beside the file"),
        ("https://fuel.example/x", "is an address that nothing is fetched from"),
        ("../../../../x.sdf", "leaves the package"),
    ] {
        let loaded = world(uri);
        let found = evidence(&loaded, "F2");
        assert!(found[0].starts_with("line 2: include of") && found[0].contains(due), "{found:?}");
        let robot = whole(loaded);
        assert!(robot.beside.unread[0].checks.contains(&"C1"));
    }
    let place = Place::new("round");
    let file = place.write(
        "m.sdf",
        "<sdf version='1.9'><model name='m'><include><uri>m.sdf</uri></include></model></sdf>",
    );
    let loaded = crate::read::load::read(&file, &CheckOptions::default());
    assert!(evidence(&loaded, "F2").iter().any(|e| e.contains("nest at most")), "{loaded:?}");
}
