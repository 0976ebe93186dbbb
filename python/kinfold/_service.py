"""A service that makes assets elsewhere: what ``kinfold serve`` answers, asked from Python."""

from __future__ import annotations

import http.client
import json
import logging
import os
import shutil
import tempfile
import threading
import time
import urllib.parse
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, NoReturn

from . import _kinfold
from ._arrays import PathLike, as_file, path_text, whole_number
from ._asset import Asset
from ._condition import Condition, condition_text
from ._errors import ConditionError, InputError, KinfoldError, RunError, ServiceError
from ._html import table
from ._make import Progress, shown

if TYPE_CHECKING:
    from ._providers import Photo

logger = logging.getLogger("kinfold")

#: The longest pause between two tries, seconds: a guess at how soon a person wants to hear of a service that
#: is back.
_PAUSE = 2.0
#: States after which nothing more becomes of a job.
_OVER = ("accepted", "rejected", "failed")


def connect(url: str, token: str | None = None, *, timeout: float = 60.0, patience: float = 60.0) -> Client:
    """Reaches a service, and looks whether it answers.

    Everything that is asked of it may be asked again: a file is kept once, and the same question is the same
    job. So a service that is started anew, or cannot be reached for a while, costs time and nothing else.

    Args:
        url: its address, such as ``"http://127.0.0.1:7412"``; https, unless it is of this machine.
        token: the token; what ``KINFOLD_TOKEN`` of the environment holds without.
        timeout: how long an answer may take, seconds.
        patience: how long one that cannot be reached is tried again, seconds.

    Raises:
        InputError: what is no address, or no token.
        ServiceError: where it does not answer, or refuses the token.
    """
    client = Client(url, token, timeout=timeout, patience=patience)
    client.about()
    return client


