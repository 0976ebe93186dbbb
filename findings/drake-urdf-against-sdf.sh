#!/usr/bin/env bash
# The same hinge in URDF and in SDF is two different hinges in Drake.
#
# Guess: one engine with two front ends gives one model, and warns where it cannot.
# Versions: drake 1.51.1 (Python 3.11).
# Behaviour, a continuous hinge with limits, friction and a mimic follower:
#   limits of `continuous`: URDF keeps them, SDF drops them
#   actuator: URDF none, SDF one of infinite effort on every joint without <effort>
#   friction: URDF warns, SDF drops it silently
#   mimic: URDF couples the joints, SDF (1.11, native <mimic>) leaves them loose, silently
# Seen:
#   urdf limits -1 1      actuators 0          couplings 1  friction warned yes
#   sdf  limits -inf inf  actuators 2 (inf)    couplings 0  friction warned no
# Why it matters: people swap formats to work around one gap and get four others.
#   A free door in SDF needs <effort>0</effort>, or a controller will find a motor in it.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
export WARP_CACHE_PATH="$d/warp"
venv() { local n=$1; shift; python3 -m venv --without-pip "$d/$n"; python3 -m pip --python "$d/$n/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: "$@"; }
venv a drake==1.51.1 numpy==2.4.6
cd "$d"
cat > t.py <<'P'
import sys
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.parsing import Parser
from pydrake.multibody.tree import JointActuatorIndex
U = '<inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial>'
S = '<inertial><mass>1</mass><inertia><ixx>.01</ixx><iyy>.01</iyy><izz>.01</izz></inertia></inertial>'
def ujoint(n, c, extra): return (f'<joint name="{n}" type="continuous"><parent link="base"/><child link="{c}"/><axis xyz="0 0 1"/>'
    f'<limit lower="-1" upper="1" effort="5" velocity="2"/><dynamics damping=".7" friction=".3"/>{extra}</joint>')
def sjoint(n, c, extra): return (f'<joint name="{n}" type="continuous"><parent>base</parent><child>{c}</child><axis><xyz>0 0 1</xyz>'
    f'<limit><lower>-1</lower><upper>1</upper></limit><dynamics><damping>.7</damping><friction>.3</friction></dynamics>{extra}</axis></joint>')
urdf = ('<robot name="m">' + "".join(f'<link name="{n}">{U}</link>' for n in ("base", "a", "b")) + ujoint("j", "a", "")
        + ujoint("k", "b", '<mimic joint="j" multiplier="2"/>') + "</robot>")
sdf = ('<sdf version="1.11"><model name="m">' + "".join(f'<link name="{n}">{S}</link>' for n in ("base", "a", "b")) + sjoint("j", "a", "")
       + sjoint("k", "b", '<mimic joint="j"><multiplier>2</multiplier><offset>0</offset><reference>0</reference></mimic>') + "</model></sdf>")
kind = sys.argv[1]; p = MultibodyPlant(0.001); Parser(p).AddModelsFromString({"urdf": urdf, "sdf": sdf}[kind], kind); p.Finalize()
j = p.GetJointByName("j")
efforts = [p.get_joint_actuator(JointActuatorIndex(i)).effort_limit() for i in range(p.num_actuators())]
print(kind, "limits", j.position_lower_limits()[0], j.position_upper_limits()[0], "actuators", efforts, "couplings", p.num_constraints(),
      "damping", j.default_damping_vector()[0])
P
for k in urdf sdf; do
  out=$(a/bin/python t.py $k 2> err); if grep -qi friction err; then f=yes; else f=no; fi
  if [ $k = sdf ] && grep -qi warning err; then cat err; exit 1; fi
  echo "$out friction warned $f"
  case "$out $f" in
    "urdf limits -1.0 1.0 actuators [] couplings 1 damping 0.7 yes") ;;
    "sdf limits -inf inf actuators [inf, inf] couplings 0 damping 0.7 no") ;;
    *) echo "the behaviour changed"; exit 1;;
  esac
done
echo "as stated"
