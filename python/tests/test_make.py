"""Assets: the same bytes as the command line's, with files, arrays and callables."""

from __future__ import annotations

import hashlib
import json
import logging
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import kinfold
import numpy as np
import pytest
from conftest import CLOCK, NAMES, box_on_box, example, run
from own import generator, speaker
from test_package import program


def digests(folder: Path) -> dict[str, str]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(p.relative_to(folder)): hashlib.sha256(p.read_bytes()).hexdigest() for p in files}


@pytest.mark.parametrize("name", NAMES)
def test_python_and_the_command_line_make_the_same_bytes(name: str, tmp_path: Path) -> None:
    photo, mesh, condition = (example(name, f) for f in ("photo.png", "mesh.glb", "condition.json"))
    words = ["make", photo, "--mesh", mesh, "--condition", condition, "--clock", CLOCK, "--quiet"]
    words += ["--out", tmp_path / "one", "--state", tmp_path / "state-1", "--export", "mjcf,usd,glb"]
    subprocess.run([program(), *words], check=True, stdout=subprocess.DEVNULL)
    asset = kinfold.make(
        photo,
        mesh=mesh,
        condition=condition,
        clock=CLOCK,
        out=tmp_path / "other",
        state=tmp_path / "state-2",
        export=["mjcf", "usd", "glb"],
    )
    assert digests(tmp_path / "one") == digests(asset.path)


def test_an_asset_says_what_it_is(made: kinfold.Asset) -> None:
    assert made.tier == "dynamic" and made.outcome == "done" and made.published
    assert made.raise_for_tier() is made and made.raise_for_tier("dynamic") is made
    assert made.verdict.tier == "dynamic" and made.verdict.asked == "kinematic"
    assert made.confidence is not None and 0 <= made.confidence <= 1
    assert made.urdf.is_file() and made.page.is_file() and made.trace.is_file()
    assert {stage["stage"] for stage in made.stages} >= {"articulate", "build-asset", "check-in-sim"}
    assert os.fspath(made) == str(made.path) and "cabinet" in repr(made)
    assert made.description["joints"]


def test_an_asset_is_opened_again(made: kinfold.Asset) -> None:
    again = kinfold.Asset(made.path)
    assert again.tier == made.tier and again.outcome is None
    with pytest.raises(kinfold.InputError, match="found no asset.urdf"):
        kinfold.Asset("none")


def test_an_asset_shows_itself(made: kinfold.Asset) -> None:
    html = made._repr_html_()
    assert html.startswith("<iframe") and "srcdoc" in html and "http://" not in html.split("srcdoc")[0]


def test_mujoco_loads_it_in_a_line(made: kinfold.Asset) -> None:
    mujoco = pytest.importorskip("mujoco")
    model = made.to_mujoco()
    assert model.njnt >= 2
    data = mujoco.MjData(model)
    drawer = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, "drawer")
    low, high = model.jnt_range[drawer]
    force = np.sign(high + low) * 20.0
    for _ in range(2000):
        data.qfrc_applied[model.jnt_dofadr[drawer]] = force
        mujoco.mj_step(model, data)
    opened = data.qpos[model.jnt_qposadr[drawer]]
    assert abs(opened) > 0.5 * max(abs(low), abs(high)), (opened, low, high)


def test_paths_for_other_simulators(made: kinfold.Asset, tmp_path: Path) -> None:
    assert Path(made.to_urdf_path()).is_absolute() and Path(made.to_usd()).name == "asset.usda"
    plain = tmp_path / "plain"
    plain.mkdir()
    (plain / "asset.urdf").write_text("<robot/>")
    with pytest.raises(kinfold.RunError) as error:
        kinfold.Asset(plain).to_usd()
    assert "export" in error.value.hints[0]


def box(folder: Path, **words: Any) -> kinfold.Asset:
    vertices, faces, condition = box_on_box()
    given = {"mesh": (vertices, faces), "condition": condition, "out": folder / "box", "tier": "static"}
    return kinfold.make(**{**given, **words})


