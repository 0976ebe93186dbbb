//! A mesh made ready once, for a person who corrects: asked again and again, each time with another
//! condition, it answers what [`crate::Hybrid`] would.

use object::condition::GivenJoint;
use object::confidence::OtherAxis;
use object::sides::OuterSide;
use object::weld::Weld;
use object::{ArticulatedObject, Condition, DVec3, Mesh, Range};

use crate::articulate::{ArticulateError, Articulation, Note};
use crate::classic::confidence::{self, Evidence, confidence};
use crate::classic::joints::choices::Choices;
use crate::classic::joints::context::JointContext;
use crate::classic::joints::scene::Scene;
use crate::classic::joints::sweep::Axis;
use crate::classic::joints::{Chosen, Joints, Labelled, fit_choosing, given};
use crate::classic::kept::{Kept, keep, lost_part};
use crate::classic::packs::check;
use crate::classic::segment::skin::Skin;
use crate::classic::segment::{Labels, Memory, Spread, Way, spread};

/// Where fitted models label, axes are placed in the light of these labellings, too.
pub(super) const HYPOTHESES: [Way; 4] =
    [Way::Merging, Way::OutOfFold(0), Way::OutOfFold(1), Way::OutOfFold(2)];

/// What of a mesh stays the same whatever a condition says.
///
/// It may be shared between threads. What it answers depends on what it is asked alone, not on what it was
/// asked before.
#[derive(Debug)]
pub struct Prepared {
    /// The mesh as it came.
    mesh: Mesh,
    /// Its outer side, where that is not the mesh as it came.
    side: Option<OuterSide>,
    /// The surface that is labelled.
    skin: Skin,
    /// What was found for the last conditions.
    memory: Memory,
}

/// A part for each face, as [`crate::Hybrid`] labels them before parts without a face are dropped.
#[derive(Clone, Debug, PartialEq)]
pub struct PartLabels {
    /// For each face of the mesh, the index of its part in the condition's tree.
    pub part_of_face: Vec<u16>,
    /// For each face of the mesh, how likely it is of that part, 0 to 1: the class probability that the
    /// fitted models give, averaged over cuts; 1 where the face was painted.
    pub confidence: Vec<f32>,
    /// Losses and doubts about labels, in order of part.
    pub notes: Vec<Note>,
}

impl Prepared {
    /// Makes a mesh ready. Of one that is drawn on both sides, or in part from within, the outer side is
    /// articulated, and all faces go along.
    ///
    /// # Errors
    /// [`ArticulateError`] where what was learned cannot be read, or the outer side is no mesh.
    pub fn new(mesh: &Mesh) -> Result<Self, ArticulateError> {
        check()?;
        let weld = Weld::new(mesh);
        let Some(side) = OuterSide::of(mesh, &weld) else {
            let (mesh, skin) = (mesh.clone(), Skin::of(mesh, &weld));
            return Ok(Self { mesh, side: None, skin, memory: Memory::default() });
        };
        let outer = side.mesh(mesh)?;
        let (mesh, skin) = (mesh.clone(), Skin::of(&outer, &Weld::new(&outer)));
        Ok(Self { mesh, side: Some(side), skin, memory: Memory::default() })
    }

    /// The mesh as it came.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The part of every face.
    ///
    /// # Errors
    /// [`ArticulateError`] where the condition does not fit the mesh.
    pub fn labels(&self, condition: &Condition) -> Result<PartLabels, ArticulateError> {
        let Spread { labels, confidence, .. } = self.spread(condition, (Way::Fitted, &[]))?;
        let Labels { part_of_face, mut notes } = labels;
        let mut is_lost = vec![true; condition.tree.len()];
        part_of_face.iter().for_each(|&part| is_lost[usize::from(part)] = false);
        let lost = condition.tree.parts().iter().zip(is_lost).filter(|(_, is_lost)| *is_lost);
        notes.extend(lost.map(|(part, _)| lost_part(part.name.clone())));
        in_order_of_parts(&mut notes, condition);
        let part_of_face = self.on_all_faces(&part_of_face);
        Ok(PartLabels { part_of_face, confidence: self.on_all_faces(&confidence), notes })
    }

