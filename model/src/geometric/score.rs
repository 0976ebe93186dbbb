//! How likely a candidate axis is: a weighted sum of its numbers, the weights by kind and role.

use object::JointKind;

use super::features::COUNT;
use super::table::{ENDLESS, ROLE_SLIDES, ROLE_TURNS, SLIDES, TURNS};
use super::words::{ROLES, Role};

/// The score of a candidate, a log-likelihood up to a constant: larger is likelier, and a lead of 3
/// over another candidate of the same joint means twenty times as likely.
pub fn score(features: &[f64; COUNT], kind: JointKind, role: Role) -> f64 {
    let row = ROLES.iter().position(|&r| r == role).unwrap_or(0);
    let (base, roles) = if kind.turns() { (&TURNS, &ROLE_TURNS) } else { (&SLIDES, &ROLE_SLIDES) };
    let endless = if kind == JointKind::Continuous { 1.0 } else { 0.0 };
    let weight = |i: usize| base[i] + roles[row][i] + endless * ENDLESS[i];
    features.iter().enumerate().map(|(i, f)| f * weight(i)).sum()
}
