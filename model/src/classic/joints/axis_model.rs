//! Probabilities of a joint's candidate axes, by a small network and by boosted trees.
//!
//! The network sees the features of one candidate. The trees also see the part's role and how the
//! candidate compares with the others. Turns and slides have models of their own.

use crate::classic::learned::network;
use object::JointKind;

use crate::classic::joints::features::{COUNT, NAMES};
use crate::classic::learned::grove::Grove;
use crate::classic::learned::network::Net;
use crate::classic::learned::pack::{Pack, PackError};
use crate::classic::learned::shipped::Shipped;
use crate::classic::lexicon::words::{ROLE_NAMES, ROLES, Role};

/// How many forests are asked side by side: what they say is averaged.
pub const FOLDS: usize = 6;
/// How many numbers the trees may ask about: those of the candidate, how far each is below the most
/// among all candidates, the role, whether the joint turns without end.
pub const INPUTS: usize = 2 * COUNT + ROLES.len() + 1;
/// What the trees are told of a candidate.
pub type Inputs = [f32; INPUTS];

/// What the numbers that the trees may ask about are called, in order: the axis features, each once more
/// as it stands below the most among all candidates.
pub fn names() -> Vec<String> {
    let below = NAMES.iter().map(|name| format!("below_most.{name}"));
    let of_joint = ROLE_NAMES.iter().chain(&["endless"]).map(ToString::to_string);
    NAMES.iter().map(ToString::to_string).chain(below).chain(of_joint).collect()
}
/// No candidate is less likely than this to the trees.
const LEAST: f64 = 1e-5;
/// How much the trees count; the rest is the networks', which know less of what is like the objects of
/// training, and more of what is not.
const TREES: f64 = 0.4;

static SHIPPED: Shipped<Learned> =
    Shipped::new("axes", include_bytes!("../../../weights/axes.pack"), Learned::read);

/// What packs of axes are called inside.
pub const KIND: &str = "axes";
/// The table of [`names`], which forests ask about.
pub const OF_TREES: &str = "candidate";
/// The table of [`crate::classic::joints::features::NAMES`], which networks ask about.
pub const OF_NETS: &str = "candidate by itself";
/// The joints that have models of their own, by what their sections are called.
pub const JOINTS: [&str; 2] = ["slide", "turn"];

/// The forests and the network of slides and of turns.
#[derive(Debug, Default)]
pub struct Learned([AxisModel; 2]);

#[derive(Debug, Default)]
struct AxisModel {
    forests: Grove<INPUTS>,
    net: Net,
}

/// The section of a fold's forest.
pub fn forest_section(joint: &str, fold: usize) -> String {
    format!("{joint}, fold {fold}")
}

/// The section of a network.
pub fn net_section(joint: &str) -> String {
    format!("{joint}, network")
}

impl Learned {
    /// What a pack of axes says; its first ensemble is that of slides, its second that of turns.
    ///
    /// # Errors
    /// [`PackError`] when it is none for this program.
    pub fn read(pack: &Pack<'_>) -> Result<Self, PackError> {
        pack.is(KIND)?;
        pack.asks(OF_TREES, &names())?;
        pack.asks(OF_NETS, &NAMES)?;
        let one = |place: usize| {
            let folds = 0..pack.ensemble(place)?.folds;
            let forests = folds.map(|f| pack.forest(&forest_section(JOINTS[place], f)));
            let net = pack.numbers(&net_section(JOINTS[place]), network::SIZE)?;
            let net = Net::new(&net).unwrap_or_default();
            Ok(AxisModel { forests: Grove::of(forests.collect::<Result<_, _>>()?), net })
        };
        Ok(Self([one(0)?, one(1)?]))
    }
}

/// Refuses a pack that this program cannot read.
///
/// # Errors
/// [`PackError`].
pub(crate) fn check() -> Result<(), PackError> {
    SHIPPED.check()
}

