#!/usr/bin/env bash
# trimesh weighs a scaled GLB node as if it had no scale.
#
# Guess: volume stays positive under any node scale, also a mirroring one.
# Versions: trimesh 5.2.0 (Python 3.11).
# Behaviour: the guess held for the sign. Beside it, the scene's own volume, area and moment_inertia are not.
#   Scene.volume and Scene.area sum the meshes without their node's scale.
#   Scene.moment_inertia is neither the unscaled nor the scaled value: it shrinks as the
#   box grows. Scene.bounds and Scene.to_mesh() do apply the scale. No warning.
# Seen (a unit cube under a node scale of 1, 2, 3; density 1):
#   scene   extents 1 2 3  volume 1  area 6   inertia 0.1667 0.0417 0.0185
#   to_mesh extents 1 2 3  volume 6  area 22  inertia 6.5 5 2.5
# Why it matters: centimetre GLBs carry their scale on the root node.
#   Mass computed from the scene is then off by a million. Call to_mesh() first.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
venv() { local n=$1; shift; python3 -m venv --without-pip "$d/$n"; python3 -m pip --python "$d/$n/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: "$@"; }
venv a trimesh==5.2.0 numpy==2.4.6
cd "$d"
cat > t.py <<'P'
import numpy as np, trimesh
def show(name, o):
    r = [np.round(o.extents, 4).tolist(), round(float(o.volume), 4), round(float(o.area), 4), np.round(np.diag(o.moment_inertia), 4).tolist()]
    print(name, *r); return r
def loaded(scale):
    s = trimesh.Scene(); s.add_geometry(trimesh.creation.box((1, 1, 1)), node_name="n", transform=np.diag([*scale, 1.0]))
    return trimesh.load_scene(trimesh.util.wrap_as_stream(s.export(file_type="glb")), file_type="glb")
g = loaded((1, 2, 3)); a, b = show("scene  ", g), show("to_mesh", g.to_mesh())
assert a == [[1, 2, 3], 1, 6, [.1667, .0417, .0185]] and b == [[1, 2, 3], 6, 22, [6.5, 5, 2.5]], "the behaviour changed"
m = loaded((1, -1, 1)).to_mesh(); print("mirrored", m.volume); assert abs(m.volume - 1) < 1e-6, "the behaviour changed"
P
a/bin/python t.py
echo "as stated"
