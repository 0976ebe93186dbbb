//! From labelled parts to joints: candidates, a choice, a range.

use object::{DVec3, JointKind, KinematicTree, Mesh};
use rayon::prelude::*;

use super::candidates::{directions, slides, turns};
use super::contact::Contact;
use super::features::{COUNT, Setting};
use super::scene::Scene;
use super::sweep::Axis;
use super::words::meaning;

/// A candidate axis and what speaks for it.
pub struct Candidate {
    /// The axis, in scene units.
    pub axis: Axis,
    /// Its numbers, in the order of [`super::features::NAMES`].
    pub features: [f64; COUNT],
}

/// What is known about the joint of `part` before its axis is chosen.
pub fn setting<'a>(
    scene: &'a Scene,
    tree: &KinematicTree,
    part: usize,
    parent_axis: Option<DVec3>,
    seed: u64,
) -> Option<Setting<'a>> {
    let parent = tree.parent(part)?;
    let still: Vec<usize> = (0..tree.len()).filter(|&p| !tree.is_under(p, part)).collect();
    let moving = (0..tree.len()).filter(|&p| tree.is_under(p, part));
    let probes = moving.flat_map(|p| scene.bodies[p].probes.iter().copied()).collect();
    let contact = Contact::new(scene, part, parent, &still, seed);
    let word = meaning(&tree.parts()[part].text, "");
    Some(Setting {
        scene,
        body: &scene.bodies[part],
        parent: &scene.bodies[parent],
        parent_index: parent,
        index: part,
        contact,
        still,
        probes,
        parent_axis,
        words: [word.upright, word.level],
    })
}

/// All candidates of one joint, measured.
pub fn candidates(setting: &Setting, kind: JointKind) -> Vec<Candidate> {
    let from = setting.sources();
    let directions = directions(&from);
    let axes = if kind.turns() { turns(&from, &directions) } else { slides(&from, &directions) };
    let measure = |axis: &Axis| Candidate { axis: *axis, features: setting.features(axis, &directions) };
    axes.par_iter().map(measure).collect()
}

/// The scene of a labelled mesh.
pub fn scene(mesh: &Mesh, tree: &KinematicTree, part_of_face: &[u16], seed: u64) -> Scene {
    Scene::new(mesh, &object::weld::Weld::new(mesh), part_of_face, tree.len(), seed)
}
