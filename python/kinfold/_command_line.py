"""The command line of the wheel: the same as the program's."""

from __future__ import annotations

import signal
import sys

from . import _kinfold


def main() -> None:
    """Does what the command line says and ends as it says."""
    # Ctrl-C is heard by whoever works, not by the interpreter.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_kinfold.command_line(["kinfold", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
