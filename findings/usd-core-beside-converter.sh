#!/usr/bin/env bash
# usd-core and the URDF converter cannot share an environment, and pip says nothing.
#
# Guess: both bring the same pxr modules, so they can live side by side.
# Versions: urdf-usd-converter 0.3.4, usd-exchange 3.0.1, usd-core 26.11 (Python 3.11).
# Behaviour: usd-exchange ships its own pxr folder (26.8) under the same name.
#   Installing usd-core 26.11 afterwards overwrites files of it. pip check is content.
#   From then on the converter dies at import. Removing usd-core does not help:
#   that takes the shared files away, usd-exchange has to be installed again.
# Seen:
#   alone               ok
#   usd-core added      ImportError: initialization failed
#   usd-core removed    fails
#   usd-exchange again  ok
# Why it matters: newton, validators and viewers all ask for usd-core.
#   A pipeline needs one environment for converting and another for checking.
set -euo pipefail
d=$(mktemp -d); trap 'rm -rf "$d"' EXIT
python3 -m venv --without-pip "$d/v"; pip="python3 -m pip --python $d/v/bin/python --disable-pip-version-check -q"; opt="--no-compile --only-binary :all:"
cat > "$d/r.urdf" <<'X'
<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>
X
try() { # name expected
  rm -rf "$d/out"
  if "$d/v/bin/urdf_usd_converter" "$d/r.urdf" "$d/out" > "$d/log" 2>&1; then r=ok; else r=fails; fi
  echo "$1: $r $( [ $r = fails ] && tail -1 "$d/log" | cut -c1-60 || true)"
  [ $r = "$2" ] || { echo "the behaviour changed"; exit 1; }
}
$pip install $opt urdf-usd-converter==0.3.4 usd-exchange==3.0.1
try "alone" ok
$pip install $opt usd-core==26.11
$pip check > /dev/null
try "usd-core added" fails
$pip uninstall -y usd-core
try "usd-core removed" fails
$pip install $opt --force-reinstall --no-deps usd-exchange==3.0.1
try "usd-exchange again" ok
echo "as stated"
