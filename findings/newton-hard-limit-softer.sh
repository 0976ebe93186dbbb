#!/usr/bin/env bash
# Newton's word for a hard joint limit makes the limit nine times softer than saying nothing.
#
# Guess: newton:limitStiffness = inf, "interpreted as a hard limit", goes less far past the limit than
#   the default spring.
# Versions: newton[sim] 1.8.0, newton-usd-schemas 0.6.0, usd-core 26.11 (Python 3.11).
# Behaviour: a hinge with limits of +-80 degrees is pushed with 60 N m for three seconds. With nothing
#   authored it ends 0.006 rad past its limit, with limitStiffness = inf 0.055 rad. inf becomes MuJoCo's
#   own default, solref 0.02 1, which is softer than Newton's default spring for so light a link.
# Seen (radians past the limit):
#   default 0.0059   inf 0.0555
# Why it matters: who asks for a hard limit gets a lid that opens three degrees too far.
#   Write a finite limitStiffness that suits the joint's effort.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
export WARP_CACHE_PATH="$d/warp"
python3 -m venv --without-pip "$d/v"
python3 -m pip --python "$d/v/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: "newton[sim]==1.8.0" newton-usd-schemas==0.6.0 usd-core==26.11 numpy==2.4.6
cd "$d"
cat > t.py <<'P'
import numpy as np, newton
U = '''#usda 1.0
(defaultPrim = "W"
 metersPerUnit = 1
 kilogramsPerUnit = 1
 upAxis = "Z")
def Xform "W" (prepend apiSchemas = ["PhysicsArticulationRootAPI"]) {
 def Xform "base" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]) {
  float physics:mass = 1
  float3 physics:diagonalInertia = (.1, .1, .1)
  quatf physics:principalAxes = (1, 0, 0, 0)
 }
 def Xform "arm" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]) {
  float physics:mass = 0.5
  float3 physics:diagonalInertia = (.001, .001, .001)
  point3f physics:centerOfMass = (0.2, 0, 0)
  quatf physics:principalAxes = (1, 0, 0, 0)
 }
 def PhysicsFixedJoint "root" { rel physics:body1 = </W/base>
 }
 def PhysicsRevoluteJoint "j" (prepend apiSchemas = ["NewtonJointAPI"]) {
  rel physics:body0 = </W/base>
  rel physics:body1 = </W/arm>
  quatf physics:localRot0 = (1, 0, 0, 0)
  quatf physics:localRot1 = (1, 0, 0, 0)
  uniform token physics:axis = "Y"
  float physics:lowerLimit = -80
  float physics:upperLimit = 80
  float newton:damping = 0.0007
  %s
 }
}
'''
def past(name, words):
    with open(name, "w") as file: file.write(U % words)
    b = newton.ModelBuilder(); b.add_usd(name)
    m = b.finalize(device="cpu"); s = newton.solvers.SolverMuJoCo(m, use_mujoco_cpu=True)
    a, z, c = m.state(), m.state(), m.control()
    newton.eval_fk(m, m.joint_q, m.joint_qd, a)
    for i in range(1500):
        f = c.joint_f.numpy(); f[-1] = 60 * min(1, i / 750); c.joint_f.assign(f)
        s.step(a, z, c, None, 0.002); a, z = z, a
    return float(a.joint_q.numpy()[-1]) - np.radians(80)
plain, hard = past("plain.usda", ""), past("hard.usda", "float newton:limitStiffness = inf")
print(f"default {plain:.4f}   inf {hard:.4f}")
assert 0 < plain < 0.01 and hard > 5 * plain, "the behaviour changed"
P
v/bin/python t.py 2> /dev/null | grep ^default
echo "as stated"
