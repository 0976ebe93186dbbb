//! What `urdf-rs` drops, accepts or refuses wrongly, read right all the same.

use glamx::{DQuat, DVec3};

use crate::options::CheckOptions;
use crate::read::load::{Loaded, from_text};
use crate::robot::{Dynamics, Geometry, Limit, Robot};
use crate::verdict::Check;

fn loaded(text: &str) -> Loaded {
    from_text(text, ".".as_ref(), &CheckOptions::default())
}

fn sound(text: &str) -> Robot {
    let loaded = loaded(text);
    assert!(loaded.checks.iter().all(Check::holds), "{:?}", loaded.checks);
    loaded.robot.unwrap()
}

/// The findings of one check.
fn faults(text: &str, id: &str) -> Vec<String> {
    let checks = loaded(text).checks.into_iter().filter(|c| c.id == id);
    checks.flat_map(|c| c.evidence).collect()
}

fn hinged(more: &str) -> String {
    format!(
        "<robot name='r'><link name='a'/><link name='b'><visual><geometry><sphere radius='1'/></geometry></visual>\
         </link>\n<joint name='j' type='revolute'><parent link='a'/><child link='b'/>{more}</joint></robot>"
    )
}

fn shaped(robot: &str, visual: &str) -> String {
    format!("<robot name='r' {robot}><link name='a'>\n<visual>{visual}</visual></link></robot>")
}

#[test]
fn a_limit_without_velocity_is_read_and_what_was_not_said_is_none() {
    assert!(urdf_rs::read_from_string(&hinged("<limit lower='0' upper='1'/>")).is_err());
    let limit = |more: &str| sound(&hinged(more)).joints[0].limit;
    let none = Limit::NONE;
    assert_eq!(
        limit("<limit lower='-0.5' upper='1'/>"),
        Some(Limit { lower: -0.5, upper: 1.0, ..none })
    );
    let (effort, velocity) = (Some(0.0), Some(2.0));
    assert_eq!(
        limit("<limit effort='0' velocity=' 2 '/>"),
        Some(Limit { effort, velocity, ..none })
    );
    assert_eq!(limit(""), None);
    let dynamics = sound(&hinged("<dynamics friction='0.1'/>")).joints[0].dynamics;
    assert_eq!(dynamics, Some(Dynamics { damping: None, friction: Some(0.1) }));
}

#[test]
fn a_word_that_is_no_number_is_not_passed_over() {
    let text = hinged("<axis xyz='0 x 0 1'/>");
    assert_eq!(urdf_rs::read_from_string(&text).unwrap().joints[0].axis.xyz.0, [0.0, 0.0, 1.0]);
    assert_eq!(
        faults(&text, "F1"),
        ["line 2: `axis`: xyz=\"0 x 0 1\" must be three numbers, found 4"]
    );
    let text = hinged("<limit lower='nan' upper='inf' velocity='1'/>");
    assert!(urdf_rs::read_from_string(&text).is_ok());
    assert_eq!(faults(&text, "F1").len(), 2);
}

#[test]
fn one_name_twice_and_a_link_that_is_not_there_are_told_with_their_lines() {
    let text = hinged("").replace("link name='b'", "link name='a'");
    assert!(urdf_rs::read_from_string(&text).is_ok());
    let found = faults(&text, "T1");
    assert_eq!(found[0], "lines 1 and 1: two links are called `a`");
    assert_eq!(found[1], "line 2: joint `j` names the child link `b`, which does not exist");
}

#[test]
fn names_that_urdf_rs_never_sees_are_kept() {
    let text = "<robot name=' r '><link name='a &#10;&lt;b'/></robot>";
    let loaded = loaded(text);
    assert_eq!(loaded.robot.unwrap().links[0].name, "a \n<b");
    assert_eq!(faults("<robot name='r'><link/></robot>", "F3").len(), 1);
    assert_eq!(faults("<robot name='r'><link/></robot>", "F1"), [""; 0]);
}

#[test]
fn materials_extensions_and_namespaces_do_no_harm() {
    let visual =
        "<geometry><box size='1 2 3'/></geometry><material><color rgba='1 1 1'/></material>";
    let text = shaped("xmlns='http://www.ros.org' xmlns:x='u'", visual);
    assert!(urdf_rs::read_from_string(&text).is_err());
    let size = DVec3::new(1.0, 2.0, 3.0);
    assert_eq!(sound(&text).links[0].visuals[0].geometry, Geometry::Box { size });
}

