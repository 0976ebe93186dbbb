//! Models as other people write them, each with one thing that made the check say nothing, or the
//! wrong thing.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail as tests do")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use sim_check::{Asked, Base, Check, CheckOptions, Places, Status, Subject, Tier, Verdict, check};

/// A folder of its own for files that a test writes.
struct Place(PathBuf);

impl Place {
    fn new(name: &str) -> Self {
        let place = std::env::temp_dir().join(format!("kinfold-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&place);
        std::fs::create_dir_all(&place).unwrap();
        Self(place)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let file = self.0.join(name);
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(&file, bytes).unwrap();
        file
    }

    /// The verdict on a model, as found, up to `dynamic`.
    fn judge(&self, name: &str, text: &str) -> Verdict {
        judge(&self.write(name, text), found())
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn found() -> CheckOptions {
    CheckOptions { up_to: Tier::Dynamic, subject: Asked::Found, ..CheckOptions::default() }
}

fn judge(file: &Path, options: CheckOptions) -> Verdict {
    check(file, &options)
}

fn of<'v>(verdict: &'v Verdict, id: &str) -> &'v Check {
    verdict.check(id).unwrap_or_else(|| panic!("{id} is not asked: {}", verdict.to_json()))
}

#[track_caller]
fn is(verdict: &Verdict, id: &str, status: Status) {
    let found = of(verdict, id);
    assert_eq!(found.status, status, "{id}: {found:?}");
}

/// The ids that do not hold.
fn open(verdict: &Verdict) -> Vec<&str> {
    verdict.checks.iter().filter(|c| c.counts_against()).map(|c| c.id.as_str()).collect()
}

const CUBE: &str = "v -.1 -.1 -.1\nv -.1 -.1 .1\nv -.1 .1 -.1\nv -.1 .1 .1\nv .1 -.1 -.1\nv .1 -.1 .1\n\
    v .1 .1 -.1\nv .1 .1 .1\nf 1 2 4\nf 1 4 3\nf 5 7 8\nf 5 8 6\nf 1 5 6\nf 1 6 2\nf 3 4 8\nf 3 8 7\n\
    f 1 3 7\nf 1 7 5\nf 2 6 8\nf 2 8 4\n";

/// A cube of 2 kg, 200 mm wide, seen and touched as that mesh.
fn cube(mesh: &str) -> String {
    let i = 2.0 * 0.04 * 2.0 / 12.0;
    let shape = format!("<geometry><mesh filename=\"{mesh}\"/></geometry>");
    format!(
        "<robot name=\"case\"><link name=\"cube\"><inertial><mass value=\"2\"/><inertia ixx=\"{i}\" \
         iyy=\"{i}\" izz=\"{i}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial><visual>{shape}</visual>\
         <collision>{shape}</collision></link></robot>"
    )
}

/// A carcass with a door, hinged `out` of its front at its left side.
fn door(out: f64, name: &str) -> String {
    let boxed = |x: f64, z: f64, size: &str| {
        let origin =
            format!("<origin xyz=\"{x} 0 {z}\"/><geometry><box size=\"{size}\"/></geometry>");
        format!("<visual>{origin}</visual><collision>{origin}</collision>")
    };
    // The door is 20 mm thick and stands 2 mm off; its middle lies 12 mm out.
    let y = 0.012 - out;
    let inner = boxed(0.2, 0.0, "0.396 0.02 0.6").replace("0.2 0 0", &format!("0.2 {} 0", -y));
    let carcass = boxed(0.0, 0.3, "0.4 0.4 0.6");
    format!(
        "<robot name=\"case\"><link name=\"carcass\"><inertial><origin xyz=\"0 0 0.3\"/><mass value=\"20\"/>\
         <inertia ixx=\".8667\" iyy=\".8667\" izz=\".5333\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>{carcass}</link>\
         <link name=\"{name}\"><inertial><origin xyz=\"0.2 {} 0\"/><mass value=\"2\"/><inertia ixx=\".06007\" \
         iyy=\".08614\" izz=\".0262\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>{inner}</link>\
         <joint name=\"hinge\" type=\"revolute\"><parent link=\"carcass\"/><child link=\"{name}\"/>\
         <origin xyz=\"-0.2 {} 0.3\"/><axis xyz=\"0 0 -1\"/><limit lower=\"0\" upper=\"1.5\" effort=\"10\" \
         velocity=\"1\"/><dynamics damping=\"1\" friction=\"0.5\"/></joint></robot>",
        -y,
        -0.2 - out
    )
}

/// The same door in MJCF, with these words for its joint and after the world.
fn mjcf_door(joint: &str, after: &str) -> String {
    format!(
        "<mujoco model=\"case\"><compiler angle=\"radian\"/><worldbody><body name=\"carcass\"><geom type=\"box\" \
         size=\".2 .2 .3\" pos=\"0 0 .3\" mass=\"20\"/><body name=\"door\" pos=\"-.2 -.212 .3\"><joint name=\"hinge\" \
         axis=\"0 0 -1\" damping=\"1\" frictionloss=\".5\" {joint}/><geom type=\"box\" size=\".198 .01 .3\" \
         pos=\".2 0 0\" mass=\"2\"/></body></body></worldbody>{after}</mujoco>"
    )
}

const RANGE: &str = "range=\"0 1.5\"";
const MOTOR: &str = "<actuator><motor joint=\"hinge\" ctrlrange=\"-10 10\"/></actuator>";

#[test]
fn a_mesh_at_package_is_found_beside_the_file_and_the_rest_is_judged() {
    let place = Place::new("packages");
    place.write("ros/arm/package.xml", "<package><name>arm</name></package>");
    place.write("ros/arm/meshes/cube.obj", CUBE);
    for (folder, address) in [
        ("ros/arm/urdf", "package://arm/meshes/cube.obj"),
        ("ros/arm/urdf/deep/er", "package://arm/meshes/cube.obj"),
        ("ros/other/urdf", "package://arm/meshes/cube.obj"),
        ("ros/arm/urdf", "model://arm/meshes/cube.obj"),
        ("ros/arm/urdf", "file://package://arm/meshes/cube.obj"),
        ("ros/arm/urdf", "$(find arm)/meshes/cube.obj"),
        ("ros/arm/urdf", "../meshes/cube.obj"),
    ] {
        let file = place.write(&format!("{folder}/a.urdf"), cube(address));
        let verdict = judge(&file, found());
        assert!(of(&verdict, "F2").holds(), "{address}: {:?}", of(&verdict, "F2"));
        assert_eq!((verdict.tier, open(&verdict)), (Tier::Dynamic, vec![]), "{address}");
    }
    let file = place.write("ros/arm/urdf/b.urdf", cube("package://lost/meshes/cube.obj"));
    let lost = judge(&file, found());
    is(&lost, "F2", Status::Fail);
    let packages = BTreeMap::from([("lost".to_owned(), place.0.join("ros/arm"))]);
    let told = CheckOptions { places: Places { packages, ..Places::default() }, ..found() };
    assert_eq!(judge(&file, told).tier, Tier::Dynamic, "--package says where it is");
}

#[test]
fn a_package_gives_nothing_from_outside_of_it() {
    let place = Place::new("escape");
    place.write("arm/package.xml", "<package><name>arm</name></package>");
    place.write("secret.obj", CUBE);
    for address in ["package://arm/../secret.obj", "../../secret.obj", "package://../secret.obj"] {
        let file = place.write("arm/urdf/a.urdf", cube(address));
        is(&judge(&file, found()), "F2", Status::Fail);
    }
}

#[test]
fn a_model_whose_mesh_is_collada_gets_the_verdict_of_its_twin() {
    let place = Place::new("collada");
    place.write("cube.obj", CUBE);
    let numbers: String =
        CUBE.lines().filter_map(|l| l.strip_prefix("v ")).collect::<Vec<_>>().join(" ");
    let faces = CUBE.lines().filter_map(|l| l.strip_prefix("f ")).flat_map(str::split_whitespace);
    let faces: Vec<String> = faces.map(|i| (i.parse::<u32>().unwrap() - 1).to_string()).collect();
    for (unit, scale) in [("1", 1.0), ("0.001", 1000.0)] {
        let numbers = numbers.split_whitespace().map(|n| n.parse::<f64>().unwrap() * scale);
        let numbers: Vec<String> = numbers.map(|n| n.to_string()).collect();
        place.write("cube.dae", format!(
            "<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\"><asset><unit meter=\"{unit}\"/></asset>\
             <library_geometries><geometry id=\"g\"><mesh><source id=\"p\"><float_array>{}</float_array></source>\
             <vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices><triangles><input \
             semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>{}</p></triangles></mesh></geometry>\
             </library_geometries></COLLADA>",
            numbers.join(" "), faces.join(" ")
        ));
        let [dae, obj] = ["cube.dae", "cube.obj"].map(|mesh| place.judge("a.urdf", &cube(mesh)));
        let told =
            |v: &Verdict| v.checks.iter().map(|c| (c.id.clone(), c.status)).collect::<Vec<_>>();
        assert_eq!(told(&dae), told(&obj), "{unit}");
        assert_eq!(dae.tier, Tier::Dynamic);
    }
}

#[test]
fn a_mesh_that_is_not_read_makes_no_neighbour_a_fault() {
    let place = Place::new("unread");
    let model =
        door(0.012, "door").replace("<box size=\"0.4 0.4 0.6\"/>", "<mesh filename=\"a.step\"/>");
    place.write("a.step", "solid");
    let verdict = place.judge("a.urdf", &model);
    for id in ["G4", "M2", "M4", "M5", "J5", "C1", "C2"] {
        is(&verdict, id, Status::Unknown);
    }
    assert!(
        verdict.checks.iter().all(|c| c.status != Status::Fail || !c.counts_against()),
        "{}",
        verdict.to_json()
    );
}

#[test]
fn one_number_that_cannot_be_read_costs_its_own_element_alone() {
    let place = Place::new("flaw");
    let whole = door(0.012, "door");
    for (from, to, open) in [
        ("size=\"0.396 0.02 0.6\"", "size=\"0,396 0.02 0.6\"", "G2"),
        ("ixx=\".06007\"", "ixx=\"1e\"", "M4"),
        ("upper=\"1.5\"", "upper=\"wide\"", "C2"),
        ("damping=\"1\"", "damping=\"nan\"", "C2"),
    ] {
        let verdict = place.judge("a.urdf", &whole.replace(from, to));
        is(&verdict, "F1", Status::Fail);
        is(&verdict, open, Status::Unknown);
        let failed: Vec<_> = verdict.failures().filter(|c| c.status == Status::Fail).collect();
        assert_eq!(failed.len(), 1, "{to}: {failed:?}");
        is(&verdict, "M6", if open == "M4" { Status::Unknown } else { Status::Pass });
    }
}

#[test]
fn several_numbers_under_numeric_do_no_harm() {
    let place = Place::new("numeric");
    let plain = place.judge("a.xml", &mjcf_door(RANGE, MOTOR));
    for data in ["0.0 0.5", "1 2 3 4 5 6 7", "x"] {
        let custom =
            format!("{MOTOR}<custom><numeric name=\"init_qpos\" data=\"{data}\"/></custom>");
        let verdict = place.judge("a.xml", &mjcf_door(RANGE, &custom));
        assert_eq!((verdict.tier, open(&verdict)), (plain.tier, open(&plain)), "{data}");
    }
    assert_eq!(plain.tier, Tier::Dynamic, "{:?}", open(&plain));
}

#[test]
fn geoms_beyond_inertiagrouprange_weigh_nothing() {
    let place = Place::new("groups");
    let heavy = "<geom type=\"box\" size=\".1 .1 .1\" density=\"50000\" group=\"5\" contype=\"0\" conaffinity=\"0\"/>";
    let with = |range: &str| {
        let text = mjcf_door(RANGE, MOTOR)
            .replace("mass=\"2\"/></body>", &format!("mass=\"2\"/>{heavy}</body>"));
        text.replace("angle=\"radian\"", &format!("angle=\"radian\" {range}"))
    };
    let density = |range: &str| of(&place.judge("a.xml", &with(range)), "M6").value.unwrap();
    assert!((density("inertiagrouprange=\"0 3\"") - 10.0).abs() < 1e-9);
    assert!(density("inertiagrouprange=\"0 5\"") < 0.1 && density("") < 0.1);
}

#[test]
fn a_mirrored_mesh_faces_outward_as_the_plain_one_does() {
    let place = Place::new("mirrored");
    place.write("cube.obj", CUBE);
    for scale in ["-1 1 1", "1 -1 1", "1 1 -1", "-1 -1 -1", "-1 -1 1"] {
        let mesh = format!("filename=\"cube.obj\" scale=\"{scale}\"");
        let verdict =
            place.judge("a.urdf", &cube("cube.obj").replace("filename=\"cube.obj\"", &mesh));
        for id in ["G1", "G2", "G3", "M2", "M4"] {
            is(&verdict, id, Status::Pass);
        }
        is(&verdict, "U1", Status::Fail);
    }
}

#[test]
fn tendons_sensors_and_keyframes_change_no_verdict() {
    let place = Place::new("tendons");
    let plain = place.judge("a.xml", &mjcf_door(RANGE, MOTOR));
    for more in [
        "<tendon><fixed name=\"t\"><joint joint=\"hinge\" coef=\"1\"/></fixed></tendon>",
        "<sensor><jointpos joint=\"hinge\"/></sensor>",
        "<keyframe><key name=\"home\" qpos=\"0.5\"/></keyframe>",
        "<contact><exclude body1=\"carcass\" body2=\"door\"/></contact>",
    ] {
        let verdict = place.judge("a.xml", &mjcf_door(RANGE, &format!("{MOTOR}{more}")));
        assert_eq!((verdict.tier, open(&verdict)), (plain.tier, open(&plain)), "{more}");
    }
}

#[test]
fn a_passive_joint_of_mjcf_needs_no_effort() {
    let place = Place::new("passive");
    for actuator in [
        "",
        "<actuator><motor joint=\"hinge\"/></actuator>",
        "<actuator><position joint=\"hinge\" kp=\"50\" ctrlrange=\"0 1.5\"/></actuator>",
        "<actuator><velocity joint=\"hinge\"/></actuator>",
    ] {
        let verdict = place.judge("a.xml", &mjcf_door(RANGE, actuator));
        is(&verdict, "J4", Status::Warn);
        is(&verdict, "S4", Status::Pass);
        assert_eq!(verdict.tier, Tier::Dynamic, "{actuator}");
    }
    let text = door(0.012, "door").replace("effort=\"10\" ", "");
    is(&place.judge("a.urdf", &text), "J4", Status::Fail);
}

#[test]
fn a_servo_that_is_asked_beyond_its_joint_is_told() {
    let place = Place::new("servo");
    let servo = |range: &str| {
        format!("<actuator><position joint=\"hinge\" kp=\"9\" ctrlrange=\"{range}\"/></actuator>")
    };
    let told = |range: &str| {
        let verdict = place.judge("a.xml", &mjcf_door(RANGE, &servo(range)));
        of(&verdict, "J4").evidence.iter().any(|e| e.contains("may ask joint `hinge`"))
    };
    assert!(told("-1 1.5") && told("0 3.14") && !told("0 1.5") && !told("0.2 1"));
}

#[test]
fn a_spring_holds_what_gravity_pulls_at() {
    let place = Place::new("springs");
    let flap = |joint: &str| {
        format!(
            "<mujoco><compiler angle=\"radian\"/><worldbody><body name=\"chest\"><geom type=\"box\" size=\".2 .2 .2\" \
             pos=\"0 0 .2\" mass=\"10\"/><body name=\"flap\" pos=\"0 -.215 .35\" euler=\".2 0 0\"><joint name=\"hinge\" \
             axis=\"1 0 0\" range=\"0 1.4\" damping=\".05\" {joint}/><geom type=\"box\" size=\".18 .01 .1\" pos=\"0 0 .1\" \
             mass=\".4\"/></body></body></worldbody></mujoco>"
        )
    };
    for (joint, holds) in [
        ("", false),
        ("stiffness=\"20\" springref=\"0\"", true),
        ("stiffness=\"20\"", true),
        ("stiffness=\"0.01\"", false),
        ("stiffness=\"20\" springref=\"1.2\"", false),
    ] {
        let status = if holds { Status::Pass } else { Status::Fail };
        is(&place.judge("a.xml", &flap(joint)), "J7", status);
    }
}

#[test]
fn a_range_without_0_is_judged_from_its_nearest_end_or_the_keyframe() {
    let place = Place::new("rest");
    let home = |q: &str| format!("{MOTOR}<keyframe><key name=\"home\" qpos=\"{q}\"/></keyframe>");
    let declared = place.judge("a.xml", &mjcf_door("range=\"0.3 1.5\"", &home("0.3")));
    is(&declared, "J2", Status::Pass);
    assert!(of(&declared, "J2").evidence[0].contains("keyframe `home`"), "{declared:?}");
    let beyond = place.judge("a.xml", &mjcf_door("range=\"0.3 1.5\"", &home("0.1")));
    is(&beyond, "J2", Status::Fail);
    let knee = door(0.012, "door").replace("lower=\"0\"", "lower=\"0.3\"");
    let urdf = place.judge("a.urdf", &knee);
    is(&urdf, "J2", Status::Fail);
    assert_eq!(
        of(&urdf, "J2").evidence,
        ["line 1: joint `hinge`: limits 0.3 to 1.5 leave out the rest pose 0"]
    );
    for verdict in [&declared, &beyond, &urdf] {
        for id in ["C1", "C2", "C3", "S1", "S3", "S5"] {
            is(verdict, id, Status::Pass);
        }
    }
    let robot = CheckOptions { subject: Asked::As(Subject::Robot), ..found() };
    let verdict = judge(&place.write("a.urdf", knee), robot);
    is(&verdict, "J2", Status::Warn);
}

#[test]
fn a_door_hangs_at_its_inner_face_its_middle_or_its_outer_face() {
    let place = Place::new("hinges");
    for out in [0.002, 0.007, 0.012, 0.022] {
        let verdict = place.judge("a.urdf", &door(out, "door"));
        is(&verdict, "C4", Status::Pass);
        assert_eq!((verdict.tier, open(&verdict)), (Tier::Dynamic, vec![]), "{out}");
    }
    // An axis 30 mm before the door holds nothing.
    is(&place.judge("a.urdf", &door(0.052, "door")), "C4", Status::Fail);
}

#[test]
fn a_follower_beyond_its_own_limits_is_a_contradiction() {
    let place = Place::new("mimic");
    let finger = |factor: &str, lower: &str, upper: &str| {
        let body = "<inertial><mass value=\"1\"/><inertia ixx=\".01\" iyy=\".01\" izz=\".01\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>";
        let joint = |name: &str, child: &str, range: (&str, &str), more: &str| {
            format!(
                "<joint name=\"{name}\" type=\"prismatic\"><parent link=\"palm\"/><child link=\"{child}\"/><axis xyz=\"1 0 0\"/>\
                 <limit lower=\"{}\" upper=\"{}\" effort=\"5\" velocity=\"1\"/>{more}</joint>",
                range.0, range.1
            )
        };
        let mimic = format!("<mimic joint=\"left\" {factor}/>");
        format!(
            "<robot name=\"case\"><link name=\"palm\">{body}</link><link name=\"a\">{body}</link><link name=\"b\">{body}</link>{}{}</robot>",
            joint("left", "a", ("0", "0.02"), ""),
            joint("right", "b", (lower, upper), &mimic)
        )
    };
    for (factor, lower, upper, status) in [
        ("multiplier=\"1\"", "0", "0.02", Status::Pass),
        ("multiplier=\"1\"", "0", "0.01", Status::Fail),
        ("multiplier=\"-1\"", "-0.02", "0", Status::Pass),
        ("multiplier=\"-1\"", "0", "0.02", Status::Fail),
        ("multiplier=\"2\"", "0", "0.02", Status::Fail),
        ("multiplier=\"0.5\" offset=\"0.02\"", "0", "0.02", Status::Fail),
    ] {
        is(&place.judge("a.urdf", &finger(factor, lower, upper)), "J2", status);
    }
}

#[test]
fn names_with_hyphens_digits_and_dots_are_a_flag_and_no_broken_file() {
    let place = Place::new("names");
    for name in ["left-door", "1", "door.left", "Tür"] {
        let verdict = place.judge("a.urdf", &door(0.012, name));
        is(&verdict, "F3", Status::Warn);
        assert!(of(&verdict, "F3").evidence[0].contains("USD"), "{name}");
        assert_eq!(verdict.tier, Tier::Dynamic, "{name}");
        let asset = CheckOptions { subject: Asked::Asset, ..found() };
        is(&judge(&place.0.join("a.urdf"), asset), "F3", Status::Fail);
    }
    let twice = door(0.012, "carcass");
    is(&place.judge("a.urdf", &twice), "F3", Status::Fail);
}

#[test]
fn an_obj_in_any_code_page_with_a_mark_or_with_continued_lines_is_read() {
    let place = Place::new("obj");
    let latin: Vec<u8> = [b"# caf\xe9\no gr\xfcn\n", CUBE.as_bytes()].concat();
    let marked: Vec<u8> = ["\u{feff}".as_bytes(), CUBE.as_bytes()].concat();
    let continued =
        CUBE.replace("f 1 2 4", "f 1 \\\n2 4").replace("v .1 .1 .1", "v .1 .1 \\\r\n .1");
    for bytes in [latin, marked, continued.into_bytes()] {
        place.write("cube.obj", &bytes);
        let verdict = place.judge("a.urdf", &cube("cube.obj"));
        assert_eq!((verdict.tier, open(&verdict)), (Tier::Dynamic, vec![]));
    }
}

#[test]
fn an_inertia_told_in_other_axes_than_the_link_s_is_seen() {
    let place = Place::new("turned");
    let right = door(0.012, "door");
    is(&place.judge("a.urdf", &right), "M4", Status::Pass);
    // The door's moments about x, y and z, in any other order.
    for [x, y, z] in [
        [".06007", ".0262", ".08614"],
        [".0262", ".08614", ".06007"],
        [".08614", ".0262", ".06007"],
    ] {
        let wrong = right
            .replace("ixx=\".06007\"", &format!("ixx=\"{x}\""))
            .replace("iyy=\".08614\"", &format!("iyy=\"{y}\""))
            .replace("izz=\".0262\"", &format!("izz=\"{z}\""));
        is(&place.judge("a.urdf", &wrong), "M4", Status::Fail);
    }
}

#[test]
fn what_is_unknown_is_never_said_to_overlap_and_the_reason_is_told() {
    let place = Place::new("sizes");
    for shape in [
        "<sphere radius=\"-0.1\"/>",
        "<box size=\"0.2 0 0.2\"/>",
        "<cylinder radius=\"0\" length=\"1\"/>",
    ] {
        let text = cube("x").replace("<mesh filename=\"x\"/>", shape);
        let verdict = place.judge("a.urdf", &text);
        is(&verdict, "G2", Status::Fail);
        let told = verdict.checks.iter().flat_map(|c| &c.evidence);
        assert!(
            told.clone().all(|e| !e.contains("flung apart: parts") && !e.contains("overlap")),
            "{shape}"
        );
        assert!(of(&verdict, "S1").evidence[0].contains("must be positive"), "{shape}");
        assert!(of(&verdict, "U2").evidence[0].contains("must be positive"), "{shape}");
        for id in ["M1", "M3", "J1", "J2"] {
            is(&verdict, id, Status::Pass);
        }
    }
}

#[test]
fn a_model_is_told_as_a_robot_or_an_object_and_may_be_told_which() {
    let place = Place::new("subject");
    let object = place.judge("a.urdf", &door(0.012, "door"));
    let judged = object.judged.clone().unwrap();
    assert_eq!((judged.subject, judged.base), (Subject::Object, Base::Free));
    let robot = place.judge("a.urdf", &door(0.012, "upper_arm"));
    let judged = robot.judged.clone().unwrap();
    assert_eq!(
        (judged.subject, judged.base, judged.because.as_str()),
        (Subject::Robot, Base::Fixed, "link `upper_arm`")
    );
    assert!(robot.check("U3").is_none() && robot.check("J7").is_none());
    let options =
        CheckOptions { subject: Asked::As(Subject::Object), base: Some(Base::Fixed), ..found() };
    let told = judge(&place.0.join("a.urdf"), options).judged.unwrap();
    assert_eq!((told.subject, told.base), (Subject::Object, Base::Fixed));
    let asset = judge(&place.0.join("a.urdf"), CheckOptions::default());
    assert!(asset.judged.is_none() && !asset.to_json().contains("\"judged\""));
}

#[test]
fn a_xacro_with_macros_and_packages_is_judged_as_what_it_becomes() {
    let place = Place::new("xacro");
    place.write("arm/package.xml", "<package><name>arm</name></package>");
    place.write("arm/meshes/cube.obj", CUBE);
    let macros = cube("package://$(arg where)/meshes/${mesh}.obj")
        .replace("<robot name=\"case\">", "<robot xmlns:xacro=\"http://ros.org/wiki/xacro\"><xacro:macro name=\"cube\" params=\"name mesh:=cube\">")
        .replace("link name=\"cube\"", "link name=\"${name}\"")
        .replace("</robot>", "</xacro:macro></robot>");
    place.write("arm/urdf/cube.xacro", macros);
    let main = "<robot name=\"case\" xmlns:xacro=\"http://ros.org/wiki/xacro\">\n<xacro:arg name=\"where\" default=\"arm\"/>\n\
                <xacro:include filename=\"$(find arm)/urdf/cube.xacro\"/>\n<xacro:cube name=\"one\"/></robot>";
    let file = place.write("arm/urdf/main.xacro", main);
    let verdict = judge(&file, found());
    assert_eq!((verdict.tier, verdict.links, open(&verdict)), (Tier::Dynamic, 1, vec![]));
    let lost = main.replace("urdf/cube.xacro", "urdf/lost.xacro");
    let verdict = judge(&place.write("arm/urdf/lost_main.xacro", lost), found());
    is(&verdict, "F2", Status::Fail);
}

#[test]
fn an_mjcf_in_several_files_is_one_model() {
    let place = Place::new("include");
    let whole = place.judge("whole.xml", &mjcf_door(RANGE, MOTOR));
    place.write("parts/motor.xml", format!("<mujocoinclude>{MOTOR}</mujocoinclude>"));
    let parts = mjcf_door(RANGE, "<include file=\"parts/motor.xml\"/>");
    let verdict = place.judge("parts.xml", &parts);
    assert_eq!((verdict.tier, open(&verdict)), (whole.tier, open(&whole)));
    let lost = place.judge("lost.xml", &mjcf_door(RANGE, "<include file=\"parts/lost.xml\"/>"));
    is(&lost, "F2", Status::Fail);
    assert_eq!(lost.tier, Tier::None);
}

/// A palm with three fingers of three joints each; names say nothing.
fn hand(of: &str) -> String {
    let solid = |mass: &str| {
        format!(
            "<inertial><mass value='{mass}'/><inertia ixx='1e-5' iyy='1e-5' izz='1e-5' ixy='0' \
             ixz='0' iyz='0'/></inertial><visual><geometry><box size='.02 .02 .02'/></geometry>\
             </visual><collision><geometry><box size='.02 .02 .02'/></geometry></collision>"
        )
    };
    let mut text = format!("<robot name='r'><link name='a'>{}</link>", solid("0.1"));
    for f in 0..3 {
        for k in 0..3 {
            let above = if k == 0 { "a".to_owned() } else { format!("l{f}{}", k - 1) };
            let y = if k == 0 { 0.05 * f64::from(f) } else { 0.0 };
            text += &format!(
                "<link name='l{f}{k}'>{}</link><joint name='j{f}{k}' type='revolute'>\
                 <origin xyz='0.03 {y} 0'/><parent link='{above}'/><child link='l{f}{k}'/>\
                 <axis xyz='0 1 0'/><limit lower='-0.3' upper='0.3' effort='1' velocity='1'/></joint>",
                solid("0.06")
            );
        }
    }
    text + of + "</robot>"
}

#[test]
fn a_hand_whose_names_say_nothing_is_a_robot() {
    let place = Place::new("hand");
    let verdict = place.judge("hand.urdf", &hand(""));
    let judged = verdict.judged.as_ref().unwrap();
    assert_eq!(judged.subject, Subject::Robot);
    assert!(judged.because.contains("3 limbs"), "{}", judged.because);
}

#[test]
fn frames_without_mass_on_a_link_that_weighs_are_no_fault_of_a_robot() {
    let place = Place::new("frames");
    let frame = |of: &str| {
        format!(
            "<link name='tool'><inertial><mass value='0'/><inertia ixx='0' iyy='0' izz='0' ixy='0' \
             ixz='0' iyz='0'/></inertial></link><joint name='f' type='{of}'><parent link='l02'/>\
             <child link='tool'/><axis xyz='1 0 0'/><limit lower='-1' upper='1' effort='1' \
             velocity='1'/></joint>"
        )
    };
    let verdict = place.judge("fixed.urdf", &hand(&frame("fixed")));
    is(&verdict, "M1", Status::Pass);
    is(&verdict, "M3", Status::Pass);
    // One that moves by itself must weigh; so must the link that carries a frame with mass.
    is(&place.judge("moves.urdf", &hand(&frame("revolute"))), "M1", Status::Fail);
    let heavy =
        frame("fixed").replace("value='0'", "value='0.01'").replace("='0' iyy", "='1e-7' iyy");
    let weightless = hand(&heavy).replacen("value='0.06'", "value='0'", 3);
    is(&place.judge("weightless.urdf", &weightless), "M1", Status::Fail);
}

/// A bracket like a C, 0.4 m by 0.4 m and 0.1 m thick, as a mesh told in place.
fn bracket(attribute: &str) -> String {
    let outline = [(0, 0), (4, 0), (4, 1), (1, 1), (1, 3), (4, 3), (4, 4), (0, 4)];
    let flat = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 7], [4, 5, 6], [4, 6, 7]];
    let (mut points, mut faces) = (String::new(), String::new());
    for z in [0, 1] {
        outline.iter().for_each(|(x, y)| points += &format!("0.{x} 0.{y} 0.{z} "));
    }
    for [a, b, c] in flat {
        faces += &format!("{a} {c} {b} {} {} {} ", a + 8, b + 8, c + 8);
    }
    for i in 0..8 {
        let j = (i + 1) % 8;
        faces += &format!("{i} {j} {} {i} {} {} ", j + 8, j + 8, i + 8);
    }
    format!(
        "<mujoco><asset><mesh name='m' {attribute} vertex='{points}' face='{faces}'/></asset>\
         <worldbody><body name='b'><freejoint/><geom type='mesh' mesh='m'/></body></worldbody></mujoco>"
    )
}

