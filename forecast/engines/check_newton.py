"""What Newton does with small files: the tests of the rules `newton.*`."""

import contextlib
import io
import warnings

import numpy as np
from common import *

with contextlib.redirect_stdout(io.StringIO()):
    import warp as wp

    wp.config.quiet = True
    import newton

BIG = 1e6


def load(*parts, **more):
    """The builder of a URDF, and what was warned of."""
    builder = newton.ModelBuilder()
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        builder.add_urdf(robot(*parts), **more)
    return builder, " ".join(str(w.message) for w in said)


def two(a=None, j=None):
    return load(link("base"), a or link("a"), j or joint())


def moments(inertia):
    return np.array(inertia).reshape(3, 3).diagonal()


@rule("newton.inertia-triangle")
def triangle():
    builder, _ = two(link("a", inertial(1, (.01, .01, .05))))
    given, made = moments(builder.body_inertia[1]), moments(builder.finalize().body_inertia.numpy()[1])
    assert np.allclose(given, (.01, .01, .05)) and np.allclose(made, (.04, .04, .08), atol=1e-5), made


@rule("newton.mass-zero")
def massless():
    model = two(link("a", inertial(0, (0, 0, 0))))[0].finalize()
    assert model.body_mass.numpy()[1] == 0 and model.body_inv_mass.numpy()[1] == 0
    model = two(link("a", "", ""))[0].finalize()
    assert model.body_mass.numpy()[1] == 0 and model.body_inv_mass.numpy()[1] == 0


@rule("newton.no-inertial")
def density():
    assert abs(two(link("a", ""))[0].body_mass[1] - 8) < 1e-5


@rule("newton.mesh-missing", "newton.mesh-uri")
def missing():
    path = write("pkg/t.obj", TETRA)
    for name in ("none.obj", "package://pkg/t.obj", "file://" + path):
        builder, said = two(link("a", collision=mesh(name)))
        assert builder.shape_count == 1 and said, name
        assert two(link("a", visual=mesh(name)))[0].shape_count == 2


@rule("newton.continuous-limit")
def continuous():
    builder, _ = two(j=joint(type="continuous"))
    assert (builder.joint_limit_lower[0], builder.joint_limit_upper[0]) == (-1, 1)


@rule("newton.range-missing")
def no_range():
    for limit in ('<limit effort="5" velocity="2"/>', ""):
        builder, _ = two(j=joint(limit=limit))
        assert builder.joint_limit_lower[0] <= -1e10 and builder.joint_limit_upper[0] >= 1e10


@rule("newton.strength-missing")
def no_limit():
    builder, _ = two(j=joint(limit='<limit lower="-1" upper="1"/>'))
    assert builder.joint_effort_limit[0] == builder.joint_velocity_limit[0] == BIG
    builder, _ = two(j=joint(limit=""))
    assert builder.joint_effort_limit[0] == builder.joint_velocity_limit[0] == BIG


@rule("newton.range-one-sided")
def half():
    builder, _ = two(j=joint(limit='<limit lower="-1" effort="5" velocity="2"/>'))
    assert builder.joint_limit_lower[0] == -1 and builder.joint_limit_upper[0] >= 1e10


@rule("newton.floating-origin")
def floating():
    builder, _ = two(j=joint(type="floating"))
    model = builder.finalize()
    state = model.state()
    newton.eval_fk(model, model.joint_q, model.joint_qd, state)
    assert abs(state.body_q.numpy()[1][2]) < 1e-6


@rule("newton.joint-type")
def kinds():
    assert refuses(lambda: two(j=joint(type="ball")), "Unsupported joint type")


@rule("newton.link-twice")
def twice():
    builder, said = load(link("base"), link("a"), link("a", inertial(3)), joint())
    assert builder.body_count == 2 and not said, (builder.body_mass, said)


@rule("newton.axis-zero")
def axis():
    assert not np.any(two(j=joint(axis="0 0 0"))[0].joint_axis[0])


