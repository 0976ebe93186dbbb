//! Objects in which a mistake is likely: eight kinds, each of an everyday thing that can be told apart by
//! who looks, and that a habit gets wrong.
//!
//! | Kind | The mistake that is likely |
//! |---|---|
//! | `front_left_behind` | a drawer's front, a body of its own, stays on the carcass |
//! | `panel_to_body` | a door's panel, or its lining, goes to the body |
//! | `leak_into_the_parent` | on one skin over all parts, a part runs over into what it hangs on |
//! | `axis_along_the_long_direction` | what is long turns about its long way |
//! | `hinge_on_the_handles_side` | a hinge where something looks like a grip |
//! | `slides_inward` | a drawer goes into its body, or out on the wrong side |
//! | `shown_open` | the range of what is shown open leads away from shut |
//! | `swivel_taken_for_roll` | a caster's fork rolls, or its wheel swivels |
//!
//! Every kind has five designs, which go by the index; index and seed throw all sizes and details. Where a
//! person clicks is of the object too: on a handle, on a box, on a loose panel.
//!
//! Seeds are split: [`JUDGED`] is for judging alone, with which nothing is ever fitted or chosen, and those
//! from [`FITTED`] on are free for fitting.

mod casters;
mod error;
mod fronts;
mod hinges;
mod sketch;
mod skins;
mod slides;

use object::Condition;

use super::draft::Dice;
use crate::dataset::Specimen;
pub use error::PitfallError;
use sketch::Sketch;

/// The seed of objects that are judged. Never fit anything to these.
pub const JUDGED: u64 = 8;
/// The first seed of objects that may be fitted to.
pub const FITTED: u64 = 1000;
/// How many designs a kind has.
pub const DESIGNS: usize = 5;

/// A kind of objects in which one mistake is likely.
pub struct Pitfall {
    /// The mistake, such as `shown_open`.
    pub name: &'static str,
    build: fn(usize, &mut Dice) -> Sketch,
}

/// An object and what is asked about it.
#[derive(Clone, Debug)]
pub struct Question {
    /// The object with its truth: object frame, metres. Its id is kind and index.
    pub specimen: Specimen,
    /// Its parts, in order, each with the point where a person clicked it.
    pub condition: Condition,
}

const fn pitfall(name: &'static str, build: fn(usize, &mut Dice) -> Sketch) -> Pitfall {
    Pitfall { name, build }
}

/// Every kind there is.
pub const PITFALLS: [Pitfall; 8] = [
    pitfall("front_left_behind", fronts::front_left_behind),
    pitfall("panel_to_body", fronts::panel_to_body),
    pitfall("leak_into_the_parent", skins::leak_into_the_parent),
    pitfall("axis_along_the_long_direction", hinges::axis_along_the_long_direction),
    pitfall("hinge_on_the_handles_side", hinges::hinge_on_the_handles_side),
    pitfall("slides_inward", slides::slides_inward),
    pitfall("shown_open", slides::shown_open),
    pitfall("swivel_taken_for_roll", casters::swivel_taken_for_roll),
];

impl Pitfall {
    /// The object of this kind with this index; the design goes by `index % DESIGNS`, all else by both numbers.
    /// Equal arguments give equal bytes.
    ///
    /// # Errors
    /// [`PitfallError`] when the kind's own rules do not make a valid object.
    pub fn make(&self, index: usize, seed: u64) -> Result<Question, PitfallError> {
        let id = format!("{}-{index}", self.name);
        let mut dice = Dice::new(seed, &id);
        let (specimen, condition) = (self.build)(index, &mut dice).finish(id)?;
        Ok(Question { specimen, condition })
    }

    /// Whether a right answer must also lead back to shut, as what is shown open does.
    pub fn leads_back(&self) -> bool {
        self.name == "shown_open"
    }
}

#[cfg(test)]
mod tests {
    use model::Articulation;
    use object::JointKind;
    use object::weld::{Weld, nearest_face};

