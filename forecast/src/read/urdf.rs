//! A URDF as the rules see it: links, joints, what carries what.

use std::collections::{BTreeMap, BTreeSet};

use crate::read::error::Reason;
use crate::read::mesh::{Bounds, Mesh};
use crate::read::numbers::{number, numbers};
use crate::read::shelf::Shelf;
use crate::read::tree::{Element, Tree};

/// Most links and joints together: rules look for one in the other. The largest models that ship with
/// simulators have fewer than 500; a guess with room.
const MAX_PARTS: usize = 20_000;

/// A URDF.
#[derive(Clone, Debug, Default)]
pub struct Urdf {
    /// Its links, in the order of the file.
    pub links: Vec<Link>,
    /// Its joints, in the order of the file.
    pub joints: Vec<Joint>,
    /// Joints that a transmission names, with its line.
    pub transmissions: Vec<(String, u32)>,
    /// Whether its options for MuJoCo make dry friction hold: `noslip_iterations` above 0.
    pub holds_in_mujoco: bool,
}

/// A link.
#[derive(Clone, Debug, Default)]
pub struct Link {
    /// Its name.
    pub name: String,
    /// Its line.
    pub line: u32,
    /// Mass and moments, where the file gives them.
    pub inertial: Option<Inertial>,
    /// What is drawn.
    pub visuals: Vec<Shape>,
    /// What is felt.
    pub collisions: Vec<Shape>,
}

/// What a link weighs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inertial {
    /// Its line.
    pub line: u32,
    /// Mass, kg; 0 where it is missing.
    pub mass: f64,
    /// ixx, iyy, izz, ixy, ixz, iyz in kg m²; 0 where they are missing.
    pub inertia: [f64; 6],
    /// Where the centre of mass is in the link, m.
    pub centre: [f64; 3],
    /// How its axes are turned against the link's: roll, pitch, yaw.
    pub angles: [f64; 3],
}

/// A visual or a collision.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Its line.
    pub line: u32,
    /// Its `name`, if it has one.
    pub name: Option<String>,
    /// What kind of shape.
    pub geometry: Geometry,
    /// The box around it in the link, m; `None` where it is turned or its size is not known.
    pub bounds: Option<Bounds>,
    /// A material that is named here and defined nowhere.
    pub undefined: Option<String>,
}

/// A shape.
#[derive(Clone, Debug)]
pub enum Geometry {
    /// A box, sphere or cylinder: its tag.
    Primitive(&'static str),
    /// A capsule, which URDF does not know and some clients do.
    Capsule,
    /// A mesh.
    Mesh(Mesh),
    /// None of these.
    Other,
}

/// A joint.
#[derive(Clone, Debug, Default)]
pub struct Joint {
    /// Its name.
    pub name: String,
    /// Its line.
    pub line: u32,
    /// Its `type`.
    pub kind: String,
    /// Name of the link above.
    pub parent: String,
    /// Name of the link that it carries.
    pub child: String,
    /// Where the child stands in the parent, m.
    pub origin: [f64; 3],
    /// How it is turned there: roll, pitch, yaw.
    pub angles: [f64; 3],
    /// Its axis as written; `None` means 1 0 0.
    pub axis: Option<[f64; 3]>,
    /// Its `<limit>`.
    pub limit: Option<Limit>,
    /// Damping and friction of its `<dynamics>`, where they are written.
    pub dynamics: Option<(Option<f64>, Option<f64>)>,
    /// The joint that it follows.
    pub mimic: Option<Mimic>,
    /// Line of a `<safety_controller>`.
    pub safety: Option<u32>,
}

/// A `<mimic>`: position = multiplier * leader + offset.
#[derive(Clone, Debug, PartialEq)]
pub struct Mimic {
    /// Name of the leader.
    pub joint: String,
    /// Per unit of the leader; 1 where it is not written.
    pub multiplier: f64,
    /// rad or m; 0 where it is not written.
    pub offset: f64,
}

/// A `<limit>`: what of it is written.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limit {
    /// Lower end, rad or m.
    pub lower: Option<f64>,
    /// Upper end, rad or m.
    pub upper: Option<f64>,
    /// Effort, N m or N.
    pub effort: Option<f64>,
    /// Speed, rad/s or m/s.
    pub velocity: Option<f64>,
}