#[test]
fn a_mesh_of_mjcf_weighs_what_mujoco_says_it_weighs() {
    let place = Place::new("weighing");
    // What MuJoCo 4.0.0 says; it reads numbers in single precision.
    for (attribute, kg) in [
        ("", 15.106_842),
        ("inertia='legacy'", 15.106_842),
        ("inertia='exact'", 10.0),
        ("inertia='convex'", 16.0),
        ("inertia='shell'", 420.0),
    ] {
        let file = place.write("bracket.xml", bracket(attribute));
        let robot = sim_check::read::load::read(&file, &found()).robot.unwrap();
        let mass = robot.links[0].inertial.unwrap().mass;
        assert!((mass / kg - 1.0).abs() < 1e-6, "{attribute}: {mass} kg, not {kg} kg");
    }
    let verdict = place.judge("odd.xml", &bracket("inertia='heavy'"));
    is(&verdict, "F1", Status::Fail);
}

#[test]
fn a_mesh_beside_the_included_file_that_names_it_is_found() {
    let place = Place::new("included-mesh");
    place.write(
        "parts/m.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
    );
    let part = "<mujocoinclude><asset><mesh name='m' file='m.obj'/></asset></mujocoinclude>";
    place.write("parts/part.xml", part);
    let model = "<mujoco><include file='parts/part.xml'/><worldbody><body name='b'><freejoint/>\
                 <geom type='mesh' mesh='m'/></body></worldbody></mujoco>";
    is(&place.judge("model.xml", model), "F2", Status::Pass);
    is(&place.judge("lacks.xml", &model.replace("mesh='m'", "mesh='n'")), "F1", Status::Fail);
}

#[test]
fn a_blank_in_a_name_of_mjcf_breaks_nothing() {
    let place = Place::new("blank");
    let model = "<mujoco><worldbody><body name='left hand'><freejoint/><geom type='box' \
                 size='.1 .1 .1'/></body></worldbody></mujoco>";
    is(&place.judge("blank.xml", model), "F3", Status::Warn);
    is(&place.judge("around.xml", &model.replace("left hand", "left ")), "F3", Status::Fail);
}
