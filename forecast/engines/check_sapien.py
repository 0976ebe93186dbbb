"""What SAPIEN does with small files: the tests of the rules `sapien.*`."""

import math
import warnings

import numpy as np
from common import *

warnings.simplefilter("ignore")
import sapien

SCENES = []  # an articulation does not keep its scene alive
WIDE = '<limit lower="-3" upper="3" effort="5" velocity="2"/>'


def load(*parts, fixed=True):
    scene = sapien.Scene([sapien.physx.PhysxCpuSystem()])
    SCENES.append(scene)
    loader = scene.create_urdf_loader()
    loader.fix_root_link = fixed
    return loader.load(robot(*parts))


def two(a=None, j=None):
    return load(link("base"), a or link("a"), j or joint())


def hinge(**more):
    return two(j=joint(**more)).active_joints[0]


def body(robot, name="a"):
    return next(x for x in robot.links if x.name == name)


@rule("sapien.joint-friction", "sapien.friction-dropped", "sapien.effort-dropped")
def strength():
    for more in ("", '<dynamics damping="0" friction="0.2"/>'):
        j = hinge(more=more)
        assert abs(j.friction - 0.05) < 1e-6 and j.force_limit > 1e38


@rule("sapien.dynamics-without-damping")
def half_dynamics():
    assert refuses(lambda: hinge(more='<dynamics friction="0.2"/>'), "incompatible function arguments")


@rule("sapien.base-fixed")
def base():
    scene = sapien.Scene([sapien.physx.PhysxCpuSystem()])
    SCENES.append(scene)
    made = scene.create_urdf_loader().load(pair())
    assert made.dof == 1 and made.links[0].joint.type == "fixed"


def follow(*parts):
    """Where the leader j and the follower k come to rest, the leader driven to 0.5."""
    made = load(*parts)
    joints = {j.name: i for i, j in enumerate(made.active_joints)}
    leader = made.active_joints[joints["j"]]
    leader.set_drive_properties(100, 10)
    leader.set_drive_target(0.5)
    for _ in range(800):
        SCENES[-1].step()
    return made.qpos[joints["j"]], made.qpos[joints["k"]]


@rule("sapien.mimic-inverted")
def inverted():
    more = '<mimic joint="j" multiplier="2"/>'
    j, k = follow(link("base"), link("a"), link("b"), joint(limit=WIDE),
                  joint("k", child="b", origin="1 0 .5", limit=WIDE, more=more))
    assert abs(j - 0.5) < 0.05 and abs(k - j / 2) < 0.02, (j, k)


@rule("sapien.mimic-dropped")
def loose():
    more = '<mimic joint="j" multiplier="2"/>'
    j, k = follow(link("base"), link("a"), link("b"), link("c"), joint(limit=WIDE),
                  joint("m", child="b", origin="1 0 .5"),
                  joint("k", parent="b", child="c", origin="1 0 .5", limit=WIDE, more=more))
    assert abs(j - 0.5) < 0.05 and abs(k) < 0.02, (j, k)


@rule("sapien.concave")
def hull():
    write("ell.obj", ELL)
    shape, = body(two(link("a", collision=mesh("ell.obj")))).collision_shapes
    assert len(shape.vertices) == 10, len(shape.vertices)


@rule("sapien.mesh-missing", "sapien.mesh-uri")
def missing():
    path = write("t.obj", TETRA)
    for name in ("none.obj", "package://pkg/t.obj", "file://" + path):
        assert not body(two(link("a", collision=mesh(name)))).collision_shapes
    write("pkg/t.obj", TETRA)
    assert body(two(link("a", collision=mesh("package://pkg/t.obj")))).collision_shapes


@rule("sapien.no-inertial", "sapien.mass-zero")
def density():
    for weight in ("", inertial(0, (0, 0, 0)), inertial(1, (0, 0, 0))):
        assert abs(body(two(link("a", weight))).mass - 8) < 1e-5


@rule("sapien.no-mass")
def nothing():
    assert body(two(link("a", "", ""))).mass < 2e-6


@rule("sapien.limit-missing")
def no_limit():
    assert refuses(lambda: hinge(limit=""), "Require joint limit")


@rule("sapien.slide-range-missing")
def no_slide_range():
    for limit in ('lower="-1"', 'upper="1"', ""):
        limit = f'<limit {limit} effort="5" velocity="2"/>'
        assert refuses(lambda: hinge(type="prismatic", limit=limit), "unsupported operand")


@rule("sapien.range-missing")
def no_range():
    for limit in ('lower="-1"', 'upper="1"', ""):
        limits = hinge(limit=f'<limit {limit} effort="5" velocity="2"/>').limits[0]
        assert any(math.isnan(x) for x in limits)


@rule("sapien.continuous-limit")
def continuous():
    assert np.isinf(hinge(type="continuous").limits).all()


@rule("sapien.floating-joint")
def floating():
    assert refuses(lambda: two(j=joint(type="floating")), "multiple objects")


@rule("sapien.joint-type")
def kinds():
    assert refuses(lambda: two(j=joint(type="ball")), "Unsupported joint type")
    assert refuses(lambda: two(j=joint(type="planar")))


@rule("sapien.link-twice")
def twice():
    assert refuses(lambda: load(link("base"), link("a"), link("a"), joint()), "Two links")


@rule("sapien.safety-ignored")
def safety():
    more = '<safety_controller soft_lower_limit="-0.5" soft_upper_limit="0.5" k_position="9" k_velocity="9"/>'
    assert hinge(more=more).limits[0][0] == -1


@rule("sapien.sinks")
def sinks():
    scene = sapien.Scene([sapien.physx.PhysxCpuSystem()])
    loader = scene.create_urdf_loader()
    loader.fix_root_link = True
    robot = loader.load(lever())
    for _ in range(500):
        scene.step()
    assert abs(robot.get_qpos()[0] - 1.5) < 0.05, robot.get_qpos()


if __name__ == "__main__":
    main()
