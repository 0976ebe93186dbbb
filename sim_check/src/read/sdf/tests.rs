//! SDFormat read as links and joints.

mod files;

use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;

use glamx::{DPose3, DVec3};

use crate::options::{Asked, CheckOptions};
use crate::read::load::{Loaded, from_text};
use crate::robot::{Geometry, Motion, Robot};

fn of(version: &str, body: &str) -> Loaded {
    let text = format!("<sdf version=\"{version}\">\n{body}\n</sdf>");
    let options = CheckOptions { subject: Asked::Found, ..CheckOptions::default() };
    from_text(&text, Path::new("."), &options)
}

fn read(body: &str) -> Loaded {
    of("1.9", &format!("<model name=\"m\">{body}</model>"))
}

#[track_caller]
fn robot(body: &str) -> Robot {
    whole(read(body))
}

#[track_caller]
fn whole(loaded: Loaded) -> Robot {
    loaded.robot.unwrap_or_else(|| panic!("{:#?}", loaded.checks))
}

fn evidence(loaded: &Loaded, id: &str) -> Vec<String> {
    loaded.checks.iter().filter(|c| c.id == id).flat_map(|c| c.evidence.clone()).collect()
}

fn names(robot: &Robot) -> Vec<&str> {
    robot.links.iter().map(|l| l.name.as_str()).collect()
}

/// Where a point of a link stands in the world.
#[track_caller]
fn stands(robot: &Robot, link: &str, at: DPose3, due: [f64; 3]) {
    let index = robot.links.iter().position(|l| l.name == link).unwrap();
    let found = (robot.link_poses(&[])[index] * at).translation;
    assert!((found - DVec3::from_array(due)).length() < 1e-12, "{link}: {found}");
}

fn shape(size: &str) -> String {
    format!("<geometry><box><size>{size}</size></box></geometry>")
}

fn link(name: &str, pose: &str, more: &str) -> String {
    let touched = format!("<collision name=\"c\">{}</collision>", shape(".1 .1 .1"));
    format!("<link name=\"{name}\">{pose}{touched}{more}</link>")
}

fn hinge(name: &str, kind: &str, [parent, child]: [&str; 2], more: &str) -> String {
    format!(
        "<joint name=\"{name}\" type=\"{kind}\"><parent>{parent}</parent><child>{child}</child>{more}</joint>"
    )
}

const TURN: &str = "<axis><xyz>0 0 1</xyz><limit><lower>0</lower><upper>1</upper></limit></axis>";

#[test]
fn a_joint_stands_in_its_childs_frame_and_the_root_in_the_worlds() {
    let pose = "<pose>0 1 0 0 0 0</pose>";
    let body = "<pose>0 0 2 0 0 0</pose>".to_owned()
        + &link("a", pose, "")
        + &link("b", "<pose>1 0 0 0 0 1.5707963267948966</pose>", "")
        + &hinge("j", "revolute", ["a", "b"], &TURN.replace("0 0 1<", "1 0 0<"));
    let robot = robot(&body);
    assert_eq!((names(&robot), robot.root()), (vec!["a", "b"], 0));
    // The root is told in the world: its shapes stand where the file puts them.
    stands(&robot, "a", robot.links[0].collisions[0].origin, [0.0, 1.0, 2.0]);
    stands(&robot, "b", robot.links[1].collisions[0].origin, [1.0, 0.0, 2.0]);
    let joint = &robot.joints[0];
    let turned = robot.link_poses(&[])[1].rotation * joint.axis;
    assert!((turned - DVec3::Y).length() < 1e-12, "{turned}");
    let limit = joint.limit.unwrap();
    assert_eq!((limit.lower, limit.upper, limit.effort, limit.velocity), (0.0, 1.0, None, None));
}

#[test]
fn poses_are_told_in_frames_which_are_attached_to_each_other() {
    let frames = "<frame name=\"f\" attached_to=\"b\"><pose>0 0 1 0 0 0</pose></frame>\
        <frame name=\"g\"><pose relative_to=\"f\">0 1 0 0 0 0</pose></frame>";
    let body = link("a", "", "")
        + &link("b", "<pose degrees=\"true\">1 0 0 0 0 90</pose>", "")
        + &link("c", "<pose relative_to=\"f\">1 0 0 0 0 0</pose>", "")
        + frames
        + &hinge(
            "j",
            "revolute",
            ["a", "f"],
            "<pose relative_to=\"g\"/><axis><xyz \
             expressed_in=\"b\">1 0 0</xyz></axis>",
        )
        + &hinge("k", "fixed", ["b", "c"], "");
    let robot = robot(&body);
    stands(&robot, "c", DPose3::identity(), [1.0, 1.0, 1.0]);
    // The joint stands at `g`, and with it its link; the shape stays where `b` is.
    stands(&robot, "b", DPose3::identity(), [0.0, 0.0, 1.0]);
    stands(&robot, "b", robot.links[1].collisions[0].origin, [1.0, 0.0, 0.0]);
    assert_eq!(robot.joints[0].kind, Motion::Continuous);
    let turned = robot.link_poses(&[])[1].rotation * robot.joints[0].axis;
    assert!((turned - DVec3::Y).length() < 1e-12, "{turned}");
}