def test_arrays_and_conditions_in_memory_are_enough(tmp_path: Path) -> None:
    asset = box(tmp_path)
    assert asset.path == tmp_path / "box" and len(asset.description["links"]) == 2
    assert list(tmp_path.iterdir()) and not list(Path(tmp_path).glob("kinfold-*"))


def test_a_mesh_with_z_up_in_memory_stands_upright(tmp_path: Path) -> None:
    vertices, faces, condition = box_on_box()
    document = condition.to_dict()
    for part in document["parts"]:
        x, y, z = part["point"]
        part["point"] = [x, -z, y]
    lying = kinfold.Mesh(vertices[:, [0, 2, 1]] * [1, -1, 1], faces, None, "z")
    upright, turned = box(tmp_path), box(tmp_path, mesh=lying, condition=document, out=tmp_path / "z")
    height = [
        a.description["size"]["value"] if "value" in a.description["size"] else a.description["size"]
        for a in (upright, turned)
    ]
    assert height[0] == height[1]


def test_trimesh_goes_in(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    vertices, faces, _ = box_on_box()
    asset = box(tmp_path, mesh=trimesh.Trimesh(vertices, faces, process=False))
    assert len(asset.description["links"]) == 2


def test_stages_are_told_and_kept(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    told: list[kinfold.Progress] = []
    with caplog.at_level(logging.INFO, "kinfold"):
        box(tmp_path, progress=told.append)
    assert {p.stage for p in told} >= {"articulate", "check-in-sim"}
    assert told[-1].done == told[-1].total and {p.state for p in told} == {"running", "done"}
    assert any("articulate: done" in record.getMessage() for record in caplog.records)
    again: list[kinfold.Progress] = []
    box(tmp_path, progress=again.append)
    assert "kept" in {p.state for p in again}


def test_progress_runs_on_the_thread_that_asked(tmp_path: Path) -> None:
    threads: set[int] = set()
    box(tmp_path, progress=lambda _: threads.add(threading.get_ident()))
    assert threads == {threading.get_ident()}


def test_what_progress_raises_stops_the_run(tmp_path: Path) -> None:
    def stop(told: kinfold.Progress) -> None:
        if told.stage == "articulate":
            raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        box(tmp_path, progress=stop)
    assert not (tmp_path / "box").exists()
    assert box(tmp_path).tier


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ({"mesh": None}, "there is no photo"),
        ({"condition": None}, "there is no photo"),
        ({"out": None}, "a mesh in memory has no name"),
        ({"export": ["stl"]}, "export: expected some of urdf, mjcf"),
        ({"tier": "audited"}, "tier: expected a tier up to dynamic"),
        ({"tier": "x"}, "tier: expected one of"),
        ({"seed": -1}, "seed: expected"),
        ({"deadline": 0}, "deadline: expected seconds above 0"),
        ({"deadline": float("nan")}, "deadline: expected seconds above 0"),
        ({"min_confidence": 2}, "probability from 0 to 1"),
        ({"up": "x"}, "up: expected"),
        ({"policy": "free"}, "policy"),
        ({"clock": "yesterday"}, "clock"),
        ({"progress": 7}, "progress: expected a callable"),
        ({"mesh": (1, 2, 3, 4)}, "found 4 things"),
        ({"mesh": object()}, "expected vertices and faces"),
        ({"condition": 7}, "expected a kinfold.Condition"),
        ({"image_to_3d": lambda p: None}, "mesh and image_to_3d"),
        ({"vlm": lambda p: None}, "condition and vlm"),
        ({"mesh": None, "image_to_3d": 7, "photo": "x.png"}, "image_to_3d: expected a callable"),
        ({"photo": "none.png"}, "none.png"),
    ],
)
def test_odd_arguments_are_refused_and_leave_nothing(tmp_path: Path, words: dict, told: str) -> None:
    with pytest.raises(kinfold.KinfoldError) as error:
        box(tmp_path, **words)
    assert told in str(error.value), error.value
    assert not (tmp_path / "box").exists()


