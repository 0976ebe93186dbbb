//! How likely every part and every joint of an articulation is right: boosted trees over what ensembles,
//! other labellings and other axes say, and a calibration of their scores.
//!
//! | Question | Right is |
//! |---|---|
//! | `labels` | the part shares at least 0.75 of its surface with the true one: intersection over union |
//! | `axis` | within 15° of the true axis |
//! | `line` | and a turn's line within 0.05 of the true one, in the unit cube |
//! | `way` | where the axis is right and has ends: what truly goes one way alone opens that way |
//! | `joint` | axis, line and way are right |
//! | `object` | every part and every joint is right |
//!
//! Forests give log-odds, averaged over folds; `slope` and `offset` of each question make them
//! probabilities, fitted to what folds say of objects that they were not grown on. Four weights make that of
//! the object of those of its parts and joints.

use std::collections::BTreeMap;

use object::condition::GivenJoint;
use object::confidence::{Confidence, Doubt, JointConfidence, PartConfidence};
use object::{ArticulatedObject, JointKind, KinematicTree};

use crate::classic::joints::evidence as joints;
use crate::classic::learned::forest::Forest;
use crate::classic::learned::pack::{Pack, PackError};
use crate::classic::learned::shipped::Shipped;
use crate::classic::lexicon::words::stem;
use crate::classic::segment::PartEvidence;
use crate::classic::segment::confidence as parts;

/// What packs of confidence are called inside.
pub const KIND: &str = "confidence";
/// How many forests answer a question together.
pub const FOLDS: usize = 3;

/// What the trees may ask of a part: its own numbers, those of what it hangs on, and those of the object.
pub const PART_INPUTS: usize = parts::COUNT + PARENT.len() + WHOLE.len() + 1;
/// What they may ask of a joint: its own numbers, and all of its part's.
pub const JOINT_INPUTS: usize = joints::COUNT + ALIKE.len() + PART_INPUTS;
/// What is known of the object: log-odds and logarithms of probabilities.
pub const OBJECT_INPUTS: usize = OBJECT_NAMES.len();

/// Trees are never surer than this: 1 is for what a person gave.
const MOST: f64 = 0.999;
/// What parts that are called alike say of a joint.
const ALIKE: [&str; 5] = [
    "alike",
    "alike_least_chance",
    "alike_mean_chance",
    "alike_mean_way",
    "alike_least_expected_iou",
];
const PARENT: [&str; 3] = ["parent_expected_iou", "parent_missed", "parent_others_least"];
/// Where those stand among a part's numbers.
const OF_PARENT: [usize; 3] = [parts::EXPECTED, 4, 5];
const WHOLE: [&str; 4] = ["parts", "least_expected_iou", "mean_expected_iou", "has_point"];
const OBJECT_NAMES: [&str; 3] = ["all_kinds", "least_labels", "least_joint"];
/// The section of the weights of those, the last of which stands alone.
pub const OBJECT: &str = "object";

/// The questions that trees answer and the tables they ask about, in the order of the pack's ensembles.
pub const QUESTIONS: [(&str, &str); 5] = [
    ("labels", "part"),
    ("axis", "joint"),
    ("line", "joint"),
    ("way", "joint"),
    ("joint", "joint"),
];

/// What the numbers of a part are called, in order.
pub fn part_names() -> Vec<String> {
    let own = parts::NAMES.iter().chain(&PARENT).chain(&WHOLE).chain(&["base"]);
    own.map(ToString::to_string).collect()
}

/// What the numbers of a joint are called, in order.
pub fn joint_names() -> Vec<String> {
    let own = joints::NAMES.iter().chain(&ALIKE).map(ToString::to_string);
    own.chain(part_names().into_iter().map(|name| format!("part_{name}"))).collect()
}

/// What the numbers of an object are called, in order.
pub fn object_names() -> Vec<String> {
    OBJECT_NAMES.map(String::from).to_vec()
}

/// The name of a forest's section.
pub fn section(question: &str, fold: usize) -> String {
    format!("{question}, fold {fold}")
}

/// The names under which the calibration of a question stands among a pack's settings: slope and offset.
pub fn settings(question: &str) -> [String; 2] {
    ["slope", "offset"].map(|what| format!("{question}: {what}"))
}

/// What is known of an articulation before anyone says how sure it is, by the parts of the object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evidence {
    /// For each part, what the trees may ask of it.
    pub parts: Vec<[f32; PART_INPUTS]>,
    /// For each part and each of its joints, what they may ask of that.
    pub joints: Vec<Vec<[f32; JOINT_INPUTS]>>,
    /// How much of the surface is one fused mesh over several parts, 0 to 1.
    pub fused: f32,
    /// For each part, the piece of it that is likeliest another's.
    pub doubts: Vec<Option<Doubt>>,
    /// For each part, the first that is called as it is, but for digits.
    pub kinds: Vec<usize>,
}

