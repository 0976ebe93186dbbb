//! Finds the first layer whose result is not finite.

use burn::tensor::Tensor;

/// Looks at results on their way; off in training, where a look would stall a GPU.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    on: bool,
    found: Option<String>,
}

impl Watch {
    /// Looks at nothing.
    pub(crate) fn off() -> Self {
        Self { on: false, found: None }
    }

    /// Looks at everything.
    pub(crate) fn on() -> Self {
        Self { on: true, found: None }
    }

    /// The first layer that gave NaN or infinity.
    pub(crate) fn found(self) -> Option<String> {
        self.found
    }

    /// Passes a result through.
    pub(crate) fn see<const D: usize>(&mut self, layer: &str, x: Tensor<D>) -> Tensor<D> {
        if self.on && self.found.is_none() && !is_finite(&x) {
            self.found = Some(layer.into());
        }
        x
    }

    /// Passes a block's result through.
    pub(crate) fn see_block(&mut self, stream: &str, block: usize, x: Tensor<3>) -> Tensor<3> {
        if self.on { self.see(&format!("{stream} block {block}"), x) } else { x }
    }
}

/// A sum is finite only if every term is; the converse is all that overflow could spoil, so a
/// suspicious sum is looked at term by term.
fn is_finite<const D: usize>(x: &Tensor<D>) -> bool {
    let sum: f32 = x.clone().sum().into_scalar();
    sum.is_finite() || x.clone().is_finite().all().into_scalar()
}
