//! A cabinet with a door, a drawer and a screw cap, built into a package and read back.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on stops")]

mod cabinet;

use std::collections::BTreeMap;

use asset::{Asset, BuildOptions, JointType, build};
use cabinet::{DOOR, MAP, blocks, built, cabinet, condition};
use object::DVec3;
use roxmltree::{Document, Node};

fn files(asset: &Asset) -> BTreeMap<String, Vec<u8>> {
    asset.to_urdf().files
}

fn text(files: &BTreeMap<String, Vec<u8>>, path: &str) -> String {
    String::from_utf8(files[path].clone()).unwrap()
}

fn child<'a>(node: Node<'a, 'a>, name: &str) -> Node<'a, 'a> {
    node.children().find(|c| c.has_tag_name(name)).unwrap_or_else(|| panic!("no <{name}>"))
}

fn vector(node: Node<'_, '_>, attribute: &str) -> DVec3 {
    let numbers: Vec<f64> =
        node.attribute(attribute).unwrap().split(' ').map(|n| n.parse().unwrap()).collect();
    DVec3::from_slice(&numbers)
}

#[test]
fn the_asset_stands_on_the_ground_with_its_base_centred() {
    let asset = built();
    assert!((asset.scale.value - 2.0).abs() < 1e-12);
    assert!((asset.size.value.z - 0.92).abs() < 1e-12);
    let body = &asset.links[0];
    assert_eq!((body.name.as_str(), body.frame), ("body", DVec3::ZERO));
    let bounds = body.body.as_ref().unwrap().visual.bounds();
    assert!(bounds.centre().truncate().length() < 1e-12);
    assert!((bounds.min.z - 0.04).abs() < 1e-12, "the foot below it stands on z = 0");
}

#[test]
fn frames_stand_at_the_pivots_and_nothing_is_turned() {
    let asset = built();
    let door = asset.links.iter().position(|l| l.name == "door").unwrap();
    let hinge = asset.joint_of(door).unwrap();
    let fitted = DVec3::new(-0.3, -0.23, 0.64);
    assert!((hinge.origin.value - fitted).length() < 0.05, "{}", hinge.origin.value);
    assert_eq!(asset.links[door].frame, hinge.origin.value);
    let (min, max) = blocks()[DOOR];
    let visual = asset.links[door].body.as_ref().unwrap().visual.bounds();
    let pivot = DVec3::new(1.0, 0.985, 1.3) + (hinge.origin.value - fitted) / 2.0;
    assert!((visual.min - (min - pivot) * 2.0).length() < 1e-12);
    assert!((visual.max - (max - pivot) * 2.0).length() < 1e-12);
}

#[test]
fn a_thin_steel_door_has_the_inertia_of_its_walls() {
    let asset = built();
    let door = asset.links.iter().find(|l| l.name == "door").unwrap();
    let wall = door.body.as_ref().unwrap().substance.wall.value;
    let (a, b, c) = (0.6, 0.02, 0.4);
    let area = 2.0 * (a * b + b * c + c * a);
    assert!((door.inertial.mass.value - 7800.0 * area * wall).abs() < 1e-9);
    let moment = |f: f64, g: f64, h: f64| {
        // Second moment over area of a box's skin along the side f: two caps at ±f/2 and four walls.
        2.0 * g * h * f * f / 4.0 + 2.0 * (g + h) * f.powi(3) / 12.0
    };
    let (x, y, z) = (moment(a, b, c), moment(b, c, a), moment(c, a, b));
    let expected = DVec3::new(y + z, z + x, x + y) / area * door.inertial.mass.value;
    let found = door.inertial.inertia.value;
    let found = DVec3::new(found.x_axis.x, found.y_axis.y, found.z_axis.z);
    assert!(((found - expected) / expected).length() < 1e-9, "{found} {expected}");
}

#[test]
fn a_part_that_slides_and_turns_gets_a_carrier_between() {
    let asset = built();
    let cap = asset.links.iter().position(|l| l.name == "Drawer_cap").unwrap();
    let turn = asset.joint_of(cap).unwrap();
    let carrier = &asset.links[turn.parent];
    let slide = asset.joint_of(turn.parent).unwrap();
    assert_eq!((turn.kind, slide.kind), (JointType::Continuous, JointType::Prismatic));
    assert_eq!((slide.parent, carrier.name.as_str()), (0, "Drawer_cap_carrier"));
    assert!(carrier.body.is_none() && carrier.inertial.mass.value > 0.0);
    let share = carrier.inertial.mass.value / asset.links[cap].inertial.mass.value;
    assert!((share - 0.25).abs() < 1e-12);
}

