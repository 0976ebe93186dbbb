//! MJCF text → the same links and joints a URDF gives, so that one set of checks judges both.
//!
//! A body with a joint is a link whose frame stands at the joint's anchor. The root is the body
//! that floats freely, if it is the only one; else a link `world`, as in URDFs that are fixed to
//! it. Angles are in degrees unless the compiler says otherwise. What touches nothing (contype and
//! conaffinity 0) is seen; what touches is seen too where its body has nothing else to show. Planes
//! in the world are the ground and no part of the asset. Several joints of one body are links in a
//! row, of which only the last has mass and shape. Tendons pull and push and change no pose; what
//! ties bodies into loops holds the joints between them; what bends is not read.

mod attributes;
mod bodies;
mod drives;
mod geoms;
mod inside;
mod joints;
mod loose;
mod masses;
mod meshes;
mod model;
mod numbers;
mod places;
mod weighing;

use std::collections::{BTreeMap, BTreeSet};

use roxmltree::Node;

use crate::read::depends::AROUND;
use crate::read::draft::{Draft, MAX_LINKS, MAX_SHAPES};
use crate::read::rgba::rgba;
use crate::read::xml::Reader;
use crate::robot::Unread;
use attributes::{Compiler, Defaults};
use geoms::Shapes;
use model::Model;

/// Elements that bring more of a model than stands here: its tree is unknown.
const FOREIGN: &[&str] = &["include", "attach", "model"];
/// Elements of what bends, which no rigid model has; a skin only looks as if it did.
const BENDS: &[&str] = &["composite", "flexcomp", "flex"];

/// Reads a `<mujoco>` element.
pub(crate) fn model(reader: &mut Reader, root: Node, draft: &mut Draft) {
    let name = root.attribute("model").unwrap_or("model").trim();
    draft.name = if name.is_empty() { "model".into() } else { name.to_owned() };
    let count = |tag: &str| root.descendants().filter(|n| n.has_tag_name(tag)).count();
    let (bodies, geoms) = (count("body"), count("geom"));
    if bodies >= MAX_LINKS || geoms > MAX_SHAPES {
        let most = format!("at most {MAX_LINKS} bodies and {MAX_SHAPES} geoms");
        return reader.fault(root, format!("{most}, found {bodies} and {geoms}"));
    }
    let compiler = Compiler::read(reader, root);
    let defaults = Defaults::read(reader, root);
    let mut model = Model {
        reader,
        compiler,
        defaults,
        meshes: BTreeMap::new(),
        paints: BTreeMap::new(),
        coordinates: Vec::new(),
        mocaps: Vec::new(),
        sites: sites(root),
        unseen: (Vec::new(), false),
        masks: Vec::new(),
        taken: Default::default(),
        draft,
    };
    model.report_foreign(root);
    model.meshes = model.mesh_assets(root);
    model.paints = model.materials(root);
    model.worldbody(root);
    model.drives(root);
    model.equalities(root);
    model.excludes(root);
    model.keyframes(root);
    model.bound_masses(root);
    model.loose_ends(root);
    model.judge_masks();
    model.judge_looks();
    model.check_names();
}

/// The body each site stands in.
fn sites(root: Node) -> BTreeMap<String, String> {
    let all = root.descendants().filter(|n| n.has_tag_name("site"));
    let body = |n: Node| {
        let above = n.ancestors().find(|a| a.has_tag_name("body"));
        above.map_or(Some("world"), |body| body.attribute("name")).map(str::to_owned)
    };
    all.filter_map(|n| Some((n.attribute("name")?.to_owned(), body(n)?))).collect()
}

impl Model<'_, '_> {
    fn foreign(&mut self, node: Node, what: &str) {
        let at = self.reader.at(node);
        self.draft.foreign.push(format!("{at}: {what} is not read here"));
    }

