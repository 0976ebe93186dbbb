"""Whatever is given, there is an answer or an error of ours, with words that say what was expected."""

from __future__ import annotations

import os
from functools import reduce
from pathlib import Path
from typing import Any

import kinfold
import numpy as np
import pytest
from conftest import box_on_box


def articulate(condition: Any) -> object:
    vertices, faces, _ = box_on_box()
    return kinfold.articulate(vertices, faces, condition)


def painted(faces: Any) -> object:
    vertices, corners, condition = box_on_box()
    return kinfold.articulate(vertices, corners, condition.paint("lid", faces, vertices, corners))


def endless() -> dict[str, Any]:
    document: dict[str, Any] = {}
    document["document"] = document
    return document


def deep() -> dict[str, Any]:
    return reduce(lambda inner, _: {"a": inner}, range(100_000), {})


CONDITIONS: list[tuple[Any, str]] = [
    ("", "found an empty text"),
    ("none.json", "none.json: No such file"),
    (b"none.json", "none.json: No such file"),
    ("a\0b", "expected a path"),
    ("/", "expected a regular file"),
    ("/dev/zero", "expected a regular file"),
    ("x" * 100_000, "xxx"),
    ('{"category": "\ud800"}', "UTF-8"),
    ("[" * 100_000, "[[["),
    (endless(), "Circular reference"),
    (deep(), "what JSON can hold"),
    ({"parts": {1, 2}}, "what JSON can hold"),
    ({"parts": float("nan")}, "what JSON can hold"),
]


@pytest.mark.parametrize(("condition", "told"), CONDITIONS, ids=range(len(CONDITIONS)))
def test_odd_conditions(condition: Any, told: str) -> None:
    with pytest.raises(kinfold.InputError) as error:
        articulate(condition)
    assert told in str(error.value) and len(str(error.value)) < 10_000


@pytest.mark.parametrize(
    ("fields", "told"),
    [
        ({"text": b"x"}, "text: cannot be b'x'"),
        ({"text": np.zeros(3)}, "text: cannot be array"),
        ({"text": object()}, "text: cannot be"),
        ({"rest": object()}, "rest: cannot be"),
        ({"range": 3}, "range: cannot be 3"),
        ({"range": [float("nan"), 1]}, "finite"),
        ({"effort": "strong"}, "effort: expected a number"),
        ({"axis": 3}, "axis: expected three numbers"),
        ({"points": 3}, "points: cannot be 3"),
        ({"joint": 3}, "joint: cannot be 3"),
        ({"joints": 3}, "joints"),
        ({"density": -1}, "density"),
        ({"text": "\ud800"}, "UTF-8"),
    ],
)
def test_odd_fields(fields: dict[str, Any], told: str) -> None:
    condition = kinfold.Condition().part("body").part("lid", parent="body", joint="revolute")
    before = condition.to_dict()
    with pytest.raises(kinfold.ConditionError) as error:
        condition.correct("lid", **fields).validate()
    assert told in str(error.value)
    # What is refused at once changes nothing.
    assert "cannot be" not in str(error.value) or condition.to_dict() == before


@pytest.mark.parametrize("size", [3, {"height": "tall"}, {1: 2.0}, {"height": float("inf")}, ["height"]])
def test_odd_sizes(size: Any) -> None:
    with pytest.raises(kinfold.InputError, match="size"):
        kinfold.Condition(size=size)


@pytest.mark.parametrize(
    "faces", [[2**40], [-1], [1.5], [float("nan")], None, 3, ["a"], "x y", "5-3", "0-4000000000"]
)
def test_odd_faces(faces: Any) -> None:
    with pytest.raises(kinfold.ConditionError):
        painted(faces)


@pytest.mark.parametrize("seed", [np.int64(3), np.uint8(3), 3])
def test_numbers_of_numpy_are_numbers(seed: Any) -> None:
    vertices, faces, condition = box_on_box()
    assert kinfold.articulate(vertices, faces, condition, seed=seed).parts


@pytest.mark.parametrize("q", [None, 3, "ab", {"lid": object()}, [[0.0]], np.zeros((2, 2))])
def test_odd_poses(q: Any) -> None:
    made = articulate(box_on_box()[2])
    assert isinstance(made, kinfold.Articulation)
    with pytest.raises(kinfold.InputError, match="q: "):
        made.pose(q)