#[test]
fn the_urdf_is_well_formed_and_names_only_files_that_are_there() {
    let files = files(&built());
    let text = text(&files, "asset.urdf");
    assert!(!text.contains("NaN") && !text.contains("e-"), "plain decimals only");
    let document = Document::parse(&text).unwrap();
    let robot = document.root_element();
    assert_eq!(robot.attribute("name"), Some("cabinet_co"));
    let meshes: Vec<_> =
        robot.descendants().filter_map(|n| n.attribute("filename")).map(String::from).collect();
    assert!(meshes.len() >= 10);
    for mesh in &meshes {
        let obj = String::from_utf8(files[mesh].clone()).unwrap();
        assert!(obj.contains("\nvn ") && obj.contains("\nf "), "{mesh}");
    }
    assert_eq!(files.len(), meshes.len() + 2);
    for joint in robot.children().filter(|n| n.has_tag_name("joint")) {
        assert_eq!(child(joint, "origin").attribute("rpy"), Some("0 0 0"));
        if joint.attribute("type") != Some("fixed") {
            assert!((vector(child(joint, "axis"), "xyz").length() - 1.0).abs() < 1e-9);
            let has = |name| child(joint, "limit").attribute(name).is_some();
            let limited = joint.attribute("type") != Some("continuous");
            assert_eq!([has("lower"), has("upper")], [limited; 2]);
            assert!(has("effort") && has("velocity"));
        }
    }
}

#[test]
fn paths_stay_apart_without_regard_to_case() {
    let mut seen = std::collections::BTreeSet::new();
    assert!(files(&built()).keys().all(|path| seen.insert(path.to_lowercase())));
}

#[test]
fn what_the_condition_says_is_kept_and_everything_else_is_a_default() {
    let asset = built();
    let mass = |name: &str| {
        let link = asset.links.iter().find(|l| l.name == name).unwrap();
        (link.inertial.mass.value, link.inertial.mass.origin)
    };
    assert_eq!(mass("drawer"), (2.5, object::Origin::User));
    assert_eq!(mass("foot").1, object::Origin::Default);
    let files = files(&asset);
    let sidecar: serde_json::Value = serde_json::from_slice(&files["asset.json"]).unwrap();
    let defaults: Vec<&str> =
        sidecar["defaults"].as_array().unwrap().iter().filter_map(|d| d.as_str()).collect();
    assert!(defaults.contains(&"links.foot.density"), "{defaults:?}");
    assert!(!defaults.contains(&"links.door.density"));
    assert!(defaults.contains(&"joints.door_turn.friction"));
}

#[test]
fn the_sidecar_holds_the_digest_of_every_other_file() {
    let files = files(&built());
    let sidecar: serde_json::Value = serde_json::from_slice(&files["asset.json"]).unwrap();
    assert_eq!(sidecar["schema"], "kinfold-asset/1");
    let listed = sidecar["files"].as_object().unwrap();
    assert_eq!(listed.len() + 1, files.len());
    for (path, digest) in listed {
        assert_eq!(digest.as_str().unwrap(), blake3::hash(&files[path]).to_hex().as_str());
    }
}

#[test]
fn the_same_object_gives_the_same_bytes_on_any_number_of_threads() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let alone = pool.install(|| files(&built()));
    assert!(alone == files(&built()));
    let asset = built();
    let copy: Asset = serde_json::from_str(&serde_json::to_string(&asset).unwrap()).unwrap();
    assert!(copy.to_urdf() == asset.to_urdf());
}

#[test]
fn a_map_that_does_not_fit_is_refused() {
    let refused = |map: &[Option<usize>]| {
        let e = build(&cabinet(), &condition(), map, &BuildOptions::default()).unwrap_err();
        e.to_string()
    };
    assert_eq!(refused(&MAP[..3]), "the condition has 4 parts, but 3 are mapped to the object");
    let beyond = [Some(0), Some(1), Some(2), Some(9)];
    assert!(refused(&beyond).contains("`cap` of the condition is mapped to part 9"));
}