#[test]
fn an_axis_is_told_in_the_model_where_the_version_or_the_file_says_so() {
    let body = |more: &str| {
        let turned = link("b", "<pose>0 0 0 0 0 1.5707963267948966</pose>", "");
        let axis = format!("<axis><xyz>1 0 0</xyz>{more}</axis>");
        link("a", "", "") + &turned + &hinge("j", "revolute", ["a", "b"], &axis)
    };
    let axis = |version: &str, more: &str| {
        whole(of(version, &format!("<model name='m'>{}</model>", body(more)))).joints[0].axis
    };
    let said = "<use_parent_model_frame>1</use_parent_model_frame>";
    for (version, more, due) in [
        ("1.4", "", -DVec3::Y),
        ("1.6", "", DVec3::X),
        ("1.6", said, -DVec3::Y),
        ("1.12", "", DVec3::X),
    ] {
        let found = axis(version, more);
        assert!((found - due).length() < 1e-12, "{version} {more}: {found}");
    }
}

#[test]
fn nested_models_bring_their_names_and_stand_where_they_are_placed() {
    let inner = format!(
        "<model name=\"arm\" placement_frame=\"tip\"><pose relative_to=\"a\">0 0 1 0 0 0</pose>{}\
         <frame name=\"tip\" attached_to=\"x\"><pose>0 0 .5 0 0 0</pose></frame></model>",
        link("x", "<pose>0 0 .25 0 0 0</pose>", "")
    );
    let body = link("a", "<pose>2 0 0 0 0 0</pose>", "")
        + &inner
        + &hinge("j", "revolute", ["a", "arm::tip"], TURN)
        + "<frame name=\"whole\" attached_to=\"arm\"/>"
        + &link("c", "", "")
        + &hinge("k", "fixed", ["whole", "c"], "<pose relative_to=\"__model__\"/>");
    let robot = robot(&body);
    assert_eq!(names(&robot), ["a", "arm::x", "c"]);
    // The joint stands at the tip, which is where the model was placed.
    stands(&robot, "arm::x", DPose3::identity(), [2.0, 0.0, 1.0]);
    stands(&robot, "arm::x", robot.links[1].collisions[0].origin, [2.0, 0.0, 0.5]);
    assert_eq!(robot.joints[1].parent, 1);
}

#[test]
fn what_is_static_or_free_in_a_world_hangs_on_it() {
    let model = |name: &str, more: &str| {
        format!(
            "<model name=\"{name}\"><pose>1 0 0 0 0 0</pose>{more}{}</model>",
            link("l", "", "")
        )
    };
    let ground = "<model name='ground'><static>1</static><link name='l'><collision name='c'>\
        <geometry><plane><normal>0 0 1</normal></plane></geometry></collision></link></model>";
    let body = model("shelf", "<static>true</static>") + &model("cup", "") + ground;
    let robot = whole(of("1.6", &format!("<world name=\"w\">{body}</world>")));
    assert_eq!(names(&robot), ["world", "shelf::l", "cup::l", "ground::l"]);
    let kinds: Vec<_> = robot.joints.iter().map(|j| j.kind).collect();
    assert_eq!(kinds, [Motion::Fixed, Motion::Floating, Motion::Fixed]);
    assert_eq!(robot.beside.floats, Some(true));
    assert!(robot.links[3].collisions.is_empty(), "a plane is the ground");
}

#[test]
fn joints_told_from_the_far_end_and_loops_become_one_tree() {
    let turned = link("a", "", "")
        + &link("b", "", "")
        + &link("c", "", "")
        + &hinge("w", "fixed", ["world", "a"], "")
        + &hinge("j", "revolute", ["b", "a"], TURN)
        + &hinge("k", "revolute", ["b", "c"], TURN);
    let robot = robot(&turned);
    assert_eq!(names(&robot)[0], "world");
    let j = robot.joints.iter().find(|j| j.name == "j").unwrap();
    assert_eq!((names(&robot)[j.parent], names(&robot)[j.child], j.axis), ("a", "b", -DVec3::Z));
    let loops = turned + &hinge("l", "revolute", ["c", "a"], TURN);
    let robot = self::robot(&loops);
    let held: Vec<_> = robot.joints.iter().filter(|j| j.held.is_some()).collect();
    assert_eq!(held.iter().map(|j| j.name.as_str()).collect::<Vec<_>>(), ["j", "k"]);
    assert!(held[0].held.as_ref().unwrap().contains("closed loop (line 2: joint `l`)"));
}

