//! How good the weights are on objects they never saw: losses, labels and axes, with true labels
//! for the axes, as in training.

use std::path::PathBuf;

use burn::tensor::{Device, Tensor};
use model::net::{Answer, Batch, Network};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::error::TrainError;
use crate::augment::{Augment, Lesson, LessonSize, lesson};
use crate::dataset::cache;
use crate::loss::{Loss, LossWeights};

/// Heads of the table of validation, after the step.
pub const HEADS: &str =
    "step,set,objects,part_loss,joint_loss,accuracy,miou,joints,axis_error,within_15,line_error";

/// What was measured on one set.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Score {
    /// Objects looked at.
    pub objects: usize,
    /// L_part, averaged over objects.
    pub part_loss: f64,
    /// L_joint, averaged over objects.
    pub joint_loss: f64,
    /// Share of queries labelled right, averaged over objects.
    pub accuracy: f64,
    /// Intersection over union of parts by points, averaged over parts, then objects.
    pub miou: f64,
    /// Joints that were asked about.
    pub joints: usize,
    /// Mean angle between found and true axis, sign-free, degrees.
    pub axis_error: f64,
    /// Share of joints whose axis is within 15 degrees.
    pub within_15: f64,
    /// Mean distance between found and true line of turns, unit cube.
    pub line_error: f64,
}

impl Score {
    /// Cells of the table, after the step.
    pub fn cells(&self, set: &str) -> Vec<String> {
        let numbers = [
            self.part_loss,
            self.joint_loss,
            self.accuracy,
            self.miou,
            self.joints as f64,
            self.axis_error,
            self.within_15,
            self.line_error,
        ];
        let numbers = numbers.iter().map(|v| format!("{v:.5}"));
        [set.to_owned(), self.objects.to_string()].into_iter().chain(numbers).collect()
    }
}

/// Sums over objects and joints.
#[derive(Default)]
struct Sums {
    objects: f64,
    part_loss: f64,
    joint_loss: f64,
    accuracy: f64,
    miou: f64,
    angles: Vec<f64>,
    lines: Vec<f64>,
}

/// Measures a network on samples, each with everything shown and nothing changed; samples with too
/// many parts are passed over.
///
/// # Errors
/// [`TrainError`] when a sample cannot be read or numbers cannot be read back.
pub fn validate(
    network: &Network,
    samples: &[PathBuf],
    size: LessonSize,
    weights: &LossWeights,
) -> Result<Score, TrainError> {
    let mut sums = Sums::default();
    let device = Device::flex().autodiff();
    for (i, path) in samples.iter().enumerate() {
        let sample = cache::read(path)?;
        let mut rng = Pcg64Mcg::seed_from_u64(i as u64);
        let size = LessonSize { balanced: 0, ..size };
        let Ok(lesson) = lesson(&sample, &Augment::none(), size, &mut rng) else { continue };
        let examples = std::slice::from_ref(&lesson.example);
        let batch = Batch::new(examples, network.config(), &device)?;
        let answer = network.forward(&batch);
        let loss = Loss::of(&answer, std::slice::from_ref(&lesson), weights);
        sums.part_loss += f64::from(loss.part.into_scalar::<f32>());
        sums.joint_loss += f64::from(loss.joint.into_scalar::<f32>());
        sums.add(&lesson, &answer)?;
    }
    Ok(sums.score())
}

fn numbers<const D: usize>(x: Tensor<D>) -> Result<Vec<f32>, TrainError> {
    x.into_data().try_into_vec().map_err(|e| TrainError::Device(format!("{e:?}")))
}

impl Sums {
    fn add(&mut self, lesson: &Lesson, answer: &Answer) -> Result<(), TrainError> {
        let parts = lesson.example.parts.len();
        let logits = numbers(answer.logits.clone())?;
        let best =
            |row: &[f32]| (0..row.len()).fold(0, |b, p| if row[p] > row[b] { p } else { b }) as u16;
        let found: Vec<u16> = logits.chunks_exact(parts).map(best).collect();
        let right = found.iter().zip(&lesson.labels).filter(|(a, b)| a == b).count();
        self.objects += 1.0;
        self.accuracy += right as f64 / found.len().max(1) as f64;
        self.miou += mean_iou(&found, &lesson.labels, parts);
        self.add_joints(lesson, &numbers(answer.joints.clone())?);
        Ok(())
    }

