#!/usr/bin/env bash
# Four MJCF compiler options that set the mass are lost on the way to USD.
#
# Guess: the converter compiles the model with MuJoCo, so the masses are MuJoCo's.
# Versions: mujoco-usd-converter 0.8.0, mujoco 3.16.0, usd-exchange 3.0.1 (Python 3.11).
# Behaviour: the converter copies what is written and ignores what the compiler does.
#   inertiagrouprange, inertiafromgeom, boundmass and settotalmass have no effect.
#   It prints no warning and exits with 0.
# Seen (kg of the moving body, MuJoCo against USD):
#   inertiagrouprange 1 / 6   inertiafromgeom 1 / 4   boundmass 3 / 1   settotalmass 10 / 1
# Why it matters: inertiagrouprange is how models keep visuals out of the mass.
#   Let MuJoCo write the compiled inertia into the file before converting.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
export WARP_CACHE_PATH="$d/warp"
venv() { local n=$1; shift; python3 -m venv --without-pip "$d/$n"; python3 -m pip --python "$d/$n/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: "$@"; }
venv e mujoco-usd-converter==0.8.0 usd-exchange==3.0.1 mujoco==3.16.0
cd "$d"
mk() { # name, compiler attribute, body content
  printf '<mujoco model="m"><compiler %s/><worldbody><body name="B"><freejoint/>%s</body></worldbody></mujoco>' "$2" "$3" > $1.xml; }
g='<geom type="box" size=".1 .1 .1" mass="1"/>'
mk inertiagrouprange 'inertiagrouprange="0 1"' "$g"'<geom type="box" size=".1 .1 .1" mass="5" group="3"/>'
mk inertiafromgeom 'inertiafromgeom="true"' '<inertial pos="0 0 0" mass="4" diaginertia=".1 .1 .1"/>'"$g"
mk boundmass 'boundmass="3"' "$g"
mk settotalmass 'settotalmass="10"' "$g"
cat > t.py <<'P'
import sys, mujoco
from pxr import Usd, UsdPhysics
want = {"inertiagrouprange": (1, 6), "inertiafromgeom": (1, 4), "boundmass": (3, 1), "settotalmass": (10, 1)}
for n, w in want.items():
    mj = round(float(mujoco.MjModel.from_xml_path(n + ".xml").body_mass.sum()), 6)
    s = Usd.Stage.Open(n + "/m.usda"); b = s.GetPrimAtPath("/m/Geometry/B")
    own = UsdPhysics.MassAPI(b).GetMassAttr().Get() if b.HasAPI(UsdPhysics.MassAPI) else 0
    usd = own or sum(UsdPhysics.MassAPI(p).GetMassAttr().Get() for p in b.GetChildren() if p.HasAPI(UsdPhysics.MassAPI))
    print(n, "mujoco", mj, "usd", usd); assert (mj, usd) == w, "the behaviour changed"
P
for f in inertiagrouprange inertiafromgeom boundmass settotalmass; do
  e/bin/mujoco_usd_converter $f.xml $f > $f.log 2>&1
  if grep -i "warning\]" $f.log; then echo "the converter warns now"; exit 1; fi
done
e/bin/python t.py 2> /dev/null
echo "as stated"
