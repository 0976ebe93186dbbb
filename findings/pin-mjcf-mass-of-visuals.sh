#!/usr/bin/env bash
# Pinocchio leaves the mass of non-colliding MJCF geoms out of the body.
#
# Guess: a geom with a mass adds to its body in every reader, colliding or not.
# Versions: pin 4.1.0, drake 1.51.1, mujoco 4.0.0 (Python 3.11).
# Behaviour: contype="0" conaffinity="0" only switches contact off in MuJoCo.
#   The geom's mass still counts. Drake agrees. Pinocchio drops it silently.
#   The centre of mass moves as well.
# Seen:
#   mujoco mass 6.0 com_y 0.25
#   drake  mass 6.0 com_y 0.25
#   pin    mass 1.0 com_y 0.0
# Why it matters: a detailed shell of 5 kg with a light collider is common.
#   Gravity compensation from Pinocchio then holds a sixth of the part.
#   Write an explicit <inertial> for every body and all three agree.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
python3 -m venv --without-pip "$d/v"
python3 -m pip --python "$d/v/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: pin==4.1.0 mujoco==4.0.0 drake==1.51.1 numpy==2.4.6
cd "$d"
cat > m.xml <<'X'
<mujoco model="m"><worldbody><body name="part"><joint name="j" type="hinge" axis="0 0 1"/>
 <geom name="collider" type="box" size=".1 .1 .1" mass="1"/>
 <geom name="shell" type="box" size=".1 .1 .1" pos="0 .3 0" mass="5" contype="0" conaffinity="0"/>
</body></worldbody></mujoco>
X
sed 's|<geom name="collider"|<inertial pos="0 .25 0" mass="6" diaginertia=".1 .1 .1"/>&|' m.xml > explicit.xml
cat > t.py <<'P'
import mujoco, pinocchio as pin
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.parsing import Parser
def all_three(f):
    m = mujoco.MjModel.from_xml_path(f); d = mujoco.MjData(m); mujoco.mj_forward(m, d)
    yield "mujoco", float(m.body_mass.sum()), float(d.subtree_com[0][1])
    p = MultibodyPlant(0.0); Parser(p).AddModels(f); p.Finalize(); c = p.CreateDefaultContext()
    yield "drake", p.CalcTotalMass(c), float(p.CalcCenterOfMassPositionInWorld(c)[1])
    q = pin.buildModelFromMJCF(f); e = q.createData()
    yield "pin", pin.computeTotalMass(q), float(pin.centerOfMass(q, e, pin.neutral(q))[1])
got = {}
for f in ("m.xml", "explicit.xml"):
    for n, mass, y in all_three(f):
        got[f, n] = (round(mass, 6), round(y, 6)); print(f, n, "mass", got[f, n][0], "com_y", got[f, n][1])
assert got["m.xml", "mujoco"] == got["m.xml", "drake"] == (6.0, 0.25)
assert got["m.xml", "pin"] == (1.0, 0.0), "the behaviour changed"
assert len({got["explicit.xml", n] for n in ("mujoco", "drake", "pin")}) == 1
print("as stated")
P
"$d/v/bin/python" t.py
