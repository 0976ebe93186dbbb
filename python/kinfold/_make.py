"""One photo to one checked asset."""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from . import _kinfold
from ._arrays import Mesh, PathLike, Up, as_file, names_of, path_text, up_axis, whole_number
from ._asset import Asset
from ._condition import Condition, condition_text
from ._errors import InputError, KinfoldError, MissingError, ProviderError, RunError
from ._providers import Photo, Providers, View, identity
from ._verdict import tier_name

if TYPE_CHECKING:
    from ._verdict import Tier

logger = logging.getLogger("kinfold")

EXPORTS = ("urdf", "mjcf", "usd", "usdz", "glb", "sdf", "ros", "isaaclab", "simready")


class Progress(NamedTuple):
    """What became of a stage.

    Attributes:
        stage: its name, such as ``"articulate"``.
        state: ``"running"``, ``"again"``, ``"done"``, ``"kept"`` (found among finished ones) or ``"failed"``.
        done: how many stages are over.
        total: how many there are.
    """

    stage: str
    state: str
    done: int
    total: int


def make(
    photo: PathLike | None = None,
    *,
    mesh: Any = None,
    condition: Condition | Mapping[str, Any] | str | PathLike | None = None,
    image_to_3d: Callable[..., Any] | None = None,
    vlm: Callable[..., Any] | None = None,
    out: PathLike | None = None,
    export: Iterable[str] | str = (),
    tier: Tier = "kinematic",
    min_confidence: float | None = None,
    up: Up | None = None,
    snap: bool = False,
    seed: int = 0,
    state: PathLike | None = None,
    config: PathLike | None = None,
    trust_config: bool = False,
    policy: str = "any",
    clock: str | int | None = None,
    wait: bool = True,
    deadline: float = 1800.0,
    progress: Callable[[Progress], object] | bool | None = None,
) -> Asset:
    """Makes a checked, simulation-ready asset of one photo: ``kinfold make``, with the same bytes.

    Mesh and condition come from what is given, else from one's own callables, else from whom
    ``kinfold.toml`` names. Finished stages are kept: the same call goes on where one was stopped. Ctrl-C
    stops at once and leaves what stood in the folder as it was.

    Args:
        photo: the photo's path; not needed where mesh and condition are given.
        mesh: a mesh file's path; or vertices and faces as a pair, a trimesh or Open3D mesh, a
            :class:`kinfold.Mesh`.
        condition: a :class:`kinfold.Condition`, its dictionary or JSON, or a file's path.
        image_to_3d: called with a :class:`kinfold.Photo`, and the seed if it takes two, where no mesh is
            given. It answers with a mesh file's path or bytes, a trimesh mesh, or vertices and faces; y up.
        vlm: called with a :class:`kinfold.Photo`, and :class:`kinfold.View` pictures if it takes two, where
            no condition is given. It answers with a condition in any form above.
        out: the folder; ``<photo>.kinfold`` beside the working folder's files without.
        export: formats besides URDF: mjcf, usd, usdz, glb, sdf, ros, isaaclab, simready.
        tier: the tier asked for. An asset below it is returned all the same, and takes no better one's
            place: ``asset.raise_for_tier()``.
        min_confidence: the probability asked for that every part and joint is right.
        up: the up axis of the mesh and the condition's points; what the condition says, else y.
        snap: whether points of the condition that lie off the mesh are moved onto it.
        seed: of everything random.
        state: where finished stages are kept; ``~/.cache/kinfold`` without.
        config: a ``kinfold.toml``; whoever names it approves it.
        trust_config: whether one that is found acts this once without approval.
        policy: what the asset is meant for, such as ``"commercial-eu"``. A callable says what its licence
            allows with an attribute ``allowed``; one that does not is refused.
        clock: the time written into the trace, for runs that repeat byte for byte.
        wait: whether another run in the folder is waited for.
        deadline: how many seconds a callable may take for an answer.
        progress: called with a :class:`Progress` for every stage; ``True`` shows a bar of tqdm's.

    Raises:
        InputError: what was given cannot be used.
        ProviderError: a callable raised, took too long, or answered with what is no answer.
        RunError: it could not be made; a trace says how far it went.
    """
    given = dict(locals())
    import tempfile

    with tempfile.TemporaryDirectory(prefix="kinfold-", ignore_cleanup_errors=True) as scratch:
        words = _words(given, scratch)
        own = (
            None if image_to_3d is None else identity("image_to_3d", image_to_3d),
            None if vlm is None else identity("vlm", vlm),
            _seconds(deadline),
        )
        notice, closing = _notices(progress)
        providers = Providers(image_to_3d, vlm, scratch)
        try:
            _, told, remarks = _kinfold.make(words, notice, providers.ask, own)
        except KeyboardInterrupt as error:
            error.add_note("hint: finished stages are kept: the same call goes on from there")
            raise
        except KinfoldError as error:
            named = _named(error, providers.raised, scratch)
            raise named from providers.raised if isinstance(named, ProviderError) else error.__cause__
        finally:
            closing()
    answer: dict[str, Any] = json.loads(told)
    for remark in remarks:
        logger.warning("%s", remark)
    answer["remarks"] = remarks
    return Asset(Path(answer["urdf"]).parent, told=answer)


