"""The server of the workbench: this machine only, one token, small requests, no paths from the browser.

Listens on 127.0.0.1. Every request must name this host and port (so that no other site can reach it by a name of its own),
and every question must bear the token of the page, which no other page can read. Dropped files are read in a temporary
folder under its plain file name. Standard library only.

The page of the workbench: the answer first, the knobs beside it (below it on a narrow screen), pictures, sweep, files, live scenes.
"""

from __future__ import annotations

import json
import re
import secrets
import socket
import sys
import tempfile
from collections.abc import Callable, Mapping
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib import resources
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

from vcmm.core.errors import Environment, UsageError, VcmmError
from vcmm.face.workbench.bench import Bench, GivenUp, diagnose_files
from vcmm.show.report.page import asset, scripts
from vcmm.show.report.palette import css_variables
from vcmm.show.report.text import escape

SCENES = ("Part in the machine", "Touches and their standard uncertainty")
TOOLS = """<div class="tools" role="toolbar" aria-label="what to do with the knobs">
<button type="button" id="undo" title="Ctrl+Z" disabled>Undo</button><button type="button" id="redo" title="Ctrl+Y" disabled>Redo</button>
<button type="button" id="reset" title="all knobs as in the file">Reset</button>
<button type="button" id="pin" title="keep these figures beside those that follow" disabled>Pin as A</button>
<button type="button" id="swap" title="turn the knobs to A, and pin these figures" hidden>Exchange A and B</button>
<button type="button" id="save" title="the scenario with these knobs">Save as TOML</button>
<progress id="progress" max="1" aria-label="progress" hidden></progress><button type="button" id="cancel" hidden>Cancel</button></div>"""
ANSWER = """<section class="answer" aria-label="the answer"><div class="scroll"><table>
<thead><tr><th>characteristic</th><th>value</th><th>U</th><th>decision</th><th>largest contributor</th><th class="pinned">A</th></tr></thead>
<tbody id="rows"></tbody></table></div></section>"""
SWEEP = """<div class="tools" style="margin-top:1.2rem"><label>U against <select id="along" aria-label="knob of the sweep"></select></label>
<button type="button" id="sweep">Sweep</button><button type="button" id="measure">Measure once</button><button type="button" id="place">Place the part</button></div><div id="swept"></div>"""
FILES = """<div class="drop" id="drop"><span id="said" role="status">Drop files or a folder here: one recording is diagnosed, \
several calibrate the machine file beside them, a scenario with [cut] is cut, points or \
values (.csv) of this task are evaluated. All of it stays on this machine.</span>
<span class="tools" style="margin:.6rem 0 0"><select id="what" aria-label="what to do with the files"><option value="">as the files say</option><option>diagnose</option>\
<option>calibrate</option><option>evaluate</option><option>cut</option></select>\
<button type="button" id="files">Files…</button><button type="button" id="folder">Folder…</button></span>
<input type="file" id="chosen" multiple hidden><input type="file" id="whole" webkitdirectory hidden></div><div id="found"></div>
<div class="tools"><button type="button" id="keep" hidden>Save the report</button></div><iframe id="report" class="report" title="report" sandbox="allow-scripts" hidden></iframe>"""


def _own(name: str) -> str:
    return resources.files("vcmm.face.workbench").joinpath(name).read_text(encoding="utf-8")


def bench_page(name: str, token: str) -> str:
    """Return the whole page. The token is for its own questions; no other page can read it."""
    given = json.dumps({"token": token}).replace("<", "\\u003c")
    figures = "".join(
        f'<figure class="figure live-scene"><figcaption>{escape(title)}</figcaption><div class="picture row"><div class="scene" tabindex="0" role="group" aria-label="{escape(title)}" '
        f'style="height:420px"><div class="live"></div></div></div></figure>'
        for title in SCENES
    )
    style = css_variables() + asset("style.css") + _own("workbench.css")
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1"><meta name="color-scheme" content="light dark">'
        f"<title>{escape(name)}: workbench</title><style>{style}</style></head><body>"
        f'<header><h1>{escape(name)}</h1><p class="subtitle" id="status" role="status">connecting</p></header><main>'
        f'<div class="bench">{ANSWER}<div class="side">{TOOLS}<form class="knobs" aria-label="knobs"></form></div>'
        f'<div class="more"><div class="pictures" id="pictures"></div>{SWEEP}{figures}{FILES}</div></div></main>'
        f'<script type="application/json" id="given">{given}</script>{scripts()}<script>{_own("workbench.js")}</script></body></html>'
    )


