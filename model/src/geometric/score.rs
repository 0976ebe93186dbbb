//! How likely a candidate axis is: what its numbers say, in the light of the joint's kind and role.

use object::JointKind;

use super::features::COUNT;
use super::table::{Net, SLIDES, TURNS, Unit};
use super::words::{ROLES, Role};

/// The score of a candidate, a log-likelihood up to a constant: larger is likelier, and a lead of 3
/// over another candidate of the same joint means twenty times as likely.
pub fn score(features: &[f64; COUNT], kind: JointKind, role: Role) -> f64 {
    let row = ROLES.iter().position(|&r| r == role).unwrap_or(0);
    if kind.turns() {
        TURNS.score(features, row, kind == JointKind::Continuous)
    } else {
        SLIDES.score(features, row, false)
    }
}

impl<const UNITS: usize> Net<UNITS> {
    fn score(&self, features: &[f64; COUNT], role: usize, endless: bool) -> f64 {
        let sum = |w: &[f64; COUNT]| w.iter().zip(features).map(|(w, f)| w * f).sum::<f64>();
        let unit = |u: &Unit| {
            let bias = u.bias + u.roles[role] + if endless { u.endless } else { 0.0 };
            u.gain * (bias + sum(&u.weights)).tanh()
        };
        sum(&self.linear) + sum(&self.roles[role]) + self.units.iter().map(unit).sum::<f64>()
    }
}
