#!/usr/bin/env bash
# The newest dm_control picks a MuJoCo it cannot open a model with, and pip is content.
#
# Guess: what pip resolves for dm_control works together: import, attach and step.
# Versions: dm_control 1.0.50, mujoco 4.0.0 (Python 3.11).
# Behaviour: dm_control asks for a MuJoCo with no upper bound, so a fresh install gets 4.0.0.
#   Importing, building and attaching MJCF work. Physics, for any model, does not:
#   it looks up a field of MjModel that 4.0.0 no longer has. MuJoCo itself opens the file.
# Seen:
#   attach  arm/j   mujoco 2 bodies   Physics AttributeError: flex_vertedge
# Why it matters: the failure shows only at the first Physics, not at install or import.
#   Pin mujoco below 4 next to dm_control.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
venv() { local n=$1; shift; python3 -m venv --without-pip "$d/$n"; python3 -m pip --python "$d/$n/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: "$@"; }
venv a dm_control==1.0.50 mujoco==4.0.0 numpy==2.4.6
cd "$d"
python3 -m pip --disable-pip-version-check --python a/bin/python check
cat > t.py <<'P'
import re, importlib.metadata as md, mujoco
from dm_control import mjcf
from dm_control.mujoco import Physics
need = [r for r in md.requires("dm_control") if re.match(r"mujoco\b", r)]; print("requires", need)
assert len(need) == 1 and "<" not in need[0] and "==" not in need[0], "the behaviour changed"
arm = mjcf.RootElement(model="arm"); b = arm.worldbody.add("body", name="b")
b.add("geom", size=[.1]); b.add("joint", name="j")
r = mjcf.RootElement(model="r"); r.worldbody.add("site", name="s").attach(arm)
assert r.find("joint", "arm/j") is not None; print("attach arm/j")
plain = '<mujoco><worldbody><body name="b"><joint/><geom size=".1"/></body></worldbody></mujoco>'
print("mujoco", mujoco.MjModel.from_xml_string(plain).nbody, "bodies")
for what, f in (("attached", lambda: mjcf.Physics.from_mjcf_model(r)), ("plain", lambda: Physics.from_xml_string(plain))):
    try: f()
    except AttributeError as e: print(what, "AttributeError", e); assert "flex_vertedge" in str(e), "the behaviour changed"
    else: raise SystemExit("the behaviour changed")
P
a/bin/python t.py 2> err || { cat err; exit 1; }
echo "as stated"
