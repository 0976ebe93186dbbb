//! MJCF read as links and joints.

use std::path::Path;

use glamx::DVec3;

use crate::options::CheckOptions;
use crate::read::load::{Loaded, from_text};
use crate::robot::{Geometry, Motion, Robot};
use crate::verdict::Status;

fn read(body: &str) -> Loaded {
    let text = format!("<mujoco model=\"m\">\n{body}\n</mujoco>");
    from_text(&text, Path::new("."), &CheckOptions::default())
}

fn robot(body: &str) -> Robot {
    let loaded = read(body);
    loaded.robot.unwrap_or_else(|| panic!("{:?}", loaded.checks))
}

fn evidence(loaded: &Loaded, id: &str) -> Vec<String> {
    loaded.checks.iter().filter(|c| c.id == id).flat_map(|c| c.evidence.clone()).collect()
}

const DOOR: &str = r#"<worldbody><body name="box"><geom type="box" size=".2 .1 .3" pos="0 0 .3"/>
    <body name="door" pos="0 -.1 0" euler="0 0 90"><joint name="hinge" pos=".2 0 0" axis="0 0 2"
    range="0 90" damping=".1" actuatorfrcrange="-3 3"/><geom type="box" size=".2 .01 .3" mass="2"/>
    </body></body></worldbody>"#;