#[test]
fn every_kind_of_joint_is_known() {
    let two = "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>";
    let one = |kind: &str, more: &str| {
        robot(&(link("a", "", "") + &link("b", "", "") + &hinge("j", kind, ["a", "b"], more)))
    };
    for kind in ["universal", "revolute2"] {
        let robot = one(kind, two);
        let axes: Vec<_> = robot.joints.iter().map(|j| (j.name.as_str(), j.axis)).collect();
        assert_eq!(axes, [("j", DVec3::X), ("j__2", DVec3::Y)], "{kind}");
        assert!(robot.links.iter().any(|l| l.between && l.name == "b__0"));
    }
    for (kind, motion) in [("continuous", Motion::Continuous), ("prismatic", Motion::Prismatic)] {
        assert_eq!(one(kind, TURN).joints[0].kind, motion);
    }
    for kind in ["ball", "screw"] {
        assert!(one(kind, TURN).joints[0].held.is_some(), "{kind}");
    }
    let odd = link("a", "", "") + &link("b", "", "") + &hinge("j", "hinge", ["a", "b"], TURN);
    assert!(evidence(&read(&odd), "T2")[0].ends_with("joint type `hinge` is unknown"));
}

#[test]
fn limits_without_end_are_none_and_mimics_follow() {
    let limit = |lower: &str, upper: &str| {
        format!(
            "<axis><xyz>0 0 1</xyz><limit><lower>{lower}</lower><upper>{upper}</upper>\
             <effort>-1</effort><velocity>2</velocity></limit><dynamics><damping>.5</damping>\
             <spring_stiffness>3</spring_stiffness></dynamics></axis>"
        )
    };
    let of = |lower: &str, upper: &str, kind: &str| {
        let joint = hinge("j", kind, ["a", "b"], &limit(lower, upper));
        robot(&(link("a", "", "") + &link("b", "", "") + &joint)).joints[0].clone()
    };
    let endless = of("-1e16", "1e16", "revolute");
    assert_eq!((endless.kind, endless.limit.unwrap().velocity), (Motion::Continuous, Some(2.0)));
    assert_eq!(endless.limit.unwrap().effort, None);
    assert_eq!(
        (endless.dynamics.unwrap().damping, endless.spring.unwrap().stiffness),
        (Some(0.5), 3.0)
    );
    assert_eq!(of("-inf", "inf", "revolute").kind, Motion::Continuous);
    assert_eq!(of("-inf", "inf", "prismatic").limit, None);
    assert_eq!(of("0", "2", "prismatic").limit.unwrap().upper, 2.0);
    let mimic = "<axis><xyz>0 0 1</xyz><mimic joint=\"j\" axis=\"axis\"><multiplier>2</multiplier>\
        <offset>.5</offset><reference>.1</reference></mimic></axis>";
    let body = link("a", "", "")
        + &link("b", "", "")
        + &link("c", "", "")
        + &hinge("j", "revolute", ["a", "b"], TURN)
        + &hinge("k", "revolute", ["a", "c"], mimic);
    let follows = robot(&body).joints[1].mimic.unwrap();
    assert_eq!((follows.joint, follows.multiplier), (0, 2.0));
    assert!((follows.offset - 0.3).abs() < 1e-15);
}

#[test]
fn masses_are_told_or_follow_from_the_collisions() {
    let told = "<inertial><pose>0 0 1 0 0 0</pose><mass>2</mass><inertia><ixx>3</ixx><iyy>4</iyy>\
        <izz>5</izz><ixy>.1</ixy></inertia></inertial>";
    let inertial = robot(&link("a", "", told)).links[0].inertial.unwrap();
    assert_eq!((inertial.mass, inertial.origin.translation), (2.0, DVec3::Z));
    assert_eq!((inertial.inertia.x_axis.y, inertial.inertia.z_axis.z), (0.1, 5.0));
    let auto = |more: &str| {
        let text = format!(
            "<link name='a'><inertial auto='true'>{more}</inertial><collision name='c'>\
             <pose>0 0 1 0 0 0</pose><density>500</density>{}</collision><collision name='d'>\
             <geometry><cone><radius>1</radius><length>4</length></cone></geometry></collision></link>",
            shape("1 1 1")
        );
        robot(&text).links[0].inertial.unwrap()
    };
    let cone = PI * 4.0 / 3.0;
    let all = auto("");
    assert!((all.mass - 500.0 - cone * 1000.0).abs() < 1e-9, "{}", all.mass);
    let height = (500.0 - cone * 1000.0) / all.mass;
    assert!((all.origin.translation.z - height).abs() < 1e-12);
    assert!((auto("<density>10</density>").mass - 500.0 - cone * 10.0).abs() < 1e-9);
    let scaled = auto("<mass>7</mass>");
    assert_eq!(scaled.mass, 7.0);
    assert!((scaled.inertia.x_axis.x / all.inertia.x_axis.x - 7.0 / all.mass).abs() < 1e-12);
}

