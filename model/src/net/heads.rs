//! The two heads: which part a query belongs to, and how its joint would move it (paper, 4.3).
//!
//! Letters: B batch · Q queries · P parts · D width · F = 4 D · E cases · R rows.

use burn::module::{Module, Param};
use burn::tensor::{Device, Tensor};

use super::layers::Mlp;
use super::ops;
use super::source::{Builder, Start};

/// Numbers the joint head gives: direction, axis point, position at the lower and the upper limit.
pub const JOINT_WIDTH: usize = 12;

/// A motion type of the paper's τ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MotionType {
    /// Turns about an axis.
    Revolute,
    /// Slides along it.
    Prismatic,
}

/// A joint with one motion type, as the head sees it. Parts are counted through the whole batch:
/// part p of element b is b · P + p.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JointCase {
    /// The part it hangs on.
    pub parent: u32,
    /// The part it moves.
    pub child: u32,
    /// How.
    pub motion: MotionType,
}

/// Which joints are asked for at which queries: row r is query `query[r]` (b · Q + j) under case
/// `case[r]`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct JointRows {
    /// The joints.
    pub cases: Vec<JointCase>,
    /// Query of each row.
    pub query: Vec<u32>,
    /// Case of each row.
    pub case: Vec<u32>,
}

/// ψ_part: MLP([q; l]) → 1.
#[derive(Module, Debug)]
pub(crate) struct PartHead {
    pair: Mlp,
}

impl PartHead {
    pub(crate) fn new(b: Builder, width: usize) -> Self {
        Self { pair: Mlp::new(b, [2 * width, 4 * width, 1]) }
    }

    /// The parts' share of the hidden layer [B, P, F].
    pub(crate) fn parts(&self, parts: Tensor<3>) -> Tensor<3> {
        let width = parts.dims()[2];
        self.pair.first().share(parts, width)
    }

    /// Query tokens [B, Q, D] and the parts' share → logits [B, Q, P].
    pub(crate) fn logits(&self, queries: Tensor<3>, parts: Tensor<3>) -> Tensor<3> {
        let queries = self.pair.first().share(queries, 0);
        let logits = ops::pair_logits(queries, parts, self.pair.second().weight());
        match self.pair.second().bias() {
            Some(bias) => logits + bias.unsqueeze(),
            None => logits,
        }
    }
}

/// ψ_joint: MLP([q; l_parent; l_child; e_τ]) → 12.
#[derive(Module, Debug)]
pub(crate) struct JointHead {
    motion: Param<Tensor<2>>, // [2, D]: revolute, prismatic
    mlp: Mlp,
}

impl JointHead {
    pub(crate) fn new(mut b: Builder, width: usize) -> Self {
        let motion = b.parameter("motion_type", [2, width], Start::Normal(1.0));
        Self { motion, mlp: Mlp::new(b, [4 * width, 4 * width, JOINT_WIDTH]) }
    }

    /// The cases' share of the hidden layer [E, F], from part tokens [B, P, D].
    pub(crate) fn cases(&self, parts: Tensor<3>, cases: &[JointCase]) -> Tensor<2> {
        let [b, p, width] = parts.dims();
        let device = parts.device();
        let flat: Tensor<2> = parts.reshape([b * p, width]);
        let pick = |from: Tensor<2>, of: &dyn Fn(&JointCase) -> u32| {
            let rows: Vec<u32> = cases.iter().map(of).collect();
            from.select(0, ops::indices(&rows, &device)).unsqueeze::<3>()
        };
        let kind = |c: &JointCase| u32::from(c.motion == MotionType::Prismatic);
        let first = self.mlp.first();
        let sum = first.share(pick(flat.clone(), &|c| c.parent), width)
            + first.share(pick(flat, &|c| c.child), 2 * width)
            + first.share(pick(self.motion.val(), &kind), 3 * width);
        sum.reshape([cases.len() as i32, -1])
    }

    /// Query tokens [B, Q, D] and the cases' share → [R, 12], positions as the head writes them.
    pub(crate) fn rows(&self, queries: Tensor<3>, cases: Tensor<2>, rows: &JointRows) -> Tensor<2> {
        let queries = self.mlp.first().share(queries, 0);
        let hidden = ops::pair_rows(queries, cases, &rows.query, &rows.case);
        self.mlp.second().forward(hidden).reshape([rows.query.len(), JOINT_WIDTH])
    }

    pub(crate) fn none(device: &Device) -> Tensor<2> {
        Tensor::zeros([0, JOINT_WIDTH], device)
    }
}