def _named(error: KinfoldError, raised: BaseException | None, scratch: str) -> KinfoldError:
    """The same error, with what was given in memory called by what it is, not by the file it was put into.

    Where a callable is what a run failed of, it is a provider's.
    """
    answer = os.path.join(scratch, "answer-")

    def told(words: str) -> str:
        for file in ("condition.json", "mesh.glb"):
            words = words.replace(os.path.join(scratch, file), f"the {file.partition('.')[0]}")
        before, found, after = words.partition(answer)
        return f"{before}the answer of image_to_3d{after.partition('.glb')[2]}" if found else words

    is_provider = isinstance(error, RunError) and ("python/1 " in str(error) or answer in str(error))
    kind = ProviderError if is_provider else type(error)
    hints = [*(getattr(raised, "hints", ()) if is_provider else ()), *error.hints]
    return kind(told(error.message), [*map(told, error.causes)], [*map(told, hints)])


def _words(given: dict[str, Any], scratch: str) -> list[str]:
    photo, mesh, condition = given["photo"], given["mesh"], given["condition"]
    if mesh is not None and given["image_to_3d"] is not None:
        raise InputError("mesh and image_to_3d: one of them makes the mesh, found both")
    if condition is not None and given["vlm"] is not None:
        raise InputError("condition and vlm: one of them gives the condition, found both")
    if photo is None and (mesh is None or condition is None):
        hint = "give the photo, or both mesh= and condition="
        raise InputError("make: there is no photo", hints=[hint])
    words = [
        "--json",
        "--quiet",
        f"--tier={made_tier(given['tier'])}",
        f"--seed={whole_number('seed', given['seed'], 0, 2**64 - 1)}",
    ]
    up: Up | None = None if given["up"] is None else up_axis(given["up"])
    if mesh is not None:
        words.append(f"--mesh={_mesh_file(mesh, scratch, given['out'], photo)}")
        up = up or (mesh.up if isinstance(mesh, Mesh) and mesh.up == "z" else None)
        words += [f"--up={up}"] if up else []
    if condition is not None:
        words.append(f"--condition={_condition_file(condition, scratch, up)}")
        words += ["--snap"] if given["snap"] else []
    exports = given["export"]
    names = names_of("export", exports)
    if unknown := [name for name in names if name not in EXPORTS]:
        known = ", ".join(EXPORTS)
        raise InputError(f"export: expected some of {known}, found {unknown[0]!r}")
    words += [f"--export={','.join(names)}"] if names else []
    for flag in ("out", "state", "config"):
        words += [f"--{flag}={path_text(flag, given[flag])}"] if given[flag] is not None else []
    words += [f"--clock={given['clock']}"] if given["clock"] is not None else []
    if given["min_confidence"] is not None:
        words.append(f"--min-confidence={given['min_confidence']}")
    words += ["--trust-config"] if given["trust_config"] else []
    words += [] if given["wait"] else ["--no-wait"]
    policy = given["policy"]
    for what in ("image_to_3d", "vlm"):
        if given[what] is not None and policy != "any":
            _permitted(what, given[what], str(policy))
    words.append(f"--policy={policy}")
    return [*words, "--", path_text("photo", photo)] if photo is not None else words


