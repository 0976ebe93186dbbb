#!/usr/bin/env bash
# A USD hinge limited on one side only is welded shut in PhysX. The validator passes it.
#
# Guess: an unauthored limit is infinite, so the hinge turns freely that way.
# Versions: ovphysx 0.7.0.74035321, newton 1.8.0, usd-core 26.11,
#   usd-validation-nvidia 1.22.0 (Python 3.11).
# Behaviour: lowerLimit = -30 is authored, upperLimit is left at its default, inf.
#   Newton reads -30 degrees and no upper end. PhysX logs an invalid limit and sets 0 .. 0.
#   NVIDIA's own validator finds no fault with the file.
# Seen (radians):
#   newton -0.5236 .. 1e10   PhysX 0.0 .. 0.0   validator 0 failures
# Why it matters: a lid with a stop on one side does not open in Isaac.
#   Write both ends, for example -30 and 36000.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
export WARP_CACHE_PATH="$d/warp"
venv() { local n=$1; shift; python3 -m venv --without-pip "$d/$n"; python3 -m pip --python "$d/$n/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: "$@"; }
venv n newton==1.8.0 usd-core==26.11 newton-usd-schemas==0.6.0 numpy==2.4.6
venv p ovphysx==0.7.0.74035321 physx-usd-schemas==25.11.2.72696984 newton-usd-schemas==0.6.0 numpy==2.4.6
venv v usd-validation-nvidia==1.22.0 usd-core==26.11 numpy==2.4.6
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
  uniform token physics:axis = "Y"; float physics:lowerLimit = -30
 }
}
}
X
cat > n.py <<'P'
import newton
b = newton.ModelBuilder(); b.add_usd("m.usda"); r = (round(b.joint_limit_lower[0], 4), b.joint_limit_upper[0])
print("newton", *r); assert r[0] == -.5236 and r[1] > 1e9, "the behaviour changed"
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
p, s = load("m.usda"); r = [round(x, 4) for x in read(p, "/W/A", "ARTICULATION_DOF_LIMIT")]; close(p, s)
print("PhysX", *r); assert r == [0, 0], "the behaviour changed"
P
n/bin/python n.py 2> /dev/null; p/bin/python p.py 2> /dev/null | grep '^PhysX '
v/bin/nvidia_usd_validate --no-init-rules --category Physics m.usda > val.log 2>&1 || true
if grep -qE "Failures: [1-9]|Warnings: [1-9]|Errors: [1-9]|Traceback" val.log; then cat val.log; exit 1; fi
echo "validator: $(grep -vE '^ *-*$' val.log | tail -1 | cut -c1-90)"
sed 's/float physics:mass = 1/float physics:mass = -1/' m.usda > bad.usda  # the validator does look
v/bin/nvidia_usd_validate --no-init-rules --category Physics bad.usda > bad.log 2>&1 || true
grep -qE "Failures: [1-9]|Warnings: [1-9]|Errors: [1-9]" bad.log || { echo "the control was not judged"; exit 1; }
echo "as stated"
