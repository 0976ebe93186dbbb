#!/usr/bin/env bash
# excludeFromArticulation makes Newton lose the body and bolt the joint to the world.
#
# Guess: Newton keeps the body and makes the joint a loop joint, or ignores the joint.
# Versions: newton 1.8.0, usd-core 26.11, ovphysx 0.7.0.74035321 (Python 3.11).
# Behaviour: an arm hangs on a base by one joint that is excluded from the articulation.
#   PhysX simulates both bodies and a plain joint between them.
#   Newton's model has one body. The joint now ties that base to the world a second time.
#   Its warning speaks of parallel joints, not of the lost body.
# Seen:
#   PhysX bodies base and arm   newton bodies base, joint j from the world to base
# Why it matters: the flag is the documented way to take a joint out of the solver tree.
#   Here it removes a link of the asset. Compare body counts after import.
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
def Xform "A" (prepend apiSchemas = ["PhysicsArticulationRootAPI"]) {
 def Xform "base" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]) {
  float physics:mass = 1; float3 physics:diagonalInertia = (.01, .01, .01); quatf physics:principalAxes = (1, 0, 0, 0)
 }
 def Xform "arm" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]) {
  float physics:mass = 1; float3 physics:diagonalInertia = (.01, .01, .01); quatf physics:principalAxes = (1, 0, 0, 0)
  double3 xformOp:translate = (.5, 0, 0); uniform token[] xformOpOrder = ["xformOp:translate"]
 }
 def PhysicsFixedJoint "root" { rel physics:body1 = </W/A/base>; }
 def PhysicsRevoluteJoint "j" {
  rel physics:body0 = </W/A/base>; rel physics:body1 = </W/A/arm>
  point3f physics:localPos0 = (.5, 0, 0); point3f physics:localPos1 = (0, 0, 0)
  quatf physics:localRot0 = (1, 0, 0, 0); quatf physics:localRot1 = (1, 0, 0, 0)
  uniform token physics:axis = "Y"; uniform bool physics:excludeFromArticulation = 1
 }
}
}
X
sed 's/excludeFromArticulation = 1/excludeFromArticulation = 0/' m.usda > plain.usda
cat > n.py <<'P'
import newton
def bodies(f):
    b = newton.ModelBuilder(); b.add_usd(f); n = [l.split("/")[-1] for l in b.body_label]
    i = [k for k, l in enumerate(b.joint_label) if l.endswith("/j")][0]
    return n, (["world"] + n)[b.joint_parent[i] + 1], n[b.joint_child[i]]
a, c = bodies("plain.usda"), bodies("m.usda")
print("newton plain   ", *a); print("newton excluded", *c)
assert a == (["base", "arm"], "base", "arm") and c == (["base"], "world", "base"), "the behaviour changed"
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
p, s = load("m.usda"); m = [read(p, "/W/A/" + n, "RIGID_BODY_MASS")[0] for n in ("base", "arm")]; p.step_sync(1 / 60); close(p, s)
print("PhysX masses of base and arm", *m); assert m == [1, 1], "the behaviour changed"
P
n/bin/python n.py 2> /dev/null; p/bin/python p.py 2> /dev/null | grep '^PhysX masses'
echo "as stated"
