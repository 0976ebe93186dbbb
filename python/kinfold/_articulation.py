"""From a mesh and a condition to parts and joints, in arrays."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, Union, overload

from . import _kinfold
from ._arrays import Mesh, Up, checked, taken, up_axis, whole_number
from ._condition import Condition, condition_text
from ._errors import InputError
from ._html import framed

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

Pose = Union[Mapping[str, float], Sequence[float], "NDArray[np.float64]"]


class Joint(NamedTuple):
    """A joint between a part and its parent, at rest.

    Attributes:
        name: the part's name; with ``.0`` and ``.1`` behind it where there are two.
        part: index of the part that moves.
        kind: ``"revolute"``, ``"continuous"`` or ``"prismatic"``.
        axis: unit direction, in the mesh's frame.
        pivot: a point on it, in the mesh's frame and unit.
        range: lower and upper end, radians or the mesh's unit; none for a continuous joint.
    """

    name: str
    part: int
    kind: str
    axis: tuple[float, float, float]
    pivot: tuple[float, float, float]
    range: tuple[float, float] | None


class Part(NamedTuple):
    """A rigid part.

    Attributes:
        name: its name in the condition.
        text: what it is, in words.
        parent: index of the part it hangs on; none for the base.
        joints: what ties it to its parent, the first nearest the parent; none where it is fixed.
        confidence: how likely its surface is the true one; none where nobody says.
    """

    name: str
    text: str
    parent: int | None
    joints: tuple[Joint, ...]
    confidence: float | None


class Note(NamedTuple):
    """A loss or a doubt about one part."""

    part: str
    message: str
    loss: bool


class Articulation:
    """Parts and joints of a mesh. Everything is in the frame and unit of the mesh that came."""

    def __init__(self, made: _kinfold.Articulated, up: Up, title: str) -> None:
        self._made, self._title = made, title
        self.up: Up = up
        told: dict[str, Any] = json.loads(made.described())
        sure: dict[str, Any] | None = told["confidence"]
        self.parts: tuple[Part, ...] = tuple(
            _part(index, part, sure) for index, part in enumerate(told["parts"])
        )
        self.joints: tuple[Joint, ...] = tuple(j for part in self.parts for j in part.joints)
        self.notes: tuple[Note, ...] = tuple(Note(**note) for note in told["notes"])
        self.confidence: float | None = None if sure is None else sure["object"]
        self.part_of_condition: tuple[int | None, ...] = tuple(told["part_of_condition"])

    @cached_property
    def labels(self) -> NDArray[np.uint16]:
        """The index of each face's part, shape (m,)."""
        import numpy as np

        return np.frombuffer(self._made.labels(), np.uint16)

    @cached_property
    def probabilities(self) -> NDArray[np.float32]:
        """How likely each face is of its part, shape (m,); 1 where it was painted."""
        import numpy as np

        return np.frombuffer(self._made.chances(), np.float32)

    @cached_property
    def _surface(self) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
        import numpy as np

        vertices, came, faces = self._made.surface()
        return (
            np.frombuffer(vertices, np.float64).reshape(-1, 3),
            np.frombuffer(came, np.int64),
            np.frombuffer(faces, np.int64).reshape(-1, 3),
        )

    @property
    def vertices(self) -> NDArray[np.float64]:
        """The surface at rest, each vertex of one part alone, shape (n, 3).

        A vertex that faces of several parts use is there once for each of them, and one that no face uses
        is not there; ``vertex_of`` says which vertex of the mesh that came each is.
        """
        return self._surface[0]

    @property
    def vertex_of(self) -> NDArray[np.int64]:
        """For each of ``vertices``, its index in the mesh that came."""
        return self._surface[1]

    @property
    def faces(self) -> NDArray[np.int64]:
        """The faces in their order, by indices into ``vertices``, shape (m, 3)."""
        return self._surface[2]

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the joints, in the order of a pose."""
        return tuple(joint.name for joint in self.joints)

    def pose(self, q: Pose = (), *, limits: bool = True) -> NDArray[np.float64]:
        """Where ``vertices`` are at joint values ``q``, shape (n, 3).

        Args:
            q: values by joint name, those left out at rest; or one for each of ``joints``. Radians, or
                the mesh's unit, counted from rest.
            limits: whether values outside a joint's range are refused.
        """
        import numpy as np

        return np.frombuffer(self._made.pose(self._values(q, limits)), np.float64).reshape(-1, 3)

    def transforms(self, q: Pose = (), *, limits: bool = True) -> NDArray[np.float64]:
        """How each part moves from rest at ``q``, shape (parts, 4, 4)."""
        import numpy as np

        moved = self._made.transforms(self._values(q, limits))
        return np.frombuffer(moved, np.float64).reshape(-1, 4, 4)

    def _values(self, q: Pose, limits: bool) -> list[list[float]]:
        if isinstance(q, Mapping):
            unknown = [name for name in q if name not in self.names]
            if unknown:
                known = ", ".join(f"`{name}`" for name in self.names) or "none"
                raise InputError(f"q: there is no joint `{unknown[0]}`; joints are {known}")
            values = [q.get(name, 0.0) for name in self.names]
        else:
            try:
                values = list(q) or [0.0] * len(self.joints)
            except TypeError:
                raise InputError(f"q: expected values of joints, found {q!r}") from None
            if len(values) != len(self.joints):
                raise InputError(f"q: expected {len(self.joints)} values, found {len(values)}")
        try:
            numbers = [float(value) for value in values]
        except (TypeError, ValueError) as error:
            raise InputError(f"q: expected numbers: {error}") from None
        for joint, value in zip(self.joints, numbers, strict=True):
            # A hair's breadth is what a slider's rounding costs.
            if (
                limits
                and joint.range is not None
                and not (joint.range[0] - 1e-9 <= value <= joint.range[1] + 1e-9)
            ):
                low, high = joint.range
                raise InputError(
                    f"q: `{joint.name}` goes from {low:.6g} to {high:.6g}, found {value:.6g}",
                    hints=["limits=False takes any value"],
                )
        by_part: list[list[float]] = [[] for _ in self.parts]
        for joint, value in zip(self.joints, numbers, strict=True):
            by_part[joint.part].append(value)
        return by_part

    def submesh(self, part: int | str) -> Mesh:
        """The surface of one part, at rest."""
        import numpy as np

        last = len(self.parts) - 1
        index = self._index(part) if isinstance(part, str) else whole_number("part", part, 0, last)
        faces = self.faces[self.labels == index]
        used, corners = np.unique(faces, return_inverse=True)
        return Mesh(self.vertices[used], corners.reshape(-1, 3).astype(np.int64), None, self.up)

    def _index(self, name: str) -> int:
        for index, part in enumerate(self.parts):
            if part.name == name:
                return index
        known = ", ".join(f"`{part.name}`" for part in self.parts)
        raise InputError(f"there is no part `{name}`; parts are {known}")

    def to_json(self) -> str:
        """The articulated object as a run leaves it, ``articulation.json``."""
        return self._made.artefact().decode("utf-8")

    def to_html(self) -> str:
        """A page of one file that shows it and moves its joints; it needs no network."""
        return self._made.page(self._title)

    def _repr_html_(self) -> str:
        return framed(self.to_html(), f"articulation of {self._title}")

    def __repr__(self) -> str:
        moving = ", ".join(f"{j.name}: {j.kind}" for j in self.joints)
        names = [part.name for part in self.parts]
        return f"Articulation({len(self.labels)} faces, parts={names}, joints={{{moving}}})"


def _part(index: int, part: dict[str, Any], sure: dict[str, Any] | None) -> Part:
    several = len(part["joints"]) > 1
    joints = tuple(
        Joint(
            f"{part['name']}.{number}" if several else part["name"],
            index,
            joint["kind"],
            tuple(joint["axis"]),
            tuple(joint["pivot"]),
            None if joint["range"] is None else tuple(joint["range"]),
        )
        for number, joint in enumerate(part["joints"])
    )
    labels = None if sure is None else sure["parts"][index]["labels"]
    return Part(part["name"], part["text"], part["parent"], joints, labels)


@overload
def articulate(
    mesh: ArrayLike,
    faces: ArrayLike,
    condition: Condition | Mapping[str, Any] | str,
    *,
    colors: ArrayLike | None = ...,
    up: Up | None = ...,
    snap: bool = ...,
    seed: int = ...,
) -> Articulation: ...
@overload
def articulate(
    mesh: object,
    *,
    condition: Condition | Mapping[str, Any] | str,
    colors: ArrayLike | None = ...,
    up: Up | None = ...,
    snap: bool = ...,
    seed: int = ...,
) -> Articulation: ...
def articulate(
    mesh: Any,
    faces: Any = None,
    condition: Any = None,
    *,
    colors: ArrayLike | None = None,
    up: Up | None = None,
    snap: bool = False,
    seed: int = 0,
) -> Articulation:
    """Labels every face with a part of the condition, and finds an axis and a range for every joint.

    It is what ``kinfold make`` does between mesh and asset, with the same result for the same mesh. The
    interpreter's lock is not held meanwhile.

    >>> made = kinfold.articulate(mesh.vertices, mesh.faces, condition)
    >>> made.names
    ('drawer', 'door')
    >>> made.pose({"door": 0.0}).shape == made.vertices.shape
    True

    Args:
        mesh: vertices, shape (n, 3), beside ``faces``; or a mesh that has both, as trimesh's, Open3D's and
            :class:`Mesh` do.
        faces: triangles, shape (m, 3).
        condition: a :class:`Condition`, its dictionary or JSON, or a file's path.
        colors: for each vertex RGB or RGBA, numbers from 0 to 255 or real numbers from 0 to 1.
        up: the up axis of the mesh and of the condition's points; what the condition says, else y.
        snap: whether points that lie off the mesh are moved onto it, instead of being refused.
        seed: of everything random.

    Raises:
        MeshError: what is no mesh.
        ConditionError: what is no condition, or does not fit the mesh.
        ArticulateError: where no parts and joints can be found.
    """
    if condition is None:
        raise InputError(
            "articulate: there is no condition",
            hints=["articulate(vertices, faces, condition), or articulate(mesh, condition=condition)"],
        )
    if isinstance(mesh, Mesh) and up is None:
        up = mesh.up
    text = condition_text(condition, up=up)
    document = json.loads(text)
    axis: Up = up_axis(up or document.get("up") or "y")
    arrays = checked(*taken(mesh, faces, colors))
    seed = whole_number("seed", seed, 0, 2**64 - 1)
    made = _kinfold.articulate(arrays[:2], arrays[2], text, (axis, bool(snap), seed))
    return Articulation(made, axis, document.get("category") or "object")
