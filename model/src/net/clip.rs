//! CLIP's text tower (Radford et al. 2021, section 2.4): the tokens of a text to one vector.
//!
//! Layer names, shapes and quirks are those of the checkpoints on Hugging Face, so that one runs
//! here; what they hold of the image tower is passed over.
//!
//! Letters: N tokens · T positions · V vocabulary · D width · F hidden width · O width out.

use std::io::{Read, Seek};

use burn::module::Param;
use burn::tensor::{Device, Tensor, TensorData, activation};

use super::config::{self, ConfigError};
use super::error::NetworkError;
use super::layers::Linear;
use super::ops;
use super::source::{Builder, Inventory, Source, Start};
use super::watch::Watch;
use crate::weights::{Extra, FileSource, TensorFile, WeightsError};

/// Sizes of a text tower.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipSizes {
    /// D, width of the tokens; a multiple of `heads`.
    pub width: usize,
    /// Attention heads; not to be seen from the weights.
    pub heads: usize,
    /// Layers.
    pub layers: usize,
    /// F, hidden width of the feed-forward.
    pub hidden: usize,
    /// T, most tokens of a text, its start and end included.
    pub positions: usize,
    /// V, tokens there are.
    pub vocabulary: usize,
    /// O, numbers of a text.
    pub out: usize,
    /// Between the two linear maps of the feed-forward; not to be seen from the weights.
    pub activation: Activation,
    /// Added to the variance in LayerNorm; not to be seen from the weights.
    pub eps: f32,
}

/// What a feed-forward bends its numbers with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activation {
    /// x · sigmoid(1.702 x), OpenAI's own.
    QuickGelu,
    /// The exact (erf) GELU, of later checkpoints.
    Gelu,
}

impl ClipSizes {
    /// The tower of ViT-B/32: 63 million parameters, 512 numbers of a text.
    pub fn base() -> Self {
        Self {
            width: 512,
            heads: 8,
            layers: 12,
            hidden: 2_048,
            positions: 77,
            vocabulary: 49_408,
            out: 512,
            activation: Activation::QuickGelu,
            eps: 1e-5,
        }
    }

    /// The tower of ViT-L/14, the paper's choice: 124 million parameters, 768 numbers of a text.
    pub fn large() -> Self {
        Self { width: 768, heads: 12, hidden: 3_072, out: 768, ..Self::base() }
    }

    /// Proves that the sizes make a tower, and one that fits a memory. Sizes are told by the names
    /// they have in a checkpoint's `config.json`.
    ///
    /// # Errors
    /// [`ConfigError`], the first size that breaks its rule.
    pub fn check(&self) -> Result<(), ConfigError> {
        let limits = [
            ("hidden_size", self.width, 4_096),
            ("num_attention_heads", self.heads, 256),
            ("num_hidden_layers", self.layers, 64),
            ("intermediate_size", self.hidden, 1 << 15),
            ("max_position_embeddings", self.positions, 1 << 12),
            ("vocab_size", self.vocabulary, 1 << 20),
            ("projection_dim", self.out, 1 << 14),
        ];
        config::within(&limits)?;
        if !self.width.is_multiple_of(self.heads) {
            let rule = format!("a multiple of `num_attention_heads` ({})", self.heads);
            return Err(ConfigError { name: "hidden_size", rule, found: self.width });
        }
        Ok(())
    }
}

/// LayerNorm with gain and bias.
#[derive(Debug)]
struct Norm {
    weight: Param<Tensor<1>>, // [D]
    bias: Param<Tensor<1>>,   // [D]
    eps: f32,
}

impl Norm {
    fn new(mut b: Builder, sizes: &ClipSizes) -> Self {
        let weight = b.parameter("weight", [sizes.width], Start::Constant(1.0));
        let bias = b.parameter("bias", [sizes.width], Start::Constant(0.0));
        Self { weight, bias, eps: sizes.eps }
    }

    fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        ops::layer_norm(x, self.weight.val(), self.bias.val(), self.eps)
    }
}

/// A pre-norm layer: causal self-attention, feed-forward.
#[derive(Debug)]
struct Layer {
    norms: [Norm; 2],
    qkv: [Linear; 3],
    out: Linear,
    inner: Linear,
    outer: Linear,
    heads: usize,
    activation: Activation,
}

impl Layer {
    fn new(mut b: Builder, sizes: &ClipSizes) -> Self {
        let (d, f) = (sizes.width, sizes.hidden);
        let projections = ["q_proj", "k_proj", "v_proj"];
        Self {
            norms: ["layer_norm1", "layer_norm2"].map(|name| Norm::new(b.at(name), sizes)),
            qkv: projections.map(|name| Linear::new(b.at("self_attn").at(name), d, d)),
            out: Linear::new(b.at("self_attn.out_proj"), d, d),
            inner: Linear::new(b.at("mlp.fc1"), d, f),
            outer: Linear::new(b.at("mlp.fc2"), f, d),
            heads: sizes.heads,
            activation: sizes.activation,
        }
    }

    /// x [1, N, D] → [1, N, D].
    fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        let y = self.norms[0].forward(x.clone());
        let qkv = [0, 1, 2].map(|i| self.qkv[i].forward(y.clone()));
        let x = x + self.out.forward(ops::causal_attention(qkv, self.heads));
        let y = self.inner.forward(self.norms[1].forward(x.clone()));
        let y = match self.activation {
            Activation::QuickGelu => activation::sigmoid(y.clone() * 1.702) * y,
            Activation::Gelu => activation::gelu(y),
        };
        x + self.outer.forward(y)
    }
}

