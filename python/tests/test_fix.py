"""Models mended from Python."""

from __future__ import annotations

import subprocess
from pathlib import Path

import kinfold
import pytest

SWAPPED = """<robot name="m">
  <link name="base"/>
  <link name="arm"/>
  <joint name="hinge" type="revolute">
    <parent link="base"/>
    <child link="arm"/>
    <axis xyz="0 0 2"/>
    <limit lower="1" upper="-1" effort="1" velocity="1"/>
  </joint>
</robot>
"""


def model(folder: Path) -> Path:
    path = folder / "m.urdf"
    path.write_text(SWAPPED)
    return path


def test_a_model_is_mended_only_where_that_is_asked_for(tmp_path: Path) -> None:
    path = model(tmp_path)
    mended = kinfold.fix(path)
    assert not mended.written and path.read_text() == SWAPPED
    assert {rule for change in mended.changes for rule in change.rules} >= {"J1", "J2"}
    assert mended.before["J2"].status == "fail" and mended.after["J2"].holds
    assert mended.changes[0].line > 0 and "hinge" in mended.changes[0].subject
    assert '+    <limit lower="-1" upper="1"' in mended.diff
    assert "-1" in mended._repr_html_() and "written=False" in repr(mended)
    written = kinfold.fix(path, write=True)
    assert written.written and written.diff == mended.diff
    assert 'lower="-1" upper="1"' in path.read_text()
    assert kinfold.check(path)["J2"].holds
    again = kinfold.fix(path, write=True)
    assert again.changes == () and again.diff == "" and not again.written
    assert all(one.why for one in again.left)


def test_the_diff_applies(tmp_path: Path) -> None:
    path = model(tmp_path)
    mended = kinfold.fix(Path("m.urdf"))
    told = subprocess.run(["patch", "-p1"], input=mended.diff, text=True, capture_output=True, check=False)
    assert told.returncode == 0, told
    assert kinfold.check(path)["J1"].holds


def test_only_what_is_asked_for_is_mended(tmp_path: Path) -> None:
    mended = kinfold.fix(model(tmp_path), only="J2")
    assert {rule for change in mended.changes for rule in change.rules} == {"J2"}
    with pytest.raises(kinfold.InputError, match="nothing mends what F1 finds") as error:
        kinfold.fix(tmp_path / "m.urdf", only=["J2", "F1"])
    assert "only= takes" in error.value.hints[0]


def test_what_is_no_model_is_told(tmp_path: Path) -> None:
    with pytest.raises(kinfold.InputError, match="expected a file, found none"):
        kinfold.fix(tmp_path / "none.urdf")
    with pytest.raises(kinfold.InputError, match="is a folder"):
        kinfold.fix(tmp_path)
    (tmp_path / "m.urdf").write_bytes(b"\xff\xfe<robot")
    with pytest.raises(kinfold.RunError) as error:
        kinfold.fix(tmp_path / "m.urdf")
    assert error.value.hints


def test_an_option_that_is_none_is_a_type_error(tmp_path: Path) -> None:
    with pytest.raises(TypeError, match="check\\(\\) got an unexpected keyword argument 'teir'"):
        kinfold.check(model(tmp_path), teir="static")  # type: ignore[call-arg]
    with pytest.raises(TypeError):
        kinfold.check_all([tmp_path], deadlin=3)  # type: ignore[call-arg]
