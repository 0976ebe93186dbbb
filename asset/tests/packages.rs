//! The cabinet as SDFormat, as a ROS 2 package, for Isaac Lab and as a SimReady package: all say the
//! masses, axes, limits and efforts of the asset.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on stops")]

mod cabinet;

use asset::{Asset, AssetAppearance, Joint, Motion};
use cabinet::built;
use roxmltree::{Document, Node};

fn moving(asset: &Asset) -> impl Iterator<Item = (&Joint, &Motion)> {
    asset.joints.iter().filter_map(|j| Some((j, j.motion.as_ref()?)))
}

fn text(files: &std::collections::BTreeMap<String, Vec<u8>>, path: &str) -> String {
    let found = files.get(path).unwrap_or_else(|| panic!("no {path} in {:?}", files.keys()));
    String::from_utf8(found.clone()).unwrap()
}

fn child<'a>(node: Node<'a, 'a>, path: &str) -> Node<'a, 'a> {
    path.split('/').fold(node, |at, tag| {
        at.children().find(|n| n.has_tag_name(tag)).unwrap_or_else(|| panic!("no {tag} of {path}"))
    })
}

fn numbers(node: Node<'_, '_>) -> Vec<f64> {
    node.text().unwrap().split(' ').map(|n| n.parse().unwrap()).collect()
}

#[test]
fn sdf_says_the_masses_places_axes_limits_and_friction_of_the_asset() {
    let asset = built();
    let files = asset.to_sdf_with(&AssetAppearance::default()).files;
    let meshes = asset.to_urdf().files;
    let sdf = text(&files, "asset.sdf");
    let document = Document::parse(&sdf).unwrap();
    let model = child(document.root(), "sdf/model");
    let tagged = |tag: &'static str| model.children().filter(move |n| n.has_tag_name(tag));
    for (link, node) in asset.links.iter().zip(tagged("link")) {
        assert_eq!(node.attribute("name"), Some(link.name.as_str()));
        assert_eq!(numbers(child(node, "inertial/mass")), [link.inertial.mass.value]);
        assert_eq!(numbers(child(node, "pose"))[..3], link.frame.to_array());
        let tensor = link.inertial.inertia.value;
        let due = [("ixx", tensor.x_axis.x), ("iyz", tensor.y_axis.z), ("izz", tensor.z_axis.z)];
        for (name, value) in due {
            assert_eq!(numbers(child(child(node, "inertial/inertia"), name)), [value], "{name}");
        }
    }
    assert_eq!(tagged("link").count(), asset.links.len());
    assert_eq!(tagged("joint").count(), asset.joints.len());
    for (joint, motion) in moving(&asset) {
        let is = |n: &Node<'_, '_>| n.attribute("name") == Some(&joint.name);
        let axis = child(tagged("joint").find(is).unwrap(), "axis");
        assert_eq!(numbers(child(axis, "xyz")), motion.axis.value.to_array());
        assert_eq!(numbers(child(axis, "limit/effort")), [motion.effort.value]);
        assert_eq!(numbers(child(axis, "dynamics/friction")), [motion.friction.value]);
        assert_eq!(numbers(child(axis, "dynamics/damping")), [motion.damping.value]);
        if let Some([lower, upper]) = &motion.limits {
            assert_eq!(numbers(child(axis, "limit/lower")), [lower.value]);
            assert_eq!(numbers(child(axis, "limit/upper")), [upper.value]);
        }
    }
    let uris = document.descendants().filter(|n| n.has_tag_name("uri"));
    assert!(uris.clone().count() > asset.links.len());
    uris.for_each(|uri| assert!(meshes.contains_key(uri.text().unwrap()), "{uri:?}"));
    assert!(text(&files, "model.config").contains("<sdf version=\"1.9\">asset.sdf</sdf>"));
}

#[test]
fn a_ros_package_holds_every_mesh_that_its_urdf_names() {
    let asset = built();
    let files = asset.to_ros_with(&AssetAppearance::default()).files;
    let name = format!("{}_description", asset.name);
    let urdf = text(&files, &format!("{name}/urdf/{}.urdf", asset.name));
    let document = Document::parse(&urdf).unwrap();
    let named: Vec<_> = document.descendants().filter_map(|n| n.attribute("filename")).collect();
    assert!(named.len() > asset.links.len());
    for file in named {
        let path = file.strip_prefix("package://").unwrap();
        assert!(files.contains_key(path), "{path}");
    }
    let manifest = text(&files, &format!("{name}/package.xml"));
    let manifest = Document::parse(&manifest).unwrap();
    let package = manifest.root_element();
    assert_eq!(package.attribute("format"), Some("3"));
    assert_eq!(child(package, "name").text(), Some(name.as_str()));
    assert_eq!(
        child(package, "description").text(),
        Some("Links, joints and meshes of: Cabinet & <co>")
    );
    let rules = text(&files, &format!("{name}/CMakeLists.txt"));
    for folder in ["launch", "meshes", "rviz", "urdf"] {
        assert!(rules.contains(folder), "{folder} is installed");
        assert!(files.keys().any(|f| f.starts_with(&format!("{name}/{folder}/"))), "{folder}");
    }
}

