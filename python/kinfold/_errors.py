"""What can go wrong, in one hierarchy. Each says what is wrong, why, and what to do about it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._verdict import Verdict


class KinfoldError(Exception):
    """Anything that kinfold raises on purpose.

    ``message`` is the rule and what was found, ``causes`` what lies behind it, outermost first, and
    ``hints`` what to do about it: the words that the command line prints.
    """

    message: str
    causes: tuple[str, ...]
    hints: tuple[str, ...]

    def __init__(self, message: str, causes: Sequence[str] = (), hints: Sequence[str] = ()) -> None:
        self.message, self.causes, self.hints = message, tuple(causes), tuple(hints)
        super().__init__(message, self.causes, self.hints)
        for hint in self.hints:
            self.add_note(f"hint: {hint}")

    def __str__(self) -> str:
        return ": ".join([self.message, *self.causes])


class InputError(KinfoldError, ValueError):
    """Something that was given cannot be used."""


class MeshError(InputError):
    """A mesh, or arrays that are meant as one, break a rule."""


class ConditionError(InputError):
    """A condition breaks a rule, or does not fit its mesh. ``causes`` has every fault."""


class RunError(KinfoldError, RuntimeError):
    """It could not be done."""


class ArticulateError(RunError):
    """No parts and joints could be found."""


class ProviderError(RunError):
    """One's own provider raised, took too long, or answered with what is no answer.

    ``__cause__`` is what it raised.
    """


class TierError(RunError):
    """A verdict or an asset is below the tier asked for. ``verdict`` says why."""

    verdict: Verdict | None = None


class MissingError(RunError, ImportError):
    """Something else has to be installed first."""


class Interrupted(RunError):
    """The run was stopped before its end; the same call goes on from there."""


class InternalError(KinfoldError):
    """A fault of kinfold's own."""
