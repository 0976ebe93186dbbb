#!/usr/bin/env bash
# MuJoCo's distance says a capsule that runs through a box is as deep in it as its radius, wherever it runs.
#
# Guess: mj_geomDistance gives the shortest way out with a minus sign: 0.10 for a rail of radius 0.02 whose axis
#   lies 0.07 beside the middle of a box that reaches 0.15 to that side.
# Versions: mujoco 4.0.0, numpy 2.4.6 (Python 3.11).
# Behaviour: -0.02 for the capsule, at 0.07 and at 0.13 alike. A cylinder in the same places: -0.10 and -0.04.
# Seen (m):
#   axis at 0.07: capsule -0.02, cylinder -0.10   axis at 0.13: capsule -0.02, cylinder -0.04
# Why it matters: who looks for parts that overlap by this function sees two centimetres where there are ten.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
python3 -m venv --without-pip "$d/v"
python3 -m pip --python "$d/v/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: mujoco==4.0.0 numpy==2.4.6
cd "$d"
cat > t.py <<'P'
import mujoco, numpy as np
ROD = '<geom name="{0}{1}" type="{0}" size=".02 2" zaxis="1 0 0" pos="0 {1} 0"/>'
rods = "".join(ROD.format(kind, at) for kind in ("capsule", "cylinder") for at in (0.07, 0.13))
model = mujoco.MjModel.from_xml_string(
    f'<mujoco><worldbody><body><freejoint/><geom name="box" type="box" size=".2 .15 .1"/></body>{rods}</worldbody></mujoco>')
data = mujoco.MjData(model); mujoco.mj_forward(model, data)
found = {}
for name in ("capsule0.07", "cylinder0.07", "capsule0.13", "cylinder0.13"):
    depth = mujoco.mj_geomDistance(model, data, model.geom("box").id, model.geom(name).id, 1.0, np.zeros(6))
    found[name] = round(float(depth), 4)
print(found)
assert found == {"capsule0.07": -0.02, "cylinder0.07": -0.1, "capsule0.13": -0.02, "cylinder0.13": -0.04}, "the behaviour changed"
P
v/bin/python t.py 2> err || { cat err; exit 1; }
echo "as stated"