#[test]
fn shapes_have_their_geometry_colours_and_masks() {
    let kinds = [
        "<sphere><radius>1</radius></sphere>",
        "<capsule><radius>1</radius><length>2</length></capsule>",
        "<ellipsoid><radii>1 2 3</radii></ellipsoid>",
        "<polyline><point>0 0</point><point>1 0</point><point>0 1</point><height>1</height></polyline>",
        "<heightmap><uri>x.png</uri></heightmap>",
        "<box><size>1 2</size></box>",
        "<empty/>",
    ];
    let all: String = kinds
        .iter()
        .map(|k| {
            format!(
                "<visual name='v'><geometry>{k}</geometry><material><diffuse>1 0 0 1</diffuse></material></visual>"
            )
        })
        .collect();
    let masked = format!(
        "<collision name='c'>{}<surface><contact><collide_bitmask>0x02</collide_bitmask></contact></surface></collision>",
        shape("1 1 1")
    );
    let loaded = read(&format!("<link name='a'>{all}{masked}</link>"));
    assert!(evidence(&loaded, "F1")[0].ends_with("`1 2` must be 3 numbers, found 2"));
    let robot = whole(loaded);
    let [_, _, Geometry::Ellipsoid { half }, Geometry::Mesh(prism), ..] =
        &robot.links[0].visuals.iter().map(|v| v.geometry.clone()).collect::<Vec<_>>()[..]
    else {
        panic!("{:?}", robot.links[0].visuals)
    };
    assert_eq!((*half, prism.signed_volume()), (DVec3::new(1.0, 2.0, 3.0), 0.5));
    let unread = |s: &&crate::robot::Shape| matches!(s.geometry, Geometry::Unread { .. });
    assert_eq!(robot.links[0].visuals.iter().filter(unread).count(), 2);
    assert_eq!(robot.links[0].visuals[0].colour, Some([255, 0, 0, 255]));
    assert_eq!(robot.links[0].collisions[0].mask, [2, 2]);
}

#[test]
fn references_that_lead_nowhere_are_named_with_their_line() {
    let body =
        |pose: &str, joint: &str| read(&(link("a", "", "") + "\n" + &link("b", pose, "") + joint));
    let joint = hinge("j", "fixed", ["a", "nowhere"], "");
    let found = evidence(&body("", &joint), "T1");
    assert_eq!(found[0], "line 3: joint `j` names the child `nowhere`, which does not exist");
    let joint = hinge("j", "fixed", ["a", "b"], "");
    let found = evidence(&body("<pose relative_to='x'/>", &joint), "T1");
    assert_eq!(found, ["line 3: where this stands is not known: there is no frame `x`"]);
    let found = evidence(&body("<pose relative_to='b'/>", &joint), "T1");
    assert!(found[0].ends_with("told in frames that go round in a circle"), "{found:?}");
    let found = evidence(&read("<frame name='f' attached_to='f'/>"), "T1");
    assert!(!found.is_empty());
    let loaded = of("1.9", "<light name='sun'/>");
    assert_eq!(evidence(&loaded, "F1"), ["line 1: `sdf`: there is no `model` in it"]);
    let twice = evidence(&read(&(link("a", "", "") + &link("a", "", ""))), "T1");
    assert!(twice.iter().any(|e| e.ends_with("two links are called `a`")), "{twice:?}");
}

#[test]
fn a_chain_as_long_as_frames_may_be_ends() {
    let frames: String = (0..2000)
        .map(|k| {
            format!("<frame name='f{k}' attached_to='f{}'><pose>1 0 0 0 0 0</pose></frame>", k + 1)
        })
        .collect();
    let body = link("a", "<pose relative_to='f0'/>", "") + &frames + "<frame name='f2000'/>";
    let robot = robot(&body);
    stands(&robot, "a", robot.links[0].collisions[0].origin, [2000.0, 0.0, 0.0]);
    let quarter = DPose3::rotation(DVec3::Z * FRAC_PI_2);
    assert!((quarter * DVec3::X - DVec3::Y).length() < 1e-12);
    let many: String = (0..9000).map(|k| format!("<frame name='f{k}'/>")).collect();
    assert!(evidence(&read(&(link("a", "", "") + &many)), "F1")[0].contains("8192 frames"));
    let links: String = (0..600).map(|k| link(&format!("l{k}"), "", "")).collect();
    assert!(evidence(&read(&links), "F1")[0].contains("at most 512 links and joints"));
}
