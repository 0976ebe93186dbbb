"""What the converter inside Isaac Sim's URDF importer makes of small files: rules `isaac.*`.

Isaac Sim itself does not install as a Python package. Its importer begins with `urdf-usd-converter`,
which does, and this asks what that writes. What the simulator does after that is not tested.
"""

import itertools
import logging

import urdf_usd_converter
from common import *
from pxr import Usd, UsdGeom, UsdPhysics

NUMBERS = itertools.count()  # USD remembers layers by name
STAGES = []  # a prim does not keep its stage alive
logging.disable(logging.WARNING)


def load(*parts):
    made = urdf_usd_converter.Converter().convert(robot(*parts), f"out{next(NUMBERS)}")
    STAGES.append(Usd.Stage.Open(made.path))
    return STAGES[-1]


def two(a=None, j=None):
    return load(link("base"), a or link("a"), j or joint())


def hinge(**more):
    return UsdPhysics.RevoluteJoint.Get(two(j=joint(**more)), "/m/Physics/j")


def shapes(stage):
    """What is drawn or felt of link `a`."""
    prims = Usd.PrimRange(stage.GetPrimAtPath("/m/Geometry/base/a"), Usd.TraverseInstanceProxies())
    return [p for p in prims if p.IsA(UsdGeom.Gprim)]


@rule("isaac.mesh-format")
def formats():
    glb("t.glb")
    stl("t.stl")
    assert not shapes(two(link("a", collision=mesh("t.glb"))))
    assert len(shapes(two(link("a", visual=mesh("t.glb"))))) == 1  # the collision box
    assert len(shapes(two(link("a", collision=mesh("t.stl"))))) == 1


@rule("isaac.mesh-missing")
def missing():
    assert not shapes(two(link("a", collision=mesh("none.obj"))))
    assert len(shapes(two(link("a", visual=mesh("none.obj"))))) == 1


@rule("isaac.axis-zero")
def axis():
    assert refuses(lambda: two(j=joint(axis="0 0 0")), "cannot be (0, 0, 0)")


@rule("isaac.mesh-package")
def package():
    write("pkg/p.obj", TETRA)
    write("q.obj", TETRA)
    assert not shapes(two(link("a", collision=mesh("package://pkg/p.obj"))))
    assert shapes(two(link("a", collision=mesh("package://pkg/q.obj"))))


@rule("isaac.concave")
def hull():
    write("ell.obj", ELL)
    shape, = shapes(two(link("a", collision=mesh("ell.obj"))))
    assert UsdPhysics.MeshCollisionAPI(shape).GetApproximationAttr().Get() == "convexHull"


@rule("isaac.capsule-dropped")
def capsule():
    assert not shapes(two(link("a", collision='<geometry><capsule radius="0.1" length="0.3"/></geometry>')))


@rule("isaac.continuous-limit")
def continuous():
    j = hinge(type="continuous")
    assert not j.GetLowerLimitAttr().HasAuthoredValue() and not j.GetUpperLimitAttr().HasAuthoredValue()


@rule("isaac.range-missing")
def no_range():
    for limit in ('<limit effort="5" velocity="2"/>', ""):
        j = hinge(limit=limit)
        assert j.GetLowerLimitAttr().Get() == j.GetUpperLimitAttr().Get() == 0


@rule("isaac.range-one-sided")
def half():
    j = hinge(limit='<limit lower="-1" effort="5" velocity="2"/>')
    assert j.GetUpperLimitAttr().Get() == 0 and j.GetLowerLimitAttr().Get() < -57


@rule("isaac.floating-joint")
def floating():
    stage = two(j=joint(type="floating"))
    assert not stage.GetPrimAtPath("/m/Physics/j") and stage.GetPrimAtPath("/m/Geometry/base/a")


@rule("isaac.planar-limit")
def planar():
    prim = two(j=joint(type="planar")).GetPrimAtPath("/m/Physics/j")
    assert not [s for s in prim.GetAppliedSchemas() if s in ("PhysicsLimitAPI:transX", "PhysicsLimitAPI:transY")]


@rule("isaac.joint-type")
def kinds():
    assert refuses(lambda: two(j=joint(type="ball")), "Invalid joint type")


@rule("isaac.link-twice")
def twice():
    assert refuses(lambda: load(link("base"), link("a"), link("a"), joint()), "already exists")


@rule("isaac.no-inertial")
def no_inertial():
    prim = two(link("a", "")).GetPrimAtPath("/m/Geometry/base/a")
    assert not prim.HasAPI(UsdPhysics.MassAPI) or not UsdPhysics.MassAPI(prim).GetMassAttr().HasAuthoredValue()


@rule("isaac.base-fixed")
def base():
    assert two().GetPrimAtPath("/m/Physics/root_joint").IsA(UsdPhysics.FixedJoint)


@rule("isaac.limit-incomplete")
def incomplete():
    j = hinge(limit='<limit lower="-1" upper="1"/>').GetPrim()
    assert j.GetAttribute("newton:velocityLimit").Get() == 0 and j.GetAttribute("urdf:limit:effort").Get() == 0


@rule("isaac.names")
def names():
    stage = load(link("base"), link("2 a-b"), joint("j.1", child="2 a-b"))
    found = sorted(p.GetName() for p in stage.Traverse() if p.IsA(UsdPhysics.RevoluteJoint))
    assert found and found != ["j.1"], found


if __name__ == "__main__":
    main()
