//! Particulate whole: a mesh becomes an articulated object, and nobody says what its parts are.
//!
//! The network whose successor the paper describes, with the point features it was trained on. Its
//! published weights may not be shipped; whoever has them, as safetensors under their original names,
//! measures with them.

mod cloud;

use std::io::{Read, Seek};

use burn::tensor::Device;
use object::articulated::{JointMotion, Range};
use object::origin::Origin;
use object::weld::Weld;
use object::{ArticulatedObject, Condition, JointKind, KinematicTree, Mesh, Part};

use self::cloud::Surface;
use crate::articulate::{ArticulateError, Articulation, Note};
use crate::features::UnitCube;
use crate::fit::survive::{Survivors, survivors};
use crate::fit::{FaceVotes, Mode, label_faces};
use crate::net::Points;
use crate::net::partfield::{PartField, PartFieldSizes};
use crate::net::particulate::{Decision, PUBLISHED_PARTS, PartMotion, Particulate};
use crate::weights::{TensorFile, WeightsError};

/// Points that the feature planes are made of, and points that are given to parts.
const POINTS: [usize; 2] = [40_000, 102_400];

/// Particulate with PartField before it.
#[derive(Debug)]
pub struct Predecessor {
    network: Particulate,
    features: PartField,
    points: [usize; 2],
    identity: String,
}

/// What was found in a mesh.
#[derive(Clone, Debug)]
pub struct Proposal {
    /// Its parts, their tree and joint kinds, in the form of a question; parts have numbers for names.
    pub condition: Condition,
    /// The answer to that question.
    pub articulation: Articulation,
}

/// Why the networks could not be set up.
#[derive(Debug, thiserror::Error)]
pub enum PredecessorError {
    /// Weights that cannot be used.
    #[error("the weights of {whose}: {source}")]
    Weights {
        /// Particulate or PartField.
        whose: &'static str,
        /// Why not.
        source: WeightsError,
    },
    /// Two networks that do not belong together.
    #[error("Particulate reads {wanted} features of a point, PartField gives {found}")]
    Width {
        /// What the one reads.
        wanted: usize,
        /// What the other gives.
        found: usize,
    },
}

impl Predecessor {
    /// Reads both networks from safetensors under the names of the published checkpoints; `name`
    /// becomes part of the identity, so it must change when the weights do.
    ///
    /// # Errors
    /// [`PredecessorError`] when weights are missing, odd or of networks that do not belong together.
    pub fn load(
        weights: impl Read + Seek,
        features: impl Read + Seek,
        name: &str,
    ) -> Result<Self, PredecessorError> {
        let device = Device::flex();
        let of = |whose| move |source| PredecessorError::Weights { whose, source };
        let particulate = TensorFile::open(weights)
            .and_then(|mut file| Particulate::load(&mut file, PUBLISHED_PARTS, &device));
        let partfield = TensorFile::open(features)
            .and_then(|mut file| PartField::load(&mut file, PartFieldSizes::PUBLISHED, &device));
        Self::new(
            particulate.map_err(of("Particulate"))?,
            partfield.map_err(of("PartField"))?,
            (POINTS, name),
        )
    }

    fn new(
        network: Particulate,
        features: PartField,
        (points, name): ([usize; 2], &str),
    ) -> Result<Self, PredecessorError> {
        let (wanted, found) = (network.sizes().features, features.sizes().features());
        if wanted != found {
            return Err(PredecessorError::Width { wanted, found });
        }
        Ok(Self { network, features, points, identity: format!("particulate/1 {name}") })
    }

    /// Name and version; changes whenever results may.
    pub fn identity(&self) -> String {
        self.identity.clone()
    }

    /// Parts, tree and joints of a mesh. The same mesh and seed give the same.
    ///
    /// # Errors
    /// [`ArticulateError`] when a network gives no numbers or what it says is no object.
    pub fn propose(&self, mesh: &Mesh, seed: u64) -> Result<Proposal, ArticulateError> {
        let (weld, frame) = (Weld::new(mesh), UnitCube::of(mesh));
        let (decision, faces) = self.ask(&Surface::new(mesh, &weld, frame), seed)?;
        let found = Found::new(&decision, frame)?;
        let part: Vec<u16> = decision
            .part_of_point
            .iter()
            .map(|&slot| found.part_of_slot[usize::from(slot)])
            .collect();
        let votes = FaceVotes { face: &faces, part: &part, parts: found.condition.tree.len() };
        let labels = label_faces(mesh, &weld, votes, Mode::Automatic);
        let Survivors { tree, part_of_condition, part_of_face } =
            survivors(&found.condition, &labels)?;
        let kept = found.motions.into_iter().zip(&part_of_condition);
        let motions = kept.filter(|(_, part)| part.is_some()).map(|(motions, _)| motions).collect();
        let object = ArticulatedObject::new(mesh.clone(), tree, part_of_face, motions)?;
        let articulation =
            Articulation { object, part_of_condition, notes: found.notes, confidence: None };
        Ok(Proposal { condition: found.condition, articulation })
    }