def test_a_condition_with_faults_is_refused_with_all_of_them(tmp_path: Path) -> None:
    vertices, faces, condition = box_on_box()
    condition.correct("lid", point=[9, 9, 9]).correct("body", point=[8, 8, 8])
    with pytest.raises(kinfold.KinfoldError) as error:
        box(tmp_path, condition=condition)
    assert len(error.value.causes) >= 2


def test_an_asset_below_its_tier_is_there_all_the_same(tmp_path: Path) -> None:
    vertices, faces, condition = box_on_box()
    # A lid that may turn into the box.
    condition.correct("lid", axis=[0, 0, 1], pivot=[0.5, 1.0, 0.5], range=[-1.2, 1.2])
    asset = box(tmp_path, condition=condition, tier="dynamic")
    if asset.verdict.reaches("dynamic"):
        pytest.skip("the asset was amended until it reached it")
    assert asset.outcome == "below the tier" and asset.reason
    with pytest.raises(kinfold.TierError):
        asset.raise_for_tier()


# One's own callables.


def own(folder: Path, **words: Any) -> kinfold.Asset:
    given = {"image_to_3d": generator, "vlm": speaker, "out": folder / "own", "clock": CLOCK}
    return kinfold.make(example("cabinet", "photo.png"), **{**given, **words})


def test_callables_make_an_asset_that_is_replayed_without_them(tmp_path: Path) -> None:
    asset = own(tmp_path)
    assert asset.tier == "dynamic"
    trace = kinfold.Trace(asset)
    assert trace.manifest["parameters"]["image_to_3d"].startswith("python/1 own.generator ")
    assert trace.verify()["holds"] is True
    same = trace.replay(tmp_path / "again")
    assert "articulate" in same
    assert digests(tmp_path / "again") == digests(asset.path)


def test_a_callable_is_asked_once(tmp_path: Path) -> None:
    asked: list[int] = []

    def counting(photo: kinfold.Photo, seed: int) -> Path:
        asked.append(seed)
        return generator(photo)

    counting.identity = "counting 1"  # type: ignore[attr-defined]
    one, other = own(tmp_path, image_to_3d=counting), own(tmp_path, image_to_3d=counting)
    assert asked == [0] and digests(one.path) == digests(other.path)
    own(tmp_path, image_to_3d=counting, seed=3)
    assert asked == [0, 3]


class Model:
    def __init__(self, answer: Any, identity: str | None = "test model 1") -> None:
        self.answer = answer
        if identity is not None:
            self.identity = identity

    def __call__(self, photo: kinfold.Photo) -> Any:
        if isinstance(self.answer, BaseException):
            raise self.answer
        return self.answer() if callable(self.answer) else self.answer


@pytest.mark.parametrize("form", ["path", "text", "bytes", "mesh", "pair", "trimesh"])
def test_a_mesh_may_be_answered_in_any_form(tmp_path: Path, form: str, mesh: kinfold.Mesh) -> None:
    path = example("cabinet", "mesh.glb")
    if form == "trimesh":
        trimesh = pytest.importorskip("trimesh")
        answer: Any = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    else:
        answers = {"path": path, "text": str(path), "bytes": path.read_bytes(), "mesh": mesh}
        answer = answers.get(form, (mesh.vertices, mesh.faces))
    asset = own(tmp_path, image_to_3d=Model(answer, f"form {form}"))
    assert asset.tier == "dynamic"