class Client:
    """A service; :func:`connect` makes one. Threads may share it."""

    def __init__(
        self, url: str, token: str | None = None, *, timeout: float = 60.0, patience: float = 60.0
    ) -> None:
        said = os.environ.get("KINFOLD_TOKEN", "") if token is None else token
        if not isinstance(said, str) or not said or not said.isascii() or not said.isprintable():
            hint = "`kinfold serve` prints it; or set KINFOLD_TOKEN"
            raise InputError("token: expected the token of the service, found none", hints=[hint])
        self._secure, self._host, self._port, self._base = _address(url)
        self.url = url.rstrip("/")
        self._token = said
        self._timeout, self._patience = _seconds("timeout", timeout), _seconds("patience", patience)
        self._most: int | None = None
        self._lines, self._lock = threading.local(), threading.Lock()
        self._open: set[http.client.HTTPConnection] = set()

    def close(self) -> None:
        """Hangs up; what is asked afterwards connects anew."""
        with self._lock:
            lines, self._open = self._open, set()
        for line in lines:
            line.close()

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        if hasattr(self, "_open"):
            self.close()

    def about(self) -> dict[str, Any]:
        """What the service makes, and what this token may still ask for and spend."""
        told: dict[str, Any] = json.loads(self._asked("GET", "/v1/about"))
        self._most = told.get("most_bytes")
        return told

    def submit(
        self,
        photo: PathLike | bytes | Photo | None = None,
        *,
        mesh: Any = None,
        condition: Condition | Mapping[str, Any] | str | PathLike | None = None,
        seed: int | None = None,
        min_confidence: float | None = None,
        category: str | None = None,
        license: str | None = None,
    ) -> Job:
        """Asks for an asset. The same question is the same job, however often it is asked.

        Args:
            photo: a file's path or its bytes; not needed where mesh and condition are given.
            mesh: a mesh file's path or bytes; or what :func:`kinfold.make` takes. What lies beside a file is
                not sent: a GLB has all in one.
            condition: a :class:`kinfold.Condition`, its dictionary or JSON, or a file's path.
            seed: of everything random; the service's without.
            min_confidence: the probability asked for that every part and joint is right.
            category: what it is, for the service's report.
            license: the photo's licence.

        Raises:
            InputError: what was given cannot be used, or is longer than the service takes.
            ServiceError: the service cannot be reached, or has too many jobs of this token already.
        """
        order: dict[str, Any] = {}
        if photo is not None:
            order["photo"] = self._sent("photo", _photo_bytes(photo))
        if mesh is not None:
            content, is_obj = _mesh_bytes(mesh)
            order["mesh"] = {"digest": self._sent("mesh", content), "obj": is_obj}
        if condition is not None:
            order["condition"] = json.loads(condition_text(condition))
        if seed is not None:
            order["seed"] = whole_number("seed", seed, 0, 2**63 - 1)
        named = {"min_confidence": min_confidence, "category": category, "license": license}
        order.update({name: value for name, value in named.items() if value is not None})
        try:
            body = json.dumps(order, allow_nan=False).encode()
        except (TypeError, ValueError) as error:
            raise InputError(f"submit: {error}") from None
        return Job(self, json.loads(self._asked("POST", "/v1/jobs", body, "application/json")))

    def job(self, id: str) -> Job:
        """A job by its id.

        Raises:
            ServiceError: where this token has no such job.
        """
        return Job(self, json.loads(self._asked("GET", f"/v1/jobs/{_quoted('id', id)}")))

    def jobs(self) -> Iterator[Job]:
        """This token's jobs, the newest first."""
        before = ""
        while True:
            page = json.loads(self._asked("GET", f"/v1/jobs?most=100{before}"))["jobs"]
            yield from (Job(self, told) for told in page)
            if len(page) < 100:
                return
            before = f"&before={_quoted('id', page[-1]['id'])}"

    def _sent(self, what: str, content: bytes) -> str:
        # Before it is sent: whoever is told in the midst of it may not hear why.
        most = self._most or self.about().get("most_bytes")
        if most is not None and len(content) > most:
            raise InputError(f"{what}: the service takes files of at most {most} bytes, found {len(content)}")
        try:
            told = json.loads(self._asked("POST", "/v1/files", content, "application/octet-stream"))
        except InputError as error:
            raise type(error)(f"{what}: {error.message}", error.causes, error.hints) from None
        digest: str = told["digest"]
        if digest != _kinfold.digest(content):
            raise ServiceError(
                f"{what}: the service kept other bytes than were sent", hints=["send it again"]
            )
        return digest

    def _asked(self, method: str, path: str, body: bytes | None = None, kind: str = "") -> bytes:
        """The answer to a question, asked until somebody answers it."""
        until, pause = time.monotonic() + self._patience, 0.05
        while True:
            wait: float | None
            try:
                status, headers, content = self._once(method, path, body, kind)
            except (OSError, http.client.HTTPException) as error:
                self._hung_up()
                wait, failed = (
                    pause,
                    ServiceError(
                        f"{self.url} does not answer: {type(error).__name__}: {error}",
                        hints=["is `kinfold serve` running there? patience= waits longer"],
                    ),
                )
            else:
                if status < 300:
                    return content
                later = headers.get("Retry-After", "")
                # Where nobody says when to come again, it is no trouble of the moment.
                wait = float(later) if status in (429, 503) and later.isdigit() else None
                wait = pause if status == 408 else wait
                failed = _error(status, content)
            if wait is None or time.monotonic() + wait > until:
                raise failed
            logger.info("%s: trying again in %.2g s", failed.message, wait)
            time.sleep(wait)
            pause = min(2 * pause, _PAUSE)

    def _once(
        self, method: str, path: str, body: bytes | None, kind: str
    ) -> tuple[int, http.client.HTTPMessage, bytes]:
        line: http.client.HTTPConnection | None = getattr(self._lines, "line", None)
        if line is None:
            line = self._lines.line = self._line()
            with self._lock:
                self._open.add(line)
        line.request(method, self._base + path, body, self._headers(kind))
        answer = line.getresponse()
        content = answer.read()
        if answer.will_close:
            self._hung_up()
        return answer.status, answer.headers, content

    def _line(self) -> http.client.HTTPConnection:
        kind = http.client.HTTPSConnection if self._secure else http.client.HTTPConnection
        return kind(self._host, self._port, timeout=self._timeout)

    def _hung_up(self) -> None:
        line: http.client.HTTPConnection | None = getattr(self._lines, "line", None)
        if line is not None:
            line.close()
            self._lines.line = None
            with self._lock:
                self._open.discard(line)

    def _headers(self, kind: str) -> dict[str, str]:
        return {"Authorization": f"Bearer {self._token}"} | ({"Content-Type": kind} if kind else {})

    def _news(self, path: str) -> Iterator[dict[str, Any]]:
        """How a job stands, whenever that changes, over a connection of its own; ends when that does."""
        line = self._line()
        try:
            line.request("GET", self._base + path, headers=self._headers(""))
            answer = line.getresponse()
            if answer.status >= 300:
                raise _error(answer.status, answer.read())
            while text := answer.readline(1 << 24):
                if text.startswith(b"data:"):
                    yield json.loads(text[5:])
        finally:
            line.close()

    def __repr__(self) -> str:
        return f"Client({self.url!r})"

    def __reduce__(self) -> NoReturn:
        # Its token would go wherever the bytes go.
        raise TypeError("a client is not pickled: connect again where it is needed")


