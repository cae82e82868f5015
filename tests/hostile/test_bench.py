"""Hostile files and requests against the workbench as it is served: nothing outside is read, used or told to exist.

Two witnesses: Python's audit hook sees every file that is opened or listed; and every case is asked twice, once with the file that it names and once
without, so that the answers tell whether there was one. `python -m tests.hostile.test_bench` prints the count.
"""

from __future__ import annotations

import contextlib
import os
import re
import socket
import sys
import threading
from collections.abc import Iterator
from http.client import HTTPConnection
from pathlib import Path

import pytest

from tests.hostile.bench_corpus import (
    BODIES,
    CANARY,
    NEXT,
    RAW,
    SECRETS,
    SLOTS,
    Files,
    Question,
    body_of,
    file_cases,
    odd_names,
)
from tests.plate import edited
from vcmm.core.confinement import confine
from vcmm.core.errors import VcmmError
from vcmm.core.text import raw_bytes
from vcmm.face.workbench.bench import Bench
from vcmm.face.workbench.server import WorkbenchServer
from vcmm.files.own.cut_scenario import load_cut
from vcmm.files.own.recording import load_recording
from vcmm.files.own.scenario import load_scenario

OPENED: list[str] = []
sys.addaudithook(
    lambda event, a: OPENED.append(str(a[0])) if event in ("open", "os.listdir", "os.scandir") else None
)
REFUSED = (400, 403, 404, 413, 414, 422, 431, 501, 505)


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WorkbenchServer]:
    path = edited(tmp_path_factory.mktemp("served"), ("trials = 20000", "trials = 1000"))
    with WorkbenchServer(Bench(load_scenario(path, knobs=False), path)) as made:
        threading.Thread(target=made.serve_forever, daemon=True).start()
        yield made
        made.shutdown()


@pytest.fixture
def outside(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder beside those in which dropped files are laid out, empty as yet."""
    folder = tmp_path_factory.mktemp("near")
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    (folder / "outside").mkdir()
    return folder / "outside"


def ask(server: WorkbenchServer, question: Question) -> tuple[int, str]:
    line = HTTPConnection("127.0.0.1", server.server_address[1], timeout=120)
    try:
        line.request("POST", question.path, body_of(question), {"X-Token": server.token})
        answer = line.getresponse()
        return answer.status, answer.read().decode()
    finally:
        line.close()


def drop(server: WorkbenchServer, files: Files, outside: Path) -> tuple[int, str]:
    """Status and words, the temporary folder left out. Fails where a file outside was opened or listed meanwhile."""
    OPENED.clear()
    code, said = ask(server, Question("/job", {"job": "", "knobs": {}, "files": files}))
    touched = [o for o in OPENED if os.path.realpath(o).startswith(str(outside))]
    assert touched == []
    return code, re.sub(r"/[^ \"]*?/vcmm-[a-z0-9_]+", "", said)


@pytest.mark.thorough
def test_files_outside_are_not_read_used_or_told(server: WorkbenchServer, outside: Path) -> None:
    without = {name: drop(server, files, outside) for name, files in file_cases(outside)}
    for name, text in SECRETS.items():
        (outside / name).write_text(text)
    for name, files in file_cases(outside):
        code, said = drop(server, files, outside)
        assert code == 422, (name, said)
        assert CANARY not in said, name
        assert (code, said) == without[name], name
    assert len(without) >= 100


@pytest.mark.parametrize("slot", SLOTS)
def test_the_same_key_with_a_file_inside_is_read(slot: str, tmp_path: Path) -> None:
    """The cases are no nonsense: the file that the key names is opened where it lies among those that were dropped."""
    file, make = SLOTS[slot]
    for name, text in (SECRETS | make(f'"given/{file}"')).items():
        (tmp_path / name).write_text(text)
    (tmp_path / "given").mkdir()
    for name, text in SECRETS.items():
        (tmp_path / "given" / name).write_text(text)
    OPENED.clear()
    with confine(tmp_path), contextlib.suppress(VcmmError):
        if "r.toml" in make('""'):
            load_recording(tmp_path / "r.toml")
        else:
            raw_bytes(load_cut(tmp_path / "boss.toml").program)  # which the reader only looks for
    assert any(o.endswith(f"given/{file}") for o in OPENED)


def test_names_that_are_none_of_a_dropped_file(server: WorkbenchServer, outside: Path) -> None:
    for name, files in odd_names():
        code, said = drop(server, files, outside)
        assert code == 422, (name, said)
        assert "root:" not in said


@pytest.mark.parametrize("name", BODIES)
def test_a_question_that_is_none_is_refused(
    server: WorkbenchServer, name: str, capfd: pytest.CaptureFixture[str]
) -> None:
    code, said = ask(server, BODIES[name])
    assert code in REFUSED, said
    assert said.startswith('{"error": "')
    assert "Traceback" not in capfd.readouterr().err
    assert ask(server, Question("/state", {}))[0] == 200


@pytest.mark.parametrize("name", RAW)
def test_a_request_that_is_none_is_refused_once(
    server: WorkbenchServer, name: str, capfd: pytest.CaptureFixture[str]
) -> None:
    port = server.server_address[1]
    put_in = lambda text: text.replace("HOST", f"127.0.0.1:{port}").replace("PORT", str(port)).replace("TOKEN", server.token).replace("\n", "\r\n")  # noqa: E731  # fmt: skip
    text = put_in(RAW[name]).replace("LENGTH", str(len(put_in(NEXT))))
    with socket.create_connection(("127.0.0.1", port), timeout=20) as line:
        line.sendall(text.encode())
        line.shutdown(socket.SHUT_WR)
        whole = b""
        while piece := line.recv(65536):
            whole += piece
    answer = whole.decode()
    codes = [int(c) for c in re.findall(r"HTTP/1\.[01] (\d{3})", answer)]
    assert len(codes) == 1, answer[:400]
    assert codes[0] in REFUSED, answer[:400]
    assert '{"error": "' in answer
    assert not re.search(r"python|<html|<!doctype", answer, re.IGNORECASE)
    assert "Traceback" not in capfd.readouterr().err


def count() -> dict[str, int]:
    """How many cases there are, by kind."""
    return {
        "files that name a file outside, each with it and without it": len(list(file_cases(Path("/x")))),
        "files that name a device, a process, an address or no file": len(list(odd_names())),
        "questions with the token and a wrong body": len(BODIES),
        "requests": len(RAW),
    }


if __name__ == "__main__":
    for kind, number in count().items():
        print(f"{number:4d}  {kind}")
    print(f"{sum(count().values()):4d}  in all")
