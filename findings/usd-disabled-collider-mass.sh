#!/usr/bin/env bash
# A switched-off USD collider weighs something in PhysX and nothing in Newton.
#
# Guess: PhysX leaves a collider with collisionEnabled = false out, Newton counts it.
# Versions: newton 1.8.0, usd-core 26.11, ovphysx 0.7.0.74035321 (Python 3.11).
# Behaviour: it is the other way round. Two cubes of 1 kg, one switched off.
#   PhysX sums both. Newton sums the active one. The centre of mass differs as well.
# Seen:
#   PhysX mass 2.0 centre_x 0.5   newton mass 1.0 centre_x 0.0
# Why it matters: switching a coarse collider off is a usual repair.
#   It changes the weight in one engine only. Author the mass on the body.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
export WARP_CACHE_PATH="$d/warp"
venv() { local n=$1; shift; python3 -m venv --without-pip "$d/$n"; python3 -m pip --python "$d/$n/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: "$@"; }
venv n newton==1.8.0 usd-core==26.11 newton-usd-schemas==0.6.0 numpy==2.4.6
venv p ovphysx==0.7.0.74035321 physx-usd-schemas==25.11.2.72696984 newton-usd-schemas==0.6.0 numpy==2.4.6
cd "$d"
cat > m.usda <<'X'
#usda 1.0
(defaultPrim = "W"; metersPerUnit = 1; kilogramsPerUnit = 1; upAxis = "Z")
def Xform "W" {
 def PhysicsScene "S" {}
 def Xform "B" (prepend apiSchemas = ["PhysicsRigidBodyAPI"]) {
  def Cube "on" (prepend apiSchemas = ["PhysicsCollisionAPI"]) { double size = .1; }
  def Cube "off" (prepend apiSchemas = ["PhysicsCollisionAPI"]) { double size = .1; bool physics:collisionEnabled = 0
  double3 xformOp:translate = (1, 0, 0); uniform token[] xformOpOrder = ["xformOp:translate"]
  }
 }
}
X
cat > n.py <<'P'
import newton
b = newton.ModelBuilder(); b.add_usd("m.usda"); r = (round(b.body_mass[0], 4), round(float(b.body_com[0][0]), 4))
print("newton mass", r[0], "centre_x", r[1]); assert r == (1, 0), "the behaviour changed"
P
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
p, s = load("m.usda")
r = (round(read(p, "/W/B", "RIGID_BODY_MASS")[0], 4), round(read(p, "/W/B", "RIGID_BODY_COM_POSE")[0], 4)); close(p, s)
print("PhysX mass", r[0], "centre_x", r[1]); assert r == (2, .5), "the behaviour changed"
P
n/bin/python n.py 2> /dev/null; p/bin/python p.py 2> /dev/null | grep '^PhysX'
echo "as stated"
