//! How far apart two hulls are or how deep inside each other: by iterative search where it proves
//! itself, exactly otherwise.

use glamx::{DPose3, DVec3};
use parry3d_f64::query::gjk::{CsoPoint, GJKResult, VoronoiSimplex, closest_points};

use super::expand;
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
            GJKResult::Intersection if !self.is_cheap(other) => {
                if let Some(gap) = expand::depth(self, other, pose) {
                    return gap;
                }
            }
            _ => {}
        }
        widest_gap(self, other, pose)
    }

    /// Whether the exact test is the quicker one. Without its faces, of a hull that no builder
    /// could make, it would know no way out but those along the axes.
    fn is_cheap(&self, other: &Self) -> bool {
        let edges = [self, other].map(|hull| hull.facets().edges.len());
        edges.iter().all(|&count| count > 0) && edges[0] * edges[1] <= CHEAP_EDGE_PAIRS
    }
}