    /// What the networks say, and the face of each point they say it of.
    fn ask(&self, surface: &Surface, seed: u64) -> Result<(Decision, Vec<u32>), ArticulateError> {
        let device = Device::flex();
        let failed = |e: WeightsError| ArticulateError::Network(e.to_string());
        let [seen, asked] = self.points;
        let seen = surface.sample(seen, false, seed);
        let planes = self.features.encode(&seen.positions, &device).map_err(failed)?;
        let asked = surface.sample(asked, true, seed.wrapping_add(2));
        let features = planes.features(&asked.positions);
        let points = Points { positions: asked.positions, normals: Some(asked.normals), features };
        let raw = self.network.forward(&points, &device).map_err(failed)?;
        Ok((self.network.decide(&raw, 0.0).map_err(failed)?, asked.faces))
    }
}

/// A decision as parts that are numbered without gaps.
struct Found {
    condition: Condition,
    motions: Vec<Vec<JointMotion>>,
    part_of_slot: Vec<u16>,
    notes: Vec<Note>,
}

impl Found {
    fn new(decision: &Decision, frame: UnitCube) -> Result<Self, ArticulateError> {
        let slots: Vec<usize> = (0..decision.used.len()).filter(|&s| decision.used[s]).collect();
        let mut part_of_slot = vec![0; decision.used.len()];
        slots.iter().enumerate().for_each(|(part, &slot)| part_of_slot[slot] = part as u16);
        let (mut parts, mut motions, mut notes) = (Vec::new(), Vec::new(), Vec::new());
        for (number, &slot) in slots.iter().enumerate() {
            let edge = decision.tree.iter().find(|(_, child)| usize::from(*child) == slot);
            let parent = edge.map(|&(parent, _)| usize::from(part_of_slot[usize::from(parent)]));
            let name = format!("part_{number}");
            let motion = &decision.motions[slot];
            // What hangs on nothing does not move.
            let moves = if parent.is_some() { joints(motion, frame) } else { Vec::new() };
            let doubtful = moves.iter().any(|(_, doubt)| *doubt);
            notes.extend(doubtful.then(|| Note {
                part: name.clone(),
                message: "its range left out the pose it is in; it was widened to hold it".into(),
                loss: false,
            }));
            let moves: Vec<JointMotion> = moves.into_iter().map(|(motion, _)| motion).collect();
            let joints = moves.iter().map(|m| m.kind).collect();
            parts.push(Part { name, text: String::new(), parent, joints });
            motions.push(moves);
        }
        let tree = KinematicTree::new(parts)?;
        let condition = Condition::of_tree("", tree, Origin::Model);
        Ok(Self { condition, motions, part_of_slot, notes })
    }
}

/// A part's joints, the mesh's unit, the turn before the slide it carries; and whether the range of
/// each was widened.
fn joints(motion: &PartMotion, frame: UnitCube) -> Vec<(JointMotion, bool)> {
    let pivot = frame.outside(motion.pivot.unwrap_or_default());
    let turn = motion.revolute.then(|| {
        let (range, widened) = range(motion.revolute_range, 1.0);
        (
            JointMotion { kind: JointKind::Revolute, axis: motion.revolute_axis, pivot, range },
            widened,
        )
    });
    let slide = motion.prismatic.then(|| {
        let (range, widened) = range(motion.prismatic_range, frame.side);
        let axis = motion.prismatic_axis;
        (JointMotion { kind: JointKind::Prismatic, axis, pivot, range }, widened)
    });
    turn.into_iter().chain(slide).collect()
}

/// A range that holds the rest pose, and whether the network's did not.
fn range([low, high]: [f64; 2], scale: f64) -> (Range, bool) {
    let (lower, upper) = (low.min(high) * scale, low.max(high) * scale);
    let range = Range::Limits { lower: lower.min(0.0), upper: upper.max(0.0) };
    (range, lower > 0.0 || upper < 0.0)
}

