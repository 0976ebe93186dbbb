"""Verdicts and forecasts."""

from __future__ import annotations

import json
import sys
import threading
import time
from pathlib import Path

import kinfold
import pytest
from conftest import run

EMPTY = "<robot name='m'><link name='a'/></robot>"


def model(path: Path, text: str = EMPTY) -> Path:
    path.write_text(text)
    return path


def test_a_good_asset_reaches_its_tier(made: kinfold.Asset) -> None:
    verdict = kinfold.check(made.urdf, tier="dynamic")
    assert verdict.tier == "dynamic" and verdict.asked == "dynamic" and verdict.reaches("static")
    assert verdict.raise_for_tier() is verdict and verdict.failures == ()
    assert verdict["C1"].holds and verdict["C1"].id == "C1" and len(verdict) == len(verdict.checks)
    assert verdict.counts["pass"] > 30 and verdict.path == str(made.urdf)


def test_a_verdict_is_that_of_the_command_line(made: kinfold.Asset) -> None:
    import subprocess

    from test_package import program

    words = [program(), "check", "--json", str(made.urdf)]
    told = json.loads(subprocess.run(words, capture_output=True, check=True).stdout)
    assert kinfold.check(made.urdf).to_dict() == told


def test_a_model_below_its_tier_raises_where_that_is_asked_for(tmp_path: Path) -> None:
    verdict = kinfold.check(model(tmp_path / "m.urdf"))
    assert not verdict.reaches("dynamic") and verdict.failures
    with pytest.raises(kinfold.TierError) as error:
        verdict.raise_for_tier("dynamic")
    assert error.value.verdict is verdict and error.value.causes
    assert "kinfold explain" in error.value.hints[0]


def test_a_waiver_stands_in_the_verdict(tmp_path: Path) -> None:
    light = EMPTY.replace(
        "<link name='a'/>",
        """<link name='a'><inertial><mass value='-1'/>
        <inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>""",
    )
    first = kinfold.check(model(tmp_path / "m.urdf", light)).failures
    failing = next(check for check in first if check.status == "fail")
    waived = kinfold.check(tmp_path / "m.urdf", waive={failing.id: "it is a test"})
    assert waived[failing.id].waived == "it is a test"
    assert failing.id not in [check.id for check in waived.failures]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ({"tier": "great"}, "tier: expected one of parse, static"),
        ({"waive": {"C9": "why"}}, "expected the id of a check"),
        ({"waive": {"C1": ""}}, "expected a reason"),
        ({"deadline": 0}, "number of seconds above 0"),
        ({"deadline": "soon"}, "number of seconds above 0"),
        ({"as_": "animal"}, "animal"),
        ({"base": "loose"}, "loose"),
        ({"seed": -1}, "seed"),
        ({"packages": {"p": "none"}}, "folder of package"),
    ],
)
def test_odd_arguments_are_refused(tmp_path: Path, words: dict, told: str) -> None:
    with pytest.raises(kinfold.InputError) as error:
        kinfold.check(model(tmp_path / "m.urdf"), **words)
    assert told in str(error.value)


def test_a_file_that_is_not_there_is_an_error_and_so_is_a_folder(tmp_path: Path) -> None:
    with pytest.raises(kinfold.KinfoldError, match="none.urdf"):
        kinfold.check("none.urdf")
    with pytest.raises(kinfold.InputError, match="expected a file, found a folder"):
        kinfold.check(tmp_path)


@pytest.mark.parametrize("text", ["", "hello", "<robot", "<robot/>", "<html/>", "\0" * 100, "<a>" * 100])
def test_whatever_stands_in_a_file_gets_a_verdict(tmp_path: Path, text: str) -> None:
    verdict = kinfold.check(model(tmp_path / "m.urdf", text))
    assert verdict.tier in ("none", "parse") and verdict.failures


