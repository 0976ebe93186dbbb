#!/usr/bin/env bash
# Pinocchio reads the range of an MJCF slide joint as degrees.
#
# Guess: a slide range is in metres, so both tools give the same numbers.
# Versions: pin 4.1.0, mujoco 4.0.0 (Python 3.11).
# Behaviour: the file uses MuJoCo's default angle unit, degrees.
#   That unit is for hinges. Pinocchio also multiplies slide ranges by pi/180.
#   A drawer of 0.4 m keeps 7 mm of travel. There is no warning.
#   With angle="radian" the same file gives the right range.
# Seen:
#   mujoco          slide [0.0, 0.4]    hinge [-0.5236, 1.0472]
#   pin, degree     slide [0.0, 0.007]  hinge [-0.5236, 1.0472]
#   pin, radian     slide [0.0, 0.4]    hinge [-0.5236, 1.0472]
# Why it matters: drawers, lifts and grippers lose 98 % of their travel in planners.
#   Whoever writes MJCF should always write angle="radian".
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
python3 -m venv --without-pip "$d/v"
python3 -m pip --python "$d/v/bin/python" install -q --no-compile --disable-pip-version-check --only-binary :all: pin==4.1.0 mujoco==4.0.0 numpy==2.4.6
cd "$d"
for unit in degree radian; do
  if [ $unit = degree ]; then r="-30 60"; head=""; else r="-0.5235988 1.0471976"; head='<compiler angle="radian"/>'; fi
  cat > $unit.xml <<X
<mujoco model="cabinet">$head<worldbody><body name="box">
 <joint name="slide" type="slide" axis="1 0 0" limited="true" range="0 0.4"/><geom type="box" size=".1 .1 .1" mass="1"/>
 <body name="door" pos=".2 0 0"><joint name="hinge" type="hinge" axis="0 0 1" limited="true" range="$r"/>
  <geom type="box" size=".1 .01 .1" mass="1"/></body></body></worldbody></mujoco>
X
done
cat > t.py <<'P'
import mujoco, pinocchio as pin
mj = [[[round(float(x), 4) for x in r] for r in mujoco.MjModel.from_xml_path(f).jnt_range] for f in ("degree.xml", "radian.xml")]
def read(f):
    m = pin.buildModelFromMJCF(f)
    return [[round(float(a), 4), round(float(b), 4)] for a, b in zip(m.lowerPositionLimit, m.upperPositionLimit)]
deg, rad = read("degree.xml"), read("radian.xml")
print("mujoco      slide", *mj[0][:1], "hinge", *mj[0][1:])
print("pin, degree slide", *deg[:1], "hinge", *deg[1:])
print("pin, radian slide", *rad[:1], "hinge", *rad[1:])
assert mj[0] == mj[1] == rad == [[0.0, 0.4], [-0.5236, 1.0472]]
assert deg == [[0.0, 0.007], [-0.5236, 1.0472]], "the behaviour changed"
print("as stated")
P
"$d/v/bin/python" t.py
