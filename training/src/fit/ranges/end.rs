//! The ends of ranges as they are asked about.

use std::collections::BTreeMap;

use model::classic::joints::Labelled;
use model::classic::joints::context::JointContext;
use model::classic::joints::range::usual;
use model::classic::joints::range_model::{FOLDS, INPUTS, NOTHING, amounts, likeness};
use model::classic::joints::scene::Scene;
use model::classic::joints::shared_axis;
use model::classic::joints::sweep::Axis;
use object::weld::Weld;
use object::{ArticulatedObject, JointMotion, Range};

use super::super::data::Subject;
use crate::forest::{Question, left_out_fold};
use crate::fuse::{Recipe, fused};

/// The seed of scenes.
const SCENE_SEED: u64 = 1;

/// One end of a range: of a joint first how far it goes along its axis, then how far back.
pub(super) struct End {
    /// The fold whose forest is not grown on it.
    pub fold: usize,
    pub turns: bool,
    pub is_fused: bool,
    pub asked: Question<INPUTS>,
    /// How far it is: radians, or lengths of the part.
    pub wanted: f64,
    pub usual: f64,
    pub free: f64,
    pub length: f64,
}

/// The ends of an object's ranges, as it is and, where it is said how, fused.
pub(super) fn seen(subject: &Subject, how: Option<&Recipe>) -> Vec<End> {
    let Subject { specimen, category } = subject;
    let fold = left_out_fold(&specimen.id, FOLDS);
    let fused = how.and_then(|recipe| fused(specimen, recipe).ok()).map(|s| s.object);
    let sights = [Some(specimen.object.clone()), fused].into_iter().enumerate();
    sights
        .flat_map(|(i, o)| o.map(|o| (i == 1, o)))
        .flat_map(|(is_fused, o)| ends(&o, category, (is_fused, fold)))
        .collect()
}

fn ends(object: &ArticulatedObject, category: &str, seen: (bool, usize)) -> Vec<End> {
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
    let mut ends: Vec<End> = Vec::new();
    let mut alike: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for &part in tree.root_first() {
        let up = tree.parent(part).and_then(|p| shared_axis(object.joints(p)));
        let Some(context) = JointContext::new(&scene, &from, part, up, SCENE_SEED) else {
            continue;
        };
        let stem: String =
            tree.parts()[part].text.chars().filter(|c| !c.is_ascii_digit()).collect();
        for wanted in object.joints(part) {
            let first = ends.len();
            ends.extend(of_joint(&context, wanted, seen));
            alike.entry(stem.clone()).or_default().extend(first..ends.len());
        }
    }
    for group in alike.values() {
        group.iter().for_each(|&e| ends[e].asked.weight = (group.len() as f32).sqrt().recip());
    }
    ends
}

fn of_joint(context: &JointContext, wanted: &JointMotion, seen: (bool, usize)) -> Vec<End> {
    let Range::Limits { lower, upper } = wanted.range else { return Vec::new() };
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
    let rows = context.asked(&axis, role).into_iter().enumerate();
    let one = |(way, numbers): (usize, Vec<[f32; INPUTS]>)| {
        let wanted = (far[way] / unit).min(amounts.last().copied().unwrap_or(0.0));
        let wanted = if wanted < NOTHING { 0.0 } else { wanted };
        let right: Vec<f64> = amounts.iter().map(|&a| likeness(a, wanted)).collect();
        let all: f64 = right.iter().sum();
        let truth = right.into_iter().map(|r| (r / all) as f32).collect();
        End {
            fold: seen.1,
            turns,
            is_fused: seen.0,
            asked: Question { weight: 1.0, truth, numbers },
            wanted,
            usual: if way == 0 { usual.open } else { usual.close },
            free: (if way == 0 { free.ahead } else { free.back })[0] / length,
            length,
        }
    };
    rows.map(one).collect()
}