@rule("newton.base-fixed")
def base():
    assert two()[0].joint_type[0] == newton.JointType.FIXED


@rule("newton.at-origin")
def origin():
    model = two()[0].finalize()
    assert model.state().body_q.numpy()[1][2] == 0
    state = model.state()
    newton.eval_fk(model, model.joint_q, model.joint_qd, state)
    assert abs(state.body_q.numpy()[1][2] - 0.5) < 1e-6


@rule("newton.safety-ignored")
def safety():
    more = '<safety_controller soft_lower_limit="-0.5" soft_upper_limit="0.5" k_position="9" k_velocity="9"/>'
    assert two(j=joint(more=more))[0].joint_limit_lower[0] == -1


@rule("newton.planar-turn")
def planar():
    builder, _ = two(j=joint(type="planar"))
    assert builder.joint_dof_count == 2, builder.joint_dof_count


STAGE = '''#usda 1.0
(
    defaultPrim = "W"
    kilogramsPerUnit = 1
    metersPerUnit = 1
    upAxis = "Z"
)
def PhysicsScene "scene"
{
}
def Xform "W"
{
%s}
'''
BODY = '''    def Cube "%s" (
        prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysicsMassAPI"%s]
    )
    {
        double size = 0.2
        float physics:mass = 1
        double3 xformOp:translate = (0, 0, %s)
        uniform token[] xformOpOrder = ["xformOp:translate"]
%s    }
'''
JOINT = '''    def %s "j"%s
    {
        rel physics:body0 = </W/base>
        rel physics:body1 = </W/a>
        point3f physics:localPos0 = (0, 0, 0.5)
%s    }
'''
ROOT = '''    def PhysicsFixedJoint "root"
    {
        rel physics:body1 = </W/base>
    }
'''


EXCLUDED = '''#usda 1.0
(
    defaultPrim = "W"
    kilogramsPerUnit = 1
    metersPerUnit = 1
    upAxis = "Z"
)
def Xform "W"
{
    def PhysicsScene "S"
    {
    }
    def Xform "A" (
        prepend apiSchemas = ["PhysicsArticulationRootAPI"]
    )
    {
        def Xform "base" (
            prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]
        )
        {
            float physics:mass = 1
            float3 physics:diagonalInertia = (.01, .01, .01)
        }
        def Xform "arm" (
            prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]
        )
        {
            float physics:mass = 1
            float3 physics:diagonalInertia = (.01, .01, .01)
            double3 xformOp:translate = (.5, 0, 0)
            uniform token[] xformOpOrder = ["xformOp:translate"]
        }
        def PhysicsFixedJoint "root"
        {
            rel physics:body1 = </W/A/base>
        }
        def PhysicsRevoluteJoint "j"
        {
            rel physics:body0 = </W/A/base>
            rel physics:body1 = </W/A/arm>
            point3f physics:localPos0 = (.5, 0, 0)
            uniform token physics:axis = "Y"
            uniform bool physics:excludeFromArticulation = %s
        }
    }
}
'''


def stage(*parts):
    builder = newton.ModelBuilder()
    with warnings.catch_warnings(record=True):
        warnings.simplefilter("always")
        builder.add_usd(write("m.usda", STAGE % "".join(parts)))
    return builder


def bodies(a=""):
    return BODY % ("base", ', "PhysicsArticulationRootAPI"', 0, ""), BODY % ("a", "", 0.5, a)


HINGE = '''        uniform token physics:axis = "Z"
        float physics:lowerLimit = -30
        float physics:upperLimit = 30
'''


@rule("newton.usd-physx-joint")
def physx():
    api = '''(
        prepend apiSchemas = ["PhysxJointAPI", "PhysxJointAxisAPI:angular"]
    )'''
    more = HINGE + '''        float physxJoint:jointFriction = 0.7
        float physxJoint:maxJointVelocity = 90
        float physxJointAxis:angular:maxJointVelocity = 90
        float physxJointAxis:angular:dynamicFrictionEffort = 0.7
'''
    builder = stage(*bodies(), ROOT, JOINT % ("PhysicsRevoluteJoint", " " + api, more))
    assert builder.joint_friction[-1] == 0 and builder.joint_velocity_limit[-1] >= BIG
    assert abs(builder.joint_limit_upper[-1] - np.pi / 6) < 1e-5


