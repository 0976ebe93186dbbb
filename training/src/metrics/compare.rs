//! A predicted object against the true one, part by part and as a whole, at rest and moved.

use std::collections::BTreeMap;

use object::DPose3;
use object::mesh::Bounds;
use serde::Serialize;

use super::assign::assign;
use super::body::{Body, Drive};
use super::boxes::{MovedBox, around, giou, iou, sampled_giou, thickened, volume};
use super::cloud::{Cloud, chamfer};
use super::{Rules, mean};

/// How close a predicted part is to a true one in one pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Closeness {
    /// Generalised IoU of their boxes, seen from the prediction and from the truth; they differ
    /// under [`Rules::RefCompat`] alone.
    pub giou: [f64; 2],
    /// IoU of the axis-aligned boxes around their points.
    pub iou: f64,
    /// Chamfer distance of their points.
    pub chamfer: f64,
}

/// A predicted part and the true one it goes with.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Matched {
    /// The predicted part.
    pub predicted: u16,
    /// The true part.
    pub truth: u16,
    /// At rest.
    pub rest: Closeness,
    /// In the poses of [`Rules::shares`].
    pub moved: Vec<Closeness>,
}

/// Two objects under one matching of their parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Whose reading.
    pub rules: Rules,
    /// Parts with points in the prediction.
    pub predicted: usize,
    /// Parts with points in the truth.
    pub truth: usize,
    /// Who went with whom.
    pub matched: Vec<Matched>,
    /// What an unmatched part's Chamfer distance counts as: half the prediction's diagonal.
    pub half_diagonal: f64,
    /// Chamfer distance of the whole objects at rest; no column of the paper, so under
    /// [`Rules::RefCompat`] alone.
    pub overall_rest: Option<f64>,
    /// Chamfer distance of the whole objects in the poses of [`Rules::shares`].
    pub overall_moved: Vec<f64>,
}

impl Comparison {
    /// Half the mean of a value over predicted parts plus half that over true parts; an unmatched
    /// part counts as `unmatched`, or not at all. NaN if nothing counts.
    pub fn both_ways(&self, unmatched: Option<f64>, value: impl Fn(&Matched, usize) -> f64) -> f64 {
        let one_way = |way: usize, parts: usize| {
            let missing = unmatched
                .into_iter()
                .flat_map(|v| std::iter::repeat_n(v, parts.saturating_sub(self.matched.len())));
            mean(self.matched.iter().map(|m| value(m, way)).chain(missing)).unwrap_or(f64::NAN)
        };
        (one_way(0, self.predicted) + one_way(1, self.truth)) / 2.0
    }
}

/// Slots of predicted and true parts, each at most once.
pub type Pairing = Vec<(usize, usize)>;

/// A predicted and a true object made ready for comparing; values of pairs are worked out once.
pub struct Comparer {
    rules: Rules,
    seed: u64,
    predicted: Side,
    truth: Side,
    overall_rest: Option<f64>,
    overall_moved: Vec<f64>,
    known: BTreeMap<(usize, usize), (Closeness, Vec<Closeness>)>,
}

struct Side {
    body: Body,
    clouds: Vec<Cloud>,
}

impl Side {
    fn new(body: Body, rules: Rules) -> Self {
        let body = if rules == Rules::Paper { body.with_still_root() } else { body };
        let clouds = Cloud::all_of(&body);
        Self { body, clouds }
    }

    fn whole(&self, share: f64) -> Cloud {
        Cloud::new(0, self.body.moved(Drive::Share(share)))
    }

    fn pose(&self, slot: usize, drive: Drive) -> DPose3 {
        self.body.pose(usize::from(self.clouds[slot].part), drive)
    }

    fn moves(&self, slot: usize) -> bool {
        self.body.moves(usize::from(self.clouds[slot].part))
    }
}

impl Comparer {
    /// Measures the objects as wholes; parts follow when they are asked for. `seed` picks the
    /// points drawn in moved boxes.
    pub fn new(predicted: Body, truth: Body, rules: Rules, seed: u64) -> Self {
        let [predicted, truth] = [predicted, truth].map(|body| Side::new(body, rules));
        let still = DPose3::identity();
        let apart = |a: &Cloud, b: &Cloud| chamfer((a, still), (b, still));
        let at_rest = |side: &Side| Cloud::new(0, side.body.points().to_vec());
        let overall_rest =
            (rules == Rules::RefCompat).then(|| apart(&at_rest(&predicted), &at_rest(&truth)));
        let overall = |&share: &f64| apart(&predicted.whole(share), &truth.whole(share));
        let overall_moved = rules.shares().iter().map(overall).collect();
        let known = BTreeMap::new();
        Self { rules, seed, predicted, truth, overall_rest, overall_moved, known }
    }

