"""What a researcher writes, as a type checker sees it; pyright reads it, nobody runs it."""

from pathlib import Path
from typing import Any, assert_type

import kinfold
import numpy as np
from numpy.typing import NDArray


def one(vertices: NDArray[np.float32], faces: NDArray[np.int32]) -> NDArray[np.float64]:
    condition = kinfold.Condition("kettle").part("body").part("lid", parent="body", joint="revolute")
    made = kinfold.articulate(vertices, faces, condition)
    assert_type(made, kinfold.Articulation)
    assert_type(made.labels, NDArray[np.uint16])
    return made.pose({"lid": 0.5})


def other(mesh: object) -> tuple[str, ...]:
    return kinfold.articulate(mesh, condition={"parts": []}, up="z").names


def generate(photo: kinfold.Photo, seed: int) -> Path:
    return Path("mesh.glb")


def answer(photo: kinfold.Photo, views: list[kinfold.View]) -> dict[str, Any]:
    return {}


def all_of_it(photo: Path) -> None:
    asset = kinfold.make(photo, image_to_3d=generate, vlm=answer, export=["mjcf"], tier="dynamic")
    assert_type(asset.raise_for_tier(), kinfold.Asset)
    verdict = kinfold.check(asset.urdf, tier="dynamic").raise_for_tier()
    assert_type(verdict["C1"], kinfold.Check)
    for stage in kinfold.Trace(asset):
        assert_type(stage, kinfold.Stage)
