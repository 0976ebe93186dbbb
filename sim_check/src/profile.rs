//! The profile simready-urdf 1.0 as a table: every check's id, rule, bound, severity and tier.
//!
//! ```
//! use sim_check::Tier;
//! use sim_check::profile::rule;
//! let ratio = rule("M6");
//! assert_eq!((ratio.tier, ratio.threshold()), (Tier::Static, "mass ratio <= 1,000".into()));
//! ```

pub mod bounds;
pub mod due;
pub mod explain;
pub mod subject;
mod tier;
pub(crate) mod words;

pub use tier::{Severity, Tier};

use std::f64::consts::PI;

use bounds::*;
use words::{grown, mm, moved, percent, shrunk, thousands};

/// Families of checks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Group {
    /// Files and numbers.
    Files,
    /// Tree and references.
    Tree,
    /// Units and placement.
    Units,
    /// Visual and collision geometry.
    Geometry,
    /// Mass and inertia.
    Mass,
    /// Joints.
    Joints,
    /// Labels.
    Labels,
    /// Contact at rest and along the ranges.
    Contact,
    /// Behaviour in a simulator.
    Simulation,
    /// Provenance.
    Provenance,
    /// Whether it is right, by what the asset says of how sure it is.
    Right,
}

/// One rule of the profile.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// Its id, like `G2`.
    pub id: &'static str,
    /// Its family.
    pub group: Group,
    /// The lowest tier that asks for it.
    pub tier: Tier,
    /// Whether failing it lowers the tier.
    pub severity: Severity,
    /// What it asks, in plain words.
    pub words: &'static str,
    /// Its default bound in words, made from [`bounds`].
    bound: fn() -> String,
    /// Unit of its figure, unless the check names another.
    pub unit: &'static str,
}

impl Rule {
    /// Its default bound in words, made from [`bounds`].
    pub fn threshold(&self) -> String {
        (self.bound)()
    }
}

