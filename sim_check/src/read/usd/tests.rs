//! USD read as links and joints.

use glamx::{DPose3, DVec3};

use crate::options::{Asked, CheckOptions};
use crate::read::formats::Place;
use crate::read::load::{Loaded, read};
use crate::robot::{Geometry, Motion, Robot};

fn of(name: &str, files: &[(&str, String)]) -> Loaded {
    let place = Place::new(name);
    let paths: Vec<_> = files.iter().map(|(name, text)| place.write(name, text)).collect();
    read(&paths[0], &CheckOptions { subject: Asked::Found, ..CheckOptions::default() })
}

fn stage(body: &str) -> String {
    format!(
        "#usda 1.0\n(defaultPrim = \"m\" metersPerUnit = 1 upAxis = \"Z\")\ndef Xform \"m\" {{\n{body}\n}}\n"
    )
}

#[track_caller]
fn whole(loaded: Loaded) -> Robot {
    loaded.robot.unwrap_or_else(|| panic!("{:#?}", loaded.checks))
}

fn evidence(loaded: &Loaded, id: &str) -> Vec<String> {
    loaded.checks.iter().filter(|c| c.id == id).flat_map(|c| c.evidence.clone()).collect()
}

fn body(name: &str, at: &str, more: &str) -> String {
    format!(
        "def Xform \"{name}\" (prepend apiSchemas = [\"PhysicsRigidBodyAPI\", \"PhysicsMassAPI\"]) {{\n\
         double3 xformOp:translate = {at}\n uniform token[] xformOpOrder = [\"xformOp:translate\"]\n{more} }}\n"
    )
}

fn shape(kind: &str, name: &str, more: &str) -> String {
    format!("def {kind} \"{name}\" (prepend apiSchemas = [\"PhysicsCollisionAPI\"]) {{ {more} }}\n")
}

fn joint(kind: &str, name: &str, [from, to]: [&str; 2], more: &str) -> String {
    let rel = |n: u8, body: &str| match body {
        "" => String::new(),
        body => format!("rel physics:body{n} = </m/{body}>\n"),
    };
    format!("def {kind} \"{name}\" {{ {}{}{more} }}\n", rel(0, from), rel(1, to))
}

#[test]
fn bodies_weigh_what_is_told_or_what_their_colliders_do() {
    let told = "float physics:mass = 2\n float3 physics:diagonalInertia = (1, 2, 3)\n \
        point3f physics:centerOfMass = (0, 0, 1)\n quatf physics:principalAxes = (0.70710678, 0, 0, 0.70710678)\n";
    let by = |more: &str| {
        let text = stage(&body(
            "a",
            "(0, 0, 0)",
            &format!("{more}{}", shape("Cube", "c", "double size = 1")),
        ));
        whole(of("weights", &[("a.usda", text)])).links[0].inertial.unwrap()
    };
    let all = by(told);
    let turned = glamx::DMat3::from_quat(all.origin.rotation);
    let inertia = turned * all.inertia * turned.transpose();
    assert_eq!((all.mass, all.origin.translation), (2.0, DVec3::Z));
    assert!((inertia.x_axis.x - 2.0).abs() < 1e-6 && (inertia.y_axis.y - 1.0).abs() < 1e-6);
    assert!((by("").mass - 1000.0).abs() < 1e-9, "a cubic metre of water");
    assert!((by("float physics:density = 10\n").mass - 10.0).abs() < 1e-9);
    let scaled = by("float physics:mass = 6\n");
    assert!((scaled.mass - 6.0).abs() < 1e-9 && (scaled.inertia.x_axis.x - 1.0).abs() < 1e-9);
    let bare = stage(&body("a", "(0, 0, 0)", "float physics:mass = 6\n"));
    let robot = whole(of("bare", &[("a.usda", bare)]));
    assert!(robot.links[0].inertial.is_none() && robot.beside.unread[0].checks.contains(&"M1"));
}

#[test]
fn shapes_take_their_prims_scale_and_what_is_a_guide_is_not_seen() {
    let moved =
        "float3 xformOp:scale = (2, 2, 3)\n uniform token[] xformOpOrder = [\"xformOp:scale\"]\n";
    let inside = [
        shape("Cube", "a", &format!("double size = 1\n{moved}")),
        shape("Sphere", "b", &format!("double radius = 1\n{moved}")),
        shape("Cylinder", "c", &format!("double radius = 1\n double height = 1\n{moved}")),
        shape("Capsule", "d", &format!("double radius = 1\n{moved}")),
        shape(
            "Cylinder",
            "e",
            "double radius = 1\n double height = 4\n token axis = \"X\"\n uniform token purpose = \"guide\"",
        ),
        shape("Plane", "f", ""),
        "def Sphere \"g\" { token visibility = \"invisible\" }\n".to_owned(),
    ];
    let robot =
        whole(of("shapes", &[("a.usda", stage(&body("a", "(1, 0, 0)", &inside.concat())))]));
    let link = &robot.links[0];
    assert_eq!((link.visuals.len(), link.collisions.len()), (4, 5));
    let all: Vec<&Geometry> = link.collisions.iter().map(|s| &s.geometry).collect();
    assert_eq!(*all[0], Geometry::Box { size: DVec3::new(2.0, 2.0, 3.0) });
    assert_eq!(*all[1], Geometry::Ellipsoid { half: DVec3::new(2.0, 2.0, 3.0) });
    assert_eq!(*all[2], Geometry::Cylinder { radius: 2.0, length: 3.0 });
    assert!(matches!(all[3], Geometry::Unread { .. }), "a capsule that is scaled unevenly");
    let along = link.collisions[4].origin.rotation * DVec3::Z;
    assert!((along - DVec3::X).length() < 1e-12, "{along}");
    // One body alone is the root, in the frame of the world.
    assert_eq!(link.collisions[0].origin.translation, DVec3::X);
}

