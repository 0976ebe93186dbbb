//! Rules about PyBullet.

use crate::client::Client;
use crate::find::{joints, links, mass, meshes, shapes};
use crate::rule::Severity::{Behaves, Looks, Note, Refused};
use crate::rule::{Find, Rule, Severity, Source};

const VERSION: &str = "pybullet 3.2.7";
const SOURCE: Source = Source::Measured("engines/check_pybullet.py");

const fn rule(
    id: &'static str,
    severity: Severity,
    find: Find,
    sentence: &'static str,
    remedy: &'static str,
) -> Rule {
    Rule {
        id,
        client: Client::Pybullet,
        severity,
        version: VERSION,
        source: SOURCE,
        sentence,
        remedy,
        find,
    }
}

pub(super) const RULES: &[Rule] = &[
    rule(
        "pybullet.mesh-format",
        Refused,
        Find::Urdf(meshes::unknown_to_pybullet),
        "PyBullet refuses the file: it reads no mesh with this extension.",
        "Save meshes as OBJ or STL.",
    ),
    rule(
        "pybullet.mesh-missing",
        Refused,
        Find::Urdf(meshes::missing),
        "PyBullet refuses the file: it finds no mesh of this name.",
        "Put the mesh where the file says, relative to the URDF.",
    ),
    rule(
        "pybullet.mesh-package",
        Refused,
        Find::Urdf(meshes::by_package_elsewhere),
        "PyBullet knows no packages: unless a folder of that name is near, it refuses the file.",
        "Write a path relative to the URDF.",
    ),
    rule(
        "pybullet.limit-missing",
        Refused,
        Find::Urdf(joints::limit_missing),
        "PyBullet refuses the file: a revolute or prismatic joint must have a <limit>.",
        "Write <limit lower upper effort velocity>.",
    ),
    rule(
        "pybullet.joint-type",
        Refused,
        Find::Urdf(joints::unknown),
        "PyBullet refuses the file: it knows no joint of this type.",
        "Use revolute, continuous, prismatic, fixed or planar.",
    ),
    rule(
        "pybullet.link-twice",
        Refused,
        Find::Urdf(links::twice),
        "PyBullet refuses the file: two links have one name.",
        "Give each link a name of its own.",
    ),
    rule(
        "pybullet.inertia-ignored",
        Behaves,
        Find::Urdf(mass::unlike_its_box),
        "PyBullet ignores your inertia and takes the moments of the box around the collision shapes.",
        "Load with flags=URDF_USE_INERTIA_FROM_FILE.",
    ),
    rule(
        "pybullet.inertia-without-collision",
        Behaves,
        Find::Urdf(mass::weighed_without_shape),
        "PyBullet gives a link without collision moments of nearly zero: it spins wildly.",
        "Load with flags=URDF_USE_INERTIA_FROM_FILE, or add a collision.",
    ),
    rule(
        "pybullet.no-inertial",
        Behaves,
        Find::Urdf(mass::without_inertial),
        "PyBullet gives a link without <inertial> a mass of 1 kg.",
        "Give the link an <inertial>.",
    ),
    rule(
        "pybullet.mass-zero",
        Behaves,
        Find::Urdf(mass::zero),
        "PyBullet holds a link of mass 0 still: no torque moves its joint.",
        "Give the link a mass.",
    ),
    rule(
        "pybullet.mimic-dropped",
        Behaves,
        Find::Urdf(joints::followers),
        "PyBullet ignores <mimic>: the follower moves on its own.",
        "Add a gear constraint from code.",
    ),
    rule(
        "pybullet.concave",
        Behaves,
        Find::Urdf(meshes::felt_concave),
        "PyBullet collides with the mesh's convex hull: its hollows are filled.",
        "Split the collision into convex pieces.",
    ),
    rule(
        "pybullet.continuous-limit",
        Behaves,
        Find::Urdf(joints::continuous_with_range),
        "PyBullet tells the range of a continuous joint in getJointInfo and does not keep it.",
        "Make the joint revolute if it has stops.",
    ),
    rule(
        "pybullet.range-missing",
        Behaves,
        Find::Urdf(joints::range_missing_in_limit),
        "PyBullet lets a joint without lower and upper move without end.",
        "Write lower and upper, or make it continuous.",
    ),
    rule(
        "pybullet.range-one-sided",
        Behaves,
        Find::Urdf(joints::range_without_upper),
        "PyBullet takes a missing upper end for -1, not for 0.",
        "Write both lower and upper.",
    ),
    rule(
        "pybullet.friction-dropped",
        Behaves,
        Find::Urdf(joints::with_friction),
        "PyBullet reads joint friction and does not apply it.",
        "Brake with a velocity motor of that force.",
    ),
    rule(
        "pybullet.axis-length",
        Behaves,
        Find::Urdf(joints::axis_long),
        "PyBullet scales the slide by the axis' length: the part moves further than its position says.",
        "Write an axis of length 1.",
    ),
    rule(
        "pybullet.axis-zero",
        Behaves,
        Find::Urdf(joints::axis_zero),
        "PyBullet loads an axis of 0 0 0, and the joint moves nothing.",
        "Write an axis of length 1.",
    ),
    rule(
        "pybullet.floating-fixed",
        Behaves,
        Find::Urdf(joints::floating),
        "PyBullet makes a floating joint fixed: the part stays where it is.",
        "Load the loose part from a file of its own.",
    ),
    rule(
        "pybullet.safety-ignored",
        Behaves,
        Find::Urdf(joints::safety),
        "PyBullet ignores <safety_controller>: its soft limits do not stop the joint.",
        "Put the range that matters into <limit>.",
    ),
    rule(
        "pybullet.material-undefined",
        Looks,
        Find::Urdf(shapes::undefined),
        "PyBullet draws a visual white whose material is defined nowhere.",
        "Define the material, with its colour.",
    ),
    rule(
        "pybullet.mesh-colours",
        Looks,
        Find::Urdf(meshes::seen_in_colours),
        "PyBullet draws a visual of several materials as one shape with one colour.",
        "Save a mesh for each colour.",
    ),
    rule(
        "pybullet.motors-hold",
        Note,
        Find::Urdf(joints::movable),
        "PyBullet holds each joint with a motor of its own, stronger than the file's effort.",
        "Call setJointMotorControl2 with VELOCITY_CONTROL and force=0.",
    ),
    rule(
        "pybullet.base-free",
        Note,
        Find::Urdf(links::roots),
        "PyBullet lets the root link fall.",
        "Load with useFixedBase=True what is mounted.",
    ),
    rule(
        "pybullet.self-collision-off",
        Note,
        Find::Urdf(links::could_meet),
        "PyBullet lets the model's own parts pass through each other.",
        "Load with flags=URDF_USE_SELF_COLLISION.",
    ),
    rule(
        "pybullet.limits-not-kept",
        Note,
        Find::Urdf(joints::with_strength),
        "PyBullet keeps neither effort nor velocity: torques beyond them act.",
        "Pass force and maxVelocity with each command.",
    ),
];