const fn entry(
    id: &'static str,
    group: Group,
    (tier, severity): (Tier, Severity),
    words: &'static str,
    (bound, unit): (fn() -> String, &'static str),
) -> Rule {
    Rule { id, group, tier, severity, words, bound, unit }
}

const PARSE: (Tier, Severity) = (Tier::Parse, Severity::Error);
const STATIC: (Tier, Severity) = (Tier::Static, Severity::Error);
const FLAG: (Tier, Severity) = (Tier::Static, Severity::Warning);
const KINEMATIC: (Tier, Severity) = (Tier::Kinematic, Severity::Error);
const DYNAMIC: (Tier, Severity) = (Tier::Dynamic, Severity::Error);
const AUDITED: (Tier, Severity) = (Tier::Audited, Severity::Error);

/// The bound of what is counted fault by fault.
fn none() -> String {
    "0 faults".into()
}

/// The rules, in the order they are reported.
#[rustfmt::skip]
pub const RULES: [Rule; 51] = {
    use Group::{Contact, Files, Geometry, Joints, Labels, Mass, Provenance, Right, Simulation, Tree, Units};
    [
    entry("F1", Files, PARSE, "well-formed XML with finite numbers", (none, "faults")),
    entry("F2", Files, PARSE, "every mesh exists at a relative path inside the package", (none, "faults")),
    entry("F3", Files, PARSE, "names are unique and [A-Za-z_][A-Za-z0-9_]*", (none, "faults")),
    entry("T1", Tree, PARSE, "one root, no cycle, every reference exists", (none, "faults")),
    entry("T2", Tree, PARSE, "joint types are known and mimics follow another joint", (none, "faults")),
    entry("T3", Tree, PARSE, "no moving link without mass and without geometry", (none, "faults")),
    entry("T4", Tree, PARSE, "part and joint counts match the kinematic condition", (|| "equal".into(), "faults")),
    entry("U1", Units, STATIC, "z up, metres, no mesh scale left", (|| format!("scale 1 within {SCALE:e}"), "off 1")),
    entry("U2", Units, STATIC, "the object is of a believable size", (|| format!("diagonal {} to {} m", SIZES.start(), SIZES.end()), "m")),
    entry("U3", Units, FLAG, "the object rests on z = 0 with its root at the centre of its base", (|| format!("lowest point within {} of z = 0, base centre within {} of x = y = 0", mm(PLACED.least), grown(PLACED, "its width")), "m")),
    entry("G1", Geometry, STATIC, "visual surfaces are sound and consistently wound", (|| format!("degenerate faces <= {}, edges wound against each other <= {}, closed surfaces of positive volume, <= {} faces", percent(DEGENERATE), percent(CLASHING), thousands(FACES as f64)), "faces")),
    entry("G2", Geometry, STATIC, "each collision piece is convex, closed, thick enough and simple", (|| format!("dents <= {} of its diagonal, thickness >= {}, <= {VERTICES} vertices, <= {PIECES} pieces per link", percent(DENT), shrunk(THIN)), "pieces")),
    entry("G3", Geometry, STATIC, "collision geometry covers what is seen and fills no cavity", (|| format!("gap <= {}, filled cavity <= {} of the collision volume", grown(COVER, "the diagonal"), percent(FILLED)), "m")),
    entry("G4", Geometry, STATIC, "no loose piece floats beside its part", (|| format!("pieces above {} lie within {} of the rest", percent(LOOSE), grown(BESIDE, "the diagonal")), "of all")),
    entry("M1", Mass, STATIC, "every moving link has mass and inertia", (|| "mass > 0".into(), "kg")),
    entry("M2", Mass, STATIC, "densities are physical", (|| format!("{} to {} kg/m³ (flagged outside {} to {})", thousands(DENSITY.0), thousands(DENSITY.1), thousands(LIKELY.0), thousands(LIKELY.1)), "kg/m³")),
    entry("M3", Mass, STATIC, "inertia is positive definite and obeys the triangle inequality", (|| format!("relative tolerance {TRIANGLE:e}"), "of the sum")),
    entry("M4", Mass, STATIC, "inertia belongs to the part's shape", (|| format!("principal moments within {} to {MOMENTS} times those of its solid or shell", 1.0 / MOMENTS), "times")),
    entry("M5", Mass, STATIC, "the centre of mass lies inside the part's hull", (|| format!("<= {} outside", grown(OUTSIDE, "the diagonal")), "m")),
    entry("M6", Mass, STATIC, "no link is overwhelmingly heavier than its child", (|| format!("mass ratio <= {}", thousands(RATIO)), "times")),
    entry("M7", Mass, AUDITED, "the source of every mass is recorded", (|| "one source per link".into(), "faults")),
    entry("J1", Joints, STATIC, "axes are finite and of length 1", (|| format!("|axis| = 1 within {AXIS:e}"), "long")),
    entry("J2", Joints, STATIC, "limits are finite, ordered and hold the rest pose", (|| "lower < upper, lower <= 0 <= upper".into(), "faults")),
    entry("J3", Joints, STATIC, "ranges are believable", (|| format!("turn <= {} pi, slide <= {SLIDE} of the part's extent along it", TURN / PI), "rad")),
    entry("J4", Joints, STATIC, "effort and velocity are positive; damping and friction are given", (|| "> 0 and finite".into(), "faults")),
    entry("J5", Joints, STATIC, "each pivot lies near both its parts", (|| format!("<= {} of the diagonal", percent(PIVOT)), "m")),
    entry("J6", Joints, FLAG, "axes follow an edge or symmetry of the part", (|| format!("<= {PARALLEL} deg"), "deg")),
    entry("J7", Joints, STATIC, "gravity does not open the joint", (|| format!("<= {} in {HELD_FOR} s", moved(OPENED)), "of the bound")),
    entry("L1", Labels, FLAG, "every link has a label", (|| "one text per link with geometry".into(), "faults")),
    entry("L2", Labels, FLAG, "what is meant to be grasped is marked", (|| "optional".into(), "links")),
    entry("C1", Contact, KINEMATIC, "no parts overlap at rest", (|| format!("depth <= {}", grown(OVERLAP, "the diagonal")), "mm")),
    entry("C2", Contact, KINEMATIC, "no parts overlap along any joint's range", (|| format!("depth <= {}", grown(OVERLAP, "the diagonal")), "mm")),
    entry("C3", Contact, KINEMATIC, "no parts overlap when joints move together", (|| format!("depth <= {}", grown(OVERLAP, "the diagonal")), "mm")),
    entry("C4", Contact, KINEMATIC, "parts stay attached along their range", (|| format!("hinge gap grows <= {}, slide keeps >= {} overlap", grown(HINGE_GAP, "the diagonal"), percent(SLIDE_KEEPS)), "of the bound")),
    entry("C5", Contact, KINEMATIC, "joints open to the free side", (|| format!("free the other way < {FARTHER} times as far, where it collides in the first {} of its range", percent(SOON)), "times as far")),
    entry("S1", Simulation, DYNAMIC, "motion stays finite and gains no energy", (|| "finite, no growth".into(), "% gained")),
    entry("S2", Simulation, DYNAMIC, "dropped from 1 cm it settles and stays upright", (|| format!("settles in {SETTLE} s, drift < {}", grown(DRIFT, "the diagonal")), "mm")),
    entry("S3", Simulation, DYNAMIC, "every joint drives to both limits", (|| format!("reaches >= {}, overshoot < {}", percent(REACHED), percent(OVERSHOOT)), "% reached")),
    entry("S4", Simulation, DYNAMIC, "limits hold under twice the effort", (|| format!("overshoot < max({}, {})", percent(PUSHED), moved(PUSHED_LEAST)), "of the bound")),
    entry("S5", Simulation, DYNAMIC, "each joint swings as its inertia says", (|| format!("within {} of the closed form", percent(CLOSED_FORM)), "% off")),
    entry("F4", Files, AUDITED, "files match the hashes in the sidecar", (none, "faults")),
    entry("P1", Provenance, AUDITED, "the trace is present, complete and matches", (none, "faults")),
    entry("P2", Provenance, AUDITED, "licences satisfy the policy", (none, "faults")),
    entry("P3", Provenance, AUDITED, "every default value is listed", (none, "faults")),
    entry("R1", Right, FLAG, "each link's surface is likely its own", (|| format!("probability >= {SURE}"), "probability")),
    entry("R2", Right, FLAG, "each axis is likely right, and in its place", (|| format!("probability >= {SURE}"), "probability")),
    entry("R3", Right, FLAG, "each joint likely opens the right way", (|| format!("probability >= {SURE}"), "probability")),
    entry("R4", Right, FLAG, "no piece of a link is likely another's", (|| format!("class probability < {STRAY} where it is {} of a link of probability < {UNSURE}", percent(PIECE)), "probability")),
    entry("R5", Right, FLAG, "each joint is shown at an end of its range, or about its middle", (|| format!("not between {} and {} from an end", percent(AJAR.0), percent(AJAR.1)), "of the range")),
    entry("R6", Right, FLAG, "no piece of a link lies along another and touches nothing of its own", (|| format!("a piece of {} of its link and of all lies along another link by no more than {TWICE} times as much as along its own", percent(LOOSE_PIECE)), "of the piece")),
    entry("R7", Right, FLAG, "no joint leads away from where it would be shut", (|| format!("a turn is free less than {} of its range beyond it, or less than {} more of the part lies against the rest there; no slide goes in that is free to come out", percent(BACK), percent(CLOSER)), "of the part")),
    ]
};

/// What an id nobody knows stands for: an error no tier forgives.
const STRANGER: Rule =
    entry("?", Group::Files, PARSE, "not a rule of this profile", (|| "none".into(), ""));

/// The rule of that id; a stranger of severity error if the profile has none.
pub fn rule(id: &str) -> &'static Rule {
    RULES.iter().find(|r| r.id == id).unwrap_or(&STRANGER)
}

