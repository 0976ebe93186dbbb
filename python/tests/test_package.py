"""The package as it is installed."""

from __future__ import annotations

import importlib.metadata
import importlib.resources
import json
import pickle
import subprocess
import sys
import sysconfig
from pathlib import Path

import kinfold
import pytest
from conftest import ROOT, example, run


def test_the_version_is_that_of_the_distribution() -> None:
    assert kinfold.__version__ == importlib.metadata.version("kinfold")
    assert f'version = "{kinfold.__version__}"' in (ROOT / "Cargo.toml").read_text()


def test_numpy_is_the_only_dependency() -> None:
    needed = [r for r in importlib.metadata.requires("kinfold") or [] if "extra ==" not in r]
    assert [r.split(">")[0] for r in needed] == ["numpy"]


def test_the_package_is_typed() -> None:
    files = importlib.resources.files("kinfold")
    assert files.joinpath("py.typed").is_file() and files.joinpath("_kinfold.pyi").is_file()


def test_importing_brings_no_numpy() -> None:
    told = run("import kinfold, sys; print('numpy' in sys.modules, 'asyncio' in sys.modules)")
    assert told.stdout.split() == ["False", "False"], told


def test_everything_that_is_public_is_there_and_documented() -> None:
    for name in kinfold.__all__:
        thing = getattr(kinfold, name)
        assert name == "__version__" or thing.__doc__, name


def test_every_error_is_one_of_ours_and_survives_a_pickle() -> None:
    names = [name for name in kinfold.__all__ if name.endswith("Error")]
    assert len(names) >= 10
    for name in names:
        kind = getattr(kinfold, name)
        assert issubclass(kind, kinfold.KinfoldError)
        error = pickle.loads(pickle.dumps(kind("what", ["why"], ["do this"])))
        assert (str(error), error.hints) == ("what: why", ("do this",))


def test_bad_input_is_a_value_error_and_what_fails_a_runtime_error() -> None:
    assert issubclass(kinfold.ConditionError, ValueError)
    assert issubclass(kinfold.ProviderError, RuntimeError)
    assert issubclass(kinfold.MissingError, ImportError)


def test_a_traceback_ends_with_the_hint() -> None:
    told = run("import kinfold; kinfold.check('/')")
    assert told.stderr.rstrip().endswith("hint: check_all looks through folders"), told.stderr


def program() -> str:
    return str(Path(sysconfig.get_path("scripts")) / "kinfold")


@pytest.mark.parametrize("how", [[program()], [sys.executable, "-m", "kinfold"]])
def test_the_command_line_comes_along(how: list[str]) -> None:
    told = subprocess.run([*how, "--version"], capture_output=True, text=True, check=True)
    assert told.stdout == f"kinfold {kinfold.__version__}\n"


def test_the_command_line_ends_as_it_says() -> None:
    told = subprocess.run([program(), "chekc"], capture_output=True, text=True, check=False)
    assert told.returncode == 2 and "error: unrecognized subcommand" in told.stderr
    told = subprocess.run([program(), "check", "none.urdf"], capture_output=True, text=True, check=False)
    assert told.returncode == 1 and told.stderr.startswith("error: none.urdf: ")


def test_the_command_line_checks_in_the_wheels_own_program(made: kinfold.Asset) -> None:
    told = subprocess.run(
        [program(), "check", "--json", made.to_urdf_path()], capture_output=True, text=True, check=True
    )
    assert json.loads(told.stdout)["tier"] == "dynamic"


def test_the_program_that_works_apart_does_nothing_else() -> None:
    from kinfold._apart import program as apart

    told = subprocess.run([apart(), "make", "x.png"], capture_output=True, text=True, check=False)
    assert told.returncode == 2 and "only works for the library" in told.stderr
    # It holds no weights: what it is for is small.
    assert Path(apart()).stat().st_size < 20 << 20


def test_an_interpreter_is_never_started_again(made: kinfold.Asset) -> None:
    code = f"""
import sys, kinfold
sys.executable = sys._base_executable = "/none"
print(kinfold.check({str(made.urdf)!r}).tier)
"""
    assert run(code).stdout == "dynamic\n"


def test_without_its_program_there_is_no_verdict_but_a_failure(tmp_path: Path, made: kinfold.Asset) -> None:
    (tmp_path / "kinfold").mkdir()
    for path in Path(kinfold.__file__).parent.iterdir():
        if path.name not in ("apart", "__pycache__"):
            (tmp_path / "kinfold" / path.name).symlink_to(path)
    code = f"""
import sys
sys.path.insert(0, {str(tmp_path)!r})
import kinfold
verdict = kinfold.check({str(made.urdf)!r})
print(verdict.tier, verdict.counts["pass"], verdict.checks[0].status)
try:
    kinfold.Trace({str(made.trace)!r}).stages
except kinfold.RunError as error:
    print(error.hints[0])
"""
    first, second = run(code).stdout.splitlines()
    assert first == "none 0 unknown" and "install the wheel" in second


def test_the_readme_of_the_package_runs() -> None:
    text = (ROOT / "README.md").read_text()
    section = text.split("## From Python", 1)[1].split("\n## ", 1)[0]
    code = section.split("```python\n", 1)[1].split("```", 1)[0]
    assert len(code.splitlines()) <= 14
    ended = subprocess.run(
        [sys.executable, "-c", code],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr
    assert example("cabinet", "photo.png").is_file()
