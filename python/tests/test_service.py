"""A service asked from Python: the real one, killed in between, and ones that do not keep their word."""

from __future__ import annotations

import json
import pickle
import signal
import sqlite3
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from typing import Any

import kinfold
import pytest
from conftest import example

TOKEN = "a-token-of-some-length"


class Service:
    """``kinfold serve`` of the package, in a folder."""

    def __init__(self, folder: Path, *words: str) -> None:
        self.folder, self.words, self.port = folder, words, 0
        self.token = ""
        self.start()

    def start(self) -> None:
        command = [sys.executable, "-m", "kinfold", "serve", "jobs", "--json", "--quiet", *self.words]
        self.process = subprocess.Popen(
            [*command, f"--port={self.port}"], cwd=self.folder, stdout=subprocess.PIPE, text=True
        )
        assert self.process.stdout is not None
        told = json.loads(self.process.stdout.readline())
        self.url, self.port = told["url"], int(told["url"].rpartition(":")[2])
        assert self.token in ("", told["token"]), "the token outlives the server"
        self.token = told["token"]

    def kill(self, how: int = signal.SIGKILL) -> int:
        self.process.send_signal(how)
        ended = self.process.wait(timeout=60)
        assert self.process.stdout is not None
        self.process.stdout.close()
        return ended

    def connect(self, **words: Any) -> kinfold.Client:
        return kinfold.connect(self.url, self.token, **words)


@pytest.fixture
def service(tmp_path: Path) -> Iterator[Service]:
    running = Service(tmp_path, "--max-upload=8")
    yield running
    if running.process.poll() is None:
        running.kill()


def given() -> dict[str, Any]:
    return {
        "photo": example("cabinet", "photo.png").read_bytes(),
        "mesh": example("cabinet", "mesh.glb"),
        "condition": kinfold.Condition.from_file(example("cabinet", "condition.json")),
    }


def test_a_job_outlives_a_kill_and_is_the_same_when_it_is_asked_for_again(
    tmp_path: Path, service: Service, made: kinfold.Asset
) -> None:
    client = service.connect()
    assert client.about()["tier"] == "kinematic" and client.about()["waiting"] == 0
    job = client.submit(**given(), category="cabinet")
    assert job.state in ("queued", "running") and not job.is_over
    told: list[kinfold.Progress] = []
    waited = threading.Thread(target=lambda: job.wait(300, progress=told.append))
    waited.start()
    while not any(one.stage == "articulate" for one in told) and not job.is_over:
        time.sleep(0.01)
    assert service.kill() == -signal.SIGKILL
    service.start()
    waited.join(300)
    assert job.state == "accepted" and job.tier == "dynamic" and job.reason is None, job.to_dict()
    assert client.submit(**given(), category="cabinet").id == job.id
    assert [one.id for one in client.jobs()] == [job.id] and client.job(job.id).is_over
    asset = job.download(tmp_path / "here")
    assert asset.urdf.read_bytes() == made.urdf.read_bytes() == job.read("asset.urdf")
    assert kinfold.Trace(asset).verify()["holds"] is True
    with pytest.raises(kinfold.InputError, match="an empty folder"):
        job.download(tmp_path / "here")
    with pytest.raises(kinfold.InputError, match="left no file"):
        job.read("../../etc/passwd")
    assert service.kill(signal.SIGTERM) == 0
    ledger = sqlite3.connect(tmp_path / "jobs" / "ledger.sqlite")
    assert ledger.execute("SELECT count(*) FROM outcomes").fetchone() == (1,)
    ledger.close()
    assert "accepted" in job._repr_html_() and job.id in repr(job)


def test_what_cannot_be_used_is_told_with_what_to_do(tmp_path: Path, service: Service) -> None:
    client = service.connect()
    with pytest.raises(kinfold.ServiceError, match="token is missing or wrong") as refused:
        kinfold.connect(service.url, "another-token-of-some-length")
    assert refused.value.status == 401 and "Authorization" in refused.value.hints[0]
    with pytest.raises(kinfold.InputError, match="a photo, or a mesh and a condition"):
        client.submit()
    with pytest.raises(kinfold.InputError, match="nobody makes a mesh here"):
        client.submit(given()["photo"])
    with pytest.raises(
        kinfold.InputError, match="photo: the service takes files of at most 8388608 bytes, found"
    ):
        client.submit(bytes(9 << 20))
    with pytest.raises(kinfold.InputError, match=r"none\.png: expected a file for photo=, found none"):
        client.submit(tmp_path / "none.png")
    with pytest.raises(kinfold.InputError, match="min_confidence is a probability"):
        client.submit(**given(), min_confidence=3.0)
    with pytest.raises(kinfold.ConditionError):
        client.submit(**{**given(), "condition": {"parts": 7}})
    with pytest.raises(kinfold.ServiceError, match="no such job") as unknown:
        client.job("../about")
    assert unknown.value.status == 404
    failed = client.submit(b"no photo", mesh=b"no mesh", condition=given()["condition"]).wait(120)
    with pytest.raises(kinfold.RunError, match="is failed: file"):
        failed.raise_for_state()
    with pytest.raises(kinfold.RunError):
        failed.download(tmp_path / "failed")
    assert not (tmp_path / "failed").exists()


