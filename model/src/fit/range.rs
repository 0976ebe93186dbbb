//! How far a joint moves, from where each point says it stands at the two limits.
//!
//! Minimises Σ ‖q± − F(q, a, θ±)‖ (not squared; paper, appendix): the squared problem has a closed
//! form, and a few reweighted rounds of that form reach the unsquared one.

use std::f64::consts::TAU;

use object::DVec3;

use super::axis::Axis;

/// Rounds of reweighting, and the smallest residual that still weighs (share of the mean radius or
/// travel).
const ROUNDS: usize = 20;
const LEAST_RESIDUAL: f64 = 1e-9;
/// A limit on the wrong side of rest by less than this is noise about zero; by more, it went round.
const SLACK: f64 = 0.35;
/// A turn that comes this close to a full one cannot be told from it.
const FULL_TURN_SLACK: f64 = 0.1;

/// Where one point stands at rest, at the lower and at the upper limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Displacement {
    /// At rest.
    pub rest: DVec3,
    /// At the lower limit.
    pub lower: DVec3,
    /// At the upper limit.
    pub upper: DVec3,
}

/// How far a joint moves from rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bounds {
    /// Radians or lengths, lower ≤ 0 ≤ upper.
    Limits {
        /// Lower end.
        lower: f64,
        /// Upper end.
        upper: f64,
    },
    /// A full turn or more, whose ends cannot be told apart.
    FullTurn,
}

/// Range of a slide along `axis`, in the unit of the points; `None` without points.
pub fn slide_bounds(axis: Axis, points: &[Displacement]) -> Option<Bounds> {
    let travel = |to: &dyn Fn(&Displacement) -> DVec3| {
        let moves: Vec<DVec3> = points.iter().map(|p| to(p) - p.rest).collect();
        let closed = |w: &[f64]| {
            let sum: f64 = moves.iter().zip(w).map(|(m, w)| w * m.dot(axis.direction)).sum();
            sum / w.iter().sum::<f64>()
        };
        let residual = |t: f64, i: usize| (moves[i] - axis.direction * t).length();
        reweighted(points.len(), &closed, &residual)
    };
    let (a, b) = (travel(&|p| p.lower)?, travel(&|p| p.upper)?);
    Some(Bounds::Limits { lower: a.min(b).min(0.0), upper: a.max(b).max(0.0) })
}

/// Range of a turn about `axis`, radians; `None` without points off the axis.
pub fn turn_bounds(axis: Axis, points: &[Displacement]) -> Option<Bounds> {
    let angle = |to: &dyn Fn(&Displacement) -> DVec3| {
        let pairs: Vec<_> = points.iter().map(|p| (arm(axis, p.rest), arm(axis, to(p)))).collect();
        let closed = |w: &[f64]| {
            let (mut sine, mut cosine) = (0.0, 0.0);
            for ((from, to), w) in pairs.iter().zip(w) {
                sine += w * axis.direction.dot(from.cross(*to));
                cosine += w * from.dot(*to);
            }
            if sine == 0.0 && cosine == 0.0 { f64::NAN } else { sine.atan2(cosine) }
        };
        let residual =
            |t: f64, i: usize| (pairs[i].1 - turned(axis.direction, pairs[i].0, t)).length();
        reweighted(points.len(), &closed, &residual)
    };
    let lower = -unwrap(-angle(&|p| p.lower)?);
    let upper = unwrap(angle(&|p| p.upper)?);
    if upper - lower >= TAU - FULL_TURN_SLACK {
        return Some(Bounds::FullTurn);
    }
    Some(Bounds::Limits { lower, upper })
}

/// From the axis to a point, at right angles to it.
fn arm(axis: Axis, p: DVec3) -> DVec3 {
    (p - axis.pivot).reject_from_normalized(axis.direction)
}

/// A vector at right angles to `direction`, turned about it.
fn turned(direction: DVec3, arm: DVec3, angle: f64) -> DVec3 {
    arm * angle.cos() + direction.cross(arm) * angle.sin()
}

