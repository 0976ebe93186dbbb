"""Arrays of every kind as meshes: taken, or refused by name."""

from __future__ import annotations

from types import SimpleNamespace

import kinfold
import numpy as np
import pytest
from conftest import cube, example
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from kinfold._arrays import checked

quick = settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))


def glb(vertices: object, faces: object, colors: object = None) -> bytes:
    return kinfold.Mesh(*checked(vertices, faces, colors)).to_glb()  # type: ignore[arg-type]


@pytest.mark.parametrize("dtype", ["f8", "f4", "f2", "i8", "i4", "u1", ">f8", "<f4"])
def test_vertices_may_be_numbers_of_any_kind(dtype: str) -> None:
    vertices, faces = cube()
    assert glb(vertices.astype(dtype), faces) == glb(vertices, faces)


@pytest.mark.parametrize("dtype", ["i8", "i4", "i2", "i1", "u8", "u4", "u2", "u1", ">i4"])
def test_faces_may_be_whole_numbers_of_any_kind(dtype: str) -> None:
    vertices, faces = cube()
    assert glb(vertices, faces.astype(dtype)) == glb(vertices, faces)


@pytest.mark.parametrize(
    "view",
    [
        lambda a: np.asfortranarray(a),
        lambda a: np.repeat(a, 2, axis=0)[::2],
        lambda a: a[::-1][::-1],
        lambda a: np.hstack([a, a])[:, :3],
        lambda a: a.tolist(),
        lambda a: tuple(map(tuple, a.tolist())),
        lambda a: memoryview(np.ascontiguousarray(a)),
        lambda a: np.ma.masked_array(a),
    ],
)
def test_arrays_need_not_be_contiguous_nor_arrays(view) -> None:  # type: ignore[no-untyped-def]
    vertices, faces = cube()
    assert glb(view(vertices), view(faces)) == glb(vertices, faces)


def test_read_only_arrays_are_read() -> None:
    vertices, faces = cube()
    vertices.setflags(write=False)
    faces.setflags(write=False)
    assert glb(vertices, faces)[:4] == b"glTF"


@pytest.mark.parametrize(
    ("vertices", "faces", "told"),
    [
        (np.zeros((0, 3)), np.zeros((0, 3), int), "at least one triangle, found none"),
        (np.zeros((4, 2)), np.zeros((1, 3), int), "vertices: expected shape (n, 3), found (4, 2)"),
        (np.zeros(12), np.zeros((1, 3), int), "vertices: expected shape (n, 3), found (12,)"),
        (np.zeros((4, 3, 1)), np.zeros((1, 3), int), "found (4, 3, 1)"),
        (3.0, np.zeros((1, 3), int), "vertices: expected shape (n, 3), found float"),
        (np.zeros((4, 3)), np.zeros((1, 4), int), "faces: expected shape (n, 3), found (1, 4)"),
        (np.eye(3), [[0, 1, 3]], "face 0 uses vertex 3, but the mesh has 3 vertices"),
        (np.eye(3), [[0, 1, 2], [0, -1, 2]], "face 1 uses vertex -1"),
        (np.eye(3), [[0, 1, 2**40]], "face 0 uses vertex 1099511627776"),
        (np.eye(3), np.array([[0, 1, 2**63]], np.uint64), "found vertex 9223372036854775808"),
        (np.eye(3), [[0.0, 1.0, 2.0]], "faces: expected whole numbers, found dtype float64"),
        (np.eye(3), [[True, False, True]], "faces: expected whole numbers, found dtype bool"),
        (np.eye(3) * np.nan, [[0, 1, 2]], "vertex 0 is not finite"),
        ([[1, 0, np.inf], [0, 1, 0], [0, 0, 1]], [[0, 1, 2]], "vertex 0 is not finite"),
        (np.eye(3) * 1e300, [[0, 1, 2]], "largest extent is"),
        (np.ones((3, 3)), [[0, 1, 2]], "largest extent is 0"),
        (np.eye(3, dtype=complex), [[0, 1, 2]], "vertices: expected real numbers, found dtype complex128"),
        ([["a", "b", "c"]], [[0, 0, 0]], "vertices: expected real numbers, found dtype <U1"),
        ([[1, 2, 3], [1, 2]], [[0, 0, 0]], "vertices: expected an array of shape (n, 3)"),
        (np.array([[None, 1, 2]]), [[0, 0, 0]], "found dtype object"),
    ],
)
def test_what_is_no_mesh_is_refused_by_its_rule(vertices: object, faces: object, told: str) -> None:
    with pytest.raises(kinfold.MeshError) as error:
        glb(vertices, faces)
    assert told in str(error.value)


@pytest.mark.parametrize(
    ("colors", "told"),
    [
        (np.zeros((3, 3)), "colors: expected shape (8, 3) or (8, 4), found (3, 3)"),
        (np.zeros((8, 2)), "found (8, 2)"),
        (np.full((8, 3), 1.5), "real numbers from 0 to 1"),
        (np.full((8, 3), np.nan), "real numbers from 0 to 1"),
        (np.full((8, 3), 256), "whole numbers from 0 to 255"),
        (np.full((8, 3), -1), "whole numbers from 0 to 255"),
        (np.full((8, 3), "red"), "colors: expected numbers"),
        ("red", "found str"),
    ],
)
def test_what_are_no_colours_is_refused(colors: object, told: str) -> None:
    with pytest.raises(kinfold.MeshError) as error:
        glb(*cube(), colors)
    assert told in str(error.value)


