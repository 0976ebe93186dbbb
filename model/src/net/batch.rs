//! Examples as plain numbers, and their stacking into the tensors of a batch.

use burn::tensor::{Device, Tensor, TensorData};

use super::config::Config;
use super::embed::{Cloud, Points};
use super::error::BatchError;
use super::heads::{JointCase, JointRows, MotionType};
use super::network::{Batch, Prompts};

/// One object and the questions about it. Everything lies in the unit cube.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Example {
    /// The points the shape is seen through: exactly [`Config::points`] of them.
    pub shape: Points,
    /// The parts, in order.
    pub parts: Vec<PartPrompt>,
    /// The points that are asked about: equally many in every example of a batch.
    pub queries: Points,
    /// The joints that are asked about.
    pub joints: Vec<JointQuestion>,
}

/// What one part is told by.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PartPrompt {
    /// Its embedded text, [`Config::text`] numbers.
    pub text: Option<Vec<f32>>,
    /// A point on it: [`Points`] of one point.
    pub point: Option<Points>,
}

/// A joint with one motion type, asked about at some query points.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JointQuestion {
    /// Index of the parent part.
    pub parent: usize,
    /// Index of the child part.
    pub child: usize,
    /// How it moves.
    pub motion: MotionType,
    /// Indices of the query points.
    pub queries: Vec<u32>,
}

/// Counts of one example, checked against the configuration.
struct Check<'a> {
    config: &'a Config,
    example: usize,
}

impl Check<'_> {
    fn count(&self, what: &'static str, found: usize, expected: usize) -> Result<(), BatchError> {
        if found == expected {
            return Ok(());
        }
        Err(BatchError::Count { example: self.example, what, rule: expected.to_string(), found })
    }

    fn most(&self, what: &'static str, found: usize, most: usize) -> Result<(), BatchError> {
        if (1..=most).contains(&found) {
            return Ok(());
        }
        let rule = format!("between 1 and {most}");
        Err(BatchError::Count { example: self.example, what, rule, found })
    }

    fn points(&self, points: &Points, count: usize) -> Result<(), BatchError> {
        let normals = points.normals.as_ref().map_or(count, Vec::len);
        self.count("normals", normals, count)?;
        self.count("point features", points.features.len(), count * self.config.features)
    }

    fn example(&self, e: &Example, queries: usize) -> Result<(), BatchError> {
        self.count("shape points", e.shape.positions.len(), self.config.points)?;
        self.points(&e.shape, self.config.points)?;
        self.most("parts", e.parts.len(), self.config.max_parts)?;
        self.count("query points", e.queries.positions.len(), queries)?;
        self.points(&e.queries, queries)?;
        for part in &e.parts {
            let text = part.text.as_ref().map_or(self.config.text, Vec::len);
            self.count("numbers of a text", text, self.config.text)?;
            if let Some(point) = &part.point {
                self.count("points of a part", point.positions.len(), 1)?;
                self.points(point, 1)?;
            }
        }
        e.joints.iter().try_for_each(|j| self.joint(j, e))
    }

    fn joint(&self, joint: &JointQuestion, e: &Example) -> Result<(), BatchError> {
        let parts = e.parts.len();
        self.most("part of a joint, counted from 1,", joint.parent.max(joint.child) + 1, parts)?;
        let last = joint.queries.iter().max().map_or(1, |&q| q as usize + 1);
        self.most("query of a joint, counted from 1,", last, e.queries.positions.len())
    }
}

impl Batch {
    /// Stacks examples.
    ///
    /// # Errors
    /// [`BatchError`], the first count that does not fit, with the limit.
    pub fn new(examples: &[Example], config: &Config, device: &Device) -> Result<Self, BatchError> {
        let first = examples.first().ok_or(BatchError::Empty)?;
        let queries = first.queries.positions.len();
        for (example, e) in examples.iter().enumerate() {
            Check { config, example }.example(e, queries)?;
        }
        let cloud = |of: &dyn Fn(&Example) -> Points| {
            let points: Vec<_> = examples.iter().map(of).collect();
            Cloud::new(&points.iter().collect::<Vec<_>>(), config.features, device)
        };
        let parts: Vec<_> = examples.iter().map(|e| e.parts.as_slice()).collect();
        Ok(Self {
            shape: cloud(&|e| e.shape.clone()),
            parts: Prompts::new(&parts, config, device),
            queries: cloud(&|e| e.queries.clone()),
            joints: joint_rows(examples),
        })
    }
}

impl Prompts {
    /// Stacks the parts of objects, padded to the most of them.
    pub(crate) fn new(objects: &[&[PartPrompt]], config: &Config, device: &Device) -> Self {
        let most = objects.iter().map(|o| o.len()).max().unwrap_or(0);
        let missing = PartPrompt::default();
        let padded = |o: &'_ &[PartPrompt], p: usize| o.get(p).unwrap_or(&missing).clone();
        let all: Vec<_> = objects.iter().flat_map(|o| (0..most).map(|p| padded(o, p))).collect();
        let stack = |values: Vec<f32>, width: usize| -> Tensor<3> {
            Tensor::from_data(TensorData::new(values, [objects.len(), most, width]), device)
        };
        let texts =
            all.iter().flat_map(|p| p.text.clone().unwrap_or_else(|| vec![0.0; config.text]));
        let known = |is: &dyn Fn(&PartPrompt) -> bool| {
            stack(all.iter().map(|p| f32::from(u8::from(is(p)))).collect(), 1)
        };
        Self {
            texts: stack(texts.collect(), config.text),
            has_text: known(&|p| p.text.is_some()),
            points: prompt_cloud(&all, [objects.len(), most], config.features, device),
            has_point: known(&|p| p.point.is_some()),
            counts: objects.iter().map(|o| o.len()).collect(),
        }
    }
}

/// The points of all parts as one cloud; parts without a point stand at the origin.
fn prompt_cloud(all: &[PartPrompt], size: [usize; 2], features: usize, device: &Device) -> Cloud {
    let [batch, most] = size;
    let nowhere =
        Points { positions: vec![[0.0; 3]], normals: None, features: vec![0.0; features] };
    let points: Vec<_> = all.iter().map(|p| p.point.as_ref().unwrap_or(&nowhere)).collect();
    let single = Cloud::new(&points, features, device);
    let stack = |x: Tensor<3>| {
        let width = x.dims()[2];
        x.reshape([batch, most, width])
    };
    Cloud {
        positions: stack(single.positions),
        position_codes: stack(single.position_codes),
        normal_codes: stack(single.normal_codes),
        has_normal: stack(single.has_normal),
        features: stack(single.features),
    }
}

/// Counts parts and queries through the whole batch.
fn joint_rows(examples: &[Example]) -> JointRows {
    let most = examples.iter().map(|e| e.parts.len()).max().unwrap_or(0);
    let mut rows = JointRows::default();
    for (b, e) in examples.iter().enumerate() {
        let part = |p: usize| (b * most + p) as u32;
        let first = (b * e.queries.positions.len()) as u32;
        for joint in &e.joints {
            let case = rows.cases.len() as u32;
            let (parent, child) = (part(joint.parent), part(joint.child));
            rows.cases.push(JointCase { parent, child, motion: joint.motion });
            rows.query.extend(joint.queries.iter().map(|q| first + q));
            rows.case.extend(std::iter::repeat_n(case, joint.queries.len()));
        }
    }
    rows
}
