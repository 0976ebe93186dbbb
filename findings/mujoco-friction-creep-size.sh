#!/usr/bin/env bash
# A joint held by dry friction creeps in MuJoCo, and five times the friction creeps just as far.
#
# Guess: friction above the pull of gravity holds the joint; if it creeps, more friction creeps less.
# Versions: mujoco 4.0.0 (Python 3.11).
# Behaviour: an arm hangs level on a hinge; gravity pulls with 0.98 N m. With a friction of 1.1, 2 and
#   5 N m it sinks by the same angle in five seconds, to 1e-9 rad. The friction constraint is soft, and
#   its pace depends on pull and inertia alone. A smaller step sinks as far. From URDF a
#   <mujoco><option noslip_iterations> in the file stops it; in MJCF solimpfriction does as well.
# Seen (radians after 5 s):
#   friction 1.1, 2, 5: 0.2433   step 0.0005: 0.2432   noslip_iterations 20: 0.0000
# Why it matters: lids and pedals sink in MuJoCo whatever friction their URDF gives them.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
python3 -m venv --without-pip "$d/v"
python3 -m pip --python "$d/v/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: mujoco==4.0.0 numpy==2.4.6
cd "$d"
cat > t.py <<'P'
import mujoco
U = '''<robot name="r"><mujoco><compiler fusestatic="false"/>%s</mujoco>
<link name="base"><inertial><mass value="1"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="arm"><inertial><origin xyz="0.2 0 0"/><mass value="0.5"/><inertia ixx=".001" iyy=".001" izz=".001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
<limit lower="-1.5" upper="1.5" effort="9" velocity="2"/><dynamics damping="0.04" friction="%g"/></joint></robot>'''
def sunk(option, friction):
    m = mujoco.MjModel.from_xml_string(U % (option, friction)); d = mujoco.MjData(m)
    while d.time < 5: mujoco.mj_step(m, d)
    return float(d.qpos[0])
soft = [sunk("", f) for f in (1.1, 2, 5)]
fine, held = sunk('<option timestep="0.0005"/>', 2), sunk('<option noslip_iterations="20"/>', 2)
print("friction 1.1, 2, 5:", *(f"{q:.4f}" for q in soft), f" step 0.0005: {fine:.4f}  noslip_iterations 20: {held:.4f}")
assert max(soft) - min(soft) < 1e-9 and abs(soft[0] - 0.2433) < 1e-3, "the behaviour changed"
assert abs(fine - soft[0]) < 1e-3 and abs(held) < 1e-6, "the behaviour changed"
P
v/bin/python t.py
echo "as stated"
