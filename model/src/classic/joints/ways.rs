//! Which ways a joint goes from the pose shown, by boosted trees: ahead, back, or both.
//!
//! The three are asked about as one question of three rows. The rows of ahead and back differ by which
//! way round the motion is told, so that nothing is learned of how an axis happens to point.

use crate::classic::joints::features::{NAMES, TOLD};
use crate::classic::joints::motion;
use crate::classic::learned::forest::{Forest, mean_chances};
use crate::classic::lexicon::words::{ROLE_NAMES, ROLES, Role};

/// How many numbers the trees may ask about: whether it goes both ways, those of the axis, of the motion and
/// of the role.
pub const INPUTS: usize = 1 + TOLD + motion::COUNT + ROLES.len();
/// What the trees are told of one answer.
pub type Inputs = [f32; INPUTS];
/// The table of [`names`].
pub const TABLE: &str = "way";
/// The joints that have forests of their own, by what their sections are called.
pub const JOINTS: [&str; 2] = ["slide, ways", "turn, ways"];

/// What the numbers that the trees may ask about are called, in order.
pub fn names() -> Vec<String> {
    let all = ["both"].iter().chain(NAMES.iter().take(TOLD)).chain(&motion::NAMES);
    all.chain(&ROLE_NAMES).map(ToString::to_string).collect()
}

/// The ways a joint may go, in the order of the rows that are asked about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Along the axis alone.
    Ahead,
    /// Against it alone.
    Back,
    /// Along it and against it.
    Both,
}

/// All of them, in order.
pub const WAYS: [Way; 3] = [Way::Ahead, Way::Back, Way::Both];

/// What the trees are told of the three answers, by the features of the axis and of both motions.
pub(crate) fn rows(
    features: &[f64; NAMES.len()],
    told: &[[f64; motion::COUNT]; 2],
    role: Role,
) -> [Inputs; 3] {
    [(0.0, 0), (0.0, 1), (1.0, 0)].map(|(both, way): (f64, usize)| {
        let mut row = [0.0; INPUTS];
        let all = std::iter::once(&both).chain(features.iter().take(TOLD)).chain(&told[way]);
        row.iter_mut().zip(all).for_each(|(to, from)| *to = *from as f32);
        let role = ROLES.iter().position(|&r| r == role).unwrap_or(0);
        row[1 + TOLD + motion::COUNT + role] = 1.0;
        row
    })
}

/// How likely it is that a part goes ahead alone, back alone, and both ways; together 1.
pub(crate) fn way_chances(forests: &[Forest<INPUTS>], rows: &[Inputs; 3]) -> [f64; 3] {
    let chances = mean_chances(forests, rows);
    let mut all = [0.0; 3];
    all.iter_mut().zip(chances).for_each(|(to, chance)| *to = f64::from(chance));
    all
}

/// The likeliest way.
pub fn likeliest_way(chances: &[f64; 3]) -> Way {
    let all = WAYS.into_iter().zip(chances);
    all.reduce(|best, next| if next.1 > best.1 { next } else { best }).map_or(Way::Both, |b| b.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_three_ways_the_likeliest_is_taken_and_the_first_among_equals() {
        assert_eq!(likeliest_way(&[0.2, 0.5, 0.3]), Way::Back);
        assert_eq!(likeliest_way(&[0.4, 0.2, 0.4]), Way::Ahead);
        assert_eq!(likeliest_way(&[0.1, 0.2, 0.7]), Way::Both);
    }

    #[test]
    fn ahead_and_back_are_told_as_each_other_s_mirror_image() {
        let (ahead, back) = ([1.0; motion::COUNT], [2.0; motion::COUNT]);
        let features = [3.0; NAMES.len()];
        let there = rows(&features, &[ahead, back], Role::Door);
        let turned = rows(&features, &[back, ahead], Role::Door);
        assert_eq!((there[0], there[1]), (turned[1], turned[0]));
        assert_eq!((there[0][0], there[2][0]), (0.0, 1.0));
        assert_eq!(names().len(), INPUTS);
    }
}
