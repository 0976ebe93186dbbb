"""Many items, broken off and gone on with; and how articulators are measured."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import kinfold
import pytest
from conftest import CLOCK, ROOT, example


def item(name: str, **more: Any) -> dict[str, Any]:
    files = {"photo": "photo.png", "mesh": "mesh.glb", "condition": "condition.json"}
    return {"id": name} | {what: example("cabinet", file) for what, file in files.items()} | more


def test_a_batch_that_is_broken_off_goes_on_and_makes_nothing_twice(
    tmp_path: Path, mesh: kinfold.Mesh, condition: kinfold.Condition
) -> None:
    items = [item("a"), item("b", mesh=mesh, condition=condition, seed=1), item("c", photo=ROOT / "none.png")]
    words: dict[str, Any] = {"clock": CLOCK, "jobs": 1}
    first = kinfold.Batch(items, tmp_path / "out", **words)
    going = iter(first)
    one = next(going)
    going.close()
    assert first.summary is None and [r.id for r in first.results()] == [one.id]
    told: list[kinfold.Progress] = []
    second = kinfold.Batch(items, tmp_path / "out", progress=told.append, **words)
    assert second.manifest.read_bytes() == first.manifest.read_bytes()
    rest = list(second)
    assert sorted([one.id, *(r.id for r in rest)]) == ["a", "b"], "what is not there is a bad line"
    assert second.summary is not None and second.summary["bad_lines"] == 1
    results = {result.id: result for result in second.results()}
    assert results["a"].outcome == "accepted" and results["a"].asset.tier == results["a"].tier == "dynamic"
    assert results["b"].record["seed"] == 1 and results["a"].folder == tmp_path / "out" / "assets" / "a"
    assert any("articulate" in one.stage for one in told) and told[-1].state in ("accepted", "rejected")
    assert list(second) == [] and "accepted" in second._repr_html_()
    assert second.run() == second.results()


def test_ctrl_c_leaves_what_the_same_batch_goes_on_from(tmp_path: Path) -> None:
    code = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from test_batch import item
import kinfold, signal
signal.signal(signal.SIGINT, signal.default_int_handler)
def told(p):
    print(p.stage, flush=True)
batch = kinfold.Batch([item("a"), item("b", seed=1)], "out", jobs=1, progress=told)
try:
    list(batch)
except KeyboardInterrupt as error:
    print("stopped", error.__notes__, flush=True)
"""
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, cwd=tmp_path)
    assert process.stdout is not None
    assert process.stdout.readline()
    time.sleep(0.2)
    process.send_signal(signal.SIGINT)
    told, _ = process.communicate(timeout=120)
    assert process.returncode == 0 and "the same batch goes on from there" in told, told
    os.chdir(tmp_path)
    results = kinfold.Batch([item("a"), item("b", seed=1)], "out", jobs=1).run()
    assert [(r.id, r.outcome) for r in results] == [("a", "accepted"), ("b", "accepted")]
    assert not any((tmp_path / "out" / "unfinished").iterdir())


@pytest.mark.parametrize(
    ("items", "words", "found"),
    [
        ([], {}, "expected some items, found none"),
        (7, {}, "a list of items, found int"),
        ([7], {}, r"items\[0\]: expected a dictionary"),
        ([{"foto": "x"}], {}, "found 'foto'"),
        ([{"photo": 3}], {}, "expected a path, found int"),
        ("none.jsonl", {}, "expected a manifest, found none"),
        ([{"photo": "x.png"}], {"export": "step"}, "found 'step'"),
        ([{"photo": "x.png"}], {"tier": "audited"}, "expected a tier up to dynamic"),
        ([{"photo": "x.png", "seed": float("nan")}], {}, r"items\[0\]: "),
    ],
)
def test_what_is_no_batch_is_told_and_leaves_nothing(
    tmp_path: Path, items: Any, words: dict[str, Any], found: str
) -> None:
    with pytest.raises(kinfold.InputError, match=found):
        kinfold.Batch(items, tmp_path / "out", **words)
    assert not (tmp_path / "out").exists() and not (tmp_path / "out.items").exists()


def test_a_folder_that_is_somebody_elses_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.tex").write_text("mine")
    with pytest.raises(kinfold.RunError, match="thesis") as error:
        list(kinfold.Batch([item("a")], tmp_path / "out"))
    assert "out=" in error.value.hints[0]
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["thesis.tex"]


def test_cases_that_are_none_are_told(tmp_path: Path) -> None:
    with pytest.raises(kinfold.KinfoldError, match="cases"):
        kinfold.evaluate(tmp_path / "cases")


def test_an_articulator_is_measured(tmp_path: Path) -> None:
    shared = Path(os.environ.get("KINFOLD_SHARED", ROOT.parent / "shared")) / "data" / "cases" / "dev"
    if not shared.is_dir():
        pytest.skip("no shared cases: set KINFOLD_SHARED")
    names = [path.name for path in shared.iterdir()]
    # The filter takes every case whose name holds the words.
    name = min(name for name in names if sum(name in other for other in names) == 1)
    told = kinfold.evaluate(shared, filter=name, points=3000)
    assert [row["case"] for row in told.cases] == [name] and told.failed == ()
    assert told.means and "hungarian" in told.text and told.to_dict()["schema"]
    assert told.mode == "mesh+kinematic" and "<pre>" in told._repr_html_()
