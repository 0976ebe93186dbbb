"""One's own callables as providers: ``photo → mesh``, and ``photo, views → condition``."""

from __future__ import annotations

import io
import os
import threading
import types
import weakref
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from . import _kinfold
from ._arrays import as_file
from ._condition import condition_text
from ._errors import InputError

if TYPE_CHECKING:
    from PIL.Image import Image


class Photo(NamedTuple):
    """A picture that a callable is asked about: upright, at most 2048 pixels a side, without metadata.

    Attributes:
        png: the picture as a PNG file.
    """

    png: bytes

    def to_pil(self) -> Image:
        """The picture as Pillow has it."""
        from PIL import Image

        return Image.open(io.BytesIO(self.png))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes it into a file."""
        with open(path, "wb") as file:
            file.write(self.png)


class View(NamedTuple):
    """A picture of the mesh.

    Attributes:
        name: which side, such as ``"front_right"``.
        png: the picture as a PNG file.
    """

    name: str
    png: bytes


#: A callable works for one run at a time, unless it says ``concurrent = True``.
_turns: weakref.WeakKeyDictionary[Any, threading.Lock] = weakref.WeakKeyDictionary()
_turns_lock = threading.Lock()


def identity(what: str, provider: Any) -> str:
    """What a callable is called in a trace: finished answers are found again under it.

    It is ``provider.identity`` where that is a text. A plain function need not say it: it is its name, with a
    digest of its code and of what it closes over, so that another body is another provider. Of an object
    nobody knows what it holds, so it has to say who it is.
    """
    if not callable(provider):
        raise InputError(f"{what}: expected a callable, found {type(provider).__name__}")
    said = getattr(provider, "identity", None)
    if isinstance(said, str):
        if not said.strip() or len(said) > 200:
            raise InputError(f"{what}: expected an identity of 1 to 200 characters, found {len(said)}")
        return f"python/1 {said}"
    import hashlib

    hint = "give it an attribute `identity`, such as its model and version"
    if not isinstance(provider, types.FunctionType):
        raise InputError(f"{what}: {provider!r:.200} does not say who it is", hints=[hint])
    code = provider.__code__
    digest = hashlib.blake2b(digest_size=6)
    _digest(digest, code)
    closure = zip(code.co_freevars, provider.__closure__ or (), strict=True)
    try:
        cells = [(name, cell.cell_contents) for name, cell in closure]
    except ValueError:  # a variable that has no value yet
        raise InputError(f"{what}: {provider!r:.200} is not finished", hints=[hint]) from None
    given = [*enumerate(provider.__defaults__ or ()), *sorted((provider.__kwdefaults__ or {}).items())]
    for name, value in [*cells, *given]:
        if not _is_plain(value):
            kind = type(value).__name__
            raise InputError(
                f"{what}: `{provider.__qualname__}` holds `{name}`, a {kind}: nobody knows which",
                hints=[hint],
            )
        digest.update(repr((name, value)).encode())
    return f"python/1 {provider.__module__}.{provider.__qualname__} {digest.hexdigest()}"


def _is_plain(value: object) -> bool:
    """Whether a value is what its text says."""
    if isinstance(value, tuple):
        return all(_is_plain(one) for one in value)
    return value is None or isinstance(value, (bool, int, float, complex, str, bytes, os.PathLike))


def _digest(digest: Any, code: types.CodeType) -> None:
    digest.update(code.co_code)
    digest.update(repr(code.co_names).encode())
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            _digest(digest, constant)
        elif isinstance(constant, frozenset):
            digest.update(repr(sorted(map(repr, constant))).encode())
        else:
            digest.update(repr(constant).encode())


class Providers:
    """The callables of one run, asked on threads of their own; what they raise is kept."""

    def __init__(
        self,
        mesh: Callable[..., Any] | None,
        condition: Callable[..., Any] | None,
        scratch: str,
    ) -> None:
        self._mesh, self._condition, self._scratch = mesh, condition, scratch
        self._lock, self._count = threading.Lock(), 0
        self.raised: BaseException | None = None

    def ask(self, kind: str, picture: bytes, rest: Any, reply: _kinfold.Reply) -> None:
        """Starts the callable on a question; its answer goes to ``reply``."""
        photo = Photo(picture)
        if kind == "mesh":
            work = lambda: self._mesh_file(_called(self._mesh, photo, rest))  # noqa: E731
            provider = self._mesh
        else:
            views = [View(name, png) for name, png in rest]
            work = lambda: condition_text(_called(self._condition, photo, views))  # noqa: E731
            provider = self._condition
        # One that hangs keeps nobody from leaving.
        thread = threading.Thread(
            target=self._work, args=(provider, work, reply), name=f"kinfold-{kind}", daemon=True
        )
        thread.start()

    def _work(self, provider: Any, work: Callable[[], str], reply: _kinfold.Reply) -> None:
        try:
            with _turn(provider):
                answer = work()
        except BaseException as error:  # the run has to hear of it, whatever it is
            self.raised = error
            reply.refuse(f"raised {type(error).__name__}: {error}")
        else:
            reply.answer(answer)

    def _mesh_file(self, mesh: Any) -> str:
        """A file of whatever a callable answered with."""
        if isinstance(mesh, (bytes, bytearray, memoryview)):
            return self._file(bytes(mesh))
        if isinstance(mesh, (str, os.PathLike)):
            return os.path.abspath(os.fspath(mesh))
        if mesh is None or isinstance(mesh, (int, float, bool)):
            raise InputError(
                f"expected a mesh, found {type(mesh).__name__}",
                hints=["answer with a file's path, its bytes, a trimesh mesh, or (vertices, faces)"],
            )
        return self._file(as_file(mesh))

    def _file(self, content: bytes) -> str:
        with self._lock:
            self._count += 1
            path = os.path.join(self._scratch, f"answer-{self._count}.glb")
        with open(path, "wb") as file:
            file.write(content)
        return path


def _called(provider: Any, photo: Photo, rest: Any) -> Any:
    """Calls with as much as the callable takes."""
    import inspect

    try:
        inspect.signature(provider).bind(photo, rest)
    except TypeError:
        return provider(photo)
    except ValueError:  # it does not say what it takes
        pass
    return provider(photo, rest)


class _turn:
    """One run at a time in a callable."""

    def __init__(self, provider: Any) -> None:
        self._lock: Any = None
        if getattr(provider, "concurrent", False) is True:
            return
        key = getattr(provider, "__func__", provider)
        with _turns_lock:
            try:
                self._lock = _turns.setdefault(key, threading.Lock())
            except TypeError:  # neither hashed nor referred to weakly
                self._lock = None

    def __enter__(self) -> None:
        if self._lock is not None:
            self._lock.acquire()

    def __exit__(self, *_: object) -> None:
        if self._lock is not None:
            self._lock.release()