class Job:
    """A job of a service, as it stood when it was last heard of."""

    def __init__(self, client: Client, told: dict[str, Any]) -> None:
        self._client, self._told = client, told

    @property
    def id(self) -> str:
        """Its id: the same for the same question."""
        return str(self._told["id"])

    @property
    def state(self) -> str:
        """``"queued"``, ``"running"``, ``"accepted"``, ``"rejected"`` or ``"failed"``."""
        return str(self._told["state"])

    @property
    def is_over(self) -> bool:
        """Whether nothing more becomes of it."""
        return self.state in _OVER

    @property
    def tier(self) -> str | None:
        """The tier that its asset reaches."""
        tier: str | None = self._told["tier"]
        return tier

    @property
    def reason(self) -> str | None:
        """Why it is not accepted, or which passing trouble it met while it waits."""
        reason: str | None = self._told["reason"] or self._told["trouble"]
        return reason

    @property
    def files(self) -> dict[str, str]:
        """The files that it left: digests by path."""
        return dict(self._told["files"])

    def to_dict(self) -> dict[str, Any]:
        """Everything that the service says of it."""
        copied: dict[str, Any] = json.loads(json.dumps(self._told))
        return copied

    def refresh(self) -> Job:
        """Asks how it stands now; returns itself."""
        self._told = self._client.job(self.id)._told
        return self

    def wait(
        self,
        timeout: float | None = None,
        *,
        progress: Callable[[Progress], object] | bool | None = None,
    ) -> Job:
        """Waits until it is over; returns itself. Ctrl-C leaves it to the service, which goes on.

        Args:
            timeout: how long at most, seconds; for ever without.
            progress: called with a :class:`kinfold.Progress` for every stage; ``True`` shows a bar of tqdm's.

        Raises:
            TimeoutError: where it takes longer.
            ServiceError: where the service cannot be reached for longer than it is waited for.
        """
        until = None if timeout is None else time.monotonic() + _seconds("timeout", timeout)
        show, close = shown(progress)
        try:
            while not self.is_over:
                self._follow(until, show)
                if self.is_over:
                    break
                if until is not None and time.monotonic() >= until:
                    raise TimeoutError(f"job {self.id} is {self.state} after {timeout} s")
                # The line was cut: whoever answers next, if anybody does, says how it stands.
                self.refresh()
        except KeyboardInterrupt as error:
            error.add_note(f"hint: the service goes on; client.job({self.id!r}) finds it again")
            raise
        finally:
            close()
        return self

    def _follow(self, until: float | None, show: Callable[[Progress], object]) -> None:
        try:
            for told in self._client._news(f"/v1/jobs/{self.id}/events"):
                self._told = told
                stage, state = told["stage"] or told["state"], told["state"]
                show(Progress(stage, state, told["done"], told["of"]))
                if until is not None and time.monotonic() >= until:
                    return
        except (OSError, http.client.HTTPException, ValueError) as error:
            logger.info("job %s: %s; asking again", self.id, error)
            time.sleep(0.1)

    def raise_for_state(self) -> Job:
        """Returns itself if it was accepted.

        Raises:
            RunError: with the reason, if it was not.
        """
        if self.state == "accepted":
            return self
        hints = {
            "queued": ["job.wait() waits for it"],
            "running": ["job.wait() waits for it"],
            "rejected": ["job.download(folder) brings what was made all the same"],
        }
        said = f": {self.reason}" if self.reason else ""
        raise RunError(f"job {self.id} is {self.state}{said}", hints=hints.get(self.state, ()))

    def read(self, path: str) -> bytes:
        """The bytes of one of its files, such as ``"asset.urdf"``.

        Raises:
            ServiceError: where it left no such file, or its bytes are not those of its digest.
        """
        digest = self.files.get(path)
        if digest is None:
            known = ", ".join(self.files) or "none yet"
            raise InputError(f"job {self.id} left no file {path!r}; there are {known}")
        content = self._client._asked("GET", f"/v1/jobs/{self.id}/artefacts/{digest}")
        if _kinfold.digest(content) != digest:
            raise ServiceError(f"{path}: the service sent other bytes than it names", hints=["ask again"])
        return content

    def download(self, folder: PathLike) -> Asset:
        """Brings its asset into a folder that is not there yet, or is empty.

        Raises:
            RunError: where it has none.
            InputError: where something stands in the folder.
        """
        if "asset.urdf" not in self.files:
            self.raise_for_state()
            raise ServiceError(f"job {self.id} left no asset")
        place = Path(path_text("folder", folder))
        if place.exists() and not (place.is_dir() and not any(place.iterdir())):
            raise InputError(f"{place}: expected a new or an empty folder", hints=["name another one"])
        place.parent.mkdir(parents=True, exist_ok=True)
        # All of it or nothing stands there.
        draft = Path(tempfile.mkdtemp(prefix=".kinfold-", dir=place.parent))
        try:
            for name in self.files:
                file = draft / _inside(name)
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_bytes(self.read(name))
            draft.chmod(0o755)
            if place.exists():
                place.rmdir()
            draft.rename(place)
        except BaseException:
            shutil.rmtree(draft, ignore_errors=True)
            raise
        return Asset(place)

    def _repr_html_(self) -> str:
        rows = [[name, digest[:12]] for name, digest in self.files.items()]
        said = f": {self.reason}" if self.reason else ""
        return table(["file", "digest"], rows, f"job {self.id}: {self.state}{said}")

    def __repr__(self) -> str:
        return f"Job({self.id!r}, state={self.state!r})"


