//! Which rules are asked of an object, and which of a robot.
//!
//! The profile was written for assets: things that rest on the floor, carry labels and open by
//! hand. Of a robot some of its rules are not asked at all, and some tell its owner what to look at
//! and no more.

use crate::profile::subject::Subject;

/// How much a rule counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Due {
    /// As the profile has it.
    Full,
    /// Failing it is told and lowers no tier.
    Flag,
    /// It is not asked.
    Not,
}

/// Rules that are not asked of a robot: it need not rest on the floor, wear labels, have axes along
/// its edges or stand without its drives.
const NOT: [&str; 7] = ["U3", "L1", "L2", "J6", "J7", "C5", "S2"];
/// Rules that a robot's owner may have good reasons to break: a mesh with a scale, a concave or
/// coarse collision mesh, an arm that can reach itself.
const FLAGS: [&str; 16] = [
    "T3", "U1", "U2", "G1", "G2", "G3", "G4", "M2", "M6", "J1", "J3", "J4", "C2", "C3", "C4", "S3",
];

/// How much a rule counts of what is judged.
pub fn asked_of(id: &str, subject: Subject) -> Due {
    match subject {
        Subject::Object => Due::Full,
        Subject::Robot if NOT.contains(&id) => Due::Not,
        Subject::Robot if FLAGS.contains(&id) => Due::Flag,
        Subject::Robot => Due::Full,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::RULES;

    #[test]
    fn a_rule_that_counts_less_of_robots_is_one_of_the_profile() {
        let known = |id: &str| RULES.iter().any(|r| r.id == id);
        assert!(NOT.iter().chain(&FLAGS).all(|id| known(id)));
        assert!(RULES.iter().all(|r| asked_of(r.id, Subject::Object) == Due::Full));
        assert!(
            ["F1", "T1", "M1", "M3", "M4", "J2", "C1", "S1"]
                .iter()
                .all(|id| asked_of(id, Subject::Robot) == Due::Full)
        );
    }
}
