//! Bodies side by side and the joints between them → a tree of links, for formats that tell where each
//! body stands rather than what it hangs on.
//!
//! A body with a joint above it is a link whose frame stands at the joint, as in URDF; joints are taken as
//! they are told, from parent to child, and the other way round where nothing else holds a body. What is
//! left over closes a loop. Bodies that hang on nothing float beside each other in a link `world`; one
//! alone is the root itself, in the frame of the world.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use glamx::DPose3;

use crate::read::draft::{Draft, JointDraft, MimicDraft, Tie};
use crate::robot::{Inertial, Joint, Link, Motion, Shape};

/// Name of the link that stands for the world.
const WORLD: &str = "world";

/// A rigid body.
pub(crate) struct Body {
    /// Shapes and inertia are told in its own frame.
    pub link: Link,
    /// Its frame in the world.
    pub at: DPose3,
    /// Whether it never moves.
    pub is_still: bool,
}

/// A joint between two bodies, or a body and the world.
pub(crate) struct Bond {
    /// Axes are told in its own frame.
    pub joint: Joint,
    /// Its frame in the world.
    pub at: DPose3,
    /// Indices of the bodies it leads from and to; `None` is the world.
    pub ends: [Option<usize>; 2],
    pub mimic: Option<MimicDraft>,
    /// A joint that follows at the same place.
    pub second: Option<Joint>,
}

/// Puts links, joints and loops into a draft.
pub(crate) fn assemble(draft: &mut Draft, bodies: Vec<Body>, bonds: Vec<Bond>, line: u32) {
    let tree = Tree::of(&bodies, &bonds);
    let world = tree.has_world.then_some(DPose3::identity());
    let mut taken: BTreeSet<String> = bodies.iter().map(|b| b.link.name.clone()).collect();
    let world_name = world.map(|_| free(&mut taken, WORLD.into()));
    let mut joints: BTreeSet<String> = bonds.iter().map(|b| b.joint.name.clone()).collect();
    if let Some(name) = &world_name {
        let (visuals, collisions, name) = (vec![], vec![], name.clone());
        let link = Link { name, inertial: None, visuals, collisions, between: false, line };
        draft.links.push(link);
        let floats = tree.loose.iter().any(|l| !bodies[*l].is_still);
        draft.beside.floats = Some(floats);
    }
    let world_name = world_name.unwrap_or_default();
    let frames: Vec<DPose3> = (0..bodies.len()).map(|l| tree.frame(l, &bodies, &bonds)).collect();
    let names: Vec<String> = bodies.iter().map(|b| b.link.name.clone()).collect();
    let name_of = |end: Option<usize>| end.map_or(&world_name, |l| &names[l]);
    let lost: BTreeSet<&str> = tree.loops.iter().map(|b| bonds[*b].joint.name.as_str()).collect();
    for &b in &tree.loops {
        let Bond { joint, ends, .. } = &bonds[b];
        let why = format!("is part of a closed loop (line {}: joint `{}`)", joint.line, joint.name);
        draft.ties.push(Tie { bodies: ends.map(|end| name_of(end).clone()), why });
    }
    for (b, bond) in bonds.iter().enumerate() {
        let Some(&child) = tree.below.get(&b) else { continue };
        let is_turned = bond.ends[1] != Some(child);
        let parent = bond.ends[usize::from(is_turned)];
        let above = parent.map_or(DPose3::identity(), |p| frames[p]);
        let origin = relative(above, bond.at);
        let mut row = vec![(bond.joint.clone(), bond.mimic.as_ref())];
        row.extend(bond.second.clone().map(|joint| (joint, None)));
        if is_turned {
            row.reverse();
        }
        let (mut from, mut origin, count) = (name_of(parent).clone(), origin, row.len());
        for (k, (mut joint, mimic)) in row.into_iter().enumerate() {
            joint.origin = origin;
            if is_turned {
                (joint.axis, joint.axis_as_written) = (-joint.axis, -joint.axis_as_written);
            }
            let mimic = mimic.filter(|m| {
                let is_lost = lost.contains(m.joint.as_str());
                if is_lost {
                    joint.held = Some("follows a joint of a closed loop".into());
                }
                !is_lost
            });
            let mimic = mimic.map(|m| MimicDraft { joint: m.joint.clone(), ..*m });
            let to = match k + 1 == count {
                true => names[child].clone(),
                false => {
                    let name = free(&mut taken, format!("{}__{k}", names[child]));
                    draft.links.push(between(&name, joint.line));
                    name
                }
            };
            draft.joints.push(JointDraft { joint, parent: from, child: to.clone(), mimic });
            (from, origin) = (to, DPose3::identity());
        }
    }
    for (l, body) in bodies.into_iter().enumerate() {
        if tree.has_world && tree.loose.contains(&l) {
            let (kind, ending) = match body.is_still {
                true => (Motion::Fixed, "fixed"),
                false => (Motion::Floating, "free"),
            };
            let name = free(&mut joints, format!("{}_{ending}", body.link.name));
            let joint = bare(name, kind, frames[l], body.link.line);
            let (parent, child) = (world_name.clone(), body.link.name.clone());
            draft.joints.push(JointDraft { joint, parent, child, mimic: None });
        }
        draft.links.push(moved(body.link, relative(frames[l], body.at)));
    }
}

