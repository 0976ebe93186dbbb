//! Particulate, the predecessor: it sees all points at once and predicts tree and joint types itself.
//!
//! Layer names, shapes and quirks are those of its published checkpoint, so that one runs here.
//!
//! Letters: N points · P part slots · D width · F = 4 D.

mod arborescence;
mod decide;

use std::io::{Read, Seek};

use burn::module::Module;
use burn::tensor::{Device, Tensor, TensorData};

pub use arborescence::best_arborescence;
pub use decide::{Decision, PartMotion};

use super::embed::{Cloud, Embedder, Points, WAVE_WIDTH, waves};
use super::layers::{Attention, FeedForward, LayerNorm, Mlp};
use super::ops;
use super::source::{Builder, Inventory, Source};
use crate::weights::{Extra, FileSource, TensorFile, WeightsError};

/// Rows that pass through the wide layers together.
const CHUNK: usize = 8_192;
/// Part slots of the published checkpoint.
pub const PUBLISHED_PARTS: usize = 16;

/// Sizes of a Particulate checkpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParticulateSizes {
    /// D.
    pub width: usize,
    /// Attention heads.
    pub heads: usize,
    /// Blocks.
    pub layers: usize,
    /// Features of a point.
    pub features: usize,
    /// P; not to be seen from the weights.
    pub parts: usize,
}

impl ParticulateSizes {
    /// Reads the sizes off a checkpoint's shapes; `parts` it does not tell.
    ///
    /// # Errors
    /// [`WeightsError::Sizes`] if a shape that tells a size is missing or odd.
    pub fn of<R: Read + Seek>(file: &TensorFile<R>, parts: usize) -> Result<Self, WeightsError> {
        let shape = |name: &str, rank: usize| {
            let found = file.shape(name).filter(|s| s.len() == rank && s.iter().all(|&n| n > 0));
            found.ok_or_else(|| WeightsError::Sizes(format!("no tensor `{name}` of rank {rank}")))
        };
        let (width, features) =
            (shape("feat_proj.weight", 2)?[0], shape("feat_proj.weight", 2)?[1]);
        let head = shape("blocks.0.attn1.norm_q.weight", 1)?[0];
        let block = |i: &usize| file.shape(&format!("blocks.{i}.norm1.weight")).is_some();
        let layers = (0..).take_while(block).count();
        if width % head != 0 || width > 1 << 14 || !(1..=256).contains(&parts) {
            let found = format!("width {width}, heads of {head}, {parts} part slots");
            return Err(WeightsError::Sizes(found));
        }
        Ok(Self { width, heads: width / head, layers, features, parts })
    }
}

/// One block: parts among themselves, parts at points, points at parts, feed-forward of both.
#[derive(Module, Debug)]
struct Block {
    norm1: LayerNorm,
    norm2: LayerNorm,
    norm3: LayerNorm,
    final_norm_x: LayerNorm,
    final_norm_q: LayerNorm,
    attn1: Attention,
    attn2: Attention,
    attn3: Attention,
    mlp_x: FeedForward,
    mlp_q: FeedForward,
}

impl Block {
    fn new(mut b: Builder, [d, heads]: [usize; 2]) -> Self {
        Self {
            norm1: LayerNorm::new(b.at("norm1"), d),
            norm2: LayerNorm::new(b.at("norm2"), d),
            norm3: LayerNorm::new(b.at("norm3"), d),
            final_norm_x: LayerNorm::new(b.at("final_norm_x"), d),
            final_norm_q: LayerNorm::new(b.at("final_norm_q"), d),
            attn1: Attention::new(b.at("attn1"), d, heads),
            attn2: Attention::new(b.at("attn2"), d, heads),
            attn3: Attention::new(b.at("attn3"), d, heads),
            mlp_x: FeedForward::new(b.at("mlp_x"), d),
            mlp_q: FeedForward::new(b.at("mlp_q"), d),
        }
    }

