"""Many photos to many assets, killed and gone on with at any moment."""

from __future__ import annotations

import json
import logging
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from . import _kinfold
from ._arrays import PathLike, as_file, names_of, path_text, whole_number
from ._asset import Asset
from ._condition import condition_text
from ._errors import InputError, RunError
from ._html import table
from ._make import EXPORTS, Progress, made_tier, shown

if TYPE_CHECKING:
    from ._verdict import Tier

logger = logging.getLogger("kinfold")

_FIELDS = ("id", "photo", "mesh", "condition", "seed", "category", "license", "min_confidence")


class Result(NamedTuple):
    """What became of an item.

    Attributes:
        id: the item.
        outcome: ``"accepted"``, ``"rejected"`` (made, and below what was asked for) or ``"failed"``.
        tier: the tier its asset reaches; none where there is none.
        confidence: how likely every part and joint is right, where the asset says.
        failure: what a failure is a failure of: input, transient, budget, provider, model, geometry, verdict.
        stage: the stage that failed.
        reason: why it is not accepted.
        folder: where it stands: in ``assets``, or in ``quarantine``.
        record: all that the ledger says of it.
    """

    id: str
    outcome: str
    tier: str | None
    confidence: float | None
    failure: str | None
    stage: str | None
    reason: str | None
    folder: Path
    record: dict[str, Any]

    @property
    def asset(self) -> Asset:
        """Its asset.

        Raises:
            RunError: where it has none.
        """
        if self.outcome == "failed":
            raise RunError(f"{self.id}: there is no asset: {self.reason}")
        return Asset(self.folder)


