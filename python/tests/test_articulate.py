"""Parts and joints of arrays: the same as those of files, in any pose."""

from __future__ import annotations

import threading
from types import SimpleNamespace

import kinfold
import numpy as np
import pytest
from conftest import NAMES, box_on_box, cube, example, run
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

quick = settings(max_examples=40, deadline=None, suppress_health_check=list(HealthCheck))


def test_labels_and_probabilities_are_one_for_each_face(
    articulation: kinfold.Articulation, mesh: kinfold.Mesh
) -> None:
    assert articulation.labels.shape == articulation.probabilities.shape == (len(mesh.faces),)
    assert articulation.labels.dtype == np.uint16 and articulation.probabilities.dtype == np.float32
    assert set(articulation.labels) == set(range(len(articulation.parts)))
    assert ((articulation.probabilities >= 0) & (articulation.probabilities <= 1)).all()


def test_parts_and_joints_are_the_conditions(
    articulation: kinfold.Articulation, condition: kinfold.Condition
) -> None:
    assert tuple(part.name for part in articulation.parts) == condition.names
    kinds = {joint.name: joint.kind for joint in articulation.joints}
    assert kinds == {"door": "revolute", "drawer": "prismatic"}
    assert articulation.names == tuple(kinds)
    for joint in articulation.joints:
        assert np.isclose(np.linalg.norm(joint.axis), 1)
        assert joint.range is not None and joint.range[0] <= 0 <= joint.range[1]
    assert articulation.confidence is not None and 0 <= articulation.confidence <= 1
    assert articulation.part_of_condition == (0, 1, 2)


@pytest.mark.parametrize("name", NAMES)
def test_arrays_give_what_the_command_line_gives(name: str, tmp_path) -> None:  # type: ignore[no-untyped-def]
    asset = kinfold.make(
        mesh=example(name, "mesh.glb"), condition=example(name, "condition.json"), out=tmp_path / name
    )
    arrays = kinfold.read_mesh(example(name, "mesh.glb"))
    condition = kinfold.Condition.from_file(example(name, "condition.json"))
    made = kinfold.articulate(arrays.vertices, arrays.faces, condition, colors=arrays.colors)
    assert made.to_json().encode() == kinfold.Trace(asset.trace).read("articulation.json")


def test_at_rest_everything_is_where_it_came(articulation: kinfold.Articulation, mesh: kinfold.Mesh) -> None:
    assert (articulation.vertices == mesh.vertices[articulation.vertex_of]).all()
    assert (articulation.vertex_of[articulation.faces] == mesh.faces).all()
    assert np.allclose(articulation.pose(), articulation.vertices)
    assert np.allclose(articulation.transforms(), np.eye(4))


def test_every_vertex_is_of_one_part(articulation: kinfold.Articulation) -> None:
    part_of = np.full(len(articulation.vertices), -1)
    for face, label in zip(articulation.faces, articulation.labels, strict=True):
        assert all(part_of[v] in (-1, label) for v in face)
        part_of[face] = label


def test_a_drawer_slides_along_its_axis_and_nothing_else_moves(articulation: kinfold.Articulation) -> None:
    joint = articulation.joints[articulation.names.index("drawer")]
    assert joint.range is not None
    far = max(joint.range, key=abs)
    moved = articulation.pose({"drawer": far}) - articulation.vertices
    of_drawer = np.unique(articulation.faces[articulation.labels == joint.part])
    assert np.allclose(moved[of_drawer], np.array(joint.axis) * far)
    others = np.setdiff1d(np.arange(len(moved)), of_drawer)
    assert np.allclose(moved[others], 0)


def test_a_door_turns_about_its_axis(articulation: kinfold.Articulation) -> None:
    joint = articulation.joints[articulation.names.index("door")]
    assert joint.range is not None
    q = max(joint.range, key=abs)
    matrix = articulation.transforms({"door": q})[joint.part]
    assert np.allclose(matrix[:3, :3] @ matrix[:3, :3].T, np.eye(3)) and np.isclose(np.linalg.det(matrix), 1)
    pivot = np.array(joint.pivot)
    assert np.allclose(matrix[:3, :3] @ pivot + matrix[:3, 3], pivot)
    assert np.allclose(matrix[:3, :3] @ joint.axis, joint.axis)
    assert np.isclose(np.trace(matrix[:3, :3]), 1 + 2 * np.cos(q))