    use super::*;
    use crate::evaluate::doubts::Judged;
    use crate::evaluate::solver::links;

    fn all(seed: u64) -> impl Iterator<Item = (&'static Pitfall, Question)> {
        const { assert!(PITFALLS.len() * DESIGNS == 40) };
        let kinds = PITFALLS.iter().flat_map(|kind| (0..DESIGNS).map(move |index| (kind, index)));
        kinds.map(move |(kind, index)| (kind, kind.make(index, seed).unwrap()))
    }

    #[test]
    fn the_same_seed_makes_the_same_object_and_another_another() {
        for (kind, one) in all(JUDGED) {
            let (_, index) = one.specimen.id.rsplit_once('-').unwrap();
            let index = index.parse().unwrap();
            let again = kind.make(index, JUDGED).unwrap();
            assert_eq!(
                object::glb::write(one.specimen.object.mesh()),
                object::glb::write(again.specimen.object.mesh())
            );
            assert_eq!(one.condition, again.condition, "{}", one.specimen.id);
            let other = kind.make(index, FITTED).unwrap();
            assert_ne!(one.specimen.object.mesh(), other.specimen.object.mesh());
        }
    }

    #[test]
    fn every_object_has_parts_where_they_are_clicked_and_is_closed() {
        for (_, Question { specimen, condition }) in all(JUDGED).chain(all(FITTED)) {
            let (id, object) = (&specimen.id, &specimen.object);
            assert!(object.tree().len() >= 2 && condition.tree == *object.tree(), "{id}");
            assert_eq!(specimen.wordings.len(), object.tree().len(), "{id}");
            for (part, prompt) in condition.prompts.iter().enumerate() {
                let point = prompt.point.unwrap();
                let (face, off) = nearest_face(object.mesh(), point);
                assert_eq!(usize::from(object.part_of_face()[face]), part, "{id}: {part}");
                assert!(off < 1e-9, "{id}: {off}");
            }
            for part in 1..object.tree().len() {
                let joint = &object.joints(part)[0];
                assert!((joint.axis.length() - 1.0).abs() < 1e-9, "{id}");
                let (lower, upper) = joint.range.ends();
                let is_endless = joint.kind == JointKind::Continuous;
                assert!(
                    is_endless || (lower <= 1e-9 && upper >= -1e-9 && upper - lower > 1e-3),
                    "{id}"
                );
            }
            let weld = Weld::new(object.mesh());
            let mut edges = std::collections::BTreeMap::<[u32; 2], i32>::new();
            for f in &weld.faces {
                for (a, b) in [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])] {
                    *edges.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
                }
            }
            assert!(edges.values().all(|&n| n == 0), "{id}: every edge both ways");
        }
    }

    #[test]
    fn the_truth_is_right_and_one_joint_turned_round_is_not() {
        for (kind, Question { specimen, .. }) in all(JUDGED) {
            let object = &specimen.object;
            let truth = |object: &object::ArticulatedObject| Articulation {
                object: object.clone(),
                part_of_condition: (0..object.tree().len()).map(Some).collect(),
                notes: Vec::new(),
                confidence: None,
            };
            let told = (object.mesh(), object.part_of_face(), &links(&truth(object))[..]);
            let judged = Judged::of(told, &truth(object), kind.leads_back());
            assert!(judged.is_right(), "{}: {judged:?}", specimen.id);
        }
    }

    #[test]
    fn what_is_shown_open_leads_back() {
        let kind = PITFALLS.iter().find(|kind| kind.leads_back()).unwrap();
        for index in 0..DESIGNS {
            let object = kind.make(index, JUDGED).unwrap().specimen.object;
            let mut ends = (1..object.tree().len()).map(|part| object.joints(part)[0].range.ends());
            assert!(ends.any(|(lower, upper)| lower < -0.3 * (upper - lower)), "{index}");
        }
    }
}
