"""What is dropped on the workbench reads nothing of this machine but itself, and no request is taken for two.

The judge is Python's own audit hook: every file that this process opens is noted, whoever opens it.
"""

from __future__ import annotations

import os
import re
import socket
import sys
import tempfile
import threading
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import pytest

from vcmm.core.errors import VcmmError
from vcmm.face.workbench.bench import Bench, diagnose_files
from vcmm.face.workbench.server import WorkbenchServer
from vcmm.files.own.library import example
from vcmm.files.own.scenario import load_scenario

OPENED: list[str] = []
sys.addaudithook(
    lambda event, a: OPENED.append(str(a[0])) if event in ("open", "os.listdir", "os.scandir") else None
)

MACHINE = """vcmm = "machine/1"
kind = "cmm"
structure = "w b Y X Z t"
[axes.X]
travel = ["0 mm", "600 mm"]
[axes.Y]
travel = ["0 mm", "500 mm"]
[axes.Z]
travel = ["-400 mm", "0 mm"]
"""
ROWS = (
    "X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,u_um\n"
    + "\n".join(f"{i},0,0,1,0,0,0.{i % 7},0.3" for i in range(40))
    + "\n"
)
TABLES = {
    "machine": 'machine = {0}\ndata = "a.csv"\n',
    "data": 'machine = "m.toml"\ndata = {0}\n',
    "after an apostrophe": 'machine = "m.toml" # it\'s\ndata = {0}\n',
    "series": 'machine = "m.toml"\ndata = "a.csv"\nseries = [{{ data = "it\'s.csv" }}, {{ data = {0} }}]\n',
    "one series": 'machine = "m.toml"\ndata = "a.csv"\n[[series]]\ndata = {0}\n',
    "known": 'machine = "m.toml"\ndata = "a.csv"\n[known]\ndata = {0}\n',
}
QUOTES = ('"{0}"', "'{0}'", '"""\n{0}"""', "'''\n{0}'''")
SUFFIXES = ("m.toml", "m.txt", "m.TOML", "m")


@pytest.fixture
def secret(tmp_path: Path) -> Path:
    """A folder beside the one that is read in, with files that would be taken if they could be."""
    folder = tmp_path / "secret"
    folder.mkdir()
    (folder / "m.toml").write_text(MACHINE)
    (folder / "a.csv").write_text(ROWS)
    (folder / "t.csv").write_text("time_s,temp_air_C\n0,20\n100,21\n")
    (folder / "errors.csv").write_text("X EXX\n0 0\n600 0.001\n")
    return folder


def hostile(secret: Path, exists: bool) -> Iterator[tuple[str, dict[str, bytes]]]:
    """(name, dropped files) that name a file outside in one way each."""
    ending = "" if exists else "x"
    for (key, text), quotes in product(TABLES.items(), QUOTES):
        target = {"machine": "m.toml", "series": "t.csv", "one series": "t.csv"}.get(key, "a.csv")
        for name in (
            f"{secret / target}{ending}",
            f"../secret/{target}{ending}",
            f"./x/../../secret/{target}{ending}",
        ):
            head = 'vcmm = "recording/1"\nkind = "probe"\n' + text.format(quotes.format(name))
            yield (
                f"{key} {quotes!r} {name}",
                {"r.toml": head.encode(), "m.toml": MACHINE.encode(), "a.csv": ROWS.encode()},
            )
    for suffix, quotes in product(SUFFIXES, QUOTES):
        table = quotes.format(f"{secret / 'errors.csv'}{ending}")
        machine = f"{MACHINE}[errors]\ntable = {table}\n"
        head = f'vcmm = "recording/1"\nkind = "probe"\nmachine = "{suffix}"\ndata = "a.csv"\n'
        yield (
            f"table of {suffix} {quotes!r}",
            {"r.toml": head.encode(), suffix: machine.encode(), "a.csv": ROWS.encode()},
        )


def answers(secret: Path, exists: bool) -> dict[str, str]:
    """Name -> what is said of it; "" where it was taken. Nothing outside may be opened meanwhile."""
    out = {}
    for name, files in hostile(secret, exists):
        with tempfile.TemporaryDirectory(dir=secret.parent) as folder:
            OPENED.clear()
            try:
                diagnose_files(files, Path(folder))
                out[name] = ""
            except VcmmError as error:
                out[name] = str(error).replace(folder, "")
            touched = [o for o in OPENED if os.path.realpath(o).startswith(str(secret))]
            assert not touched, (name, touched)
    return out


