#!/usr/bin/env bash
# MJCF density="0" weighs 1000 kg per cubic metre after conversion to USD.
#
# Guess: a massless visual geom stays massless.
# Versions: mujoco-usd-converter 0.8.0, mujoco 3.16.0, usd-exchange 3.0.1,
#   ovphysx 0.7.0.74035321 (Python 3.11).
# Behaviour: density="0" is MuJoCo's way to say that a shape weighs nothing.
#   MuJoCo writes it itself for the visuals of a URDF that it exports.
#   UsdPhysics reads a density of 0 as "not set" and uses 1000. The converter copies the 0.
# Seen (a 1 kg body with a box of 0.2 m as its shell):
#   mujoco 1.0 kg   PhysX on the USD 9.0 kg
# Why it matters: shells become the heaviest parts of the robot, without a warning.
#   Give each body an explicit <inertial> before it goes to USD.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
export WARP_CACHE_PATH="$d/warp"
venv() { local n=$1; shift; python3 -m venv --without-pip "$d/$n"; python3 -m pip --python "$d/$n/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: "$@"; }
venv e mujoco-usd-converter==0.8.0 usd-exchange==3.0.1 mujoco==3.16.0
venv p ovphysx==0.7.0.74035321 physx-usd-schemas==25.11.2.72696984 newton-usd-schemas==0.6.0 numpy==2.4.6
cd "$d"
cat > m.xml <<'X'
<mujoco model="m"><worldbody><body name="B"><freejoint/>
 <geom name="core" type="box" size=".05 .05 .05" mass="1"/>
 <geom name="shell" type="box" size=".1 .1 .1" density="0"/></body></worldbody></mujoco>
X
cat > m.py <<'P'
import mujoco
m = round(float(mujoco.MjModel.from_xml_path("m.xml").body_mass.sum()), 6); print("mujoco", m, "kg"); assert m == 1
P
e/bin/python m.py; e/bin/mujoco_usd_converter m.xml out > conv.log 2>&1
if grep -i warn conv.log; then echo "the converter warns now"; exit 1; fi
cat > p.py <<'P'
import sys, numpy as np, ovphysx, ovstage
from ovphysx import PhysX
from ovphysx.types import TensorType as T
from ovphysx.samples.python_samples.schema_support import physx_schema_paths
ovstage.population.register_usd_schemas([*map(str, physx_schema_paths()), str(ovphysx.newton_schema_root())])
PhysX.set_cpu_mode(True)
def load(f):
    p, s = PhysX(), ovstage.Stage("s")
    ovstage.population.open_usd(s, f, ordinal=1, domains=ovstage.PopulationDomain.ALL); s.advance_write_floor(ordinal=1).wait()
    p.wait_task(p.attach_ovstage(s, read_ordinal=1)); p.wait_all()
    return p, s
def read(p, path, what):
    b = p.create_tensor_binding(pattern=path, tensor_type=getattr(T, what)); a = np.zeros(b.shape, np.float32); b.read(a); b.destroy()
    return a.astype(float).ravel()
def close(p, s): p.wait_task(p.detach_ovstage()); p.destroy(); s.destroy()
p, s = load("out/m.usda"); m = round(read(p, "/m/Geometry/B", "RIGID_BODY_MASS")[0], 4); close(p, s)
print("PhysX", m, "kg"); assert m == 9, "the behaviour changed"
P
p/bin/python p.py 2> /dev/null | grep '^PhysX'
echo "as stated"
