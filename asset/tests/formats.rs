//! The cabinet as MJCF, USD and GLB: what each format must say, without its loaders.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on stops")]

mod cabinet;

use std::collections::BTreeSet;

use asset::{Asset, JointType};
use cabinet::built;
use object::{DVec3, glb};
use roxmltree::{Document, Node};
use serde_json::{Value, json};

/// Pairs of links that need not collide: body and foot are one rigid body, and the cap meets it
/// through its carrier.
const ADJACENT: [[&str; 2]; 7] = [
    ["body", "door"],
    ["body", "drawer"],
    ["body", "Drawer_cap"],
    ["body", "foot"],
    ["door", "foot"],
    ["drawer", "foot"],
    ["Drawer_cap", "foot"],
];

fn all<'a>(root: Node<'a, 'a>, tag: &'static str) -> Vec<Node<'a, 'a>> {
    root.descendants().filter(|n| n.has_tag_name(tag)).collect()
}

#[test]
fn the_mjcf_names_meshes_of_the_package_and_nests_links_as_the_tree_does() {
    let asset = built();
    let (text, files) = (asset.to_mjcf(), asset.to_urdf().files);
    let document = Document::parse(&text).unwrap();
    let root = document.root_element();
    let meshes = all(root, "mesh");
    assert!(meshes.iter().all(|m| files.contains_key(m.attribute("file").unwrap())));
    let known: BTreeSet<_> = meshes.iter().map(|m| m.attribute("name")).collect();
    let used: BTreeSet<_> =
        all(root, "geom").iter().filter_map(|g| g.attribute("mesh")).map(Some).collect();
    assert_eq!(known, used);
    let parent = |n: &Node<'_, '_>| n.parent_element().unwrap().attribute("name").map(String::from);
    let found: BTreeSet<_> = all(root, "body")
        .iter()
        .map(|n| (n.attribute("name").unwrap().to_owned(), parent(n)))
        .collect();
    let name = |link: usize| asset.links[link].name.clone();
    let above = |link: usize| asset.joint_of(link).map(|j| name(j.parent));
    let expected = (0..asset.links.len()).map(|l| (name(l), above(l))).collect();
    assert_eq!(found, expected);
    let named = |tag| all(root, tag).iter().filter(|n| n.has_attribute("name")).count();
    assert_eq!((named("motor"), named("joint")), (4, 4));
}

#[test]
fn links_that_meet_in_a_joint_are_excluded_from_contact_and_no_others() {
    let text = built().to_mjcf();
    let document = Document::parse(&text).unwrap();
    let excluded = all(document.root_element(), "exclude");
    let pair = |n: &Node<'_, '_>| ["body1", "body2"].map(|a| n.attribute(a).unwrap().to_owned());
    let found: BTreeSet<_> = excluded.iter().map(pair).collect();
    assert_eq!(found, ADJACENT.map(|p| p.map(String::from)).into());
    let usd = built().to_usd();
    let filter = usd.lines().find(|l| l.contains("filteredPairs")).unwrap();
    for [_, other] in ADJACENT.into_iter().filter(|p| p[0] == "body") {
        assert!(filter.contains(&format!("/Links/{other}>")), "{filter}");
    }
}

#[test]
fn usd_counts_turns_in_degrees() {
    let asset = built();
    let usd = asset.to_usd();
    let hinge = asset.joints.iter().find(|j| j.name == "door_turn").unwrap();
    let motion = hinge.motion.as_ref().unwrap();
    let upper = motion.limits.as_ref().unwrap()[1].value.to_degrees() as f32;
    let damping = (motion.damping.value / 1.0_f64.to_degrees()) as f32;
    let start = usd.find("\"door_turn\"").unwrap();
    let text = &usd[start..start + usd[start..].find("\n        }").unwrap()];
    assert!(text.contains(&format!("float physics:upperLimit = {upper}\n")), "{text}");
    let line = format!("float drive:angular:physics:damping = {damping}\n");
    assert!(text.contains(&line), "{text}");
    assert_eq!(usd.matches("\"PhysicsRigidBodyAPI\"").count(), asset.links.len());
}

#[test]
fn the_glb_reads_back_as_the_asset_at_rest() {
    let asset = built();
    let mesh = glb::read(&asset.to_glb()).unwrap();
    assert!((mesh.bounds().size() - asset.size.value).length() < 1e-6);
    assert!(mesh.bounds().min.z.abs() < 1e-6);
    let faces = asset.links.iter().filter_map(|l| l.body.as_ref());
    assert_eq!(mesh.faces().len(), faces.map(|b| b.visual.faces().len()).sum::<usize>());
}

#[test]
fn the_same_asset_gives_the_same_bytes_in_every_format() {
    let asset = built();
    let copy: Asset = serde_json::from_str(&serde_json::to_string(&asset).unwrap()).unwrap();
    assert!(copy.to_mjcf() == asset.to_mjcf());
    assert!(copy.to_usd() == asset.to_usd());
    assert!(copy.to_glb() == asset.to_glb());
}

/// JSON and buffer of a GLB.
fn chunks(glb: &[u8]) -> (Value, &[u8]) {
    let long = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    let json = serde_json::from_slice(&glb[20..20 + long(12)]).unwrap();
    (json, &glb[28 + long(12)..])
}

#[test]
fn a_short_slide_far_from_the_middle_keeps_its_direction_in_the_glb() {
    let mut asset = built();
    let drawer = asset.joints.iter_mut().find(|j| j.kind == JointType::Prismatic).unwrap();
    let (name, axis) = (drawer.name.clone(), DVec3::new(0.6, -0.64, 0.48));
    drawer.origin.value = DVec3::new(0.71, -0.37, 0.93);
    let motion = drawer.motion.as_mut().unwrap();
    motion.axis.value = axis;
    motion.limits.as_mut().unwrap()[0].value = 0.0;
    motion.limits.as_mut().unwrap()[1].value = 0.002;
    let glb = asset.to_glb();
    let (json, data) = chunks(&glb);
    let named = |list: &Value| {
        let all = list.as_array().unwrap();
        all.iter().position(|n| n["name"] == *name).unwrap()
    };
    let animation = &json["animations"][named(&json["animations"])];
    let output = animation["samplers"][0]["output"].as_u64().unwrap() as usize;
    let view = json["accessors"][output]["bufferView"].as_u64().unwrap() as usize;
    let start = json["bufferViews"][view]["byteOffset"].as_u64().unwrap() as usize;
    let word = |i: usize| f32::from_le_bytes(data[start + 4 * i..][..4].try_into().unwrap());
    let end = DVec3::from_array([3, 4, 5].map(|i| f64::from(word(i))));
    let upright = DVec3::new(axis.x, axis.z, -axis.y);
    assert!(end.normalize().distance(upright) < 2e-7, "{end}");
    assert!((end.length() - 0.002).abs() < 1e-9, "{end}");
    let rest = &json["nodes"][named(&json["nodes"])];
    assert_eq!(rest["children"], json!([animation["channels"][0]["target"]["node"]]));
    let at = |i: usize| rest["translation"][i].as_f64().unwrap();
    assert!(DVec3::new(at(0), at(1), at(2)).distance(DVec3::new(0.71, 0.93, 0.37)) < 1e-7);
}
