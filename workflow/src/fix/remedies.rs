//! What `kinfold fix` mends, rule by rule, and by what change. What is not in this table is told and
//! left to a person.

use sim_check::{Check, Severity, Status, Verdict};

/// A way of mending, the smallest change first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Way {
    /// An axis is divided by its length.
    Unit,
    /// Two limits change places.
    Swap,
    /// Limits in degrees become radians.
    Degrees,
    /// A centre of mass goes to the centre of the shape.
    Centre,
    /// Inertia is computed from the shape and the mass that is told.
    Inertia,
    /// Mass and inertia are computed from the shape and a density.
    Weight,
    /// Faces of a mesh are turned round, in a file of its own.
    Turn,
    /// What is seen gets collision geometry.
    Touch,
    /// A collision piece gives way to convex ones.
    Split,
    /// The pieces of a link give way to convex ones made of what is seen.
    Cover,
    /// An axis points the other way.
    Flip,
    /// A range ends before parts meet.
    Clamp,
    /// A pivot goes to where its parts are.
    Pivot,
}

/// What one way mends.
#[derive(Clone, Copy, Debug)]
pub struct Remedy {
    /// The way.
    pub way: Way,
    /// The rules it serves.
    pub rules: &'static [&'static str],
    /// What was found, in words.
    pub found: &'static str,
    /// What is changed, in words.
    pub change: &'static str,
    /// What a finding of these rules says where this way is for it; any where there is nothing.
    says: &'static [(&'static str, &'static str)],
}

/// Every way, in the order in which they are tried.
pub const REMEDIES: [Remedy; 13] = [
    Remedy {
        way: Way::Unit,
        rules: &["J1"],
        found: "an axis whose length is neither 1 nor 0",
        change: "the axis is divided by its length",
        says: &[("J1", "has length")],
    },
    Remedy {
        way: Way::Swap,
        rules: &["J2"],
        found: "a lower limit above the upper one",
        change: "the two change places",
        says: &[("J2", "are not ordered")],
    },
    Remedy {
        way: Way::Degrees,
        rules: &["J3"],
        found: "limits in degrees where radians are due: beyond two turns, and within one turn if read so",
        change: "both are converted to radians",
        says: &[("J3", "degrees written as radians?")],
    },
    Remedy {
        way: Way::Centre,
        rules: &["M5"],
        found: "a centre of mass outside its part",
        change: "it goes to the centre of the part's shape",
        says: &[("M5", "outside its hull")],
    },
    Remedy {
        way: Way::Inertia,
        rules: &["M3", "M4"],
        found: "an inertia that no body has, or that is another body's",
        change: "it is computed from the part's shape and its mass",
        says: &[("M3", "principal moments"), ("M4", "principal moments")],
    },
    Remedy {
        way: Way::Weight,
        rules: &["M1", "M3"],
        found: "a link that moves without <inertial>, or with a mass of 0 or less",
        change: "mass, centre and inertia are computed from its shape; the density is that of the other links, or a guess; a frame without shape that weighs 0 loses its <inertial>",
        says: &[("M1", ""), ("M3", "principal moments 0, 0, 0")],
    },
    Remedy {
        way: Way::Turn,
        rules: &["G1", "G2"],
        found: "faces of an OBJ or STL file that look inward, or against each other",
        change: "a copy of the file has them turned round",
        says: &[
            ("G1", "faces inward"),
            ("G1", "wound against"),
            ("G2", "faces inward"),
            ("G2", "edges clash"),
        ],
    },
    Remedy {
        way: Way::Touch,
        rules: &["G3", "G2", "C1"],
        found: "a link that is seen and cannot be touched",
        change: "it gets the same primitives, or convex pieces of its mesh, as <collision>",
        says: &[
            ("G3", "collision geometry"),
            ("G2", "no link has collision geometry"),
            ("C1", "no collision geometry"),
            ("C1", "no collider"),
        ],
    },
    Remedy {
        way: Way::Split,
        rules: &["G2"],
        found: "a collision mesh that is not convex, not closed or has too many vertices",
        change: "convex pieces take its place",
        says: &[
            ("G2", "is not convex"),
            ("G2", "is open"),
            ("G2", "is not closed"),
            ("G2", " vertices"),
            ("G2", "faces inward"),
        ],
    },
    Remedy {
        way: Way::Cover,
        rules: &["G3"],
        found: "collision geometry that stands off what is seen, or fills its cavity",
        change: "convex pieces of what is seen take its place",
        says: &[("G3", "leaves"), ("G3", "fills empty space")],
    },
    Remedy {
        way: Way::Flip,
        rules: &["C5", "C2"],
        found: "a joint that opens into another part and is free the other way",
        change: "its axis points the other way",
        says: &[("C5", "is free for")],
    },
    Remedy {
        way: Way::Clamp,
        rules: &["C2", "S3"],
        found: "a range along which parts meet that are apart at rest, of a joint with limits that no other follows",
        change: "the range ends before they meet",
        says: &[("C2", "overlap by"), ("S3", "of its range")],
    },
    Remedy {
        way: Way::Pivot,
        rules: &["J5"],
        found: "a joint that turns about a line apart from its parts, which themselves are near each other",
        change: "its pivot goes to the edge of the part that is nearest; nothing moves at rest",
        says: &[("J5", "its axis passes")],
    },
];