def _address(url: object) -> tuple[bool, str, int | None, str]:
    """Whether it is https, the host, the port and what stands before every path."""
    hint = 'such as "http://127.0.0.1:7412", or "https://kinfold.example.org"'
    if not isinstance(url, str):
        raise InputError(f"url: expected an address, found {type(url).__name__}", hints=[hint])
    try:
        parts = urllib.parse.urlsplit(url)
        port = parts.port
    except ValueError as error:
        raise InputError(f"url: {error}", hints=[hint]) from None
    odd = parts.query or parts.fragment or parts.username or parts.password
    if parts.scheme not in ("http", "https") or not parts.hostname or odd:
        raise InputError(
            "url: expected http or https and a host, and neither query nor password", hints=[hint]
        )
    if parts.scheme == "http" and parts.hostname not in ("127.0.0.1", "localhost", "::1"):
        hint = "put something before the service that speaks TLS, and name that with https"
        raise InputError(
            f"url: over http the token of {parts.hostname} would be read on the way", hints=[hint]
        )
    return parts.scheme == "https", parts.hostname, port, parts.path.rstrip("/")


def _seconds(what: str, seconds: object) -> float:
    if isinstance(seconds, bool) or not isinstance(seconds, (int, float)) or not 0 < seconds < 1e9:
        raise InputError(f"{what}: expected seconds above 0, found {seconds!r}")
    return float(seconds)


def _quoted(what: str, text: object) -> str:
    if not isinstance(text, str) or not text:
        raise InputError(f"{what}: expected a text, found {text!r}")
    return urllib.parse.quote(text, safe="")


def _photo_bytes(photo: Any) -> bytes:
    if isinstance(photo, (bytes, bytearray, memoryview)):
        return bytes(photo)
    png = getattr(photo, "png", None)
    return png if isinstance(png, bytes) else _file("photo", photo)


def _mesh_bytes(mesh: Any) -> tuple[bytes, bool]:
    if isinstance(mesh, (bytes, bytearray, memoryview)):
        return bytes(mesh), False
    if isinstance(mesh, (str, os.PathLike)):
        name = path_text("mesh", mesh)
        return _file("mesh", name), name.lower().endswith(".obj")
    return as_file(mesh), False


def _file(what: str, path: object) -> bytes:
    name = path_text(what, path)
    try:
        if not os.path.isfile(name):
            found = "a folder" if os.path.isdir(name) else "none"
            raise InputError(f"{name}: expected a file for {what}=, found {found}")
        return Path(name).read_bytes()
    except OSError as error:
        raise InputError(f"{name}: {error.strerror}") from error


def _inside(name: str) -> Path:
    """A path of a file inside an asset, or why it is none: what a service names is a stranger's word."""
    path = PurePosixPath(name)
    odd = path.is_absolute() or ".." in path.parts or not path.parts or any(c in name for c in "\\:\0")
    if odd:
        raise ServiceError(f"the service names a file {name!r}, which would not stand in the folder")
    return Path(*path.parts)


def _error(status: int, content: bytes) -> KinfoldError:
    try:
        told = json.loads(content)
        message, hint = str(told["error"]["message"]), told["error"].get("hint")
        faults = [str(fault["message"]) for fault in told.get("faults", ())]
    except (ValueError, KeyError, TypeError):
        message, hint, faults = f"the service answered with status {status}", None, []
    hints = [str(hint)] if hint else []
    if faults:
        return ConditionError(message, faults, hints)
    if status in (400, 413, 415, 422):
        return InputError(message, hints=hints)
    error = ServiceError(message, hints=hints)
    error.status = status
    return error
