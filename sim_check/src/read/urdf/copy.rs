//! What a `<robot>` element says, as a text that `urdf-rs` reads whole.
//!
//! Written from the parsed document once our own pass found nothing wrong: elements and numbers of
//! URDF, and no others. So comments, sections of character data, namespaces, extensions and
//! materials do not reach it. They made `urdf-rs` 0.10 refuse files that simulators read, take the
//! square of the time, or overflow the stack (docs/dependencies.md). Names that are odd or long do
//! not reach it either: the outline has them.

use object::kinematics::is_safe_name;
use roxmltree::Node;

use crate::read::caps::MAX_NAME;

/// Longest number that is copied as it stands, bytes; a longer one is written anew, with the same value.
const MAX_NUMBER: usize = 64;

/// The elements of URDF that hold a model's numbers: which, and what stands in each, in the order in
/// which `urdf-rs` takes it.
const ELEMENTS: [(&str, &[&str], &[&str]); 19] = [
    ("robot", &[], &["link", "joint"]),
    ("link", &[], &["inertial", "visual", "collision"]),
    ("inertial", &[], &["origin", "mass", "inertia"]),
    ("mass", &["value"], &[]),
    ("inertia", &["ixx", "ixy", "ixz", "iyy", "iyz", "izz"], &[]),
    ("visual", &[], &["origin", "geometry"]),
    ("collision", &[], &["origin", "geometry"]),
    ("geometry", &[], &[]),
    ("box", &["size"], &[]),
    ("sphere", &["radius"], &[]),
    ("cylinder", &["radius", "length"], &[]),
    ("capsule", &["radius", "length"], &[]),
    ("mesh", &["scale"], &[]),
    ("joint", &[], &["origin", "parent", "child", "axis", "limit", "dynamics", "mimic"]),
    ("origin", &["xyz", "rpy"], &[]),
    ("axis", &["xyz"], &[]),
    ("limit", &["lower", "upper", "effort", "velocity"], &[]),
    ("dynamics", &["damping", "friction"], &[]),
    ("mimic", &["multiplier", "offset"], &[]),
];

/// What `urdf-rs` wants of an element whether or not the file says it, and what stands for it.
const WANTED: [(&str, &str, &str); 8] = [
    ("robot", "name", "_"),
    ("link", "name", "_"),
    ("joint", "name", "_"),
    ("joint", "type", "fixed"),
    ("parent", "link", "_"),
    ("child", "link", "_"),
    ("mimic", "joint", "_"),
    ("mesh", "filename", "_"),
];

/// The copy of a `<robot>` element that our own pass found sound.
pub(super) fn of(root: Node) -> String {
    let mut text = String::new();
    element(&mut text, root, "robot");
    text
}

fn element(text: &mut String, node: Node, tag: &str) {
    text.extend(["<", tag]);
    for (_, attribute, stand_in) in WANTED.into_iter().filter(|(of, ..)| *of == tag) {
        let plain = |name: &&str| name.len() <= MAX_NAME && is_safe_name(name);
        let said = node.attribute(attribute).filter(plain);
        text.extend([" ", attribute, "=\"", said.unwrap_or(stand_in), "\""]);
    }
    let known = ELEMENTS.into_iter().find(|(name, ..)| *name == tag);
    let (_, numbers, children) = known.unwrap_or((tag, &[], &[]));
    for attribute in numbers {
        let is_due = DUE.contains(&tag);
        let said = node.attribute(*attribute).or(is_due.then_some(""));
        if let Some(said) = said {
            let count = if VECTORS.contains(attribute) { 3 } else { 1 };
            text.extend([" ", attribute, "=\"", &plain(said, count), "\""]);
        }
    }
    if tag == "limit" && !node.has_attribute("velocity") {
        text.push_str(" velocity=\"0\"");
    }
    text.push('>');
    if tag == "geometry" {
        shape(text, node);
    }
    for child in children {
        let several = matches!(tag, "robot") || matches!(*child, "visual" | "collision");
        let most = if several { usize::MAX } else { 1 };
        let found = node.children().filter(|n| n.has_tag_name(*child)).take(most);
        for node in found.filter(|n| is_whole(*n)) {
            element(text, node, child);
        }
        if *child == "geometry" && !node.children().any(|n| n.has_tag_name("geometry")) {
            text.push_str("<geometry><mesh filename=\"_\"></mesh></geometry>");
        }
    }
    text.extend(["</", tag, ">"]);
}

/// Shapes of URDF.
const SHAPES: [&str; 5] = ["box", "sphere", "cylinder", "capsule", "mesh"];
/// Elements of which `urdf-rs` wants every number.
const DUE: [&str; 7] = ["mass", "inertia", "box", "sphere", "cylinder", "capsule", "axis"];
/// Attributes of three numbers.
const VECTORS: [&str; 4] = ["xyz", "rpy", "size", "scale"];

/// The first shape of a geometry; what URDF does not have, or nothing, stands as a mesh.
fn shape(text: &mut String, geometry: Node) {
    let first = geometry.children().find(Node::is_element);
    let known = first.and_then(|n| SHAPES.into_iter().find(|s| n.has_tag_name(*s)).zip(Some(n)));
    match known {
        Some((tag, node)) => element(text, node, tag),
        None => text.push_str("<mesh filename=\"_\"></mesh>"),
    }
}

/// Whether an element has what `urdf-rs` wants of it: mass and inertia come together.
fn is_whole(node: Node) -> bool {
    let has = |tag: &str| node.children().any(|n| n.has_tag_name(tag));
    !node.has_tag_name("inertial") || has("mass") && has("inertia")
}

/// The numbers of an attribute with one blank between them, so many: what is no number or not there is
/// 0, and known to our own pass.
fn plain(said: &str, count: usize) -> String {
    let number = |word: &str| match word.parse::<f64>() {
        Ok(value) if !value.is_finite() => "0".to_owned(),
        Ok(value) if word.len() > MAX_NUMBER => format!("{value:?}"),
        Ok(_) => word.to_owned(),
        Err(_) => "0".to_owned(),
    };
    let words = said.split_whitespace().map(number).chain(std::iter::repeat("0".to_owned()));
    words.take(count).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use roxmltree::Document;

    #[test]
    fn extensions_comments_and_namespaces_stay_behind() {
        let text = "<robot xmlns='u' xmlns:x='v' name='r'><!-- - --><![CDATA[]]]]]><gazebo><link/></gazebo>\n\
                    <link name='a b'><visual><geometry><mesh filename='m.obj' scale='1\u{a0}2  3'/></geometry>\
                    <material/></visual><x:link/></link></robot>";
        let document = Document::parse(text).unwrap();
        let copied = "<robot name=\"r\"><link name=\"_\"><visual><geometry>\
                      <mesh filename=\"_\" scale=\"1 2 3\"></mesh></geometry></visual></link></robot>";
        assert_eq!(of(document.root_element()), copied);
    }

    #[test]
    fn a_long_number_keeps_its_value_and_not_its_length() {
        let long = format!("1.{}e1 2", "0".repeat(400));
        assert_eq!(plain(&long, 2), "10.0 2");
        assert_eq!(plain(" -1.50e+3\n", 1), "-1.50e+3");
        assert_eq!(plain("0,07 nan 3 4", 3), "0 0 3");
    }
}
