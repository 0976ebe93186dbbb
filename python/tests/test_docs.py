"""The examples in the documentation run."""

from __future__ import annotations

import doctest
import importlib

import kinfold
import pytest

MODULES = ["_arrays", "_articulation", "_asset", "_condition", "_make", "_providers", "_trace", "_verdict"]


@pytest.mark.parametrize("name", MODULES)
def test_examples_run(
    name: str, made: kinfold.Asset, mesh: kinfold.Mesh, condition: kinfold.Condition
) -> None:
    given = {"kinfold": kinfold, "folder": made.path, "mesh": mesh, "condition": condition}
    flags = doctest.ELLIPSIS | doctest.IGNORE_EXCEPTION_DETAIL
    found = doctest.testmod(importlib.import_module(f"kinfold.{name}"), extraglobs=given, optionflags=flags)
    assert found.failed == 0
    assert found.attempted or name in ("_arrays", "_make", "_providers")
