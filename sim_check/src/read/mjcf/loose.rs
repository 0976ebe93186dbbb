//! References of an MJCF model that its tree does without: materials, joints of drives. MuJoCo reads no
//! model in which one of them leads nowhere.

use std::collections::BTreeSet;

use roxmltree::Node;

use super::model::Model;

/// Elements that bring names of their own, or a whole model.
const MAKES_NAMES: [&str; 7] =
    ["include", "attach", "model", "replicate", "composite", "flexcomp", "plugin"];

impl Model<'_, '_> {
    /// Notes materials and driven joints that are not there.
    pub(super) fn loose_ends(&mut self, root: Node) {
        let is_maker = |n: Node| MAKES_NAMES.iter().any(|tag| n.has_tag_name(*tag));
        if root.descendants().any(is_maker) {
            return;
        }
        let named = |tags: &[&str]| -> BTreeSet<&str> {
            let all = root.descendants().filter(|n| tags.iter().any(|t| n.has_tag_name(*t)));
            all.filter_map(|n| n.attribute("name").map(str::trim)).collect()
        };
        let (materials, joints) = (named(&["material"]), named(&["joint", "freejoint"]));
        let mut loose = Vec::new();
        let in_class = |n: &Node| n.ancestors().any(|a| a.has_tag_name("default"));
        for node in root.descendants().filter(Node::is_element).filter(|n| !in_class(n)) {
            let below_actuator = node.parent().is_some_and(|p| p.has_tag_name("actuator"));
            let told = |attribute: &str| node.attribute(attribute).map(str::trim);
            let told = |attribute| told(attribute).filter(|name| !name.is_empty());
            let (what, name, known) = match node.tag_name().name() {
                "geom" | "site" | "skin" | "tendon" => ("material", told("material"), &materials),
                _ if below_actuator => ("joint", told("joint").or(told("jointinparent")), &joints),
                _ => continue,
            };
            if let Some(name) = name.filter(|name| !known.contains(*name)) {
                loose.push(format!("{}: there is no {what} `{name}`", self.reader.at(node)));
            }
        }
        self.reader.faults.loose.extend(loose);
    }
}