    /// Points x [1, N, D] and parts q [1, P, D], both updated.
    fn forward(&self, x: Tensor<3>, q: Tensor<3>) -> (Tensor<3>, Tensor<3>) {
        // The residual of the self-attention is the normalised stream: a quirk the weights know.
        let q = self.norm1.forward(q);
        let q = q.clone() + self.attn1.forward(q.clone(), &self.attn1.context(q, &[]));
        let points = self.attn2.context(x.clone(), &[]);
        let q = q.clone() + self.attn2.forward(self.norm2.forward(q), &points);
        let parts = self.attn3.context(q.clone(), &[]);
        let x = in_chunks(x, |x| {
            let x = x.clone() + self.attn3.forward(self.norm3.forward(x), &parts);
            x.clone() + self.mlp_x.forward(self.final_norm_x.forward(x))
        });
        let q = q.clone() + self.mlp_q.forward(self.final_norm_q.forward(q));
        (x, q)
    }
}

/// Applies a row-wise map a few thousand rows at a time.
fn in_chunks(x: Tensor<3>, f: impl Fn(Tensor<3>) -> Tensor<3>) -> Tensor<3> {
    let n = x.dims()[1];
    if n <= CHUNK {
        return f(x);
    }
    let piece = |from: usize| f(x.clone().narrow(1, from, CHUNK.min(n - from)));
    Tensor::cat((0..n).step_by(CHUNK).map(piece).collect(), 1)
}

/// The Particulate transformer.
#[derive(Module, Debug)]
pub struct Particulate {
    embed: Embedder,
    part_id_embed: Mlp,
    blocks: Vec<Block>,
    point_mask_decoder: Mlp,
    part_hierarchy_decoder: Mlp,
    part_motion_classifier: Mlp,
    revolute_motion_decoder: Mlp,
    prismatic_motion_decoder: Mlp,
    point_motion_decoder: Mlp,
    #[module(skip)]
    sizes: ParticulateSizes,
}

/// What the network says before anything is decided.
#[derive(Clone, Debug)]
pub struct RawParticulate {
    /// Scores of parts [N, P], row-major.
    pub mask: Vec<f32>,
    /// Scores of parent and child [P, P], row-major.
    pub adjacency: Vec<f32>,
    /// Scores of none, revolute, prismatic, both [P, 4].
    pub motion: Vec<f32>,
    /// Revolute axis, low and high for each part [P, 5]; radians.
    pub revolute: Vec<f32>,
    /// Prismatic axis, low and high for each part [P, 5]; unit cube.
    pub prismatic: Vec<f32>,
    /// P.
    pub parts: usize,
    points: Tensor<3>,
    slots: Tensor<3>,
}

impl Particulate {
    /// Builds the network from a source of parameters.
    pub fn build(sizes: ParticulateSizes, source: &mut dyn Source, device: &Device) -> Self {
        let b = &mut Builder::new(source, device);
        let d = sizes.width;
        let size = [d, sizes.heads];
        Self {
            embed: Embedder::new(b, sizes.features, d),
            part_id_embed: Mlp::new(b.at("part_id_embed.mlp"), [WAVE_WIDTH, d, d]),
            blocks: (0..sizes.layers)
                .map(|i| Block::new(b.at(format!("blocks.{i}")), size))
                .collect(),
            point_mask_decoder: Mlp::new(b.at("point_mask_decoder"), [2 * d, 4 * d, 1]),
            part_hierarchy_decoder: Mlp::new(b.at("part_hierarchy_decoder"), [2 * d, 4 * d, 1]),
            part_motion_classifier: Mlp::new(b.at("part_motion_classifier"), [d, 4 * d, 4]),
            revolute_motion_decoder: Mlp::new(b.at("revolute_motion_decoder"), [d, 4 * d, 5]),
            prismatic_motion_decoder: Mlp::new(b.at("prismatic_motion_decoder"), [d, 4 * d, 5]),
            point_motion_decoder: Mlp::new(b.at("point_motion_decoder"), [2 * d, 4 * d, 3]),
            sizes,
        }
    }

    /// Reads a checkpoint in safetensors form with its original keys.
    ///
    /// # Errors
    /// [`WeightsError`]; for tensors that do not fit, with all of them.
    pub fn load<R: Read + Seek>(
        file: &mut TensorFile<R>,
        parts: usize,
        device: &Device,
    ) -> Result<Self, WeightsError> {
        let sizes = ParticulateSizes::of(file, parts)?;
        let mut inventory = Inventory::default();
        Self::build(sizes, &mut inventory, device);
        file.check(&inventory.parameters, Extra::Refused)?;
        let mut source = FileSource { file, failure: None };
        let network = Self::build(sizes, &mut source, device);
        source.failure.map_or(Ok(network), Err)
    }