#[test]
fn a_welded_body_hangs_on_the_world_and_a_hinge_stands_at_its_anchor() {
    let robot = robot(DOOR);
    let names: Vec<_> = robot.links.iter().map(|l| l.name.as_str()).collect();
    assert_eq!(names, ["world", "box", "door"]);
    let hinge = &robot.joints[1];
    assert_eq!((hinge.kind, hinge.axis), (Motion::Revolute, DVec3::Z));
    let limit = hinge.limit.unwrap();
    assert!((limit.upper - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert_eq!((limit.effort, limit.velocity), (Some(3.0), None));
    let rest = robot.link_poses(&[0.0; 2]);
    assert!((rest[2].translation - DVec3::new(0.0, 0.1, 0.0)).length() < 1e-12, "{:?}", rest[2]);
    let centre = rest[2] * robot.links[2].collisions[0].origin * DVec3::ZERO;
    assert!((centre - DVec3::new(0.0, -0.1, 0.0)).length() < 1e-12, "{centre}");
    let mass = robot.links[2].inertial.unwrap();
    assert!((mass.mass - 2.0).abs() < 1e-12 && mass.inertia.x_axis.x > 0.0);
    assert!((robot.links[1].inertial.unwrap().mass - 1000.0 * 0.4 * 0.2 * 0.6).abs() < 1e-9);
}

#[test]
fn a_body_that_floats_is_the_root() {
    let robot = robot(
        r#"<worldbody><geom type="plane" size="1 1 1"/><body name="cup" pos="0 0 1"><freejoint/>
        <geom size=".1"/></body></worldbody>"#,
    );
    assert_eq!((robot.links.len(), robot.joints.len()), (1, 0));
    assert_eq!(robot.links[0].collisions[0].origin.translation, DVec3::Z);
}

#[test]
fn classes_lend_what_an_element_does_not_say() {
    let robot = robot(
        r#"<compiler angle="radian" autolimits="false"/>
        <default><joint damping="1"/><default class="slow"><joint damping="2" type="slide"/>
        <geom contype="0" conaffinity="0" type="capsule" size=".1 .2"/></default></default>
        <worldbody><body name="a"><geom size=".1"/><body name="b" childclass="slow"><joint name="j"
        range="0 1" limited="true"/><geom/><geom class="main" type="sphere" size=".1"/></body>
        <body name="c"><joint name="k" range="0 1"/><geom size=".1"/></body></body></worldbody>"#,
    );
    let [j, k] = ["j", "k"].map(|n| robot.joints.iter().find(|j| j.name == n).unwrap());
    assert_eq!((j.kind, j.dynamics.unwrap().damping), (Motion::Prismatic, Some(2.0)));
    assert_eq!((k.kind, k.dynamics.unwrap().damping), (Motion::Continuous, Some(1.0)));
    let b = robot.links.iter().find(|l| l.name == "b").unwrap();
    let capsule = Geometry::Capsule { radius: 0.1, length: 0.4 };
    assert_eq!((&b.visuals[0].geometry, b.visuals.len(), b.collisions.len()), (&capsule, 1, 1));
}

#[test]
fn turns_are_told_in_five_ways() {
    for (way, expected) in [
        ("quat=\"2 0 0 2\"", DVec3::Y),
        ("axisangle=\"0 0 3 90\"", DVec3::Y),
        ("euler=\"90 0 90\"", DVec3::Z),
        ("xyaxes=\"0 1 0 -1 0 0\"", DVec3::Y),
        ("zaxis=\"1 0 0\"", DVec3::NEG_Z),
    ] {
        let body = format!("<worldbody><body name='a' {way}><geom size='.1'/></body></worldbody>");
        let turned = robot(&body).link_poses(&[0.0])[1].rotation * DVec3::X;
        assert!((turned - expected).length() < 1e-12, "{way}: {turned}");
    }
}

#[test]
fn what_has_no_counterpart_is_unknown_and_never_passes() {
    let geom = "<geom size='.1'/>";
    for body in [
        format!("<worldbody><body name='a'>{geom}</body></worldbody><include file='x.xml'/>"),
        format!("<worldbody><body name='a'>{geom}<attach model='x'/></body></worldbody>"),
    ] {
        let loaded = read(&body);
        assert!(loaded.robot.is_none());
        let t2 = loaded.checks.iter().find(|c| c.id == "T2").unwrap();
        assert_eq!(t2.status, Status::Unknown, "{body}");
        assert!(t2.evidence[0].contains("is not read here"), "{:?}", t2.evidence);
    }
}

#[test]
fn a_joint_type_that_mjcf_has_not_fails() {
    let geom = "<geom size='.1'/>";
    let body = format!("<worldbody><body name='a'><joint type='spring'/>{geom}</body></worldbody>");
    let loaded = read(&body);
    assert!(loaded.robot.is_none());
    let t2 = loaded.checks.iter().find(|c| c.id == "T2").unwrap();
    assert_eq!(t2.status, Status::Fail, "{:?}", t2.evidence);
    assert!(t2.evidence[0].contains("joint type `spring` is unknown"), "{:?}", t2.evidence);
}

#[test]
fn a_ball_or_a_loop_costs_its_own_joints_alone() {
    let geom = "<geom size='.1'/>";
    let ball =
        format!("<worldbody><body name='a'><joint name='j' type='ball'/>{geom}</body></worldbody>");
    let held = robot(&ball).joints[0].held.clone().unwrap();
    assert_eq!(held, "a ball, which has no single range");
    let body = |name: &str, inner: &str| {
        format!("<body name='{name}'><joint name='{name}_j' axis='1 0 0'/>{geom}{inner}</body>")
    };
    let arms = body("a", &body("b", "")) + &body("c", "");
    let tied = robot(&format!(
        "<worldbody>{arms}</worldbody><equality><connect body1='b' body2='a' anchor='0 0 0'/></equality>"
    ));
    let held: Vec<_> = tied.joints.iter().filter(|j| j.held.is_some()).map(|j| &j.name).collect();
    assert_eq!(held, ["b_j"]);
}

#[test]
fn several_joints_of_one_body_turn_one_after_the_other_as_in_mujoco() {
    let robot = robot(
        r#"<compiler angle="radian"/><worldbody><body name="a" pos="1 0 0"><joint name="x" axis="0 0 1"
        pos="0 1 0"/><joint name="y" axis="0 1 0"/><geom size=".1" pos="0 0 2"/></body></worldbody>"#,
    );
    let names: Vec<_> = robot.links.iter().map(|l| (l.name.as_str(), l.between)).collect();
    assert_eq!(names, [("world", false), ("a__0", true), ("a", false)]);
    let (half, quarter) = (std::f64::consts::PI, std::f64::consts::FRAC_PI_2);
    let poses = robot.link_poses(&[half, quarter]);
    let centre = poses[2] * robot.links[2].collisions[0].origin * DVec3::ZERO;
    // Half a turn about z through (1, 1): the body's origin goes to (1, 2); then about its own y.
    assert!((centre - DVec3::new(-1.0, 2.0, 0.0)).length() < 1e-12, "{centre}");
}

#[test]
fn a_frame_turns_the_joints_in_it_and_replicas_stand_side_by_side() {
    let framed = robot(
        r#"<worldbody><body name="a"><frame euler="0 90 0"><joint name="j" axis="0 0 1"/></frame>
        <replicate count="3" offset="1 0 0"><geom size=".1"/></replicate></body></worldbody>"#,
    );
    assert!((framed.joints[0].axis - DVec3::X).length() < 1e-12);
    let across: Vec<f64> =
        framed.links[1].collisions.iter().map(|s| s.origin.translation.x).collect();
    assert_eq!(across, [0.0, 1.0, 2.0]);
}

#[test]
fn every_broken_number_is_listed_with_its_line() {
    let loaded = read(
        "<worldbody><body name='a' pos='0 0'>\n<geom type='box' size='1 x 1'/><geom mesh='m'/>\n\
         <inertial mass='1' pos='0 0 0'/></body></worldbody>",
    );
    let found = evidence(&loaded, "F1");
    for expected in [
        "line 2: `body`: pos: expected 3 numbers, found 2",
        "line 3: `geom`: size=\"x\" is not a number",
        "line 3: `geom`: there is no mesh `m`",
        "line 4: `inertial`: has neither",
    ] {
        assert!(found.iter().any(|f| f.starts_with(expected)), "{expected}: {found:?}");
    }
}

#[test]
fn followers_efforts_and_velocities_are_found_where_they_stand() {
    let robot = robot(
        r#"<worldbody><body name="a"><geom size=".1"/><body name="b"><joint name="j" range="0 9"/>
        <geom size=".1"/></body><body name="c"><joint name="k" range="0 9"/><geom size=".1"/></body>
        </body></worldbody><equality><joint joint1="k" joint2="j" polycoef="0.5 -1"/></equality>
        <actuator><motor joint="j" ctrlrange="-2 1" gear="3"/></actuator>
        <custom><numeric name="j_velocity" data="4"/></custom>"#,
    );
    let j = robot.joints.iter().position(|j| j.name == "j").unwrap();
    let limit = robot.joints[j].limit.unwrap();
    assert_eq!((limit.effort, limit.velocity), (Some(6.0), Some(4.0)));
    let k = robot.joints.iter().find(|j| j.name == "k").unwrap();
    let mimic = k.mimic.unwrap();
    assert_eq!((mimic.joint, mimic.multiplier, mimic.offset), (j, -1.0, 0.5));
}

#[test]
fn deep_nests_and_many_bodies_are_refused_not_followed() {
    let deep = "<body>".repeat(400) + &"</body>".repeat(400);
    let loaded = read(&format!("<worldbody>{deep}</worldbody>"));
    assert!(loaded.robot.is_none() && !evidence(&loaded, "F1").is_empty());
    let many = "<body/>".repeat(600);
    let loaded = read(&format!("<worldbody>{many}</worldbody>"));
    assert!(evidence(&loaded, "F1")[0].contains("at most 512 bodies"));
}

#[test]
fn a_geom_has_its_own_colour_before_that_of_its_material() {
    let robot = robot(
        r#"<default><geom rgba=".5 .5 .5 1"/><default class="dark"><geom rgba="0 0 0 1"/></default></default>
        <asset><material name="red" rgba="1 0 0 1"/><texture name="t" type="2d" builtin="checker" width="8"
        height="8"/><material name="tiles" texture="t" rgba="1 1 0 1"/></asset>
        <worldbody><body name="b"><geom size=".1" material="red"/><geom size=".1" class="dark" material="red"/>
        <geom size=".1" rgba="0 1 0 .2" material="red"/><geom size=".1"/><geom size=".1" material="tiles"/>
        <geom size=".1" material="gone"/><geom size=".1" rgba="x"/></body></worldbody>"#,
    );
    let link = robot.links.iter().find(|l| l.name == "b").unwrap();
    let colours: Vec<_> = link.visuals.iter().map(|s| s.colour).collect();
    let solid = |r, g, b| Some([r, g, b, 255]);
    let green = Some([0, 255, 0, 51]);
    assert_eq!(colours, [solid(255, 0, 0), solid(0, 0, 0), green, None, None, None, None]);
}
