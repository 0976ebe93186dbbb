//! Rules about Newton.

use crate::client::Client;
use crate::find::{joints, links, mass, meshes, sink, usd};
use crate::rule::Severity::{Behaves, Looks, Note, Refused};
use crate::rule::{Find, Rule, Tested};

const TESTED: Tested =
    Tested { client: Client::Newton, version: "newton 1.8.0", script: "engines/check_newton.py" };

pub(super) const RULES: &[Rule] = &[
    TESTED.rule(
        "newton.joint-type",
        Refused,
        Find::Urdf(joints::unknown),
        "Newton refuses the file: it knows no joint of this type.",
        "Use revolute, continuous, prismatic, fixed, floating or planar.",
    ),
    TESTED.rule(
        "newton.mesh-missing",
        Behaves,
        Find::Urdf(meshes::missing),
        "Newton warns and leaves out a mesh that it does not find.",
        "Put the mesh where the file says, relative to the URDF.",
    ),
    TESTED.rule(
        "newton.mesh-uri",
        Behaves,
        Find::Urdf(meshes::by_uri),
        "Newton alone resolves neither package:// nor file://: it warns and leaves the mesh out.",
        "Install resolve-robotics-uri-py, or write a relative path.",
    ),
    TESTED.rule(
        "newton.inertia-triangle",
        Behaves,
        Find::Urdf(mass::triangle),
        "Newton raises impossible moments until A + B >= C, and warns once for all.",
        "Give moments that a body can have.",
    ),
    TESTED.rule(
        "newton.mass-zero",
        Behaves,
        Find::Urdf(mass::zero_or_nothing),
        "Newton keeps a link of mass 0 with an inverse mass of 0: no force moves it.",
        "Give the link a mass.",
    ),
    TESTED.rule(
        "newton.no-inertial",
        Behaves,
        Find::Urdf(mass::shaped_without_inertial),
        "Newton weighs the link by its collision shapes at 1000 kg per cubic metre.",
        "Give the link an <inertial>.",
    ),
    TESTED.rule(
        "newton.continuous-limit",
        Behaves,
        Find::Urdf(joints::continuous_with_range),
        "Newton keeps the range of a continuous joint.",
        "Take lower and upper out if it turns without end.",
    ),
    TESTED.rule(
        "newton.range-missing",
        Behaves,
        Find::Urdf(joints::range_missing),
        "Newton lets a joint without lower and upper move without end.",
        "Write lower and upper, or make it continuous.",
    ),
    TESTED.rule(
        "newton.range-one-sided",
        Behaves,
        Find::Urdf(joints::range_one_sided),
        "Newton takes a missing end of a range for infinite, not for 0.",
        "Write both lower and upper.",
    ),
    TESTED.rule(
        "newton.strength-missing",
        Behaves,
        Find::Urdf(joints::strength_missing),
        "Newton takes a missing effort or velocity for a million.",
        "Write <limit lower upper effort velocity>.",
    ),
    TESTED.rule(
        "newton.floating-origin",
        Behaves,
        Find::Urdf(joints::floating_off),
        "Newton loses the origin of a floating joint: the part starts at the root.",
        "Set the pose of free parts after loading.",
    ),
    TESTED.rule(
        "newton.planar-turn",
        Behaves,
        Find::Urdf(joints::planar),
        "Newton gives a planar joint two slides and no turn.",
        "Use two prismatic joints and a revolute one.",
    ),
    TESTED.rule(
        "newton.link-twice",
        Behaves,
        Find::Urdf(links::twice),
        "Newton makes one body of two links of one name, without a warning.",
        "Give each link a name of its own.",
    ),
    TESTED.rule(
        "newton.axis-zero",
        Behaves,
        Find::Urdf(joints::axis_zero),
        "Newton keeps an axis of 0 0 0, without a warning.",
        "Write an axis of length 1.",
    ),
    TESTED.rule(
        "newton.safety-ignored",
        Behaves,
        Find::Urdf(joints::safety),
        "Newton ignores <safety_controller>: its soft limits do not stop the joint.",
        "Put the range that matters into <limit>.",
    ),
    TESTED.rule(
        "newton.base-fixed",
        Note,
        Find::Urdf(links::bodies_at_root),
        "Newton fixes the root link to the world.",
        "Call add_urdf with floating=True if it is to move.",
    ),
    TESTED.rule(
        "newton.at-origin",
        Note,
        Find::Urdf(links::roots_of_moving),
        "Newton leaves all links at the origin until eval_fk is called.",
        "Call newton.eval_fk on the first state.",
    ),
    TESTED.rule(
        "newton.usd-physx-joint",
        Behaves,
        Find::Usd(usd::physx_alone),
        "Newton does not read PhysX's joint friction and speed: 0 and a million apply.",
        "Write newton:friction and newton:velocityLimit as well.",
    ),
    TESTED.rule(
        "newton.usd-disabled-body",
        Behaves,
        Find::Usd(usd::disabled_bodies),
        "Newton lets a switched-off body fall and leaves its collider hanging.",
        "Take PhysicsRigidBodyAPI off instead.",
    ),
    TESTED.rule(
        "newton.usd-excluded-joint",
        Behaves,
        Find::Usd(usd::excluded_joints),
        "Newton loses the body that hangs on a joint excluded from its articulation.",
        "Keep the joint in the articulation, and compare body counts.",
    ),
    TESTED.rule(
        "newton.usd-free-axis",
        Behaves,
        Find::Usd(usd::free_axes),
        "Newton locks an axis of a PhysicsJoint that no limit mentions.",
        "Give every free axis a wide finite limit.",
    ),
    TESTED.rule(
        "newton.usd-com-inertia",
        Behaves,
        Find::Usd(usd::centre_alone),
        "Newton does not move the collider's moments to the centre of mass that is written.",
        "Write diagonalInertia and principalAxes with centerOfMass.",
    ),
    TESTED.rule(
        "newton.usd-mirrored-visual",
        Looks,
        Find::Usd(usd::mirrored),
        "Newton does not mirror a visual under a negative scale, but its collider.",
        "Bake the mirror into the points.",
    ),
    TESTED.rule(
        "newton.sinks",
        Behaves,
        Find::Urdf(sink::in_newton),
        "Newton's MuJoCo solver lets these joints sink: gravity pulls, and its dry friction is soft.",
        "Set model.mujoco.solimpfriction of the joints to 0.9999, 0.9999, 0.001, 0.5, 2.",
    ),
];