/// An upper limit from an angle in (−π, π]: not below rest, and round where it seems to be.
fn unwrap(angle: f64) -> f64 {
    if angle >= 0.0 {
        angle
    } else if angle > -SLACK {
        0.0
    } else {
        angle + TAU
    }
}

/// Minimises Σ residual by iteratively reweighted closed forms; `None` if there is nothing to fit.
fn reweighted(
    count: usize,
    closed: &dyn Fn(&[f64]) -> f64,
    residual: &dyn Fn(f64, usize) -> f64,
) -> Option<f64> {
    let mut weights = vec![1.0; count];
    let mut value = closed(&weights);
    for _ in 0..ROUNDS {
        for (i, w) in weights.iter_mut().enumerate() {
            *w = 1.0 / residual(value, i).max(LEAST_RESIDUAL);
        }
        let next = closed(&weights);
        let settled = (next - value).abs() < 1e-12;
        value = next;
        if settled {
            break;
        }
    }
    (count > 0 && value.is_finite()).then_some(value)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use object::pose::turn_about;

    use super::*;

    fn axis() -> Axis {
        Axis { direction: DVec3::new(0.48, 0.6, 0.64), pivot: DVec3::new(0.1, -0.2, 0.3) }
    }

    fn rest(i: i32) -> DVec3 {
        let t = f64::from(i);
        DVec3::new((1.7 * t).sin(), (2.3 * t).cos(), (0.9 * t).sin()) * 0.4
    }

    fn turns(lower: f64, upper: f64) -> Vec<Displacement> {
        let at = |angle: f64, p: DVec3| turn_about(axis().direction, axis().pivot, angle) * p;
        let one = |i| Displacement {
            rest: rest(i),
            lower: at(lower, rest(i)),
            upper: at(upper, rest(i)),
        };
        (0..13).map(one).collect()
    }

    fn ends(bounds: Option<Bounds>) -> (f64, f64) {
        match bounds {
            Some(Bounds::Limits { lower, upper }) => (lower, upper),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_known_turn_comes_back() {
        for (lower, upper) in [(-0.3, 1.2), (0.0, 3.0), (-2.9, 0.0), (-1.0, 4.0), (-4.5, 0.5)] {
            let found = ends(turn_bounds(axis(), &turns(lower, upper)));
            assert!((found.0 - lower).abs() < 1e-6 && (found.1 - upper).abs() < 1e-6, "{found:?}");
        }
    }

    #[test]
    fn a_known_slide_comes_back_even_with_one_liar() {
        let d = axis().direction;
        let one =
            |i| Displacement { rest: rest(i), lower: rest(i) - d * 0.1, upper: rest(i) + d * 0.7 };
        let mut points: Vec<_> = (0..13).map(one).collect();
        let found = ends(slide_bounds(axis(), &points));
        assert!((found.0 + 0.1).abs() < 1e-6 && (found.1 - 0.7).abs() < 1e-6);
        points[4].upper = DVec3::new(5.0, 5.0, 5.0);
        let (_, upper) = ends(slide_bounds(axis(), &points));
        assert!((upper - 0.7).abs() < 1e-6, "the unsquared norm does not follow it: {upper}");
    }

    #[test]
    fn full_turns_are_told_and_noise_about_rest_is_rest() {
        assert_eq!(turn_bounds(axis(), &turns(-PI, PI)), Some(Bounds::FullTurn));
        let (lower, upper) = ends(turn_bounds(axis(), &turns(0.05, 1.0)));
        assert_eq!(lower, 0.0);
        assert!((upper - 1.0).abs() < 1e-6);
    }

    #[test]
    fn nothing_to_fit_is_unknown() {
        assert_eq!(turn_bounds(axis(), &[]), None);
        assert_eq!(slide_bounds(axis(), &[]), None);
        let on_axis = Displacement { rest: axis().pivot, lower: axis().pivot, upper: axis().pivot };
        assert_eq!(turn_bounds(axis(), &[on_axis]), None);
    }
}