impl Urdf {
    /// Reads the elements of a URDF.
    pub(crate) fn read(tree: &Tree, shelf: &mut Shelf) -> Result<Self, Reason> {
        let mut urdf = Self::default();
        let Some(root) = tree.root() else { return Ok(urdf) };
        let parts = tree.children(root).filter(|e| matches!(e.tag.as_str(), "link" | "joint"));
        if let Some(one) = parts.clone().nth(MAX_PARTS) {
            let rule = "a URDF has at most this many links and joints:";
            let (line, most, found) = (one.line, MAX_PARTS, parts.count());
            return Err(Reason::TooMuch { line, rule, most, found });
        }
        let defined = defined(tree);
        for element in tree.children(root) {
            match element.tag.as_str() {
                "link" => urdf.links.push(link(tree, element, &defined, shelf)?),
                "joint" => urdf.joints.push(joint(tree, element)?),
                "transmission" => {
                    let joints = tree.tagged(element, "joint");
                    urdf.transmissions.extend(joints.map(|j| (j.name(), element.line)));
                }
                "mujoco" => {
                    for option in tree.tagged(element, "option") {
                        let passes = number(option, "noslip_iterations")?;
                        urdf.holds_in_mujoco |= passes.is_some_and(|n| n > 0.0);
                    }
                }
                _ => {}
            }
        }
        Ok(urdf)
    }

    /// The links that no joint carries.
    pub fn roots(&self) -> impl Iterator<Item = &Link> {
        let carried: BTreeSet<_> = self.joints.iter().map(|j| j.child.as_str()).collect();
        self.links.iter().filter(move |l| !carried.contains(l.name.as_str()))
    }

    /// The links that move as one, by the name of the topmost: what hangs on fixed joints belongs to
    /// its parent. Those at rest, which hang on a root by fixed joints alone, are left out.
    pub fn moving(&self) -> BTreeMap<&str, Vec<&Link>> {
        let above: BTreeMap<_, _> = self.joints.iter().map(|j| (j.child.as_str(), j)).collect();
        let mut tops: BTreeMap<&str, Option<&str>> = BTreeMap::new();
        let mut groups: BTreeMap<&str, Vec<&Link>> = BTreeMap::new();
        for link in &self.links {
            let (mut name, mut way) = (link.name.as_str(), Vec::new());
            let top = loop {
                if let Some(top) = tops.get(name) {
                    break *top;
                }
                // A file may tie its links into a ring: whoever comes by again is at rest.
                tops.insert(name, None);
                way.push(name);
                match above.get(name) {
                    Some(joint) if joint.kind == "fixed" => name = &joint.parent,
                    Some(_) => break Some(name),
                    None => break None,
                }
            };
            tops.extend(way.into_iter().map(|name| (name, top)));
            if let Some(top) = top {
                groups.entry(top).or_default().push(link);
            }
        }
        groups
    }
}

impl Inertial {
    /// Whether its axes are turned against the link's.
    pub fn is_turned(&self) -> bool {
        self.angles.iter().any(|a| *a != 0.0)
    }
}

impl Joint {
    /// Whether it is `revolute` or `prismatic`, which URDF wants a range of.
    pub fn has_range(&self) -> bool {
        matches!(self.kind.as_str(), "revolute" | "prismatic")
    }

    /// Whether anything moves by it.
    pub fn moves(&self) -> bool {
        self.kind != "fixed"
    }
}

/// Materials that some element gives a colour or a texture.
fn defined(tree: &Tree) -> BTreeSet<String> {
    let materials = tree.elements.iter().filter(|e| e.tag == "material");
    materials.filter(|e| !e.children.is_empty()).map(Element::name).collect()
}

fn link(
    tree: &Tree,
    element: &Element,
    defined: &BTreeSet<String>,
    shelf: &mut Shelf,
) -> Result<Link, Reason> {
    let mut link = Link { name: element.name(), line: element.line, ..Link::default() };
    for child in tree.children(element) {
        match child.tag.as_str() {
            "inertial" if link.inertial.is_none() => link.inertial = Some(inertial(tree, child)?),
            "visual" => link.visuals.push(shape(tree, child, defined, shelf)?),
            "collision" => link.collisions.push(shape(tree, child, defined, shelf)?),
            _ => {}
        }
    }
    Ok(link)
}

fn inertial(tree: &Tree, element: &Element) -> Result<Inertial, Reason> {
    let mut made = Inertial { line: element.line, ..Inertial::default() };
    if let Some(origin) = tree.first(element, "origin") {
        made.centre = numbers::<3>(origin, "xyz")?.unwrap_or_default();
        made.angles = numbers::<3>(origin, "rpy")?.unwrap_or_default();
    }
    if let Some(mass) = tree.first(element, "mass") {
        made.mass = number(mass, "value")?.unwrap_or_default();
    }
    if let Some(inertia) = tree.first(element, "inertia") {
        let names = ["ixx", "iyy", "izz", "ixy", "ixz", "iyz"];
        for (slot, name) in made.inertia.iter_mut().zip(names) {
            *slot = number(inertia, name)?.unwrap_or_default();
        }
    }
    Ok(made)
}