    fn add_joints(&mut self, lesson: &Lesson, votes: &[f32]) {
        let mut row = 0;
        for joint in &lesson.example.joints {
            let rows = row..row + joint.queries.len();
            row = rows.end;
            let votes = rows.clone().map(|r| std::array::from_fn(|i| votes[12 * r + i]));
            let [found, wanted] = [mean_line(votes), mean_line(rows.map(|r| lesson.targets[r]))];
            self.angles.push(angle(found.0, wanted.0));
            if joint.motion == model::net::MotionType::Revolute {
                self.lines.push(apart(found, wanted));
            }
        }
    }

    fn score(&self) -> Score {
        let each = |sum: f64| sum / self.objects.max(1.0);
        let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len().max(1) as f64;
        let near = self.angles.iter().filter(|&&a| a <= 15.0).count();
        Score {
            objects: self.objects as usize,
            part_loss: each(self.part_loss),
            joint_loss: each(self.joint_loss),
            accuracy: each(self.accuracy),
            miou: each(self.miou),
            joints: self.angles.len(),
            axis_error: mean(&self.angles),
            within_15: near as f64 / self.angles.len().max(1) as f64,
            line_error: mean(&self.lines),
        }
    }
}

/// Over the parts that queries truly lie on.
fn mean_iou(found: &[u16], wanted: &[u16], parts: usize) -> f64 {
    let (mut both, mut either) = (vec![0.0; parts], vec![0.0; parts]);
    let mut there = vec![false; parts];
    for (&a, &b) in found.iter().zip(wanted) {
        let [a, b] = [a, b].map(usize::from);
        there[b] = true;
        either[b] += 1.0;
        if a == b {
            both[b] += 1.0;
        } else {
            either[a] += 1.0;
        }
    }
    let known: Vec<f64> = (0..parts).filter(|&p| there[p]).map(|p| both[p] / either[p]).collect();
    known.iter().sum::<f64>() / known.len().max(1) as f64
}

type V = object::DVec3;

/// Mean direction, normalised, and mean point of votes.
fn mean_line(votes: impl Iterator<Item = [f32; 12]>) -> (V, V) {
    let (mut direction, mut point, mut count) = (V::ZERO, V::ZERO, 0.0);
    for v in votes.map(|v| v.map(f64::from)) {
        direction += V::new(v[0], v[1], v[2]);
        point += V::new(v[3], v[4], v[5]);
        count += 1.0;
    }
    (direction.normalize_or_zero(), point / f64::max(count, 1.0))
}

fn angle(a: V, b: V) -> f64 {
    a.dot(b).abs().min(1.0).acos().to_degrees()
}

/// Distance between two lines.
fn apart((a, p): (V, V), (b, q): (V, V)) -> f64 {
    let across = a.cross(b);
    if across.length() < 1e-6 {
        let d = p - q;
        return (d - b * d.dot(b)).length();
    }
    (p - q).dot(across.normalize()).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlap_counts_what_is_missed_and_what_is_taken() {
        assert_eq!(mean_iou(&[0, 1, 1], &[0, 1, 1], 3), 1.0);
        assert!(
            (mean_iou(&[0, 0, 1, 1], &[0, 1, 1, 1], 2) - (0.5 + 2.0 / 3.0) / 2.0).abs() < 1e-12
        );
    }

    #[test]
    fn lines_are_as_far_apart_as_geometry_says() {
        let (x, y, z) = (V::X, V::Y, V::Z);
        assert!((apart((x, V::ZERO), (y, z * 0.3)) - 0.3).abs() < 1e-12);
        assert!((apart((x, y), (x, V::ZERO + x * 5.0)) - 1.0).abs() < 1e-12);
        assert_eq!(angle(x, -x), 0.0);
    }
}