@pytest.mark.parametrize(
    ("answer", "told"),
    [
        (None, "raised InputError: expected a mesh, found NoneType"),
        (7, "found int"),
        (b"hello", "the answer of image_to_3d: expected a mesh as GLB"),
        ("none.glb", "none.glb"),
        ((1, 2), "raised MeshError: vertices: expected shape (n, 3)"),
        (ValueError("no GPU"), "raised ValueError: no GPU"),
        (SystemExit(3), "raised SystemExit: 3"),
        (KeyboardInterrupt(), "raised KeyboardInterrupt"),
        (ValueError("\x1b[2J\n" * 3), "raised ValueError"),
    ],
)
def test_a_callable_that_does_not_answer_is_a_provider_error(tmp_path: Path, answer: Any, told: str) -> None:
    with pytest.raises(kinfold.KinfoldError) as error:
        own(tmp_path, image_to_3d=Model(answer))
    assert told in str(error.value) and "\x1b" not in str(error.value)
    assert isinstance(error.value, kinfold.ProviderError) or answer == "none.glb"
    assert answer is not None or "answer with a file's path" in error.value.hints[0]
    if isinstance(answer, BaseException):
        assert isinstance(error.value, kinfold.ProviderError) and error.value.__cause__ is answer
    assert not (tmp_path / "own").exists()


@pytest.mark.parametrize(
    "answer",
    [
        None,
        7,
        "",
        "{",
        {"parts": []},
        ["x"],
        {"schema": "kinfold-condition/2", "parts": [{"name": "a", "point": [9, 9, 9]}]},
    ],
)
def test_a_condition_that_is_none_is_an_error(tmp_path: Path, answer: Any) -> None:
    with pytest.raises(kinfold.KinfoldError):
        own(tmp_path, vlm=Model(answer))
    assert not (tmp_path / "own").exists()


def test_a_callable_that_hangs_has_a_deadline(tmp_path: Path) -> None:
    forever = threading.Event()
    began = time.monotonic()
    with pytest.raises(kinfold.ProviderError, match="gave no answer in 0.3 s"):
        own(tmp_path, image_to_3d=Model(forever.wait), deadline=0.3)
    assert time.monotonic() - began < 60
    forever.set()


def test_a_callable_that_does_not_say_who_it_is_is_refused(tmp_path: Path) -> None:
    import functools

    weights = [1, 2, 3]
    unknown = Model(b"", None)
    odd: list[Any] = [functools.partial(generator), unknown, unknown.__call__, lambda photo: weights, print]
    for provider in odd:
        with pytest.raises(kinfold.InputError) as error:
            own(tmp_path, image_to_3d=provider)
        assert "identity" in error.value.hints[0], provider
    with pytest.raises(kinfold.InputError, match="holds `weights`, a list: nobody knows which"):
        own(tmp_path, image_to_3d=lambda photo: weights)


def test_a_callable_whose_licence_nobody_knows_is_refused_by_a_policy(tmp_path: Path) -> None:
    licensed = Model(example("cabinet", "mesh.glb"), "licensed 1")
    with pytest.raises(kinfold.InputError, match="nobody says that its licence allows commercial and eu"):
        own(tmp_path, image_to_3d=licensed, policy="commercial-eu")
    licensed.allowed = ["commercial", "eu"]  # type: ignore[attr-defined]
    with pytest.raises(kinfold.InputError, match="vlm: not with the policy"):
        own(tmp_path, image_to_3d=licensed, policy="commercial-eu")
    condition = example("cabinet", "condition.json")
    assert own(tmp_path, image_to_3d=licensed, vlm=None, condition=condition, policy="commercial-eu").tier


def test_another_body_is_another_provider() -> None:
    from kinfold._providers import identity

    def closed(number: int) -> Any:
        return lambda photo, more=(1, "a"): number

    one, two = (lambda photo: b"1"), (lambda photo: b"2")
    names = [identity("x", f) for f in (one, two, closed(1), closed(2), Model(b""), generator)]
    assert len(set(names)) == len(names) and names[4] == "python/1 test model 1"
    assert identity("x", one) == identity("x", one) and identity("x", closed(1)) == names[2]


