//! How far apart two hulls are or how deep inside each other: by iterative search where it proves
//! itself, exactly otherwise.

use glamx::{DPose3, DVec3};
use parry3d_f64::query::epa::EPA;
use parry3d_f64::query::gjk::{CsoPoint, GJKResult, VoronoiSimplex, closest_points};

use super::hull::{Gap, Hull};
use super::sat::widest_gap;

/// Up to this many pairs of edges the exact test is cheaper than the iterative search.
const CHEAP_EDGE_PAIRS: usize = 400;

impl Hull {
    /// Distance or depth between this hull and another whose frame stands at `pose` in this one's.
    /// `guess`: a likely direction from this one to the other, to save time.
    pub fn gap(&self, other: &Self, pose: &DPose3, guess: Option<DVec3>) -> Gap {
        let exact = match (self.round(), other.round()) {
            (Some(mine), Some(theirs)) => Some(mine.gap(theirs, pose)),
            (Some(mine), None) => mine.gap_to(other, pose),
            (None, Some(theirs)) => {
                let seen = theirs.gap_to(self, &pose.inverse());
                seen.map(|g| Gap { normal: pose.rotation * -g.normal, ..g })
            }
            (None, None) => None,
        };
        if let Some(gap) = exact {
            return gap;
        }
        let start = guess.or_else(|| (pose.translation).try_normalize()).unwrap_or(DVec3::X);
        let mut simplex = VoronoiSimplex::new();
        simplex.reset(CsoPoint::from_shapes(pose, self, other, start));
        match closest_points(pose, self, other, f64::MAX, true, &mut simplex) {
            GJKResult::ClosestPoints(a, b, normal) => {
                let (distance, proved) = (a.distance(b), self.gap_along(other, pose, normal));
                let close = distance * (1.0 - 1e-3) - 1e-9 * (self.size() + other.size());
                if proved.distance >= close {
                    return Gap { distance, normal };
                }
            }
            GJKResult::Intersection if self.edge_pairs(other) > CHEAP_EDGE_PAIRS => {
                if let Some(gap) = self.searched_depth(other, pose, &simplex) {
                    return gap;
                }
            }
            _ => {}
        }
        widest_gap(self, other, pose)
    }

    fn edge_pairs(&self, other: &Self) -> usize {
        self.facets().edges.len() * other.facets().edges.len()
    }

    /// The depth by iterative search, if it proves itself: the face it found, which the depth
    /// cannot be less than, is one the hulls can be pushed apart along, which it cannot exceed.
    fn searched_depth(&self, other: &Self, pose: &DPose3, simplex: &VoronoiSimplex) -> Option<Gap> {
        let (a, b, normal) = EPA::new().closest_points(pose, self, other, simplex)?;
        let gaps = [normal, -normal].map(|n| self.gap_along(other, pose, n));
        let best = if gaps[0].distance >= gaps[1].distance { gaps[0] } else { gaps[1] };
        let slack = 1e-3 * a.distance(b) + 1e-9 * (self.size() + other.size());
        (normal.is_finite() && -best.distance <= a.distance(b) + slack).then_some(best)
    }
}
