//! Siblings of one kind move alike: the drawers of a cabinet all come out of its front, so their
//! joints are chosen together.

use object::{DVec3, JointKind};

use crate::classic::joints::sweep::Axis;
use crate::classic::lexicon::words::Role;

/// How much a part minds its siblings.
const WEIGHT: f64 = 0.6;
/// Support that costs nothing to lack: keeps one odd sibling from forbidding anything.
const DOUBT: f64 = 0.05;
/// Directions are alike within 14°.
const ALIKE: f64 = 0.97;

/// The candidates of one joint with their scores.
#[derive(Clone, Debug)]
pub struct Ballot {
    /// The part.
    pub part: usize,
    /// Which of its joints.
    pub joint: usize,
    /// Its kind.
    pub kind: JointKind,
    /// The role of the part.
    pub role: Role,
    /// The part's text without digits: tells groups of unknown words apart.
    pub stem: String,
    /// Candidates, score first.
    pub axes: Vec<(f64, Axis)>,
}

impl Ballot {
    fn is_like(&self, other: &Self) -> bool {
        let named = self.role != Role::Other || self.stem == other.stem;
        self.part != other.part && self.kind == other.kind && self.role == other.role && named
    }

    /// For each candidate, its direction and its likelihood among the others.
    fn likelihoods(&self) -> Vec<(DVec3, f64)> {
        let best = self.axes.iter().map(|a| a.0).fold(f64::NEG_INFINITY, f64::max);
        let weights: Vec<f64> = self.axes.iter().map(|a| (a.0 - best).exp()).collect();
        let total: f64 = weights.iter().sum();
        self.axes.iter().zip(weights).map(|(a, w)| (a.1.direction, w / total)).collect()
    }
}

/// The ballots of one parent's children after each has heard its siblings.
pub fn vote(ballots: &[Ballot]) -> Vec<Ballot> {
    let likely: Vec<_> = ballots.iter().map(Ballot::likelihoods).collect();
    let heard = |ballot: &Ballot| {
        let alike = ballots.iter().zip(&likely).filter(|(other, _)| ballot.is_like(other));
        let siblings: Vec<_> = alike.map(|(_, l)| l).collect();
        let share = WEIGHT / (siblings.len().max(1) as f64).sqrt();
        let support = |d: DVec3| {
            let of = |l: &Vec<(DVec3, f64)>| {
                let near = l.iter().filter(|(e, _)| e.dot(d).abs() > ALIKE);
                (DOUBT + near.map(|(_, p)| p).sum::<f64>()).ln()
            };
            siblings.iter().map(|l| of(l)).sum::<f64>()
        };
        let axes = ballot.axes.iter().map(|(s, a)| (s + share * support(a.direction), *a));
        Ballot { axes: axes.collect(), ..ballot.clone() }
    };
    ballots.iter().map(heard).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawer(part: usize, along_x: f64, along_y: f64) -> Ballot {
        let axis = |direction| Axis { direction, pivot: DVec3::ZERO, turns: false };
        let axes = vec![(along_x, axis(DVec3::X)), (along_y, axis(DVec3::Y))];
        let (kind, role) = (JointKind::Prismatic, Role::Drawer);
        Ballot { part, joint: 0, kind, role, stem: String::new(), axes }
    }

    #[test]
    fn an_undecided_drawer_follows_its_siblings() {
        let ballots = [drawer(1, 0.1, 0.0), drawer(2, 0.0, 5.0), drawer(3, 0.0, 5.0)];
        let heard = vote(&ballots);
        assert!(heard[0].axes[1].0 > heard[0].axes[0].0);
    }

    #[test]
    fn a_part_alone_keeps_its_scores() {
        let mut knob = drawer(2, 0.0, 5.0);
        knob.role = Role::Knob;
        let heard = vote(&[drawer(1, 0.1, 0.0), knob]);
        assert_eq!(heard[0].axes, [drawer(1, 0.1, 0.0).axes[0], drawer(1, 0.1, 0.0).axes[1]]);
    }
}