def test_matrices_and_vertices_agree(articulation: kinfold.Articulation) -> None:
    q = [joint.range[1] / 2 if joint.range else 1.0 for joint in articulation.joints]
    matrices, moved = articulation.transforms(q), articulation.pose(q)
    part_of = np.empty(len(moved), int)
    part_of[articulation.faces.ravel()] = np.repeat(articulation.labels, 3)
    homogeneous = np.hstack([articulation.vertices, np.ones((len(moved), 1))])
    assert np.allclose(np.einsum("nij,nj->ni", matrices[part_of], homogeneous)[:, :3], moved)


@pytest.mark.parametrize(
    ("q", "told"),
    [
        ({"dor": 0.1}, "there is no joint `dor`; joints are `drawer`, `door`"),
        ([0.1], "expected 2 values, found 1"),
        ([0, 0, 0], "expected 2 values, found 3"),
        ({"door": 100.0}, "`door` goes from"),
        ({"door": float("nan")}, ""),
        ({"door": "open"}, "expected numbers"),
        ({"door": None}, "expected numbers"),
    ],
)
def test_poses_that_are_none_are_refused(articulation: kinfold.Articulation, q, told: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(kinfold.InputError) as error:
        articulation.pose(q)
    assert told in str(error.value)


def test_a_pose_outside_the_range_is_given_to_whoever_asks(articulation: kinfold.Articulation) -> None:
    assert articulation.pose({"door": 100.0}, limits=False).shape == articulation.vertices.shape
    with pytest.raises(kinfold.InputError, match="finite"):
        articulation.pose({"door": float("inf")}, limits=False)


@quick
@given(st.floats(0, 1), st.floats(0, 1))
def test_any_pose_within_the_ranges_keeps_every_part_rigid(
    articulation: kinfold.Articulation, a: float, b: float
) -> None:
    q = [
        lo + share * (hi - lo)
        for (lo, hi), share in zip((j.range or (0, 0) for j in articulation.joints), (a, b), strict=True)
    ]
    moved = articulation.pose(q)
    for part in range(len(articulation.parts)):
        corners = np.unique(articulation.faces[articulation.labels == part])[:20]
        before, after = articulation.vertices[corners], moved[corners]
        assert np.allclose(
            np.linalg.norm(before[:, None] - before, axis=2), np.linalg.norm(after[:, None] - after, axis=2)
        )


def test_parts_come_out_as_meshes(articulation: kinfold.Articulation) -> None:
    drawer = articulation.submesh("drawer")
    assert len(drawer.faces) == (articulation.labels == 1).sum() and drawer.to_glb()[:4] == b"glTF"
    assert (articulation.submesh(1).vertices == drawer.vertices).all()
    with pytest.raises(kinfold.InputError, match="no part `x`"):
        articulation.submesh("x")
    with pytest.raises(kinfold.InputError, match="from 0 to 2, found 3"):
        articulation.submesh(3)


def test_a_mesh_with_z_up_moves_in_its_own_frame() -> None:
    vertices, faces, condition = box_on_box()
    upright = kinfold.articulate(vertices, faces, condition)
    turned = vertices[:, [0, 2, 1]] * [1, -1, 1]
    document = condition.to_dict()
    for part in document["parts"]:
        x, y, z = part["point"]
        part["point"] = [x, -z, y]
    lying = kinfold.articulate(turned, faces, document, up="z")
    assert (lying.labels == upright.labels).all()
    q = {"lid": upright.joints[0].range[1] / 2}  # type: ignore[index]
    there = upright.pose(q)[:, [0, 2, 1]] * [1, -1, 1]
    assert np.allclose(lying.pose(q), there)


def test_an_up_axis_that_the_condition_contradicts_is_refused() -> None:
    vertices, faces, condition = box_on_box()
    document = {**condition.to_dict(), "up": "y"}
    with pytest.raises(kinfold.ConditionError, match="another axis"):
        kinfold.articulate(vertices, faces, document, up="z")


def test_a_point_off_the_mesh_is_refused_or_moved() -> None:
    vertices, faces, condition = box_on_box()
    far = condition.correct("lid", point=[0.5, 1.5, 0.5])
    with pytest.raises(kinfold.ConditionError, match="lid"):
        kinfold.articulate(vertices, faces, far)
    moved = kinfold.articulate(vertices, faces, far, snap=True)
    assert len(moved.parts) == 2


def test_a_base_without_a_face_is_an_error_with_a_hint() -> None:
    vertices, faces = cube()
    condition = (
        kinfold.Condition().part("body").part("lid", parent="body").paint("lid", "0-11", vertices, faces)
    )
    with pytest.raises(kinfold.KinfoldError) as error:
        kinfold.articulate(vertices, faces, condition)
    assert error.value.hints


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ({"condition": None}, "there is no condition"),
        ({"condition": 7}, "expected a kinfold.Condition"),
        ({"up": "x"}, "up: expected"),
        ({"seed": -1}, "seed: expected"),
        ({"seed": 1.5}, "seed: expected"),
        ({"seed": 2**64}, "seed: expected"),
        ({"seed": True}, "seed: expected"),
    ],
)
def test_odd_arguments_are_refused(words: dict, told: str) -> None:
    vertices, faces, condition = box_on_box()
    with pytest.raises(kinfold.InputError) as error:
        kinfold.articulate(vertices, faces, **{"condition": condition, **words})
    assert told in str(error.value)


