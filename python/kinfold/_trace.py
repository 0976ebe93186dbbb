"""Traces: how assets came to be, step by step. Strangers' traces are read in a process of their own."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from . import _kinfold
from ._apart import program
from ._arrays import PathLike, path_text
from ._asset import Asset
from ._errors import InputError, KinfoldError, RunError
from ._html import table


class Stage(NamedTuple):
    """An input, or a step of the run, as the trace has it.

    Attributes:
        name: its name, such as ``"articulate"``.
        event: ``"finished"`` or ``"failed"``.
        identity: who did the work, where somebody was asked.
        outputs: what it made, by name, each with its digest.
        notes: losses and doubts.
    """

    name: str
    event: str
    identity: str | None
    outputs: dict[str, str]
    notes: tuple[str, ...]


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
        events = (event["event"] for event in self._told["events"])
        return tuple(_stage(event) for event in events if event["event"] != "started")

    @property
    def artefacts(self) -> tuple[str, ...]:
        """The names of what is kept whole in the trace."""
        return tuple(kept["name"] for kept in self._told["attachments"])

    def __iter__(self) -> Iterator[Stage]:
        return iter(self.stages)

    def read(self, name: str) -> bytes:
        """The bytes of one artefact, such as ``"condition.json"``.

        Raises:
            RunError: where the trace does not keep it.
        """
        import tempfile

        with tempfile.TemporaryDirectory(prefix="kinfold-") as folder:
            out = os.path.join(folder, "artefact")
            _kinfold.trace(["extract", f"--out={out}", "--", str(self.path), name])
            return Path(out).read_bytes()

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
        rows = [[stage.name, stage.event, stage.identity or "", ", ".join(stage.outputs)] for stage in self]
        return table(["stage", "", "by", "made"], rows, str(self.path))

    def __repr__(self) -> str:
        return f"Trace({str(self.path)!r})"


def _stage(event: dict[str, Any]) -> Stage:
    outputs = {made["name"]: made["digest"] for made in event.get("outputs", ())}
    return Stage(
        event["stage"], event["event"], event.get("identity"), outputs, tuple(event.get("notes", ()))
    )


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