#[test]
fn a_quaternion_is_the_same_turn_as_its_angles() {
    let turn = |robot: &str, origin: &str| {
        let visual =
            format!("<origin xyz='1 2 3' {origin}/><geometry><sphere radius='1'/></geometry>");
        sound(&shaped(robot, &visual)).links[0].visuals[0].origin
    };
    let (sin, cos) = 0.6f64.sin_cos();
    for version in ["1.1", "1.2", "2.0"] {
        let told = turn(&format!("version='{version}'"), &format!("quat_xyzw='0 0 {sin} {cos}'"));
        let angles = turn("", "rpy='0 0 1.2'");
        assert!(told.rotation.angle_between(angles.rotation) < 1e-8);
        assert_eq!(told.translation, DVec3::new(1.0, 2.0, 3.0));
    }
    // Two and a half thousandths of a radian from straight down, which `urdf-rs` takes for straight.
    let near = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2 - 0.0025);
    let words = near.to_array().map(|v| (7.0 * v).to_string()).join(" ");
    let told = turn("version='1.1'", &format!("quat_xyzw='{words}'"));
    assert!(told.rotation.angle_between(near) < 1e-7);
}

#[test]
fn a_quaternion_that_cannot_be_meant_is_a_fault() {
    let found = |robot: &str, origin: &str| {
        let visual = format!("<origin {origin}/><geometry><sphere radius='1'/></geometry>");
        faults(&shaped(robot, &visual), "F1")
    };
    let no_version = "line 2: `origin`: quat_xyzw is URDF 1.1, which the robot does not say: write `rpy`, or \
                      `version=\"1.1\"` in `robot`";
    assert_eq!(found("", "quat_xyzw='0 0 0 1'"), [no_version]);
    assert_eq!(found("version='one'", "quat_xyzw='0 0 0 1'"), [no_version]);
    let found = |origin: &str| found("version='1.1'", origin);
    assert_eq!(
        found("quat_xyzw='0 0 0 0'"),
        ["line 2: `origin`: quat_xyzw=\"0 0 0 0\" is no turn"]
    );
    assert_eq!(found("quat_xyzw='1e300 1e300 0 0'").len(), 1);
    assert_eq!(found("quat_xyzw='0 0 1'").len(), 1);
    assert_eq!(found("quat_xyzw='0 nan 0 1'").len(), 1);
    let both = "line 2: `origin`: tells its turn twice, as rpy and as quat_xyzw";
    assert_eq!(found("rpy='0 0 0' quat_xyzw='0 0 0 1'"), [both]);
}

#[test]
fn a_capsule_is_read_as_mjcf_s_is() {
    let visual = "<geometry><capsule radius='0.05' length='0.2'/></geometry>";
    let capsule = Geometry::Capsule { radius: 0.05, length: 0.2 };
    assert_eq!(sound(&shaped("", visual)).links[0].visuals[0].geometry, capsule);
    let torus = shaped("", "<geometry><torus radius='1'/></geometry>");
    assert_eq!(
        faults(&torus, "F1"),
        ["line 2: `torus`: expected box, cylinder, sphere or mesh, found `torus`"]
    );
}

/// Unknown elements, sections of character data, comments and long numbers, in amounts that harm nobody.
#[test]
fn what_is_no_element_or_number_of_urdf_does_not_reach_urdf_rs() {
    let deep = "<g>".repeat(20) + &"</g>".repeat(20);
    let brackets = format!("<![CDATA[{}]]>", "]".repeat(3));
    let long = format!("<link name='b'/><joint name='{}' type='fixed'>", "j".repeat(300));
    for more in [deep.as_str(), brackets.as_str(), "<!-- - -->"] {
        assert_eq!(
            sound(&format!("<robot name='r'><link name='a'/>{more}</robot>")).links.len(),
            1
        );
    }
    let joint = format!(
        "{long}<origin xyz='0.{}1 0 0'/><parent link='a'/><child link='b'/></joint>",
        "0".repeat(400)
    );
    let text = format!(
        "<robot name='r'><link name='a'><visual><geometry><sphere radius='1'/></geometry></visual></link>{joint}</robot>"
    );
    let loaded = loaded(&text);
    assert_eq!(loaded.robot.unwrap().joints[0].origin.translation, DVec3::ZERO);
}

#[test]
fn a_visual_has_the_colour_of_its_material_or_of_the_one_it_names() {
    let visual = |material: &str| {
        format!("<visual><geometry><sphere radius='1'/></geometry>{material}</visual>")
    };
    let inline = "<material name='own'><color rgba='0 1 0 0.5'/></material>";
    let other = "<material name='red'><color rgba='0 0 1 1'/></material>";
    let materials = [inline, "<material name='red'/>", "<material name='own'/>", other, ""];
    let unreadable =
        "<material name='odd'><color rgba='1 x 0 1'/></material><material name='gone'/>";
    let visuals: String = materials.iter().map(|m| visual(m)).collect();
    let text = format!(
        "<robot name='r'><link name='a'>{visuals}{}{}</link>\n\
         <material name='red'><color rgba='1 0 0 1'/></material></robot>",
        visual(unreadable),
        visual("<material name=''><color rgba='1 1 0 1'/></material>"),
    );
    let robot = sound(&text);
    let colours: Vec<_> = robot.links[0].visuals.iter().map(|s| s.colour).collect();
    let (red, own) = (Some([255, 0, 0, 255]), Some([0, 255, 0, 128]));
    assert_eq!(colours, [own, red, own, red, None, None, Some([255, 255, 0, 255])]);
}