    /// The articulated object, and for each joint the axes it was chosen among, by the condition's parts.
    ///
    /// # Errors
    /// [`ArticulateError`] where the condition does not fit the mesh, or too few parts got a face.
    pub fn articulate(
        &self,
        condition: &Condition,
        seed: u64,
    ) -> Result<(Articulation, Vec<Choices>), ArticulateError> {
        confidence::check()?;
        let Made { mut articulation, choices, evidence, given } =
            self.articulated(condition, seed, Way::Fitted)?;
        let sure = |evidence: &Evidence| confidence(&articulation.object, evidence, &given);
        articulation.confidence = evidence.as_ref().map(sure);
        others(&mut articulation, &choices, mesh_size(&self.mesh));
        Ok((articulation, choices))
    }

    /// The articulated object, without a word on how sure it is, and what speaks for its parts and joints:
    /// what confidence is fitted to.
    ///
    /// # Errors
    /// As [`Prepared::articulate`].
    pub fn evidence(
        &self,
        condition: &Condition,
        seed: u64,
    ) -> Result<(Articulation, Evidence), ArticulateError> {
        let made = self.articulated(condition, seed, Way::Fitted)?;
        Ok((made.articulation, made.evidence.unwrap_or_default()))
    }

    /// How far a joint about this axis is free both ways: until more than a few points of what moves bump
    /// into what stays, radians or the mesh's unit; at most half a turn, or the object's diagonal. The axis
    /// need not be a unit vector; `pivot` is in the mesh's frame and unit.
    ///
    /// # Errors
    /// [`ArticulateError`] where the condition does not fit the mesh, too few parts got a face, or the part
    /// has no such joint or no face.
    pub fn free_range(
        &self,
        condition: &Condition,
        (part, joint): (usize, usize),
        (axis, pivot): (DVec3, DVec3),
        seed: u64,
    ) -> Result<Range, ArticulateError> {
        let labels = self.spread(condition, (Way::Fitted, &[]))?.labels;
        let Kept { tree, part_of_condition, part_of_face } = keep(condition, &labels.part_of_face)?;
        let no_joint = || ArticulateError::NoJoint { part, joint };
        let part = part_of_condition.get(part).copied().flatten().ok_or_else(no_joint)?;
        let kind = tree.parts()[part].joints.get(joint).ok_or_else(no_joint)?;
        let direction = axis.try_normalize().ok_or_else(no_joint)?;
        let Skin { mesh, weld, .. } = &self.skin;
        let category = condition.category.as_str();
        let from =
            Labelled { mesh, weld, tree: &tree, part_of_face: &part_of_face, category, given: &[] };
        let scene = Scene::new(&from, seed);
        let context = JointContext::new(&scene, &from, part, None, seed).ok_or_else(no_joint)?;
        let pivot = (pivot - scene.origin) / scene.unit;
        let axis = Axis { direction, pivot, turns: kind.turns() };
        let [ahead, back] = context.clearance(&axis);
        let range = Range::Limits { lower: -back, upper: ahead };
        Ok(if kind.turns() { range } else { range.scaled(scene.unit) })
    }

