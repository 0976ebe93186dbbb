//! The Instruct-Particulate network (paper, section 4): shape, parts and queries in; part logits and
//! joint votes out.
//!
//! Letters: B batch · N points · L shape tokens · P parts · Q queries · T text width · D width.

use burn::module::{Module, Param};
use burn::tensor::{Device, Tensor, TensorData};

use super::block::{Look, PartBlock, QueryBlock, Scene, Think};
use super::config::{Config, ConfigError, Positions};
use super::embed::{Cloud, Embedder};
use super::heads::{JOINT_WIDTH, JointHead, JointRows, PartHead};
use super::layers::Mlp;
use super::ops;
use super::precision::Precision;
use super::source::{Builder, Inventory, Random, Source, Start};
use super::watch::Watch;

/// What the parts are told by: texts, points or both.
#[derive(Clone, Debug)]
pub struct Prompts {
    /// Embedded texts [B, P, T]; rows of parts without a text are not looked at.
    pub texts: Tensor<3>,
    /// 1 where there is a text, else 0 [B, P, 1].
    pub has_text: Tensor<3>,
    /// A point of each part; rows of parts without one are not looked at.
    pub points: Cloud,
    /// 1 where there is a point, else 0 [B, P, 1].
    pub has_point: Tensor<3>,
    /// How many of the P parts each batch element really has.
    pub counts: Vec<usize>,
}

/// Everything a training step feeds the network.
#[derive(Clone, Debug)]
pub struct Batch {
    /// Points the shapes are seen through.
    pub shape: Cloud,
    /// The parts.
    pub parts: Prompts,
    /// Points that are asked about.
    pub queries: Cloud,
    /// Joints that are asked about, and where.
    pub joints: JointRows,
}

/// What the network answers.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Scores of parts [B, Q, P]; parts beyond an element's count have −1e9.
    pub logits: Tensor<3>,
    /// One row per row of [`JointRows`]: axis direction (not unit), axis point, position at the
    /// lower limit, position at the upper limit [R, 12]; unit cube.
    pub joints: Tensor<2>,
}

/// The articulation transformer.
#[derive(Module, Debug)]
pub struct Network {
    embed: Embedder,
    text: Mlp,
    latents: Param<Tensor<2>>, // Z⁰ [L, D]
    gather: Look,
    digest: Think,
    part_blocks: Vec<PartBlock>,
    query_blocks: Vec<QueryBlock>,
    part_head: PartHead,
    joint_head: JointHead,
    #[module(skip)]
    config: Config,
    #[module(skip)]
    precision: Precision,
}

/// Shape and parts, digested: all that decoding queries needs, whatever their number.
#[derive(Clone, Debug)]
pub struct Memory {
    scenes: Vec<Scene>,        // one per block
    parts: Tensor<3>,          // l^B [B, P, D]
    part_share: Tensor<3>,     // [B, P, 4 D]
    beyond: Option<Tensor<3>>, // [B, 1, P]: −1e9 for parts that are not there
}

impl Network {
    /// A network with random parameters.
    ///
    /// # Errors
    /// [`ConfigError`] when the sizes do not fit together.
    pub fn new(config: &Config, seed: u64, device: &Device) -> Result<Self, ConfigError> {
        Self::build(config, &mut Random { seed }, device, Precision::Full)
    }

    /// A network whose parameters a source gives, and that answers in this precision; it is trained
    /// in full precision, whatever is said here.
    ///
    /// # Errors
    /// [`ConfigError`] when the sizes do not fit together.
    pub fn build(
        config: &Config,
        source: &mut dyn Source,
        device: &Device,
        precision: Precision,
    ) -> Result<Self, ConfigError> {
        config.check()?;
        let b = &mut Builder::new(source, device).at_precision(precision);
        let (d, size) = (config.width, [config.width, config.heads]);
        Ok(Self {
            embed: Embedder::new(b, config.features, d),
            text: Mlp::new(b.at("text_embed"), [config.text, d, d]),
            latents: b.parameter("latents", [config.tokens, d], Start::Normal(0.02)),
            gather: Look::new(b, "gather", size),
            digest: Think::new(b, "digest", d),
            part_blocks: (0..config.blocks)
                .map(|i| PartBlock::new(b.at(format!("blocks.{i}.part")), size))
                .collect(),
            query_blocks: (0..config.blocks)
                .map(|i| QueryBlock::new(b.at(format!("blocks.{i}.query")), size))
                .collect(),
            part_head: PartHead::new(b.at("part_head"), d),
            joint_head: JointHead::new(b.at("joint_head"), d),
            config: config.clone(),
            precision,
        })
    }

