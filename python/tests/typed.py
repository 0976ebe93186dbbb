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


def many(folder: Path) -> None:
    mended = kinfold.fix(folder / "robot.urdf", only="J2", base="fixed")
    assert_type(mended.after, kinfold.Verdict)
    assert_type(mended.changes[0].rules, tuple[str, ...])
    verdicts = kinfold.check_all([folder], jobs=2, tier="dynamic", waive={"M2": "it is foam"})
    assert_type(verdicts, list[kinfold.Verdict])
    for result in kinfold.Batch([{"photo": folder / "a.png"}], folder / "out", export="mjcf"):
        assert_type(result, kinfold.Result)
        assert_type(result.asset, kinfold.Asset)
    assert_type(kinfold.evaluate(folder, jobs=2).failed, tuple[str, ...])
    with kinfold.connect("http://127.0.0.1:7412", token="t") as client:
        job = client.submit(folder / "a.png", mesh=b"glTF", condition={"parts": []})
        assert_type(job.wait(60, progress=True).download(folder / "asset"), kinfold.Asset)