impl Evidence {
    /// What was told of parts and of joints, for each part of the object; whether each was pointed at; and what
    /// became of a part of the condition.
    pub(crate) fn of(
        object: &ArticulatedObject,
        told: &[PartEvidence],
        of_joints: &[Vec<[f64; joints::COUNT]>],
        (has_point, new): (&[bool], &dyn Fn(usize) -> Option<usize>),
    ) -> Self {
        let tree = object.tree();
        let doubt = |part: &PartEvidence| {
            let parts::Doubtful { other, chance, share, at } = part.doubt?;
            Some(Doubt { other: new(other)?, chance, share, at })
        };
        let doubts = told.iter().map(doubt).collect();
        let told: Vec<&[f64; parts::COUNT]> = told.iter().map(|t| &t.numbers).collect();
        let expected: Vec<f64> = told.iter().map(|t| t[parts::EXPECTED]).collect();
        let least = expected.iter().copied().fold(1.0, f64::min);
        let mean = expected.iter().sum::<f64>() / expected.len().max(1) as f64;
        let row = |part: usize| {
            let up = tree.parent(part).unwrap_or(part);
            let pointed = f64::from(u8::from(has_point[part]));
            let base = f64::from(u8::from(part == tree.root()));
            let own = told[part].iter().copied().chain(OF_PARENT.map(|n| told[up][n]));
            let all = own.chain([tree.len() as f64, least, mean, pointed, base]);
            filled(all)
        };
        let parts: Vec<[f32; PART_INPUTS]> = (0..tree.len()).map(row).collect();
        let kinds = kinds(tree);
        let joint = |part: usize, nth: usize, own: &[f64; joints::COUNT]| {
            let alike = (0..kinds.len()).filter(|&p| kinds[p] == kinds[part]);
            let of_alike = alike.clone().filter_map(|p| of_joints[p].get(nth));
            let count = of_alike.clone().count() as f64;
            let mean = |number: usize| of_alike.clone().map(|o| o[number]).sum::<f64>() / count;
            let least = of_alike.clone().map(|o| o[joints::CHANCE]).fold(1.0, f64::min);
            let least_iou = alike.map(|p| expected[p]).fold(1.0, f64::min);
            let alike = [count, least, mean(joints::CHANCE), mean(joints::WAY), least_iou];
            let of_part = parts[part].iter().map(|&x| f64::from(x));
            filled(own.iter().copied().chain(alike).chain(of_part))
        };
        let joints = of_joints.iter().enumerate().map(|(part, all)| {
            all.iter().enumerate().map(|(nth, own)| joint(part, nth, own)).collect()
        });
        let fused = told.first().map_or(0.0, |t| t[parts::COUNT - 1] as f32);
        Self { joints: joints.collect(), parts, fused, doubts, kinds }
    }

    /// What is known of the object, where so likely the parts and the joints are right; `moves` says which part
    /// each joint moves. Parts that are called alike are right or wrong together, so the least likely of them
    /// speaks for all.
    pub fn of_object(
        &self,
        labels: &[f64],
        (joints, moves): (&[f64], &[usize]),
    ) -> [f64; OBJECT_INPUTS] {
        let least = |all: &[f64]| log_odds(all.iter().copied().fold(MOST, f64::min));
        let mut of_kind: BTreeMap<usize, f64> = BTreeMap::new();
        let own = labels.iter().copied().enumerate();
        for (part, chance) in own.chain(moves.iter().copied().zip(joints.iter().copied())) {
            let kind = self.kinds.get(part).copied().unwrap_or(part);
            let least = of_kind.entry(kind).or_insert(1.0);
            *least = least.min(chance);
        }
        let all: f64 = of_kind.values().map(|chance| chance.max(1.0 - MOST).ln()).sum();
        [all, least(labels), least(joints)]
    }
}

/// The log-odds of a probability, none of which is certain.
fn log_odds(chance: f64) -> f64 {
    let chance = chance.clamp(1.0 - MOST, MOST);
    (chance / (1.0 - chance)).ln()
}

/// For each part, the first that is called as it is, but for digits.
fn kinds(tree: &KinematicTree) -> Vec<usize> {
    let stems: Vec<String> = tree.parts().iter().map(|part| stem(&part.text)).collect();
    let first = |stem| stems.iter().position(|other| other == stem).unwrap_or_default();
    stems.iter().map(first).collect()
}

