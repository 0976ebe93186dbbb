//! The rules, client by client.

mod drake;
mod genesis;
mod isaac;
mod mujoco;
mod newton;
mod pybullet;
mod rerun;
mod sapien;

use crate::rule::Rule;

/// All rules, client by client.
pub const RULES: [&[Rule]; 8] = [
    mujoco::RULES,
    pybullet::RULES,
    drake::RULES,
    newton::RULES,
    isaac::RULES,
    sapien::RULES,
    genesis::RULES,
    rerun::RULES,
];
