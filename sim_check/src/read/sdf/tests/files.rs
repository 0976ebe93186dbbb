//! SDFormat models of several files, and the same model in other formats.

use glamx::DPose3;

use super::{evidence, hinge, link, names, of, shape, stands, whole};
use crate::check;
use crate::options::{Asked, CheckOptions};
use crate::profile::Tier;
use crate::robot::Geometry;
use crate::verdict::Status;

/// A folder of its own.
struct Place(std::path::PathBuf);

impl Place {
    fn new(name: &str) -> Self {
        let place = std::env::temp_dir().join(format!("kinfold-sdf-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&place);
        std::fs::create_dir_all(&place).unwrap();
        Self(place)
    }

    fn write(&self, name: &str, text: &str) -> std::path::PathBuf {
        let file = self.0.join(name);
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(&file, text).unwrap();
        file
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

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

/// A box with a door, in three formats.
fn doors() -> [(&'static str, String); 3] {
    let urdf = r#"<robot name="m"><link name="box"><inertial><mass value="4"/><inertia ixx=".08" iyy=".08" izz=".06" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><box size=".3 .3 .4"/></geometry></visual><collision><geometry><box size=".3 .3 .4"/></geometry></collision></link>
<link name="door"><inertial><origin xyz="0 .15 0"/><mass value="1"/><inertia ixx=".02" iyy=".014" izz=".008" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><origin xyz="0 .15 0"/><geometry><box size=".02 .3 .4"/></geometry></visual><collision><origin xyz="0 .15 0"/><geometry><box size=".02 .3 .4"/></geometry></collision></link>
<joint name="hinge" type="revolute"><origin xyz=".161 -.15 0" rpy="0 0 0"/><parent link="box"/><child link="door"/><axis xyz="0 0 -1"/><limit lower="0" upper="1.5" effort="3" velocity="2"/><dynamics damping=".1" friction=".05"/></joint></robot>"#;
    let mjcf = r#"<mujoco model="m"><compiler angle="radian"/><worldbody><body name="box"><freejoint/><inertial pos="0 0 0" mass="4" diaginertia=".08 .08 .06"/>
<geom type="box" size=".15 .15 .2"/><body name="door" pos=".161 -.15 0"><joint name="hinge" axis="0 0 -1" range="0 1.5" actuatorfrcrange="-3 3" damping=".1" frictionloss=".05"/>
<inertial pos="0 .15 0" mass="1" diaginertia=".02 .014 .008"/><geom type="box" size=".01 .15 .2" pos="0 .15 0"/></body></body></worldbody></mujoco>"#;
    let inertial = |pose: &str, mass: &str, [x, y, z]: [&str; 3]| {
        format!(
            "<inertial><pose>{pose} 0 0 0</pose><mass>{mass}</mass><inertia><ixx>{x}</ixx><iyy>{y}</iyy><izz>{z}</izz></inertia></inertial>"
        )
    };
    let both = |pose: &str, size: &str| {
        let shape = shape(size);
        format!(
            "<visual name='v'><pose>{pose} 0 0 0</pose>{shape}</visual><collision name='c'><pose>{pose} 0 0 0</pose>{shape}</collision>"
        )
    };
    let sdf = format!(
        "<sdf version='1.9'><model name='m'><link name='box'>{}{}</link>\n<link name='door'><pose>.161 -.15 0 0 0 0</pose>{}{}</link>\n\
         <joint name='hinge' type='revolute'><parent>box</parent><child>door</child><axis><xyz>0 0 -1</xyz><limit><lower>0</lower><upper>1.5</upper>\
         <effort>3</effort><velocity>2</velocity></limit><dynamics><damping>.1</damping><friction>.05</friction></dynamics></axis></joint></model></sdf>",
        inertial("0 0 0", "4", [".08", ".08", ".06"]),
        both("0 0 0", ".3 .3 .4"),
        inertial("0 .15 0", "1", [".02", ".014", ".008"]),
        both("0 .15 0", ".02 .3 .4"),
    );
    [("m.urdf", urdf.into()), ("m.xml", mjcf.into()), ("m.sdf", sdf)]
}

#[test]
fn one_model_in_three_formats_gets_one_verdict() {
    let place = Place::new("one");
    let options =
        CheckOptions { up_to: Tier::Dynamic, subject: Asked::Found, ..CheckOptions::default() };
    let verdicts = doors().map(|(name, text)| check(&place.write(name, &text), &options));
    let [urdf, mjcf, sdf] = &verdicts;
    assert_eq!(urdf.tier, Tier::Dynamic, "{:?}", urdf.failures().collect::<Vec<_>>());
    for other in [mjcf, sdf] {
        assert_eq!((other.tier, other.links), (urdf.tier, urdf.links));
        for check in &urdf.checks {
            let found = other.check(&check.id).unwrap();
            // MJCF has no word for velocity.
            if check.id != "J4" {
                assert_eq!((found.status, check.id.as_str()), (check.status, found.id.as_str()));
            }
            if let (Some(a), Some(b)) = (check.value, found.value) {
                assert!((a - b).abs() <= 1e-6 * a.abs().max(1e-6), "{}: {a} and {b}", check.id);
            }
        }
    }
    assert_eq!(sdf.check("J4").map(|c| c.status), Some(Status::Pass));
}
