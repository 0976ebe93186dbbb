//! USD with UsdPhysics → the same links and joints a URDF gives, so that one set of checks judges all formats.
//!
//! The `object` crate puts the stage together, behind its fence; here its prims are read. A prim with
//! `PhysicsRigidBodyAPI` is a link; what stands below it and is drawn is seen, what has
//! `PhysicsCollisionAPI` is touched. Joints are those of UsdPhysics, a generic one by its limits. Units and
//! the up axis are the stage's own. A joint's value is 0 where its two frames agree, which need not be where
//! the file has its bodies. What collides and is no body stands still; planes are the ground.

mod joints;
mod lines;
mod masses;
mod model;
mod prims;
mod shapes;

use std::collections::{BTreeMap, BTreeSet};

use glamx::DPose3;
use object::usd::UsdError;
use object::usd::prims::Stage;

use crate::read::assembly::{Body, Bond, assemble};
use crate::read::depends::{AROUND, MOVED};
use crate::read::draft::{Draft, MAX_LINKS, MAX_SHAPES};
use crate::read::meshes::Shelf;
use crate::read::xml::judge_names;
use crate::robot::{Format, Link, Unread};
use lines::Lines;
use model::Usd;
use prims::Prims;

/// Most pairs of bodies that are filtered, however often each is told; a guess with room.
const MOST_PAIRS: usize = 4_000_000;
/// What parts the names of prims in a path.
const WITHIN: &str = "/";

/// Reads a USD file of any form; layers that it names come from the shelf.
pub(crate) fn read(bytes: Vec<u8>, shelf: &mut Shelf) -> Draft {
    let mut draft = Draft { format: Format::Usd, ..Draft::default() };
    let lines = Lines::of(&bytes);
    let stage = object::usd::read_prims(bytes, &mut |name| shelf.layer(name));
    match stage {
        Ok(stage) => model(stage, lines, &mut draft),
        Err(why @ UsdError::Unanswered(_)) => draft.unanswered = Some(why.to_string()),
        Err(why) => draft.faults.text.push(why.to_string()),
    }
    draft
}

fn model(stage: Stage, lines: Lines, draft: &mut Draft) {
    draft.name = stage.default_prim.clone().unwrap_or_else(|| "stage".into());
    for why in &stage.missing {
        draft.faults.files.push(why.clone());
        draft.beside.unread.push(Unread { what: why.clone(), checks: AROUND });
    }
    let prims = match Prims::of(stage) {
        Ok(prims) => prims,
        Err(why) => return draft.faults.text.push(why),
    };
    let mut usd = Usd { draft, prims, lines, bodies: BTreeMap::new() };
    usd.read();
}