def test_a_callable_works_for_one_at_a_time(tmp_path: Path) -> None:
    at_work, most = [0], [0]

    def slow(photo: kinfold.Photo) -> Path:
        at_work[0] += 1
        most[0] = max(most[0], at_work[0])
        time.sleep(0.2)
        at_work[0] -= 1
        return generator(photo)

    slow.identity = "slow 1"  # type: ignore[attr-defined]

    def one(n: int) -> None:
        own(tmp_path, image_to_3d=slow, out=tmp_path / str(n), state=tmp_path / f"s{n}", seed=n)

    threads = [threading.Thread(target=one, args=(n,)) for n in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most == [1] and all((tmp_path / str(n) / "asset.urdf").is_file() for n in range(3))


STOPPED = """
import sys, pathlib, signal
# Whoever starts tests in the background of a shell has Ctrl-C ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.path.insert(0, {tests!r})
import kinfold
from conftest import CLOCK, example
from own import generator, speaker
folder = pathlib.Path({folder!r})
def told(p):
    print(p.stage, p.state, flush=True)
try:
    kinfold.make(example("cabinet", "photo.png"), image_to_3d=generator, vlm=speaker, clock=CLOCK,
        out=folder / "out", state=folder / "state", progress=told)
except KeyboardInterrupt as error:
    print("interrupted", error.__notes__, flush=True)
"""


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL])
def test_a_run_that_is_stopped_goes_on_to_the_same_bytes(tmp_path: Path, how: signal.Signals) -> None:
    code = STOPPED.format(tests=str(Path(__file__).parent), folder=str(tmp_path))
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as first:
        assert first.stdout is not None
        for line in first.stdout:
            if line.startswith("articulate running"):
                first.send_signal(how)
                break
        rest = first.stdout.read()
    assert first.returncode == (0 if how == signal.SIGINT else -signal.SIGKILL)
    if how == signal.SIGINT:
        assert "interrupted" in rest and "the same call goes on from there" in rest
    assert not (tmp_path / "out").exists()
    told = run(code)
    assert "generate-mesh kept" in told.stdout and "check-in-sim done" in told.stdout, told
    whole = own(tmp_path, out=tmp_path / "whole", state=tmp_path / "other")
    assert digests(tmp_path / "out") == digests(whole.path)


def test_a_trace_is_looked_into(made: kinfold.Asset) -> None:
    trace = kinfold.Trace(made.trace)
    names = [stage.name for stage in trace]
    assert "articulate" in names and names == [stage.name for stage in trace.stages]
    assert all(stage.event == "finished" for stage in trace)
    assert trace.manifest["flow"] == "image-to-urdf" and "condition.json" in trace.artefacts
    assert json.loads(trace.read("condition.json"))["category"] == "cabinet"
    assert trace.asset().path == made.path
    assert trace._repr_html_().startswith("<table>") and "trace.mcap" in repr(trace)


def test_what_a_trace_keeps_comes_as_objects(made: kinfold.Asset, condition: kinfold.Condition) -> None:
    trace = kinfold.Trace(made)
    kept = trace.load("condition.json")
    assert isinstance(kept, kinfold.Condition) and kept.to_dict()["parts"] == condition.to_dict()["parts"]
    mesh = trace.load("mesh.glb")
    assert isinstance(mesh, kinfold.Mesh) and len(mesh.faces) > 10
    for name in trace.artefacts:
        assert trace.load(name) is not None, name
    with pytest.raises(kinfold.RunError):
        trace.load("nothing.json")


def test_a_trace_shows_when_its_stages_ran(tmp_path: Path) -> None:
    files = {"mesh": example("cabinet", "mesh.glb"), "condition": example("cabinet", "condition.json")}
    asset = kinfold.make(example("cabinet", "photo.png"), out=tmp_path / "timed", **files)
    stages = {stage.name: stage for stage in kinfold.Trace(asset)}
    articulate, check = stages["articulate"], stages["check-in-sim"]
    assert 0 <= articulate.began < articulate.ended <= check.began < check.ended
    assert set(articulate.inputs.values()) >= set(stages["generate-mesh"].outputs.values())
    shown = kinfold.Trace(asset)._repr_html_()
    assert shown.count("margin-left") == len(stages) and "nan" not in shown


