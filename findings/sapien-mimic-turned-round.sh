#!/usr/bin/env bash
# SAPIEN turns <mimic> round between joints that hang on the same link.
#
# Guess: follower = multiplier * leader + offset, as URDF says and MuJoCo couples it.
# Versions: sapien 3.0.3, mujoco 4.0.0 (Python 3.11).
# Behaviour: two hinges on one base, the second mimics the first with multiplier 2, offset 0.1.
#   The leader is driven to 0.5. SAPIEN's follower rests at (0.5 - 0.1) / 2.
#   A follower two links further out is not coupled at all. There is no warning.
# Seen (follower when the leader is at 0.5):
#   mujoco 1.1   sapien 0.2   sapien, further out 0.0
# Why it matters: a gripper or a pair of doors closes at another rate than in MuJoCo.
#   With multiplier 1 or -1 and no offset the mistake does not show. Couple them from code.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
venv() { local n=$1; shift; python3 -m venv --without-pip "$d/$n"; python3 -m pip --python "$d/$n/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: "$@"; }
venv a mujoco==4.0.0 numpy==2.4.6
venv b sapien==3.0.3 numpy==2.4.6
cd "$d"
python3 - <<'P'
I = '<inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial>'
def link(n): return f'<link name="{n}">{I}</link>'
def joint(n, p, c, more=""):
    return (f'<joint name="{n}" type="revolute"><parent link="{p}"/><child link="{c}"/><origin xyz="1 0 0"/>'
            f'<axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="5" velocity="2"/>{more}</joint>')
M = '<mimic joint="j" multiplier="2" offset="0.1"/>'
near = link("base") + link("a") + link("b") + joint("j", "base", "a") + joint("k", "base", "b", M)
far = link("base") + link("a") + link("b") + link("c") + joint("j", "base", "a") + joint("m", "base", "b") + joint("k", "b", "c", M)
for name, parts in (("near", near), ("far", far)):
    open(name + ".urdf", "w").write(f'<robot name="m">{parts}</robot>')
P
cat > m.py <<'P'
import mujoco
m = mujoco.MjModel.from_xml_path("near.urdf"); d = mujoco.MjData(m)
for _ in range(4000):
    d.qfrc_applied[0] = 50 * (0.5 - d.qpos[0]) - 5 * d.qvel[0]; d.qfrc_applied[1] = -0.5 * d.qvel[1]
    mujoco.mj_step(m, d)
print("mujoco", round(float(d.qpos[0]), 2), round(float(d.qpos[1]), 2))
assert abs(d.qpos[0] - 0.5) < 0.03 and abs(d.qpos[1] - 1.1) < 0.06, "the behaviour changed"
P
cat > s.py <<'P'
import warnings; warnings.simplefilter("ignore")
import sapien
def rest(path):
    scene = sapien.Scene([sapien.physx.PhysxCpuSystem()]); a = scene.create_urdf_loader().load(path)
    at = {j.name: i for i, j in enumerate(a.active_joints)}
    j = a.active_joints[at["j"]]; j.set_drive_properties(100, 10); j.set_drive_target(0.5)
    for _ in range(1000): scene.step()
    return float(a.qpos[at["j"]]), float(a.qpos[at["k"]])
near, far = rest("near.urdf"), rest("far.urdf")
print("sapien", [round(x, 2) for x in near], "further out", [round(x, 2) for x in far])
assert abs(near[1] - (near[0] - 0.1) / 2) < 0.01 and abs(far[0] - 0.5) < 0.03 and abs(far[1]) < 0.01, "the behaviour changed"
P
a/bin/python m.py
b/bin/python s.py 2> err || { cat err; exit 1; }
echo "as stated"
