"""Meshes as arrays: whatever has vertices and faces, made into what the module reads."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol, Union, cast, runtime_checkable

from . import _kinfold
from ._errors import InputError, MeshError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

Up = Literal["y", "z"]
PathLike = Union[str, "os.PathLike[str]"]


@runtime_checkable
class TrimeshLike(Protocol):
    """What trimesh's meshes have: ``vertices`` and ``faces``."""

    @property
    def vertices(self) -> Any: ...
    @property
    def faces(self) -> Any: ...


@runtime_checkable
class Open3DLike(Protocol):
    """What Open3D's meshes have: ``vertices`` and ``triangles``."""

    @property
    def vertices(self) -> Any: ...
    @property
    def triangles(self) -> Any: ...


class Mesh(NamedTuple):
    """A triangle mesh in its file's own frame and unit.

    Attributes:
        vertices: float64, shape (n, 3).
        faces: int64, shape (m, 3), counter-clockwise seen from outside.
        colors: RGBA of each vertex, uint8, shape (n, 4); or none.
        up: the up axis, ``"y"`` or ``"z"``.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    colors: NDArray[np.uint8] | None = None
    up: Up = "y"

    def to_glb(self) -> bytes:
        """The mesh as a GLB file."""
        return _kinfold.write_glb(*checked(self.vertices, self.faces, self.colors), self.up)


def read_mesh(path: PathLike, *, up: Up = "y") -> Mesh:
    """Reads a mesh file: GLB, glTF, OBJ, STL, PLY or USD, with what lies beside it.

    ``up`` is the file's up axis. What is returned has y up: it is set upright as ``kinfold make`` does.
    """
    import numpy as np

    vertices, faces, colors, found = _kinfold.read_mesh(path_text("path", path), up)
    return Mesh(
        np.frombuffer(vertices, np.float64).reshape(-1, 3),
        np.frombuffer(faces, np.int64).reshape(-1, 3),
        None if colors is None else np.frombuffer(colors, np.uint8).reshape(-1, 4),
        cast(Up, found),
    )


def taken(mesh: object, faces: object, colors: object) -> tuple[Any, Any, Any]:
    """Vertices, faces and colours of whatever was given."""
    if faces is not None:
        return mesh, faces, colors
    if isinstance(mesh, Mesh):
        return mesh.vertices, mesh.faces, mesh.colors if colors is None else colors
    if isinstance(mesh, TrimeshLike):
        return mesh.vertices, mesh.faces, _colors_of(mesh) if colors is None else colors
    if isinstance(mesh, Open3DLike):
        return mesh.vertices, mesh.triangles, _open3d_colors(mesh) if colors is None else colors
    geometry = getattr(mesh, "geometry", None)
    if isinstance(geometry, dict):
        hint = "a trimesh Scene holds several meshes: give `scene.to_mesh()`"
        raise MeshError(f"mesh: expected one mesh, found a {_kind(mesh)}", hints=[hint])
    raise MeshError(
        f"mesh: expected vertices and faces, or a mesh that has both, found {_kind(mesh)}",
        hints=["give two arrays, a trimesh or Open3D mesh, or `kinfold.read_mesh(path)`"],
    )


def as_file(mesh: Any) -> bytes:
    """A mesh in memory as a file that has its own coordinates: trimesh's own GLB, which has its materials,
    else one of vertices, faces and colours."""
    export = getattr(mesh, "export", None)
    if export is not None and not isinstance(mesh, (Mesh, tuple)):
        exported = export(file_type="glb")
        if not isinstance(exported, bytes):
            raise MeshError(f'mesh: expected export(file_type="glb") to give bytes, found {_kind(exported)}')
        return exported
    if isinstance(mesh, tuple) and not isinstance(mesh, Mesh):
        if len(mesh) not in (2, 3):
            raise MeshError(
                f"mesh: expected vertices and faces, and colours if there are any, found {len(mesh)} things"
            )
        arrays = checked(mesh[0], mesh[1], mesh[2] if len(mesh) == 3 else None)
    else:
        arrays = checked(*taken(mesh, None, None))
    return _kinfold.write_glb(*arrays, "y")


def _colors_of(mesh: TrimeshLike) -> Any:
    """Colours that a trimesh mesh was given for its vertices; those that it would make up are none."""
    visual = getattr(mesh, "visual", None)
    if getattr(visual, "kind", None) != "vertex" or not getattr(visual, "defined", True):
        return None
    return getattr(visual, "vertex_colors", None)


def _open3d_colors(mesh: Open3DLike) -> Any:
    has = getattr(mesh, "has_vertex_colors", None)
    return getattr(mesh, "vertex_colors", None) if has is not None and has() else None


def checked(
    vertices: ArrayLike, faces: ArrayLike, colors: ArrayLike | None
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.uint8] | None]:
    """The same as arrays of the types and shapes that a mesh has; copies are made where they must be."""
    import numpy as np

    points = _rows("vertices", vertices, 3)
    _no_more("vertices", points, _kinfold.MAX_VERTICES)
    if points.dtype.kind not in "fiu":
        raise MeshError(f"vertices: expected real numbers, found dtype {points.dtype}")
    corners = _rows("faces", faces, 3, "triangles; cut larger faces into triangles first")
    _no_more("faces", corners, _kinfold.MAX_FACES)
    if corners.dtype.kind not in "iu":
        raise MeshError(
            f"faces: expected whole numbers, found dtype {corners.dtype}",
            hints=["faces.astype(numpy.int64), if they count vertices"],
        )
    if corners.dtype.kind == "u" and corners.size and int(corners.max()) > np.iinfo(np.int64).max:
        raise MeshError(f"faces: found vertex {int(corners.max())}, but there are {len(points)}")
    shades = None if colors is None else _shades(colors, len(points))
    return (
        np.ascontiguousarray(points, np.float64),
        np.ascontiguousarray(corners, np.int64),
        shades,
    )


def _no_more(what: str, array: NDArray[Any], most: int) -> None:
    """Refuses more than a mesh may have before anything is copied."""
    if len(array) > most:
        raise MeshError(f"{what}: a mesh may have at most {most}, found {len(array)}")


def _rows(what: str, value: ArrayLike, width: int, hint: str | None = None) -> NDArray[Any]:
    import numpy as np

    try:
        array = np.asarray(value)
    except (ValueError, TypeError) as error:
        raise MeshError(f"{what}: expected an array of shape (n, {width}): {error}") from error
    if array.ndim != 2 or array.shape[1] != width:
        found = array.shape if array.ndim else _kind(value)
        hints = [hint] if hint and array.ndim == 2 else []
        raise MeshError(f"{what}: expected shape (n, {width}), found {found}", hints=hints)
    return array


def _shades(colors: ArrayLike, count: int) -> NDArray[np.uint8]:
    import numpy as np

    array = np.asarray(colors)
    if array.ndim != 2 or array.shape not in [(count, 3), (count, 4)]:
        found = array.shape if array.ndim else _kind(colors)
        raise MeshError(f"colors: expected shape ({count}, 3) or ({count}, 4), found {found}")
    if array.dtype.kind == "f":
        if not (np.isfinite(array).all() and array.min(initial=0.0) >= 0 and array.max(initial=0.0) <= 1):
            raise MeshError(
                "colors: expected real numbers from 0 to 1, found others",
                hints=["whole numbers from 0 to 255 go as numpy.uint8"],
            )
        array = np.rint(array * 255)
    elif array.dtype.kind in "iu":
        if array.size and (int(array.min()) < 0 or int(array.max()) > 255):
            raise MeshError("colors: expected whole numbers from 0 to 255, found others")
    else:
        raise MeshError(f"colors: expected numbers, found dtype {array.dtype}")
    whole = np.full((count, 4), 255, np.uint8)
    whole[:, : array.shape[1]] = array
    return whole


def path_text(what: str, path: object) -> str:
    """A path as text, or why it is none."""
    if isinstance(path, (str, bytes, os.PathLike)):
        text = os.fsdecode(path)
        if text and "\0" not in text:
            return text
        raise InputError(f"{what}: expected a path, found {text!r}")
    raise InputError(f"{what}: expected a path, found {_kind(path)}")


def whole_number(what: str, number: object, least: int, most: int) -> int:
    """A whole number within bounds, or why it is none."""
    try:
        if not isinstance(number, bool) and least <= (whole := operator.index(number)) <= most:  # type: ignore[call-overload]
            return whole
    except TypeError:
        pass
    raise InputError(f"{what}: expected a whole number from {least} to {most}, found {number!r}")


def names_of(what: str, names: object) -> list[str]:
    """Some names, given as one text or as several, or why they are none."""
    if isinstance(names, str):
        return [names]
    if isinstance(names, Iterable):
        listed: list[Any] = list(names)
        if all(isinstance(name, str) for name in listed):
            return listed
    raise InputError(f"{what}: expected a text or a list of texts, found {names!r}")


def pairs_of(what: str, pairs: object) -> list[tuple[str, Any]]:
    """The items of a mapping from texts, or why there are none."""
    if pairs is None:
        return []
    if isinstance(pairs, Mapping):
        listed: list[Any] = list(pairs.items())
        if all(isinstance(name, str) for name, _ in listed):
            return listed
    raise InputError(f"{what}: expected a dictionary whose keys are texts, found {pairs!r}")


def up_axis(up: object) -> Up:
    """An up axis, or why it is none."""
    if up in ("y", "z"):
        return cast(Up, up)
    raise InputError(f'up: expected "y" or "z", found {up!r}')


def _kind(value: object) -> str:
    return type(value).__name__