HOST = "127.0.0.1"
LARGEST = 20_000_000  # bytes of a request: what a recording of 10^5 rows has
MOST_FILES = 20
LENGTH = re.compile(r"[0-9]{1,10}")
PLAIN = re.compile(
    r"[A-Za-z0-9][A-Za-z0-9 _.-]{0,99}(/[A-Za-z0-9][A-Za-z0-9 _.-]{0,99}){0,4}"
)  # perhaps in folders
FOREIGN_ADDRESS = "this workbench answers to its own address only"
Answer = Callable[[Mapping[str, Any]], dict[str, Any]]
POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:; connect-src 'self'"


class WorkbenchServer(ThreadingHTTPServer):
    """Holds the bench and the token. Environment: the port is taken."""

    daemon_threads = True
    allow_reuse_address = False

    def __init__(self, bench: Bench, port: int = 0) -> None:
        self.bench, self.token = bench, secrets.token_urlsafe(24)
        try:
            super().__init__((HOST, port), Handler)
        except OSError as error:
            raise Environment(
                f"port {port} cannot be used ({error.strerror}); another workbench may have it: name another one with --port, or 0 for any"
            ) from None
        self.origin = f"http://{HOST}:{self.server_address[1]}"

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore a page that was closed or reloaded, which is no fault; report everything else."""
        if not isinstance(sys.exception(), (ConnectionError, TimeoutError)):
            super().handle_error(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        """Read and discard the remaining request for a second at most: if closed before, the system would discard the answer."""
        with suppress(OSError):
            request.shutdown(socket.SHUT_WR)
            request.settimeout(1.0)
            left = LARGEST
            while left > 0 and (piece := request.recv(65536)):
                left -= len(piece)
        self.close_request(request)

    @property
    def address(self) -> str:
        """Address to open in a browser."""
        return f"{self.origin}/?token={self.token}"


class Handler(BaseHTTPRequestHandler):
    """GET / with the token: the page. POST a question (`do_POST`) with the token: JSON."""

    server: WorkbenchServer
    protocol_version = "HTTP/1.1"
    server_version = "vcmm"
    sys_version = ""
    timeout = 60

    def parse_request(self) -> bool:
        """Parse as the base class, and return False after a refusal of a request whose body has no single length: the rest is no request."""
        if not super().parse_request():
            return False
        if self.request_version == "HTTP/0.9" or len(self.headers.get_all("Host", [])) != 1:
            self.send_error(400, "a request states its version of HTTP and one Host")
            return False
        lengths = self.headers.get_all("Content-Length", [])
        if "Transfer-Encoding" in self.headers or len(lengths) > 1:
            self.send_error(400, "a request has one Content-Length and no Transfer-Encoding")
            return False
        if self.command != "POST":
            if lengths and lengths[0] != "0":
                self.send_error(400, "only questions (POST) have a body")
                return False
            return True
        length = lengths[0] if lengths else ""
        if not LENGTH.fullmatch(length) or int(length) > LARGEST:
            self.send_error(413, f"a question states its length, at most {LARGEST / 1e6:.0f} MB")
            return False
        return True

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """Send a refusal as JSON; the connection is closed, since the rest may belong to a request that was not read."""
        self.close_connection = True
        if not hasattr(self, "request_version") or self.request_version == "HTTP/0.9":
            self.request_version = "HTTP/1.1"
        self._refuse(code, message or "this request cannot be answered")

    def do_GET(self) -> None:
        """Answer with the page, and nothing else."""
        address = urlsplit(self.path)
        given = parse_qs(address.query).get("token", [""])[0]
        if not self._is_ours():
            self._refuse(403, FOREIGN_ADDRESS)
        elif address.path != "/":
            self._refuse(404, "there is one page only")
        elif not self._knows(given):
            self._refuse(403, "open the address that vcmm serve prints")
        else:
            page = bench_page(self.server.bench.scenario.name, self.server.token)
            self._send(200, "text/html; charset=utf-8", page)

    def do_POST(self) -> None:
        """Answer a question of the page. Its body is read whole before anything is answered: a refused one is no further request."""
        length = int(self.headers["Content-Length"])
        content = self.rfile.read(length)
        answers: dict[str, Answer] = {
            "/state": self._state, "/preview": self._preview, "/settled": self._settle, "/diagnose": self._diagnose,
            "/sweep": self._sweep, "/save": self._save, "/progress": self._progress, "/cancel": self._cancel,
            "/job": self._job,
        }  # fmt: skip
        if len(content) < length:
            self.send_error(400, "the question is shorter than it states")
        elif not self._is_ours():
            self._refuse(403, FOREIGN_ADDRESS)
        elif not self._knows(self.headers.get("X-Token", "")):
            self._refuse(
                403, "the token is not that of this workbench; open the address that vcmm serve prints"
            )
        elif self.path not in answers:
            self._refuse(404, "there is no such question")
        elif (body := self._object(content)) is not None:
            self._answer(answers[self.path], body)

    def _answer(self, answer: Answer, body: Mapping[str, Any]) -> None:
        try:
            self._send(200, "application/json", json.dumps(answer(body), allow_nan=False, default=_plain))
        except GivenUp:
            self._send(200, "application/json", json.dumps({"given_up": True}))
        except VcmmError as error:
            self._refuse(422, str(error))
        except (KeyError, TypeError, ValueError, AttributeError, RecursionError, OverflowError):
            self._refuse(422, "the question is not of the right form")

    def _knows(self, token: str) -> bool:
        return secrets.compare_digest(token.encode(), self.server.token.encode())

    def _state(self, _body: Mapping[str, Any]) -> dict[str, Any]:
        return self.server.bench.state()

    def _preview(self, body: Mapping[str, Any]) -> dict[str, Any]:
        return self.server.bench.preview(body["knobs"], _page(body))

    def _settle(self, body: Mapping[str, Any]) -> dict[str, Any]:
        return self.server.bench.settle(body["knobs"], _page(body))

    def _sweep(self, body: Mapping[str, Any]) -> dict[str, Any]:
        return self.server.bench.sweep(body["knobs"], str(body["knob"]), _page(body))

    def _save(self, body: Mapping[str, Any]) -> dict[str, Any]:
        return self.server.bench.text_with_knobs(body["knobs"])

    def _progress(self, body: Mapping[str, Any]) -> dict[str, Any]:
        return self.server.bench.progress(_page(body))

    def _cancel(self, body: Mapping[str, Any]) -> dict[str, Any]:
        return self.server.bench.cancel(_page(body))

    def _diagnose(self, body: Mapping[str, Any]) -> dict[str, Any]:
        with tempfile.TemporaryDirectory(prefix="vcmm-") as folder:
            diagnosis = diagnose_files(_files(body["files"]), Path(folder))
        return {
            "verdict": diagnosis["verdict"],
            "sentences": diagnosis["said"],
            "answer": diagnosis["answer"],
        }

    def _job(self, body: Mapping[str, Any]) -> dict[str, Any]:
        files = _files(body["files"]) if body.get("files") else {}
        with tempfile.TemporaryDirectory(prefix="vcmm-") as folder:
            return self.server.bench.job(str(body["job"]), files, Path(folder), body["knobs"], _page(body))

    def _is_ours(self) -> bool:
        """Return whether host and origin are this server's own."""
        host, origin = self.headers.get("Host", ""), self.headers.get("Origin")
        return f"http://{host}" == self.server.origin and origin in (None, self.server.origin)

    def _object(self, content: bytes) -> Mapping[str, Any] | None:
        """Return the JSON object of a question, or None after a refusal."""
        try:
            value = json.loads(content)
        except (ValueError, RecursionError):
            value = None
        if not isinstance(value, dict):
            self._refuse(400, "expected a JSON object")
            return None
        return value

    def _refuse(self, code: int, text: str) -> None:
        self._send(code, "application/json", json.dumps({"error": text}))

    def _send(self, code: int, kind: str, text: str) -> None:
        content = text.encode("utf-8")
        self.send_response(code)
        for name, value in {
            "Content-Type": kind, "Content-Length": str(len(content)), "Content-Security-Policy": POLICY,
            "X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer", "Cache-Control": "no-store",
            "X-Frame-Options": "DENY", "Connection": "close" if self.close_connection else "keep-alive",
        }.items():  # fmt: skip
            self.send_header(name, value)
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)

    def log_message(self, format: str, *args: Any) -> None:
        """Log nothing: the terminal shows the address only."""


def _files(given: Any) -> dict[str, bytes]:
    """Return dropped files by name. UsageError: too many, or names that are none of a file in a folder below."""
    files = dict(given)
    if not 0 < len(files) <= MOST_FILES:
        raise UsageError(f"{len(files)} files; 1 to {MOST_FILES} are taken")
    if any(not PLAIN.fullmatch(n) for n in files):
        raise UsageError("a dropped file needs a plain name: letters, digits, dots, dashes")
    return {n: str(t).encode() for n, t in files.items()}


def _page(body: Mapping[str, Any]) -> str:
    """Return which open page asks: a short text of its own choice."""
    return str(body.get("page", ""))[:40]


def _plain(value: Any) -> Any:
    """Return numbers of numpy as those of Python."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} has no JSON form")