    pub(super) fn articulated(
        &self,
        condition: &Condition,
        seed: u64,
        way: Way,
    ) -> Result<Made, ArticulateError> {
        let asked: &[Way] = if way == Way::Fitted { &HYPOTHESES } else { &[] };
        let Spread { labels, others, evidence, .. } = self.spread(condition, (way, asked))?;
        let Labels { part_of_face, mut notes } = labels;
        let Kept { tree, part_of_condition, part_of_face } = keep(condition, &part_of_face)?;
        let name = |p: usize| condition.tree.parts()[p].name.clone();
        let lost = part_of_condition.iter().enumerate().filter(|(_, new)| new.is_none());
        notes.extend(lost.map(|(p, _)| lost_part(name(p))));
        let Skin { mesh, weld, .. } = &self.skin;
        let category = condition.category.as_str();
        let scale = condition.size.map_or(1.0, |size| size.scale_for(mesh));
        let given = given::of_parts(condition, &part_of_condition, scale);
        let from = Labelled {
            mesh,
            weld,
            tree: &tree,
            part_of_face: &part_of_face,
            category,
            given: &given,
        };
        let now = |&p: &u16| part_of_condition[usize::from(p)].unwrap_or(tree.root()) as u16;
        let others: Vec<Vec<u16>> = others.iter().map(|o| o.iter().map(now).collect()).collect();
        let Chosen { joints, mut choices, evidence: told } = fit_choosing(&from, &others, seed);
        let Joints { motions, notes: doubts } = joints;
        notes.extend(doubts);
        in_order_of_parts(&mut notes, condition);
        let part_of_face = self.on_all_faces(&part_of_face);
        let object = ArticulatedObject::new(self.mesh.clone(), tree, part_of_face, motions)?;
        let place = |new: usize| part_of_condition.iter().position(|p| *p == Some(new));
        choices.iter_mut().for_each(|c| c.part = place(c.part).unwrap_or(c.part));
        let evidence = evidence.map(|of_condition| {
            let old =
                |new: usize| part_of_condition.iter().position(|p| *p == Some(new)).unwrap_or(0);
            let old: Vec<usize> = (0..object.tree().len()).map(old).collect();
            let parts: Vec<_> = old.iter().map(|&p| of_condition[p]).collect();
            let has_point = |&p: &usize| condition.prompts[p].point.is_some();
            let has_point: Vec<bool> = old.iter().map(has_point).collect();
            let mut joints = vec![Vec::new(); parts.len()];
            told.into_iter().for_each(|(part, all)| joints[part] = all);
            let new = |old: usize| part_of_condition[old];
            Evidence::of(&object, &parts, &joints, (&has_point, &new))
        });
        let articulation = Articulation { object, part_of_condition, notes, confidence: None };
        Ok(Made { articulation, choices, evidence, given })
    }

    /// What is said of the faces of the surface that is labelled, said of all faces.
    fn on_all_faces<T: Copy>(&self, said: &[T]) -> Vec<T> {
        match &self.side {
            Some(side) => side.of_face.iter().map(|&face| said[face]).collect(),
            None => said.to_vec(),
        }
    }

    /// Labels of the surface that is labelled.
    fn spread(
        &self,
        condition: &Condition,
        ways: (Way, &[Way]),
    ) -> Result<Spread, ArticulateError> {
        condition.check_points(&self.mesh)?;
        let Some(side) = &self.side else {
            return Ok(spread((&self.skin, &self.memory), condition, ways));
        };
        let mut there = condition.clone();
        for prompt in &mut there.prompts {
            let faces = prompt.faces.iter().map(|face| side.of_face[face as usize] as u32);
            prompt.faces = faces.collect();
        }
        Ok(spread((&self.skin, &self.memory), &there, ways))
    }
}

/// The longest side of a mesh's box.
fn mesh_size(mesh: &Mesh) -> f64 {
    mesh.bounds().size().max_element()
}

/// Says of each joint which other axis is likeliest, by what it was chosen among, for the parts of the
/// condition.
fn others(made: &mut Articulation, choices: &[Choices], size: f64) {
    let Articulation { object, part_of_condition, confidence, .. } = made;
    let Some(confidence) = confidence else { return };
    for Choices { part, joint, axes } in choices {
        let Some(part) = part_of_condition.get(*part).copied().flatten() else { continue };
        let sure = confidence.parts.get_mut(part).and_then(|sure| sure.joints.get_mut(*joint));
        let (Some(sure), Some(found)) = (sure, object.joints(part).get(*joint)) else { continue };
        let own = axes.iter().filter(|axis| axis.is_one_with(found, size));
        let own: f64 = own.map(|axis| axis.probability).sum();
        let other = axes.iter().find(|axis| !axis.is_one_with(found, size));
        sure.instead =
            other.filter(|_| sure.axis < 1.0 || sure.line.is_some_and(|l| l < 1.0)).map(|other| {
                OtherAxis {
                    axis: other.direction,
                    pivot: other.pivot,
                    chance: other.probability / (1.0 - own).max(other.probability),
                }
            });
    }
}

/// An articulated object, the axes its joints were chosen among, and what speaks for it.
pub(super) struct Made {
    pub articulation: Articulation,
    choices: Vec<Choices>,
    /// Nothing where labels came by merging.
    evidence: Option<Evidence>,
    /// What was given of the joints of every part of the object.
    given: Vec<Vec<GivenJoint>>,
}

fn in_order_of_parts(notes: &mut [Note], condition: &Condition) {
    notes.sort_by_key(|n| condition.tree.parts().iter().position(|p| p.name == n.part));
}

#[cfg(test)]
mod tests;
