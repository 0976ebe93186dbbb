//! Poses drawn at random, and objects in them.

use object::{ArticulatedObject, Configuration, JointMotion};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

pub use object::posed::{PoseError, posed};

/// A configuration drawn evenly from the range of every joint.
pub fn random_configuration(object: &ArticulatedObject, rng: &mut Pcg64Mcg) -> Configuration {
    let mut value = |motion: &JointMotion| {
        let (lower, upper) = motion.range.ends();
        lower + (upper - lower) * rng.random::<f64>()
    };
    let parts = 0..object.tree().len();
    Configuration(parts.map(|p| object.joints(p).iter().map(&mut value).collect()).collect())
}

/// The object with every part either where it was or, as often, somewhere in its range.
///
/// # Errors
/// [`PoseError`] where it cannot be posed so.
pub fn opened(
    object: &ArticulatedObject,
    rng: &mut Pcg64Mcg,
) -> Result<ArticulatedObject, PoseError> {
    let Configuration(rest) = Configuration::rest(object.tree());
    let Configuration(moved) = random_configuration(object, rng);
    let pairs = rest.into_iter().zip(moved);
    let one = |(rest, moved)| if rng.random::<bool>() { moved } else { rest };
    let some = Configuration(pairs.map(one).collect());
    posed(object, &some)
}

#[cfg(test)]
mod tests {
    use object::Range;
    use rand::SeedableRng;

    use super::*;
    use crate::procedural::FAMILIES;

    /// The fan: a head that tilts, and blades that turn on it.
    fn fan() -> ArticulatedObject {
        FAMILIES.iter().find(|f| f.name == "fan").unwrap().make().unwrap().object
    }

    #[test]
    fn an_object_at_rest_stays_as_it_is() {
        let fan = fan();
        let same = posed(&fan, &Configuration::rest(fan.tree())).unwrap();
        for face in 0..fan.mesh().faces().len() {
            assert_eq!(same.mesh().corners(face), fan.mesh().corners(face));
        }
        assert_eq!(same.joints(2), fan.joints(2));
    }

    #[test]
    fn moving_on_from_a_pose_ends_where_moving_at_once_does() {
        let fan = fan();
        let first = Configuration(vec![vec![], vec![0.25], vec![1.1]]);
        let then = Configuration(vec![vec![], vec![-0.5], vec![0.7]]);
        let sum = Configuration(vec![vec![], vec![-0.25], vec![1.8]]);
        let twice = posed(&posed(&fan, &first).unwrap(), &then).unwrap();
        let once = posed(&fan, &sum).unwrap();
        for face in (0..fan.mesh().faces().len()).step_by(97) {
            let [a, b] = [&twice, &once].map(|o| o.mesh().corners(face)[1]);
            assert!((a - b).length() < 1e-12);
        }
        let Range::Limits { lower, upper } = twice.joints(1)[0].range else { panic!() };
        assert!((lower + 0.15).abs() < 1e-12 && (upper - 0.65).abs() < 1e-12);
    }

    #[test]
    fn a_random_configuration_lies_in_every_range_and_repeats() {
        let fan = fan();
        let draw = |seed| random_configuration(&fan, &mut Pcg64Mcg::seed_from_u64(seed));
        assert_eq!(draw(3), draw(3));
        assert_ne!(draw(3), draw(4));
        assert!(draw(3).0[1][0].abs() <= 0.4);
    }

    #[test]
    fn what_is_opened_is_open_in_part() {
        let fan = fan();
        let stands = |seed| {
            let open = opened(&fan, &mut Pcg64Mcg::seed_from_u64(seed)).unwrap();
            (1..3).map(|part| open.joints(part) == fan.joints(part)).collect::<Vec<_>>()
        };
        let all: Vec<_> = (0..20).map(stands).collect();
        assert!(all.iter().any(|s| s[0]) && all.iter().any(|s| !s[0]), "{all:?}");
    }
}
