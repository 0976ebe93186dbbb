"""`kinfold check` beside MuJoCo's Python bindings on the same files, in one run, taken in turn.

    against_mujoco.py KINFOLD FILE... [--rounds N]

Processor seconds (user and system) of whole processes, the median over the rounds. kinfold does
all of its checks up to `dynamic`; MuJoCo loads the URDF and looks for the deepest overlap of any
two bodies with each joint alone through its range, a step per 2 mm of tip motion.
"""

import os
import resource
import statistics
import subprocess
import sys

STEP = 0.002

SWEEP = """
import sys, mujoco, numpy as np
model = mujoco.MjModel.from_xml_path(sys.argv[1])
data = mujoco.MjData(model)
geoms = [g for g in range(model.ngeom) if model.geom_contype[g] or model.geom_conaffinity[g]]
pairs = [(a, b) for i, a in enumerate(geoms) for b in geoms[i + 1:]
         if model.geom_bodyid[a] != model.geom_bodyid[b]]
first, second = (np.array(side) for side in zip(*pairs)) if pairs else (np.zeros(0, int),) * 2
reach = model.geom_rbound[first] + model.geom_rbound[second]
size, worst, fromto = 2 * model.stat.extent, 0.0, np.zeros(6)
for j in range(model.njnt):
    low, high = model.jnt_range[j] if model.jnt_limited[j] else (0.0, 2 * np.pi)
    arm = 1.0 if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_SLIDE else size / 2
    for q in np.linspace(low, high, max(2, int((high - low) * arm / float(sys.argv[2])) + 1)):
        mujoco.mj_resetData(model, data)
        data.qpos[model.jnt_qposadr[j]] = q
        mujoco.mj_kinematics(model, data)
        apart = np.linalg.norm(data.geom_xpos[first] - data.geom_xpos[second], axis=1)
        for k in np.nonzero(apart <= reach)[0]:
            depth = -mujoco.mj_geomDistance(model, data, pairs[k][0], pairs[k][1], 0.01, fromto)
            worst = max(worst, depth)
print(worst)
"""


def seconds(command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main(arguments):
    rounds = int(arguments.pop(arguments.index("--rounds") + 1)) if "--rounds" in arguments else 5
    program, *files = [a for a in arguments if a != "--rounds"]
    for file in files:
        ours, theirs = [], []
        for _ in range(rounds):
            ours.append(seconds([program, "check", "--here", "--json", file]))
            theirs.append(seconds([sys.executable, "-c", SWEEP, file, str(STEP)]))
        ours, theirs = statistics.median(ours), statistics.median(theirs)
        print(f"{1000 * ours:8.1f} ms kinfold  {1000 * theirs:8.1f} ms MuJoCo  {os.path.relpath(file)}")


if __name__ == "__main__":
    main(sys.argv[1:])
