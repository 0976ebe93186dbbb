#!/usr/bin/env bash
# A revolute URDF joint whose <limit> names no range is locked in one reader, free in others.
#
# Guess: lower and upper default to 0 as the URDF page says, so the joint is locked everywhere.
# Versions: mujoco 4.0.0, pin 4.1.0, ikpy 4.2.1 (Python 3.11).
# Behaviour: <limit effort="5" velocity="2"/> is valid, both attributes are optional.
#   Pinocchio follows the page: 0 .. 0. MuJoCo makes it unlimited, ikpy too. No one warns.
# Seen:
#   pin 0 .. 0   mujoco unlimited   ikpy -inf .. inf
# Why it matters: a planner on Pinocchio cannot move a joint that the simulator spins freely.
#   Write lower and upper, or type="continuous".
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
venv() { local n=$1; shift; python3 -m venv --without-pip "$d/$n"; python3 -m pip --python "$d/$n/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: "$@"; }
venv a mujoco==4.0.0 pin==4.1.0 ikpy==4.2.1 numpy==2.4.6
cd "$d"
cat > m.urdf <<'X'
<robot name="m">
 <link name="base"/>
 <link name="a"><inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial></link>
 <joint name="j" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/><limit effort="5" velocity="2"/></joint>
</robot>
X
cat > t.py <<'P'
import warnings; warnings.filterwarnings("ignore", message="Link Base link")  # about ikpy's own fixed base
import mujoco, pinocchio as pin
from ikpy.chain import Chain
p = pin.buildModelFromUrdf("m.urdf"); pn = [float(p.lowerPositionLimit[0]), float(p.upperPositionLimit[0])]
m = mujoco.MjModel.from_xml_path("m.urdf"); mj = bool(m.jnt_limited[0])
ik = [float(x) for x in Chain.from_urdf_file("m.urdf", base_elements=["base"]).links[1].bounds]
print("pin", pn, "mujoco limited", mj, "ikpy", ik)
assert pn == [0, 0] and m.njnt == 1 and not mj and ik == [-float("inf"), float("inf")], "the behaviour changed"
P
a/bin/python t.py 2> err; if grep -i warn err; then echo "someone warns now"; exit 1; fi
echo "as stated"
