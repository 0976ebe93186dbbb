//! Objects as they are asked about: in segments, with their truth.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

use model::classic::segment::Way;
use model::classic::segment::classify::{Layout, Probabilities};
use model::classic::segment::{label_faces, layout};
use object::condition::Prompt;
use object::origin::Origin;
use object::weld::Weld;
use object::{ArticulatedObject, Condition, DQuat};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::super::Watcher;
use super::ensemble::Ensemble;
use super::iou::mean_iou;
use crate::dataset::cut::cut_up;
use crate::dataset::pose::opened;
use crate::dataset::{Specimen, any_face, middle_face};
use crate::forest::left_out_fold;
use crate::fuse::{Recipe, fused};

/// The number of the draw that says how objects are posed.
const POSED: u64 = 1000;
/// The number of the first draw that says how objects are cut up.
const CUT: u64 = 2000;

/// An object in segments, with its truth.
pub(super) struct Case {
    /// Of its object the how many-th draw it is.
    pub draw: u64,
    /// The fold that is not fitted to it.
    pub fold: usize,
    pub layout: Layout,
    /// For each segment, the area of each part in it, as a share of the whole surface.
    pub votes: Vec<BTreeMap<usize, f64>>,
    pub parts: usize,
    /// Mean IoU over parts of the labels by merging; 0 for what is learned from.
    pub merged: f64,
    /// How likely each part is at each segment, as last asked.
    pub probabilities: Probabilities,
}

impl Case {
    /// All segments with those they share most with.
    pub(super) fn truth(&self) -> Probabilities {
        let row = |votes: &BTreeMap<usize, f64>| {
            (0..self.parts).map(|p| votes.get(&p).copied().unwrap_or(0.0) as f32).collect()
        };
        self.votes.iter().map(row).collect()
    }
}

/// How objects are seen.
pub(super) struct Seen<'a> {
    pub ensemble: &'a Ensemble,
    pub draws: u64,
    /// Whether they are judged by, not learned from.
    pub is_judged: bool,
    pub watcher: &'a dyn Watcher,
}

impl Seen<'_> {
    /// The object as it is, or fused in every way that is asked for, each with points drawn anew.
    pub(super) fn cases(&self, specimen: &Specimen) -> Vec<Case> {
        let drawn = |object: &ArticulatedObject, number| {
            self.case(object, &Draw::of(&specimen.id, number), &specimen.id)
        };
        if self.ensemble.fused.is_empty() {
            let whole = (0..self.draws).filter_map(|d| drawn(&specimen.object, d));
            let cut = (0..self.ensemble.cut).filter_map(|d| {
                let mut draw = Draw::of(&specimen.id, CUT + d);
                let cut = cut_up(&specimen.object, &mut draw.dice);
                let cut = cut.inspect_err(|e| self.left_out(&specimen.id, "cut up", e)).ok()?;
                drawn(&cut, self.draws + d)
            });
            return whole.chain(cut).collect();
        }
        let posed = match self.ensemble.posed.then(|| Draw::of(&specimen.id, POSED)) {
            None => None,
            Some(mut draw) => match opened(&specimen.object, &mut draw.dice) {
                Ok(object) => Some(Specimen { object, ..specimen.clone() }),
                Err(e) => {
                    self.left_out(&specimen.id, "posed", &e);
                    return Vec::new();
                }
            },
        };
        let specimen = posed.as_ref().unwrap_or(specimen);
        let ways = self.ensemble.fused.len() as u64;
        // As drawn first every one has its points in the middle, and every other one is seen from behind.
        let number = |way: u64, draw: u64| 2 * (way + draw / 2 * ways) + draw % 2;
        let one = |(way, recipe): (u64, &Recipe)| match fused(specimen, recipe) {
            Ok(found) if self.is_judged => (0..2).filter_map(|d| drawn(&found.object, d)).collect(),
            Ok(found) => {
                let draws = (0..self.draws).map(|d| number(way, d));
                draws.filter_map(|d| drawn(&found.object, d)).collect()
            }
            Err(e) => {
                self.left_out(&specimen.id, &format!("fused over {} cells", recipe.cells), &e);
                Vec::new()
            }
        };
        (0..).zip(&self.ensemble.fused).flat_map(one).collect()
    }

    fn left_out(&self, id: &str, how: &str, why: &dyn std::error::Error) {
        self.watcher.say(&format!("{id}, {how}, is left out: {why}"));
    }

    /// The object with a point on each part, turned by a quarter for each draw: what is front is not
    /// known. Every other draw takes the face nearest the middle of the part's surface, as one does who
    /// knows the part; the others any place on it, as one does who clicks.
    fn case(&self, object: &ArticulatedObject, draw: &Draw, id: &str) -> Option<Case> {
        let turn = DQuat::from_rotation_z(FRAC_PI_2 * draw.number as f64);
        let mesh = &object.mesh().map_vertices(|v| turn * v).ok()?;
        let mut dice = draw.dice.clone();
        let clicks = (!draw.number.is_multiple_of(2)).then_some(&mut dice);
        let condition = &prompted((object, mesh), "", clicks);
        let weld = Weld::new(mesh);
        let (segment_of_face, layout) = layout(mesh, condition, &weld);
        let parts = object.tree().len();
        let total: f64 = (0..segment_of_face.len()).map(|f| mesh.area(f)).sum();
        let truth = |face: usize| usize::from(object.part_of_face()[face]);
        let mut votes = vec![BTreeMap::new(); layout.len()];
        for (face, &segment) in segment_of_face.iter().enumerate() {
            *votes[segment as usize].entry(truth(face)).or_insert(0.0) += mesh.area(face) / total;
        }
        let mut merged = 0.0;
        if self.is_judged {
            let found = label_faces(mesh, condition, &weld, Way::Merging).part_of_face;
            let mut crossed = vec![vec![0.0; parts]; parts];
            for (face, &found) in found.iter().enumerate() {
                crossed[truth(face)][usize::from(found)] += mesh.area(face) / total;
            }
            merged = mean_iou(&crossed);
        }
        let (probabilities, fold) = (layout.first(), left_out_fold(id, self.ensemble.folds));
        Some(Case { draw: draw.number, fold, layout, votes, parts, merged, probabilities })
    }
}

/// An object's words and tree, with a point on every part of it as it stands in a mesh: in the middle of
/// the part's surface, or, with dice, anywhere on it.
pub(in super::super) fn prompted(
    (object, mesh): (&ArticulatedObject, &object::Mesh),
    category: &str,
    mut dice: Option<&mut Pcg64Mcg>,
) -> Condition {
    let mut prompts = Vec::new();
    for part in 0..object.tree().len() {
        let faces: Vec<usize> = object.faces_of(part).collect();
        let face = match &mut dice {
            None => middle_face(mesh, &faces),
            Some(dice) => any_face(mesh, &faces, dice),
        };
        prompts.push(Prompt { point: face.map(|f| mesh.centroid(f)), ..Prompt::default() });
    }
    let condition = Condition::of_tree(category, object.tree().clone(), Origin::User);
    Condition { prompts, ..condition }
}

/// How an object is seen once.
pub(in super::super) struct Draw {
    pub number: u64,
    pub dice: Pcg64Mcg,
}

impl Draw {
    pub(in super::super) fn of(id: &str, number: u64) -> Self {
        let own = blake3::hash(id.as_bytes());
        let seed = own
            .as_bytes()
            .iter()
            .take(7)
            .fold(number, |seed, &byte| seed.wrapping_mul(251) + u64::from(byte));
        Self { number, dice: Pcg64Mcg::seed_from_u64(seed) }
    }
}
