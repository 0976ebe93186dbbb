//! From labelled parts to joints: candidates, a choice, a range.

use object::weld::Weld;
use object::{DVec3, JointKind, JointMotion, KinematicTree, Mesh, Range};
use rayon::prelude::*;

use super::candidates::{directions, slides, turns};
use super::features::COUNT;
use super::range::Travel;
use super::scene::Scene;
use super::score::score;
use super::setting::Setting;
use super::sweep::Axis;
use crate::articulate::Note;

/// Another candidate is taken for a stuck one if it scores at most this much less.
const SECOND_CHANCE: f64 = 2.0;
/// How many candidates are looked at for a free one.
const CHANCES: usize = 6;
/// Two joints of one part share their axis, as a cap that turns and lifts does.
const SHARED_AXIS: f64 = 3.0;

/// A mesh whose faces have parts: what joints are fitted to.
#[derive(Clone, Copy, Debug)]
pub struct Labelled<'a> {
    /// The surface.
    pub mesh: &'a Mesh,
    /// Its connectivity.
    pub weld: &'a Weld,
    /// Parts and joint kinds; every part has a face.
    pub tree: &'a KinematicTree,
    /// The part of each face.
    pub part_of_face: &'a [u16],
    /// What the object is, in words; may be empty.
    pub category: &'a str,
}

/// Fitted joints, for each part those of the tree in order, and what was noticed.
#[derive(Clone, Debug, PartialEq)]
pub struct Joints {
    /// The motions, in the mesh's unit and frame.
    pub motions: Vec<Vec<JointMotion>>,
    /// Doubts, in order of part.
    pub notes: Vec<Note>,
}

/// A candidate axis and what speaks for it.
pub struct Candidate {
    /// The axis, in scene units.
    pub axis: Axis,
    /// Its numbers, in the order of [`super::features::NAMES`].
    pub features: [f64; COUNT],
}

/// Finds axis, pivot and range of every joint, parents before children.
pub fn fit_joints(from: &Labelled, seed: u64) -> Joints {
    let scene = Scene::new(from, seed);
    let tree = from.tree;
    let mut found: Vec<Vec<Travel>> = vec![Vec::new(); tree.len()];
    let mut motions = vec![Vec::new(); tree.len()];
    let mut notes: Vec<Vec<Note>> = vec![Vec::new(); tree.len()];
    for &part in tree.root_first() {
        let parent_axis = tree.parent(part).and_then(|p| axis_of(&found[p]));
        let Some(setting) = Setting::new(&scene, from, part, parent_axis, seed) else { continue };
        let travels = fit_part(&setting, &tree.parts()[part].joints);
        motions[part] = tree.parts()[part]
            .joints
            .iter()
            .zip(&travels)
            .map(|(&kind, t)| motion(&setting, kind, t))
            .collect();
        let name = &tree.parts()[part].name;
        notes[part] = travels.iter().filter_map(|t| doubt(name, t)).collect();
        found[part] = travels;
    }
    Joints { motions, notes: notes.concat() }
}

/// The axis a child of this part may share: its turn's, else its slide's.
fn axis_of(travels: &[Travel]) -> Option<DVec3> {
    let turn = travels.iter().find(|t| t.axis.turns);
    turn.or(travels.first()).map(|t| t.axis.direction)
}

/// The joints of one part: the turn is found first, the slide then prefers its axis.
fn fit_part(setting: &Setting, kinds: &[JointKind]) -> Vec<Travel> {
    let mut order: Vec<usize> = (0..kinds.len()).collect();
    order.sort_by_key(|&i| !kinds[i].turns());
    let mut found: Vec<Option<Travel>> = vec![None; kinds.len()];
    for i in order {
        let shared = found.iter().flatten().next().map(|t| t.axis.direction);
        found[i] = fit_one(setting, kinds[i], shared);
    }
    found.into_iter().flatten().collect()
}

/// The likeliest axis that is free; if none of the likely ones is, the likeliest.
fn fit_one(setting: &Setting, kind: JointKind, shared: Option<DVec3>) -> Option<Travel> {
    let role = setting.meaning.role;
    let value = |c: &Candidate| {
        let along = shared.map_or(0.0, |s| s.dot(c.axis.direction).powi(8));
        score(&c.features, kind, role) + SHARED_AXIS * along
    };
    let mut ranked: Vec<(f64, Axis)> =
        candidates(setting, kind).iter().map(|c| (value(c), c.axis)).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    let best = ranked.first()?.0;
    if kind == JointKind::Continuous {
        let axis = ranked.first()?.1;
        return Some(Travel { axis, range: Range::Continuous, stuck: false, rough: false });
    }
    let likely = ranked.iter().take(CHANCES).take_while(|r| r.0 > best - SECOND_CHANCE);
    let mut first = None;
    for (_, axis) in likely {
        let travel = setting.travel(axis, role);
        if !travel.stuck {
            return Some(travel);
        }
        first = first.or(Some(travel));
    }
    first
}

/// All candidates of one joint, measured.
pub fn candidates(setting: &Setting, kind: JointKind) -> Vec<Candidate> {
    let from = setting.sources();
    let directions = directions(&from);
    let axes = if kind.turns() { turns(&from, &directions) } else { slides(&from, &directions) };
    let measure =
        |axis: &Axis| Candidate { axis: *axis, features: setting.features(axis, &directions) };
    axes.par_iter().map(measure).collect()
}

/// The joint in the mesh's own frame and unit.
fn motion(setting: &Setting, kind: JointKind, travel: &Travel) -> JointMotion {
    let scene = setting.scene;
    let pivot = setting.pivot(&travel.axis) * scene.unit + scene.origin;
    let range = match travel.range {
        Range::Limits { lower, upper } if !kind.turns() => {
            Range::Limits { lower: lower * scene.unit, upper: upper * scene.unit }
        }
        angle => angle,
    };
    JointMotion { kind, axis: travel.axis.direction.normalize(), pivot, range }
}

fn doubt(part: &str, travel: &Travel) -> Option<Note> {
    let message = if travel.stuck {
        "no free motion was found along any likely axis, so the range is a small guess"
    } else if travel.rough {
        "the motion rubs against what stays behind, so the range allows some overlap"
    } else {
        return None;
    };
    Some(Note { part: part.into(), message: message.into(), loss: false })
}
