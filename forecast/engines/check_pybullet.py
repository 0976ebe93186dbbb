"""What PyBullet does with small files: the tests of the rules `pybullet.*`."""

import itertools

import pybullet as pb
from common import *

NUMBERS = itertools.count()  # PyBullet remembers files by name
WIDE = '<limit lower="-100" upper="100" effort="{}" velocity="{}"/>'
OFF = ('<inertial><origin xyz="0.5 0 0"/><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" '
       'ixy="0" ixz="0" iyz="0"/></inertial>')


def load(*parts, base=True, **more):
    pb.resetSimulation()
    pb.setGravity(0, 0, -9.81)
    return pb.loadURDF(robot(*parts, path=f"m{next(NUMBERS)}.urdf"), useFixedBase=base, **more)


def two(a=None, j=None, **more):
    return load(link("base"), a or link("a"), j or joint(), **more)


def push(body, torque, steps=240):
    """Position and speed after a second of torque, motor off and no gravity."""
    pb.setGravity(0, 0, 0)
    pb.setJointMotorControl2(body, 0, pb.VELOCITY_CONTROL, force=0)
    for _ in range(steps):
        pb.setJointMotorControl2(body, 0, pb.TORQUE_CONTROL, force=torque)
        pb.stepSimulation()
    return pb.getJointState(body, 0)[:2]


def close(a, b, by=1e-6):
    return all(abs(x - y) <= by for x, y in zip(a, b, strict=True))


@rule("pybullet.inertia-ignored")
def inertia():
    given = link("a", inertial(1, (.02, .03, .04)))
    assert close(pb.getDynamicsInfo(two(given), 0)[2], [0.2 * 0.2 * 2 / 12] * 3)
    beside = '<collision><origin xyz="0.4 0 0"/>' + BOX + "</collision>"
    both = pb.getDynamicsInfo(two(link("a", inertial(1, (.02, .03, .04)), more=beside)), 0)[2]
    assert close(both, (.08 / 12, .4 / 12, .4 / 12), 2e-3), both
    ball = '<geometry><sphere radius="0.1"/></geometry>'
    assert close(pb.getDynamicsInfo(two(link("a", collision=ball)), 0)[2], [0.004] * 3)
    rod = '<geometry><cylinder radius="0.1" length="0.4"/></geometry>'
    assert close(pb.getDynamicsInfo(two(link("a", collision=rod)), 0)[2], (.2 / 12, .2 / 12, .08 / 12), 1e-3)
    assert close(pb.getDynamicsInfo(two(given, flags=pb.URDF_USE_INERTIA_FROM_FILE), 0)[2], [.02, .03, .04])


@rule("pybullet.inertia-without-collision")
def speck():
    assert max(pb.getDynamicsInfo(two(link("a", collision="")), 0)[2]) < 1e-6


@rule("pybullet.motors-hold")
def motors():
    body = two(link("a", OFF), joint(axis="0 1 0", limit='<limit lower="-2" upper="2" effort="0.1" velocity="2"/>'))
    for _ in range(480):
        pb.stepSimulation()
    state = pb.getJointState(body, 0)
    assert abs(state[0]) < 1e-6 and abs(state[3]) > 40 * 0.1


@rule("pybullet.base-free")
def base():
    body = load(link("base"), link("a"), joint(), base=False)
    for _ in range(60):
        pb.stepSimulation()
    assert pb.getBasePositionAndOrientation(body)[0][2] < -0.1


@rule("pybullet.no-inertial")
def no_inertial():
    for collision in (BOX, ""):
        assert pb.getDynamicsInfo(two(link("a", "", collision)), 0)[0] == 1


@rule("pybullet.mimic-dropped")
def mimic():
    body = load(link("base"), link("a"), link("b"), joint(),
                joint("k", child="b", origin="1 0 .5", limit=WIDE.format(5, 2),
                      more='<mimic joint="j" multiplier="2"/>'))
    pb.setJointMotorControl2(body, 1, pb.VELOCITY_CONTROL, force=0)
    assert push(body, 0.05)[0] > 0.9 and abs(pb.getJointState(body, 1)[0]) < 1e-6


@rule("pybullet.concave")
def hull():
    write("ell.obj", ELL)
    two(link("a", collision=mesh("ell.obj")))
    hit = pb.rayTest([.4, .4, 2], [.4, .4, -1])[0]
    assert hit[0] == 0 and abs(hit[3][2] - 0.7) < 0.01


@rule("pybullet.mesh-format")
def formats():
    glb("t.glb")
    write("t.gltf", "{}")
    write("t.ply", "ply\n")
    for name in ("t.glb", "t.gltf", "t.ply"):
        assert refuses(lambda: two(link("a", collision=mesh(name))), "Cannot load")
        assert refuses(lambda: two(link("a", visual=mesh(name))), "Cannot load")


@rule("pybullet.mesh-missing")
def missing():
    assert refuses(lambda: two(link("a", collision=mesh("none.obj"))), "Cannot load")
    assert refuses(lambda: two(link("a", visual=mesh("none.obj"))), "Cannot load")


