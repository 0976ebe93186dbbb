"""Conditions: built, read, corrected, written."""

from __future__ import annotations

import copy
import json
import pickle
from pathlib import Path

import kinfold
import numpy as np
import pytest
from conftest import EXAMPLES, NAMES, cube
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from kinfold._condition import condition_text

quick = settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))


def kettle() -> kinfold.Condition:
    return (
        kinfold.Condition("kettle", size={"height": 0.24})
        .part("body", material="steel", point=[0.195, -0.046, 0.069])
        .part("lid", parent="body", joint="revolute", point=[-0.098, 0.472, 0.003])
    )


@pytest.mark.parametrize("name", NAMES)
def test_a_file_is_read_and_says_the_same_again(name: str) -> None:
    path = EXAMPLES / name / "condition.json"
    read = kinfold.Condition.from_file(path)
    assert kinfold.Condition.from_json(read.to_json()) == read
    assert list(read.names) == [part["name"] for part in json.loads(path.read_text())["parts"]]


def test_what_is_built_is_what_is_read() -> None:
    built = kettle()
    read = kinfold.Condition.from_json(built.to_json())
    assert read.names == built.names == ("body", "lid") and read.category == "kettle"
    assert built.validate() is built


def test_comments_and_marks_of_order_are_read() -> None:
    text = '\ufeff{ // mine\n "schema": "kinfold-condition/2", "parts": [{"name": "body"},], }'
    assert kinfold.Condition.from_json(text).names == ("body",)
    assert kinfold.Condition.from_json(text.encode()).names == ("body",)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "the file is empty"),
        ("[]", ""),
        ("{", ""),
        ('{"schema": "kinfold-condition/2", "parts": []}', ""),
        ('{"schema": "kinfold-condition/2", "parts": [{"name": "a b"}]}', "a b"),
        ('{"schema": "kinfold-condition/2", "parts": [{"name": "a", "joint": "revolut"}]}', "revolute"),
        ('{"schema": "kinfold-condition/9", "parts": [{"name": "a"}]}', "kinfold-condition"),
    ],
)
def test_what_is_no_condition_is_refused(text: str, told: str) -> None:
    with pytest.raises(kinfold.ConditionError) as error:
        kinfold.Condition.from_json(text)
    assert told in str(error.value) and error.value.hints


def test_all_faults_are_told_at_once_with_their_lines() -> None:
    text = """{ "schema": "kinfold-condition/2", "parts": [
        { "name": "body" },
        { "name": "lid", "parent": "boddy", "joint": "revolute" },
        { "name": "lid", "parent": "body", "mass": -1 }
    ] }"""
    with pytest.raises(kinfold.ConditionError) as error:
        kinfold.Condition.from_json(text)
    assert any(cause.startswith("line 3") for cause in error.value.causes), error.value
    assert len(error.value.causes) >= 2


@pytest.mark.parametrize("odd", [None, 3, [], object()])
def test_what_is_no_text_is_refused(odd: object) -> None:
    with pytest.raises(kinfold.ConditionError, match="expected JSON as text or bytes"):
        kinfold.Condition.from_json(odd)  # type: ignore[arg-type]
    with pytest.raises(kinfold.ConditionError):
        condition_text(odd)


def test_bytes_that_are_no_text_are_refused() -> None:
    with pytest.raises(kinfold.ConditionError, match="UTF-8"):
        kinfold.Condition.from_json(b"\xff\xfe")


def test_corrections_stand_in_the_file_as_they_were_given() -> None:
    told = kettle().correct(
        "lid", range=[0, "80°"], axis=np.array([1, 0, 0]), pivot=(0, 0.4, 0), rest=0.2, effort=np.float32(2)
    )
    lid = told.validate().to_dict()["parts"][1]
    assert lid["range"] == [0.0, "80°"] and lid["axis"] == [1.0, 0.0, 0.0] and lid["effort"] == 2.0


def test_points_are_added_and_excluded() -> None:
    told = (
        kettle().part("knob", parent="lid").add_point("knob", [0, 1, 0], [0, 1, 1]).exclude("lid", [0, 1, 0])
    )
    body, lid, knob = told.to_dict()["parts"]
    assert knob["point"] == [0, 1, 0] and knob["points"] == [[0, 1, 1]] and lid["not"] == [[0, 1, 0]]
    assert "points" not in body


def test_faces_are_painted_in_the_mesh_they_count_in() -> None:
    vertices, faces = cube()
    told = (
        kinfold.Condition()
        .part("body")
        .part("lid", parent="body")
        .paint("lid", [2, 0, 1, 7], vertices, faces)
    )
    document = told.validate().to_dict()
    assert document["parts"][1]["faces"] == "0-2 7" and len(document["mesh"]) == 64


