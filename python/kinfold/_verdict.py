"""What checks and rules find in model files."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypedDict, Unpack

from . import _kinfold
from ._arrays import PathLike, names_of, pairs_of, path_text, whole_number
from ._errors import InputError, MissingError, RunError, TierError
from ._html import table

if TYPE_CHECKING:
    import pandas as pd

Tier = Literal["parse", "static", "kinematic", "dynamic", "audited"]
#: From nothing to most.
TIERS = ("none", "parse", "static", "kinematic", "dynamic", "audited")
CLIENTS = ("mujoco", "pybullet", "drake", "newton", "isaac", "sapien", "genesis", "rerun")


class Check(NamedTuple):
    """What was checked, and what was found.

    Attributes:
        id: its id in the profile, such as ``"C1"``.
        rule: the rule in plain words.
        status: ``"pass"``, ``"warn"``, ``"fail"`` or ``"unknown"``; unknown is a failure.
        severity: how much it counts.
        value: the worst figure found.
        unit: of that figure.
        threshold: the bound, in words.
        evidence: what was found, worst first.
        waived: why somebody lets it pass, or none.
    """

    id: str
    rule: str
    status: str
    severity: str
    value: float | None
    unit: str
    threshold: str
    evidence: tuple[str, ...]
    waived: str | None

    @property
    def holds(self) -> bool:
        """Whether it passed, if with a warning."""
        return self.status in ("pass", "warn")


class Verdict(Mapping[str, Check]):
    """What the checks found about one model, check by check; a mapping of ids to checks."""

    def __init__(self, document: Mapping[str, Any], path: str = "", asked: str | None = None) -> None:
        self._document = dict(document)
        self.path = path
        self.tier: str = document["tier"]
        self.asked: str = asked or document["asked"]
        self.profile: str = document["profile"]
        self.robot: str = document.get("robot", "")
        self.counts: dict[str, int] = dict(document["counts"])
        self.checks: tuple[Check, ...] = tuple(_check(check) for check in document["checks"])
        self._by_id = {check.id: check for check in self.checks}

    def __getitem__(self, key: str) -> Check:
        return self._by_id[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._by_id)

    def __len__(self) -> int:
        return len(self._by_id)

    @property
    def failures(self) -> tuple[Check, ...]:
        """The checks that failed or could not be judged, and that nobody answers for."""
        return tuple(c for c in self.checks if not c.holds and c.waived is None)

    def reaches(self, tier: Tier) -> bool:
        """Whether the model gets as far as this tier."""
        return TIERS.index(self.tier) >= TIERS.index(tier_name(tier))

    def raise_for_tier(self, tier: Tier | None = None) -> Verdict:
        """Returns itself if the tier is reached: this one, or else the one that was asked for.

        Raises:
            TierError: with the checks that fail.
        """
        asked: Any = tier or self.asked
        if self.reaches(asked):
            return self
        failed = [f"{c.id}: {c.rule}" + (f" ({c.evidence[0]})" if c.evidence else "") for c in self.failures]
        what = self.path or self.robot or "the model"
        first = f"`kinfold explain {self.failures[0].id}` says more" if self.failures else ""
        error = TierError(
            f"{what} reaches tier {self.tier}, asked for {asked}", failed, [first] if first else []
        )
        error.verdict = self
        raise error

    def to_dict(self) -> dict[str, Any]:
        """The verdict as it stands in ``verdict.json``."""
        copied: dict[str, Any] = json.loads(json.dumps(self._document))
        return copied

    def to_pandas(self) -> pd.DataFrame:
        """The checks as a table, one a row."""
        try:
            import pandas
        except ImportError:
            raise MissingError("to_pandas needs pandas", hints=["pip install pandas"]) from None
        return pandas.DataFrame(list(self.checks), columns=list(Check._fields)).set_index("id")

    def _repr_html_(self) -> str:
        shown = [c for c in self.checks if not c.holds or c.status == "warn"]
        counts = ", ".join(f"{number} {word}" for word, number in self.counts.items() if number)
        rows = [
            [c.id, "waived" if c.waived else c.status, c.rule, c.evidence[0] if c.evidence else ""]
            for c in shown
        ]
        caption = f"{self.path or self.robot}: tier {self.tier}, {counts}"
        return table(["", "status", "rule", "found"], rows, caption)

    def __repr__(self) -> str:
        failed = [check.id for check in self.failures]
        return f"Verdict(tier={self.tier!r}, asked={self.asked!r}, failures={failed})"


def _check(check: Mapping[str, Any]) -> Check:
    return Check(
        check["id"],
        check["rule"],
        check["status"],
        check["severity"],
        check.get("value"),
        check.get("unit", ""),
        check.get("threshold", ""),
        tuple(check.get("evidence", ())),
        check.get("waived"),
    )


def tier_name(tier: object) -> Tier:
    """A tier that can be asked for, or why it is none."""
    if tier in TIERS[1:]:
        return tier  # type: ignore[return-value]
    raise InputError(f"tier: expected one of {', '.join(TIERS[1:])}, found {tier!r}")


class Judging(TypedDict, total=False):
    """How models are judged: what :func:`check` and :func:`check_all` take besides paths, and :func:`fix` in
    part.

    Attributes:
        tier: the tier asked for; no check above it runs. Unless given, kinematic is asked for and the
            simulation runs too.
        waive: checks that may fail, by id, each with a reason.
        allow_outside: whether meshes may lie outside the file's folder.
        as_: judge it as an object or a robot; as what is found, without.
        base: judge it with a base that is fixed or free; as what is found, without.
        packages: where packages lie that ``package://`` names.
        deadline: the longest time, seconds; 120 without.
        seed: of everything random; 0 without.
    """

    tier: Tier | None
    waive: Mapping[str, str] | None
    allow_outside: bool
    as_: Literal["object", "robot"] | None
    base: Literal["fixed", "free"] | None
    packages: Mapping[str, PathLike] | None
    deadline: float
    seed: int


def check(path: PathLike, **options: Unpack[Judging]) -> Verdict:
    """Checks a URDF, xacro, MJCF, SDFormat or USD model and says how far it gets, whoever wrote it.

    It is read in a process of its own, so no file can hang or crash this one. What could not be decided
    is ``unknown``, and unknown is a failure. A verdict below the tier is no exception:
    ``check(path).raise_for_tier()`` makes it one.

    >>> verdict = kinfold.check(folder / "asset.urdf", tier="dynamic")
    >>> verdict.raise_for_tier().tier, verdict["C1"].status
    ('dynamic', 'pass')

    Args:
        path: the file.
        options: how it is judged: ``tier``, ``waive``, ``allow_outside``, ``as_``, ``base``, ``packages``,
            ``deadline`` and ``seed``, as :class:`Judging` says.

    Raises:
        InputError: where there is no such file.
    """
    name = path_text("path", path)
    if os.path.isdir(name):
        hint = "check_all looks through folders"
        raise InputError(f"{name}: expected a file, found a folder", hints=[hint])
    _, told, remarks = _kinfold.check([*_words("check", options), "--", name])
    if not told:
        raise RunError(f"{name}: there is no verdict", remarks)
    return Verdict(json.loads(told), name, options.get("tier") or "kinematic")


def check_all(
    paths: Iterable[PathLike] | PathLike, *, jobs: int | None = None, **options: Unpack[Judging]
) -> list[Verdict]:
    """Checks many models, ``jobs`` at a time, and those in folders at any depth; as :func:`check`."""
    if isinstance(paths, (str, bytes, os.PathLike)):
        paths = [paths]  # type: ignore[list-item]
    if not isinstance(paths, Iterable):
        raise InputError(f"paths: expected a path or several, found {type(paths).__name__}")
    names = [path_text("paths", path) for path in paths]
    if not names:
        return []
    if len(names) == 1 and not os.path.isdir(names[0]):
        return [check(names[0], **options)]
    words = _words("check_all", options)
    if jobs is not None:
        words += ["--jobs", str(jobs)]
    _, told, _ = _kinfold.check([*words, "--", *names])
    lines = [json.loads(line) for line in told.splitlines()]
    asked = options.get("tier") or "kinematic"
    return [Verdict(line["verdict"], line["file"], asked) for line in lines]


def _words(called: str, options: Judging) -> list[str]:
    # What a program asks does not depend on the folder it stands in.
    return ["--json", "--no-config", *judging(called, options)]


def judging(called: str, options: Judging) -> list[str]:
    """How models are judged, in the words of the command line."""
    if unknown := options.keys() - Judging.__annotations__.keys():
        raise TypeError(f"{called}() got an unexpected keyword argument {min(unknown)!r}")
    words = [
        f"--deadline={options.get('deadline', 120.0)}",
        f"--seed={whole_number('seed', options.get('seed', 0), 0, 2**64 - 1)}",
    ]
    if (tier := options.get("tier")) is not None:
        words += ["--tier", tier_name(tier)]
    words += [f"--waive={key}={reason}" for key, reason in pairs_of("waive", options.get("waive"))]
    packages = pairs_of("packages", options.get("packages"))
    words += [f"--package={key}={path_text('packages', where)}" for key, where in packages]
    words += ["--allow-outside"] if options.get("allow_outside") else []
    words += [f"--as={kind}"] if (kind := options.get("as_")) is not None else []
    words += [f"--base={base}"] if (base := options.get("base")) is not None else []
    return words


class Finding(NamedTuple):
    """What a client will do with a file, by a written rule.

    Attributes:
        rule: the rule's id.
        severity: how much follows.
        sentence: what will happen.
        remedy: what to do about it.
        version: with what it was measured, or what was read.
        places: where it applies, in the order of the file.
        total: in how many places.
    """

    rule: str
    severity: str
    sentence: str
    remedy: str
    version: str
    places: tuple[dict[str, Any], ...]
    total: int


class Forecast(NamedTuple):
    """What one client will do with a file. No rules means that nothing is known of it."""

    client: str
    rules: int
    findings: tuple[Finding, ...]

    def _repr_html_(self) -> str:
        rows = [[f.severity, f.sentence, f.remedy, f.rule] for f in self.findings]
        return table(["", "what happens", "remedy", "rule"], rows, f"{self.client}: {self.rules} rules asked")


def forecast(
    path: PathLike, clients: Sequence[str] | str = "all", *, allow_outside: bool = False
) -> list[Forecast]:
    """Says what simulators will do with a URDF, MJCF or USDA file, by written rules, without running them.

    ``clients`` are some of mujoco, pybullet, drake, newton, isaac, sapien, genesis and rerun.

    Raises:
        InputError: where the file cannot be read, or a client is not known.
    """
    names = ",".join(names_of("clients", clients))
    told = json.loads(_kinfold.forecast(path_text("path", path), names, bool(allow_outside)))
    return [_forecast(one) for one in told]


def _forecast(told: Mapping[str, Any]) -> Forecast:
    findings = tuple(
        Finding(
            f["rule"], f["severity"], f["sentence"], f["remedy"], f["version"], tuple(f["places"]), f["count"]
        )
        for f in told["findings"]
    )
    return Forecast(told["client"], told["rules"], findings)
