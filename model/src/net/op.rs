//! The kernels as one burn operation, for the CPU backend and for automatic differentiation.
//!
//! Other backends never get here: [`super::ops`] gives them burn's own operations.

use burn::backend::autodiff::checkpoint::base::Checkpointer;
use burn::backend::autodiff::checkpoint::strategy::CheckpointStrategy;
use burn::backend::autodiff::grads::Gradients;
use burn::backend::autodiff::ops::{Backward, Ops, OpsKind};
use burn::backend::tensor::FloatTensor;
use burn::backend::{Autodiff, Backend, Dispatch, Flex, backend_extension};
use burn::tensor::{Tensor, TensorData};

use super::kernel::{Forward, Kernel, Saved, View};

type Primitive = FloatTensor<Flex>;

/// Backends that run our kernels.
#[backend_extension(Flex, Autodiff)]
pub(crate) trait RunKernel: Backend {
    /// Applies the kernel; tensors it does not use are empty.
    fn run_kernel(
        a: FloatTensor<Self>,
        b: FloatTensor<Self>,
        c: FloatTensor<Self>,
        kernel: Kernel,
    ) -> FloatTensor<Self>;
}

/// Applies a kernel to tensors on the CPU, recording it where gradients are wanted.
pub(crate) fn run<const A: usize, const B: usize, const C: usize, const R: usize>(
    kernel: Kernel,
    a: Tensor<A>,
    b: Tensor<B>,
    c: Tensor<C>,
) -> Tensor<R> {
    let (a, b, c) = (a.into_dispatch(), b.into_dispatch(), c.into_dispatch());
    Tensor::from_dispatch(<Dispatch as RunKernel>::run_kernel(a, b, c, kernel))
}

/// Calls `f` with views of the three tensors' data.
fn with_views<R>(x: &[Primitive; 3], f: impl FnOnce([View; 3]) -> R) -> R {
    let whole = x.each_ref().map(|t| t.to_contiguous());
    f(whole.each_ref().map(|t| {
        let shape = t.layout().shape().as_slice();
        View { data: t.storage::<f32>(), shape }
    }))
}

fn tensor(data: Vec<f32>, shape: &[usize]) -> Primitive {
    Primitive::from_data(TensorData::new(data, shape.to_vec()))
}

impl RunKernel for Flex {
    fn run_kernel(a: Primitive, b: Primitive, c: Primitive, kernel: Kernel) -> Primitive {
        let Forward { data, shape, .. } = with_views(&[a, b, c], |x| kernel.forward(x));
        tensor(data, &shape)
    }
}

impl<S: CheckpointStrategy> RunKernel for Autodiff<Flex, S> {
    fn run_kernel(
        a: FloatTensor<Self>,
        b: FloatTensor<Self>,
        c: FloatTensor<Self>,
        kernel: Kernel,
    ) -> FloatTensor<Self> {
        let nodes = [a.node(), b.node(), c.node()];
        let x = [a, b, c].map(|t| t.primitive().clone());
        let forward = with_views(&x, |x| kernel.forward(x));
        let out = tensor(forward.data, &forward.shape);
        match Step.prepare::<S>(nodes).compute_bound().stateful() {
            OpsKind::Tracked(prepared) => {
                let state = State { x, kernel, out: out.clone(), kept: forward.kept };
                prepared.finish(state, out)
            }
            OpsKind::UnTracked(prepared) => prepared.finish(out),
        }
    }
}

/// A recorded kernel.
#[derive(Debug)]
struct Step;

/// What its backward pass needs.
#[derive(Clone, Debug)]
struct State {
    x: [Primitive; 3],
    kernel: Kernel,
    out: Primitive,
    kept: Vec<f32>,
}

impl Backward<Flex, 3> for Step {
    type State = State;

    fn backward(self, ops: Ops<State, 3>, grads: &mut Gradients, _: &mut Checkpointer) {
        let grad = grads.consume::<Flex>(&ops.node).to_contiguous();
        let State { x, kernel, out, kept } = ops.state;
        let wanted = ops.parents.each_ref().map(Option::is_some);
        let saved = Saved { out: out.storage::<f32>(), kept: &kept };
        let found = with_views(&x, |x| kernel.backward(x, saved, grad.storage::<f32>(), wanted));
        for ((node, found), x) in ops.parents.into_iter().zip(found).zip(&x) {
            if let Some(node) = node
                && !found.is_empty()
            {
                grads.register::<Flex>(node.id, tensor(found, x.layout().shape().as_slice()));
            }
        }
    }
}
