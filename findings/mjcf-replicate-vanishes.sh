#!/usr/bin/env bash
# Three MJCF readers lose every body inside <replicate>, none of them says so.
#
# Guess: Newton expands it. Drake and Pinocchio may not, but warn.
# Versions: mujoco 4.0.0, newton 1.8.0, drake 1.51.1, pin 4.1.0 (Python 3.11).
# Behaviour: <replicate> has been MJCF since MuJoCo 3.
#   Newton, Drake and Pinocchio skip the element and everything inside it.
#   Drake does warn about <frame>, Pinocchio loses that silently, too.
# Seen (moving joints, total mass):
#   mujoco  frame 2 joints 3 kg             replicate 4 joints 7 kg
#   newton  frame 2 joints 3 kg             replicate 1 joint  1 kg, no warning
#   drake   frame 1 joint  1 kg, a warning  replicate 1 joint  1 kg, no warning
#   pin     frame 1 joint  1 kg, no warning replicate 1 joint  1 kg, no warning
# Why it matters: a chest loads without its drawers and every check passes.
#   Flatten a model with MuJoCo (MjSpec.to_xml) before another reader gets it.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
export WARP_CACHE_PATH="$d/warp"
venv() { local n=$1; shift; python3 -m venv --without-pip "$d/$n"; python3 -m pip --python "$d/$n/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: "$@"; }
venv a mujoco==4.0.0 pin==4.1.0 drake==1.51.1 numpy==2.4.6
venv b newton==1.8.0 numpy==2.4.6
cd "$d"
drawer='<body name="drawer" pos=".5 0 0"><joint type="slide" axis="1 0 0"/><geom type="box" size=".2 .05 .05" mass="2"/></body>'
for k in frame replicate; do
  case $k in frame) open='<frame pos="0 1 0">';; *) open='<replicate count="3" offset="0 .3 0">';; esac
  printf '<mujoco model="m"><worldbody><body name="base"><joint type="hinge" axis="0 0 1"/><geom type="box" size=".1 .1 .1" mass="1"/>%s%s</%s></body></worldbody></mujoco>' "$open" "$drawer" $k > $k.xml
done
cat > mujoco.t <<'P'
import sys, mujoco
m = mujoco.MjModel.from_xml_path(sys.argv[1]); print(m.njnt, round(float(m.body_mass.sum())))
P
cat > pin.t <<'P'
import sys, pinocchio as pin
m = pin.buildModelFromMJCF(sys.argv[1]); print(m.nv, round(pin.computeTotalMass(m)))
P
cat > drake.t <<'P'
import sys
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.parsing import Parser
p = MultibodyPlant(0.0); Parser(p).AddModels(sys.argv[1]); p.Finalize()
print(p.num_velocities(), round(p.CalcTotalMass(p.CreateDefaultContext())))
P
cat > newton.t <<'P'
import sys, newton
b = newton.ModelBuilder(); b.add_mjcf(sys.argv[1]); print(b.joint_dof_count, round(sum(b.body_mass)))
P
check() { # tool venv file expected(joints mass) expected(warned)
  local out w; out=$("$2/bin/python" -W always "$1.t" "$3.xml" 2> err | tail -1)
  if grep -qiE "(unsupported|ignored|skip|replicate|not support)" err; then w=yes; else w=no; fi
  echo "$1 $3: joints and kg $out, warned $w"
  [ "$out/$w" = "$4/$5" ] || { echo "the behaviour changed"; exit 1; }
}
check mujoco a frame "2 3" no;  check mujoco a replicate "4 7" no
check newton b frame "2 3" no;  check newton b replicate "1 1" no
check drake a frame "1 1" yes;  check drake a replicate "1 1" no
check pin a frame "1 1" no;     check pin a replicate "1 1" no
echo "as stated"