@rule("pybullet.mesh-package")
def package():
    write("q.obj", TETRA)
    assert refuses(lambda: two(link("a", visual=mesh("package://nobody/q.obj"))), "Cannot load")
    write("somebody/q.obj", TETRA)
    assert pb.getNumJoints(two(link("a", visual=mesh("package://somebody/q.obj")))) == 1


@rule("pybullet.self-collision-off")
def selves():
    parts = link("base"), link("a"), link("b"), joint(), joint("k", parent="a", child="b", origin="0.05 0 -0.5")
    body = load(*parts)
    pb.stepSimulation()
    assert not pb.getContactPoints(body, body)
    body = load(*parts, flags=pb.URDF_USE_SELF_COLLISION)
    pb.stepSimulation()
    assert pb.getContactPoints(body, body)


@rule("pybullet.continuous-limit")
def continuous():
    body = two(j=joint(type="continuous"))
    assert pb.getJointInfo(body, 0)[8:10] == (-1, 1) and push(body, 0.05)[0] > 2


@rule("pybullet.limit-missing")
def no_limit():
    for kind in ("revolute", "prismatic"):
        assert refuses(lambda: two(j=joint(type=kind, limit="")), "Cannot load")


@rule("pybullet.range-missing")
def no_range():
    assert push(two(j=joint(limit='<limit effort="5" velocity="2"/>')), 0.05)[0] > 2


@rule("pybullet.range-one-sided")
def half():
    info = pb.getJointInfo(two(j=joint(limit='<limit lower="-2" effort="5" velocity="2"/>')), 0)
    assert info[8:10] == (-2, -1)
    info = pb.getJointInfo(two(j=joint(limit='<limit upper="2" effort="5" velocity="2"/>')), 0)
    assert info[8:10] == (0, 2)


@rule("pybullet.limits-not-kept")
def strength():
    assert push(two(j=joint(limit=WIDE.format(0.01, 2))), 0.2)[1] > 20


@rule("pybullet.friction-dropped")
def friction():
    free = push(two(j=joint(limit=WIDE.format(5, 200))), 0.05)
    rubbed = push(two(j=joint(limit=WIDE.format(5, 200), more='<dynamics friction="0.2"/>')), 0.05)
    assert free == rubbed


@rule("pybullet.axis-length")
def length():
    def at(axis):
        body = two(j=joint(type="prismatic", axis=axis))
        pb.resetJointState(body, 0, 0.5)
        return pb.getLinkState(body, 0, computeForwardKinematics=1)[0][2]
    assert abs(at("0 0 1") - 1) < 1e-6 and abs(at("0 0 2") - 1.5) < 1e-6


@rule("pybullet.axis-zero")
def no_axis():
    body = two(j=joint(type="prismatic", axis="0 0 0"))
    pb.resetJointState(body, 0, 0.5)
    assert abs(pb.getLinkState(body, 0, computeForwardKinematics=1)[0][2] - 0.5) < 1e-6


@rule("pybullet.floating-fixed")
def floating():
    assert pb.getJointInfo(two(j=joint(type="floating")), 0)[2] == pb.JOINT_FIXED


@rule("pybullet.joint-type")
def kinds():
    assert refuses(lambda: two(j=joint(type="ball")), "Cannot load")


@rule("pybullet.link-twice")
def twice():
    assert refuses(lambda: load(link("base"), link("a"), link("a"), joint()), "Cannot load")


@rule("pybullet.mass-zero")
def massless():
    body = two(link("a", inertial(0, (0, 0, 0))))
    assert pb.getDynamicsInfo(body, 0)[0] == 0
    position, speed = push(body, 5)
    assert abs(position) < 1e-6 and abs(speed) < 1e-6


@rule("pybullet.material-undefined")
def material():
    body = two(link("a", more=f'<visual>{BOX}<material name="nobody"/></visual>'))
    assert pb.getVisualShapeData(body)[-1][7] == (1, 1, 1, 1)


@rule("pybullet.mesh-colours")
def colours():
    write("two.mtl", "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n")
    corners, _ = TETRA.split("f ", 1)
    write("two.obj", "mtllib two.mtl\n" + corners + "usemtl red\nf 1 3 2\nf 1 2 4\nusemtl blue\nf 1 4 3\nf 2 3 4\n")
    shown = [s for s in pb.getVisualShapeData(two(link("a", visual=mesh("two.obj")))) if s[1] == 0]
    assert len(shown) == 1


@rule("pybullet.safety-ignored")
def safety():
    more = '<safety_controller soft_lower_limit="-0.5" soft_upper_limit="0.5" k_position="9" k_velocity="9"/>'
    assert push(two(j=joint(more=more)), 0.05)[0] > 0.99


@rule("pybullet.sinks")
def sinks():
    pb.resetSimulation()
    pb.setGravity(0, 0, -9.81)
    body = pb.loadURDF(lever(f"m{next(NUMBERS)}.urdf"), useFixedBase=True)
    pb.setJointMotorControl2(body, 0, pb.VELOCITY_CONTROL, force=0)
    for _ in range(5 * 240):
        pb.stepSimulation()
    assert abs(pb.getJointState(body, 0)[0] - 1.5) < 0.05


if __name__ == "__main__":
    pb.connect(pb.DIRECT)
    main()
