"""What Drake does with small files: the tests of the rules `drake.*`."""

import logging

import numpy as np
from common import *
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import JointActuatorIndex
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

SAID = []


class Ear(logging.Handler):
    def emit(self, record):
        SAID.append(record.getMessage())


logging.getLogger("drake").handlers = [Ear()]
logging.getLogger("drake").propagate = False
MOTOR = ('<transmission name="t"><type>transmission_interface/SimpleTransmission</type><joint name="j">'
         '<hardwareInterface>EffortJointInterface</hardwareInterface></joint><actuator name="m">'
         '<mechanicalReduction>1</mechanicalReduction></actuator></transmission>')


def build(*parts, weld=True):
    SAID.clear()
    builder = DiagramBuilder()
    plant, scene = AddMultibodyPlantSceneGraph(builder, 0.001)
    Parser(plant).AddModels(robot(*parts))
    if weld:
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base"))
    plant.Finalize()
    return plant, scene, builder


def load(*parts, **more):
    return build(*parts, **more)[0]


def two(a=None, j=None, *more, **how):
    return load(link("base"), a or link("a"), j or joint(), *more, **how)


def said(words):
    return any(words in text for text in SAID)


def limits(plant, name="j"):
    j = plant.GetJointByName(name)
    return float(j.position_lower_limits()[0]), float(j.position_upper_limits()[0])


@rule("drake.no-actuator")
def actuators():
    assert two().num_actuators() == 0 and not SAID
    plant = two(None, None, MOTOR)
    assert plant.get_joint_actuator(JointActuatorIndex(0)).effort_limit() == 5


@rule("drake.effort-zero")
def no_effort():
    none = joint(limit='<limit lower="-1" upper="1" effort="0" velocity="2"/>')
    assert two(None, none, MOTOR).num_actuators() == 0 and said("zero effort limit")


def inertia(plant):
    body = plant.GetBodyByName("a").default_spatial_inertia()
    return body.get_mass(), body.CalcRotationalInertia().get_moments()


@rule("drake.inertia-triangle")
def triangle():
    mass, moments = inertia(two(link("a", inertial(1, (.01, .01, .05)))))
    ball = 0.4 * (3 / (4 * np.pi * 1000)) ** (2 / 3)  # 1 kg of water
    assert said("triangle inequality") and abs(mass - 1) < 1e-9 and np.allclose(moments, ball), moments


@rule("drake.mass-zero")
def impossible():
    for weight in (inertial(0, (1, 1, 1)), inertial(-1)):
        mass, _ = inertia(two(link("a", weight)))
        assert abs(mass - 1) < 1e-9 and said("mass > 0")


@rule("drake.no-mass")
def massless():
    for weight in ("", inertial(0, (0, 0, 0))):
        _, _, builder = build(link("base"), link("a", weight), joint())
        simulator = Simulator(builder.Build())
        assert refuses(lambda: simulator.AdvanceTo(0.01), "not positive-definite")


@rule("drake.mesh-format")
def formats():
    glb("t.glb")
    stl("t.stl")
    write("t.dae", "<COLLADA/>")
    for name in ("t.glb", "t.stl", "t.dae"):
        assert refuses(lambda: two(link("a", collision=mesh(name))), "unsupported extension")
        assert two(link("a", visual=mesh(name))).num_bodies() == 3


@rule("drake.mesh-missing")
def missing():
    for a in (link("a", collision=mesh("none.obj")), link("a", visual=mesh("none.obj"))):
        assert refuses(lambda: two(a), "does not exist")


@rule("drake.mesh-package")
def package():
    write("meshes/t.obj", TETRA)
    here = "package://pkg/meshes/t.obj"
    assert refuses(lambda: two(link("a", collision=mesh(here))), "unknown package")


@rule("drake.concave")
def hull():
    write("ell.obj", ELL)
    plant, scene, builder = build(link("base"), link("a", collision=mesh("ell.obj")), joint())
    probe = scene.get_query_output_port()
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    query = probe.Eval(scene.GetMyContextFromRoot(context))
    a = plant.GetCollisionGeometriesForBody(plant.GetBodyByName("a"))[0]
    hull = scene.model_inspector().GetConvexHull(a)
    assert hull is not None and hull.num_vertices() == 10


@rule("drake.continuous-limit")
def continuous():
    assert limits(two(None, joint(type="continuous"))) == (-1, 1)


@rule("drake.friction-dropped")
def friction():
    two(None, joint(more='<dynamics friction="0.2"/>'))
    assert said("does not currently support non-zero joint friction")


@rule("drake.floating-joint")
def floating():
    plant = two(None, joint(type="floating"))
    assert said("Leaving 'a' as a free body") and not plant.HasJointNamed("j")


@rule("drake.planar-limit")
def planar():
    plant = two(None, joint(type="planar"))
    assert plant.num_velocities() == 3 and limits(plant) == (-np.inf, np.inf)


@rule("drake.joint-type")
def kinds():
    assert refuses(lambda: two(None, joint(type="ball")), "custom joint type")


@rule("drake.material-undefined")
def material():
    a = link("a", more=f'<visual>{BOX}<material name="nobody"/></visual>')
    assert refuses(lambda: two(a), "not previously defined")


@rule("drake.link-twice")
def twice():
    assert refuses(lambda: load(link("base"), link("a"), link("a"), joint()), "unique")


@rule("drake.axis-zero")
def axis():
    assert refuses(lambda: two(None, joint(axis="0 0 0")), "axis is zero")


@rule("drake.base-free")
def base():
    assert two(weld=False).num_velocities() == 7 and two().num_velocities() == 1


@rule("drake.safety-ignored")
def safety():
    two(None, joint(more='<safety_controller soft_lower_limit="-0.5" k_position="9" k_velocity="9"/>'))
    assert said("safety_controller")


@rule("drake.range-missing")
def unlimited():
    for limit in ('<limit effort="5" velocity="2"/>', ""):
        assert limits(two(None, joint(limit=limit))) == (-np.inf, np.inf)


@rule("drake.range-one-sided")
def half():
    assert limits(two(None, joint(limit='<limit lower="-1" effort="5" velocity="2"/>'))) == (-1, np.inf)


@rule("drake.sinks")
def sinks():
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, 0.001)
    Parser(plant).AddModels(lever())
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base"))
    plant.Finalize()
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(5)
    q = plant.GetPositions(plant.GetMyContextFromRoot(simulator.get_context()))
    assert abs(q[0] - 1.5) < 0.05, q


if __name__ == "__main__":
    main()