/// Place of a rule in the report; strangers come last.
pub(crate) fn position(id: &str) -> usize {
    RULES.iter().position(|r| r.id == id).unwrap_or(RULES.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the profile has said since 1.0. Reports hold these words: they change with its version.
    #[rustfmt::skip]
    const SAID: [(&str, &str); 51] = [
        ("F1", "0 faults"),
        ("F2", "0 faults"),
        ("F3", "0 faults"),
        ("T1", "0 faults"),
        ("T2", "0 faults"),
        ("T3", "0 faults"),
        ("T4", "equal"),
        ("U1", "scale 1 within 1e-9"),
        ("U2", "diagonal 0.005 to 10 m"),
        ("U3", "lowest point within 2 mm of z = 0, base centre within max(2 mm, 5 % of its width) of x = y = 0"),
        ("G1", "degenerate faces <= 0.1 %, edges wound against each other <= 0.1 %, closed surfaces of positive volume, <= 50,000 faces"),
        ("G2", "dents <= 0.1 % of its diagonal, thickness >= min(1 mm, 0.2 % of the diagonal), <= 64 vertices, <= 32 pieces per link"),
        ("G3", "gap <= max(5 mm, 2 % of the diagonal), filled cavity <= 5 % of the collision volume"),
        ("G4", "pieces above 1 % lie within max(5 mm, 2 % of the diagonal) of the rest"),
        ("M1", "mass > 0"),
        ("M2", "20 to 20,000 kg/m³ (flagged outside 100 to 8,000)"),
        ("M3", "relative tolerance 1e-6"),
        ("M4", "principal moments within 0.1 to 10 times those of its solid or shell"),
        ("M5", "<= max(1 mm, 0.2 % of the diagonal) outside"),
        ("M6", "mass ratio <= 1,000"),
        ("M7", "one source per link"),
        ("J1", "|axis| = 1 within 1e-6"),
        ("J2", "lower < upper, lower <= 0 <= upper"),
        ("J3", "turn <= 2 pi, slide <= 1.2 of the part's extent along it"),
        ("J4", "> 0 and finite"),
        ("J5", "<= 5 % of the diagonal"),
        ("J6", "<= 5 deg"),
        ("J7", "<= 2 deg or 5 mm in 5 s"),
        ("L1", "one text per link with geometry"),
        ("L2", "optional"),
        ("C1", "depth <= max(1 mm, 0.2 % of the diagonal)"),
        ("C2", "depth <= max(1 mm, 0.2 % of the diagonal)"),
        ("C3", "depth <= max(1 mm, 0.2 % of the diagonal)"),
        ("C4", "hinge gap grows <= max(3 mm, 0.3 % of the diagonal), slide keeps >= 5 % overlap"),
        ("C5", "free the other way < 2 times as far, where it collides in the first 50 % of its range"),
        ("S1", "finite, no growth"),
        ("S2", "settles in 5 s, drift < max(2 mm, 0.2 % of the diagonal)"),
        ("S3", "reaches >= 95 %, overshoot < 5 %"),
        ("S4", "overshoot < max(5 %, 0.5 deg or 2 mm)"),
        ("S5", "within 5 % of the closed form"),
        ("F4", "0 faults"),
        ("P1", "0 faults"),
        ("P2", "0 faults"),
        ("P3", "0 faults"),
        ("R1", "probability >= 0.5"),
        ("R2", "probability >= 0.5"),
        ("R3", "probability >= 0.5"),
        ("R4", "class probability < 0.35 where it is 5 % of a link of probability < 0.6"),
        ("R5", "not between 5 % and 20 % from an end"),
        ("R6", "a piece of 5 % of its link and of all lies along another link by no more than 2 times as much as along its own"),
        ("R7", "a turn is free less than 50 % of its range beyond it, or less than 5 % more of the part lies against the rest there; no slide goes in that is free to come out"),
    ];

    #[test]
    fn bounds_in_words_are_those_of_the_profile() {
        let said = RULES.map(|r| (r.id, r.threshold()));
        for ((id, made), (due_id, due)) in said.iter().zip(SAID) {
            assert_eq!((*id, made.as_str()), (due_id, due));
        }
        assert_eq!(rule("nobody's").threshold(), "none");
    }

    #[test]
    fn bounds_grow_and_shrink_with_the_object() {
        assert_eq!([OVERLAP.of(0.1), OVERLAP.of(1.0)], [0.001, 0.002]);
        assert_eq!([THIN.of(0.1), THIN.of(1.0)], [0.0002, 0.001]);
        assert_eq!([OPENED.of(true), OPENED.of(false)], [2f64.to_radians(), 0.005]);
    }

    #[test]
    fn a_rule_nobody_knows_counts_as_an_error_and_comes_last() {
        assert_eq!((rule("Z9").id, rule("Z9").severity), ("?", Severity::Error));
        assert_eq!([position("F1"), position("P3"), position("Z9")], [0, 43, 51]);
    }
}