fn shape(
    tree: &Tree,
    element: &Element,
    defined: &BTreeSet<String>,
    shelf: &mut Shelf,
) -> Result<Shape, Reason> {
    let material = tree.first(element, "material").filter(|m| m.children.is_empty());
    let undefined = material.map(Element::name).filter(|name| !defined.contains(name));
    let inner = tree.first(element, "geometry").and_then(|g| tree.children(g).next());
    let geometry = match inner.map(|g| g.tag.as_str()) {
        Some("box") => Geometry::Primitive("box"),
        Some("sphere") => Geometry::Primitive("sphere"),
        Some("cylinder") => Geometry::Primitive("cylinder"),
        Some("capsule") => Geometry::Capsule,
        Some("mesh") => {
            let filename = inner.and_then(|g| g.get("filename")).unwrap_or_default();
            Geometry::Mesh(shelf.mesh(filename))
        }
        _ => Geometry::Other,
    };
    let place = origin(tree, element)?;
    Ok(Shape {
        line: element.line,
        name: element.get("name").map(str::to_string),
        bounds: inner.map(|g| bounds(g, &geometry, place)).transpose()?.flatten(),
        geometry,
        undefined,
    })
}

fn joint(tree: &Tree, element: &Element) -> Result<Joint, Reason> {
    let mut joint = Joint {
        name: element.name(),
        line: element.line,
        kind: element.get("type").unwrap_or_default().to_string(),
        ..Joint::default()
    };
    for child in tree.children(element) {
        let linked = || child.get("link").unwrap_or_default().to_string();
        match child.tag.as_str() {
            "parent" => joint.parent = linked(),
            "child" => joint.child = linked(),
            "axis" => joint.axis = numbers::<3>(child, "xyz")?,
            "origin" => {
                joint.origin = numbers::<3>(child, "xyz")?.unwrap_or_default();
                joint.angles = numbers::<3>(child, "rpy")?.unwrap_or_default();
            }
            "limit" => joint.limit = Some(limit(child)?),
            "dynamics" => {
                joint.dynamics = Some((number(child, "damping")?, number(child, "friction")?));
            }
            "mimic" => joint.mimic = Some(mimic(child)?),
            "safety_controller" => joint.safety = Some(child.line),
            _ => {}
        }
    }
    Ok(joint)
}

/// Where an element's `<origin>` puts it, and whether it turns it.
fn origin(tree: &Tree, element: &Element) -> Result<([f64; 3], bool), Reason> {
    let Some(origin) = tree.first(element, "origin") else { return Ok(([0.0; 3], false)) };
    let turn = numbers::<3>(origin, "rpy")?.unwrap_or_default();
    Ok((numbers::<3>(origin, "xyz")?.unwrap_or_default(), turn.iter().any(|a| *a != 0.0)))
}

/// The box around a shape in its link; `None` where it is turned or its size is not known.
fn bounds(
    inner: &Element,
    geometry: &Geometry,
    (at, turned): ([f64; 3], bool),
) -> Result<Option<Bounds>, Reason> {
    let radius = number(inner, "radius")?;
    let around = |size: [f64; 3]| [size.map(|s| -s / 2.0), size.map(|s| s / 2.0)];
    let own = match (geometry, radius) {
        (Geometry::Primitive("box"), _) => numbers::<3>(inner, "size")?.map(around),
        (Geometry::Primitive("sphere"), Some(r)) => Some(around([2.0 * r; 3])),
        (Geometry::Primitive("cylinder"), Some(r)) => {
            number(inner, "length")?.map(|l| around([2.0 * r, 2.0 * r, l]))
        }
        (Geometry::Mesh(mesh), _) => {
            let scale = numbers::<3>(inner, "scale")?.unwrap_or([1.0; 3]);
            mesh.bounds.map(|[low, high]| {
                let ends = [0, 1, 2].map(|i| [low[i] * scale[i], high[i] * scale[i]]);
                [ends.map(|[a, b]| a.min(b)), ends.map(|[a, b]| a.max(b))]
            })
        }
        _ => None,
    };
    Ok(own.filter(|_| !turned).map(|ends| ends.map(|end| [0, 1, 2].map(|i| end[i] + at[i]))))
}

fn mimic(element: &Element) -> Result<Mimic, Reason> {
    Ok(Mimic {
        joint: element.get("joint").unwrap_or_default().to_string(),
        multiplier: number(element, "multiplier")?.unwrap_or(1.0),
        offset: number(element, "offset")?.unwrap_or_default(),
    })
}

fn limit(element: &Element) -> Result<Limit, Reason> {
    Ok(Limit {
        lower: number(element, "lower")?,
        upper: number(element, "upper")?,
        effort: number(element, "effort")?,
        velocity: number(element, "velocity")?,
    })
}
