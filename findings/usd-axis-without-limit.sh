#!/usr/bin/env bash
# The free axis of a USD D6 joint turns in PhysX and is welded in Newton.
#
# Guess: an axis without PhysicsLimitAPI is free, as UsdPhysics says.
# Versions: newton 1.8.0, usd-core 26.11, ovphysx 0.7.0.74035321 (Python 3.11).
# Behaviour: a continuous hinge as PhysicsJoint: five axes locked, rotY not mentioned.
#   PhysX gives one free turn. Newton gives a joint with no degree of freedom.
#   With a LimitAPI of -30 .. 60 on rotY both give the same hinge.
# Seen:
#   rotY not listed  PhysX 1 free  newton 0
#   rotY -30 .. 60   PhysX 1       newton 1
# Why it matters: a generic joint is the usual way to write unusual mechanisms.
#   Give every free axis a LimitAPI with wide finite limits.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
export WARP_CACHE_PATH="$d/warp"
venv() { local n=$1; shift; python3 -m venv --without-pip "$d/$n"; python3 -m pip --python "$d/$n/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: "$@"; }
venv n newton==1.8.0 usd-core==26.11 newton-usd-schemas==0.6.0 numpy==2.4.6
venv p ovphysx==0.7.0.74035321 physx-usd-schemas==25.11.2.72696984 newton-usd-schemas==0.6.0 numpy==2.4.6
cd "$d"
cat > open.usda <<'X'
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
 def PhysicsJoint "j" (prepend apiSchemas = ["PhysicsLimitAPI:transX", "PhysicsLimitAPI:transY", "PhysicsLimitAPI:transZ", "PhysicsLimitAPI:rotX", "PhysicsLimitAPI:rotZ"]) {
  rel physics:body0 = </W/A/base>; rel physics:body1 = </W/A/arm>
  point3f physics:localPos0 = (.5, 0, 0); point3f physics:localPos1 = (0, 0, 0)
  quatf physics:localRot0 = (1, 0, 0, 0); quatf physics:localRot1 = (1, 0, 0, 0)
  float limit:transX:physics:low = 1; float limit:transX:physics:high = -1
  float limit:transY:physics:low = 1; float limit:transY:physics:high = -1
  float limit:transZ:physics:low = 1; float limit:transZ:physics:high = -1
  float limit:rotX:physics:low = 1; float limit:rotX:physics:high = -1
  float limit:rotZ:physics:low = 1; float limit:rotZ:physics:high = -1
 }
}
}
X
sed -e 's/\["PhysicsLimitAPI:transX"/["PhysicsLimitAPI:rotY", "PhysicsLimitAPI:transX"/' \
    -e 's/ def PhysicsJoint .*/&\n  float limit:rotY:physics:low = -30; float limit:rotY:physics:high = 60/' open.usda > closed.usda
cat > n.py <<'P'
import newton
got = {}
for f in ("open", "closed"):
    b = newton.ModelBuilder(); b.add_usd(f + ".usda"); got[f] = [round(x, 4) for x in b.joint_limit_lower]
print("newton", got); assert got == {"open": [], "closed": [-.5236]}, "the behaviour changed"
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
got = {}
for f in ("open", "closed"):
    p, s = load(f + ".usda"); got[f] = [max(-1e9, round(x, 4)) for x in read(p, "/W/A", "ARTICULATION_DOF_LIMIT")[::2]]; close(p, s)
print("PhysX", got); assert got == {"open": [-1e9], "closed": [-.5236]}, "the behaviour changed"
P
n/bin/python n.py 2> /dev/null; p/bin/python p.py 2> /dev/null | grep '^PhysX {'
echo "as stated"
