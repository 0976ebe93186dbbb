//! Joints as they are asked about: their candidates, and how far each is from the truth.

use std::collections::BTreeMap;

use model::classic::joints::Labelled;
use model::classic::joints::axis_model::{INPUTS, Inputs, inputs};
use model::classic::joints::candidates;
use model::classic::joints::context::JointContext;
use model::classic::joints::endless;
use model::classic::joints::features::COUNT;
use model::classic::joints::scene::Scene;
use model::classic::joints::shared_axis;
use model::classic::lexicon::words::ROLES;
use model::classic::segment::{Way, label_faces};
use object::weld::Weld;
use object::{ArticulatedObject, DVec3, JointKind, JointMotion};

use super::super::segments::prompted;
use super::knuckles::{self, Side};
use crate::forest::Question;

/// Angle and distance, as a share of the largest extent, beyond which an axis is wrong.
pub(super) const WRONG: (f64, f64) = (15.0, 0.05);
/// Angle and distance that make an axis less right by a factor of e.
const OFF: (f64, f64) = (4.0, 0.008);
/// The seed of scenes.
const SCENE_SEED: u64 = 1;

/// How an object is seen, each time with its true labels and with those that are found; then, fused, with
/// hinges that are all of one side.
pub(super) const SIGHTS: [&str; 6] = [
    "as it is",
    "as it is, labelled",
    "fused",
    "fused, labelled",
    "fused, hinges of the part",
    "fused, hinges of its parent",
];
/// Which of them are fused, with true labels.
const FUSED: usize = 2;
/// Which of them have hinges that are all of one side.
const ONE_SIDED: [(usize, Side); 2] = [(4, Side::Part), (5, Side::Parent)];

/// A joint and its candidates.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Joint {
    /// Which share of the objects it is of: folds that leave that out do not know it.
    pub share: usize,
    /// Which of [`SIGHTS`].
    pub sight: usize,
    pub turns: bool,
    pub asked: Question<INPUTS>,
    /// For each candidate, how far it is from the truth: degrees, and a share of the largest extent.
    pub off: Vec<(f32, f32)>,
}

impl Joint {
    /// Whether any candidate is right.
    pub(super) fn is_told(&self) -> bool {
        self.asked.truth.iter().any(|t| *t > 0.0)
    }

    /// The joint's role, by its place in [`ROLES`], and whether it turns without end, as trees are told;
    /// `None` if it has no candidates.
    pub(super) fn told(&self) -> Option<(usize, bool)> {
        let first = self.asked.numbers.first()?;
        let role = (0..ROLES.len()).find(|r| first[2 * COUNT + r] > 0.5)?;
        Some((role, first[INPUTS - 1] > 0.5))
    }
}

/// The candidate's own features among those that trees are told.
pub(super) fn own(numbers: &[f32; INPUTS]) -> [f64; COUNT] {
    let mut row = [0.0; COUNT];
    row.iter_mut().zip(numbers).for_each(|(r, n)| *r = f64::from(*n));
    row
}

/// The first of the largest.
pub(super) fn best(scores: &[f64]) -> usize {
    (0..scores.len()).reduce(|a, b| if scores[b] > scores[a] { b } else { a }).unwrap_or(0)
}

/// The candidate nearest the truth.
pub(super) fn nearest(joint: &Joint) -> usize {
    let far =
        |k: &usize| f64::from(joint.off[*k].0) / WRONG.0 + f64::from(joint.off[*k].1) / WRONG.1;
    (0..joint.off.len()).min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(0)
}

/// The joints of an object by its true labels and by those that are found.
pub(super) fn seen_as(
    object: &ArticulatedObject,
    category: &str,
    (sight, share, way): (usize, usize, Way),
) -> Vec<Joint> {
    let mesh = object.mesh();
    let weld = Weld::new(mesh);
    let truth: Vec<&[JointMotion]> = (0..object.tree().len()).map(|p| object.joints(p)).collect();
    let from = Labelled {
        mesh,
        weld: &weld,
        tree: object.tree(),
        part_of_face: object.part_of_face(),
        category,
        given: &[],
    };
    let scene = Scene::new(&from, SCENE_SEED);
    let all = vec![true; truth.len()];
    let mut joints = joints((&from, &scene), (&truth, &all), (sight, share));
    let is_fused = sight == FUSED;
    let hinges = if is_fused { knuckles::hinges((&from, &scene), &truth) } else { Vec::new() };
    for (sight, side) in ONE_SIDED {
        let (labels, is_changed) = knuckles::given(&from, &hinges, side);
        if is_changed.contains(&true) {
            let from = Labelled { part_of_face: &labels, ..from };
            let scene = Scene::new(&from, SCENE_SEED);
            let asked = (&truth[..], &is_changed[..]);
            joints.extend(self::joints((&from, &scene), asked, (sight, share)));
        }
    }
    let condition = prompted((object, mesh), category, None);
    let labels = label_faces(mesh, &condition, &weld, way).part_of_face;
    let mut lost = vec![true; truth.len()];
    labels.iter().for_each(|&l| lost[usize::from(l)] = false);
    let Ok((tree, now)) = object.tree().without(&lost) else { return joints };
    if tree.len() < 2 {
        return joints;
    }
    let labels: Vec<u16> =
        labels.iter().map(|&l| now[usize::from(l)].unwrap_or_default() as u16).collect();
    let kept = (0..truth.len()).filter(|&p| now[p].is_some()).map(|p| truth[p]).collect::<Vec<_>>();
    let from =
        Labelled { mesh, weld: &weld, tree: &tree, part_of_face: &labels, category, given: &[] };
    let (scene, all) = (Scene::new(&from, SCENE_SEED), vec![true; kept.len()]);
    joints.extend(self::joints((&from, &scene), (&kept, &all), (sight + 1, share)));
    joints
}

