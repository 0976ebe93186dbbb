#!/usr/bin/env bash
# MuJoCo forgets the inertia of a massless fixed link when it fuses it, as it does with URDFs unless told not to.
#
# Guess: fusing changes nothing; 0.1 on the moving link and 0.1 on a link fixed to it are 0.2 about the hinge.
# Versions: mujoco 4.0.0, pin 4.1.0, drake 1.51.1, numpy 2.4.6 (Python 3.11).
# Behaviour: with fusestatic="false" the joint-space inertia is 0.2, as in Pinocchio.
#   Fused, which is what a URDF gets unless its <mujoco><compiler> says otherwise, it is 0.1: the rest is gone.
#   Drake warns of the massless link and takes 0.1015.
# Seen (kg m^2 about the hinge):
#   mujoco fused 0.1   mujoco unfused 0.2   pinocchio 0.2   drake 0.1015
# Why it matters: hands and tool frames with mass 0 and an inertia are common (Franka, Bolt); the arm moves otherwise.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
python3 -m venv --without-pip "$d/v"
python3 -m pip --python "$d/v/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: mujoco==4.0.0 pin==4.1.0 drake==1.51.1 numpy==2.4.6
cd "$d"
cat > m.urdf <<'X'
<robot name="m"><link name="base"/>
 <link name="hand"><inertial><mass value="1"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial></link>
 <link name="tip"><inertial><mass value="0"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial></link>
 <joint name="turn" type="revolute"><parent link="base"/><child link="hand"/><axis xyz="0 0 1"/>
  <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
 <joint name="weld" type="fixed"><parent link="hand"/><child link="tip"/></joint>
</robot>
X
cat > t.py <<'P'
import logging; logging.getLogger("drake").setLevel(logging.ERROR)
import mujoco, numpy as np, pinocchio as pin
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
def about_hinge(model):
    data, whole = mujoco.MjData(model), np.zeros((1, 1))
    mujoco.mj_forward(model, data); mujoco.mj_fullM(model, data, whole)
    return round(float(whole[0, 0]), 6)
text = open("m.urdf").read()
kept = text.replace('<link name="base"/>', '<mujoco><compiler fusestatic="false"/></mujoco><link name="base"/>')
fused, unfused = (about_hinge(mujoco.MjModel.from_xml_string(t)) for t in (text, kept))
model = pin.buildModelFromUrdf("m.urdf"); other = round(float(pin.crba(model, model.createData(), pin.neutral(model))[0, 0]), 6)
p = MultibodyPlant(0.001); Parser(p).AddModels("m.urdf"); p.WeldFrames(p.world_frame(), p.GetFrameByName("base")); p.Finalize()
drake = float(p.CalcMassMatrix(p.CreateDefaultContext())[0, 0])
print("mujoco fused", fused, "unfused", unfused, "pinocchio", other, "drake", round(drake, 4))
assert (fused, unfused, other) == (0.1, 0.2, 0.2) and abs(drake - 0.1015) < 1e-3, "the behaviour changed"
P
v/bin/python t.py 2> err || { cat err; exit 1; }
echo "as stated"
