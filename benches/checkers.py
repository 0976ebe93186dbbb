#!/usr/bin/env python3
"""What several checkers find of the same planted defects, as a table: docs/checkers.md.

    benches/checkers.py CHECKERS.json FOLDER... > docs/checkers.md

A FOLDER was written by `kinfold mutate`. CHECKERS.json is a list of
{"name": "…", "version": "…", "formats": ["URDF"], "program": ["…", "{}"], "options": ["--found-by", "exit"]};
one without a program is kinfold itself. Checkers are other people's programs in environments of their
own, so nothing of this runs in CI. `kinfold` is taken from the search path, or from KINFOLD.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

KINFOLD = os.environ.get("KINFOLD", "kinfold")


def asked(checker, folders):
    """The answer of `kinfold bench-check` for one checker."""
    kept = os.environ.get("CHECKERS_KEPT")
    path = Path(kept) / f"{checker['name']}.json" if kept else None
    if path and path.is_file():
        return json.loads(path.read_text())
    command = [KINFOLD, "bench-check", "--json", *checker.get("options", [])]
    for folder in folders:
        command += ["--mutants", str(folder)]
    if checker.get("program"):
        command += ["--", *checker["program"]]
    said = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    if said.returncode not in (0, 3):
        sys.exit(f"{checker['name']}: exit {said.returncode}")
    if path:
        path.write_text(said.stdout)
    return json.loads(said.stdout)


def middle(numbers):
    """The median."""
    numbers = sorted(numbers)
    return numbers[len(numbers) // 2] if numbers else 0.0


def main():
    checkers = json.loads(Path(sys.argv[1]).read_text())
    folders = [Path(folder) for folder in sys.argv[2:]]
    formats = {f: json.loads((f / "mutants.json").read_text())["format"] for f in folders}
    kinds = [k["kind"] for k in json.loads(
        subprocess.run([KINFOLD, "mutate", "--list", "--json"], stdout=subprocess.PIPE, text=True,
                       check=True).stdout)]
    rows, by_kind = [], {}
    for checker in checkers:
        mine = [f for f in folders if formats[f] in checker["formats"]]
        answer = asked(checker, mine)
        all_of = answer["mutants"]
        found = sum(m["found"] for m in all_of)
        alarms = sum(o["alarm"] is not None for o in answer["originals"])
        unanswered = sum(m["by"].startswith(("no answer", "it broke down")) for m in all_of)
        rows.append((checker, len(answer["originals"]), len(all_of), found, alarms, unanswered,
                     middle([m["seconds"] for m in all_of])))
        for mutant in all_of:
            cell = by_kind.setdefault(mutant["kind"], {}).setdefault(checker["name"], [0, 0])
            cell[0] += mutant["found"]
            cell[1] += 1
    print("# What checkers find\n")
    print("Of the same planted defects ([the kinds](mutants.md)), by `kinfold bench-check`. Made by "
          "`benches/checkers.py`, outside CI. A program finds a mutant where its exit code turns from 0, "
          "or where its output has a finding that it had not on the model without the defect. kinfold "
          "finds one where a rule of that kind finds what it had not found before: stricter than what is "
          "asked of the others. Seconds are of a clock, beside other work: an upper bound. Not every checker was asked of every model: the "
          "third and the fifth column say of how many, and the last table of which kinds.\n")
    print("| Checker | Formats | Models | Found | Of | Share | False alarms | No answer | Seconds a file |")
    print("|---|---|---|---|---|---|---|---|---|")
    for checker, models, count, found, alarms, unanswered, seconds in rows:
        print(f"| {checker['name']} {checker['version']} | {', '.join(checker['formats'])} | {models} "
              f"| {found} | {count} | {100 * found / max(count, 1):.1f} % | {alarms} | {unanswered} "
              f"| {seconds:.2f} |")
    print("\n## Kind by kind\n\nFound of planted; a dash where no model that the checker reads has a place "
          "for it.\n")
    names = [c["name"] for c in checkers]
    print("| Kind | " + " | ".join(names) + " |")
    print("|---|" + "---|" * len(names))
    for kind in kinds:
        cells = by_kind.get(kind)
        if cells:
            told = [f"{cells[n][0]}/{cells[n][1]}" if n in cells else "–" for n in names]
            print(f"| `{kind}` | " + " | ".join(told) + " |")


if __name__ == "__main__":
    main()
