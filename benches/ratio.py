"""Two builds of kinfold beside each other: processor seconds of `make`, stage by stage, taken in turn.

    ratio.py OLD NEW CASE... [--rounds N] [--threads N] [--apart STAGE,...] [--json FILE]

OLD and NEW are programs. A CASE is a folder with `mesh.glb`, `condition.json` and a picture of any
kind, such as `examples/cabinet`. Each program makes every case from scratch, the two in turn, N
times (3); what is told is the median. A stage's seconds are what the program and those it started
have had of the processors when the stage ended, less what they had when the one before ended.

Stages go by one name in both builds: `write` is everything that writes the asset. Those named by
`--apart` (pages and pictures by default) stand beside the sum, not in it. Last come, for each stage
and for all of them, the geometric mean of old over new, the least and the most.
"""

import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time

# The stages of either build, by one name.
NAMES = {
    "render-views": "render",
    "articulate": "articulate",
    "shape-parts": "build",
    "build-asset": "build",
    "check-in-sim": "check",
    "write-pictures": "pictures",
    "write-page": "pictures",
}
WRITERS = ("write", "export", "transfer")
PICTURES = (".png", ".jpg", ".jpeg", ".webp")
TICK = os.sysconf("SC_CLK_TCK")


def stage_of(line):
    """The stage that a line of progress says has ended; nothing of other lines."""
    word = line.split(" ", 1)[0]
    if not line[:1].isalpha() or "-" not in word and word != "articulate":
        return None
    if word in NAMES:
        return NAMES[word]
    if word.startswith(WRITERS):
        return "write"
    return "others"


def spent(process):
    """Processor seconds that a process and those it waited for have had."""
    with open(f"/proc/{process}/stat", encoding="utf-8") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return sum(int(fields[i]) for i in range(11, 15)) / TICK


def made(program, case, threads):
    """Processor seconds of each stage, of all, wall seconds and most memory, MB, of one `make`."""
    names = sorted(os.listdir(case))
    photo = next(n for n in names if n.lower().endswith(PICTURES))
    environment = dict(os.environ)
    if threads:
        environment["RAYON_NUM_THREADS"] = str(threads)
    with tempfile.TemporaryDirectory() as scratch:
        command = [program, "make", os.path.join(case, photo), "--mesh", os.path.join(case, "mesh.glb")]
        command += ["--condition", os.path.join(case, "condition.json"), "--out", os.path.join(scratch, "out")]
        environment.update(HOME=scratch, XDG_CACHE_HOME=scratch, XDG_DATA_HOME=scratch)
        began, before = time.monotonic(), 0.0
        child = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True,
                                 env=environment, cwd=scratch)
        stages = {}
        for line in child.stderr:
            stage = stage_of(line)
            try:
                now = spent(child.pid)
            except (OSError, IndexError):
                continue
            if stage:
                stages[stage] = stages.get(stage, 0.0) + now - before
                before = now
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        wall = time.monotonic() - began
    if child.returncode not in (0, 3):
        sys.exit(f"{program} ended with {child.returncode} on {case}")
    whole = usage.ru_utime + usage.ru_stime
    return stages, whole, wall, usage.ru_maxrss / 1024


def medians(runs, apart):
    """Of several runs of one program: the median of each stage, of their sum, of wall time and memory."""
    stages = {s for run in runs for s in run[0]}
    found = {s: statistics.median(run[0].get(s, 0.0) for run in runs) for s in sorted(stages)}
    sums = [run[1] - sum(run[0].get(s, 0.0) for s in apart) for run in runs]
    found["all"] = statistics.median(sums)
    found["wall"] = statistics.median(run[2] for run in runs)
    found["MB"] = statistics.median(run[3] for run in runs)
    return found


def main():
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("old")
    asked.add_argument("new")
    asked.add_argument("cases", nargs="+")
    asked.add_argument("--rounds", type=int, default=3)
    asked.add_argument("--threads", type=int, default=1)
    asked.add_argument("--apart", default="pictures")
    asked.add_argument("--json")
    asked = asked.parse_args()
    programs = [os.path.abspath(p) for p in (asked.old, asked.new)]
    apart = [s for s in asked.apart.split(",") if s]
    columns = ["render", "articulate", "build", "write", "check", "others", "pictures", "all", "wall", "MB"]
    print(f"{'':28}" + "".join(f"{c:>17}" for c in columns))
    ratios, told = {}, {}
    for case in asked.cases:
        case = os.path.abspath(case)
        runs = ([], [])
        for _ in range(asked.rounds):
            for program, kept in zip(programs, runs):
                kept.append(made(program, case, asked.threads))
        old, new = (medians(kept, apart) for kept in runs)
        name = os.path.basename(case)
        told[name] = {"old": old, "new": new}
        row = [f"{old.get(c, 0.0):8.2f}→{new.get(c, 0.0):<7.2f} " for c in columns]
        print(f"{name[:27]:28}" + "".join(row), flush=True)
        for column in columns:
            if old.get(column, 0.0) >= 0.02 and new.get(column, 0.0) > 0.0:
                ratios.setdefault(column, []).append(old[column] / new[column])
    print("\nold over new: geometric mean (least to most)")
    for column, all_of in ratios.items():
        mean = math.exp(statistics.fmean(math.log(r) for r in all_of))
        print(f"{column:12} {mean:6.2f} ({min(all_of):.2f} to {max(all_of):.2f}) of {len(all_of)}")
    for side in ("old", "new"):
        every = sorted(of[side]["all"] for of in told.values())
        print(f"{side}: median {statistics.median(every):.2f} s, least {every[0]:.2f}, most {every[-1]:.2f}")
    if asked.json:
        with open(asked.json, "w", encoding="utf-8") as file:
            json.dump(told, file, indent=1)


if __name__ == "__main__":
    main()