@pytest.mark.parametrize("odd", [None, 3, "mesh", object(), [1, 2]])
def test_what_is_no_mesh_at_all_is_refused(odd: object) -> None:
    with pytest.raises(kinfold.MeshError, match="expected vertices and faces"):
        kinfold.articulate(odd, condition=box_on_box()[2])


def test_colours_are_looked_at(mesh: kinfold.Mesh) -> None:
    vertices, faces, condition = box_on_box()
    colors = np.tile(np.array([[200, 30, 30]], np.uint8), (len(vertices), 1))
    made = kinfold.articulate(vertices, faces, condition, colors=colors)
    assert "colours" in made.to_json()


def test_the_same_arrays_give_the_same_whatever_asks(
    mesh: kinfold.Mesh, condition: kinfold.Condition
) -> None:
    made = kinfold.articulate(mesh.vertices, mesh.faces, condition).to_json()
    like = SimpleNamespace(vertices=mesh.vertices, faces=mesh.faces)
    assert kinfold.articulate(like, condition=condition.to_dict()).to_json() == made
    assert (
        kinfold.articulate(mesh.vertices.tolist(), mesh.faces.tolist(), condition.to_json()).to_json() == made
    )


def test_ten_threads_at_once_get_what_one_gets() -> None:
    vertices, faces, condition = box_on_box()
    alone = kinfold.articulate(vertices, faces, condition).to_json()
    found: list[str] = []
    threads = [
        threading.Thread(
            target=lambda: found.append(kinfold.articulate(vertices, faces, condition).to_json())
        )
        for _ in range(10)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [alone] * 10


FORKED = """
import os, sys
sys.path.insert(0, {tests!r})
import kinfold
from conftest import box_on_box
given = box_on_box()
if {before}: kinfold.articulate(*given)
pid = os.fork()
if pid == 0:
    try:
        print(len(kinfold.articulate(*given).parts), flush=True)
    except kinfold.RunError as error:
        print(error, error.hints[0], flush=True)
    os._exit(0)
print(os.waitpid(pid, 0)[1], len(kinfold.articulate(*given).parts))
"""


@pytest.mark.parametrize("before", [False, True])
def test_a_process_that_is_forked_works_or_is_told_why_not(before: bool) -> None:
    from pathlib import Path

    told = run(FORKED.format(before=before, tests=str(Path(__file__).parent)))
    child, parent = told.stdout.splitlines()
    assert parent == "0 2", told
    if before:
        assert "was forked off one in which kinfold had been at work" in child and "spawn" in child
    else:
        assert child == "2"


def test_an_interpreter_that_leaves_in_the_middle_ends_cleanly() -> None:
    from pathlib import Path

    code = f"""
import sys, threading, time
sys.path.insert(0, {str(Path(__file__).parent)!r})
import kinfold
from conftest import example
mesh = kinfold.read_mesh(example("cabinet", "mesh.glb"))
condition = example("cabinet", "condition.json")
for _ in range(3):
    threading.Thread(target=lambda: kinfold.articulate(mesh, condition=condition), daemon=True).start()
time.sleep(0.05)
print("left")
"""
    told = run(code)
    assert told.stdout == "left\n" and told.returncode == 0, told


def test_an_articulation_shows_itself(articulation: kinfold.Articulation) -> None:
    html = articulation._repr_html_()
    assert html.startswith("<iframe") and "sandbox" in html and "&lt;!doctype html&gt;" in html
    assert "door" in html and repr(articulation).startswith("Articulation(")
    assert articulation.to_html().startswith("<!doctype html>")