#[test]
fn joints_of_every_kind_are_known() {
    let limits = "float physics:lowerLimit = -90\n float physics:upperLimit = 90\n";
    let locked = |axes: &[&str], free: &str| {
        let apis: Vec<String> = axes.iter().map(|a| format!("\"PhysicsLimitAPI:{a}\"")).collect();
        let all = axes.iter().map(|a| {
            let [low, high] = if *a == free { [-1, 1] } else { [1, -1] };
            format!("float limit:{a}:physics:low = {low}\n float limit:{a}:physics:high = {high}\n")
        });
        let all: String = all.collect();
        joint("PhysicsJoint", "j", ["a", "b"], &all)
            .replace("\"j\" {", &format!("\"j\" (prepend apiSchemas = [{}]) {{", apis.join(", ")))
    };
    let two = || body("a", "(0, 0, 0)", "") + &body("b", "(1, 0, 0)", "");
    let one = |text: String| {
        let robot = whole(of("kinds", &[("a.usda", stage(&(two() + &text)))]));
        robot.joints[0].clone()
    };
    let at = "point3f physics:localPos0 = (1, 0, 0)\n";
    let hinge = one(joint("PhysicsRevoluteJoint", "j", ["a", "b"], &format!("{at}{limits}")));
    assert_eq!((hinge.kind, hinge.axis), (Motion::Revolute, DVec3::X));
    assert!((hinge.limit.unwrap().upper - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert_eq!(one(joint("PhysicsRevoluteJoint", "j", ["a", "b"], at)).kind, Motion::Continuous);
    let slide = one(joint("PhysicsPrismaticJoint", "j", ["a", "b"], limits));
    // The bodies stand a metre apart along the axis: that is the joint's value there.
    assert_eq!((slide.kind, slide.rest), (Motion::Prismatic, 1.0));
    assert_eq!(slide.limits_as_written(), Some((-90.0, 90.0)));
    assert_eq!(one(joint("PhysicsFixedJoint", "j", ["a", "b"], at)).kind, Motion::Fixed);
    assert!(one(joint("PhysicsSphericalJoint", "j", ["a", "b"], at)).held.is_some());
    let all = ["transX", "transY", "transZ", "rotX", "rotY", "rotZ"];
    let generic = one(locked(&all, "rotY"));
    assert_eq!((generic.kind, generic.axis), (Motion::Revolute, DVec3::Y));
    assert!((generic.limit.unwrap().upper - 1f64.to_radians()).abs() < 1e-12);
    assert_eq!(one(locked(&all, "")).kind, Motion::Fixed);
    assert!(one(locked(&all[..4], "")).held.unwrap().contains("2 directions"));
}

#[test]
fn what_hangs_on_nothing_is_the_world_and_frames_that_do_not_meet_are_flagged() {
    let text = body("a", "(0, 0, 1)", "")
        + &body("b", "(1, 0, 1)", "")
        + &joint("PhysicsFixedJoint", "w", ["", "a"], "point3f physics:localPos0 = (0, 0, 1)")
        + &joint(
            "PhysicsRevoluteJoint",
            "j",
            ["a", "b"],
            "point3f physics:localPos0 = (0.5, 0, 0)",
        )
        + &shape("Cube", "floor", "");
    let robot = whole(of("world", &[("a.usda", stage(&text))]));
    let names: Vec<_> = robot.links.iter().map(|l| l.name.as_str()).collect();
    assert_eq!(names, ["world", "a", "b", "surroundings"]);
    assert_eq!(robot.beside.floats, Some(false));
    assert!(robot.beside.flags[0].1.contains("500.0 mm and 0.0 deg apart"), "{:?}", robot.beside);
}

#[test]
fn a_stage_of_several_files_is_read_and_what_is_missing_is_said() {
    let arm = "#usda 1.0\n(defaultPrim = \"arm\")\n".to_owned()
        + &body("arm", "(0, 0, 0)", &shape("Cube", "c", "double size = 1"));
    let text = stage(
        "def \"a\" (prepend references = @./parts/arm.usda@) {}\ndef \"b\" (prepend payload = @./gone.usd@) {}\n\
         def \"c\" (prepend references = @../../out.usda@) {}\n",
    );
    let loaded = of("several", &[("a.usda", text), ("parts/arm.usda", arm)]);
    let missing = evidence(&loaded, "F2");
    assert!(
        missing.iter().any(|e| e.contains("gone.usd") && e.contains("does not exist")),
        "{missing:?}"
    );
    assert!(
        missing.iter().any(|e| e.contains("out.usda") && e.contains("leaves the package")),
        "{missing:?}"
    );
    let robot = whole(loaded);
    assert_eq!((robot.links[0].name.as_str(), robot.links[0].line), ("a", 4));
    assert!(robot.beside.unread.iter().all(|u| u.checks.contains(&"C1")));
}

#[test]
fn a_mesh_is_told_in_its_bodys_frame_and_one_the_simulator_makes_is_unknown() {
    let mesh = |more: &str| {
        format!(
            "def Mesh \"m\" (prepend apiSchemas = [\"PhysicsCollisionAPI\"]) {{ {more}\n int[] faceVertexCounts = [3, 3, 3, 3]\n \
             int[] faceVertexIndices = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]\n \
             point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]\n \
             double3 xformOp:scale = (-2, 1, 1)\n uniform token[] xformOpOrder = [\"xformOp:scale\"] }}\n"
        )
    };
    let of = |more: &str| {
        let text = stage(&body("a", "(5, 0, 0)", &mesh(more)));
        whole(of("mesh", &[("a.usda", text)])).links[0].collisions[0].clone()
    };
    let plain = of("uniform token physics:approximation = \"convexHull\"");
    let Geometry::Mesh(mesh) = &plain.geometry else { panic!("{plain:?}") };
    assert!((mesh.signed_volume() - 1.0 / 3.0).abs() < 1e-12, "mirrored, and still outside out");
    assert_eq!(mesh.bounds().min.x, -2.0);
    assert_eq!(plain.origin, DPose3::translation(5.0, 0.0, 0.0));
    let boxed = of("uniform token physics:approximation = \"boundingCube\"");
    assert_eq!(boxed.geometry, Geometry::Box { size: DVec3::new(2.0, 1.0, 1.0) });
    let made = of("uniform token physics:approximation = \"convexDecomposition\"");
    assert!(
        matches!(made.geometry, Geometry::Unread { reason } if reason.contains("by the simulator"))
    );
}

#[test]
fn numbers_beyond_all_bounds_cost_what_says_them_alone() {
    let cube = shape("Cube", "c", "double size = 1e300");
    let weighs = "float physics:mass = 1e38\n float3 physics:diagonalInertia = (inf, 1, 1)\n \
        point3f physics:centerOfMass = (0, 0, 0)\n";
    let two = body("a", "(0, 0, 0)", &cube) + &body("b", "(0, 0, 1)", weighs);
    let far = "point3f physics:localPos0 = (1e30, 0, 0)\n";
    let text = two + &joint("PhysicsRevoluteJoint", "j", ["a", "b"], far);
    let loaded = of("bounds", &[("a.usda", stage(&text))]);
    let found = evidence(&loaded, "F1");
    assert_eq!(found.iter().filter(|e| e.contains("beyond all bounds")).count(), 3, "{found:?}");
    let robot = whole(loaded);
    assert!(robot.joints[0].origin.translation.length() < 10.0);
    for at in ["(nan, 0, 0)", "(1e9, 0, 0)"] {
        let loaded = of("nowhere", &[("a.usda", stage(&body("a", at, "")))]);
        assert!(evidence(&loaded, "F1")[0].contains("`/m/a` must stand within 1e6 m"), "{at}");
    }
}

#[test]
fn broken_stages_are_refused_in_words() {
    for (text, due) in [
        ("#usda 1.0\ndef Xform \"a\" {}\n".to_owned(), "no prim has PhysicsRigidBodyAPI"),
        (
            "#usda 1.0\n(metersPerUnit = 0)\ndef Xform \"a\" {}\n".to_owned(),
            "metersPerUnit must be a number above 0",
        ),
        ("#usda 1.0\ndef Xform {".to_owned(), "USD: "),
        ("PXR-USDC and no more".to_owned(), "USD: "),
        ("PK\u{3}\u{4} and no more".to_owned(), "USDZ archive"),
    ] {
        let found = evidence(&of("broken", &[("a.usda", text)]), "F1");
        assert!(found[0].contains(due), "{found:?}");
    }
    let lost =
        stage(&(body("a", "(0, 0, 0)", "") + &joint("PhysicsFixedJoint", "j", ["a", "gone"], "")));
    let found = evidence(&of("lost", &[("a.usda", lost)]), "T1");
    assert_eq!(found, ["line 8: `/m/j`: its body1 `/m/gone` does not exist"]);
}
