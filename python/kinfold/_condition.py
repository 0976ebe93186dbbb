"""Conditions: what the parts of an object are, how they hang together, and what a person corrects."""

from __future__ import annotations

import copy
import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from . import _kinfold
from ._arrays import (
    Mesh,
    PathLike,
    Up,
    checked,
    pairs_of,
    path_text,
    taken,
    up_axis,
    whole_number,
)
from ._errors import ConditionError, InputError

if TYPE_CHECKING:
    from typing import Self

Joint = Literal["revolute", "continuous", "prismatic", "fixed"]
Point = Sequence[float]

SCHEMA = "kinfold-condition/2"
#: The largest number that a face may have in a condition file, whatever the mesh.
_LAST_FACE = 2**32 - 2


class Condition:
    """What is asked for: parts, their tree, joints, points and corrections (``kinfold-condition/2``).

    >>> import kinfold
    >>> kettle = kinfold.Condition("kettle", size={"height": 0.24})
    >>> kettle = kettle.part("body", material="stainless steel").part(
    ...     "lid", parent="body", joint="revolute", point=[-0.098, 0.472, 0.003])
    >>> kettle.names
    ('body', 'lid')
    >>> kettle.correct("lid", range=[0, "80°"]).validate() == kettle
    True

    Points, axes and pivots are in the mesh file's own coordinates. Every method that changes the
    condition returns it, so calls may be chained.
    """

    __slots__ = ("_document",)
    _document: dict[str, Any]

    def __init__(
        self,
        category: str = "",
        *,
        size: Mapping[str, float] | None = None,
        up: Up | None = None,
        notes: str = "",
    ) -> None:
        document: dict[str, Any] = {"schema": SCHEMA, "category": category}
        if up is not None:
            document["up"] = up_axis(up)
        if size is not None:
            document["size"] = {key: _number(f"size: {key}", value) for key, value in pairs_of("size", size)}
        if notes:
            document["notes"] = notes
        document["parts"] = []
        self._document = document

    @classmethod
    def from_json(cls, text: str | bytes, *, up: Up = "y") -> Self:
        """Reads a condition as it stands in a file; ``up`` is that of one that does not say.

        >>> kinfold.Condition.from_json('{"parts": []}')
        Traceback (most recent call last):
        ...
        kinfold._errors.ConditionError: ...

        Raises:
            ConditionError: with everything that is wrong with it, each with its line.
        """
        made = cls.__new__(cls)
        made._document = json.loads(_kinfold.condition(_utf8(text), up_axis(up)))
        return made

    @classmethod
    def from_dict(cls, document: Mapping[str, Any], *, up: Up = "y") -> Self:
        """The same from what ``json.load`` gives."""
        return cls.from_json(_dumped(document), up=up)

    @classmethod
    def from_file(cls, path: PathLike, *, up: Up = "y") -> Self:
        """The same from a file."""
        made = cls.__new__(cls)
        made._document = json.loads(_kinfold.condition_file(path_text("path", path), up_axis(up)))
        return made

    def part(
        self,
        name: str,
        *,
        parent: str | None = None,
        joint: Joint | Sequence[Joint] | None = None,
        text: str | None = None,
        point: Point | None = None,
        points: Iterable[Point] = (),
        material: str | None = None,
        density: float | None = None,
        mass: float | None = None,
        friction: float | None = None,
        **corrections: Any,
    ) -> Self:
        """Adds a part. The one without a parent is the base.

        Args:
            name: its link's name, ``[A-Za-z_][A-Za-z0-9_]*``.
            parent: the part it hangs on.
            joint: how it moves: a kind, or two of them, the first nearest the parent; fixed without.
            text: what it is, in words; the name where it is left out.
            point: any point on its surface.
            points: further points on it.
            material: in words, like ``"oak"``.
            density: kg/m³.
            mass: kg; wins over density.
            friction: coefficient of its surface.
            corrections: as :meth:`correct` takes them.
        """
        if self._find(name) is not None:
            raise ConditionError(
                f"part `{name}` is there already", hints=[f"change it with correct({name!r}, …)"]
            )
        part: dict[str, Any] = {"name": name}
        self._document["parts"].append(part)
        try:
            return self.correct(
                name,
                parent=parent,
                joint=joint,
                text=text,
                point=point,
                points=points,
                material=material,
                density=density,
                mass=mass,
                friction=friction,
                **corrections,
            )
        except BaseException:
            self._document["parts"].remove(part)
            raise

    def correct(self, name: str, **fields: Any) -> Self:
        """Says more of a part, or something else; what is ``None`` stays as it was.

        Fields are those of a part in a condition file: ``text``, ``parent``, ``joint``, ``joints``,
        ``point``, ``points``, ``not_``, ``faces``, ``axis``, ``pivot``, ``range``, ``rest``, ``effort``,
        ``damping``, ``material``, ``density``, ``mass``, ``friction``. What is given is kept exactly, and
        ``asset.json`` names its origin ``user``.
        """
        part = self._part(name)
        told = {key: value for key, value in fields.items() if value is not None}
        unknown = sorted(set(told) - set(_FIELDS))
        if unknown:
            known = ", ".join(_FIELDS)
            raise ConditionError(f"part `{name}`: no field `{unknown[0]}`; there are {known}")
        plain: dict[str, Any] = {}
        for key, value in told.items():
            what = f"part `{name}`: {key}"
            try:
                plain[_FIELDS[key]] = _PLAIN.get(key, _same)(what, value)
                json.dumps(plain[_FIELDS[key]], allow_nan=False)
            except ConditionError:
                raise
            except (TypeError, ValueError, RecursionError) as error:
                raise ConditionError(f"{what}: cannot be {_short(value)}: {error}") from None
        part.update({key: value for key, value in plain.items() if value != []})
        return self

    def add_point(self, name: str, *points: Point) -> Self:
        """Says points that are on a part."""
        part = self._part(name)
        new = _triples(f"part `{name}`: point", points)
        if new and "point" not in part:
            part["point"], new = new[0], new[1:]
        if new:
            part["points"] = [*part.get("points", []), *new]
        return self

    def exclude(self, name: str, *points: Point) -> Self:
        """Says points that are not on a part; each goes to the likeliest other one."""
        part = self._part(name)
        part["not"] = [*part.get("not", []), *_triples(f"part `{name}`: not", points)]
        return self

    def paint(self, name: str, faces: str | Iterable[int], mesh: object, mesh_faces: object = None) -> Self:
        """Says faces of a mesh that are of a part whatever else is found.

        ``faces`` are numbers from 0, or text such as ``"0-119 340"``; ``mesh`` is the mesh that they are
        counted in, or its vertices with ``mesh_faces``.
        """
        part = self._part(name)
        up: Up = mesh.up if isinstance(mesh, Mesh) else self._document.get("up", "y")
        vertices, corners, _ = checked(*taken(mesh, mesh_faces, None)[:2], None)
        runs = _runs(f"part `{name}`: faces", faces)
        self._document["mesh"] = _kinfold.mesh_digest(vertices, corners, up)
        part["faces"] = runs
        return self

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the parts, in order."""
        return tuple(part["name"] for part in self._document["parts"])

    @property
    def category(self) -> str:
        """What the object is, in a word or two."""
        return str(self._document.get("category", ""))

    def validate(self) -> Self:
        """Proves that it is a condition.

        Raises:
            ConditionError: with everything that is wrong with it.
        """
        _kinfold.condition(_utf8(self.to_json()), "y")
        return self

    def to_dict(self) -> dict[str, Any]:
        """The condition as it stands in a file; a copy."""
        return copy.deepcopy(self._document)

    def to_json(self, *, indent: int | None = 2) -> str:
        """The same as text."""
        return json.dumps(self._document, indent=indent, ensure_ascii=False, allow_nan=False)

    def save(self, path: PathLike) -> None:
        """Proves it and writes it into a file."""
        text = self.validate().to_json() + "\n"
        Path(path_text("path", path)).write_text(text, encoding="utf-8")

    def _find(self, name: str) -> dict[str, Any] | None:
        return next((part for part in self._document["parts"] if part["name"] == name), None)

    def _part(self, name: str) -> dict[str, Any]:
        part = self._find(name)
        if part is None:
            known = ", ".join(f"`{one}`" for one in self.names) or "none yet"
            raise ConditionError(f"there is no part `{name}`; parts are {known}")
        return part

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Condition) and self._document == other._document

    __hash__ = None  # type: ignore[assignment]

    def __copy__(self) -> Self:
        return self.__deepcopy__({})

    def __deepcopy__(self, _memo: dict[int, Any]) -> Self:
        made = type(self).__new__(type(self))
        made._document = copy.deepcopy(self._document)
        return made

    def __getstate__(self) -> dict[str, Any]:
        return self._document

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._document = state

    def __repr__(self) -> str:
        return f"Condition({self.category!r}, parts={list(self.names)})"


_FIELDS = {
    "text": "text",
    "parent": "parent",
    "joint": "joint",
    "joints": "joints",
    "point": "point",
    "points": "points",
    "not_": "not",
    "faces": "faces",
    "axis": "axis",
    "pivot": "pivot",
    "range": "range",
    "rest": "rest",
    "effort": "effort",
    "damping": "damping",
    "material": "material",
    "density": "density",
    "mass": "mass",
    "friction": "friction",
}


def _short(value: object) -> str:
    """A value as a message has it: its beginning, where it is long."""
    told = repr(value)
    return told if len(told) <= 80 else told[:80] + "…"


def _utf8(text: object) -> str:
    """A text that the module can read, or why it is none."""
    try:
        if isinstance(text, (bytes, bytearray)):
            return bytes(text).decode("utf-8")
        if isinstance(text, str):
            text.encode("utf-8")
            return text
    except UnicodeError as error:
        raise ConditionError(f"expected JSON in UTF-8: {error}") from None
    raise ConditionError(f"expected JSON as text or bytes, found {type(text).__name__}")


def _dumped(document: object) -> str:
    try:
        return json.dumps(document, allow_nan=False)
    except (TypeError, ValueError, RecursionError) as error:
        raise ConditionError(f"expected what JSON can hold: {error}") from None


def _same(what: str, value: Any) -> Any:
    item = getattr(value, "item", None)
    return item() if item is not None and getattr(value, "ndim", 1) == 0 else value


def _number(what: str, value: Any) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise ConditionError(f"{what}: expected a number, found {value!r}") from None
    if number != number or number in (float("inf"), float("-inf")):
        raise ConditionError(f"{what}: expected a number that is finite, found {number}")
    return number


def _triple(what: str, value: Any) -> list[float]:
    try:
        numbers = list(value)
    except TypeError:
        numbers = []
    if len(numbers) != 3:
        raise ConditionError(f"{what}: expected three numbers, found {value!r}")
    return [_number(what, one) for one in numbers]


def _triples(what: str, value: Any) -> list[list[float]]:
    return [_triple(what, one) for one in value]


def _runs(what: str, faces: object) -> str:
    if isinstance(faces, str):
        return faces
    if not isinstance(faces, Iterable):
        raise ConditionError(f"{what}: expected numbers of faces, found {type(faces).__name__}")
    numbers: list[int] = []
    for face in faces:
        try:
            numbers.append(whole_number(what, face, 0, _LAST_FACE))
        except InputError as error:
            raise ConditionError(error.message) from None
    numbers = sorted(set(numbers))
    runs: list[list[int]] = []
    for number in numbers:
        if runs and runs[-1][1] + 1 == number:
            runs[-1][1] = number
        else:
            runs.append([number, number])
    return " ".join(str(a) if a == b else f"{a}-{b}" for a, b in runs)


def _joint(what: str, value: Any) -> Any:
    return value if isinstance(value, str) else list(value)


def _quantities(what: str, value: Any) -> list[Any]:
    return [one if isinstance(one, str) else _number(what, one) for one in value]


_PLAIN: dict[str, Any] = {
    "joint": _joint,
    "point": _triple,
    "points": _triples,
    "not_": _triples,
    "faces": _runs,
    "axis": _triple,
    "pivot": _triple,
    "range": _quantities,
    "effort": _number,
    "damping": _number,
    "density": _number,
    "mass": _number,
    "friction": _number,
}


def condition_schema() -> dict[str, Any]:
    """The JSON Schema of a condition file."""
    schema: dict[str, Any] = json.loads(_kinfold.condition_schema())
    return schema


def condition_text(condition: object, *, up: Up | None = None) -> str:
    """A condition as text, whatever it was given as: a condition, its dictionary, its JSON, or its file."""
    if isinstance(condition, Condition):
        return condition.to_json()
    if isinstance(condition, Mapping):
        return Condition.from_dict(condition, up=up or "y").to_json()
    if isinstance(condition, (str, bytes)) and condition[:4096].lstrip()[:1] in ("{", b"{"):
        return Condition.from_json(condition, up=up or "y").to_json()
    if isinstance(condition, str) and not condition.strip():
        raise ConditionError("condition: expected a condition or a file's path, found an empty text")
    if isinstance(condition, (str, bytes, os.PathLike)):
        return Condition.from_file(os.fsdecode(condition), up=up or "y").to_json()
    raise ConditionError(
        f"condition: expected a kinfold.Condition, its dictionary or JSON, or a file's path, found "
        f"{type(condition).__name__}",
        hints=['kinfold.Condition("kettle").part("body").part("lid", parent="body", joint="revolute")'],
    )