    /// Something that is not read, and what depends on it.
    fn unread(&mut self, node: Node, what: &str, checks: &'static [&'static str]) {
        let what = format!("{}: {what} is not read here", self.reader.at(node));
        self.draft.beside.unread.push(Unread { what, checks });
    }

    /// Colours of materials; a texture is not read, and the colour beside it tints it alone.
    fn materials(&self, root: Node) -> BTreeMap<String, [u8; 4]> {
        let assets = root.children().filter(|n| n.has_tag_name("asset"));
        let all = assets.flat_map(|n| n.children()).filter(|n| n.has_tag_name("material"));
        let elements = all.map(|n| self.defaults.element(n, None));
        let bare = elements.filter(|e| e.get("texture").is_none());
        bare.filter_map(|e| Some((e.get("name")?.to_owned(), rgba(e.get("rgba")?)?))).collect()
    }

    fn report_foreign(&mut self, root: Node) {
        for tag in FOREIGN {
            if let Some(node) = root.descendants().find(|n| n.has_tag_name(*tag)) {
                self.foreign(node, "this element");
            }
        }
        for tag in BENDS {
            if let Some(node) = root.descendants().find(|n| n.has_tag_name(*tag)) {
                self.unread(node, "what bends", AROUND);
            }
        }
    }

    fn check_names(&mut self) {
        let links = self.draft.links.iter().filter(|l| !l.between);
        let links: Vec<_> = links.map(|l| (l.name.clone(), l.line)).collect();
        self.reader.check_names("body", links.iter().map(|(n, l)| (n.as_str(), *l)), true);
        let joints = self.draft.joints.iter().map(|j| (j.joint.name.as_str(), j.joint.line));
        self.reader.check_names("joint", joints, true);
    }

    /// A name for a link that no other has: what MJCF leaves unnamed, or repeats, gets a number.
    fn unique(&mut self, name: String) -> String {
        let unnamed = |n: &str| n.starts_with("body_") || n.contains("__");
        numbered(&mut self.taken[0], name, unnamed)
    }

    /// The same for a joint.
    fn unique_joint(&mut self, name: String) -> String {
        numbered(&mut self.taken[1], name, |n| n.ends_with("_joint"))
    }

    /// Keeps what the geoms of a body may touch.
    fn note_masks(&mut self, body: usize, shapes: &Shapes) {
        let touched = shapes.touched.iter().map(|s| s.mask);
        self.masks.extend(touched.chain(shapes.planes.iter().copied()).map(|mask| (body, mask)));
    }

    /// Keeps whether a body shows something.
    fn note_looks(&mut self, name: &str, shapes: &Shapes) {
        self.unseen.1 |= !shapes.seen.is_empty();
        if shapes.seen.is_empty() && !shapes.touched.is_empty() && !shapes.shows {
            self.unseen.0.push(name.to_owned());
        }
    }

    /// Flags bodies that show nothing in a model that shows others.
    fn judge_looks(&mut self) {
        let (unseen, others) = std::mem::take(&mut self.unseen);
        let words = |name: String| {
            let name = crate::read::xml::shown(&name);
            format!("link `{name}` can be touched and is not seen: its geoms are in hidden groups")
        };
        let flags = unseen.into_iter().filter(|_| others).map(|name| ("G3", words(name)));
        self.draft.beside.flags.extend(flags);
    }

    /// Flags a model in which no two geoms may ever touch.
    fn judge_masks(&mut self) {
        let meets = |[t, a]: [u32; 2], [u, b]: [u32; 2]| t & b != 0 || u & a != 0;
        let kinds: BTreeSet<(usize, [u32; 2])> = self.masks.iter().copied().collect();
        let bodies: BTreeSet<usize> = kinds.iter().map(|(body, _)| *body).collect();
        let some = kinds.iter().any(|(i, a)| kinds.iter().any(|(j, b)| i != j && meets(*a, *b)));
        if bodies.len() > 1 && !some {
            let words = "no two geoms may touch: contype and conaffinity of none of them meet";
            self.draft.beside.flags.push(("G3", words.into()));
        }
    }
}

/// The name, or the name with the first free number where it was made up and is taken.
fn numbered(taken: &mut BTreeSet<String>, name: String, made_up: impl Fn(&str) -> bool) -> String {
    let mut free = name.clone();
    let mut number = 2;
    while made_up(&name) && taken.contains(&free) {
        free = format!("{name}_{number}");
        number += 1;
    }
    taken.insert(free.clone());
    free
}

#[cfg(test)]
mod tests;