@pytest.mark.parametrize(
    ("url", "token", "words"),
    [
        (7, TOKEN, "expected an address, found int"),
        ("ftp://127.0.0.1", TOKEN, "expected http or https"),
        ("http://127.0.0.1:x", TOKEN, "url: "),
        ("http://me:secret@127.0.0.1", TOKEN, "neither query nor password"),
        ("http://kinfold.example.org", TOKEN, "would be read on the way"),
        ("http://127.0.0.1:1", "", "expected the token"),
        ("http://127.0.0.1:1", "a\r\nX: y", "expected the token"),
    ],
)
def test_no_address_and_no_token_are_told_before_anybody_is_asked(url: Any, token: str, words: str) -> None:
    with pytest.raises(kinfold.InputError, match=words) as error:
        kinfold.connect(url, token)
    assert error.value.hints and TOKEN not in str(error.value)


def test_a_service_that_is_not_there_is_waited_for_as_long_as_is_said() -> None:
    began = time.monotonic()
    with pytest.raises(kinfold.ServiceError, match="does not answer") as error:
        kinfold.connect("http://127.0.0.1:1", TOKEN, patience=0.3)
    assert 0.1 < time.monotonic() - began < 20 and "kinfold serve" in error.value.hints[0]


@pytest.fixture
def liar() -> Iterator[tuple[str, dict[str, Any]]]:
    """A service that answers as a test says, by path."""
    answers: dict[str, Any] = {"/v1/about": {}}

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            answer = answers.get(self.path, b"<html>")
            status, body = answer if isinstance(answer, tuple) else (200, answer)
            content = body if isinstance(body, bytes) else json.dumps(body).encode()
            self.send_response(status)
            self.send_header("Content-Length", str(len(content)))
            if status == 302:
                self.send_header("Location", "http://127.0.0.1:1/elsewhere")
            self.end_headers()
            self.wfile.write(content)

        do_POST = do_GET

        def log_message(self, format: str, *args: Any) -> None:
            pass

    server = HTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_address[1]}", answers
    server.shutdown()
    server.server_close()


@pytest.mark.parametrize("name", ["../outside", "/etc/x", "a\\b", "C:x", "a/../../b", ""])
def test_a_file_that_a_service_names_outside_the_folder_is_not_written(
    tmp_path: Path, liar: tuple[str, dict[str, Any]], name: str
) -> None:
    url, answers = liar
    client = kinfold.connect(url, TOKEN)
    urdf = b"<robot/>"
    digest = kinfold._kinfold.digest(urdf)
    told = {"id": "x", "state": "accepted", "stage": None, "done": 0, "of": 0, "tier": None}
    told |= {"reason": None, "trouble": None, "files": {"asset.urdf": digest, name: digest}}
    answers["/v1/jobs/x"] = told
    answers[f"/v1/jobs/x/artefacts/{digest}"] = urdf
    with pytest.raises(kinfold.ServiceError, match="would not stand in the folder"):
        client.job("x").download(tmp_path / "a" / "here")
    assert list((tmp_path / "a").iterdir()) == []


def test_bytes_that_are_not_those_of_their_digest_are_refused(
    tmp_path: Path, liar: tuple[str, dict[str, Any]]
) -> None:
    url, answers = liar
    client = kinfold.connect(url, TOKEN)
    told = {
        "id": "x",
        "state": "accepted",
        "reason": None,
        "trouble": None,
        "files": {"asset.urdf": "0" * 64},
    }
    answers["/v1/jobs/x"] = told
    answers[f"/v1/jobs/x/artefacts/{'0' * 64}"] = b"<robot/>"
    with pytest.raises(kinfold.ServiceError, match="other bytes than it names"):
        client.job("x").download(tmp_path / "here")
    assert not (tmp_path / "here").exists()
    answers["/v1/files"] = {"digest": "0" * 64, "bytes": 3}
    with pytest.raises(kinfold.ServiceError, match="kept other bytes"):
        client.submit(b"abc")


def test_a_service_that_sends_elsewhere_or_says_nothing_is_an_error(
    liar: tuple[str, dict[str, Any]],
) -> None:
    url, answers = liar
    client = kinfold.connect(url, TOKEN, patience=0.2)
    answers["/v1/about"] = (302, b"")
    with pytest.raises(kinfold.ServiceError, match="status 302"):
        client.about()
    answers["/v1/about"] = (500, b"\xff\x00")
    with pytest.raises(kinfold.ServiceError, match="status 500"):
        client.about()


def test_a_token_is_neither_shown_nor_pickled(liar: tuple[str, dict[str, Any]]) -> None:
    client = kinfold.connect(liar[0], TOKEN)
    assert TOKEN not in repr(client)
    with pytest.raises(TypeError):
        pickle.dumps(client)
