//! Rules about Isaac Sim.
//!
//! Isaac Sim does not install as a Python package. Its URDF importer begins with
//! `urdf-usd-converter`, and its physics is PhysX, which both do: these are asked.

use crate::client::Client;
use crate::find::{joints, links, mass, meshes, shapes, usd};
use crate::rule::Severity::{Behaves, Looks, Note, Refused};
use crate::rule::{Find, Rule, Severity, Source};

const CONVERTER: (&str, Source) = (
    "urdf-usd-converter 0.3.4, of Isaac Sim 6.1's importer",
    Source::Measured("engines/check_isaac.py"),
);
const LIMIT: (&str, Source) =
    ("ovphysx 0.7.0.74035321", Source::Measured("../findings/usd-one-sided-limit.sh"));
const COLLIDER: (&str, Source) =
    ("ovphysx 0.7.0.74035321", Source::Measured("../findings/usd-disabled-collider-mass.sh"));
const DOCS: (&str, Source) = (
    "Isaac Sim 6.0.1",
    Source::Read(
        "docs.isaacsim.omniverse.nvidia.com, Tutorial: Import URDF and URDF Importer Extension",
    ),
);

const fn rule(
    id: &'static str,
    severity: Severity,
    (version, source): (&'static str, Source),
    find: Find,
    sentence: &'static str,
    remedy: &'static str,
) -> Rule {
    Rule { id, client: Client::Isaac, severity, version, source, sentence, remedy, find }
}

pub(super) const RULES: &[Rule] = &[
    rule(
        "isaac.joint-type",
        Refused,
        CONVERTER,
        Find::Urdf(joints::unknown),
        "Isaac's importer refuses the file: it knows no joint of this type.",
        "Use revolute, continuous, prismatic, fixed, floating or planar.",
    ),
    rule(
        "isaac.link-twice",
        Refused,
        CONVERTER,
        Find::Urdf(links::twice),
        "Isaac's importer refuses the file: two links have one name.",
        "Give each link a name of its own.",
    ),
    rule(
        "isaac.axis-zero",
        Refused,
        CONVERTER,
        Find::Urdf(joints::axis_zero),
        "Isaac's importer refuses the file: the joint's axis has no direction.",
        "Write an axis of length 1.",
    ),
    rule(
        "isaac.mesh-format",
        Behaves,
        CONVERTER,
        Find::Urdf(meshes::gltf),
        "Isaac's importer warns and leaves out glTF meshes.",
        "Save meshes as OBJ, STL or DAE.",
    ),
    rule(
        "isaac.mesh-missing",
        Behaves,
        CONVERTER,
        Find::Urdf(meshes::missing),
        "Isaac's importer warns and leaves out a mesh that it does not find.",
        "Put the mesh where the file says, relative to the URDF.",
    ),
    rule(
        "isaac.mesh-package",
        Behaves,
        CONVERTER,
        Find::Urdf(meshes::by_package),
        "Isaac's importer drops an unknown package's name, looks beside the file, and may leave the mesh out.",
        "Map the package to its folder at import, or write a relative path.",
    ),
    rule(
        "isaac.concave",
        Behaves,
        CONVERTER,
        Find::Urdf(meshes::felt_concave),
        "Isaac's importer marks collision meshes as convex hulls: hollows are filled.",
        "Split the collision, or set its approximation to convexDecomposition.",
    ),
    rule(
        "isaac.capsule-dropped",
        Behaves,
        CONVERTER,
        Find::Urdf(shapes::capsules),
        "Isaac's importer warns and leaves out a <capsule>, which URDF does not know.",
        "Use a cylinder and two spheres.",
    ),
    rule(
        "isaac.no-inertial",
        Behaves,
        CONVERTER,
        Find::Urdf(mass::without_inertial),
        "Isaac's importer writes no mass for the link: the engine weighs its colliders.",
        "Give the link an <inertial>.",
    ),
    rule(
        "isaac.continuous-limit",
        Behaves,
        CONVERTER,
        Find::Urdf(joints::continuous_with_range),
        "Isaac's importer drops the range of a continuous joint.",
        "Make the joint revolute if it has stops.",
    ),
    rule(
        "isaac.range-missing",
        Behaves,
        CONVERTER,
        Find::Urdf(joints::range_missing),
        "Isaac's importer writes a range of 0 .. 0: the joint is locked.",
        "Write lower and upper, or make it continuous.",
    ),
    rule(
        "isaac.range-one-sided",
        Behaves,
        CONVERTER,
        Find::Urdf(joints::range_one_sided),
        "Isaac's importer takes a missing end of a range for 0.",
        "Write both lower and upper.",
    ),
    rule(
        "isaac.limit-incomplete",
        Behaves,
        CONVERTER,
        Find::Urdf(joints::limit_incomplete),
        "Isaac's importer writes 0 for an effort or a velocity that is missing.",
        "Write both effort and velocity.",
    ),
    rule(
        "isaac.floating-joint",
        Behaves,
        CONVERTER,
        Find::Urdf(joints::floating),
        "Isaac's importer writes no joint for a floating one: its child is a free body.",
        "Set the free body's pose by its link's name.",
    ),
    rule(
        "isaac.planar-limit",
        Behaves,
        CONVERTER,
        Find::Urdf(joints::planar_with_range),
        "Isaac's importer drops the range of a planar joint.",
        "Use two prismatic joints and a revolute one.",
    ),
    rule(
        "isaac.names",
        Looks,
        CONVERTER,
        Find::Urdf(links::odd_names),
        "Isaac's importer renames what is no USD identifier: code that asks for the name fails.",
        "Use letters, digits and underscores, no digit first.",
    ),
    rule(
        "isaac.base-fixed",
        Note,
        CONVERTER,
        Find::Urdf(links::bodies_at_root),
        "Isaac's importer ties the root link to the world by a fixed joint.",
        "Delete `root_joint` if it is to move.",
    ),
    rule(
        "isaac.self-collision",
        Note,
        DOCS,
        Find::Urdf(links::could_meet),
        "Isaac's importer leaves collisions of the model with itself off.",
        "Tick Allow Self-Collision at import.",
    ),
    rule(
        "isaac.usd-one-sided-limit",
        Behaves,
        LIMIT,
        Find::Usd(usd::one_sided),
        "Isaac's engine makes 0 .. 0 of a limit of which one end is missing: the joint is locked.",
        "Write both ends, for example -30 and 36000.",
    ),
    rule(
        "isaac.usd-disabled-collider",
        Behaves,
        COLLIDER,
        Find::Usd(usd::disabled_colliders),
        "Isaac's engine weighs a collider that is switched off.",
        "Write physics:mass on the body.",
    ),
];
