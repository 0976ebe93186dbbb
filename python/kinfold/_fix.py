"""Models mended by the smallest changes of their text."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from typing import Any, Literal, NamedTuple

from . import _kinfold
from ._arrays import PathLike, names_of, path_text
from ._errors import InputError, RunError
from ._verdict import Judging, Verdict, judging


class Change(NamedTuple):
    """A change of a model's text.

    Attributes:
        rules: the checks that asked for it.
        subject: what it is about, such as ``"joint `hinge`"``.
        line: its line in the file.
        change: what was changed, in words.
    """

    rules: tuple[str, ...]
    subject: str
    line: int
    change: str


class Left(NamedTuple):
    """What a check still finds.

    Attributes:
        rule: the check.
        finding: what it found.
        why: why nothing was done about it, or what a person can do.
        counts: whether it lowers the tier.
    """

    rule: str
    finding: str
    why: str
    counts: bool


class Fix:
    """A model before and after.

    Attributes:
        path: the file.
        written: whether the file was changed.
        before: the verdict on the file as it was.
        after: the verdict on the text that stands there, or would.
        changes: what was changed, in the order of trying.
        left: what stays.
        diff: the changes, as ``git apply`` and ``patch -p1`` read them; empty where there are none.
        new_files: meshes that go with them; they are there only if it was written.
        out_of_time: whether time ran out before everything was tried.
    """

    def __init__(self, told: Mapping[str, Any]) -> None:
        self.path: str = told["file"]
        self.written: bool = told["written"]
        verdicts = told["verdicts"]
        self.before = Verdict(verdicts["before"], self.path, "kinematic")
        self.after = Verdict(verdicts["after"], self.path, "kinematic")
        self.changes: tuple[Change, ...] = tuple(
            Change(tuple(c["rules"]), c["subject"], c["line"], c["change"]) for c in told["changes"]
        )
        self.left: tuple[Left, ...] = tuple(Left(**one) for one in told["left"])
        self.diff: str = told["diff"]
        self.new_files: tuple[str, ...] = tuple(told["new_files"])
        self.out_of_time: bool = told["out_of_time"]

    def _repr_html_(self) -> str:
        from html import escape

        from ._html import table

        rows = [[", ".join(c.rules), "changed", c.subject, c.change] for c in self.changes]
        rows += [[one.rule, "stays", one.finding, one.why] for one in self.left]
        done = "written" if self.written else "not written"
        caption = f"{self.path}: tier {self.before.tier} before, {self.after.tier} after, {done}"
        return table(["", "", "about", ""], rows, caption) + f"<pre>{escape(self.diff)}</pre>"

    def __repr__(self) -> str:
        tiers = f"{self.before.tier!r} -> {self.after.tier!r}"
        return f"Fix({self.path!r}, {len(self.changes)} changes, tier {tiers}, written={self.written})"


def fix(
    path: PathLike,
    write: bool = False,
    *,
    only: Iterable[str] | str = (),
    flags: bool = False,
    allow_outside: bool = False,
    as_: Literal["object", "robot"] | None = None,
    base: Literal["fixed", "free"] | None = None,
    packages: Mapping[str, PathLike] | None = None,
    deadline: float = 300.0,
    seed: int = 0,
) -> Fix:
    """Mends a URDF or MJCF model by the smallest changes of its text, whoever wrote it.

    A change stays only if the checks find less for it and none is worse. Nothing is written unless that is
    asked for: ``diff`` says what would be. It is read and mended in a process of its own.

    >>> mended = kinfold.fix(folder / "asset.urdf")
    >>> mended.changes, mended.diff, mended.after.tier
    ((), '', 'dynamic')

    Args:
        path: the file.
        write: whether the changes are written into the file, in one step; new meshes go beside those it has.
        only: checks whose findings are mended, warnings too, and nothing else; all without.
        flags: whether what is a warning only is mended, too.
        allow_outside: whether meshes may lie outside the file's folder.
        as_: judge it as an object or a robot; as what is found, without.
        base: judge it with a base that is fixed or free; as what is found, without.
        packages: where packages lie that ``package://`` names.
        deadline: the longest time, seconds; two thirds of it are for trying changes.
        seed: of everything random.

    Raises:
        InputError: where there is no such file, or nothing mends what a check of ``only`` finds.
        RunError: where it is no model, or cannot be written.
    """
    name = path_text("path", path)
    if not os.path.exists(name):
        raise InputError(f"{name}: expected a file, found none")
    options: Judging = {
        "allow_outside": allow_outside,
        "as_": as_,
        "base": base,
        "packages": packages,
        "deadline": deadline,
        "seed": seed,
    }
    words = ["--json", *judging("fix", options)]
    words += [f"--only={rule}" for rule in names_of("only", only)]
    words += ["--write"] if write else []
    words += ["--flags"] if flags else []
    _, told, remarks = _kinfold.fix([*words, "--", name])
    if not told:
        raise RunError(f"{name}: nothing is said of it", remarks)
    return Fix(json.loads(told))
