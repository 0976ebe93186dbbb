"""What MuJoCo does with small files: the tests of the rules `mujoco.*`."""

import os

import mujoco
from common import *

RANGE = '<limit lower="{}" upper="{}" effort="5" velocity="2"/>'
FREE = '<limit effort="5" velocity="2"/>'


def load(path):
    return mujoco.MjModel.from_xml_path(path)


@rule("mujoco.visuals-dropped")
def visuals():
    assert load(pair()).ngeom == load(pair(a=link("a", visual=BOX))).ngeom == 2


@rule("mujoco.fixed-fused")
def fused():
    m = load(robot(link("base"), link("a"), link("b"), joint(), joint("k", "fixed", "a", "b", "", "")))
    assert m.nbody == 2 and m.body_mass[1] == 2


@rule("mujoco.base-welded", "mujoco.no-actuator")
def welded():
    m = load(pair())
    assert m.nv == 1 and m.nu == 0 and sum(m.body_mass) == 1


@rule("mujoco.inertia-triangle")
def triangle():
    assert refuses(lambda: load(pair(a=link("a", inertial(1, (.01, .01, .05))))), "A + B >= C")


@rule("mujoco.mass-zero")
def massless():
    for weight in (inertial(0, (0, 0, 0)), inertial(1, (0, 0, 0)), inertial(-1)):
        assert refuses(lambda: load(pair(a=link("a", weight))), "mjMINVAL")


@rule("mujoco.no-mass")
def nothing():
    assert refuses(lambda: load(pair(a=link("a", "", ""))), "mjMINVAL")


@rule("mujoco.no-inertial")
def density():
    assert abs(load(pair(a=link("a", ""))).body_mass[1] - 8) < 1e-9


@rule("mujoco.mesh-format")
def formats():
    glb("t.glb")
    write("t.dae", "<COLLADA/>")
    for name in ("t.glb", "t.dae"):
        assert refuses(lambda: load(pair(a=link("a", collision=mesh(name)))), "no decoder")
        assert load(pair(a=link("a", visual=mesh(name)))).ngeom == 2


@rule("mujoco.mesh-flat")
def flat():
    write("sheet.obj", SHEET)
    assert refuses(lambda: load(pair(a=link("a", collision=mesh("sheet.obj")))), "coplanar")


@rule("mujoco.stl-text")
def stl_text():
    face = "facet normal 0 0 1\nouter loop\n{}endloop\nendfacet\n"
    corners = "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n", "vertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1\n"
    write("t.stl", "solid t\n" + "".join(map(face.format, corners)) + "endsolid\n")
    assert refuses(lambda: load(pair(a=link("a", collision=mesh("t.stl")))), "perhaps this is an ASCII file")


@rule("mujoco.stl-faces")
def stl_faces():
    count = 200_001
    write("t.stl", b" " * 80 + count.to_bytes(4, "little") + bytes(50 * count))
    assert refuses(lambda: load(pair(a=link("a", collision=mesh("t.stl")))), "between 1 and 200000")


@rule("mujoco.mesh-missing")
def missing():
    assert refuses(lambda: load(pair(a=link("a", collision=mesh("none.obj")))), "Error opening file")
    assert load(pair(a=link("a", visual=mesh("none.obj")))).ngeom == 2


@rule("mujoco.mesh-uri")
def uri():
    path = write("pkg/t.obj", TETRA)
    for name in ("package://pkg/t.obj", "file://" + path):
        assert refuses(lambda: load(pair(a=link("a", collision=mesh(name)))), "Error opening file")


@rule("mujoco.concave")
def hull():
    write("ell.obj", ELL)
    m = load(pair(a=link("a", collision=mesh("ell.obj"))))
    d = mujoco.MjData(m)
    mujoco.mj_forward(m, d)
    # The hollow of the L is filled: a ball that fits into it is inside.
    ball = ('<mujoco><asset><mesh file="ell.obj"/></asset><worldbody><geom type="mesh" mesh="ell"/>'
            '<body pos=".4 .4 .1"><freejoint/><geom size=".05"/></body></worldbody></mujoco>')
    m = load(write("b.xml", ball))
    d = mujoco.MjData(m)
    mujoco.mj_forward(m, d)
    assert d.ncon > 0


@rule("mujoco.velocity-dropped")
def velocity():
    m = load(pair(j=joint(limit='<limit lower="-99" upper="99" effort="5" velocity="0.1"/>')))
    d = mujoco.MjData(m)
    d.qfrc_applied[0] = 1
    for _ in range(100):
        mujoco.mj_step(m, d)
    assert d.qvel[0] > 1