#[cfg(test)]
mod tests {
    use object::DVec3;

    use super::cloud::tests::blocks;
    use super::*;
    use crate::net::particulate::ParticulateSizes;
    use crate::net::source::Random;

    /// Networks that were never trained.
    fn untrained(features: usize, seed: u64) -> Result<Predecessor, PredecessorError> {
        let device = Device::flex();
        let sizes = ParticulateSizes { width: 32, heads: 2, layers: 2, features, parts: 5 };
        let network = Particulate::build(sizes, &mut Random { seed }, &device);
        let sizes = PartFieldSizes {
            channels: 16,
            resolution: 16,
            hidden: 32,
            width: 16,
            layers: 1,
            heads: 2,
            out: 20,
            distance: 8,
        };
        let features = PartField::build(sizes, &mut Random { seed: seed + 1 }, &device);
        Predecessor::new(network, features, ([300, 500], "untrained"))
    }

    #[test]
    fn whatever_the_networks_say_is_an_object_and_the_same_again() {
        let mesh = blocks(&[0.0, 3.0, 6.0, 9.0].map(|x| DVec3::new(x, x / 2.0, -x)));
        let mut answers = 0;
        for seed in 0..12 {
            let predecessor = untrained(12, seed).unwrap();
            match predecessor.propose(&mesh, seed) {
                Ok(Proposal { condition, articulation }) => {
                    let again = predecessor.propose(&mesh, seed).unwrap();
                    assert_eq!(
                        (&condition, &articulation),
                        (&again.condition, &again.articulation)
                    );
                    assert_eq!(condition.tree.len(), articulation.part_of_condition.len());
                    assert_eq!(condition.origin, Origin::Model);
                    answers += 1;
                }
                Err(ArticulateError::NothingLabelled(_) | ArticulateError::Tree(_)) => {}
                Err(other) => panic!("{other}"),
            }
        }
        assert!(answers > 0, "untrained networks never said anything");
    }

    #[test]
    fn networks_that_do_not_belong_together_are_told_apart() {
        let error = untrained(13, 5).unwrap_err().to_string();
        assert_eq!(error, "Particulate reads 13 features of a point, PartField gives 12");
    }

    fn motion(revolute: bool, prismatic: bool) -> PartMotion {
        PartMotion {
            revolute,
            prismatic,
            revolute_axis: DVec3::Z,
            pivot: Some(DVec3::new(0.25, 0.0, 0.0)),
            revolute_range: [1.5, 0.0],
            prismatic_axis: DVec3::X,
            prismatic_range: [0.1, 0.3],
        }
    }

    #[test]
    fn slots_become_parts_and_motions_leave_the_unit_cube() {
        let decision = Decision {
            part_of_point: vec![0, 2, 3],
            used: vec![true, false, true, true],
            tree: vec![(2, 0), (2, 3)],
            motions: vec![
                motion(true, false),
                motion(true, true),
                motion(true, false),
                motion(true, true),
            ],
            axis_points: vec![],
        };
        let frame = UnitCube { centre: DVec3::Y, side: 4.0 };
        let Found { condition, motions, part_of_slot, notes } =
            Found::new(&decision, frame).unwrap();
        assert_eq!(part_of_slot, [0, 0, 1, 2]);
        let parents: Vec<_> = condition.tree.parts().iter().map(|p| p.parent).collect();
        assert_eq!(parents, [Some(1), None, Some(1)]);
        assert!(motions[1].is_empty(), "the root hangs on nothing");
        let [turn] = motions[0].as_slice() else { panic!("{motions:?}") };
        assert_eq!(turn.pivot, DVec3::new(1.0, 1.0, 0.0));
        assert_eq!(turn.range, Range::Limits { lower: 0.0, upper: 1.5 });
        let kinds: Vec<_> = motions[2].iter().map(|m| m.kind).collect();
        assert_eq!(kinds, [JointKind::Revolute, JointKind::Prismatic]);
        let Range::Limits { lower, upper } = motions[2][1].range else { panic!("{motions:?}") };
        assert!(lower == 0.0 && (upper - 1.2).abs() < 1e-12);
        assert_eq!(notes.iter().map(|n| n.part.as_str()).collect::<Vec<_>>(), ["part_2"]);
    }
}