/// The joints of those parts that are asked about.
fn joints(
    (from, scene): (&Labelled, &Scene),
    (truth, is_asked): (&[&[JointMotion]], &[bool]),
    (sight, share): (usize, usize),
) -> Vec<Joint> {
    let tree = from.tree;
    let mut joints = Vec::new();
    let mut alike: BTreeMap<(String, usize), Vec<usize>> = BTreeMap::new();
    for &part in tree.root_first().iter().filter(|&&p| is_asked[p]) {
        let up = tree.parent(part).and_then(|p| shared_axis(truth[p]));
        let Some(context) = JointContext::new(scene, from, part, up, SCENE_SEED) else { continue };
        for (k, (&kind, wanted)) in tree.parts()[part].joints.iter().zip(truth[part]).enumerate() {
            let text = tree.parts()[part].text.chars().filter(|c| !c.is_ascii_digit()).collect();
            alike.entry((text, k)).or_default().push(joints.len());
            joints.push(joint((from, scene, &context), (kind, wanted), (sight, share)));
        }
    }
    for group in alike.values() {
        for &j in group {
            joints[j].asked.weight = (group.len() as f32).sqrt().recip();
        }
    }
    joints
}

fn joint(
    (from, scene, context): (&Labelled, &Scene, &JointContext),
    (kind, wanted): (JointKind, &JointMotion),
    (sight, share): (usize, usize),
) -> Joint {
    let role = context.meaning.role;
    let role = if kind == JointKind::Continuous { endless(role) } else { role };
    let found = candidates(context, kind);
    let features: Vec<&[f64; COUNT]> = found.iter().map(|c| &c.features).collect();
    let asked: Vec<Inputs> = inputs(&features, kind, role);
    let extent = from.mesh.bounds().size().max_element();
    let off: Vec<(f32, f32)> = found
        .iter()
        .map(|c| {
            let pivot = c.axis.pivot * scene.unit + scene.origin;
            let (angle, line) = off(c.axis.direction, pivot, wanted);
            (angle as f32, (line / extent) as f32)
        })
        .collect();
    let question = Question { weight: 1.0, truth: right(&off), numbers: asked };
    Joint { share, sight, turns: kind.turns(), asked: question, off }
}

/// How often each candidate ought to be chosen, by how far off it is; all 0 where none is near.
fn right(off: &[(f32, f32)]) -> Vec<f32> {
    let right = |&(angle, line): &(f32, f32)| {
        let (angle, line) = (f64::from(angle), f64::from(line));
        let is_wrong = angle >= WRONG.0 || line >= WRONG.1;
        if is_wrong { 0.0 } else { (-angle / OFF.0 - line / OFF.1).exp() }
    };
    let right: Vec<f64> = off.iter().map(right).collect();
    let sum: f64 = right.iter().sum();
    right.into_iter().map(|r| if sum > 0.0 { (r / sum) as f32 } else { 0.0 }).collect()
}

/// Angle of an axis to the true one, degrees, and for turns the distance of both lines.
fn off(direction: DVec3, pivot: DVec3, wanted: &JointMotion) -> (f64, f64) {
    let angle = wanted.axis.dot(direction).abs().min(1.0).acos().to_degrees();
    let (across, apart) = (wanted.axis.cross(direction), pivot - wanted.pivot);
    let line = if !wanted.kind.turns() {
        0.0
    } else if across.length() < 1e-3 {
        apart.reject_from_normalized(wanted.axis).length()
    } else {
        apart.dot(across.normalize()).abs()
    };
    (angle, line)
}

#[cfg(test)]
mod tests {
    use object::Range;

    use super::*;

    #[test]
    fn an_axis_is_off_by_its_angle_and_a_turn_by_how_far_its_line_lies_too() {
        let range = Range::Limits { lower: 0.0, upper: 1.0 };
        let turn =
            JointMotion { kind: JointKind::Revolute, axis: DVec3::Z, pivot: DVec3::X, range };
        let (angle, line) = off(DVec3::NEG_Z, DVec3::new(1.0, 2.0, 9.0), &turn);
        assert!(angle < 1e-6 && (line - 2.0).abs() < 1e-12, "{angle}, {line}");
        let (angle, line) = off(DVec3::X, DVec3::new(0.0, 0.25, 3.0), &turn);
        assert!((angle - 90.0).abs() < 1e-6 && (line - 0.25).abs() < 1e-12, "{angle}, {line}");
        let slide = JointMotion { kind: JointKind::Prismatic, ..turn };
        assert_eq!(off(DVec3::Z, DVec3::splat(7.0), &slide), (0.0, 0.0));
    }

    #[test]
    fn the_nearer_a_candidate_the_oftener_it_is_right_and_none_where_none_is_near() {
        let near = right(&[(0.0, 0.0), (4.0, 0.0), (20.0, 0.0), (0.0, 0.06)]);
        assert!((near[0] / near[1] - std::f32::consts::E).abs() < 1e-4, "{near:?}");
        assert!((near[0] + near[1] - 1.0).abs() < 1e-6 && near[2..] == [0.0, 0.0], "{near:?}");
        assert_eq!(right(&[(90.0, 0.0)]), [0.0]);
    }
}