/// The name and the digest of the pack.
pub(crate) fn digest_of_pack() -> (&'static str, String) {
    SHIPPED.digest()
}

/// The score of each candidate of one joint, a log-likelihood up to a constant: a lead of 3 over another
/// means twenty times as likely.
pub fn scores(candidates: &[&[f64; COUNT]], kind: JointKind, role: Role) -> Vec<f64> {
    let (chances, nets) = said(candidates, kind, role);
    blended(&chances, &nets)
}

/// What the trees say of each candidate, and what the network says.
pub(crate) fn said(
    candidates: &[&[f64; COUNT]],
    kind: JointKind,
    role: Role,
) -> (Vec<f32>, Vec<f64>) {
    let forests = &SHIPPED.get().0[usize::from(kind.turns())].forests;
    let rows = inputs(candidates, kind, role);
    let chances = forests.mean_chances_of(0..forests.folds().len(), &rows, &[rows.len()]);
    (chances, candidates.iter().map(|c| net_score(c, kind, role)).collect())
}

/// What trees, which say chances, and a network, which says log-likelihoods, make of candidates
/// together.
pub fn blended(chances: &[f32], nets: &[f64]) -> Vec<f64> {
    let trees = chances.iter().map(|c| f64::from(*c).max(LEAST).ln());
    trees.zip(nets).map(|(trees, net)| TREES * trees + (1.0 - TREES) * net).collect()
}

/// What the trees are told of all candidates of one joint.
pub fn inputs(candidates: &[&[f64; COUNT]], kind: JointKind, role: Role) -> Vec<Inputs> {
    let mut most = [f64::NEG_INFINITY; COUNT];
    for candidate in candidates {
        most.iter_mut().zip(*candidate).for_each(|(m, x)| *m = m.max(*x));
    }
    let role = ROLES.iter().position(|&r| r == role).unwrap_or(0);
    let one = |candidate: &&[f64; COUNT]| {
        let mut inputs = [0.0; INPUTS];
        for (i, (own, most)) in candidate.iter().zip(&most).enumerate() {
            (inputs[i], inputs[COUNT + i]) = (*own as f32, (own - most) as f32);
        }
        inputs[2 * COUNT + role] = 1.0;
        inputs[INPUTS - 1] = f32::from(u8::from(kind == JointKind::Continuous));
        inputs
    };
    candidates.iter().map(one).collect()
}

/// What the network says of one candidate.
fn net_score(features: &[f64; COUNT], kind: JointKind, role: Role) -> f64 {
    let role = ROLES.iter().position(|&r| r == role).unwrap_or(0);
    SHIPPED.get().0[usize::from(kind.turns())].net.score(
        features,
        role,
        kind == JointKind::Continuous,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pack_that_ships_is_whole() {
        SHIPPED.check().unwrap();
        for AxisModel { forests, net } in &SHIPPED.get().0 {
            assert_eq!(forests.folds().len(), FOLDS);
            assert!(forests.folds().iter().all(|f| !f.trees.is_empty()));
            assert!(net != &Net::default());
        }
    }

    #[test]
    fn a_candidate_is_told_by_itself_and_against_the_best() {
        let (mut weak, mut strong) = ([0.0; COUNT], [0.0; COUNT]);
        (weak[0], weak[1], strong[0]) = (0.25, 1.0, 2.0);
        let told = inputs(&[&weak, &strong], JointKind::Continuous, ROLES[2]);
        assert_eq!((told[0][0], told[0][COUNT], told[0][COUNT + 1]), (0.25, -1.75, 0.0));
        assert_eq!((told[1][COUNT], told[1][COUNT + 1]), (0.0, -1.0));
        assert_eq!((told[0][2 * COUNT + 2], told[0][INPUTS - 1]), (1.0, 1.0));
        assert_eq!(told[0].iter().filter(|n| **n != 0.0).count(), 5);
    }
}
