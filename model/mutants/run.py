#!/usr/bin/env python3
"""Makes each change of learned.toml in turn, runs the golden test, and tells which changes nobody noticed.

    python3 model/mutants/run.py [WORD...]

What is built is the learned path alone, from the sources below model/src, in the crate beside this file.
With words, only mutants whose names hold one of them. Sources are put back as they were, whatever happens.
Exit: 0 all were noticed, 1 some were not, 2 a mutant fits no source, does not build, or could not be tried.
"""

import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
import tomllib

HERE = pathlib.Path(__file__).resolve().parent
SOURCES = HERE.parent / "src"
RULES = HERE / "learned.toml"
TEST = ["cargo", "test", "--release", "--lib"]


def cargo(*more):
    """The exit status of the test's command, and what it said."""
    done = subprocess.run(
        [*TEST, *more],
        cwd=HERE,
        env={**os.environ, "KINFOLD_BLESS": "0"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    return done.returncode, done.stdout


def changed(mutant):
    """The file of a mutant, its text as it is and with the change."""
    path = SOURCES / mutant["file"]
    text = path.read_text()
    find, replace = (mutant[k].removeprefix("\n").rstrip() for k in ("find", "replace"))
    if text.count(find) != 1:
        raise ValueError(f"{text.count(find)} places in {mutant['file']} fit, not 1")
    return path, text, text.replace(find, replace)


def tried(mutant):
    """What became of a mutant: `died`, `survived`, or why it could not be tried."""
    try:
        path, text, other = changed(mutant)
    except ValueError as error:
        return str(error)
    try:
        path.write_text(other)
        status, said = cargo("--no-run")
        if status:
            return "does not build:\n" + "\n".join(said.splitlines()[-15:])
        return "died" if cargo("golden")[0] else "survived"
    finally:
        path.write_text(text)


def main():
    shutil.copy(HERE.parent.parent / "Cargo.lock", HERE)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(2))
    words = sys.argv[1:]
    rules = tomllib.loads(RULES.read_text())["mutant"]
    mutants = [m for m in rules if not words or any(w in m["name"] for w in words)]
    status, said = cargo("golden")
    if status:
        print("without any change the golden test fails\n" + said[-3000:])
        return 2
    found = {}
    for mutant in mutants:
        start = time.monotonic()
        found[mutant["name"]] = tried(mutant)
        print(f"{time.monotonic() - start:6.0f} s  {found[mutant['name']]:<9} {mutant['name']}", flush=True)
    died, survived = (sum(f == w for f in found.values()) for w in ("died", "survived"))
    print(f"{len(found)} mutants: {died} died, {survived} survived")
    if died + survived < len(found):
        return 2
    return 1 if survived else 0


if __name__ == "__main__":
    sys.exit(main())
