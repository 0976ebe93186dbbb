//! Inference: one object digested once, its queries answered in chunks of any size.

use burn::tensor::{Device, Tensor};

use super::batch::Example;
use super::embed::{Cloud, Points};
use super::error::{BatchError, NetworkError};
use super::heads::{JOINT_WIDTH, JointRows};
use super::network::{Batch, Memory, Network, Prompts};
use super::watch::Watch;

/// One object, ready to be asked about.
#[derive(Clone, Debug)]
pub struct Question {
    shape: Cloud,
    parts: Prompts,
}

/// What a chunk of queries was answered.
#[derive(Clone, Debug)]
pub struct Labels {
    /// The part of each query, the first where several have the same score.
    pub part: Vec<u16>,
    /// Scores [Q, P], row-major.
    pub logits: Vec<f32>,
    tokens: Tensor<3>,
    queries: Cloud,
}

/// One point's opinion of a joint; unit cube, as the head wrote it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vote {
    /// Direction of the axis; not of unit length.
    pub direction: [f32; 3],
    /// The point of the axis nearest the query.
    pub closest: [f32; 3],
    /// Where the query stands at the lower limit.
    pub lower: [f32; 3],
    /// Where it stands at the upper limit.
    pub upper: [f32; 3],
}

impl Network {
    fn device(&self) -> Device {
        burn::module::Module::devices(self).into_iter().next().unwrap_or_default()
    }

    /// Puts shape and parts of an example on the network's device.
    ///
    /// # Errors
    /// [`BatchError`] when they do not fit the configuration.
    pub fn question(&self, example: &Example) -> Result<Question, BatchError> {
        let (config, device) = (self.config(), self.device());
        let bare = Example {
            queries: example.shape.slice(0..example.shape.positions.len().min(1), config.features),
            joints: vec![],
            ..example.clone()
        };
        let batch = Batch::new(&[bare], config, &device)?;
        Ok(Question { shape: batch.shape, parts: batch.parts })
    }

    /// Digests an object: shape tokens, part tokens, and the keys and values queries look at.
    ///
    /// # Errors
    /// [`NetworkError::NotFinite`], naming the layer.
    pub fn digest(&self, question: &Question) -> Result<Memory, NetworkError> {
        let mut watch = Watch::on();
        let memory = self.remember(&question.shape, &question.parts, &mut watch);
        finite(watch)?;
        Ok(memory)
    }

    /// Labels queries; the same labels however they are cut into chunks.
    ///
    /// # Errors
    /// [`NetworkError`], for values that are not finite naming the layer.
    pub fn labels(&self, memory: &Memory, queries: &Points) -> Result<Labels, NetworkError> {
        let count = queries.positions.len();
        if count == 0 {
            let rule = "at least 1".into();
            let what = "query points";
            return Err(BatchError::Count { example: 0, what, rule, found: 0 }.into());
        }
        let queries = Cloud::new(&[queries], self.config().features, &self.device());
        let mut watch = Watch::on();
        let (tokens, logits) = self.decode(memory, &queries, &mut watch);
        finite(watch)?;
        let logits = read(logits)?;
        let part = logits.chunks_exact(logits.len() / count).map(first_largest).collect();
        Ok(Labels { part, logits, tokens, queries })
    }

    /// Votes on joints by labelled queries: row r is query `rows.query[r]`, case `rows.case[r]`.
    ///
    /// # Errors
    /// [`NetworkError`], for values that are not finite naming the head.
    pub fn votes(
        &self,
        memory: &Memory,
        labels: &Labels,
        rows: &JointRows,
    ) -> Result<Vec<Vote>, NetworkError> {
        let joints = self.joints(memory, labels.tokens.clone(), &labels.queries, rows);
        let numbers = read(joints)?;
        if numbers.iter().any(|v| !v.is_finite()) {
            return Err(NetworkError::NotFinite("the joint head".into()));
        }
        let three = |v: &[f32; JOINT_WIDTH], i: usize| [v[i], v[i + 1], v[i + 2]];
        let vote = |v: &[f32; JOINT_WIDTH]| Vote {
            direction: three(v, 0),
            closest: three(v, 3),
            lower: three(v, 6),
            upper: three(v, 9),
        };
        Ok(numbers.as_chunks().0.iter().map(vote).collect())
    }
}

fn finite(watch: Watch) -> Result<(), NetworkError> {
    watch.found().map_or(Ok(()), |layer| Err(NetworkError::NotFinite(layer)))
}

fn read<const D: usize>(x: Tensor<D>) -> Result<Vec<f32>, NetworkError> {
    x.into_data().try_into_vec().map_err(|e| NetworkError::Device(format!("{e:?}")))
}

fn first_largest(row: &[f32]) -> u16 {
    let better = |best: usize, p: usize| if row[p] > row[best] { p } else { best };
    (0..row.len()).fold(0, better) as u16
}
