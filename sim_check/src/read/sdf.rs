//! SDFormat text → the same links and joints a URDF gives, so that one set of checks judges all formats.
//!
//! Versions 1.4 to 1.12 are read: a model, or a world with models, and what they include. Names of nested
//! models come before those of their links, as `model::link`. Frames are followed to where they stand, so
//! that only links and joints are left. What is static hangs on the world; planes are the ground and no
//! part of anything; plugins, sensors and lights are passed over. A limit of 1e16 and more is none, an
//! effort or a velocity below zero neither. A height map is not read, nor a part of a mesh file.

mod frames;
mod joints;
mod model;
mod numbers;
mod shapes;
mod tree;

use std::collections::BTreeMap;

use glamx::{DMat3, DPose3, DVec3};
use roxmltree::Node;

use crate::mass::solid::together;
use crate::read::assembly::{Body, assemble, relative};
use crate::read::depends::{AROUND, PLACED, WEIGHED};
use crate::read::draft::{Draft, MAX_LINKS, MAX_SHAPES};
use crate::read::meshes::Shelf;
use crate::read::xml::judge_names;
use crate::robot::{Format, Inertial, Link, Shape, Unread};
use frames::{Frame, Frames, Kind, OWN, Scope, WITHIN, WORLD};
use model::{Sdf, Told};
use numbers::{flaw, number, pose, relative_to};
use shapes::{Shapes, solid};
use tree::{Element, Includes, MERGED, is_true};

/// Density of a collision that states none, kg/m³: the format's own.
const DENSITY: f64 = 1000.0;
/// Most frames of all kinds; a guess with room.
const MAX_FRAMES: usize = 8192;

/// A link and where it stands.
struct ToldLink<'e> {
    element: &'e Element,
    scope: usize,
    frame: usize,
    name: String,
    is_still: bool,
}

/// What the models of a file hold.
#[derive(Default)]
struct Found<'e> {
    links: Vec<ToldLink<'e>>,
    joints: Vec<Told<'e>>,
}

/// Where an element of a model is read.
#[derive(Clone)]
struct Place {
    scope: usize,
    /// Names of the models around, each with its `::`.
    prefix: String,
    home: Option<usize>,
    is_still: bool,
    depth: usize,
}

/// Reads an `<sdf>` element.
pub(crate) fn model(root: Node, text: &str, shelf: &mut Shelf, draft: &mut Draft) {
    draft.format = Format::Sdf;
    let mut root = tree::of_document(root, text, "", None);
    let mut includes = Includes::new(shelf, &mut draft.faults);
    includes.take(&mut root, 0);
    let missing = includes.missing;
    draft.beside.unread.extend(missing.into_iter().map(|what| Unread { what, checks: AROUND }));
    let world = root.child("world");
    let models: Vec<&Element> = match world {
        Some(world) => world.all("model").collect(),
        None => root.all("model").collect(),
    };
    let around = world.unwrap_or(&root);
    if models.is_empty() {
        let words = format!("{}: there is no `model` in it", around.at());
        return draft.faults.text.push(words);
    }
    let named = world.or(models.first().copied()).map(|n| n.name()).unwrap_or_default();
    draft.name = if named.is_empty() { "model".into() } else { named.to_owned() };
    if world.is_none() && models.len() > 1 {
        let words = format!("{} models in a file, of which programs take the first", models.len());
        draft.faults.flags.push(words);
    }
    let mut sdf = Sdf { draft, shelf, frames: Frames::default(), shapes: 0 };
    sdf.world(around, world.is_some());
}