def test_colours_of_every_kind_are_the_same_colours(tmp_path) -> None:  # type: ignore[no-untyped-def]
    vertices, faces = cube()
    whole = np.tile(np.array([255, 0, 51], np.uint8), (8, 1))
    same = glb(vertices, faces, whole)
    assert glb(vertices, faces, whole / 255) == same
    assert glb(vertices, faces, whole.astype(int)) == same
    assert glb(vertices, faces, np.hstack([whole, np.full((8, 1), 255)])) == same
    (tmp_path / "a.glb").write_bytes(same)
    read = kinfold.read_mesh(tmp_path / "a.glb")
    assert read.colors is not None and (read.colors == [255, 0, 51, 255]).all()


def test_a_mesh_that_is_written_is_read_again(tmp_path) -> None:  # type: ignore[no-untyped-def]
    vertices, faces = cube(0.25)
    (tmp_path / "a.glb").write_bytes(glb(vertices, faces))
    read = kinfold.read_mesh(tmp_path / "a.glb")
    # Corners of a cube are told apart by their normals.
    assert (read.vertices[read.faces] == vertices[faces]).all()
    assert read.colors is None and read.up == "y"


def test_arrays_that_are_read_may_be_written_to(mesh: kinfold.Mesh) -> None:
    read = kinfold.read_mesh(example("cabinet", "mesh.glb"))
    read.vertices[0] = 7.0
    assert (kinfold.read_mesh(example("cabinet", "mesh.glb")).vertices == mesh.vertices).all()


def test_a_mesh_file_that_is_none_is_refused(tmp_path) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(kinfold.InputError, match="none.glb"):
        kinfold.read_mesh("none.glb")
    (tmp_path / "a.glb").write_text("hello")
    with pytest.raises(kinfold.InputError, match="expected a mesh as GLB"):
        kinfold.read_mesh(tmp_path / "a.glb")
    with pytest.raises(kinfold.InputError, match='up: expected "y" or "z", found "x"'):
        kinfold.read_mesh(tmp_path / "a.glb", up="x")  # type: ignore[arg-type]


def test_meshes_of_other_libraries_are_taken_by_what_they_have() -> None:
    from kinfold._arrays import taken

    vertices, faces = cube()
    shades = np.full((8, 4), 9, np.uint8)
    trimesh = SimpleNamespace(
        vertices=vertices, faces=faces, visual=SimpleNamespace(kind="vertex", vertex_colors=shades)
    )
    open3d = SimpleNamespace(
        vertices=vertices, triangles=faces, vertex_colors=shades / 255, has_vertex_colors=lambda: True
    )
    plain = SimpleNamespace(vertices=vertices, faces=faces)
    for mesh in (trimesh, open3d):
        assert glb(*taken(mesh, None, None)) == glb(vertices, faces, shades)
    assert glb(*taken(plain, None, None)) == glb(vertices, faces)


def test_a_scene_is_refused_with_what_to_do() -> None:
    trimesh = pytest.importorskip("trimesh")
    scene = trimesh.Scene(trimesh.creation.box())
    with pytest.raises(kinfold.MeshError) as error:
        kinfold.articulate(scene, condition=kinfold.Condition().part("body"))
    assert "Scene" in error.value.hints[0]


numbers = st.floats(-1e3, 1e3, width=32)


@quick
@given(
    arrays.arrays(np.float64, (6, 3), elements=numbers),
    arrays.arrays(np.int64, (4, 3), elements=st.integers(0, 5)),
)
def test_any_triangles_go_through_a_file_and_back(vertices: np.ndarray, faces: np.ndarray) -> None:
    used = vertices[np.unique(faces)]
    if np.ptp(used, axis=0).max() < 1e-3:
        return
    written = glb(vertices, faces)
    with pytest.MonkeyPatch.context():
        import tempfile

        with tempfile.NamedTemporaryFile(suffix=".glb") as file:
            file.write(written)
            file.flush()
            read = kinfold.read_mesh(file.name)
    assert np.allclose(read.vertices[read.faces], vertices[faces], atol=1e-6)


anything = st.one_of(
    arrays.arrays(
        st.sampled_from([np.float64, np.float32, np.int64, np.uint8, np.bool_, np.complex64, np.int8]),
        arrays.array_shapes(min_dims=0, max_dims=4, min_side=0, max_side=5),
    ),
    st.none(),
    st.text(),
    st.lists(st.one_of(st.integers(), st.floats(), st.none())),
    st.binary(),
)


@quick
@given(anything, anything, st.one_of(st.none(), anything))
def test_anything_at_all_is_a_mesh_or_an_error_of_ours(
    vertices: object, faces: object, colors: object
) -> None:
    try:
        with np.errstate(all="ignore"):
            assert glb(vertices, faces, colors)[:4] == b"glTF"
    except kinfold.InputError:
        pass


@quick
@given(
    arrays.arrays(np.float64, (5, 3), elements=st.floats(allow_nan=True, allow_infinity=True)),
    arrays.arrays(np.int64, (3, 3), elements=st.integers(-(2**63), 2**63 - 1)),
)
def test_any_numbers_are_a_mesh_or_an_error_of_ours(vertices: np.ndarray, faces: np.ndarray) -> None:
    try:
        glb(vertices, faces)
    except kinfold.MeshError:
        pass