def test_names_may_hold_anything(tmp_path: Path) -> None:
    for name in ("--json.urdf", "a b'\".urdf", "ä\n.urdf", "-.urdf"):
        assert kinfold.check(model(tmp_path / name)).checks
    if sys.platform == "linux":
        import os

        odd = os.fsencode(tmp_path) + b"/\xff.urdf"
        Path(os.fsdecode(odd)).write_text(EMPTY)
        assert kinfold.check(os.fsdecode(odd)).checks


def test_a_check_that_takes_too_long_is_unknown(made: kinfold.Asset) -> None:
    verdict = kinfold.check(made.urdf, deadline=0.001)
    assert verdict.tier == "none" and {check.status for check in verdict.checks} == {"unknown"}
    assert "took longer than 0.001 s" in verdict.checks[0].evidence[0]


def test_many_are_checked_at_once(tmp_path: Path, made: kinfold.Asset) -> None:
    folder = tmp_path / "models"
    folder.mkdir()
    for name in ("a", "b"):
        model(folder / f"{name}.urdf")
    verdicts = kinfold.check_all([folder, made.urdf], jobs=2)
    assert [Path(v.path).name for v in verdicts] == ["a.urdf", "b.urdf", "asset.urdf"]
    assert verdicts[2].tier == "dynamic"
    assert [v.path for v in kinfold.check_all(made.urdf)] == [str(made.urdf)]
    assert kinfold.check_all([]) == []
    (tmp_path / "none").mkdir()
    with pytest.raises(kinfold.KinfoldError, match="no model in it"):
        kinfold.check_all(tmp_path / "none")


def test_a_verdict_is_a_table(made: kinfold.Asset, tmp_path: Path) -> None:
    html = kinfold.check(model(tmp_path / "<script>.urdf"))._repr_html_()
    assert html.startswith("<table>") and "&lt;script&gt;" in html and "<script" not in html
    verdict = kinfold.check(made.urdf)
    try:
        import pandas  # noqa: F401
    except ImportError:
        with pytest.raises(kinfold.MissingError) as error:
            verdict.to_pandas()
        assert error.value.hints == ("pip install pandas",)
    else:
        assert list(verdict.to_pandas().index) == list(verdict)


def test_the_lock_of_the_interpreter_is_not_held(made: kinfold.Asset) -> None:
    ticks, done = [0], threading.Event()

    def tick() -> None:
        while not done.is_set():
            ticks[0] += 1
            time.sleep(0.005)

    thread = threading.Thread(target=tick)
    thread.start()
    before = ticks[0]
    kinfold.check(made.urdf)
    assert ticks[0] > before
    done.set()
    thread.join()


def test_ctrl_c_leaves_a_check(made: kinfold.Asset) -> None:
    code = f"""
import os, signal, threading, time, kinfold
signal.signal(signal.SIGINT, signal.default_int_handler)
threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
began = time.monotonic()
try:
    for _ in range(200): kinfold.check({str(made.urdf)!r})
except KeyboardInterrupt:
    print("stopped", time.monotonic() - began < 20)
"""
    assert run(code).stdout == "stopped True\n"


def test_rules_say_what_simulators_will_do(made: kinfold.Asset) -> None:
    said = kinfold.forecast(made.urdf)
    assert len(said) == 8 and {one.client for one in said} >= {"mujoco", "pybullet", "drake"}
    some = kinfold.forecast(made.urdf, ["mujoco", "drake"])
    assert [one.client for one in some] == ["mujoco", "drake"] and some[0].rules > 0
    assert all(finding.remedy for one in some for finding in one.findings)
    assert some[0]._repr_html_().startswith("<table>")


def test_a_forecast_of_nothing_or_for_nobody_is_refused(made: kinfold.Asset) -> None:
    with pytest.raises(kinfold.InputError, match="none.urdf"):
        kinfold.forecast("none.urdf")
    with pytest.raises(kinfold.InputError, match="gazebo"):
        kinfold.forecast(made.urdf, "gazebo")