impl Sdf<'_> {
    fn world(&mut self, around: &Element, is_world: bool) {
        let mut found = Found::default();
        self.frames.scopes.push(Scope { is_world: true, ..Scope::default() });
        let outside =
            Place { scope: 0, prefix: String::new(), home: None, is_still: false, depth: 0 };
        if is_world {
            self.inside(around, &outside, &mut found);
        } else if let Some(model) = around.child("model") {
            self.nested(model, &outside, "", &mut found);
        }
        let is_too_much = self.frames.frames.len() > MAX_FRAMES
            || found.links.len() > MAX_LINKS
            || found.joints.len() > MAX_LINKS
            || self.shapes > MAX_SHAPES;
        if is_too_much {
            let (l, j, s) = (found.links.len(), found.joints.len(), self.shapes);
            let words = format!(
                "at most {MAX_LINKS} links and joints, {MAX_SHAPES} shapes and {MAX_FRAMES} frames, \
                 found {l}, {j}, {s} and {}",
                self.frames.frames.len()
            );
            return self.draft.faults.text.push(words);
        }
        self.find_places();
        let bodies: Vec<Body> = found.links.iter().map(|told| self.body(told)).collect();
        let still: Vec<bool> = bodies.iter().map(|b| b.is_still).collect();
        let is_still = |end: Option<usize>| end.is_none_or(|l| still[l]);
        // What never moves needs no joint.
        let moves = found.joints.iter().filter(|told| !told.is_still);
        let bonds: Vec<_> = moves.filter_map(|told| self.bond(told)).collect();
        let bonds: Vec<_> =
            bonds.into_iter().filter(|b| !b.ends.iter().all(|end| is_still(*end))).collect();
        let names = |all: Vec<(String, u32)>| all.into_iter();
        let links = names(bodies.iter().map(|b| (b.link.name.clone(), b.link.line)).collect());
        judge_names(&mut self.draft.faults, "link", links, WITHIN, false);
        let joints = names(found.joints.iter().map(|j| (j.name.clone(), j.element.line)).collect());
        judge_names(&mut self.draft.faults, "joint", joints, WITHIN, false);
        assemble(self.draft, bodies, bonds, around.line);
    }

    /// What stands in a model or a world.
    fn inside<'e>(&mut self, of: &'e Element, place: &Place, found: &mut Found<'e>) {
        for child in &of.children {
            // Counted where all is known; here no more than that is taken up.
            if self.frames.frames.len() > MAX_FRAMES || found.links.len() > MAX_LINKS {
                return;
            }
            let name = child.name();
            let full = format!("{}{name}", place.prefix);
            match child.tag.as_str() {
                "link" => {
                    let kind = Kind::Link(found.links.len());
                    let frame = self.frame(child, place, kind);
                    // Older files have links of that name, and older programs take them for the world.
                    let (scope, is_still) = (place.scope, place.is_still || name == WORLD);
                    if name == WORLD {
                        let words = format!("{}: `world` names the world and no link", child.at());
                        self.draft.faults.flags.push(words);
                    }
                    let shapes = |c: &&Element| matches!(c.tag.as_str(), "visual" | "collision");
                    self.shapes += child.children.iter().filter(shapes).count();
                    found.links.push(ToldLink {
                        element: child,
                        scope,
                        frame,
                        name: full,
                        is_still,
                    });
                }
                "joint" => {
                    let leads = child.said("child").unwrap_or_default().to_owned();
                    let frame = self.frame(child, place, Kind::Joint(leads));
                    let (scope, is_still) = (place.scope, place.is_still);
                    found.joints.push(Told { element: child, scope, frame, name: full, is_still });
                }
                "frame" => {
                    let attached = child.get("attached_to").map(str::to_owned);
                    self.frame(child, place, Kind::Plain(attached));
                }
                "model" => self.nested(child, place, &format!("{full}{WITHIN}"), found),
                "population" => self.unread(child, "a population", AROUND),
                "drake:joint" | "drake:linear_bushing_rpy" | "drake:ball_constraint" => {
                    let at = child.at();
                    self.draft.foreign.push(format!("{at}: this element is not read here"));
                }
                _ => {}
            }
        }
    }

    fn nested<'e>(&mut self, of: &'e Element, place: &Place, prefix: &str, found: &mut Found<'e>) {
        if place.depth > tree::DEEPEST {
            let words = format!("{}: models nest at most {} deep", of.at(), tree::DEEPEST);
            return self.draft.faults.text.push(words);
        }
        let is_still = place.is_still || of.is_so("static");
        let depth = place.depth + 1;
        if of.get(MERGED).is_some_and(is_true) {
            let frame = self.frame(of, place, Kind::Merged);
            if of.get("placement_frame").is_some() {
                self.unread(of, "the placement frame of what is merged", PLACED);
            }
            let place = Place { home: Some(frame), is_still, depth, ..place.clone() };
            return self.inside(of, &place, found);
        }
        let scope = self.frames.scopes.len();
        let frame = self.frame(of, place, Kind::Model(scope));
        let first = || {
            let inner = of.children.iter().find(|c| matches!(c.tag.as_str(), "link" | "model"))?;
            let ending = if inner.tag == "model" { "::__model__" } else { "" };
            Some(format!("{}{ending}", inner.name()))
        };
        let canonical = of.get("canonical_link").map(str::to_owned).or_else(first);
        let frame = Some(frame);
        self.frames.scopes.push(Scope {
            frame,
            names: BTreeMap::new(),
            canonical,
            is_world: false,
        });
        let is_explicit = of.said("self_collide").is_some_and(|word| !is_true(word));
        if is_explicit && of.all("link").count() > 2 {
            let words = format!(
                "{}: Gazebo lets no two of its links touch (`self_collide` is false); they are \
                 judged as if they could",
                of.at()
            );
            self.draft.beside.flags.push(("G3", words));
        }
        let place = Place { scope, prefix: prefix.to_owned(), home: None, is_still, depth };
        self.inside(of, &place, found);
    }

    /// Notes a frame under its name.
    fn frame(&mut self, of: &Element, place: &Place, kind: Kind) -> usize {
        let told = pose(&mut self.draft.faults, of);
        let relative_to = relative_to(of).or_else(|| match &kind {
            Kind::Joint(child) => Some(child.clone()).filter(|child| !child.is_empty()),
            Kind::Plain(attached) => attached.clone(),
            _ => None,
        });
        let placement = of.get("placement_frame").map(str::to_owned);
        let index = self.frames.frames.len();
        let (scope, home, line) = (place.scope, place.home, of.line);
        let frame = Frame { kind, scope, told, relative_to, home, placement, line };
        let merged = format!("_merged__{}{OWN}", of.name());
        let name = if frame.kind == Kind::Merged { merged } else { of.name().to_owned() };
        self.frames.frames.push(frame);
        let names = &mut self.frames.scopes[place.scope].names;
        if let Some(first) = names.get(&name).copied() {
            // Of one kind they are counted with the names.
            let first = &self.frames.frames[first];
            let is_one = std::mem::discriminant(&first.kind)
                == std::mem::discriminant(&self.frames.frames[index].kind);
            if !is_one && !name.is_empty() {
                let words = format!(
                    "lines {} and {line}: two elements of a model are called `{name}`",
                    first.line
                );
                self.draft.faults.flags.push(words);
            }
        } else {
            names.insert(name, index);
        }
        index
    }

    fn find_places(&mut self) {
        for (frame, why) in self.frames.settle() {
            let Frame { kind, relative_to, line, .. } = &self.frames.frames[frame];
            // A child that is not there is told with its joint.
            if matches!(kind, Kind::Joint(child) if Some(child) == relative_to.as_ref()) {
                continue;
            }
            let words = format!("line {line}: where this stands is not known: {why}");
            self.draft.beside.unread.push(Unread { what: words.clone(), checks: PLACED });
            self.draft.faults.references.push(words);
        }
    }

    fn body(&mut self, told: &ToldLink) -> Body {
        let of = told.element;
        let at = self.absolute(told.scope, told.frame);
        let mut parts: [Vec<(Shape, &Element)>; 2] = [Vec::new(), Vec::new()];
        for (tag, list) in ["visual", "collision"].into_iter().zip(&mut parts) {
            for child in of.all(tag) {
                let origin = self.within(told, child);
                let faults = &mut self.draft.faults;
                let made = Shapes { shelf: self.shelf, faults }.shape(child, origin);
                list.extend(made.map(|shape| (shape, child)));
            }
        }
        let known = self.draft.faults.numbers.len();
        let inertial = self.inertial(of, &parts[1]);
        if let Some(what) = self.draft.faults.numbers.get(known).cloned() {
            self.draft.beside.unread.push(Unread { what, checks: WEIGHED });
        }
        let [visuals, collisions] =
            parts.map(|list| list.into_iter().map(|(shape, _)| shape).collect::<Vec<_>>());
        let link = Link {
            name: told.name.clone(),
            inertial,
            visuals,
            collisions,
            between: false,
            line: of.line,
        };
        Body { link, at: at.unwrap_or_default(), is_still: told.is_still }
    }

    /// Where a part of a link stands in it.
    fn within(&mut self, told: &ToldLink, of: &Element) -> DPose3 {
        let own = pose(&mut self.draft.faults, of);
        let Some(name) = relative_to(of) else { return own };
        let link = self.frames.place(told.frame);
        match link.zip(self.frames.named(told.scope, &name)) {
            Some((link, from)) => relative(link, from) * own,
            None => {
                flaw(&mut self.draft.faults, of, format!("there is no frame `{name}`"));
                own
            }
        }
    }

    /// Mass and inertia of a link: as told, or by its collisions where the file wants that.
    fn inertial(&mut self, of: &Element, collisions: &[(Shape, &Element)]) -> Option<Inertial> {
        let told = of.child("inertial")?;
        let known = self.draft.faults.numbers.len();
        if told.get("auto").is_some_and(is_true) {
            return self.weighed(told, collisions);
        }
        let origin = pose(&mut self.draft.faults, told);
        let faults = &mut self.draft.faults;
        // What is left out is one, as the format has it.
        let mass = number(faults, told, "mass", 1.0);
        let inertia = match told.child("inertia") {
            None => DMat3::IDENTITY,
            Some(m) => {
                let mut entry = |tag, unsaid| number(faults, m, tag, unsaid);
                let (xx, yy, zz) = (entry("ixx", 1.0), entry("iyy", 1.0), entry("izz", 1.0));
                let (xy, xz, yz) = (entry("ixy", 0.0), entry("ixz", 0.0), entry("iyz", 0.0));
                let column = DVec3::new;
                DMat3::from_cols(column(xx, xy, xz), column(xy, yy, yz), column(xz, yz, zz))
            }
        };
        let is_sound = faults.numbers.len() == known;
        is_sound.then_some(Inertial { origin, mass, inertia, line: told.line })
    }

    fn weighed(&mut self, told: &Element, collisions: &[(Shape, &Element)]) -> Option<Inertial> {
        let faults = &mut self.draft.faults;
        let of_link = number(faults, told, "density", DENSITY);
        let mut weights = Vec::new();
        for (shape, of) in collisions {
            let density = number(faults, of, "density", of_link);
            match solid(of, &shape.geometry) {
                Some(solid) => weights.push(solid.weighing(None, density, shape.origin)),
                None => flaw(faults, of, "what it weighs cannot be told"),
            }
        }
        let all = together(&weights, told.line)?;
        let mass = number(faults, told, "mass", all.mass);
        let inertia = all.inertia * (mass / all.mass);
        Some(Inertial { mass, inertia, ..all })
    }
}

#[cfg(test)]
mod tests;
