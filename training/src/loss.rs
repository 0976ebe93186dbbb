//! The paper's loss: cross-entropy of the parts, and weighted L1 of the joint votes (section 4.4).
//!
//! Letters: B batch · M queries · P parts · R rows of the joint head.

use burn::tensor::{Device, Tensor, TensorData, activation};
use model::net::{Answer, Example};
use serde::{Deserialize, Serialize};

use crate::augment::{Lesson, Target};

/// Weights of the joint terms; defaults are the paper's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LossWeights {
    /// λ_d, of the axis direction.
    pub direction: f64,
    /// λ_c, of the nearest point of the axis.
    pub closest: f64,
    /// λ_q, of the position at each limit.
    pub limits: f64,
    /// How the rows of one joint are put together.
    pub rows: Rows,
}

/// How the rows of one joint are put together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rows {
    /// Their mean, so that joints of large and of small parts count alike and the parts are not
    /// drowned.
    #[default]
    Mean,
    /// Their sum, as the paper's formula is written.
    Sum,
}

impl Default for LossWeights {
    fn default() -> Self {
        Self { direction: 5.0, closest: 5.0, limits: 10.0, rows: Rows::Mean }
    }
}

/// The loss of a batch, and its two terms as numbers of one element each.
#[derive(Clone, Debug)]
pub struct Loss {
    /// L_part + L_joint.
    pub total: Tensor<1>,
    /// L_part.
    pub part: Tensor<1>,
    /// L_joint.
    pub joint: Tensor<1>,
}

impl Loss {
    /// Compares an answer with the lessons it was asked for, averaged over them.
    pub fn of(answer: &Answer, lessons: &[Lesson], weights: &LossWeights) -> Self {
        let part = part_loss(answer.logits.clone(), lessons);
        let joint = joint_loss(answer.joints.clone(), lessons, weights);
        Self { total: part.clone() + joint.clone(), part, joint }
    }
}

/// Mean over queries and lessons of the cross-entropy of logits [B, M, P].
fn part_loss(logits: Tensor<3>, lessons: &[Lesson]) -> Tensor<1> {
    let [batch, queries, parts] = logits.dims();
    let mut wanted = vec![0.0f32; batch * queries * parts];
    for (row, &label) in lessons.iter().flat_map(|l| &l.labels).enumerate() {
        wanted[row * parts + usize::from(label)] = 1.0;
    }
    let device = logits.device();
    let wanted = Tensor::<3>::from_data(TensorData::new(wanted, [batch, queries, parts]), &device);
    let log = activation::log_softmax(logits, 2);
    (log * wanted).sum().div_scalar(-((batch * queries) as f32))
}

/// Weighted L1 of votes [R, 12].
fn joint_loss(votes: Tensor<2>, lessons: &[Lesson], weights: &LossWeights) -> Tensor<1> {
    let device = votes.device();
    let rows = votes.dims()[0];
    if rows == 0 {
        return zero(&device);
    }
    let targets: Vec<f32> = lessons.iter().flat_map(|l| &l.targets).flatten().copied().collect();
    let shares = lessons.iter().flat_map(|l| shares(&l.example, weights.rows));
    let share = 1.0 / lessons.len() as f32;
    let factors: Vec<f32> = shares.flat_map(|s| factors(weights).map(|f| f * s * share)).collect();
    let full = |values: Vec<f32>| -> Tensor<2> {
        Tensor::from_data(TensorData::new(values, [rows, 12]), &device)
    };
    ((votes - full(targets)).abs() * full(factors)).sum()
}

fn zero(device: &Device) -> Tensor<1> {
    Tensor::zeros([1], device)
}

/// The weight of each number of a target.
fn factors(weights: &LossWeights) -> Target {
    std::array::from_fn(|i| match i / 3 {
        0 => weights.direction as f32,
        1 => weights.closest as f32,
        _ => weights.limits as f32,
    })
}

/// The weight of each row of a lesson: 1 / (P − 1), and one over the rows of its joint for means.
fn shares(example: &Example, rows: Rows) -> Vec<f32> {
    let joints = example.parts.len().saturating_sub(1).max(1) as f32;
    let of = |count: usize| match rows {
        Rows::Mean => 1.0 / (joints * count as f32),
        Rows::Sum => 1.0 / joints,
    };
    let all = example.joints.iter().map(|j| j.queries.len());
    all.flat_map(|count| std::iter::repeat_n(of(count), count)).collect()
}

#[cfg(test)]
mod tests {
    use model::net::{JointQuestion, MotionType, PartPrompt};

    use super::*;

    fn lesson(labels: Vec<u16>, queries: Vec<u32>, target: Target) -> Lesson {
        let targets = vec![target; queries.len()];
        let joint = JointQuestion { parent: 0, child: 1, motion: MotionType::Revolute, queries };
        let parts = vec![PartPrompt::default(); 3];
        Lesson {
            example: Example { parts, joints: vec![joint], ..Example::default() },
            labels,
            targets,
        }
    }

    fn answer(logits: Vec<f32>, shape: [usize; 3], joints: Vec<f32>) -> Answer {
        let device = Device::flex();
        let rows = joints.len() / 12;
        Answer {
            logits: Tensor::from_data(TensorData::new(logits, shape), &device),
            joints: Tensor::from_data(TensorData::new(joints, [rows, 12]), &device),
        }
    }

    fn numbers(loss: &Loss) -> [f32; 3] {
        [&loss.total, &loss.part, &loss.joint].map(|t| t.clone().into_scalar())
    }

    #[test]
    fn the_loss_is_the_formula_worked_by_hand() {
        let lesson = lesson(vec![0, 1], vec![0, 1], [0.0; 12]);
        let mut votes = vec![0.0; 24];
        (votes[0], votes[4], votes[12 + 8], votes[12 + 11]) = (0.1, -0.2, 0.3, 0.4);
        let answer = answer(vec![1.0, 1.0, 1.0, 0.0, 0.0, 0.0], [1, 2, 3], votes);
        let mean = Loss::of(&answer, std::slice::from_ref(&lesson), &LossWeights::default());
        let [total, part, joint] = numbers(&mean);
        assert!((part - 3f32.ln()).abs() < 1e-6, "three parts alike: {part}");
        let wanted = (5.0 * 0.1 + 5.0 * 0.2 + 10.0 * 0.3 + 10.0 * 0.4) / 2.0 / 2.0;
        assert!((joint - wanted).abs() < 1e-5 && (total - part - joint).abs() < 1e-5);
        let weights = LossWeights { rows: Rows::Sum, ..LossWeights::default() };
        let [_, _, sum] = numbers(&Loss::of(&answer, &[lesson], &weights));
        assert!((sum - 2.0 * joint).abs() < 1e-5);
    }

    #[test]
    fn a_right_answer_costs_nothing_and_an_object_without_joints_has_no_joint_loss() {
        let target: Target = std::array::from_fn(|i| i as f32 / 7.0);
        let right = lesson(vec![2], vec![0], target);
        let good = answer(vec![-50.0, -50.0, 50.0], [1, 1, 3], target.to_vec());
        let [total, ..] = numbers(&Loss::of(&good, &[right], &LossWeights::default()));
        assert!(total.abs() < 1e-6);
        let still = Lesson { example: Example::default(), labels: vec![0], targets: vec![] };
        let answer = answer(vec![0.0, 0.0], [1, 1, 2], vec![]);
        let [total, part, joint] = numbers(&Loss::of(&answer, &[still], &LossWeights::default()));
        assert_eq!(joint, 0.0);
        assert_eq!(total, part);
    }
}
