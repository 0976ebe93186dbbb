#!/usr/bin/env bash
# A URDF inertia that no body has is refused, replaced, raised, ignored or simulated.
#
# Guess: moments of 0.01, 0.01, 0.05 (A + B < C) are an error, or are taken as they are.
# Versions: mujoco 4.0.0, drake 1.51.1, newton 1.8.0, pybullet 3.2.7, sapien 3.0.3 (Python 3.11).
# Behaviour: MuJoCo refuses the file. SAPIEN simulates the moments as they are.
#   Drake warns and takes a ball of water of the same mass: 0.0015, a thirtieth.
#   Newton adds 0.03 to all three, and warns once however many bodies it changed.
#   PyBullet never looks: it takes the moments of the collision shape's box.
# Seen (about z):
#   mujoco refused   sapien 0.05   drake 0.0015   newton 0.08   pybullet 0.0067
# Why it matters: exporters write such moments, and one part swings in five ways.
#   Derive moments from a shape and a density.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
export WARP_CACHE_PATH="$d/warp"
venv() { local n=$1; shift; python3 -m venv --without-pip "$d/$n"; python3 -m pip --python "$d/$n/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: "$@"; }
venv a mujoco==4.0.0 pybullet==3.2.7 drake==1.51.1 sapien==3.0.3 numpy==2.4.6
venv b newton==1.8.0 numpy==2.4.6
cd "$d"
cat > m.urdf <<'X'
<robot name="m">
 <link name="base"><inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial></link>
 <link name="a"><inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".05" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><box size=".2 .2 .2"/></geometry></collision></link>
 <joint name="j" type="continuous"><parent link="base"/><child link="a"/><origin xyz="0 0 1"/><axis xyz="0 0 1"/></joint>
</robot>
X
cat > t.py <<'P'
import logging, warnings; warnings.simplefilter("ignore"); logging.getLogger("drake").setLevel(logging.ERROR)
import mujoco, pybullet as pb, sapien
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
try: mujoco.MjModel.from_xml_path("m.urdf"); mj = "loaded"
except ValueError as e: mj = "refused" if "A + B >= C" in str(e) else str(e)
pb.connect(pb.DIRECT); bullet = pb.getDynamicsInfo(pb.loadURDF("m.urdf"), 0)[2][2]
p = MultibodyPlant(0.001); Parser(p).AddModels("m.urdf"); p.Finalize()
drake = p.GetBodyByName("a").default_spatial_inertia().CalcRotationalInertia().get_moments()[2]
s = sapien.Scene([sapien.physx.PhysxCpuSystem()]); a = s.create_urdf_loader().load("m.urdf")
sap = next(l for l in a.links if l.name == "a").inertia[2]
print("mujoco", mj, "pybullet", round(bullet, 4), "drake", round(float(drake), 4), "sapien", round(float(sap), 4))
assert mj == "refused" and abs(bullet - 0.0067) < 1e-4 and abs(drake - 0.00154) < 1e-5 and abs(sap - 0.05) < 1e-4, "the behaviour changed"
P
cat > n.py <<'P'
import newton, numpy as np
b = newton.ModelBuilder(); b.add_urdf("m.urdf"); m = b.finalize().body_inertia.numpy()[1]
print("newton", np.round(np.diag(m), 4).tolist())
assert np.allclose(np.diag(m), (0.04, 0.04, 0.08), atol=1e-4), "the behaviour changed"
P
a/bin/python t.py 2> err || { cat err; exit 1; }
b/bin/python n.py 2> err || { cat err; exit 1; }
echo "as stated"
