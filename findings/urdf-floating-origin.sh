#!/usr/bin/env bash
# Newton loses the <origin> of a floating joint: the part appears at the root.
#
# Guess: a free part starts where its joint origin puts it.
# Versions: newton 1.8.0, mujoco 4.0.0, pin 4.1.0 (Python 3.11).
# Behaviour: MuJoCo and Pinocchio place the child at the joint origin.
#   Newton starts the free joint with the negative of that origin.
#   Both cancel, so the child stands on the root link. There is no warning.
# Seen (height of the loose cup on a table of 0.8 m):
#   mujoco 0.8   pin 0.8   newton 0.0
# Why it matters: a loose part in a drawer starts inside the base.
#   The engine then throws it out with the first contact.
#   Set the pose of free parts in code after loading, or use a second file.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
export WARP_CACHE_PATH="$d/warp"
venv() { local n=$1; shift; python3 -m venv --without-pip "$d/$n"; python3 -m pip --python "$d/$n/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: "$@"; }
venv a mujoco==4.0.0 pin==4.1.0 numpy==2.4.6
venv b newton==1.8.0 numpy==2.4.6
cd "$d"
I='<inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial>'
cat > r.urdf <<X
<robot name="r"><link name="table">$I</link><link name="cup">$I</link>
<joint name="loose" type="floating"><parent link="table"/><child link="cup"/><origin xyz="0 0 0.8"/></joint></robot>
X
cat > a.py <<'P'
import mujoco, pinocchio as pin
m = mujoco.MjModel.from_xml_path("r.urdf"); d = mujoco.MjData(m); mujoco.mj_forward(m, d)
p = pin.buildModelFromUrdf("r.urdf"); e = p.createData(); pin.forwardKinematics(p, e, pin.neutral(p))
z = (float(d.body("cup").xpos[2]), float(e.oMi[1].translation[2]))
print("mujoco", z[0], "pin", z[1])
assert z == (0.8, 0.8), "the behaviour changed"
P
cat > b.py <<'P'
import newton
b = newton.ModelBuilder(); b.add_urdf("r.urdf")
i = [k for k, l in enumerate(b.joint_label) if l.endswith("loose")][0]
frame = float(b.joint_X_p[i][2]); q = float(b.joint_q[b.joint_q_start[i] + 2]); z = round(frame + q, 6)
print("newton frame", round(frame, 6), "coordinate", round(q, 6), "height", z)
assert z == 0.0, "the behaviour changed"
P
a/bin/python a.py; b/bin/python b.py 2> err
if grep -i floating err; then echo "Newton warns now"; exit 1; fi
echo "as stated"
