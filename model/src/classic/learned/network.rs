//! A small network with one hidden layer beside a linear path: the score of a candidate axis by
//! itself.

use crate::classic::joints::features::COUNT;
use crate::classic::lexicon::words::ROLES;

/// Hidden units: those of several networks, fitted one by one, whose mean this one is.
pub const UNITS: usize = 200;
/// What a unit is made of: a weight for each number, its bias, what an endless turn and each role add
/// to that, and what the unit is worth.
pub const UNIT: usize = COUNT + 2 + ROLES.len() + 1;
/// Where in the weights units begin: before them stand those of the features alone, for every joint
/// and for each role beside.
pub const FIRST_UNIT: usize = COUNT * (1 + ROLES.len());
/// How many weights there are.
pub const SIZE: usize = FIRST_UNIT + UNITS * UNIT;

/// The features of a candidate.
type Row = [f64; COUNT];

/// Weights of features as they are measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Net {
    weights: Vec<f64>,
}

impl Default for Net {
    /// A network that says 0 of everything.
    fn default() -> Self {
        Self { weights: vec![0.0; SIZE] }
    }
}

impl Net {
    /// A network of these weights; `None` if their count is not [`SIZE`] or one is not finite.
    pub fn new(weights: &[f64]) -> Option<Self> {
        let net = Self { weights: weights.to_vec() };
        (weights.len() == SIZE && net.is_finite()).then_some(net)
    }

    /// Whether every weight is finite.
    pub fn is_finite(&self) -> bool {
        self.weights.iter().all(|w| w.is_finite())
    }

    /// The weights, little-endian, in single precision.
    pub fn write(&self) -> Vec<u8> {
        self.weights.iter().flat_map(|w| (*w as f32).to_le_bytes()).collect()
    }

    /// Log-likelihood of a candidate, up to a constant for the joint; `role` by its place in
    /// [`ROLES`].
    pub fn score(&self, features: &Row, role: usize, is_endless: bool) -> f64 {
        let (lines, units) = self.weights.split_at(FIRST_UNIT);
        let bent = |unit: &[f64]| unit[UNIT - 1] * lean(unit, features, role, is_endless).tanh();
        let bent: f64 = units.chunks(UNIT).map(bent).sum();
        dot(features, lines) + dot(features, &lines[COUNT * (1 + role)..]) + bent
    }
}

/// A unit's sum before its bend.
pub fn lean(unit: &[f64], features: &Row, role: usize, is_endless: bool) -> f64 {
    let endless = if is_endless { unit[COUNT + 1] } else { 0.0 };
    dot(features, unit) + unit[COUNT] + endless + unit[COUNT + 2 + role]
}

/// The features weighed by the first of `weights`.
pub fn dot(features: &Row, weights: &[f64]) -> f64 {
    features.iter().zip(weights).map(|(n, w)| n * w).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_score_is_what_lines_and_units_add_up_to() {
        let (role, mut weights) = (2, vec![0.0; SIZE]);
        (weights[1], weights[COUNT * (1 + role) + 1]) = (3.0, 0.5);
        let unit = &mut weights[FIRST_UNIT..FIRST_UNIT + UNIT];
        (unit[1], unit[COUNT], unit[COUNT + 1]) = (1.0, 0.25, 0.125);
        (unit[COUNT + 2 + role], unit[UNIT - 1]) = (0.5, 10.0);
        let net = Net::new(&weights).unwrap();
        let mut features = [0.0; COUNT];
        features[1] = 2.0;
        assert_eq!(net.score(&features, role, false), 7.0 + 10.0 * 2.75f64.tanh());
        assert_eq!(net.score(&features, role, true), 7.0 + 10.0 * 2.875f64.tanh());
        assert_eq!(net.score(&features, 0, false), 6.0 + 10.0 * 2.25f64.tanh());
    }

    #[test]
    fn a_network_is_written_in_single_precision_and_refused_where_it_is_none() {
        let weights: Vec<f64> = (0..SIZE).map(|i| i as f64 / 8.0).collect();
        let written = Net::new(&weights).unwrap().write();
        let (features, rest) = written.as_chunks::<4>();
        assert!(rest.is_empty());
        assert_eq!(
            features.iter().map(|n| f64::from(f32::from_le_bytes(*n))).collect::<Vec<_>>(),
            weights
        );
        assert_eq!(Net::new(&[f64::NAN; SIZE]), None);
        assert_eq!(Net::new(&weights[1..]), None);
    }
}
