#!/usr/bin/env bash
# The same four URDF joints come in three orders, and Newton knows two of them.
#
# Guess: depth first in file order everywhere, alphabetical in Pinocchio.
# Versions: mujoco 4.0.0, pin 4.1.0, sapien 3.0.3, newton 1.8.0, usd-core 26.11,
#   urdf-usd-converter 0.3.4, usd-exchange 3.0.1 (Python 3.11).
# Behaviour: the tree is base -> z -> m and base -> a -> k, z before a in the file.
#   MuJoCo and Newton's URDF reader go depth first in file order.
#   SAPIEN goes breadth first. Pinocchio sorts siblings by name.
#   Newton gives another order for the USD that NVIDIA's converter makes of the file.
# Seen:
#   mujoco jz jm ja jk   newton urdf jz jm ja jk   sapien jz ja jm jk
#   pin    ja jk jz jm   newton usd  ja jk jz jm
# Why it matters: a joint vector saved from one tool moves other joints in the next.
#   Even one engine changes its order when the format changes. Exchange values by name.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
export WARP_CACHE_PATH="$d/warp"
venv() { local n=$1; shift; python3 -m venv --without-pip "$d/$n"; python3 -m pip --python "$d/$n/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: "$@"; }
venv a mujoco==4.0.0 pin==4.1.0 numpy==2.4.6
venv b newton==1.8.0 usd-core==26.11 newton-usd-schemas==0.6.0 numpy==2.4.6
venv c sapien==3.0.3 numpy==2.4.6
venv e urdf-usd-converter==0.3.4 usd-exchange==3.0.1
cd "$d"
python3 - > r.urdf <<'P'
I = '<inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial>'
print('<robot name="r">' + "".join(f'<link name="{n}">{I}</link>' for n in ("base", "z", "a", "m", "k")))
for j, p, c in (("jz", "base", "z"), ("ja", "base", "a"), ("jm", "z", "m"), ("jk", "a", "k")):
    print(f'<joint name="{j}" type="revolute"><parent link="{p}"/><child link="{c}"/><origin xyz=".3 0 0"/><axis xyz="0 1 0"/>'
          '<limit lower="-1" upper="1" effort="5" velocity="2"/></joint>')
print("</robot>")
P
cat > a.py <<'P'
import mujoco, pinocchio as pin
m = mujoco.MjModel.from_xml_path("r.urdf"); a = " ".join(m.joint(i).name for i in range(m.njnt))
b = " ".join(list(pin.buildModelFromUrdf("r.urdf").names)[1:])
print("mujoco", a); print("pin", b); assert (a, b) == ("jz jm ja jk", "ja jk jz jm"), "the behaviour changed"
P
cat > b.py <<'P'
import newton
def order(f):
    b = newton.ModelBuilder(); (b.add_usd if f.endswith("usda") else b.add_urdf)(f)
    return " ".join(n for n in (l.split("/")[-1] for l in b.joint_label) if n in ("jz", "ja", "jm", "jk"))
u, s = order("r.urdf"), order("out/r.usda")
print("newton urdf", u); print("newton usd ", s); assert (u, s) == ("jz jm ja jk", "ja jk jz jm"), "the behaviour changed"
P
cat > c.py <<'P'
import sapien
s = sapien.Scene([sapien.physx.PhysxCpuSystem()]); l = s.create_urdf_loader(); l.fix_root_link = True
o = " ".join(j.name for j in l.load("r.urdf").active_joints); print("sapien", o); assert o == "jz ja jm jk", "the behaviour changed"
P
e/bin/urdf_usd_converter r.urdf out > conv.log 2>&1
a/bin/python a.py; c/bin/python c.py 2> /dev/null; b/bin/python b.py 2> /dev/null
echo "as stated"