@rule("mujoco.effort-zero")
def no_effort():
    assert not load(pair(j=joint(limit='<limit lower="-1" upper="1" effort="0" velocity="2"/>'))).jnt_actfrclimited[0]


@rule("mujoco.continuous-limit")
def continuous():
    assert not load(pair(j=joint(type="continuous"))).jnt_limited[0]


@rule("mujoco.range-zero")
def zero():
    for at in (0, 0.5):
        assert not load(pair(j=joint(limit=RANGE.format(at, at)))).jnt_limited[0]


@rule("mujoco.range-missing")
def unlimited():
    for limit in (FREE, ""):
        assert not load(pair(j=joint(limit=limit))).jnt_limited[0]


@rule("mujoco.range-one-sided")
def one_sided():
    for limit in ('lower="-1"', 'upper="1"'):
        m = load(pair(j=joint(limit=f'<limit {limit} effort="5" velocity="2"/>')))
        assert not m.jnt_limited[0], m.jnt_range


@rule("mujoco.link-twice")
def twice():
    assert refuses(lambda: load(robot(link("base"), link("a"), link("a"), joint())), "repeated")


@rule("mujoco.axis-zero")
def axis():
    assert refuses(lambda: load(pair(j=joint(axis="0 0 0"))), "axis too small")


@rule("mujoco.joint-type")
def kinds():
    assert refuses(lambda: load(pair(j=joint(type="ball"))), "invalid joint type")


@rule("mujoco.planar-limit")
def planar():
    m = load(pair(j=joint(type="planar")))
    assert list(m.jnt_limited) == [1, 0, 0] and m.nv == 3


@rule("mujoco.mimic-soft")
def mimic():
    m = load(robot(link("base"), link("a"), link("b"), joint(),
                   joint("k", child="b", more='<mimic joint="j" multiplier="2" offset="0.1"/>')))
    assert m.neq == 1 and m.nv == 2 and list(m.eq_data[0][:2]) == [0.1, 2]


@rule("mujoco.safety-ignored")
def safety():
    more = '<safety_controller soft_lower_limit="-0.5" soft_upper_limit="0.5" k_position="9" k_velocity="9"/>'
    assert list(load(pair(j=joint(more=more))).jnt_range[0]) == [-1, 1]


ARM = ('<mujoco>{}<worldbody><body name="a">{}<joint name="j" {}/><geom size=".1"/>{}</body>'
       '</worldbody></mujoco>')


def arm(head="", weight="", joint="", more=""):
    return load(write("m.xml", ARM.format(head, weight, joint, more)))


@rule("mujoco.mjcf-degrees")
def degrees():
    m = arm(joint='range="-1.57 1.57"')
    assert abs(m.jnt_range[0][1] - 1.57 * 3.14159265 / 180) < 1e-6
    assert abs(arm('<compiler angle="radian"/>', joint='range="-1.57 1.57"').jnt_range[0][1] - 1.57) < 1e-9


@rule("mujoco.mjcf-range-zero")
def mjcf_zero():
    assert not arm(joint='range="0 0"').jnt_limited[0]


@rule("mujoco.mjcf-visual-mass")
def mjcf_mass():
    one = arm().body_mass[1]
    more = '<geom size=".1" contype="0" conaffinity="0"/>'
    assert abs(arm(more=more).body_mass[1] - 2 * one) < 1e-9
    assert arm(weight='<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>', more=more).body_mass[1] == 1


@rule("mujoco.mjcf-autolimits-off")
def mjcf_auto():
    head = '<compiler autolimits="false"/>'
    assert refuses(lambda: arm(head, joint='range="-10 10"'), "not `limited`")


@rule("mujoco.mjcf-inertial-overruled")
def mjcf_overruled():
    weight = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
    head = '<compiler inertiafromgeom="true"/>'
    assert abs(arm(head, weight).body_mass[1] - 4.18879) < 1e-4 and arm(weight=weight).body_mass[1] == 1


@rule("mujoco.friction-creeps")
def creeps():
    def after(option):
        text = open(lever()).read().replace("</robot>", f"<mujoco>{option}</mujoco></robot>")
        model = mujoco.MjModel.from_xml_path(write("creeps.urdf", text))
        data = mujoco.MjData(model)
        while data.time < 5:
            mujoco.mj_step(model, data)
        return float(data.qpos[0])
    assert abs(after("") - 0.2433) < 0.005, after("")
    assert abs(after('<option noslip_iterations="20"/>')) < 1e-6


if __name__ == "__main__":
    main()