def test_hints_name_arguments_of_python(tmp_path: Path) -> None:
    with pytest.raises(kinfold.InputError) as error:
        kinfold.make(example("cabinet", "photo.png"), out=tmp_path / "out")
    hints = " ".join(error.value.hints)
    assert "mesh=" in hints and "condition=" in hints and "vlm=" in hints and "--" not in hints
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("mine")
    with pytest.raises(kinfold.KinfoldError) as error:
        own(tmp_path, out=tmp_path / "mine")
    assert "out=" in " ".join(error.value.hints) and "--" not in str(error.value)


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ("give the surface with --mesh FILE.glb", "give the surface with mesh="),
        ("without --no-wait this one waits", "without wait=False this one waits"),
        ("invalid value '0' for '--jobs <N>'", "invalid value '0' for 'jobs='"),
        ("`kinfold make --mesh FILE` does", "`kinfold make --mesh FILE` does"),
        ("a--mesh, --meshes", "a--mesh, --meshes"),
        ("the same command goes on", "the same call goes on"),
    ],
)
def test_flags_are_called_as_arguments_are(said: str, told: str) -> None:
    from kinfold._errors import in_python

    assert in_python(said) == told and in_python(told) == told


class Builder:
    """What Newton's has of a ModelBuilder."""

    def __init__(self) -> None:
        self.read: list[Any] = []

    def add_mjcf(self, source: str, **options: Any) -> None:
        self.read.append((source, options))


def test_an_asset_goes_into_newtons_builder(made: kinfold.Asset) -> None:
    builder = Builder()
    assert made.to_newton(builder, floating=False) is builder
    assert builder.read == [(str(made.path / "asset.xml"), {"floating": False})]
    with pytest.raises(kinfold.InputError, match="expected one of Newton's"):
        made.to_newton(object())


def test_newton_loads_an_asset(made: kinfold.Asset) -> None:
    pytest.importorskip("newton")
    model = made.to_newton().finalize()
    assert model.joint_count >= 2 and model.body_count >= 3


def test_pybullet_loads_an_asset(made: kinfold.Asset) -> None:
    pybullet = pytest.importorskip("pybullet")
    client = pybullet.connect(pybullet.DIRECT)
    try:
        body = pybullet.loadURDF(made.to_urdf_path(), useFixedBase=True, physicsClientId=client)
        kinds = [
            pybullet.getJointInfo(body, n, client)[2] for n in range(pybullet.getNumJoints(body, client))
        ]
        assert pybullet.JOINT_PRISMATIC in kinds and pybullet.JOINT_REVOLUTE in kinds
    finally:
        pybullet.disconnect(client)


def test_traces_that_are_none_are_errors(tmp_path: Path, made: kinfold.Asset) -> None:
    (tmp_path / "a.mcap").write_bytes(b"hello")
    for path in ("none.mcap", tmp_path / "a.mcap"):
        with pytest.raises(kinfold.KinfoldError) as error:
            _ = kinfold.Trace(path).stages
        assert str(error.value)
    with pytest.raises(kinfold.KinfoldError, match="nothing.json"):
        kinfold.Trace(made.trace).read("nothing.json")
    broken = bytearray(made.trace.read_bytes())
    broken[len(broken) // 2] ^= 1
    (tmp_path / "b.mcap").write_bytes(broken)
    with pytest.raises(kinfold.KinfoldError):
        kinfold.Trace(tmp_path / "b.mcap").verify()


def test_two_runs_are_compared(made: kinfold.Asset, tmp_path: Path) -> None:
    assert isinstance(kinfold.Trace(made).diff(made.trace), dict)
