//! What an MJCF element says, its default classes included, and the compiler's settings.

use std::collections::BTreeMap;

use roxmltree::Node;

use crate::read::xml::Reader;

/// Deepest nesting of classes and bodies that is followed.
pub(super) const DEEPEST: usize = 256;
/// The class of what names none.
const MAIN: &str = "main";
/// Groups of geoms are numbered from 0 to this.
const LAST_GROUP: u8 = 5;
/// Actuators are one kind of element under several names: what a class says of one it says of all.
const ACTUATORS: &[&str] = &[
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
];
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
    /// Groups of geoms that weigh something, the first and the last.
    pub weighing: [f64; 2],
    /// Least mass, kg, and least moment of inertia, kg·m², of a body that moves.
    pub least: [f64; 2],
    /// What all bodies weigh together, kg; `None` where it stays as told.
    pub total: Option<f64>,
    /// Whether moments that break the triangle inequality are evened out.
    pub balances: bool,
    /// Whether names of files are taken without their folders.
    pub strips: bool,
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
            weighing: [0.0, f64::from(LAST_GROUP)],
            least: [0.0; 2],
            total: None,
            balances: false,
            strips: false,
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
        self.take_masses(reader, node);
        self.strips |= node.attribute("strippath") == Some("true");
        if node.attribute("coordinate") == Some("global") {
            reader.fault(node, "global coordinates are no longer MJCF");
        }
    }
}

impl Compiler {
    /// Settings that change what bodies weigh.
    fn take_masses(&mut self, reader: &mut Reader, node: Node) {
        if let Some(range) = node.attribute("inertiagrouprange") {
            let words = range.split_whitespace();
            let numbers = words.map(|w| reader.parse(node, "inertiagrouprange", w));
            match numbers.collect::<Vec<_>>()[..] {
                [Some(first), Some(last)] => self.weighing = [first, last],
                _ => reader.fault(node, "inertiagrouprange: expected two groups"),
            }
        }
        for (k, name) in ["boundmass", "boundinertia"].into_iter().enumerate() {
            self.least[k] = reader.optional(node, name).unwrap_or(self.least[k]);
        }
        let total = reader.optional(node, "settotalmass").filter(|kg| *kg > 0.0);
        self.total = total.or(self.total);
        self.balances |= node.attribute("balanceinertia") == Some("true");
    }
}

/// Attribute values by class, element and attribute, inherited ones included.
pub(super) struct Defaults {
    classes: BTreeMap<String, Attributes>,
    /// The class of what names none.
    main: String,
}

type Attributes = BTreeMap<(String, String), String>;

impl Defaults {
    pub(super) fn read(reader: &mut Reader, root: Node) -> Self {
        let mut defaults = Self { classes: BTreeMap::new(), main: MAIN.into() };
        let mut own: Option<String> = None;
        for node in root.children().filter(|n| n.has_tag_name("default")) {
            let name = node.attribute("class").map(str::to_owned);
            let main = own.get_or_insert_with(|| name.unwrap_or_else(|| MAIN.into())).clone();
            defaults.main = main.clone();
            // Several sections, of included files for example, are one.
            let known = defaults.classes.get(&main).cloned().unwrap_or_default();
            defaults.take(reader, node, known, 0);
        }
        defaults
    }

    fn take(&mut self, reader: &mut Reader, node: Node, mut inherited: Attributes, depth: usize) {
        let is_class = |n: &Node| n.has_tag_name("default");
        for element in node.children().filter(|n| n.is_element() && !is_class(n)) {
            for attribute in element.attributes() {
                let key = (element.tag_name().name().to_owned(), attribute.name().to_owned());
                inherited.insert(key, attribute.value().to_owned());
            }
        }
        if depth > DEEPEST || inherited.len() > MOST || self.classes.len() >= MOST {
            return reader.fault(node, format!("at most {MOST} classes, {DEEPEST} deep"));
        }
        for below in node.children().filter(is_class) {
            self.take(reader, below, inherited.clone(), depth + 1);
        }
        let name = node.attribute("class").unwrap_or(&self.main).to_owned();
        self.classes.insert(name, inherited);
    }

    /// An element under the class it names, or else `class`, or else the main one.
    pub(super) fn element<'d>(&self, node: Node<'d, 'd>, class: Option<&str>) -> Element<'d> {
        let class = node.attribute("class").or(class).unwrap_or(&self.main);
        let tag = node.tag_name().name();
        let is_of = |t: &str| t == tag || ACTUATORS.contains(&t) && ACTUATORS.contains(&tag);
        let inherited = self.classes.get(class).into_iter().flatten();
        let inherited = inherited.filter(|((t, _), _)| is_of(t));
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
