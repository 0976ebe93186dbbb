"""The examples in the documentation run."""

from __future__ import annotations

import doctest
import importlib
from pathlib import Path

import kinfold
import pytest
from conftest import example

MODULES = (
    "_arrays _articulation _asset _batch _condition _evaluate _fix _make _providers _service _trace _verdict"
)


@pytest.mark.parametrize("name", MODULES.split())
def test_examples_run(
    name: str, made: kinfold.Asset, mesh: kinfold.Mesh, condition: kinfold.Condition, tmp_path: Path
) -> None:
    given = {"kinfold": kinfold, "folder": made.path, "mesh": mesh, "condition": condition}
    given |= {"photo": example("cabinet", "photo.png"), "scratch": tmp_path}
    flags = doctest.ELLIPSIS | doctest.IGNORE_EXCEPTION_DETAIL
    found = doctest.testmod(importlib.import_module(f"kinfold.{name}"), extraglobs=given, optionflags=flags)
    assert found.failed == 0
    assert found.attempted or name in ("_arrays", "_evaluate", "_make", "_providers", "_service")
