//! The profile simready-urdf 1.0 as a table: every check's id, rule, bound, severity and tier.

use crate::verdict::{Severity, Tier};

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
    /// Its default bound.
    pub threshold: &'static str,
    /// Unit of its figure, unless the check names another.
    pub unit: &'static str,
}

const fn entry(
    id: &'static str,
    group: Group,
    (tier, severity): (Tier, Severity),
    words: &'static str,
    (threshold, unit): (&'static str, &'static str),
) -> Rule {
    Rule { id, group, tier, severity, words, threshold, unit }
}

const PARSE: (Tier, Severity) = (Tier::Parse, Severity::Error);
const STATIC: (Tier, Severity) = (Tier::Static, Severity::Error);
const FLAG: (Tier, Severity) = (Tier::Static, Severity::Warning);
const KINEMATIC: (Tier, Severity) = (Tier::Kinematic, Severity::Error);
const DYNAMIC: (Tier, Severity) = (Tier::Dynamic, Severity::Error);
const AUDITED: (Tier, Severity) = (Tier::Audited, Severity::Error);

/// The rules, in the order they are reported.
#[rustfmt::skip]
pub const RULES: [Rule; 44] = {
    use Group::{Contact, Files, Geometry, Joints, Labels, Mass, Provenance, Simulation, Tree, Units};
    [
    entry("F1", Files, PARSE, "well-formed XML with finite numbers", ("0 faults", "faults")),
    entry("F2", Files, PARSE, "every mesh exists at a relative path inside the package", ("0 faults", "faults")),
    entry("F3", Files, PARSE, "names are unique and [A-Za-z_][A-Za-z0-9_]*", ("0 faults", "faults")),
    entry("T1", Tree, PARSE, "one root, no cycle, every reference exists", ("0 faults", "faults")),
    entry("T2", Tree, PARSE, "joint types are known and mimics follow another joint", ("0 faults", "faults")),
    entry("T3", Tree, PARSE, "no moving link without mass and without geometry", ("0 faults", "faults")),
    entry("T4", Tree, PARSE, "part and joint counts match the kinematic condition", ("equal", "faults")),
    entry("U1", Units, STATIC, "z up, metres, no mesh scale left", ("scale 1 within 1e-9", "off 1")),
    entry("U2", Units, STATIC, "the object is of a believable size", ("diagonal 0.005 to 10 m", "m")),
    entry("U3", Units, FLAG, "the object rests on z = 0 with its root at the centre of its base", ("lowest point within 2 mm of z = 0, base centre within max(2 mm, 5 % of its width) of x = y = 0", "m")),
    entry("G1", Geometry, STATIC, "visual surfaces are sound and consistently wound", ("degenerate faces <= 0.1 %, edges wound against each other <= 0.1 %, closed surfaces of positive volume, <= 50,000 faces", "faces")),
    entry("G2", Geometry, STATIC, "each collision piece is convex, closed, thick enough and simple", ("dents <= 0.1 % of its diagonal, thickness >= min(1 mm, 0.2 % of the diagonal), <= 64 vertices, <= 32 pieces per link", "pieces")),
    entry("G3", Geometry, STATIC, "collision geometry covers what is seen and fills no cavity", ("gap <= max(5 mm, 2 % of the diagonal), filled cavity <= 5 % of the collision volume", "m")),
    entry("G4", Geometry, STATIC, "no loose piece floats beside its part", ("pieces above 1 % lie within max(5 mm, 2 % of the diagonal) of the rest", "of all")),
    entry("M1", Mass, STATIC, "every moving link has mass and inertia", ("mass > 0", "kg")),
    entry("M2", Mass, STATIC, "densities are physical", ("20 to 20,000 kg/m³ (flagged outside 100 to 8,000)", "kg/m³")),
    entry("M3", Mass, STATIC, "inertia is positive definite and obeys the triangle inequality", ("relative tolerance 1e-6", "of the sum")),
    entry("M4", Mass, STATIC, "inertia belongs to the part's shape", ("principal moments within 0.1 to 10 times those of its solid or shell", "times")),
    entry("M5", Mass, STATIC, "the centre of mass lies inside the part's hull", ("<= max(1 mm, 0.2 % of the diagonal) outside", "m")),
    entry("M6", Mass, STATIC, "no link is overwhelmingly heavier than its child", ("mass ratio <= 1,000", "times")),
    entry("M7", Mass, AUDITED, "the source of every mass is recorded", ("one source per link", "faults")),
    entry("J1", Joints, STATIC, "axes are finite and of length 1", ("|axis| = 1 within 1e-6", "long")),
    entry("J2", Joints, STATIC, "limits are finite, ordered and hold the rest pose", ("lower < upper, lower <= 0 <= upper", "faults")),
    entry("J3", Joints, STATIC, "ranges are believable", ("turn <= 2 pi, slide <= 1.2 of the part's extent along it", "rad")),
    entry("J4", Joints, STATIC, "effort and velocity are positive; damping and friction are given", ("> 0 and finite", "faults")),
    entry("J5", Joints, STATIC, "each pivot lies near both its parts", ("<= 5 % of the diagonal", "m")),
    entry("J6", Joints, FLAG, "axes follow an edge or symmetry of the part", ("<= 5 deg", "deg")),
    entry("J7", Joints, STATIC, "gravity does not open the joint", ("<= 2 deg or 5 mm in 5 s", "of the bound")),
    entry("L1", Labels, FLAG, "every link has a label", ("one text per link with geometry", "faults")),
    entry("L2", Labels, FLAG, "what is meant to be grasped is marked", ("optional", "links")),
    entry("C1", Contact, KINEMATIC, "no parts overlap at rest", ("depth <= max(1 mm, 0.2 % of the diagonal)", "mm")),
    entry("C2", Contact, KINEMATIC, "no parts overlap along any joint's range", ("depth <= max(1 mm, 0.2 % of the diagonal)", "mm")),
    entry("C3", Contact, KINEMATIC, "no parts overlap when joints move together", ("depth <= max(1 mm, 0.2 % of the diagonal)", "mm")),
    entry("C4", Contact, KINEMATIC, "parts stay attached along their range", ("hinge gap grows <= max(3 mm, 0.3 % of the diagonal), slide keeps >= 5 % overlap", "of the bound")),
    entry("C5", Contact, KINEMATIC, "joints open to the free side", ("declared side free", "")),
    entry("S1", Simulation, DYNAMIC, "motion stays finite and gains no energy", ("finite, no growth", "% gained")),
    entry("S2", Simulation, DYNAMIC, "dropped from 1 cm it settles and stays upright", ("settles in 5 s, drift < max(2 mm, 0.2 % of the diagonal)", "mm")),
    entry("S3", Simulation, DYNAMIC, "every joint drives to both limits", ("reaches >= 95 %, overshoot < 5 %", "% reached")),
    entry("S4", Simulation, DYNAMIC, "limits hold under twice the effort", ("overshoot < max(5 %, 0.5 deg or 2 mm)", "of the bound")),
    entry("S5", Simulation, DYNAMIC, "each joint swings as its inertia says", ("within 5 % of the closed form", "% off")),
    entry("F4", Files, AUDITED, "files match the hashes in the sidecar", ("0 faults", "faults")),
    entry("P1", Provenance, AUDITED, "the trace is present, complete and matches", ("0 faults", "faults")),
    entry("P2", Provenance, AUDITED, "licences satisfy the policy", ("0 faults", "faults")),
    entry("P3", Provenance, AUDITED, "every default value is listed", ("0 faults", "faults")),
    ]
};

/// What an id nobody knows stands for: an error no tier forgives.
const STRANGER: Rule = entry("?", Group::Files, PARSE, "not a rule of this profile", ("none", ""));

/// The rule of that id; a stranger of severity error if the profile has none.
pub fn rule(id: &str) -> &'static Rule {
    RULES.iter().find(|r| r.id == id).unwrap_or(&STRANGER)
}

/// Place of a rule in the report; strangers come last.
pub(crate) fn position(id: &str) -> usize {
    RULES.iter().position(|r| r.id == id).unwrap_or(RULES.len())
}