def test_nothing_outside_is_read_or_said_to_exist(secret: Path) -> None:
    there, not_there = answers(secret, True), answers(secret, False)
    assert len(there) == 88
    for (name, said), (_, other) in zip(there.items(), not_there.items()):
        assert "outside the given files" in said, name
        said, other = (re.sub(r"(m\.toml|a\.csv|t\.csv|errors\.csv)x?", "F", s) for s in (said, other))
        assert said == other, name
        assert "secret" not in said, name


@pytest.mark.thorough
def test_the_same_files_inside_are_read(tmp_path: Path) -> None:
    head = 'vcmm = "recording/1"\nkind = "probe"\nmachine = "m.txt"\ndata = "a.csv"\n'
    files = {"r.toml": head.encode(), "m.txt": MACHINE.encode(), "a.csv": ROWS.encode()}
    assert diagnose_files(files, tmp_path)["verdict"]


@pytest.fixture(scope="module")
def server() -> Iterator[WorkbenchServer]:
    with WorkbenchServer(Bench(load_scenario(example("ring_gauge")))) as made:
        threading.Thread(target=made.serve_forever, daemon=True).start()
        yield made
        made.shutdown()


def raw(server: WorkbenchServer, request: str) -> tuple[list[int], str]:
    """(codes of all answers that come back, everything) to bytes as they stand."""
    text = request.replace("HOST", f"127.0.0.1:{server.server_address[1]}").replace("TOKEN", server.token)
    with socket.create_connection(("127.0.0.1", server.server_address[1]), timeout=10) as line:
        line.sendall(text.replace("\n", "\r\n").encode())
        line.shutdown(socket.SHUT_WR)
        whole = b""
        while piece := line.recv(65536):
            whole += piece
    answer = whole.decode()
    return [int(c) for c in re.findall(r"HTTP/1\.1 (\d{3})", answer)], answer


HEAD = "POST /state HTTP/1.1\nHost: HOST\nX-Token: TOKEN\n"
SECOND = "GET /?token=TOKEN HTTP/1.1\nHost: HOST\n\n"
REQUESTS = {
    "a length of 5000 digits": (HEAD + "Content-Length: " + "1" * 5000 + "\n\n{}", 413),
    "a length below zero": (HEAD + "Content-Length: -1\n\n{}", 413),
    "a length of other digits": (HEAD + "Content-Length: ²\n\n{}", 413),
    "no length": (HEAD + "\n{}", 413),
    "too long": (HEAD + "Content-Length: 99999999\n\n" + SECOND, 413),
    "two lengths": (HEAD + "Content-Length: 2\nContent-Length: 60\n\n{}" + SECOND, 400),
    "chunks": (HEAD + "Transfer-Encoding: chunked\n\n0\n\n" + SECOND, 400),
    "GET with a body": ("GET / HTTP/1.1\nHost: HOST\nContent-Length: 60\n\n" + SECOND, 400),
    "no such method": ("BREW / HTTP/1.1\nHost: HOST\n\n", 501),
    "HEAD": ("HEAD / HTTP/1.1\nHost: HOST\n\n", 501),
    "PUT": ("PUT / HTTP/1.1\nHost: HOST\n\n", 501),
    "OPTIONS": ("OPTIONS / HTTP/1.1\nHost: HOST\n\n", 501),
    "an older protocol": ("GET / HTTP/9.9\nHost: HOST\n\n", 505),
    "a bad first line": ("GET / x y HTTP/1.1\n\n", 400),
    "a long address": ("GET /" + "a" * 70000 + " HTTP/1.1\nHost: HOST\n\n", 414),
    "many headers": ("GET / HTTP/1.1\n" + "".join(f"A{i}: 1\n" for i in range(200)) + "\n", 431),
}


@pytest.mark.parametrize("name", REQUESTS)
def test_a_wrong_request_has_one_answer_in_json(
    server: WorkbenchServer, name: str, capfd: pytest.CaptureFixture[str]
) -> None:
    request, code = REQUESTS[name]
    codes, answer = raw(server, request)
    assert codes == [code]
    assert "Python" not in answer
    assert "<html" not in answer.lower()
    assert "application/json" in answer
    assert "Traceback" not in capfd.readouterr().err


def test_a_refused_body_is_no_further_request(server: WorkbenchServer) -> None:
    """The token is wrong: the body is read and thrown away; the second request behind it has an answer of its own."""
    size = len(
        SECOND.replace("HOST", f"127.0.0.1:{server.server_address[1]}")
        .replace("TOKEN", server.token)
        .replace("\n", "\r\n")
    )
    codes, _ = raw(
        server, f"POST /state HTTP/1.1\nHost: HOST\nX-Token: x\nContent-Length: {size}\n\n" + SECOND
    )
    assert codes == [403]
