//! What parts look like, by role: weights of the shape descriptor, learned from objects with known
//! parts.
//!
//! A conditional choice among the candidates of each part, or none of them, by logistic regression; the
//! pack says on what.

use crate::classic::learned::pack::{Pack, PackError};
use crate::classic::learned::shipped::Shipped;
use crate::classic::lexicon::words::ROLE_NAMES;
use crate::classic::segment::prompts::shape;
use crate::classic::segment::prompts::shape::{COPIES, SHAPE_FEATURES, Shape};

/// How many weights a row has: those of the shape descriptor and of three more.
pub const WEIGHTS: usize = SHAPE_FEATURES + MORE.len();
/// What depends on the part beside the shape descriptor: how far the number of copies is from the number
/// of like-worded parts, how far below it, and a constant.
const MORE: [&str; 3] = ["copies_off", "copies_short", "constant"];
/// The row of all parts.
const ANY: &str = "any";
/// The rows of joints, in the order of [`PartTraits::joint`].
const JOINTS: [&str; 4] = ["joint_hinge", "joint_slide", "joint_endless", "joint_none"];
/// The rows of what else is known of a part.
const MORE_OF_PART: [&str; 4] = ["several_alike", "carries", "hangs_on_other", "is_base"];

/// What packs of roles are called inside.
pub const KIND: &str = "roles";
/// Their table of features: [`names`].
pub const TABLE: &str = "shape";

static SHIPPED: Shipped<RoleWeights> =
    Shipped::new("roles", include_bytes!("../../../../weights/roles.pack"), RoleWeights::read);

/// The features that are weighed, in order.
pub fn names() -> Vec<&'static str> {
    shape::NAMES.into_iter().chain(MORE).collect()
}

/// The rows of weights, each of which is a section of the pack, in order.
pub fn rows() -> Vec<&'static str> {
    let known = [ANY].into_iter().chain(ROLE_NAMES).chain(JOINTS);
    known.chain(MORE_OF_PART).collect()
}

/// The places among [`rows`] of those that count for a part of this role and joint, of which these
/// things are so.
pub(crate) fn row_numbers(
    (role, joint): (usize, usize),
    is: [bool; MORE_OF_PART.len()],
) -> Vec<usize> {
    let joints = 1 + ROLE_NAMES.len();
    let said = (joints + JOINTS.len()..).zip(is).filter(|(_, is)| *is).map(|(row, _)| row);
    [0, 1 + role, joints + joint].into_iter().chain(said).collect()
}

/// Weights by row.
#[derive(Debug, Default)]
pub(crate) struct RoleWeights {
    any: Vec<f64>,
    roles: Vec<Vec<f64>>,
    joints: Vec<Vec<f64>>,
    /// Several like-worded parts; carries a part; hangs on another part than the base; is the base.
    more: Vec<Vec<f64>>,
}

impl RoleWeights {
    fn read(pack: &Pack<'_>) -> Result<Self, PackError> {
        pack.is(KIND)?;
        pack.asks(TABLE, &names())?;
        let row = |name: &str| pack.numbers(name, WEIGHTS);
        let several = |names: &[&str]| names.iter().map(|name| row(name)).collect::<Result<_, _>>();
        Ok(Self {
            any: row(ANY)?,
            roles: several(&ROLE_NAMES)?,
            joints: several(&JOINTS)?,
            more: several(&MORE_OF_PART)?,
        })
    }

    /// The weights that count for a part of this role and joint, of which these things are so.
    pub(crate) fn of(
        &self,
        (role, joint): (usize, usize),
        is: [bool; MORE_OF_PART.len()],
    ) -> impl Iterator<Item = &[f64]> {
        let said = self.more.iter().zip(is).filter(|(_, is)| *is).map(|(row, _)| row);
        let known =
            [&self.any].into_iter().chain(self.roles.get(role)).chain(self.joints.get(joint));
        known.chain(said).map(|row| &row[..])
    }
}

/// What was learned.
pub(crate) fn learned() -> &'static RoleWeights {
    SHIPPED.get()
}

/// Refuses a pack that this program cannot read.
pub(crate) fn check() -> Result<(), PackError> {
    SHIPPED.check()
}

/// The name and the digest of the pack.
pub(crate) fn digest_of_pack() -> (&'static str, String) {
    SHIPPED.digest()
}

/// What is known of a part, as the table of looks wants it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PartTraits {
    /// Its role, by its place among all roles.
    pub role: usize,
    /// 0 hinge, 1 slide, 2 endless turn, 3 none.
    pub joint: usize,
    /// How many parts have the same words and the same parent, itself included.
    pub like: usize,
    /// Whether another part hangs on it.
    pub carries: bool,
    /// Whether it hangs on the base.
    pub hangs_on_base: bool,
    /// Whether it is the base.
    pub is_base: bool,
}

impl PartTraits {
    /// How well a candidate with these shape features fits, as log-odds against the part being absent.
    pub(crate) fn fit(&self, shape: &Shape) -> f64 {
        let features = self.features(shape);
        let row = |weights: &[f64]| weights.iter().zip(&features).map(|(w, x)| w * x).sum::<f64>();
        learned().of((self.role, self.joint), self.is()).map(row).sum()
    }

    /// What is weighed of a candidate with these shape features, in the order of [`crate::classic::segment::prompts::roles::names`].
    pub(crate) fn features(&self, shape: &Shape) -> [f64; WEIGHTS] {
        let like = (self.like as f64).ln();
        let more = [(shape[COPIES] - like).abs(), (like - shape[COPIES]).max(0.0), 1.0];
        let mut features = [0.0; WEIGHTS];
        features.iter_mut().zip(shape.iter().chain(&more)).for_each(|(f, x)| *f = *x);
        features
    }

    /// The rows of weights that count for the part, as places in [`crate::classic::segment::prompts::roles::rows`].
    pub(crate) fn rows(&self) -> Vec<usize> {
        row_numbers((self.role, self.joint), self.is())
    }

    fn is(&self) -> [bool; 4] {
        let far = !self.hangs_on_base && !self.is_base;
        [self.like > 1, self.carries, far, self.is_base]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pack_that_ships_has_a_row_for_everything_a_part_may_be() {
        SHIPPED.check().unwrap();
        assert_eq!(rows().len(), 25);
        let said = ((3, 1), [true, false, false, true]);
        let features = row_numbers(said.0, said.1);
        let names: Vec<&str> = features.iter().map(|&row| rows()[row]).collect();
        assert_eq!(names, ["any", "role_pointer", "joint_slide", "several_alike", "is_base"]);
        assert_eq!(learned().of(said.0, said.1).count(), names.len());
    }
}
