#!/usr/bin/env bash
# rigidBodyEnabled = false: Newton lets the body fall and leaves its collider hanging.
#
# Guess: the body becomes static scenery in both engines.
# Versions: newton 1.8.0, usd-core 26.11, ovphysx 0.7.0.74035321 (Python 3.11).
# Behaviour: PhysX makes no moving body and keeps the collider at its place.
#   Newton ties the collider to the world, but also keeps a free body of 1 kg.
#   That body has no collider. It drops through everything, with whatever is drawn on it.
# Seen:
#   newton: body "shelf" dynamic, 1.0 kg, 6 degrees of freedom, collider on the world
#   PhysX: no rigid body "shelf", a ball rests on it at 0.1 m
# Why it matters: switching a part's physics off is how people freeze furniture.
#   Remove the RigidBodyAPI instead, then both engines agree.
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
 def Xform "shelf" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]) {
  float physics:mass = 1; float3 physics:diagonalInertia = (.01, .01, .01); quatf physics:principalAxes = (1, 0, 0, 0)
  bool physics:rigidBodyEnabled = 0
  def Cube "c" (prepend apiSchemas = ["PhysicsCollisionAPI"]) { double size = .1; }
 }
 def Xform "ball" (prepend apiSchemas = ["PhysicsRigidBodyAPI"]) {
  double3 xformOp:translate = (0, 0, .3); uniform token[] xformOpOrder = ["xformOp:translate"]
  def Cube "c" (prepend apiSchemas = ["PhysicsCollisionAPI"]) { double size = .1; }
 }
}
X
cat > n.py <<'P'
import newton
b = newton.ModelBuilder(); b.add_usd("m.usda")
i = [k for k, l in enumerate(b.body_label) if l.endswith("shelf")][0]
s = [k for k, l in enumerate(b.shape_label) if "shelf" in l][0]
j = [k for k in range(b.joint_count) if b.joint_child[k] == i][0]
dof = sum(b.joint_dof_dim[j]); free = b.joint_type[j] == newton.JointType.FREE
print("newton shelf mass", b.body_mass[i], "free joint", free, "dynamic flag", int(b.body_flags[i]), "collider on body", b.shape_body[s])
assert b.body_mass[i] == 1 and free and int(b.body_flags[i]) == 1 and b.shape_body[s] == -1, "the behaviour changed"
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
b = p.create_tensor_binding(pattern="/W/shelf", tensor_type=T.RIGID_BODY_MASS); n = b.count; b.destroy()
for _ in range(90): p.step_sync(1 / 60)
z = round(read(p, "/W/ball", "RIGID_BODY_POSE")[2], 2); close(p, s)
print("PhysX rigid bodies named shelf", n, "ball rests at", z); assert (n, z) == (0, .1), "the behaviour changed"
P
n/bin/python n.py 2> /dev/null; p/bin/python p.py 2> /dev/null | grep '^PhysX rigid'
echo "as stated"