#[test]
fn a_urdf_has_a_transmission_for_each_joint_that_moves() {
    let asset = built();
    let urdf = text(&asset.to_urdf().files, "asset.urdf");
    let document = Document::parse(&urdf).unwrap();
    let actuated: Vec<_> = document
        .descendants()
        .filter(|n| n.has_tag_name("transmission"))
        .map(|n| child(n, "joint").attribute("name").unwrap().to_owned())
        .collect();
    assert_eq!(actuated, moving(&asset).map(|(j, _)| j.name.clone()).collect::<Vec<_>>());
    assert!(urdf.contains("<option noslip_iterations="), "what friction holds creeps in MuJoCo");
}

#[test]
fn isaac_lab_gets_each_joint_with_its_bounds_and_friction() {
    let asset = built();
    let python = asset.to_isaaclab();
    let name = asset.name.to_uppercase();
    for config in [format!("\n{name}_CFG = "), format!("\n{name}_DRIVEN_CFG = ")] {
        let of = &python[python.find(&config).unwrap()..];
        for (joint, motion) in moving(&asset) {
            let start = of.find(&format!("joint_names_expr=[\"{}\"]", joint.name)).unwrap();
            let value = |field: &str| -> f64 {
                let of = &of[start + of[start..].find(&format!(" {field}=")).unwrap()..];
                let from = of.find('=').unwrap() + 1;
                of[from..from + of[from..].find(',').unwrap()].parse().unwrap()
            };
            let close = |a: f64, b: f64| (a - b).abs() <= 1e-5 * b.abs();
            assert!(close(value("joint_effort_limit"), motion.effort.value), "{}", joint.name);
            assert!(close(value("joint_velocity_limit"), motion.velocity.value));
            assert!(close(value("friction"), motion.friction.value));
        }
    }
}

#[test]
fn a_simready_base_has_no_engines_words_and_each_engine_a_layer_of_its_own() {
    let asset = built();
    let files = asset.to_simready_with(&AssetAppearance::default(), vec![1, 2, 3]).files;
    let name = &asset.name;
    let base = text(&files, &format!("{name}/usd/{name}.usda"));
    let words = ["physx", "newton:", "Newton", "mjc:", "Mjc", "Physx"];
    let is_variant = |line: &&str| {
        line.contains("runnables/physics")
            || line.contains("variant")
            || line.contains("dictionary")
    };
    for line in base.lines().filter(|l| !is_variant(l)) {
        let found = words.iter().find(|w| line.contains(**w));
        assert!(found.is_none() || line.contains("string"), "{line}");
    }
    assert_eq!(files[&format!("{name}/usd/.thumbs/256x256/{name}.usda.png")], [1, 2, 3]);
    assert!(base.contains(&format!("int rigid_body_count = {}", asset.links.len())));
    for (engine, word) in [
        ("physx", "staticFrictionEffort"),
        ("newton", "newton:friction"),
        ("mujoco", "mjc:solimpfriction"),
    ] {
        let layer = text(&files, &format!("{name}/usd/runnables/physics/{engine}.usda"));
        assert_eq!(layer.matches(word).count(), moving(&asset).count(), "{engine}");
        assert!(!layer.contains("\ndef "), "opinions alone");
    }
}

#[test]
fn usd_says_friction_and_speed_in_the_words_of_each_engine() {
    let asset = built();
    let usd = asset.to_usd();
    let hinge = asset.joints.iter().find(|j| j.name == "door_turn").unwrap();
    let motion = hinge.motion.as_ref().unwrap();
    let start = usd.find("\"door_turn\"").unwrap();
    let text = &usd[start..start + usd[start..].find("\n        }").unwrap()];
    let friction = motion.friction.value as f32;
    let speed = motion.velocity.value.to_degrees() as f32;
    for line in [
        format!("float physxJointAxis:angular:staticFrictionEffort = {friction}\n"),
        format!("float newton:friction = {friction}\n"),
        format!("float newton:velocityLimit = {speed}\n"),
        format!("uniform double mjc:frictionloss = {friction}\n"),
    ] {
        assert!(text.contains(&line), "{line} in {text}");
    }
}