/// The text tower with its projection.
#[derive(Debug)]
pub struct ClipTower {
    tokens: Param<Tensor<2>>, // [V, D]
    places: Param<Tensor<2>>, // [T, D]
    layers: Vec<Layer>,
    norm: Norm,
    projection: Linear, // [O, D]
    sizes: ClipSizes,
}

impl ClipTower {
    /// Builds the tower from a source of parameters.
    ///
    /// # Errors
    /// [`ConfigError`] for sizes that make none.
    pub fn build(
        sizes: ClipSizes,
        source: &mut dyn Source,
        device: &Device,
    ) -> Result<Self, ConfigError> {
        sizes.check()?;
        let mut all = Builder::new(source, device);
        let (v, t, d) = (sizes.vocabulary, sizes.positions, sizes.width);
        let mut b = all.at("text_model");
        let mut table = |name: &str, rows: usize| {
            b.at("embeddings").at(name).parameter("weight", [rows, d], Start::Normal(0.02))
        };
        let (tokens, places) = (table("token_embedding", v), table("position_embedding", t));
        let mut layer = |i: usize| Layer::new(b.at("encoder.layers").at(i), &sizes);
        let layers = (0..sizes.layers).map(&mut layer).collect();
        let norm = Norm::new(b.at("final_layer_norm"), &sizes);
        let projection = Linear::unbiased(all.at("text_projection"), d, sizes.out);
        Ok(Self { tokens, places, layers, norm, projection, sizes })
    }

    /// Proves that a checkpoint holds every parameter in its shape.
    ///
    /// # Errors
    /// [`WeightsError`]; for tensors that are missing or do not fit, with all of them.
    pub fn check<R: Read + Seek>(
        sizes: ClipSizes,
        file: &TensorFile<R>,
    ) -> Result<(), WeightsError> {
        let mut inventory = Inventory::default();
        Self::build(sizes, &mut inventory, &Device::flex()).map_err(sizes_error)?;
        file.check(&inventory.parameters, Extra::Ignored)
    }

    /// Reads a checkpoint in safetensors form with its original keys. `watch` is shown the name,
    /// shape and values of every parameter.
    ///
    /// # Errors
    /// [`WeightsError`]; for tensors that are missing or do not fit, with all of them.
    pub fn load<R: Read + Seek>(
        sizes: ClipSizes,
        file: &mut TensorFile<R>,
        watch: &mut Onlooker<'_>,
    ) -> Result<Self, WeightsError> {
        Self::check(sizes, file)?;
        let mut source = Watched { source: FileSource { file, failure: None }, watch };
        let tower = Self::build(sizes, &mut source, &Device::flex()).map_err(sizes_error)?;
        source.source.failure.map_or(Ok(tower), Err)
    }

    /// Its sizes.
    pub fn sizes(&self) -> &ClipSizes {
        &self.sizes
    }

    /// The vector of a text, `[O]`: what its last token, the end of the text, has seen of all, then
    /// projected; not of unit length. Tokens after the end would not be seen, so none are given.
    ///
    /// # Errors
    /// [`NetworkError::NotFinite`], naming the layer; [`NetworkError::Tokens`] for no tokens, more
    /// than there are positions, or one that is not of the vocabulary.
    pub fn forward(&self, ids: &[u32]) -> Result<Vec<f32>, NetworkError> {
        let (n, ClipSizes { width, positions, vocabulary, .. }) = (ids.len(), self.sizes);
        let known = ids.iter().all(|&id| (id as usize) < vocabulary);
        if n == 0 || n > positions || !known {
            return Err(NetworkError::Tokens { positions, vocabulary, found: ids.to_vec() });
        }
        let mut watch = Watch::on();
        let tokens = self.tokens.val().select(0, ops::indices(ids, &Device::flex()));
        let places = self.places.val().slice([0..n, 0..width]);
        let mut x: Tensor<3> = watch.see("the embedding", tokens + places).unsqueeze(); // [1, N, D]
        for (i, layer) in self.layers.iter().enumerate() {
            x = watch.see_block("text", i, layer.forward(x));
        }
        let last = self.norm.forward(x.narrow(1, n - 1, 1)); // [1, 1, D]
        let last = watch.see("the final norm", last);
        let text = watch.see("the text projection", self.projection.forward(last));
        match watch.found() {
            Some(layer) => Err(NetworkError::NotFinite(layer)),
            None => read(text),
        }
    }
}

fn read(x: Tensor<3>) -> Result<Vec<f32>, NetworkError> {
    let data: TensorData = x.into_data();
    data.try_into_vec().map_err(|e| NetworkError::Device(format!("{e:?}")))
}

fn sizes_error(what: ConfigError) -> WeightsError {
    WeightsError::Sizes(what.to_string())
}

/// Is shown the name, shape and values of a parameter.
pub type Onlooker<'a> = dyn FnMut(&str, &[usize], &[f32]) + 'a;

/// A file whose parameters are shown to somebody on their way.
struct Watched<'a, R> {
    source: FileSource<'a, R>,
    watch: &'a mut Onlooker<'a>,
}

impl<R: Read + Seek> Source for Watched<'_, R> {
    fn values(&mut self, name: &str, shape: &[usize], start: Start) -> Vec<f32> {
        let values = self.source.values(name, shape, start);
        (self.watch)(name, shape, &values);
        values
    }
}