    /// Its sizes.
    pub fn sizes(&self) -> ParticulateSizes {
        self.sizes
    }

    /// One pass over an object's points (unit cube, z up).
    ///
    /// # Errors
    /// [`WeightsError::NotFinite`] naming the head that gave NaN or infinity.
    pub fn forward(
        &self,
        points: &Points,
        device: &Device,
    ) -> Result<RawParticulate, WeightsError> {
        let p = self.sizes.parts;
        let cloud = Cloud::new(&[points], self.sizes.features, device);
        let ids = (0..p).flat_map(|i| waves(i as f32 / p as f32)).collect::<Vec<_>>();
        let ids = Tensor::<3>::from_data(TensorData::new(ids, [1, p, WAVE_WIDTH]), device);
        let mut x = self.embed.forward(&cloud);
        let mut q = self.part_id_embed.forward(ids);
        for block in &self.blocks {
            (x, q) = block.forward(x, q);
        }
        Ok(RawParticulate {
            mask: read("point_mask_decoder", pair_scores(&self.point_mask_decoder, &x, &q))?,
            adjacency: read(
                "part_hierarchy_decoder",
                pair_scores(&self.part_hierarchy_decoder, &q, &q),
            )?,
            motion: read("part_motion_classifier", self.part_motion_classifier.forward(q.clone()))?,
            revolute: read(
                "revolute_motion_decoder",
                self.revolute_motion_decoder.forward(q.clone()),
            )?,
            prismatic: read(
                "prismatic_motion_decoder",
                self.prismatic_motion_decoder.forward(q.clone()),
            )?,
            parts: p,
            points: x,
            slots: q,
        })
    }

    /// For each point, the nearest point of the turning axis of the part it was given to; unit cube.
    ///
    /// # Errors
    /// [`WeightsError::NotFinite`].
    pub fn axis_points(
        &self,
        raw: &RawParticulate,
        part_of_point: &[u16],
    ) -> Result<Vec<[f32; 3]>, WeightsError> {
        let head = &self.point_motion_decoder;
        let d = self.sizes.width;
        let slots = head.first().share(raw.slots.clone(), d);
        let slots: Tensor<2> = slots.reshape([self.sizes.parts, 4 * d]);
        let mut out = Vec::new();
        for (i, parts) in part_of_point.chunks(CHUNK).enumerate() {
            let x = raw.points.clone().narrow(1, i * CHUNK, parts.len());
            let query: Vec<u32> = (0..parts.len() as u32).collect();
            let case: Vec<u32> = parts.iter().map(|&p| p.into()).collect();
            let hidden = ops::pair_rows(head.first().share(x, 0), slots.clone(), &query, &case);
            out.extend(read("point_motion_decoder", head.second().forward(hidden))?);
        }
        Ok(out.as_chunks::<3>().0.to_vec())
    }
}

/// MLP([a; b]) → 1 for all pairs: a [1, N, D], b [1, P, D] → [1, N, P].
fn pair_scores(head: &Mlp, a: &Tensor<3>, b: &Tensor<3>) -> Tensor<3> {
    let d = a.dims()[2];
    let b = head.first().share(b.clone(), d);
    let scores = in_chunks(a.clone(), |a| {
        ops::pair_logits(head.first().share(a, 0), b.clone(), head.second().weight())
    });
    match head.second().bias() {
        Some(bias) => scores + bias.unsqueeze(),
        None => scores,
    }
}

fn read(head: &str, x: Tensor<3>) -> Result<Vec<f32>, WeightsError> {
    let values = x.into_data().try_into_vec::<f32>();
    let values = values.map_err(|e| WeightsError::Format(format!("{head}: {e:?}")))?;
    let sound = values.iter().all(|v| v.is_finite());
    sound.then_some(values).ok_or_else(|| WeightsError::NotFinite(head.into()))
}