@rule("newton.usd-disabled-body")
def disabled():
    off = "        bool physics:rigidBodyEnabled = 0\n"
    builder = stage(BODY % ("base", "", 0, off))
    assert builder.body_count == 1 and builder.body_mass[0] == 1 and builder.shape_body[0] == -1


@rule("newton.usd-excluded-joint")
def excluded():
    for out, count in ((0, 2), (1, 1)):
        builder = newton.ModelBuilder()
        with warnings.catch_warnings(record=True):
            builder.add_usd(write(f"m{out}.usda", EXCLUDED % out))
        assert builder.body_count == count, builder.body_label


@rule("newton.usd-free-axis")
def free_axis():
    axes = ["transX", "transY", "transZ", "rotX", "rotY"]
    api = ' (\n        prepend apiSchemas = [' + ", ".join(f'"PhysicsLimitAPI:{a}"' for a in axes) + "]\n    )"
    more = "".join(f"        float limit:{a}:physics:low = 1\n        float limit:{a}:physics:high = -1\n" for a in axes)
    builder = stage(*bodies(), ROOT, JOINT % ("PhysicsJoint", api, more))
    assert builder.joint_dof_count == 0, builder.joint_dof_count


@rule("newton.usd-com-inertia")
def centre():
    builder = stage(BODY % ("base", "", 0, "        point3f physics:centerOfMass = (0.2, 0, 0)\n"))
    assert np.allclose(moments(builder.body_inertia[0]), 0.04 / 6, atol=1e-5)


@rule("newton.usd-mirrored-visual")
def mirrored():
    points = '''            point3f[] points = [(0,0,0), (.3,0,0), (0,.2,0), (0,0,.1)]
            int[] faceVertexCounts = [3, 3, 3, 3]
            int[] faceVertexIndices = [0,2,1, 0,1,3, 0,3,2, 1,2,3]
            uniform token subdivisionScheme = "none"
'''
    api = ' (\n            prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsMeshCollisionAPI"]\n        )'
    text = ('    def Xform "part" (\n        prepend apiSchemas = ["PhysicsRigidBodyAPI"]\n    )\n    {\n'
            '    def Xform "left"\n    {\n'
            '        float3 xformOp:scale = (1, -1, 1)\n        uniform token[] xformOpOrder = ["xformOp:scale"]\n'
            f'        def Mesh "seen"\n        {{\n{points}        }}\n'
            f'        def Mesh "felt"{api}\n        {{\n{points}            uniform token purpose = "guide"\n        }}\n    }}\n    }}\n')
    builder, low = stage(text), {}
    for i, name in enumerate(builder.shape_label):
        y = np.array(builder.shape_source[i].vertices) * np.array(builder.shape_scale[i])
        frame = np.array(builder.shape_transform[i])
        u, w = frame[3:6], frame[6]
        low[name.split("/")[-1]] = round(float((y + 2 * np.cross(u, np.cross(u, y) + w * y))[:, 1].min()), 4)
    assert low == {"seen": 0, "felt": -0.2}, low


@rule("newton.sinks")
def sinks():
    # Its solver of that name wants MuJoCo, which it brings as an extra. What creeps there creeps here.
    builder = newton.ModelBuilder()
    newton.solvers.SolverMuJoCo.register_custom_attributes(builder)
    builder.add_urdf(lever(), floating=False)
    model = builder.finalize()
    assert abs(model.joint_friction.numpy()[-1] - 2) < 1e-6
    soft = model.mujoco.solimpfriction.numpy()[-1]
    assert np.allclose(soft, (.9, .95, .001, .5, 2)), soft


if __name__ == "__main__":
    main()