class Batch:
    """Many items, each to an asset: ``kinfold batch``, with the same ledger, store and bytes.

    Going through a batch makes what has no outcome yet and gives each result as it comes. It may be broken
    off at any moment, by Ctrl-C or a kill: the same batch goes on from there. ``results`` are those of all
    runs.

    >>> batch = kinfold.Batch([{"photo": photo, "mesh": mesh, "condition": condition}], scratch / "batch")
    >>> [(result.id, result.outcome) for result in batch]
    [('photo', 'accepted')]
    >>> [result.tier for result in batch.results()], list(batch)
    (['dynamic'], [])

    Args:
        items: a manifest's path (JSON Lines, .csv, or a folder of photos); or items, each a dictionary with
            some of ``id``, ``photo``, ``mesh``, ``condition``, ``seed``, ``category``, ``license`` and
            ``min_confidence``. Meshes and conditions may be in memory; they are kept in ``<out>.items``.
        out: where assets, quarantine and ledger go.
        export: formats besides URDF, as :func:`kinfold.make` has them.
        pages: whether a page and pictures are written for each asset, too.
        tier: the tier an asset is accepted from.
        min_confidence: the probability asked for that every part and joint is right, of items that name none.
        seed: of items that name none.
        jobs: stages that compute at a time; one per core without.
        max_calls: most requests that may cost, over all runs.
        max_cost: most cost of them, in the currency of the prices.
        mesh_price: what a mesh costs.
        condition_price: what a condition costs.
        retry: classes of failures that are tried again, such as ``"provider"``.
        state: where finished stages are kept; in ``out`` without.
        config: a ``kinfold.toml``, which says who is asked; whoever names it approves it.
        clock: the time written into traces and ledger, for runs that repeat byte for byte.
        wait: whether another batch in the folder is waited for.
        progress: called with a :class:`kinfold.Progress` for every stage and item, of which ``done`` and
            ``total`` are items of this run; ``True`` shows a bar of tqdm's.

    Raises:
        InputError: what was given cannot be used.
    """

    def __init__(
        self,
        items: PathLike | Iterable[Mapping[str, Any]],
        out: PathLike,
        *,
        export: Iterable[str] | str = (),
        pages: bool = False,
        tier: Tier = "kinematic",
        min_confidence: float | None = None,
        seed: int = 0,
        jobs: int | None = None,
        max_calls: int | None = None,
        max_cost: float | None = None,
        mesh_price: float | None = None,
        condition_price: float | None = None,
        retry: Iterable[str] | str = (),
        state: PathLike | None = None,
        config: PathLike | None = None,
        clock: str | int | None = None,
        wait: bool = True,
        progress: Callable[[Progress], object] | bool | None = None,
    ) -> None:
        self.out = Path(path_text("out", out))
        names = names_of("export", export)
        if unknown := [name for name in names if name not in EXPORTS]:
            known = ", ".join(EXPORTS)
            raise InputError(f"export: expected some of {known}, found {unknown[0]!r}")
        words = ["--json", "--quiet", f"--tier={made_tier(tier)}"]
        words += [f"--seed={whole_number('seed', seed, 0, 2**64 - 1)}"]
        words += [f"--export={','.join(names)}"] if names else []
        words += ["--pages"] if pages else []
        counts = {"jobs": jobs, "max-calls": max_calls}
        for flag, count in counts.items():
            if count is not None:
                words.append(f"--{flag}={whole_number(flag.replace('-', '_'), count, 0, 2**63 - 1)}")
        amounts = {
            "min-confidence": min_confidence,
            "max-cost": max_cost,
            "mesh-price": mesh_price,
            "condition-price": condition_price,
        }
        words += [f"--{flag}={amount}" for flag, amount in amounts.items() if amount is not None]
        again = names_of("retry", retry)
        words += [f"--retry={','.join(again)}"] if again else []
        words += [f"--state={path_text('state', state)}"] if state is not None else []
        words += [f"--config={path_text('config', config)}"] if config is not None else []
        words += [f"--clock={clock}"] if clock is not None else []
        words += [] if wait else ["--no-wait"]
        self._progress = progress
        if isinstance(items, (str, bytes, os.PathLike)):
            self.manifest = Path(path_text("items", items))
            if not self.manifest.exists():
                hint = "name a .jsonl or .csv file, or a folder of photos; or give items"
                raise InputError(f"{self.manifest}: expected a manifest, found none", hints=[hint])
        else:
            self.manifest = _written(items, self.out)
        self._words = [*words, f"--out={self.out}", "--", str(self.manifest)]
        self.summary: dict[str, Any] | None = None
        """What the last run came to; none before."""

    def __iter__(self) -> Iterator[Result]:
        """Makes what has no outcome yet; gives each result as it comes."""
        show, close = shown(self._progress)
        done, total = 0, self._lines()
        running = _kinfold.Batch(self._words)
        try:
            while (news := running.next()) is not None:
                told = json.loads(news)
                if "record" not in told:
                    logger.info("%s: %s", told["item"], told["stage"])
                    show(Progress(f"{told['item']}: {told['stage']}", "running", done, max(total, done)))
                    continue
                result = self._result(told["record"])
                done += 1
                show(Progress(result.id, result.outcome, done, max(total, done)))
                yield result
            _, answer, remarks = running.answer() or (0, "{}", [])
            for remark in remarks:
                logger.warning("%s", remark)
            self.summary = json.loads(answer)
        except KeyboardInterrupt as error:
            error.add_note("hint: what has an outcome keeps it: the same batch goes on from there")
            raise
        finally:
            running.stop()
            # The folder is somebody's until the run has left it.
            _drained(running)
            close()

    def run(self) -> list[Result]:
        """Makes what has no outcome yet; the results of all items, by id.

        Raises:
            RunError: where it cannot go on; what has an outcome keeps it.
        """
        for _ in self:
            pass
        return self.results()

    def results(self) -> list[Result]:
        """The latest result of every item that has one, of all runs, by id."""
        import sqlite3

        ledger = self.out / "ledger.sqlite"
        if not ledger.is_file():
            return []
        address = ledger.absolute().as_uri() + "?mode=ro"
        try:
            with closing(sqlite3.connect(address, uri=True, timeout=30)) as table_:
                rows = table_.execute("SELECT facts FROM items ORDER BY id").fetchall()
        except sqlite3.Error as error:
            hint = "`kinfold audit` on the folder says more"
            raise RunError(f"{ledger}: it cannot be read as a ledger: {error}", hints=[hint]) from error
        return [self._result(json.loads(facts)) for (facts,) in rows]

    def _result(self, record: dict[str, Any]) -> Result:
        place = "assets" if record["outcome"] == "accepted" else "quarantine"
        return Result(
            record["id"],
            record["outcome"],
            record["verdict"],
            record["confidence"],
            record["class"],
            record["stage"],
            record["reason"],
            self.out / place / record["id"],
            record,
        )

    def _lines(self) -> int:
        """About how many items there are: lines, or files of a folder."""
        try:
            if self.manifest.is_dir():
                return sum(1 for _ in self.manifest.iterdir())
            with self.manifest.open("rb") as file:
                return sum(1 for line in file if line.strip())
        except OSError:
            return 0

    def _repr_html_(self) -> str:
        rows = [[r.id, r.outcome, r.tier or "", r.reason or ""] for r in self.results()]
        return table(["item", "outcome", "tier", "why not"], rows, str(self.out))

    def __repr__(self) -> str:
        return f"Batch({str(self.manifest)!r}, {str(self.out)!r})"


