//! What a kernel's forward and backward passes read and give.

/// A row-major tensor that a kernel reads.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View<'a> {
    pub(crate) data: &'a [f32],
    pub(crate) shape: &'a [usize],
}

impl View<'_> {
    /// Size of the last dimension; 0 for the empty tensor that stands for "none".
    pub(crate) fn width(&self) -> usize {
        self.shape.last().copied().unwrap_or(0)
    }

    /// How many rows of that width there are.
    pub(crate) fn rows(&self) -> usize {
        self.data.len().checked_div(self.width()).unwrap_or(0)
    }
}

/// What a forward pass gives: the result, and what its backward pass wants to find again.
#[derive(Clone, Debug, Default)]
pub(crate) struct Forward {
    pub(crate) data: Vec<f32>,
    pub(crate) shape: Vec<usize>,
    pub(crate) kept: Vec<f32>,
}

/// What a backward pass finds of the forward pass: its result and what it kept.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Saved<'a> {
    pub(crate) out: &'a [f32],
    pub(crate) kept: &'a [f32],
}

/// Gradients of the three inputs; empty where there is none.
pub(crate) type Gradients = [Vec<f32>; 3];