@pytest.mark.parametrize("odd", [[1.5], [-1], [True], ["a"]])
def test_faces_that_are_no_numbers_are_refused(odd: list[object]) -> None:
    told = kinfold.Condition().part("body")
    with pytest.raises((kinfold.ConditionError, ValueError)):
        told.paint("body", odd, *cube())  # type: ignore[arg-type]


def test_a_part_that_is_there_already_is_refused_and_one_that_is_not() -> None:
    with pytest.raises(kinfold.ConditionError, match="part `lid` is there already"):
        kettle().part("lid")
    with pytest.raises(kinfold.ConditionError, match="no part `ldi`; parts are `body`, `lid`"):
        kettle().correct("ldi", mass=1)
    with pytest.raises(kinfold.ConditionError, match="no field `weight`; there are text"):
        kettle().correct("lid", weight=1)


def test_a_part_that_is_refused_is_not_left_behind() -> None:
    told = kettle()
    with pytest.raises(kinfold.ConditionError, match="point: expected three numbers"):
        told.part("knob", point=[0, 1])
    assert told == kettle()


@pytest.mark.parametrize("odd", [[1, 2], [1, 2, "x"], [1, 2, float("nan")], 7, [[1, 2, 3]]])
def test_points_that_are_none_are_refused(odd: object) -> None:
    with pytest.raises(kinfold.ConditionError, match="`lid`"):
        kettle().add_point("lid", odd)  # type: ignore[arg-type]


def test_a_condition_is_copied_pickled_and_compared() -> None:
    one = kettle()
    for other in (copy.copy(one), copy.deepcopy(one), pickle.loads(pickle.dumps(one))):
        assert other == one
        other.part("knob", parent="lid")
        assert other != one and one.names == ("body", "lid")
    with pytest.raises(TypeError):
        hash(one)
    one.to_dict()["parts"].clear()
    assert one.names == ("body", "lid")


def test_a_condition_is_saved_only_if_it_is_one(tmp_path: Path) -> None:
    with pytest.raises(kinfold.ConditionError):
        kinfold.Condition().save(tmp_path / "a.json")
    assert not (tmp_path / "a.json").exists()
    kettle().save(tmp_path / "a.json")
    assert kinfold.Condition.from_file(tmp_path / "a.json").names == ("body", "lid")


def test_a_condition_may_be_given_in_any_form(tmp_path: Path) -> None:
    kettle().save(tmp_path / "a.json")
    forms = [
        kettle(),
        kettle().to_dict(),
        kettle().to_json(),
        kettle().to_json().encode(),
        tmp_path / "a.json",
        str(tmp_path / "a.json"),
    ]
    names = {tuple(p["name"] for p in json.loads(condition_text(form))["parts"]) for form in forms}
    assert names == {("body", "lid")}


def test_the_schema_is_that_of_the_command_line() -> None:
    assert kinfold.condition_schema()["title"] == "kinfold condition"


@quick
@given(st.text())
def test_any_text_is_a_condition_or_an_error_of_ours(text: str) -> None:
    try:
        kinfold.Condition.from_json(text)
    except kinfold.ConditionError:
        pass


json_like = st.recursive(
    st.one_of(
        st.none(), st.booleans(), st.integers(), st.floats(allow_nan=False, allow_infinity=False), st.text()
    ),
    lambda inner: st.one_of(st.lists(inner), st.dictionaries(st.text(), inner)),
    max_leaves=10,
)
fields = st.sampled_from(
    ["schema", "parts", "name", "parent", "joint", "point", "axis", "range", "size", "up", "faces"]
)


@quick
@given(st.dictionaries(fields, json_like), st.lists(st.dictionaries(fields, json_like), max_size=3))
def test_any_document_is_a_condition_or_an_error_of_ours(document: dict, parts: list) -> None:
    try:
        kinfold.Condition.from_dict({**document, "parts": parts})
    except kinfold.ConditionError:
        pass


@quick
@given(st.lists(st.integers(0, 2**32 - 2), min_size=1, max_size=50))
def test_runs_of_faces_are_those_faces(faces: list[int]) -> None:
    from kinfold._condition import _runs

    written = _runs("faces", faces)
    read: list[int] = []
    for word in written.split():
        first, _, last = word.partition("-")
        if int(last or first) - int(first) < 100:
            read += range(int(first), int(last or first) + 1)
    assert read == sorted(set(faces))
