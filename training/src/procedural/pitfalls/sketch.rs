//! An object in the making, and where a person clicks.

use object::articulated::ObjectError;
use object::condition::Prompt;
use object::weld::nearest_on_triangle;
use object::{ArticulatedObject, Condition, Configuration, DVec3, Origin};

use super::super::draft::{Draft, cuboid, rod};
use super::super::error::FamilyError;
use super::super::shapes::Shape;
use super::error::PitfallError;
use crate::dataset::Specimen;
use crate::dataset::pose::posed;
use crate::fuse::fused;

/// An object in the making: object frame, metres.
pub(super) struct Sketch {
    /// What kind of thing it is.
    pub(super) category: &'static str,
    /// Its parts, as they are when everything is shut.
    pub(super) draft: Draft,
    /// Where each part is clicked: its nearest face is meant.
    pub(super) clicks: Vec<DVec3>,
    /// How far the first joint of some parts is from shut, radians or metres.
    pub(super) open: Vec<(usize, f64)>,
    /// The recipe of the one skin it comes as, if it does.
    pub(super) skin: Option<&'static str>,
}

impl Sketch {
    /// Begins with what stands still, and where that is clicked.
    pub(super) fn new(category: &'static str, (text, click): (&str, DVec3), shape: Shape) -> Self {
        let draft = Draft::new(vec![text.to_owned()], shape);
        Self { category, draft, clicks: vec![click], open: Vec::new(), skin: None }
    }

    /// Adds a part with one joint to a parent; returns its number.
    pub(super) fn add(
        &mut self,
        parent: usize,
        (text, click): (impl Into<String>, DVec3),
        motion: object::JointMotion,
        shape: Shape,
    ) -> usize {
        self.clicks.push(click);
        self.draft.add(parent, vec![text.into()], vec![motion], shape)
    }

    /// The object and what is asked about it.
    pub(super) fn finish(self, id: String) -> Result<(Specimen, Condition), PitfallError> {
        let Self { category, draft, clicks, open, skin } = self;
        let shut = draft.finish(id)?;
        let mut whole = shut.clone();
        if !open.is_empty() {
            let mut there = Configuration::rest(shut.object.tree());
            for (part, value) in open {
                let own = there.0.get_mut(part).and_then(|values| values.first_mut());
                *own.ok_or(PitfallError::NoJoint(part))? = value;
            }
            whole.object = posed(&shut.object, &there)?;
        }
        // The skin has other faces; a pose has the same.
        let mut pointed = &shut.object;
        if let Some(recipe) = skin {
            whole = fused(&whole, &recipe.parse()?)?;
            pointed = &whole.object;
        }
        let parts = pointed.tree().len();
        if parts != clicks.len() {
            return Err(PitfallError::Hidden { left: parts, parts: clicks.len() });
        }
        let prompt = |(part, click): (usize, &DVec3)| {
            let face = face_near(pointed, part, *click);
            let point = face.map(|face| whole.object.mesh().centroid(face));
            Prompt { point, ..Prompt::default() }
        };
        let prompts = clicks.iter().enumerate().map(prompt).collect();
        let asked = Condition::of_tree(category, whole.object.tree().clone(), Origin::User);
        Ok((whole, Condition { prompts, ..asked }))
    }
}

impl From<ObjectError> for PitfallError {
    fn from(wrong: ObjectError) -> Self {
        Self::Family(FamilyError::from(wrong))
    }
}

/// The face of a part that is nearest to a place.
fn face_near(object: &ArticulatedObject, part: usize, place: DVec3) -> Option<usize> {
    let off = |face: &usize| {
        nearest_on_triangle(place, object.mesh().corners(*face)).distance_squared(place)
    };
    object.faces_of(part).min_by(|a, b| off(a).total_cmp(&off(b)))
}

/// Barrels of a hinge along a line: so many, each a share of what falls to it.
pub(super) fn barrels([from, to]: [DVec3; 2], count: usize, radius: f64) -> Shape {
    let along = (to - from) / count as f64;
    let one = |i: usize| {
        let start = from + along * i as f64;
        rod(start + along * 0.35, start + along * 0.65, radius)
    };
    (1..count).fold(one(0), |all, i| all.with(one(i)))
}

/// A box between two corners.
pub(super) fn between(min: DVec3, max: DVec3) -> Shape {
    cuboid((min + max) / 2.0, max - min)
}
