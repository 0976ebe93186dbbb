"""What the tests share: the examples, each read and made once."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import kinfold
import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
NAMES = ("cabinet", "cart", "pedal_bin")
CLOCK = "2026-01-01T00:00:00Z"


def example(name: str, file: str) -> Path:
    return EXAMPLES / name / file


@pytest.fixture(autouse=True)
def _away(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every test works in a folder of its own, and nothing of the person's acts."""
    monkeypatch.chdir(tmp_path)
    for name in ("KINFOLD_CONFIG", "KINFOLD_STATE", "KINFOLD_POLICY", "OPENAI_API_KEY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("KINFOLD_STATE", str(tmp_path / "state"))


@pytest.fixture(scope="session")
def mesh() -> kinfold.Mesh:
    return kinfold.read_mesh(example("cabinet", "mesh.glb"))


@pytest.fixture(scope="session")
def condition() -> kinfold.Condition:
    return kinfold.Condition.from_file(example("cabinet", "condition.json"))


@pytest.fixture(scope="session")
def articulation(mesh: kinfold.Mesh, condition: kinfold.Condition) -> kinfold.Articulation:
    return kinfold.articulate(mesh, condition=condition)


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> kinfold.Asset:
    """The cabinet's asset, with MJCF and USD."""
    folder = tmp_path_factory.mktemp("made")
    return kinfold.make(
        example("cabinet", "photo.png"),
        mesh=example("cabinet", "mesh.glb"),
        condition=example("cabinet", "condition.json"),
        out=folder / "cabinet",
        state=folder / "state",
        export=["mjcf", "usd"],
        clock=CLOCK,
    )


def run(code: str, *, timeout: float = 300) -> subprocess.CompletedProcess[str]:
    """Runs a piece of Python in an interpreter of its own, which must not be ended by a signal."""
    ended = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=timeout, check=False
    )
    assert ended.returncode >= 0, f"ended by signal {-ended.returncode}: {ended.stderr}"
    return ended


def cube(size: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float) * size
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]]
    faces += [[2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    return corners, np.array(faces)


def box_on_box() -> tuple[np.ndarray, np.ndarray, kinfold.Condition]:
    """A box and a lid that lies on it; y up."""
    (body, faces), (lid, more) = cube(), cube()
    lid = lid * [1.0, 0.1, 1.0] + [0.0, 1.0, 0.0]
    condition = (
        kinfold.Condition("box", size={"height": 0.3})
        .part("body", point=[0.5, 0.5, 0.0])
        .part("lid", parent="body", joint="revolute", point=[0.5, 1.1, 0.5])
    )
    return np.vstack([body, lid]), np.vstack([faces, more + len(body)]), condition
