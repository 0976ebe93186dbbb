"""One photo to one checked, simulation-ready articulated asset.

:func:`make` does the whole of it, :func:`articulate` the part between a mesh and its joints, in arrays,
and :func:`check` says how far any URDF or MJCF model gets, whoever wrote it.

Every error is a :class:`KinfoldError` with hints. Stages, and what a person should know, go to the logger
``kinfold``.
"""

from typing import TYPE_CHECKING

from . import _kinfold
from ._apart import PATH as _apart_path

if TYPE_CHECKING:
    from ._arrays import Mesh, read_mesh
    from ._articulation import Articulation, Joint, Note, Part, articulate
    from ._asset import Asset
    from ._batch import Batch, Result
    from ._condition import Condition, condition_schema
    from ._errors import (
        ArticulateError,
        ConditionError,
        InputError,
        InternalError,
        Interrupted,
        KinfoldError,
        MeshError,
        MissingError,
        ProviderError,
        RunError,
        ServiceError,
        TierError,
    )
    from ._evaluate import Evaluation, evaluate
    from ._fix import Change, Fix, Left, fix
    from ._make import Progress, make
    from ._providers import Photo, View
    from ._service import Client, Job, connect
    from ._trace import Stage, Trace
    from ._verdict import Check, Finding, Forecast, Judging, Verdict, check, check_all, forecast

__version__: str = _kinfold.__version__

# Whoever works apart is this program, and never the interpreter once more.
_kinfold.name_apart(_apart_path)

# Files are read when something of theirs is asked for: importing takes as long as loading the module.
_PLACES = {
    "_arrays": ("Mesh", "read_mesh"),
    "_articulation": ("Articulation", "Joint", "Note", "Part", "articulate"),
    "_asset": ("Asset",),
    "_batch": ("Batch", "Result"),
    "_condition": ("Condition", "condition_schema"),
    "_errors": (
        "ArticulateError",
        "ConditionError",
        "InputError",
        "InternalError",
        "Interrupted",
        "KinfoldError",
        "MeshError",
        "MissingError",
        "ProviderError",
        "RunError",
        "ServiceError",
        "TierError",
    ),
    "_evaluate": ("Evaluation", "evaluate"),
    "_fix": ("Change", "Fix", "Left", "fix"),
    "_make": ("Progress", "make"),
    "_providers": ("Photo", "View"),
    "_service": ("Client", "Job", "connect"),
    "_trace": ("Stage", "Trace"),
    "_verdict": ("Check", "Finding", "Forecast", "Judging", "Verdict", "check", "check_all", "forecast"),
}


def __getattr__(name: str) -> object:
    for place, names in _PLACES.items():
        if name in names:
            from importlib import import_module

            module = import_module(f"{__name__}.{place}")
            globals().update({one: getattr(module, one) for one in names})
            return globals()[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


__all__ = [
    "ArticulateError",
    "Articulation",
    "Asset",
    "Batch",
    "Change",
    "Check",
    "Client",
    "Condition",
    "ConditionError",
    "Evaluation",
    "Finding",
    "Fix",
    "Forecast",
    "InputError",
    "InternalError",
    "Interrupted",
    "Job",
    "Joint",
    "Judging",
    "KinfoldError",
    "Left",
    "Mesh",
    "MeshError",
    "MissingError",
    "Note",
    "Part",
    "Photo",
    "Progress",
    "ProviderError",
    "Result",
    "RunError",
    "ServiceError",
    "Stage",
    "TierError",
    "Trace",
    "Verdict",
    "View",
    "__version__",
    "articulate",
    "check",
    "check_all",
    "condition_schema",
    "connect",
    "evaluate",
    "fix",
    "forecast",
    "make",
    "read_mesh",
]
