//! What a URDF says of colours: a `<material>` with a `<color>` of its own, or the name of one that
//! stands elsewhere in the robot.

use std::collections::BTreeMap;

use roxmltree::Node;

use crate::read::rgba::rgba;

/// The colours of a robot's materials by name.
pub(super) struct Paints<'a>(BTreeMap<&'a str, [u8; 4]>);

impl<'a> Paints<'a> {
    /// Of several materials of one name the robot's own counts, and then the first, as in urdfdom.
    pub(super) fn read(root: Node<'a, 'a>) -> Self {
        let mut known = BTreeMap::new();
        let is_material = |n: &Node| n.has_tag_name("material");
        let own = root.children().filter(is_material);
        let links = root.children().filter(|n| n.has_tag_name("link"));
        let visuals = links.flat_map(|n| n.children()).filter(|n| n.has_tag_name("visual"));
        let inside = visuals.flat_map(|n| n.children()).filter(is_material);
        for material in own.chain(inside) {
            if let Some((name, colour)) = name(material).zip(colour(material)) {
                known.entry(name).or_insert(colour);
            }
        }
        Self(known)
    }

    /// The colour of a `<visual>`; none where the file says none.
    pub(super) fn of(&self, visual: Node<'a, 'a>) -> Option<[u8; 4]> {
        let material = visual.children().find(|n| n.has_tag_name("material"))?;
        let named = name(material).and_then(|name| self.0.get(name).copied());
        named.or_else(|| colour(material))
    }
}

fn name<'a>(material: Node<'a, 'a>) -> Option<&'a str> {
    material.attribute("name").map(str::trim).filter(|name| !name.is_empty())
}

fn colour(material: Node) -> Option<[u8; 4]> {
    let colour = material.children().find(|n| n.has_tag_name("color"))?;
    rgba(colour.attribute("rgba")?)
}
