//! Joints as their ranges are asked about: which ways they go, and how far each way.

use std::collections::BTreeMap;

use model::classic::joints::Labelled;
use model::classic::joints::context::JointContext;
use model::classic::joints::range::usual;
use model::classic::joints::range_model::{FOLDS, INPUTS, NOTHING, amounts, likeness};
use model::classic::joints::scene::Scene;
use model::classic::joints::shared_axis;
use model::classic::joints::sweep::Axis;
use model::classic::joints::ways;
use object::weld::Weld;
use object::{ArticulatedObject, JointMotion, Range};

use super::super::data::Subject;
use crate::forest::{Question, left_out_fold};
use crate::fuse::{Recipe, fused};
use crate::metrics::opening::ONE_WAY;

/// The seed of scenes.
const SCENE_SEED: u64 = 1;

/// A joint with limits.
pub(super) struct Joint {
    /// The fold whose forests are not grown on it.
    pub fold: usize,
    pub turns: bool,
    pub is_fused: bool,
    /// Length of the part along the axis, scene units; 1 of a turn.
    pub length: f64,
    /// Which ways it goes.
    pub ways: Question<{ ways::INPUTS }>,
    /// How far it goes along its axis, then how far back.
    pub ends: [End; 2],
}

/// One end of a range.
pub(super) struct End {
    pub asked: Question<INPUTS>,
    /// How far it is: radians, or lengths of the part.
    pub wanted: f64,
    pub usual: f64,
    pub free: f64,
}

impl Joint {
    /// The truth of the ways: of a joint that goes nowhere, nothing.
    fn truth(far: [f64; 2]) -> Vec<f32> {
        let [ahead, back] = far.map(|f| f.max(0.0));
        let share = ahead / (ahead + back).max(f64::MIN_POSITIVE);
        let truth = match share {
            s if s >= ONE_WAY => [1.0, 0.0, 0.0],
            s if s <= 1.0 - ONE_WAY => [0.0, 1.0, 0.0],
            _ => [0.0, 0.0, 1.0],
        };
        truth.to_vec()
    }
}

/// The joints of an object, as it is and, where it is said how, fused.
pub(super) fn seen(subject: &Subject, how: Option<&Recipe>) -> Vec<Joint> {
    let Subject { specimen, category } = subject;
    let fold = left_out_fold(&specimen.id, FOLDS);
    let fused = how.and_then(|recipe| fused(specimen, recipe).ok()).map(|s| s.object);
    let sights = [Some(specimen.object.clone()), fused].into_iter().enumerate();
    sights
        .flat_map(|(i, o)| o.map(|o| (i == 1, o)))
        .flat_map(|(is_fused, o)| joints(&o, category, (is_fused, fold)))
        .collect()
}

fn joints(object: &ArticulatedObject, category: &str, seen: (bool, usize)) -> Vec<Joint> {
    let mesh = object.mesh();
    let weld = Weld::new(mesh);
    let tree = object.tree();
    let from = Labelled {
        mesh,
        weld: &weld,
        tree,
        part_of_face: object.part_of_face(),
        category,
        given: &[],
    };
    let scene = Scene::new(&from, SCENE_SEED);
    let mut joints: Vec<Joint> = Vec::new();
    let mut alike: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for &part in tree.root_first() {
        let up = tree.parent(part).and_then(|p| shared_axis(object.joints(p)));
        let Some(context) = JointContext::new(&scene, &from, part, up, SCENE_SEED) else {
            continue;
        };
        let stem: String =
            tree.parts()[part].text.chars().filter(|c| !c.is_ascii_digit()).collect();
        for wanted in object.joints(part) {
            let first = joints.len();
            joints.extend(of_joint(&context, wanted, seen));
            alike.entry(stem.clone()).or_default().extend(first..joints.len());
        }
    }
    for group in alike.values() {
        let weight = (group.len() as f32).sqrt().recip();
        for &joint in group {
            let joint = &mut joints[joint];
            joint.ways.weight = weight;
            joint.ends.iter_mut().for_each(|end| end.asked.weight = weight);
        }
    }
    joints
}

fn of_joint(
    context: &JointContext,
    wanted: &JointMotion,
    (is_fused, fold): (bool, usize),
) -> Option<Joint> {
    let Range::Limits { lower, upper } = wanted.range else { return None };
    let (scene, role) = (context.scene, context.meaning.role);
    let turns = wanted.kind.turns();
    let pivot = (wanted.pivot - scene.origin) / scene.unit;
    let axis = context.opening(&Axis { direction: wanted.axis, pivot, turns }, role);
    let is_along = axis.direction.dot(wanted.axis) > 0.0;
    let length = context.length(&axis);
    let unit = if turns { 1.0 } else { length * scene.unit };
    let far = if is_along { [upper, -lower] } else { [-lower, upper] };
    let usual = usual(role, turns);
    let amounts = amounts(turns);
    let free = context.freedom_of(&axis, role);
    let asked = context.asked(&axis, role);
    let one = |way: usize, numbers: Vec<[f32; INPUTS]>| {
        let wanted = (far[way] / unit).min(amounts.last().copied().unwrap_or(0.0));
        let wanted = if wanted < NOTHING { 0.0 } else { wanted };
        let right: Vec<f64> = amounts.iter().map(|&a| likeness(a, wanted)).collect();
        let all: f64 = right.iter().sum();
        let truth = right.into_iter().map(|r| (r / all) as f32).collect();
        End {
            asked: Question { weight: 1.0, truth, numbers },
            wanted,
            usual: if way == 0 { usual.open } else { usual.close },
            free: (if way == 0 { free.ahead } else { free.back })[0] / length,
        }
    };
    let [ahead, back] = asked.amounts;
    let ways = Question { weight: 1.0, truth: Joint::truth(far), numbers: asked.ways.to_vec() };
    let ends = [one(0, ahead), one(1, back)];
    Some(Joint { fold, turns, is_fused, length, ways, ends })
}