/// Numbers as trees take them.
fn filled<const N: usize>(numbers: impl IntoIterator<Item = f64>) -> [f32; N] {
    let mut row = [0.0; N];
    row.iter_mut().zip(numbers).for_each(|(to, from)| *to = from as f32);
    row
}

/// A question's forests and calibration.
#[derive(Debug)]
struct Answers<const N: usize> {
    forests: Vec<Forest<N>>,
    slope: f64,
    offset: f64,
}

impl<const N: usize> Default for Answers<N> {
    fn default() -> Self {
        Self { forests: Vec::new(), slope: 1.0, offset: 0.0 }
    }
}

impl<const N: usize> Answers<N> {
    fn read(pack: &Pack<'_>, place: usize) -> Result<Self, PackError> {
        let question = QUESTIONS[place].0;
        let [slope, offset] = settings(question);
        let folds = 0..pack.ensemble(place)?.folds;
        let forests =
            folds.map(|fold| pack.forest(&section(question, fold))).collect::<Result<_, _>>()?;
        Ok(Self { forests, slope: pack.setting(&slope)?, offset: pack.setting(&offset)? })
    }

    fn chance(&self, row: &[f32; N]) -> f64 {
        calibrated(mean_score(&self.forests, row), [self.slope, self.offset])
    }
}

/// The mean of what forests say: log-odds.
pub fn mean_score<const N: usize>(forests: &[Forest<N>], row: &[f32; N]) -> f64 {
    let all: f64 = forests.iter().map(|forest| f64::from(forest.score(row))).sum();
    all / forests.len().max(1) as f64
}

/// Log-odds by weights, of which the last stands alone.
pub fn weighed(weights: &[f64], told: &[f64; OBJECT_INPUTS]) -> f64 {
    weights.iter().zip(told.iter().chain(&[1.0])).map(|(weight, number)| weight * number).sum()
}

/// Log-odds as a probability, by a slope and an offset; never quite certain.
pub fn calibrated(score: f64, [slope, offset]: [f64; 2]) -> f64 {
    (1.0 / (1.0 + (-(slope * score + offset)).exp())).clamp(1.0 - MOST, MOST)
}

/// What was fitted.
#[derive(Debug, Default)]
pub struct Learned {
    labels: Answers<PART_INPUTS>,
    axis: Answers<JOINT_INPUTS>,
    line: Answers<JOINT_INPUTS>,
    way: Answers<JOINT_INPUTS>,
    joint: Answers<JOINT_INPUTS>,
    /// Weights of what is known of the object; the last stands alone.
    object: Vec<f64>,
}

impl Learned {
    /// What a pack of confidence says.
    ///
    /// # Errors
    /// [`PackError`] when it is none for this program.
    pub fn read(pack: &Pack<'_>) -> Result<Self, PackError> {
        pack.is(KIND)?;
        pack.asks("part", &part_names())?;
        pack.asks("joint", &joint_names())?;
        pack.asks("object", &object_names())?;
        Ok(Self {
            labels: Answers::read(pack, 0)?,
            axis: Answers::read(pack, 1)?,
            line: Answers::read(pack, 2)?,
            way: Answers::read(pack, 3)?,
            joint: Answers::read(pack, 4)?,
            object: pack.numbers(OBJECT, OBJECT_INPUTS + 1)?,
        })
    }

    fn of_joint(
        &self,
        kind: JointKind,
        row: &[f32; JOINT_INPUTS],
        given: &GivenJoint,
    ) -> JointConfidence {
        let has_axis = given.axis.is_some();
        let has_line = has_axis && given.pivot.is_some();
        let has_way = given.range.is_some() && has_axis;
        let unless = |is_given: bool, answers: &Answers<JOINT_INPUTS>| {
            if is_given { 1.0 } else { answers.chance(row) }
        };
        let line = kind.turns().then(|| unless(has_line, &self.line));
        let way = (kind != JointKind::Continuous).then(|| unless(has_way, &self.way));
        let axis = unless(has_axis, &self.axis);
        let is_given = has_axis && line.is_none_or(|l| l == 1.0) && way.is_none_or(|w| w == 1.0);
        JointConfidence { axis, line, way, joint: unless(is_given, &self.joint), instead: None }
    }

