#!/usr/bin/env bash
# A URDF range with one end has five meanings in five readers.
#
# Guess: the missing end is 0, as the URDF page says.
# Versions: mujoco 4.0.0, pybullet 3.2.7, drake 1.51.1, sapien 3.0.3, rerun-sdk 0.41.0 (Python 3.11).
# Behaviour: <limit lower="-2" effort="5" velocity="2"/> on a revolute joint.
#   Rerun follows the page. MuJoCo drops the range, Drake has no upper end.
#   PyBullet's upper end is -1, which leaves the joint's own zero out of range.
#   SAPIEN's upper end is NaN. On a prismatic joint it raises a TypeError.
# Seen:
#   rerun -2 .. 0   mujoco none   drake -2 .. inf   pybullet -2 .. -1   sapien -2 .. nan
# Why it matters: a lid with one stop is free, stuck or poisoned by NaN, by reader.
#   Write both ends.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
venv() { local n=$1; shift; python3 -m venv --without-pip "$d/$n"; python3 -m pip --python "$d/$n/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: "$@"; }
venv a mujoco==4.0.0 pybullet==3.2.7 drake==1.51.1 sapien==3.0.3 rerun-sdk==0.41.0 numpy==2.4.6
cd "$d"
cat > m.urdf <<'X'
<robot name="m">
 <link name="base"><inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial></link>
 <link name="a"><inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial></link>
 <joint name="j" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/><limit lower="-2" effort="5" velocity="2"/></joint>
</robot>
X
sed 's/revolute/prismatic/' m.urdf > slide.urdf
cat > t.py <<'P'
import math, warnings; warnings.simplefilter("ignore")
import mujoco, pybullet as pb, sapien, rerun.urdf as ru
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
got = {"mujoco": bool(mujoco.MjModel.from_xml_path("m.urdf").jnt_limited[0])}
pb.connect(pb.DIRECT); got["pybullet"] = pb.getJointInfo(pb.loadURDF("m.urdf"), 0)[8:10]
p = MultibodyPlant(0.001); Parser(p).AddModels("m.urdf"); p.Finalize(); j = p.GetJointByName("j")
got["drake"] = float(j.position_lower_limits()[0]), float(j.position_upper_limits()[0])
s = sapien.Scene([sapien.physx.PhysxCpuSystem()]); a = s.create_urdf_loader().load("m.urdf")
got["sapien"] = tuple(float(x) for x in a.active_joints[0].limits[0])
k, = ru.UrdfTree.from_file_path("m.urdf").joints(); got["rerun"] = k.limit_lower, k.limit_upper
try: s.create_urdf_loader().load("slide.urdf"); got["slide"] = "loaded"
except TypeError: got["slide"] = "TypeError"
print(got)
assert not got["mujoco"] and got["pybullet"] == (-2, -1) and got["drake"] == (-2, math.inf) and got["rerun"] == (-2, 0)
assert got["sapien"][0] == -2 and math.isnan(got["sapien"][1]) and got["slide"] == "TypeError", "the behaviour changed"
P
a/bin/python t.py 2> err || { cat err; exit 1; }
echo "as stated"
