"""What an articulator is worth on objects whose parts and joints are known."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from . import _kinfold
from ._arrays import PathLike, names_of, path_text, whole_number
from ._errors import MissingError

if TYPE_CHECKING:
    import pandas as pd


class Evaluation:
    """Scores, case by case and in the mean.

    Attributes:
        articulator: who answered, with its version.
        mode: what was given.
        cases: one row per case, by name, as nested dictionaries; ``error`` says why a case has no answer.
        means: means over all objects; none where there are none.
        sets: the same of each set of cases.
        text: the table that the command line prints.
    """

    def __init__(self, report: dict[str, Any], text: str) -> None:
        self._report = report
        self.text = text
        self.articulator: str = report["articulator"]
        self.mode: str = report["mode"]
        self.cases: tuple[dict[str, Any], ...] = tuple(report["cases"])
        self.means: dict[str, Any] | None = report["all"]
        self.sets: dict[str, dict[str, Any]] = dict(report["sets"])

    @property
    def failed(self) -> tuple[str, ...]:
        """The cases that got no answer; they count as the worst."""
        return tuple(row["case"] for row in self.cases if row.get("error"))

    def to_dict(self) -> dict[str, Any]:
        """Everything in full."""
        copied: dict[str, Any] = json.loads(json.dumps(self._report))
        return copied

    def to_pandas(self) -> pd.DataFrame:
        """The cases as a table, one a row; names of columns have dots where scores are nested."""
        try:
            import pandas
        except ImportError:
            raise MissingError("to_pandas needs pandas", hints=["pip install pandas"]) from None
        return pandas.json_normalize(list(self.cases)).set_index("case")

    def _repr_html_(self) -> str:
        from html import escape

        return f"<pre>{escape(self.text)}</pre>"

    def __repr__(self) -> str:
        return f"Evaluation({len(self.cases)} cases, {self.articulator!r}, failed={list(self.failed)})"


def evaluate(
    cases: PathLike,
    *,
    mode: Literal["mesh+kinematic", "mesh", "image"] = "mesh+kinematic",
    articulator: str = "default",
    filter: str | None = None,
    sets: Iterable[str] | str = (),
    without: Iterable[str] | str = (),
    jobs: int = 1,
    points: int = 100_000,
    seed: int = 0,
    config: PathLike | None = None,
    state: PathLike | None = None,
) -> Evaluation:
    """Measures an articulator on case folders: ``kinfold eval``, with the same figures.

    A case is a folder with ``mesh.glb``, ``condition.json``, ``truth.json`` and ``face_labels.u16le``. One
    without an answer is a row with its error, and counts as the worst. The interpreter's lock is not held
    meanwhile.

    Args:
        cases: a folder of case folders.
        mode: what is given: mesh and condition, the mesh alone, or a picture.
        articulator: who answers: ``"default"`` or ``"geometric"``.
        filter: only cases whose name holds this.
        sets: only cases of these sets.
        without: what is kept back: ``"text"``, ``"points"``.
        jobs: cases at a time.
        points: how many are drawn on each surface.
        seed: of everything random.
        config: a ``kinfold.toml`` that says who is asked, for the other modes.
        state: where what was asked for is kept.

    Raises:
        InputError: where there are no cases, or something else cannot be used.
    """
    name = path_text("cases", cases)
    words = ["--quiet", f"--mode={mode}", f"--articulator={articulator}"]
    words += [
        f"--jobs={whole_number('jobs', jobs, 1, 256)}",
        f"--points={whole_number('points', points, 1, 10_000_000)}",
        f"--seed={whole_number('seed', seed, 0, 2**64 - 1)}",
    ]
    words += [f"--filter={filter}"] if filter is not None else []
    for flag, listed in [("set", names_of("sets", sets)), ("without", names_of("without", without))]:
        words += [f"--{flag}={','.join(listed)}"] if listed else []
    for flag, path in [("config", config), ("state", state)]:
        words += [f"--{flag}={path_text(flag, path)}"] if path is not None else []
    with tempfile.TemporaryDirectory(prefix="kinfold-", ignore_cleanup_errors=True) as folder:
        file = os.path.join(folder, "report.json")
        _, text, _ = _kinfold.evaluate([*words, f"--json={file}", "--", name])
        return Evaluation(json.loads(Path(file).read_bytes()), text)
