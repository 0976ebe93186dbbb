"""Traces: how assets came to be, step by step. Strangers' traces are read in a process of their own."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from . import _kinfold
from ._apart import program
from ._arrays import PathLike, path_text, read_mesh
from ._asset import Asset
from ._condition import Condition
from ._errors import InputError, KinfoldError, RunError
from ._html import Bar, table
from ._verdict import Verdict


class Stage(NamedTuple):
    """An input, or a step of the run, as the trace has it.

    Attributes:
        name: its name, such as ``"articulate"``.
        event: ``"finished"`` or ``"failed"``.
        identity: who did the work, where somebody was asked.
        outputs: what it made, by name, each with its digest.
        notes: losses and doubts.
        began: when it began, seconds after the first event; one clock for all where a run was given one.
        ended: when it was over.
        inputs: what it was given, by name, each with its digest.
    """

    name: str
    event: str
    identity: str | None
    outputs: dict[str, str]
    notes: tuple[str, ...]
    began: float = 0.0
    ended: float = 0.0
    inputs: dict[str, str] = {}  # noqa: RUF012 - never changed


class Trace:
    """The record of one run, from its file or its asset's folder; iterating gives its stages.

    >>> [stage.name for stage in kinfold.Trace(folder)][:3]
    ['photo', 'generate-mesh', 'render-views']
    """

    def __init__(self, path: PathLike) -> None:
        self.path = Path(path_text("path", path))

    @cached_property
    def _told(self) -> dict[str, Any]:
        told: dict[str, Any] = json.loads(_apart(["show", "--json", "--", str(self.path)]))
        return told

    @property
    def manifest(self) -> dict[str, Any]:
        """What the run was asked to do, and by whom it was done."""
        return dict(self._told["manifest"])

    @property
    def stages(self) -> tuple[Stage, ...]:
        """What became of every stage, in order."""
        events = self._told["events"]
        first = events[0]["time_ns"] if events else 0
        began: dict[str, float] = {}
        stages: list[Stage] = []
        for line in events:
            event, at = line["event"], (line["time_ns"] - first) / 1e9
            if event["event"] == "started":
                began[event["stage"]] = at
            else:
                start = began[event["stage"]] if event["stage"] in began else at
                stages.append(_stage(event, start, at))
        return tuple(stages)

    @property
    def artefacts(self) -> tuple[str, ...]:
        """The names of what stages made and the trace keeps whole; ``manifest`` is apart."""
        names = (kept["name"] for kept in self._told["attachments"])
        return tuple(name for name in names if name != "manifest.json")

    def __iter__(self) -> Iterator[Stage]:
        return iter(self.stages)

    def read(self, name: str) -> bytes:
        """The bytes of one artefact, such as ``"condition.json"``.

        Raises:
            RunError: where the trace does not keep it.
        """
        with tempfile.TemporaryDirectory(prefix="kinfold-") as folder:
            out = os.path.join(folder, "artefact")
            _kinfold.trace(["extract", f"--out={out}", "--", str(self.path), name])
            return Path(out).read_bytes()

    def load(self, name: str) -> Any:
        """One artefact as an object: a :class:`kinfold.Condition`, :class:`kinfold.Verdict` or
        :class:`kinfold.Mesh`, a JSON document as a dictionary; whatever else there is as its bytes.

        Raises:
            RunError: where the trace does not keep it.
        """
        content = self.read(name)
        ending = name.rpartition(".")[2].lower()
        if name == "condition.json":
            return Condition.from_json(_kinfold.condition_kept(content))
        if ending == "json":
            document = json.loads(content)
            is_verdict = isinstance(document, dict) and {"tier", "asked", "checks"} <= document.keys()
            return Verdict(document, f"{self.path}: {name}") if is_verdict else document
        if ending in ("glb", "obj", "stl", "ply"):
            with tempfile.TemporaryDirectory(prefix="kinfold-") as folder:
                file = Path(folder, f"artefact.{ending}")
                file.write_bytes(content)
                return read_mesh(file)
        return content

    def verify(self, *, key: PathLike | None = None) -> dict[str, Any]:
        """Proves that the trace is whole and that the files beside it are those it names.

        Raises:
            RunError: with what does not hold.
        """
        words = ["verify", "--json"] + ([f"--key={path_text('key', key)}"] if key is not None else [])
        told: dict[str, Any] = json.loads(_apart([*words, "--", str(self.path)]))
        return told

    def replay(self, out: PathLike | None = None) -> dict[str, str]:
        """Runs the flow again, from the trace alone and without a network; returns digests by stage.

        Raises:
            RunError: at the first artefact that comes out other than recorded.
        """
        words = ["replay", "--json"] + ([f"--out={path_text('out', out)}"] if out is not None else [])
        _, told, _ = _kinfold.trace([*words, "--", str(self.path)])
        same: dict[str, str] = json.loads(told)["artefacts"]
        return same

    def diff(self, other: Trace | PathLike) -> dict[str, Any]:
        """What differs between this run and another."""
        path = other.path if isinstance(other, Trace) else Path(path_text("other", other))
        told: dict[str, Any] = json.loads(
            _apart(["diff", "--json", "--", str(self.path), str(path)], also=(1, 3))
        )
        return told

    def asset(self) -> Asset:
        """The asset in whose folder it stands."""
        return Asset(self.path if self.path.is_dir() else self.path.parent)

    def _repr_html_(self) -> str:
        stages = self.stages
        whole = max((stage.ended for stage in stages), default=0.0)
        rows = [
            [
                stage.name,
                stage.event,
                f"{stage.ended - stage.began:.2f} s",
                Bar(stage.began, stage.ended, whole, failed=stage.event == "failed"),
                stage.identity or "",
                ", ".join(stage.outputs),
            ]
            for stage in stages
        ]
        caption = f"{self.path}: {whole:.2f} s"
        return table(["stage", "", "took", "when", "by", "made"], rows, caption)

    def __repr__(self) -> str:
        return f"Trace({str(self.path)!r})"


def _stage(event: dict[str, Any], began: float, ended: float) -> Stage:
    made, given = (
        {one["name"]: one["digest"] for one in event.get(name, ())} for name in ("outputs", "inputs")
    )
    notes = tuple(event.get("notes", ()))
    return Stage(event["stage"], event["event"], event.get("identity"), made, notes, began, ended, given)


def _apart(words: Sequence[str], *, also: tuple[int, ...] = ()) -> str:
    """What the program that works apart says about a trace."""
    import subprocess

    ended = subprocess.run(
        [program(), "trace", *words], stdin=subprocess.DEVNULL, capture_output=True, check=False
    )
    told = ended.stdout.decode("utf-8", "replace")
    if ended.returncode == 0 or (ended.returncode in also and told):
        return told
    raise _error(ended.stderr.decode("utf-8", "replace"), ended.returncode)


def _error(words: str, code: int) -> KinfoldError:
    message, causes, hints = "", list[str](), list[str]()
    for line in words.splitlines():
        head, _, rest = line.strip().partition(": ")
        if head == "error" and not message:
            message = rest
        elif head == "caused by":
            causes.append(rest)
        elif head == "hint":
            hints.append(rest)
    kind = InputError if code == 2 else RunError
    return kind(message or f"looking at the trace ended with {code}", causes, hints)
