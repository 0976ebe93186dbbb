//! Room to move: pieces and ranges altered until no two links touch, at rest or in motion.
//!
//! Every conflict is ended by planes: a piece keeps only what lies behind a plane that the other
//! piece's whole motion stays in front of. Cutting only ever shrinks pieces, so what is free stays
//! free. Where room would cost visible surface, the range is cut instead; every alteration is
//! written down.
//!
//! ```
//! use asset::collision::clearance::ClearanceOptions;
//! let of = ClearanceOptions::for_diagonal;
//! assert_eq!((of(0.1).tolerance, of(1.0).tolerance), (0.005, 0.02));
//! assert_eq!((of(1.0).gap, of(10.0).gap), (0.0008, 0.001));
//! ```

mod carve;
mod combine;
mod joints;
mod meeting;
mod motion;
mod scene;
mod slides;
mod together;

#[cfg(test)]
mod tests;

use object::condition::GivenJoints;
use object::{ArticulatedObject, JointMotion};

use crate::change::Change;
use crate::collision::cover::Cover;
use crate::collision::piece::{ConvexPiece, least_width};
use crate::collision::solid::{MAX_CORNERS, Solid};
use scene::{Body, Scene};

/// Share of a link's samples that carving may uncover before a range is cut instead: none.
const HARMLESS: f64 = 1e-9;

/// How far links are kept apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearanceOptions {
    /// How far surface and pieces may lie apart, metres.
    pub tolerance: f64,
    /// Distance kept between links, metres.
    pub gap: f64,
    /// Seed of the surface samples and of the configurations tried.
    pub seed: u64,
    /// How much of the usual worth is enough for a further piece: 1 for few pieces, less for more.
    pub share: f64,
}

impl ClearanceOptions {
    /// What suits an object of this diagonal, metres: a tolerance of 2 % or 5 mm and a gap of
    /// 0.08 %, at most 1 mm.
    pub fn for_diagonal(diagonal: f64) -> Self {
        let tolerance = (0.02 * diagonal).max(0.005);
        Self { tolerance, gap: (0.0008 * diagonal).min(0.001), seed: 0, share: 1.0 }
    }
}

/// Pieces that have room, and the ranges they have room for.
#[derive(Clone, Debug)]
pub struct Cleared {
    /// The pieces of each part, object frame, rest pose, metres.
    pub pieces: Vec<Vec<ConvexPiece>>,
    /// The motions of each part; kinds, axes and pivots as they were.
    pub joints: Vec<Vec<JointMotion>>,
    /// What was altered: ranges (`range`) and pieces that lost surface (`collision`).
    pub changes: Vec<Change>,
}

/// Alters the pieces of an object's parts and the ranges of its joints until no two parts that
/// move against each other touch: at rest, along each joint alone, along each pair of joints.
///
/// `pieces` holds the pieces of each part, object frame, metres. Parts that no joint separates are
/// one body and may touch.
pub fn clear(
    object: &ArticulatedObject,
    pieces: Vec<Vec<ConvexPiece>>,
    options: &ClearanceOptions,
) -> Cleared {
    clear_keeping(object, pieces, &GivenJoints::default(), options)
}

/// [`clear`], but ends of ranges that are given stay: parts that meet before them do so.
pub(crate) fn clear_keeping(
    object: &ArticulatedObject,
    pieces: Vec<Vec<ConvexPiece>>,
    given: &GivenJoints,
    options: &ClearanceOptions,
) -> Cleared {
    let mut clearing = Clearing::new(object, pieces, given, options);
    clearing.shorten_slides();
    clearing.hold_slides();
    clearing.clear_each_joint();
    clearing.clear_pairs();
    clearing.clear_together();
    clearing.hold_slides();
    clearing.finish()
}

/// One joint of the object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct JointId {
    part: usize,
    index: usize,
}

/// The work in progress.
struct Clearing<'a> {
    object: &'a ArticulatedObject,
    given: &'a GivenJoints,
    options: ClearanceOptions,
    scene: Scene,
    joints: Vec<Vec<JointMotion>>,
    changes: Vec<Change>,
    /// For each part, the share of samples uncovered and the volume before anything was carved.
    before: Vec<(f64, f64)>,
}

impl<'a> Clearing<'a> {
    fn new(
        object: &'a ArticulatedObject,
        mut pieces: Vec<Vec<ConvexPiece>>,
        given: &'a GivenJoints,
        options: &ClearanceOptions,
    ) -> Self {
        let parts = object.tree().len();
        pieces.resize(parts, Vec::new());
        let mesh = object.mesh();
        let body = |(part, pieces): (usize, Vec<ConvexPiece>)| {
            let solid = |p: ConvexPiece| Solid::of(&p.vertices, MAX_CORNERS, 0.0);
            let solids = pieces.into_iter().filter_map(solid).collect();
            let cover = match mesh.submesh(object.faces_of(part)) {
                Ok(link) => Cover::new(&link, options.seed, options.tolerance),
                Err(_) => Cover::empty(options.tolerance),
            };
            Body::new(solids, cover)
        };
        let bodies: Vec<Body> = pieces.into_iter().enumerate().map(body).collect();
        let before = bodies.iter().map(|b| (b.uncovered(), b.volume())).collect();
        let scene = Scene {
            bodies,
            gap: options.gap,
            width: least_width(options.tolerance),
            share: options.share,
        };
        let joints = (0..parts).map(|p| object.joints(p).to_vec()).collect();
        Self { object, given, options: *options, scene, joints, changes: Vec::new(), before }
    }

    /// All joints, parents first, those nearest the parent first.
    fn joint_ids(&self) -> Vec<JointId> {
        let of =
            |&part: &usize| (0..self.joints[part].len()).map(move |index| JointId { part, index });
        self.object.tree().root_first().iter().flat_map(of).collect()
    }

    fn motion(&self, joint: JointId) -> &JointMotion {
        &self.joints[joint.part][joint.index]
    }

    /// Whether the lower and the upper end of a joint's range are given.
    fn keeps(&self, joint: JointId) -> [bool; 2] {
        self.given.ends(joint.part, joint.index)
    }

    fn note(&mut self, part: usize, what: &str, before: String, after: String, why: &str) {
        let name = &self.object.tree().parts()[part].name;
        self.changes.push(Change::new(name, what, before, after, why));
    }

    fn finish(mut self) -> Cleared {
        for part in 0..self.scene.bodies.len() {
            let body = &self.scene.bodies[part];
            let ((uncovered, volume), now) = (self.before[part], (body.uncovered(), body.volume()));
            if now.0 > uncovered + HARMLESS || now.1 < 0.9 * volume {
                let text = |(uncovered, volume): (f64, f64)| {
                    format!("{:.1} % of the surface uncovered, {volume:.3e} m³", 100.0 * uncovered)
                };
                let why = "pieces give way to parts that move past them";
                self.note(part, "collision", text((uncovered, volume)), text(now), why);
            }
        }
        let of = |b: &Body| b.alive().filter_map(|(_, p)| p.solid.to_piece()).collect();
        let pieces = self.scene.bodies.iter().map(of).collect();
        Cleared { pieces, joints: self.joints, changes: self.changes }
    }
}
