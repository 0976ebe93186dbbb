"""What can go wrong, in one hierarchy. Each says what is wrong, why, and what to do about it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._verdict import Verdict


#: Arguments that the command line names otherwise: those that are said or not, and those with a value.
_SAID = {
    "allow-outside": "allow_outside=True",
    "flags": "flags=True",
    "no-wait": "wait=False",
    "pages": "pages=True",
    "snap": "snap=True",
    "trust-config": "trust_config=True",
    "write": "write=True",
}
_VALUED = (
    "articulator clock condition condition-price config deadline export filter jobs max-calls max-cost mesh "
    "mesh-price min-confidence mode only out points policy retry seed state tier up waive without"
).split()
#: Whole phrases, before single flags.
_PHRASES = {
    "or ask a server of your own with --vlm URL --model NAME": "or give a callable that says it, with vlm=",
    "(`kinfold schema condition` prints the format)": "(`kinfold.condition_schema()` is the format)",
    "the same command": "the same call",
}


def in_python(words: str) -> str:
    """What the command line says, with its flags called as Python's arguments are. Commands stay commands."""
    if "--" not in words and not any(phrase in words for phrase in _PHRASES):
        return words
    import re

    for phrase, instead in _PHRASES.items():
        words = words.replace(phrase, instead)

    def named(found: re.Match[str]) -> str:
        flag = found["flag"]
        if flag in _SAID:
            return _SAID[flag]
        return flag.replace("-", "_") + "=" if flag in _VALUED else found[0]

    # A flag, with the capitals that stand for its value; not one of a longer word.
    flag = r"(?<![\w-])--(?P<flag>[a-z]+(?:-[a-z]+)*)(?:[ =](?:<[A-Z.]+>|[A-Z]+\b(?:[./=][A-Za-z]+)*))?"
    # What stands between backquotes is a command, or somebody's words.
    parts = words.split("`")
    parts[::2] = [re.sub(flag, named, part) for part in parts[::2]]
    return "`".join(parts)


class KinfoldError(Exception):
    """Anything that kinfold raises on purpose.

    ``message`` is the rule and what was found, ``causes`` what lies behind it, outermost first, and
    ``hints`` what to do about it: the words that the command line prints, with its flags called as Python's
    arguments are.
    """

    message: str
    causes: tuple[str, ...]
    hints: tuple[str, ...]

    def __init__(self, message: str, causes: Sequence[str] = (), hints: Sequence[str] = ()) -> None:
        self.message = in_python(message)
        self.causes, self.hints = tuple(map(in_python, causes)), tuple(map(in_python, hints))
        super().__init__(self.message, self.causes, self.hints)
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


class ServiceError(RunError):
    """A service does not answer, or not as it should. ``status`` is its answer's, where there is one."""

    status: int | None = None


class TierError(RunError):
    """A verdict or an asset is below the tier asked for. ``verdict`` says why."""

    verdict: Verdict | None = None


class MissingError(RunError, ImportError):
    """Something else has to be installed first."""


class Interrupted(RunError):
    """The run was stopped before its end; the same call goes on from there."""


class InternalError(KinfoldError):
    """A fault of kinfold's own."""
