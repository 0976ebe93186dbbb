#!/usr/bin/env bash
# An MJCF joint with ref= has three different reaches in three readers.
#
# Guess: Pinocchio and the USD converter reach the same poses as MuJoCo.
# Versions: mujoco 4.0.0, pin 4.1.0, mujoco-usd-converter 0.8.0, usd-exchange 3.0.1 (Python 3.11).
# Behaviour: ref="20" names the drawn pose 20 degrees. The range -30 60 counts from there.
#   So the arm may turn from -50 to +40 degrees, seen from the drawn pose.
#   Pinocchio moves the zero pose by ref and then shifts the range by ref as well.
#   The converter leaves the range as it is, though USD has no ref.
#   Neither warns. Newton and Drake are right here.
# Seen (reach in degrees from the drawn pose):
#   mujoco -50 .. 40   pin -70 .. 20   usd -30 .. 60
# Why it matters: a planner or a USD engine drives the part 20 degrees into a wall.
#   Write joints with ref="0" and put the rest pose into a keyframe.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
venv() { local n=$1; shift; python3 -m venv --without-pip "$d/$n"; python3 -m pip --python "$d/$n/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: "$@"; }
venv a mujoco==4.0.0 pin==4.1.0 numpy==2.4.6
venv b mujoco-usd-converter==0.8.0 usd-exchange==3.0.1
cd "$d"
cat > m.xml <<'X'
<mujoco model="m"><worldbody><body name="arm">
 <joint name="j" type="hinge" axis="0 1 0" limited="true" range="-30 60" ref="20"/>
 <geom type="box" size=".2 .05 .05" pos=".2 0 0" mass="2"/></body></worldbody></mujoco>
X
cat > reach.py <<'P'
import math, mujoco, numpy as np, pinocchio as pin
def turn(R): return round(math.degrees(math.atan2(R[0, 2], R[0, 0])))  # about y, 0 = as drawn
m = mujoco.MjModel.from_xml_path("m.xml"); d = mujoco.MjData(m); mj = []
for q in m.jnt_range[0]:
    d.qpos[0] = q; mujoco.mj_forward(m, d); mj.append(turn(d.body("arm").xmat.reshape(3, 3)))
p = pin.buildModelFromMJCF("m.xml"); e = p.createData(); pn = []
for q in (p.lowerPositionLimit, p.upperPositionLimit):
    pin.forwardKinematics(p, e, np.array(q)); pn.append(turn(e.oMi[1].rotation))
print("mujoco", mj, " pin", pn)
assert mj == [-50, 40] and pn == [-70, 20], "the behaviour changed"
P
a/bin/python reach.py
b/bin/mujoco_usd_converter m.xml out > conv.log 2>&1
cat > usd.py <<'P'
from pxr import Usd, UsdPhysics
s = Usd.Stage.Open("out/m.usda")
j = [UsdPhysics.RevoluteJoint(p) for p in s.Traverse() if p.IsA(UsdPhysics.RevoluteJoint)][0]
r = [round(j.GetLowerLimitAttr().Get()), round(j.GetUpperLimitAttr().Get())]
flat = j.GetLocalRot0Attr().Get() == j.GetLocalRot1Attr().Get()
print("usd", r, "frames not turned:", flat)
assert r == [-30, 60] and flat, "the behaviour changed"
P
b/bin/python usd.py
if grep -qi warn conv.log; then echo "the converter warns now"; exit 1; fi
echo "as stated"