    /// Parts of the same number go together.
    pub fn by_number(&self) -> Pairing {
        let slot_of = |part: u16| self.truth.clouds.iter().position(|t| t.part == part);
        let numbered = self.predicted.clouds.iter().enumerate();
        numbered.filter_map(|(slot, p)| Some((slot, slot_of(p.part)?))).collect()
    }

    /// Parts go together so that the distances of their centroids at rest have the least sum.
    pub fn by_centroid(&self) -> Pairing {
        let row =
            |p: &Cloud| self.truth.clouds.iter().map(|t| p.centroid.distance(t.centroid)).collect();
        assign(&self.predicted.clouds.iter().map(row).collect::<Vec<_>>())
    }

    /// Everything there is to say about the objects under a matching.
    pub fn compare(&mut self, pairing: &[(usize, usize)]) -> Comparison {
        let matched = pairing.iter().map(|&pair| self.matched(pair)).collect();
        Comparison {
            rules: self.rules,
            predicted: self.predicted.clouds.len(),
            truth: self.truth.clouds.len(),
            matched,
            half_diagonal: Bounds::of(self.predicted.body.points().iter().copied()).diagonal()
                / 2.0,
            overall_rest: self.overall_rest,
            overall_moved: self.overall_moved.clone(),
        }
    }

    fn matched(&mut self, (p, t): (usize, usize)) -> Matched {
        if !self.known.contains_key(&(p, t)) {
            let still = self.at(p, t, [DPose3::identity(); 2]);
            let moves = self.predicted.moves(p) || self.truth.moves(t);
            let moved = |&share| if moves { self.moved(p, t, share) } else { still };
            let moved = self.rules.shares().iter().map(moved).collect();
            self.known.insert((p, t), (still, moved));
        }
        let (rest, moved) = self.known[&(p, t)].clone();
        let (predicted, truth) = (self.predicted.clouds[p].part, self.truth.clouds[t].part);
        Matched { predicted, truth, rest, moved }
    }

    /// Both parts in their poses, boxes axis-aligned.
    fn at(&self, p: usize, t: usize, [pose_p, pose_t]: [DPose3; 2]) -> Closeness {
        let (a, b) = (&self.predicted.clouds[p], &self.truth.clouds[t]);
        let boxes = [self.solid(a.bounds_at(&pose_p)), self.solid(b.bounds_at(&pose_t))];
        Closeness {
            giou: [giou(&boxes[0], &boxes[1]); 2],
            iou: iou(&boxes[0], &boxes[1]),
            chamfer: chamfer((a, pose_p), (b, pose_t)),
        }
    }

    fn moved(&self, p: usize, t: usize, share: f64) -> Closeness {
        let drive = Drive::Share(share);
        let poses = [self.predicted.pose(p, drive), self.truth.pose(t, drive)];
        let close = self.at(p, t, poses);
        match self.rules {
            Rules::RefCompat if share == 0.0 => close,
            _ => Closeness { giou: self.moved_giou(p, t, poses, share), ..close },
        }
    }

    fn moved_giou(&self, p: usize, t: usize, poses: [DPose3; 2], share: f64) -> [f64; 2] {
        let (a, b) = (&self.predicted.clouds[p], &self.truth.clouds[t]);
        let boxes = [self.solid(a.bounds), self.solid(b.bounds)];
        let seed = self.seed.wrapping_add(u64::from(a.part) << 16 | u64::from(b.part));
        let moved =
            |poses: [DPose3; 2]| [0, 1].map(|i| MovedBox { rest: boxes[i], pose: poses[i] });
        match self.rules {
            Rules::Paper => {
                let [a, b] = moved(poses);
                let whole = volume(&around(&a.bounds(), &b.bounds()));
                [sampled_giou(&a, &b, whole, seed); 2]
            }
            Rules::RefCompat => {
                let drive = Drive::BoxShare(share);
                let [own, other] = [self.predicted.pose(p, drive), self.truth.pose(t, drive)];
                let whole = volume(&around(&boxes[0], &boxes[1]));
                [[own, other], [other, own]].map(|poses| {
                    let [a, b] = moved(poses);
                    sampled_giou(&a, &b, whole, seed)
                })
            }
        }
    }

    /// A box as the rules see it.
    fn solid(&self, bounds: Bounds) -> Bounds {
        match self.rules {
            Rules::Paper => thickened(&bounds),
            Rules::RefCompat => bounds,
        }
    }
}
