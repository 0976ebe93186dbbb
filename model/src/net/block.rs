//! The attention blocks: parts look at the shape and at each other, queries at the shape and at
//! the parts (paper, section 4.2). Queries never look at queries.
//!
//! Letters: B batch · Q queries · P parts · L shape tokens · D width.

use burn::module::Module;
use burn::tensor::Tensor;

use super::layers::{Attention, Context, FeedForward, LayerNorm};
use super::source::Builder;

/// x + Attn(norm x, context).
#[derive(Module, Debug)]
pub(crate) struct Look {
    norm: LayerNorm,
    attention: Attention,
}

impl Look {
    pub(crate) fn new(b: &mut Builder, name: &str, [width, heads]: [usize; 2]) -> Self {
        let norm = LayerNorm::new(b.at(format!("{name}.norm")), width);
        Self { norm, attention: Attention::new(b.at(name), width, heads) }
    }

    pub(crate) fn context(&self, x: Tensor<3>, lengths: &[usize]) -> Context {
        self.attention.context(x, lengths)
    }

    pub(crate) fn at(&self, x: Tensor<3>, context: &Context) -> Tensor<3> {
        x.clone() + self.attention.forward(self.norm.forward(x), context)
    }

    /// Self-attention: the context is the normalised x itself.
    fn around(&self, x: Tensor<3>, lengths: &[usize]) -> Tensor<3> {
        let y = self.norm.forward(x.clone());
        let context = self.attention.context(y.clone(), lengths);
        x + self.attention.forward(y, &context)
    }
}

/// x + GEGLU(norm x).
#[derive(Module, Debug)]
pub(crate) struct Think {
    norm: LayerNorm,
    feed_forward: FeedForward,
}

impl Think {
    pub(crate) fn new(b: &mut Builder, name: &str, width: usize) -> Self {
        let norm = LayerNorm::new(b.at(format!("{name}.norm")), width);
        Self { norm, feed_forward: FeedForward::new(b.at(name), width) }
    }

    pub(crate) fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        x.clone() + self.feed_forward.forward(self.norm.forward(x))
    }
}

/// One block of the part stream: cross-attention to the shape, self-attention, feed-forward.
#[derive(Module, Debug)]
pub(crate) struct PartBlock {
    shape: Look,
    parts: Look,
    think: Think,
}

impl PartBlock {
    pub(crate) fn new(mut b: Builder, size: [usize; 2]) -> Self {
        Self {
            shape: Look::new(&mut b, "shape", size),
            parts: Look::new(&mut b, "parts", size),
            think: Think::new(&mut b, "mlp", size[0]),
        }
    }

    /// Part tokens [B, P, D] and shape tokens [B, L, D] → [B, P, D]; `counts` parts are real.
    pub(crate) fn forward(
        &self,
        parts: Tensor<3>,
        shape: Tensor<3>,
        counts: &[usize],
    ) -> Tensor<3> {
        let parts = self.shape.at(parts, &self.shape.context(shape, &[]));
        self.think.forward(self.parts.around(parts, counts))
    }
}

/// What a query block looks at, its keys and values computed once.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    shape: Context,
    parts: Context,
}

/// One block of the query stream: cross-attention to the shape, to the updated parts, feed-forward.
#[derive(Module, Debug)]
pub(crate) struct QueryBlock {
    shape: Look,
    parts: Look,
    think: Think,
}

impl QueryBlock {
    pub(crate) fn new(mut b: Builder, size: [usize; 2]) -> Self {
        Self {
            shape: Look::new(&mut b, "shape", size),
            parts: Look::new(&mut b, "parts", size),
            think: Think::new(&mut b, "mlp", size[0]),
        }
    }

    pub(crate) fn scene(&self, shape: Tensor<3>, parts: Tensor<3>, counts: &[usize]) -> Scene {
        Scene { shape: self.shape.context(shape, &[]), parts: self.parts.context(parts, counts) }
    }

    /// Query tokens [B, Q, D] → [B, Q, D].
    pub(crate) fn forward(&self, queries: Tensor<3>, scene: &Scene) -> Tensor<3> {
        let queries = self.shape.at(queries, &scene.shape);
        self.think.forward(self.parts.at(queries, &scene.parts))
    }
}
