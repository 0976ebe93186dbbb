//! What an MJCF element says, its default classes included, and the compiler's settings.

use std::collections::BTreeMap;

use roxmltree::Node;

use crate::read::xml::Reader;

/// Deepest nesting of classes and bodies that is followed.
pub(super) const DEEPEST: usize = 256;
/// The class of what names none.
const MAIN: &str = "main";
/// Most classes, and most attributes of one.
const MOST: usize = 512;

/// Settings of `<compiler>` that change what numbers mean.
pub(super) struct Compiler {
    /// Radians per unit of angle.
    pub angle: f64,
    /// Axes of Euler angles, such as `xyz`; upper case: about fixed axes.
    pub euler: String,
    /// Folder of mesh files, with its slash; empty if there is none.
    pub meshes: String,
    /// Whether a range alone makes a joint limited.
    pub autolimits: bool,
    /// Whether bodies without (`auto`) or even with (`true`) inertial get theirs from geoms.
    pub from_geoms: FromGeoms,
}

/// When mass is computed from geoms.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum FromGeoms {
    Never,
    WhereMissing,
    Always,
}

impl Compiler {
    pub(super) fn read(reader: &mut Reader, root: Node) -> Self {
        let mut compiler = Self {
            angle: 1f64.to_radians(),
            euler: "xyz".into(),
            meshes: String::new(),
            autolimits: true,
            from_geoms: FromGeoms::WhereMissing,
        };
        for node in root.children().filter(|n| n.has_tag_name("compiler")) {
            compiler.take(reader, node);
        }
        compiler
    }

    fn take(&mut self, reader: &mut Reader, node: Node) {
        let folder = |name: &str| node.attribute(name).map(str::trim).filter(|f| !f.is_empty());
        match node.attribute("angle") {
            Some("radian") => self.angle = 1.0,
            Some("degree") | None => {}
            Some(other) => reader.fault(node, format!("angle=\"{other}\" is no unit")),
        }
        if let Some(order) = node.attribute("eulerseq") {
            let is_order = order.len() == 3 && order.chars().all(|c| "xyzXYZ".contains(c));
            if is_order {
                self.euler = order.into();
            } else {
                reader.fault(node, format!("eulerseq=\"{order}\" must be three of x, y, z"));
            }
        }
        if let Some(folder) = folder("meshdir").or(folder("assetdir")) {
            self.meshes = format!("{}/", folder.trim_end_matches('/'));
        }
        self.autolimits &= node.attribute("autolimits") != Some("false");
        match node.attribute("inertiafromgeom") {
            Some("true") => self.from_geoms = FromGeoms::Always,
            Some("false") => self.from_geoms = FromGeoms::Never,
            _ => {}
        }
        if node.attribute("coordinate") == Some("global") {
            reader.fault(node, "global coordinates are no longer MJCF");
        }
    }
}

/// Attribute values by class, element and attribute, inherited ones included.
pub(super) struct Defaults(BTreeMap<String, Attributes>);

type Attributes = BTreeMap<(String, String), String>;

impl Defaults {
    pub(super) fn read(reader: &mut Reader, root: Node) -> Self {
        let mut classes = Self(BTreeMap::new());
        for node in root.children().filter(|n| n.has_tag_name("default")) {
            classes.take(reader, node, Attributes::new(), 0);
        }
        classes
    }

    fn take(&mut self, reader: &mut Reader, node: Node, mut inherited: Attributes, depth: usize) {
        let is_class = |n: &Node| n.has_tag_name("default");
        for element in node.children().filter(|n| n.is_element() && !is_class(n)) {
            for attribute in element.attributes() {
                let key = (element.tag_name().name().to_owned(), attribute.name().to_owned());
                inherited.insert(key, attribute.value().to_owned());
            }
        }
        if depth > DEEPEST || inherited.len() > MOST || self.0.len() >= MOST {
            return reader.fault(node, format!("at most {MOST} classes, {DEEPEST} deep"));
        }
        for below in node.children().filter(is_class) {
            self.take(reader, below, inherited.clone(), depth + 1);
        }
        self.0.insert(node.attribute("class").unwrap_or(MAIN).to_owned(), inherited);
    }

    /// An element under the class it names, or else `class`, or else the main one.
    pub(super) fn element<'d>(&self, node: Node<'d, 'd>, class: Option<&str>) -> Element<'d> {
        let class = node.attribute("class").or(class).unwrap_or(MAIN);
        let tag = node.tag_name().name();
        let inherited = self.0.get(class).into_iter().flatten().filter(|((t, _), _)| t == tag);
        let inherited = inherited.map(|((_, name), value)| (name.clone(), value.clone()));
        let own = node.attributes().map(|a| (a.name().to_owned(), a.value().to_owned()));
        Element { node, attributes: inherited.chain(own).collect() }
    }
}

/// An element with what its class adds.
pub(super) struct Element<'d> {
    pub node: Node<'d, 'd>,
    attributes: BTreeMap<String, String>,
}

impl Element<'_> {
    pub(super) fn get(&self, name: &str) -> Option<&str> {
        self.attributes.get(name).map(|v| v.trim())
    }
}
