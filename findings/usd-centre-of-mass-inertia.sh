#!/usr/bin/env bash
# A USD body with an authored centerOfMass: Newton's inertia is a seventh of PhysX's.
#
# Guess: with mass and centerOfMass given, both engines derive the same inertia.
# Versions: newton 1.8.0, usd-core 26.11, ovphysx 0.7.0.74035321 (Python 3.11).
# Behaviour: a 2 kg cube of 0.2 m, its centre of mass authored 0.2 m off the middle.
#   No inertia is authored, so the engine takes it from the collider.
#   PhysX moves it to the given centre: 2/150 + 2 * 0.2 * 0.2 = 0.0933.
#   Newton keeps the cube's own 0.0133. There is no warning.
# Seen (mass, inertia about x, y, z):
#   PhysX 2.0 0.0133 0.0933 0.0933   newton 2.0 0.0133 0.0133 0.0133
# Why it matters: a loaded drawer or a door with a heavy handle swings differently.
#   Author diagonalInertia and principalAxes whenever centerOfMass is authored.
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
 def Xform "B" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]) {
  float physics:mass = 2; point3f physics:centerOfMass = (.2, 0, 0)
  def Cube "c" (prepend apiSchemas = ["PhysicsCollisionAPI"]) { double size = .2; }
 }
}
X
cat > n.py <<'P'
import newton, numpy as np
b = newton.ModelBuilder(); b.add_usd("m.usda")
i = [round(float(x), 4) for x in np.diag(np.array(b.body_inertia[0]).reshape(3, 3))]
com = [round(float(x), 4) for x in b.body_com[0]]
print("newton mass", b.body_mass[0], "centre", com, "inertia", i)
assert b.body_mass[0] == 2 and com == [.2, 0, 0] and i == [.0133] * 3, "the behaviour changed"
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
m, com, i = read(p, "/W/B", "RIGID_BODY_MASS"), read(p, "/W/B", "RIGID_BODY_COM_POSE"), read(p, "/W/B", "RIGID_BODY_INERTIA")
close(p, s); com = [round(x, 4) + 0 for x in com[:3]]; i = [round(x, 4) for x in i[[0, 4, 8]]]
print("PhysX mass", m[0], "centre", com, "inertia", i)
assert m[0] == 2 and com == [.2, 0, 0] and i == [.0133, .0933, .0933], "the behaviour changed"
P
n/bin/python n.py 2> err; p/bin/python p.py 2> /dev/null | grep '^PhysX'
if grep -i inertia err; then echo "Newton warns now"; exit 1; fi
echo "as stated"