impl Usd<'_> {
    fn read(&mut self) {
        let found: Vec<usize> = self.prims.all().filter(|p| self.prims.is_body(*p)).collect();
        let joints: Vec<usize> =
            self.prims.all().filter(|p| joints::is_joint(self.prims.kind(*p))).collect();
        let shapes = self.prims.all().filter(|p| self.prims.is_shape(*p)).count();
        let (links, count) = (found.len(), joints.len());
        if links.max(count) >= MAX_LINKS || shapes > MAX_SHAPES {
            let words = format!(
                "at most {MAX_LINKS} bodies and joints and {MAX_SHAPES} shapes, \
                 found {links}, {count} and {shapes}"
            );
            return self.draft.faults.text.push(words);
        }
        if found.is_empty() {
            let words = "no prim has PhysicsRigidBodyAPI, so there is no body in it".into();
            return self.draft.faults.text.push(words);
        }
        self.bodies = found.iter().enumerate().map(|(body, prim)| (*prim, body)).collect();
        let names = self.names(&found);
        let mut bodies: Vec<Body> =
            found.iter().zip(&names).map(|(prim, name)| self.body(*prim, name)).collect();
        bodies.extend(self.still());
        let bonds: Vec<Bond> = joints.into_iter().filter_map(|joint| self.bond(joint)).collect();
        let bonds = from_rest(bonds);
        self.filtered(&names);
        let links = bodies.iter().map(|b| (b.link.name.clone(), b.link.line));
        judge_names(&mut self.draft.faults, "body", links, WITHIN, false);
        let joints = bonds.iter().map(|b| (b.joint.name.clone(), b.joint.line));
        judge_names(&mut self.draft.faults, "joint", joints, WITHIN, false);
        assemble(self.draft, bodies, bonds, 1);
    }

    /// Names of bodies: their prims', or their paths where several prims are called the same.
    fn names(&self, found: &[usize]) -> Vec<String> {
        let name = |prim: usize| self.prims.name(prim);
        let is_one = |prim: usize| found.iter().filter(|p| name(**p) == name(prim)).count() == 1;
        let of = |prim: &usize| match is_one(*prim) {
            true => name(*prim).to_owned(),
            false => self.prims.path(*prim).trim_start_matches('/').to_owned(),
        };
        found.iter().map(of).collect()
    }

    fn body(&mut self, prim: usize, name: &str) -> Body {
        let at = self.prims.pose(prim);
        let inside: Vec<usize> = self.prims.inside(prim).collect();
        let parts = self.shapes(&inside, at);
        let inertial = self.inertial(prim, &parts);
        let line = self.line(prim);
        let shapes = |touched: bool| {
            let of = parts.iter().filter(move |p| if touched { p.is_touched } else { p.is_seen });
            of.map(|p| p.shape.clone()).collect::<Vec<_>>()
        };
        let link = Link {
            name: name.to_owned(),
            inertial,
            visuals: shapes(false),
            collisions: shapes(true),
            between: false,
            line,
        };
        // A body that a program moves stands where it is.
        let is_still = self.prims.flag(prim, "physics:kinematicEnabled", false);
        Body { link, at, is_still }
    }

    /// What collides and belongs to no body.
    fn still(&mut self) -> Option<Body> {
        let outside: Vec<usize> =
            self.prims.all().filter(|p| self.prims.body_of(*p).is_none()).collect();
        let parts = self.shapes(&outside, DPose3::identity());
        if !parts.iter().any(|p| p.is_touched) {
            return None;
        }
        let line = parts.first().map_or(1, |p| p.shape.line);
        let of = |touched: bool| {
            let of = parts.iter().filter(move |p| if touched { p.is_touched } else { p.is_seen });
            of.map(|p| p.shape.clone()).collect::<Vec<_>>()
        };
        let (name, inertial) = ("surroundings".into(), None);
        let link =
            Link { name, inertial, visuals: of(false), collisions: of(true), between: false, line };
        Some(Body { link, at: DPose3::identity(), is_still: true })
    }

    /// Pairs of bodies that the file lets pass through each other.
    fn filtered(&mut self, names: &[String]) {
        let under = |prim: usize| -> Vec<usize> {
            match self.prims.body_of(prim).and_then(|b| self.bodies.get(&b)) {
                Some(body) => vec![*body],
                None => {
                    let all = self.bodies.iter();
                    all.filter(|(b, _)| self.prims.is_under(**b, prim)).map(|(_, n)| *n).collect()
                }
            }
        };
        let (mut apart, mut steps) = (BTreeSet::new(), 0);
        for prim in self.prims.all() {
            for target in self.prims.targets(prim, "physics:filteredPairs") {
                let Some(other) = self.prims.find(target) else { continue };
                let (ours, theirs) = (under(prim), under(other));
                steps += ours.len() * theirs.len();
                if steps > MOST_PAIRS {
                    return self.unread(prim, "its filtered pairs are too many", AROUND);
                }
                let pairs = ours.iter().flat_map(|a| theirs.iter().map(|b| [*a, *b]));
                apart.extend(pairs);
            }
        }
        self.draft
            .apart
            .extend(apart.into_iter().map(|pair: [usize; 2]| pair.map(|n| names[n].clone())));
        let groups = |p: &usize| self.prims.kind(*p) == "PhysicsCollisionGroup";
        if let Some(group) = self.prims.all().find(groups) {
            self.unread(group, "collision groups are not read here", AROUND);
            self.unread(group, "collision groups are not read here", MOVED);
        }
    }
}

/// Followers told from where the file has all joints stand.
fn from_rest(mut bonds: Vec<Bond>) -> Vec<Bond> {
    let rests: BTreeMap<String, f64> =
        bonds.iter().map(|b| (b.joint.name.clone(), b.joint.rest)).collect();
    for bond in &mut bonds {
        let rest = bond.joint.rest;
        if let Some(mimic) = &mut bond.mimic {
            let leads = rests.get(&mimic.joint).copied().unwrap_or(0.0);
            mimic.offset += mimic.multiplier * leads - rest;
        }
    }
    bonds
}

#[cfg(test)]
mod tests;
