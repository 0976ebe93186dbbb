"""A finished asset: a folder, and what stands in it."""

from __future__ import annotations

import importlib
import json
from pathlib import Path
from typing import Any

from ._arrays import PathLike, path_text
from ._errors import InputError, MissingError, RunError
from ._html import framed
from ._verdict import Tier, Verdict


class Asset:
    """A folder that ``kinfold make`` left, or :func:`kinfold.make`.

    >>> asset = kinfold.Asset(folder)
    >>> asset.tier
    'dynamic'
    """

    def __init__(self, path: PathLike, *, told: dict[str, Any] | None = None) -> None:
        self.path = Path(path_text("path", path))
        if not self.urdf.is_file():
            hint = "kinfold.make leaves one; a folder of a run that failed has only its trace"
            raise InputError(f"{self.path}: expected an asset's folder, found no asset.urdf", hints=[hint])
        told = told or {}
        self.outcome: str | None = told.get("outcome")
        self.reason: str | None = told.get("reason")
        self.losses: tuple[str, ...] = tuple(told.get("losses", ()))
        self.doubts: tuple[str, ...] = tuple(told.get("doubts", ()))
        self.published: bool = told.get("published", True)
        self.stages: tuple[dict[str, Any], ...] = tuple(told.get("stages", ()))
        self.remarks: tuple[str, ...] = tuple(told.get("remarks", ()))
        self._asked: str | None = told.get("tier_asked")

    @property
    def urdf(self) -> Path:
        """The URDF."""
        return self.path / "asset.urdf"

    @property
    def trace(self) -> Path:
        """The trace of the run that made it."""
        return self.path / "trace.mcap"

    @property
    def page(self) -> Path:
        """The page that shows it in a browser."""
        return self.path / "viewer.html"

    @property
    def verdict(self) -> Verdict:
        """What the checks found about it."""
        return Verdict(self._json("verdict.json"), str(self.urdf), self._asked)

    @property
    def tier(self) -> str:
        """How far it gets in the checks."""
        return self.verdict.tier

    @property
    def description(self) -> dict[str, Any]:
        """Every number of it with its unit and its origin: ``asset.json``."""
        return self._json("asset.json")

    @property
    def confidence(self) -> float | None:
        """How likely every part and joint is right; none where it does not say."""
        said = self.description.get("confidence")
        return None if said is None else float(said["value"])

    def raise_for_tier(self, tier: Tier | None = None) -> Asset:
        """Returns itself if the tier is reached: this one, or else the one that was asked for.

        Raises:
            TierError: with the checks that fail.
        """
        self.verdict.raise_for_tier(tier)
        return self

    def to_urdf_path(self) -> str:
        """The URDF's path, for whoever takes a string."""
        return str(self.urdf.absolute())

    def to_usd(self) -> str:
        """The path of its USD file: ``asset.usdz``, else ``asset.usda``.

        Raises:
            RunError: where neither was written.
        """
        for name in ("asset.usdz", "asset.usda"):
            if (self.path / name).is_file():
                return str((self.path / name).absolute())
        raise RunError(f"{self.path}: there is no USD in it", hints=['make(…, export=["usd"]) writes it'])

    def to_mujoco(self) -> Any:
        """The asset as MuJoCo's ``MjModel``: from ``asset.xml`` where it was written, else from the URDF.

        Raises:
            MissingError: where mujoco is not installed.
        """
        try:
            mujoco: Any = importlib.import_module("mujoco")
        except ImportError:
            raise MissingError("to_mujoco needs mujoco", hints=["pip install mujoco"]) from None
        mjcf = self.path / "asset.xml"
        file = mjcf if mjcf.is_file() else self.urdf
        return mujoco.MjModel.from_xml_path(str(file.absolute()))

    def to_newton(self, builder: Any = None, **options: Any) -> Any:
        """Adds the asset to a ``ModelBuilder`` of Newton's, a new one without, and returns that.

        It is read from ``asset.xml`` where it was written, else from the URDF; ``options`` go to Newton's
        reader.

        >>> builder = asset.to_newton()  # doctest: +SKIP
        >>> model = builder.finalize()  # doctest: +SKIP

        Raises:
            MissingError: where newton is not installed.
        """
        if builder is None:
            try:
                newton: Any = importlib.import_module("newton")
            except ImportError:
                raise MissingError(
                    "to_newton needs newton", hints=["pip install 'newton[importers]'"]
                ) from None
            builder = newton.ModelBuilder()
        mjcf = self.path / "asset.xml"
        add, file = ("add_mjcf", mjcf) if mjcf.is_file() else ("add_urdf", self.urdf)
        reader = getattr(builder, add, None)
        if not callable(reader):
            kind = type(builder).__name__
            raise InputError(f"builder: expected one of Newton's, with {add}, found {kind}")
        reader(str(file.absolute()), **options)
        return builder

    def _json(self, name: str) -> dict[str, Any]:
        try:
            read: dict[str, Any] = json.loads((self.path / name).read_bytes())
        except (OSError, ValueError) as error:
            raise RunError(f"{self.path / name}: {error}") from error
        return read

    def _repr_html_(self) -> str:
        if not self.page.is_file():
            return self.verdict._repr_html_()
        return framed(self.page.read_text(encoding="utf-8"), f"asset {self.path.name}")

    def __fspath__(self) -> str:
        return str(self.path)

    def __repr__(self) -> str:
        return f"Asset({str(self.path)!r}, tier={self.tier!r})"