/// Which joint each body hangs on.
struct Tree {
    has_world: bool,
    /// Bodies that hang on no joint.
    loose: BTreeSet<usize>,
    /// The body below each joint of the tree.
    below: BTreeMap<usize, usize>,
    /// The joint above each body.
    above: Vec<Option<usize>>,
    /// Joints that close loops.
    loops: Vec<usize>,
}

impl Tree {
    fn of(bodies: &[Body], bonds: &[Bond]) -> Self {
        let (mut below, mut above) = (BTreeMap::new(), vec![None; bodies.len()]);
        let mut is_met = vec![false; bodies.len()];
        let mut loose = BTreeSet::new();
        let on_world = |b: &Bond| b.ends.contains(&None);
        let mut has_world = bodies.iter().any(|b| b.is_still) || bonds.iter().any(on_world);
        for (l, _) in bodies.iter().enumerate().filter(|(_, b)| b.is_still) {
            is_met[l] = true;
            loose.insert(l);
        }
        let mut queue: VecDeque<Option<usize>> = loose.iter().map(|l| Some(*l)).collect();
        if has_world {
            queue.push_front(None);
        }
        loop {
            while let Some(from) = queue.pop_front() {
                for (b, bond) in bonds.iter().enumerate().filter(|(_, b)| b.ends[0] == from) {
                    let Some(to) = bond.ends[1].filter(|to| !is_met[*to]) else { continue };
                    (is_met[to], above[to]) = (true, Some(b));
                    below.insert(b, to);
                    queue.push_back(Some(to));
                }
            }
            // A joint told the other way round, where nothing else leads to a body.
            let met = |end: Option<usize>, is_met: &[bool]| match end {
                Some(l) => is_met[l],
                None => has_world,
            };
            let turned = bonds.iter().enumerate().find_map(|(b, bond)| {
                let to = bond.ends[0].filter(|l| !is_met[*l])?;
                met(bond.ends[1], &is_met).then_some((b, to))
            });
            let next = turned.map(|(b, to)| {
                above[to] = Some(b);
                below.insert(b, to);
                to
            });
            let first = || {
                let left = (0..bodies.len()).filter(|l| !is_met[*l]);
                let is_child = |l: usize| bonds.iter().any(|b| b.ends[1] == Some(l));
                left.clone().find(|l| !is_child(*l)).or_else(|| left.clone().next())
            };
            let Some(to) = next.or_else(first) else { break };
            if above[to].is_none() {
                loose.insert(to);
            }
            is_met[to] = true;
            queue.push_back(Some(to));
        }
        has_world |= loose.len() > 1;
        let loops = (0..bonds.len()).filter(|b| !below.contains_key(b)).collect();
        Self { has_world, loose, below, above, loops }
    }

    /// The frame of a link in the world.
    fn frame(&self, link: usize, bodies: &[Body], bonds: &[Bond]) -> DPose3 {
        match self.above[link] {
            Some(bond) => bonds[bond].at,
            None if self.has_world => bodies[link].at,
            None => DPose3::identity(),
        }
    }
}

/// One frame in another; of two that are the same exactly none.
pub(crate) fn relative(from: DPose3, to: DPose3) -> DPose3 {
    if from == to { DPose3::identity() } else { from.inverse() * to }
}

/// The name, or the name with the first free number.
fn free(taken: &mut BTreeSet<String>, name: String) -> String {
    let mut found = name.clone();
    let mut number = 2;
    while taken.contains(&found) {
        found = format!("{name}_{number}");
        number += 1;
    }
    taken.insert(found.clone());
    found
}

fn between(name: &str, line: u32) -> Link {
    let (visuals, collisions) = (vec![], vec![]);
    Link { name: name.into(), inertial: None, visuals, collisions, between: true, line }
}

/// A joint of which nothing is said.
pub(crate) fn bare(name: String, kind: Motion, origin: DPose3, line: u32) -> Joint {
    Joint {
        name,
        kind,
        parent: usize::MAX,
        child: usize::MAX,
        origin,
        axis: glamx::DVec3::X,
        axis_as_written: glamx::DVec3::X,
        limit: None,
        dynamics: None,
        mimic: None,
        rest: 0.0,
        spring: None,
        held: None,
        line,
    }
}

/// A link told in another frame.
fn moved(link: Link, by: DPose3) -> Link {
    if by == DPose3::identity() {
        return link;
    }
    let shape = |s: Shape| Shape { origin: by * s.origin, ..s };
    let shapes = |all: Vec<Shape>| all.into_iter().map(shape).collect();
    let inertial = |i: Inertial| Inertial { origin: by * i.origin, ..i };
    Link {
        inertial: link.inertial.map(inertial),
        visuals: shapes(link.visuals),
        collisions: shapes(link.collisions),
        ..link
    }
}
