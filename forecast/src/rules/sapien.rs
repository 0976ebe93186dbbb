//! Rules about SAPIEN.

use crate::client::Client;
use crate::find::{joints, links, mass, meshes, sink};
use crate::rule::Severity::{Behaves, Note, Refused};
use crate::rule::{Find, Rule, Tested};

const TESTED: Tested =
    Tested { client: Client::Sapien, version: "sapien 3.0.3", script: "engines/check_sapien.py" };

pub(super) const RULES: &[Rule] = &[
    TESTED.rule(
        "sapien.limit-missing",
        Refused,
        Find::Urdf(joints::limit_missing),
        "SAPIEN refuses the file: a revolute or prismatic joint must have a <limit>.",
        "Write <limit lower upper effort velocity>.",
    ),
    TESTED.rule(
        "sapien.dynamics-without-damping",
        Refused,
        Find::Urdf(joints::dynamics_without_damping),
        "SAPIEN raises a TypeError: <dynamics> must say damping.",
        "Write damping=\"0\".",
    ),
    TESTED.rule(
        "sapien.floating-joint",
        Refused,
        Find::Urdf(joints::floating),
        "SAPIEN's load refuses a floating joint, since it parts the file into two objects.",
        "Call load_multiple.",
    ),
    TESTED.rule(
        "sapien.joint-type",
        Refused,
        Find::Urdf(joints::unknown_or_planar),
        "SAPIEN refuses the file: it builds no joint of this type.",
        "Use revolute, continuous, prismatic or fixed.",
    ),
    TESTED.rule(
        "sapien.link-twice",
        Refused,
        Find::Urdf(links::twice),
        "SAPIEN refuses the file: two links have one name.",
        "Give each link a name of its own.",
    ),
    TESTED.rule(
        "sapien.slide-range-missing",
        Refused,
        Find::Urdf(joints::slide_range_incomplete),
        "SAPIEN raises a TypeError: a prismatic joint must say lower and upper.",
        "Write both lower and upper.",
    ),
    TESTED.rule(
        "sapien.range-missing",
        Behaves,
        Find::Urdf(joints::hinge_range_incomplete),
        "SAPIEN makes NaN of a missing end of a revolute joint's range.",
        "Write both lower and upper, or make the joint continuous.",
    ),
    TESTED.rule(
        "sapien.mimic-inverted",
        Behaves,
        Find::Urdf(joints::followers_beside),
        "SAPIEN turns <mimic> between siblings round: follower = (leader - offset) / multiplier.",
        "Couple the joints from code.",
    ),
    TESTED.rule(
        "sapien.mimic-dropped",
        Behaves,
        Find::Urdf(joints::followers_apart),
        "SAPIEN ignores a <mimic> whose leader is neither on the same link nor right above.",
        "Couple the joints from code.",
    ),
    TESTED.rule(
        "sapien.mesh-missing",
        Behaves,
        Find::Urdf(meshes::felt_missing),
        "SAPIEN logs and leaves out a collision mesh that it does not find.",
        "Put the mesh where the file says, relative to the URDF.",
    ),
    TESTED.rule(
        "sapien.mesh-uri",
        Behaves,
        Find::Urdf(meshes::lost_to_sapien),
        "SAPIEN looks for packages beside the file and reads no file://: the mesh is left out.",
        "Pass package_dir, or write a relative path.",
    ),
    TESTED.rule(
        "sapien.concave",
        Behaves,
        Find::Urdf(meshes::felt_concave),
        "SAPIEN collides with the mesh's convex hull: its hollows are filled.",
        "Split the collision, or set load_multiple_collisions_from_file.",
    ),
    TESTED.rule(
        "sapien.no-inertial",
        Behaves,
        Find::Urdf(mass::shaped_without_inertial),
        "SAPIEN weighs the link by its collision shapes at 1000 kg per cubic metre.",
        "Give the link an <inertial>.",
    ),
    TESTED.rule(
        "sapien.mass-zero",
        Behaves,
        Find::Urdf(mass::shaped_zero),
        "SAPIEN takes a mass or moments of 0 for missing: collision shapes weigh 1000 kg per cubic metre.",
        "Give the link a mass and moments.",
    ),
    TESTED.rule(
        "sapien.no-mass",
        Behaves,
        Find::Urdf(mass::nothing),
        "SAPIEN gives a link with neither inertial nor collision a millionth of a kilogram.",
        "Give the link an <inertial>.",
    ),
    TESTED.rule(
        "sapien.continuous-limit",
        Behaves,
        Find::Urdf(joints::continuous_with_range),
        "SAPIEN drops the range of a continuous joint: it turns without end.",
        "Make the joint revolute if it has stops.",
    ),
    TESTED.rule(
        "sapien.friction-dropped",
        Behaves,
        Find::Urdf(joints::with_friction),
        "SAPIEN gives the joint a friction of 0.05, whatever the file says.",
        "Call set_friction on the joint.",
    ),
    TESTED.rule(
        "sapien.safety-ignored",
        Behaves,
        Find::Urdf(joints::safety),
        "SAPIEN ignores <safety_controller>: its soft limits do not stop the joint.",
        "Put the range that matters into <limit>.",
    ),
    TESTED.rule(
        "sapien.joint-friction",
        Note,
        Find::Urdf(joints::movable),
        "SAPIEN gives every joint a friction of 0.05.",
        "Call set_friction on the joints.",
    ),
    TESTED.rule(
        "sapien.effort-dropped",
        Note,
        Find::Urdf(joints::with_effort),
        "SAPIEN drops the effort: drives push with any force.",
        "Pass force_limit to set_drive_properties.",
    ),
    TESTED.rule(
        "sapien.base-fixed",
        Note,
        Find::Urdf(links::bodies_at_root),
        "SAPIEN fixes the root link to the world.",
        "Set fix_root_link to False if it is to move.",
    ),
    TESTED.rule(
        "sapien.sinks",
        Behaves,
        Find::Urdf(sink::in_sapien),
        "SAPIEN lets these joints sink: gravity pulls, and friction is 0.05 whatever the file says.",
        "Call set_friction on the joints with the file's friction.",
    ),
];
