//! Objects as they are articulated, beside the truth.

use model::classic::confidence::{Evidence, FOLDS, PART_INPUTS};
use model::{Articulation, Prepared};
use object::ArticulatedObject;
use serde::{Deserialize, Serialize};

use super::super::Watcher;
use super::super::data::Subject;
use super::super::segments::{Draw, prompted};
use crate::dataset::cut::cut_up;
use crate::dataset::pose::opened;
use crate::evaluate::outcome::Outcome;
use crate::evaluate::solver::links;
use crate::forest::left_out_fold;
use crate::fuse::{Recipe, fused};

/// The seed of articulators.
const SEED: u64 = 0;
/// The number of the first draw: no other fit sees objects so.
const FIRST: u64 = 3000;
/// The number of the draw that says how objects are cut up and opened.
const ALTERED: u64 = 4000;

/// How an object is seen.
pub(super) const SIGHTS: [&str; 4] = ["as they are", "fused", "cut up", "half open"];
const WHOLE: usize = 0;
const FUSED: usize = 1;
const CUT: usize = 2;
const HALF_OPEN: usize = 3;

/// How often objects are seen, and how fused.
pub(super) struct How<'a> {
    pub draws: u64,
    pub fused: &'a [Recipe],
}

/// What became of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Fate {
    pub axis: bool,
    /// None of a slide.
    pub line: Option<bool>,
    pub joint: bool,
}

impl Fate {
    /// Whether it goes the right way; none of what has no ends, or whose axis is wrong.
    pub(super) fn way(&self, is_endless: bool) -> Option<bool> {
        let is_found = self.axis && self.line.unwrap_or(true);
        (is_found && !is_endless).then_some(self.joint)
    }
}

/// An object that was articulated once.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Seen {
    /// The fold that does not know it.
    pub fold: usize,
    /// Which of [`SIGHTS`].
    pub sight: usize,
    pub is_own: bool,
    /// For each part that was found, what the trees may ask.
    pub parts: Vec<Vec<f32>>,
    pub is_part_right: Vec<bool>,
    /// For each joint, part by part, what the trees may ask.
    pub joints: Vec<Vec<f32>>,
    pub outcomes: Vec<Fate>,
    /// The part that each joint moves.
    pub moves: Vec<usize>,
    /// [`Evidence::kinds`].
    pub kinds: Vec<usize>,
    /// Whether everything is.
    pub is_right: bool,
    pub fused: f32,
}

impl Seen {
    /// What is said of the object itself.
    pub(super) fn evidence(&self) -> Evidence {
        Evidence { fused: self.fused, kinds: self.kinds.clone(), ..Evidence::default() }
    }
}

/// An object in all of [`SIGHTS`], several times each; as its bodies come in pieces and as it is half open
/// once.
pub(super) fn seen(
    subject: &Subject,
    is_own: bool,
    how: &How<'_>,
    watcher: &dyn Watcher,
) -> Vec<Seen> {
    let Subject { specimen, category } = subject;
    let mut all = Vec::new();
    let mut number = FIRST;
    let mut look = |sight: usize, object: Option<&ArticulatedObject>, draws: u64| {
        for _ in 0..draws {
            let draw = Draw::of(&specimen.id, number);
            number += 1;
            let seen = object.and_then(|object| once((object, category), draw));
            match seen {
                Some(seen) => {
                    let fold = left_out_fold(&specimen.id, FOLDS);
                    all.push(Seen { fold, sight, is_own, ..seen });
                }
                None => watcher.say(&format!("{}, {}, is left out", specimen.id, SIGHTS[sight])),
            }
        }
    };
    look(WHOLE, Some(&specimen.object), how.draws);
    for recipe in how.fused {
        let fused = fused(specimen, recipe).ok().map(|s| s.object);
        look(FUSED, fused.as_ref(), how.draws);
    }
    let mut dice = Draw::of(&specimen.id, ALTERED).dice;
    let cut = cut_up(&specimen.object, &mut dice).ok();
    look(CUT, cut.as_ref(), 1);
    let half_open = opened(&specimen.object, &mut dice).ok();
    look(HALF_OPEN, half_open.as_ref(), 1);
    all
}

fn once((object, category): (&ArticulatedObject, &str), mut draw: Draw) -> Option<Seen> {
    let clicks = (!draw.number.is_multiple_of(2)).then_some(&mut draw.dice);
    let condition = prompted((object, object.mesh()), category, clicks);
    let (made, evidence) = Prepared::new(object.mesh()).ok()?.evidence(&condition, SEED).ok()?;
    Some(compared(object, &made, &evidence))
}

fn compared(truth: &ArticulatedObject, made: &Articulation, evidence: &Evidence) -> Seen {
    let part_of_condition = (0..truth.tree().len()).map(Some).collect();
    let (object, notes) = (truth.clone(), Vec::new());
    let links = links(&Articulation { object, part_of_condition, notes, confidence: None });
    let outcome = Outcome::of((truth.mesh(), truth.part_of_face(), &links), made);
    let place = |part: usize| made.part_of_condition.iter().position(|p| *p == Some(part));
    let places: Vec<usize> = (0..made.object.tree().len()).filter_map(place).collect();
    let (mut rows, mut outcomes, mut moves) = (Vec::new(), Vec::new(), Vec::new());
    for (part, &place) in places.iter().enumerate() {
        let of_part = outcome.joints.iter().filter(|j| usize::from(j.part) == place);
        for (row, joint) in evidence.joints[part].iter().zip(of_part) {
            rows.push(row.to_vec());
            moves.push(part);
            outcomes.push(Fate {
                axis: joint.is_near(),
                line: joint.line.map(|_| joint.is_found()),
                joint: joint.is_right(),
            });
        }
    }
    Seen {
        fold: 0,
        sight: 0,
        is_own: false,
        parts: evidence.parts.iter().map(|row: &[f32; PART_INPUTS]| row.to_vec()).collect(),
        is_part_right: places.iter().map(|&place| outcome.is_part_right(place)).collect(),
        joints: rows,
        outcomes,
        moves,
        kinds: evidence.kinds.clone(),
        is_right: outcome.is_right(),
        fused: evidence.fused,
    }
}