    /// Name and shape of every parameter of such a network, in order.
    ///
    /// # Errors
    /// [`ConfigError`] when the sizes do not fit together.
    pub fn parameters(config: &Config) -> Result<Vec<(String, Vec<usize>)>, ConfigError> {
        let mut inventory = Inventory::default();
        Self::build(config, &mut inventory, &Device::flex(), Precision::Full)?;
        Ok(inventory.parameters)
    }

    /// The sizes it was built with.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// How precisely it answers.
    pub fn precision(&self) -> Precision {
        self.precision
    }

    /// One pass over a batch; with gradients where the device records them.
    pub fn forward(&self, batch: &Batch) -> Answer {
        let watch = &mut Watch::off();
        let memory = self.remember(&batch.shape, &batch.parts, watch);
        let (tokens, logits) = self.decode(&memory, &batch.queries, watch);
        let joints = self.joints(&memory, tokens, &batch.queries, &batch.joints);
        Answer { logits, joints }
    }

    /// Shape tokens Zˢ [B, L, D] of point clouds.
    fn shape_tokens(&self, shape: &Cloud) -> Tensor<3> {
        let points = self.embed.forward(shape);
        let batch = points.dims()[0];
        let latents = self.latents.val().unsqueeze::<3>().repeat_dim(0, batch);
        self.digest.forward(self.gather.at(latents, &self.gather.context(points, &[])))
    }

    /// Part tokens l⁰ [B, P, D].
    fn part_tokens(&self, parts: &Prompts) -> Tensor<3> {
        let text = self.text.forward(parts.texts.clone()) * parts.has_text.clone();
        text + self.embed.forward(&parts.points) * parts.has_point.clone()
    }

    /// Digests shapes and parts.
    pub(crate) fn remember(&self, shape: &Cloud, prompts: &Prompts, watch: &mut Watch) -> Memory {
        let shape = watch.see("the shape tokens", self.shape_tokens(shape));
        let mut parts = watch.see("the part embedding", self.part_tokens(prompts));
        let mut scenes = Vec::with_capacity(self.part_blocks.len());
        for (i, (part, query)) in self.part_blocks.iter().zip(&self.query_blocks).enumerate() {
            parts = part.forward(parts, shape.clone(), &prompts.counts);
            parts = watch.see_block("part", i, parts);
            scenes.push(query.scene(shape.clone(), parts.clone(), &prompts.counts));
        }
        let part_share = self.part_head.parts(parts.clone());
        let [batch, all, _] = parts.dims();
        let padded = prompts.counts.iter().any(|&c| c < all);
        let beyond = padded.then(|| ops::beyond(&prompts.counts, all, &parts.device()));
        let beyond = beyond.map(|b| b.reshape([batch, 1, all]));
        Memory { scenes, parts, part_share, beyond }
    }

    /// Query tokens q^B [B, Q, D] and logits [B, Q, P].
    pub(crate) fn decode(
        &self,
        memory: &Memory,
        queries: &Cloud,
        watch: &mut Watch,
    ) -> (Tensor<3>, Tensor<3>) {
        let mut tokens = watch.see("the query embedding", self.embed.forward(queries));
        for (i, (block, scene)) in self.query_blocks.iter().zip(&memory.scenes).enumerate() {
            tokens = watch.see_block("query", i, block.forward(tokens, scene));
        }
        let logits = self.part_head.logits(tokens.clone(), memory.part_share.clone());
        let logits = watch.see("the part head", logits);
        let logits = match &memory.beyond {
            Some(beyond) => logits + beyond.clone(),
            None => logits,
        };
        (tokens, logits)
    }

    /// Joint votes [R, 12] of decoded queries.
    pub(crate) fn joints(
        &self,
        memory: &Memory,
        tokens: Tensor<3>,
        queries: &Cloud,
        rows: &JointRows,
    ) -> Tensor<2> {
        if rows.query.is_empty() {
            return JointHead::none(&tokens.device());
        }
        let cases = self.joint_head.cases(memory.parts.clone(), &rows.cases);
        let votes = self.joint_head.rows(tokens, cases, rows);
        match self.config.positions {
            Positions::Absolute => votes,
            Positions::Offset => votes + offsets(&queries.positions, rows),
        }
    }
}

/// For each row 0, 0, 0 and three times its query's position [R, 12].
fn offsets(positions: &Tensor<3>, rows: &JointRows) -> Tensor<2> {
    let [b, n, _] = positions.dims();
    let device = positions.device();
    let flat: Tensor<2> = positions.clone().reshape([b * n, 3]);
    let at = flat.select(0, ops::indices(&rows.query, &device)).repeat_dim(1, JOINT_WIDTH / 3);
    let mut mask = vec![1.0f32; JOINT_WIDTH];
    mask[..3].fill(0.0);
    at * Tensor::<2>::from_data(TensorData::new(mask, [1, JOINT_WIDTH]), &device)
}