def _drained(running: _kinfold.Batch) -> None:
    """Waits until a batch that was told to stop has ended, however it ends."""
    if running.answer() is None:
        try:
            while running.next() is not None:
                pass
        except (KeyboardInterrupt, RunError):
            return


def _written(items: object, out: Path) -> Path:
    """The manifest of some items, with what of them is in memory, in a folder beside the batch's. The same
    items make the same bytes, so that a batch goes on."""
    if not isinstance(items, Iterable) or isinstance(items, Mapping):
        kind = type(items).__name__
        raise InputError(f"items: expected a manifest's path or a list of items, found {kind}")
    folder = out.with_name(out.name + ".items").absolute()
    lines = []
    for number, item in enumerate(items):
        if not isinstance(item, Mapping):
            raise InputError(f"items[{number}]: expected a dictionary, found {type(item).__name__}")
        if unknown := [name for name in item if name not in _FIELDS]:
            known = ", ".join(_FIELDS)
            raise InputError(f"items[{number}]: expected some of {known}, found {unknown[0]!r}")
        line = {name: value for name, value in item.items() if value is not None}
        for name, ending, content in [("mesh", "glb", _mesh), ("condition", "json", _condition)]:
            if name in line and (made := content(line[name])) is not None:
                line[name] = _kept(folder, made, ending)
        for name in ("photo", "mesh", "condition"):
            if name in line:
                line[name] = os.path.abspath(path_text(f"items[{number}]: {name}", line[name]))
        try:
            lines.append(json.dumps(line, allow_nan=False, sort_keys=True) + "\n")
        except (TypeError, ValueError) as error:
            raise InputError(f"items[{number}]: {error}") from None
    if not lines:
        raise InputError("items: expected some items, found none")
    manifest = folder / "items.jsonl"
    _placed(manifest, "".join(lines).encode())
    return manifest


def _mesh(mesh: object) -> bytes | None:
    return None if isinstance(mesh, (str, bytes, os.PathLike)) else as_file(mesh)


def _condition(condition: object) -> bytes | None:
    is_path = isinstance(condition, (str, os.PathLike)) and str(condition).lstrip()[:1] != "{"
    return None if is_path else condition_text(condition).encode()


def _kept(folder: Path, content: bytes, ending: str) -> str:
    file = folder / f"{_kinfold.digest(content)[:32]}.{ending}"
    _placed(file, content)
    return str(file)


def _placed(file: Path, content: bytes) -> None:
    """Puts a file where it belongs, whole or not at all."""
    try:
        if file.is_file() and file.read_bytes() == content:
            return
        file.parent.mkdir(parents=True, exist_ok=True)
        handle, draft = tempfile.mkstemp(dir=file.parent)
        with os.fdopen(handle, "wb") as written:
            written.write(content)
        os.replace(draft, file)
    except OSError as error:
        raise RunError(f"{file}: {error.strerror}", hints=["name another folder with out="]) from error