def _permitted(what: str, provider: object, policy: str) -> None:
    """Refuses a callable of which nobody says that it may be used for this: unknown is never a pass."""
    allowed = names_of(f"{what}.allowed", getattr(provider, "allowed", ()))
    if missing := [word for word in policy.split("-") if word not in allowed]:
        raise InputError(
            f"{what}: not with the policy `{policy}`: nobody says that its licence allows "
            + " and ".join(missing),
            hints=['say it with an attribute of the callable, such as allowed = ["commercial", "eu"]'],
        )


def made_tier(tier: object) -> str:
    if (name := tier_name(tier)) == "audited":
        raise InputError("tier: expected a tier up to dynamic, found 'audited'")
    return name


def _seconds(deadline: object) -> float:
    if isinstance(deadline, bool) or not isinstance(deadline, (int, float)) or not deadline > 0:
        raise InputError(f"deadline: expected seconds above 0, found {deadline!r}")
    return float(deadline)


def _mesh_file(mesh: Any, scratch: str, out: object, photo: object) -> str:
    if isinstance(mesh, (str, bytes, os.PathLike)):
        return path_text("mesh", mesh)
    if out is None and photo is None:
        hint = "name the folder with out="
        raise InputError("make: a mesh in memory has no name that the asset could have", hints=[hint])
    path = os.path.join(scratch, "mesh.glb")
    with open(path, "wb") as file:
        file.write(as_file(mesh))
    return path


def _condition_file(condition: Any, scratch: str, up: Up | None) -> str:
    is_text = isinstance(condition, str) and condition.lstrip()[:1] == "{"
    if isinstance(condition, (str, os.PathLike)) and not is_text:
        return path_text("condition", condition)
    path = os.path.join(scratch, "condition.json")
    with open(path, "w", encoding="utf-8") as file:
        file.write(condition_text(condition, up=up))
    return path


Notice = Callable[[str, str, int], None]


def _notices(progress: Any) -> tuple[Notice, Callable[[], None]]:
    """What is told of every stage, and what is done at the end."""
    over: set[str] = set()
    show, close = shown(progress)

    def notice(stage: str, state: str, total: int) -> None:
        if state in ("done", "kept", "failed"):
            over.add(stage)
        logger.info("%s: %s", stage, state)
        show(Progress(stage, state, len(over), max(total, len(over))))

    return notice, close


def shown(progress: Any) -> tuple[Callable[[Progress], object], Callable[[], None]]:
    """Where progress is told, and what is done at the end."""
    if progress is None or progress is False:
        return (lambda _: None), (lambda: None)
    if progress is not True:
        if not callable(progress):
            kind = type(progress).__name__
            raise InputError(f"progress: expected a callable or True, found {kind}")
        return progress, (lambda: None)
    try:
        from tqdm.auto import tqdm
    except ImportError:
        raise MissingError("progress=True needs tqdm", hints=["pip install tqdm"]) from None
    bar = tqdm(unit="stage")

    def show(told: Progress) -> None:
        bar.total = told.total
        bar.n = told.done
        bar.set_description(told.stage)

    return show, bar.close


__all__ = ["EXPORTS", "Photo", "Progress", "View", "make"]