impl Way {
    /// What it mends.
    pub fn remedy(self) -> &'static Remedy {
        // Every way stands in the table: a test looks.
        REMEDIES.iter().find(|r| r.way == self).unwrap_or(&REMEDIES[0])
    }
}

impl Remedy {
    /// Whether a finding of a rule is of the kind that this way is for.
    pub fn is_for(&self, rule: &str, finding: &str) -> bool {
        self.says.iter().any(|(id, words)| *id == rule && finding.contains(words))
    }

    /// Whether it can be mended so, as far as its figures tell.
    fn can(&self, rule: &str, finding: &str) -> bool {
        let number = |before: &str| -> Option<f64> {
            finding.rsplit_once(before)?.1.split(' ').next()?.parse().ok()
        };
        match self.way {
            Way::Unit => number("has length ") != Some(0.0),
            Way::Swap => number("limits ").zip(number(" to ")).is_none_or(|(low, up)| low > up),
            // Findings tell four digits.
            Way::Degrees => number("turns ").is_none_or(|span| span > 1.001 * NO_RADIANS),
            // What covers less is stuck, and no range helps it.
            Way::Clamp if rule == "S3" => number("covers ").is_some_and(|percent| percent >= 50.0),
            _ => true,
        }
    }
}

/// Ends beyond this are degrees: two turns, radians. Wrists of arms turn once each way, and no arm we
/// know of more than twice; a guess.
pub const NO_RADIANS: f64 = 4.0 * std::f64::consts::PI;

/// Whether something of this kind is mended at all.
pub fn is_mendable(rule: &str, finding: &str) -> bool {
    REMEDIES.iter().any(|r| r.is_for(rule, finding) && r.can(rule, finding))
}

/// What a person wants mended.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// These rules alone, warnings of theirs too; every rule where there is none.
    pub only: Vec<String>,
    /// Warnings, too.
    pub flags: bool,
}

impl Wanted {
    /// Whether what a check found is to be mended.
    pub fn wants(&self, check: &Check) -> bool {
        let named = self.only.contains(&check.id);
        let counts = check.severity == Severity::Error || self.flags || named;
        let open = matches!(check.status, Status::Fail | Status::Unknown);
        (self.only.is_empty() || named) && counts && open && check.waived.is_none()
    }

    /// The findings of a verdict that a way is for.
    pub fn findings<'v>(&self, verdict: &'v Verdict, way: Way) -> Vec<(&'v str, &'v str)> {
        let remedy = way.remedy();
        // What could not be judged is mended where that was for want of collision geometry alone.
        let can = |c: &&Check| c.status == Status::Fail || way == Way::Touch;
        let checks = verdict.checks.iter().filter(|c| self.wants(c)).filter(can);
        let all = checks.flat_map(|c| c.evidence.iter().map(|e| (c.id.as_str(), e.as_str())));
        all.filter(|(rule, finding)| remedy.is_for(rule, finding)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim_check::profile::RULES;

    #[test]
    fn every_way_has_one_remedy_and_every_remedy_rules_of_the_profile() {
        for (at, remedy) in REMEDIES.iter().enumerate() {
            assert_eq!(remedy.way.remedy().found, REMEDIES[at].found);
            assert!(remedy.rules.iter().all(|id| RULES.iter().any(|r| r.id == *id)));
            assert!(remedy.says.iter().all(|(id, _)| remedy.rules.contains(id)), "{remedy:?}");
        }
        assert!(REMEDIES.windows(2).all(|pair| pair[0].way < pair[1].way));
    }

    #[test]
    fn an_axis_without_direction_is_for_a_person() {
        assert!(is_mendable("J1", "line 3: joint `a`: axis [0, 0, 2] has length 2"));
        assert!(!is_mendable("J1", "line 3: joint `a`: axis [0, 0, 0] has length 0"));
        assert!(!is_mendable("F1", "not XML"));
    }

    #[test]
    fn equal_limits_and_two_turns_are_for_a_person() {
        let limits = |from: &str| format!("line 3: joint `a`: limits {from} are not ordered");
        assert!(is_mendable("J2", &limits("1.57 to 0")));
        assert!(!is_mendable("J2", &limits("0 to 0")));
        let turns = |span: &str| {
            format!("line 3: joint `a`: turns {span} rad, 5157 deg; degrees written as radians?")
        };
        assert!(is_mendable("J3", &turns("90")));
        assert!(!is_mendable("J3", &turns("12.57")));
    }
}
