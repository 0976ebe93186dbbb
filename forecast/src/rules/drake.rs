//! Rules about Drake.

use crate::client::Client;
use crate::find::{joints, links, mass, meshes, shapes, sink};
use crate::rule::Severity::{Behaves, Note, Refused};
use crate::rule::{Find, Rule, Tested};

const TESTED: Tested =
    Tested { client: Client::Drake, version: "drake 1.51.1", script: "engines/check_drake.py" };

pub(super) const RULES: &[Rule] = &[
    TESTED.rule(
        "drake.mesh-format",
        Refused,
        Find::Urdf(meshes::felt_unknown_to_drake),
        "Drake refuses the file: it makes hulls of OBJ, VTK and glTF text only.",
        "Save collision meshes as OBJ.",
    ),
    TESTED.rule(
        "drake.mesh-missing",
        Refused,
        Find::Urdf(meshes::missing),
        "Drake refuses the file: it finds no mesh of this name.",
        "Put the mesh where the file says, relative to the URDF.",
    ),
    TESTED.rule(
        "drake.mesh-package",
        Refused,
        Find::Urdf(meshes::by_foreign_package),
        "Drake refuses the file unless the parser's package map knows this package.",
        "Call parser.package_map().Add(...), or write a relative path.",
    ),
    TESTED.rule(
        "drake.no-mass",
        Refused,
        Find::Urdf(mass::end_without_mass),
        "Drake loads a moving link without mass and stops at the first step.",
        "Give the link a mass and moments.",
    ),
    TESTED.rule(
        "drake.material-undefined",
        Refused,
        Find::Urdf(shapes::undefined),
        "Drake refuses the file: a visual names a material that is defined nowhere.",
        "Define the material, with its colour.",
    ),
    TESTED.rule(
        "drake.joint-type",
        Refused,
        Find::Urdf(joints::unknown),
        "Drake refuses the file: this type must be written as <drake:joint>.",
        "Use revolute, continuous, prismatic, fixed, floating or planar.",
    ),
    TESTED.rule(
        "drake.link-twice",
        Refused,
        Find::Urdf(links::twice),
        "Drake refuses the file: two links have one name.",
        "Give each link a name of its own.",
    ),
    TESTED.rule(
        "drake.axis-zero",
        Refused,
        Find::Urdf(joints::axis_zero),
        "Drake refuses the file: the joint's axis has no direction.",
        "Write an axis of length 1.",
    ),
    TESTED.rule(
        "drake.inertia-triangle",
        Behaves,
        Find::Urdf(mass::triangle),
        "Drake warns and replaces impossible moments by those of a ball of water of that mass.",
        "Give moments that a body can have.",
    ),
    TESTED.rule(
        "drake.mass-zero",
        Behaves,
        Find::Urdf(mass::impossible),
        "Drake warns and replaces a mass of zero or less by 1 kg.",
        "Give the link a mass above zero.",
    ),
    TESTED.rule(
        "drake.effort-zero",
        Behaves,
        Find::Urdf(joints::transmission_without_effort),
        "Drake skips a transmission whose joint has effort 0: there is no actuator.",
        "Write the motor's real effort.",
    ),
    TESTED.rule(
        "drake.concave",
        Behaves,
        Find::Urdf(meshes::felt_concave),
        "Drake's point contact takes the mesh's convex hull: its hollows are filled.",
        "Split the collision into convex pieces.",
    ),
    TESTED.rule(
        "drake.continuous-limit",
        Behaves,
        Find::Urdf(joints::continuous_with_range),
        "Drake stops a continuous joint at the ends of its range.",
        "Take lower and upper out if it turns without end.",
    ),
    TESTED.rule(
        "drake.range-missing",
        Behaves,
        Find::Urdf(joints::range_missing),
        "Drake lets a joint without lower and upper move without end.",
        "Write lower and upper, or make it continuous.",
    ),
    TESTED.rule(
        "drake.range-one-sided",
        Behaves,
        Find::Urdf(joints::range_one_sided),
        "Drake takes a missing end of a range for infinite, not for 0.",
        "Write both lower and upper.",
    ),
    TESTED.rule(
        "drake.friction-dropped",
        Behaves,
        Find::Urdf(joints::with_friction),
        "Drake warns and drops joint friction.",
        "Put it into damping, or add a friction force from code.",
    ),
    TESTED.rule(
        "drake.floating-joint",
        Behaves,
        Find::Urdf(joints::floating),
        "Drake drops a floating joint and its name: its child is a free body.",
        "Set the free body's pose by its link's name.",
    ),
    TESTED.rule(
        "drake.planar-limit",
        Behaves,
        Find::Urdf(joints::planar_with_range),
        "Drake drops the range of a planar joint.",
        "Use two prismatic joints and a revolute one.",
    ),
    TESTED.rule(
        "drake.safety-ignored",
        Behaves,
        Find::Urdf(joints::safety),
        "Drake warns and ignores <safety_controller>.",
        "Put the range that matters into <limit>.",
    ),
    TESTED.rule(
        "drake.no-actuator",
        Note,
        Find::Urdf(joints::without_transmission),
        "Drake makes no actuator without a <transmission>: the joint cannot be driven.",
        "Add a transmission, or call AddJointActuator.",
    ),
    TESTED.rule(
        "drake.base-free",
        Note,
        Find::Urdf(links::bodies_at_root),
        "Drake lets the root link float.",
        "Weld what is mounted: plant.WeldFrames, or a root link named `world`.",
    ),
    TESTED.rule(
        "drake.sinks",
        Behaves,
        Find::Urdf(sink::without_friction),
        "Drake lets these joints sink: gravity pulls, and it applies no friction.",
        "Hold them by their actuators, or lock the joints.",
    ),
];