    fn of(
        &self,
        object: &ArticulatedObject,
        evidence: &Evidence,
        given: &[Vec<GivenJoint>],
    ) -> Confidence {
        let one = |part: usize| {
            let given = |joint: usize| {
                let own = given.get(part).and_then(|g| g.get(joint));
                own.copied().unwrap_or_default()
            };
            let of = evidence.joints[part].iter().zip(object.joints(part)).enumerate();
            let joints = of.map(|(j, (row, motion))| self.of_joint(motion.kind, row, &given(j)));
            let labels = self.labels.chance(&evidence.parts[part]);
            let doubt = evidence.doubts.get(part).copied().flatten();
            PartConfidence { labels, doubt, joints: joints.collect() }
        };
        let parts: Vec<PartConfidence> = (0..object.tree().len()).map(one).collect();
        let labels: Vec<f64> = parts.iter().map(|p| p.labels).collect();
        let of_part = |(part, sure): (usize, &PartConfidence)| {
            sure.joints.iter().map(move |joint| (joint.joint, part)).collect::<Vec<_>>()
        };
        let (joints, moves): (Vec<f64>, Vec<usize>) =
            parts.iter().enumerate().flat_map(of_part).unzip();
        let told = evidence.of_object(&labels, (&joints, &moves));
        let object = calibrated(weighed(&self.object, &told), [1.0, 0.0]);
        Confidence { object, parts }
    }
}

static SHIPPED: Shipped<Learned> =
    Shipped::new(KIND, include_bytes!("../../weights/confidence.pack"), Learned::read);

/// Refuses a pack that this program cannot read.
///
/// # Errors
/// [`PackError`].
pub(crate) fn check() -> Result<(), PackError> {
    SHIPPED.check()
}

/// The name and the digest of the pack.
pub(crate) fn digest_of_pack() -> (&'static str, String) {
    SHIPPED.digest()
}

/// How sure an articulation is of itself; what is given of a joint, part by part, is sure.
pub(crate) fn confidence(
    object: &ArticulatedObject,
    evidence: &Evidence,
    given: &[Vec<GivenJoint>],
) -> Confidence {
    SHIPPED.get().of(object, evidence, given)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_has_a_name() {
        let counts = [part_names().len(), joint_names().len(), object_names().len()];
        assert_eq!(counts, [PART_INPUTS, JOINT_INPUTS, OBJECT_INPUTS]);
        let missed = OF_PARENT.map(|n| format!("parent_{}", parts::NAMES[n]));
        assert_eq!(missed.each_ref().map(String::as_str), PARENT);
        assert_eq!(parts::NAMES[parts::COUNT - 1], "fused");
    }

    #[test]
    fn the_pack_that_ships_answers_every_question_with_three_forests() {
        SHIPPED.check().unwrap();
        let Learned { labels, axis, line, way, joint, object } = SHIPPED.get();
        let joints = [axis, line, way, joint].map(|a| a.forests.len());
        assert_eq!((labels.forests.len(), joints), (FOLDS, [FOLDS; 4]));
        assert_eq!(object.len(), OBJECT_INPUTS + 1);
    }

    #[test]
    fn parts_that_are_called_alike_count_once_by_the_least_likely_of_them() {
        let evidence = Evidence { kinds: vec![0, 1, 1], ..Evidence::default() };
        let [all, labels, joint] = evidence.of_object(&[0.9, 0.8, 0.6], (&[0.5, 0.7], &[1, 2]));
        assert!((all - (0.9_f64 * 0.5).ln()).abs() < 1e-12, "{all}");
        assert!((labels - (0.6_f64 / 0.4).ln()).abs() < 1e-12 && joint.abs() < 1e-12);
    }

    #[test]
    fn log_odds_become_probabilities_by_slope_and_offset() {
        assert_eq!(calibrated(0.0, [1.0, 0.0]), 0.5);
        assert!((calibrated(2.0, [0.5, 1.0]) - 1.0 / (1.0 + (-2.0_f64).exp())).abs() < 1e-12);
    }

    #[test]
    fn what_a_person_gave_of_a_joint_is_sure() {
        let learned = Learned::default();
        let axis = Some(object::DVec3::Z);
        let pivot = Some(object::DVec3::ZERO);
        let range = Some(object::Range::Limits { lower: 0.0, upper: 1.0 });
        let row = [0.0; JOINT_INPUTS];
        let told = |given: GivenJoint| learned.of_joint(JointKind::Revolute, &row, &given);
        let nothing = told(GivenJoint::default());
        assert_eq!((nothing.axis, nothing.line, nothing.joint), (0.5, Some(0.5), 0.5));
        let all = told(GivenJoint { axis, pivot, range, ..GivenJoint::default() });
        assert_eq!((all.axis, all.line, all.way, all.joint), (1.0, Some(1.0), Some(1.0), 1.0));
        let some = told(GivenJoint { axis, ..GivenJoint::default() });
        assert_eq!((some.axis, some.line, some.joint), (1.0, Some(0.5), 0.5));
    }
}
