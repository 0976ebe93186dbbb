"""The program of the wheel that works apart."""

from __future__ import annotations

import os
import sys

_NAME = "kinfold-apart.exe" if sys.platform == "win32" else "kinfold-apart"
PATH = os.path.join(os.path.dirname(os.path.abspath(__file__)), "apart", _NAME)


def program() -> str:
    """Its path.

    Raises:
        RunError: where the package came without it.
    """
    from ._errors import RunError

    if not os.access(PATH, os.X_OK):
        raise RunError(
            f"{PATH}: expected the program that checks in a process of its own, found none",
            hints=["install the wheel of your platform; from sources, `.ci/python wheel` builds it"],
        )
    return PATH