@pytest.mark.parametrize("part", [None, 1.5, -1, 2, "no", True])
def test_odd_parts(part: Any) -> None:
    made = articulate(box_on_box()[2])
    assert isinstance(made, kinfold.Articulation)
    with pytest.raises(kinfold.InputError, match="part"):
        made.submesh(part)


PATHS: list[Any] = [None, 3, 1.5, "", "a\0b", object(), ["a"]]


@pytest.mark.parametrize("path", PATHS, ids=range(len(PATHS)))
@pytest.mark.parametrize(
    "call",
    [
        kinfold.check,
        kinfold.forecast,
        kinfold.read_mesh,
        kinfold.Asset,
        kinfold.Trace,
        kinfold.Condition.from_file,
        lambda path: kinfold.check_all([path]),
        lambda path: (
            kinfold.make(path, mesh="m.glb", condition="c.json", out="out")
            if path is not None
            else kinfold.make()
        ),
        lambda path: kinfold.make(mesh=path if path is not None else 3, condition="c.json", out="out"),
        lambda path: kinfold.make(mesh="m.glb", condition="c.json", out=path if path is not None else 3),
        lambda path: kinfold.make(mesh="m.glb", condition="c.json", state=path if path is not None else 3),
    ],
)
def test_odd_paths(call: Any, path: Any) -> None:
    with pytest.raises(kinfold.InputError):
        call(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
@pytest.mark.parametrize("path", ["/dev/zero", "pipe"])
def test_pipes_and_devices_are_not_waited_for(path: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert kinfold.check(path, deadline=20).tier == "none"
    for call in (kinfold.forecast, kinfold.read_mesh, kinfold.Condition.from_file, articulate):
        with pytest.raises(kinfold.InputError):
            call(path)  # type: ignore[operator]
    with pytest.raises(kinfold.KinfoldError):
        _ = kinfold.Trace(path).stages
    with pytest.raises(kinfold.KinfoldError):
        kinfold.make(path, mesh=box_on_box()[:2], condition=box_on_box()[2], out="out")


@pytest.mark.parametrize(
    "call",
    [
        lambda f: kinfold.check(f, waive=["C1"]),
        lambda f: kinfold.check(f, waive={1: "x"}),
        lambda f: kinfold.check(f, packages=3),
        lambda f: kinfold.check(f, packages={"p": 3}),
        lambda f: kinfold.check(f, tier=["dynamic"]),
        lambda f: kinfold.check(f, seed=1.5),
        lambda f: kinfold.check_all(None),
        lambda f: kinfold.check_all(3),
        lambda f: kinfold.check_all([f, f], jobs=0),
        lambda f: kinfold.forecast(f, [1]),
        lambda f: kinfold.forecast(f, 3),
        lambda f: kinfold.forecast(f, ""),
        lambda f: kinfold.make(mesh="m", condition="c", export=3),
        lambda f: kinfold.make(mesh="m", condition="c", export=[3]),
        lambda f: kinfold.make(mesh="m", condition="c", policy=3),
    ],
)
def test_odd_words(call: Any, tmp_path: Path) -> None:
    (tmp_path / "m.urdf").write_text("<robot name='m'><link name='a'/></robot>")
    with pytest.raises(kinfold.InputError) as error:
        call(tmp_path / "m.urdf")
    assert "For more information" not in str(error.value)


def test_more_than_a_mesh_may_have_is_refused_before_it_is_copied() -> None:
    vertices, faces, condition = box_on_box()
    many = 10**11
    for given in [
        (np.broadcast_to(np.float64(0), (many, 3)), faces),
        (vertices, np.broadcast_to(np.int64(0), (many, 3))),
    ]:
        with pytest.raises(kinfold.MeshError, match="at most"):
            kinfold.articulate(*given, condition)
    with pytest.raises(kinfold.MeshError, match="colors: expected shape"):
        kinfold.articulate(vertices, faces, condition, colors=np.broadcast_to(np.uint8(0), (many, 3)))


def test_what_was_given_in_memory_is_called_by_what_it_is(tmp_path: Path) -> None:
    vertices, faces, condition = box_on_box()
    condition.correct("lid", mass=-1)
    with pytest.raises(kinfold.KinfoldError) as error:
        kinfold.make(mesh=(vertices, faces), condition=condition, out=tmp_path / "out")
    assert "the condition: line" in str(error.value) and "kinfold-" not in str(error.value).replace(
        "kinfold-condition", ""
    )
