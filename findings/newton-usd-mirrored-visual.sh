#!/usr/bin/env bash
# Newton mirrors the collider of a mirrored USD mesh but not the visual.
#
# Guess: xformOp:scale (1, -1, 1) mirrors both alike.
# Versions: newton 1.8.0, usd-core 26.11 (Python 3.11).
# Behaviour: one mesh is used twice under one scale of (1, -1, 1).
#   The collider lies at y -0.2 .. 0. The visual stays at y 0 .. 0.2.
#   From a URDF with the same scale both are mirrored.
# Seen:
#   visual y 0.0 .. 0.2   collider y -0.2 .. 0.0
# Why it matters: left and right parts are often one mesh with a negative scale.
#   Cameras see the part on one side, contacts happen on the other.
#   Bake the mirror into the points and flip the faces before export.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
export WARP_CACHE_PATH="$d/warp"
python3 -m venv --without-pip "$d/b"
python3 -m pip --python "$d/b/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: newton==1.8.0 usd-core==26.11 newton-usd-schemas==0.6.0 numpy==2.4.6
cd "$d"
python3 - > m.usda <<'P'
mesh = '''def Mesh "%s" %s{
 point3f[] points = [(0,0,0),(.3,0,0),(0,.2,0),(0,0,.1)]
 int[] faceVertexCounts = [3,3,3,3]
 int[] faceVertexIndices = [0,2,1, 0,1,3, 0,3,2, 1,2,3]
 uniform token subdivisionScheme = "none"
 %s
}
'''
api = '(prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsMeshCollisionAPI"]) '
print('''#usda 1.0
(
 defaultPrim = "W"
 metersPerUnit = 1
 upAxis = "Z"
)
def Xform "W" {
def Xform "part" (prepend apiSchemas = ["PhysicsRigidBodyAPI"]) {
def Xform "left" {
 float3 xformOp:scale = (1, -1, 1)
 uniform token[] xformOpOrder = ["xformOp:scale"]
''' + mesh % ("visual", "", "") + mesh % ("collider", api, 'uniform token purpose = "guide"') + "}\n}\n}")
P
cat > t.py <<'P'
import newton, numpy as np
b = newton.ModelBuilder(); b.add_usd("m.usda"); got = {}
for i, name in enumerate(b.shape_label):
    v = np.array(b.shape_source[i].vertices) * np.array(b.shape_scale[i])
    x = np.array(b.shape_transform[i]); u, w = x[3:6], x[6]
    p = v + 2 * np.cross(u, np.cross(u, v) + w * v) + x[:3]
    got[name.split("/")[-1]] = (round(float(p[:, 1].min()), 4) + 0.0, round(float(p[:, 1].max()), 4) + 0.0)
for k in sorted(got): print(k, "y", *got[k])
assert got["visual"] == (0.0, 0.2) and got["collider"] == (-0.2, 0.0), "the behaviour changed"
print("as stated")
P
b/bin/python t.py 2> err || { cat err; exit 1; }
