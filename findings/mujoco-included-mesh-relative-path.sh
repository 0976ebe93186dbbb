#!/usr/bin/env bash
# A MuJoCo model loads or not with the folder it is loaded from, where a mesh lies beside an included file.
#
# Guess: m.xml includes sub/part.xml, which names a mesh that lies in sub. It is found, or it is not; and the folder
#   the process stands in decides nothing, as the model's own folder is named in full by the model's path.
# Versions: mujoco 4.0.0 (Python 3.11).
# Behaviour: named /…/w/m.xml the model loads: what is not beside the model is looked for beside the included file.
#   So does m.xml from within its folder. Named w/m.xml from the folder above it does not: the error names
#   w/sub/box.obj, which is there.
# Seen:
#   absolute loads   w/m.xml from above fails, opening w/sub/box.obj, which is there   m.xml from within loads
# Why it matters: a model passes in a test that names it in full, and fails on the command line.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
python3 -m venv --without-pip "$d/v"
python3 -m pip --python "$d/v/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: mujoco==4.0.0
cd "$d"
mkdir -p w/sub
cat > w/m.xml <<'X'
<mujoco><include file="sub/part.xml"/><worldbody><geom type="mesh" mesh="box"/></worldbody></mujoco>
X
cat > w/sub/part.xml <<'X'
<mujocoinclude><asset><mesh name="box" file="box.obj"/></asset></mujocoinclude>
X
cat > w/sub/box.obj <<'X'
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
X
cat > t.py <<'P'
import os, mujoco
def load(path):
    try: mujoco.MjModel.from_xml_path(path); return "loads"
    except ValueError as e: return str(e).splitlines()[0]
here = os.getcwd()
absolute, above = load(os.path.abspath("w/m.xml")), load("w/m.xml")
os.chdir("w"); within = load("m.xml"); os.chdir(here)
print("absolute:", absolute.replace(here, "…"), "| from above:", above, "| from within:", within)
assert absolute == within == "loads" and "w/sub/box.obj" in above and os.path.isfile("w/sub/box.obj"), "the behaviour changed"
P
v/bin/python t.py 2> err || { cat err; exit 1; }
echo "as stated"
