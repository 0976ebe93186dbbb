//! Rules about Rerun.

use crate::client::Client;
use crate::find::{joints, meshes, shapes};
use crate::rule::Severity::{Behaves, Looks, Note, Refused};
use crate::rule::{Find, Rule, Tested};

const TESTED: Tested =
    Tested { client: Client::Rerun, version: "rerun-sdk 0.41.0", script: "engines/check_rerun.py" };

pub(super) const RULES: &[Rule] = &[
    TESTED.rule(
        "rerun.limit-incomplete",
        Refused,
        Find::Urdf(joints::limit_incomplete),
        "Rerun refuses the file: a <limit> must say effort and velocity.",
        "Write both, even as 0.",
    ),
    TESTED.rule(
        "rerun.joint-type",
        Refused,
        Find::Urdf(joints::unknown),
        "Rerun refuses the file: it knows no joint of this type.",
        "Use revolute, continuous, prismatic, fixed, floating or planar.",
    ),
    TESTED.rule(
        "rerun.axis-length",
        Behaves,
        Find::Urdf(joints::axis_long),
        "Rerun scales the slide by the axis' length.",
        "Write an axis of length 1.",
    ),
    TESTED.rule(
        "rerun.range-missing",
        Behaves,
        Find::Urdf(joints::range_missing),
        "Rerun takes missing ends for 0 and clamps the joint there: it never moves.",
        "Write lower and upper, or make it continuous.",
    ),
    TESTED.rule(
        "rerun.range-one-sided",
        Behaves,
        Find::Urdf(joints::range_one_sided),
        "Rerun takes a missing end of a range for 0 and clamps there.",
        "Write both lower and upper.",
    ),
    TESTED.rule(
        "rerun.continuous-limit",
        Behaves,
        Find::Urdf(joints::continuous_with_range),
        "Rerun does not clamp a continuous joint to its range.",
        "Make the joint revolute if it has stops.",
    ),
    TESTED.rule(
        "rerun.joint-unmoved",
        Behaves,
        Find::Urdf(joints::floating_or_planar),
        "Rerun computes no transform for floating and planar joints: it raises an error.",
        "Log the child's transform yourself.",
    ),
    TESTED.rule(
        "rerun.mesh-missing",
        Looks,
        Find::Urdf(meshes::missing),
        "Rerun warns and leaves out a mesh that it does not find.",
        "Put the mesh where the file says, relative to the URDF.",
    ),
    TESTED.rule(
        "rerun.mesh-package",
        Looks,
        Find::Urdf(meshes::by_package),
        "Rerun finds packages by ROS_PACKAGE_PATH or AMENT_PREFIX_PATH alone; else the mesh is left out.",
        "Set one of them, or write a relative path.",
    ),
    TESTED.rule(
        "rerun.collision-name-twice",
        Looks,
        Find::Urdf(shapes::collisions_twice),
        "Rerun files collisions by name: of two with one name, one is lost.",
        "Give each collision of a link a name of its own.",
    ),
    TESTED.rule(
        "rerun.visual-name-twice",
        Looks,
        Find::Urdf(shapes::visuals_twice),
        "Rerun files visuals by name: of two with one name, one is lost.",
        "Give each visual of a link a name of its own.",
    ),
    TESTED.rule(
        "rerun.mimic-not-followed",
        Note,
        Find::Urdf(joints::followers),
        "Rerun only tells the <mimic>: each joint's transform is computed from its own value.",
        "Compute the follower's value before you log it.",
    ),
];
