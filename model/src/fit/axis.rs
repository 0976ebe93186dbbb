//! One axis from many votes: the mean direction and the mean point (paper, appendix, inference).

use object::DVec3;

/// Votes whose mean direction is shorter than this share of their mean length cancel out.
const LEAST_AGREEMENT: f64 = 1e-3;

/// A line with a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// Unit direction.
    pub direction: DVec3,
    /// A point on it.
    pub pivot: DVec3,
}

/// The axis that votes (direction, nearest point of the axis) agree on; `None` without votes and
/// where their directions cancel out.
pub fn fit_axis(votes: impl Iterator<Item = (DVec3, DVec3)>) -> Option<Axis> {
    let (mut direction, mut pivot, mut length, mut count) = (DVec3::ZERO, DVec3::ZERO, 0.0, 0.0);
    for (d, c) in votes {
        direction += d;
        pivot += c;
        length += d.length();
        count += 1.0;
    }
    let agree = count > 0.0 && length > 0.0 && direction.length() > LEAST_AGREEMENT * length;
    agree.then(|| Axis { direction: direction.normalize(), pivot: pivot / count })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn votes_on_one_axis_give_that_axis() {
        let d = DVec3::new(0.0, 0.6, 0.8);
        let vote = |i: i32| (d * (1.0 + 0.1 * f64::from(i)), DVec3::X + d * f64::from(i));
        let axis = fit_axis((-3..=3).map(vote)).unwrap();
        assert!((axis.direction - d).length() < 1e-14);
        assert!((axis.pivot - DVec3::X).length() < 1e-14);
    }

    #[test]
    fn no_votes_and_opposite_votes_give_no_axis() {
        assert_eq!(fit_axis(std::iter::empty()), None);
        let both = [(DVec3::Z, DVec3::ZERO), (-DVec3::Z, DVec3::ZERO)];
        assert_eq!(fit_axis(both.into_iter()), None);
    }
}
