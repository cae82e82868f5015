"""Hostile files and requests for the workbench, written from the outside: what is served is known, how it is guarded is not looked at.

Files: every key of a dropped file that may name another one (SLOTS), in every spelling of a path outside (SPELLINGS), and ways of TOML to
hide a key. Requests: bytes as somebody else's program would send them (RAW), and questions with the right token and a wrong body (BODIES).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.shop.machining import shop

CANARY = "canary-4711"
MACHINE = f"""vcmm = "machine/1"
name = "{CANARY}"
kind = "cmm"
structure = "w b Y X Z t"
[axes.X]
travel = ["0 mm", "600 mm"]
[axes.Y]
travel = ["0 mm", "500 mm"]
[axes.Z]
travel = ["-400 mm", "0 mm"]
"""
OURS = MACHINE.replace(CANARY, "ours")
ROWS = "time_s,X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,u_um\n" + "".join(
    f"{i},{i},0,0,1,0,0,0.{i % 7},0.3\n" for i in range(40)
)
HEAD = 'vcmm = "recording/1"\nkind = "probe"\nmachine = "m.toml"\ndata = "a.csv"\n'
SECRETS = {  # what lies outside: all of it would be taken if it could be read
    "m.toml": MACHINE, "a.csv": ROWS, "t.csv": "time_s,temp_air_C\n0,20\n100,21\n", "errors.csv": "X EXX\n0 0\n600 0.001\n",
    "part.nc": shop.PROGRAM.replace("BOSS", CANARY), "setup.toml": shop.SETUP, "job.toml": 'vcmm = "job/1"\ntrials = 1000\n', "sub.nc": f"O7 ({CANARY})\nM99\n",
    "cube.stl": f"solid {CANARY}\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n",
    "points.csv": "x_mm,y_mm,z_mm,nx,ny,nz\n0,0,0,0,0,1\n1,0,0,0,0,1\n0,1,0,0,0,1\n", "cov.csv": "EXX_um\n1\n", "force.csv": "time_s,force_x_N,force_y_N,force_z_N\n0,1,1,1\n9,1,1,1\n",
}  # fmt: skip

Files = dict[str, str]


def recording(more: str = "", head: str = HEAD, machine: str = OURS) -> Files:
    return {"r.toml": head + more, "m.toml": machine, "a.csv": ROWS}


def cutting(**changed: str) -> Files:
    files = {
        "boss.toml": shop.SCENARIO, "mill.toml": shop.MACHINE + '[repeatability]\nu = "1 um"\n', "setup.toml": shop.SETUP, "part.nc": shop.PROGRAM,
    }  # fmt: skip
    for name, edit in changed.items():
        old, new = edit.split(" => ")
        file = {"scenario": "boss.toml", "mill": "mill.toml", "setup": "setup.toml", "nc": "part.nc"}[name]
        assert old in files[file], old
        files[file] = files[file].replace(old, new, 1)
    return files


# the key that names a file: which file of SECRETS it would take, and the dropped files with the name at its place (a TOML value with its quotes)
Slot = tuple[str, Callable[[str], Files]]
SLOTS: dict[str, Slot] = {
    "machine of a recording": ("m.toml", lambda v: recording(head=HEAD.replace('"m.toml"', v))),
    "data of a recording": ("a.csv", lambda v: recording(head=HEAD.replace('"a.csv"', v))),
    "series": ("t.csv", lambda v: recording(f"[[series]]\ndata = {v}\n")),
    "known errors": ("a.csv", lambda v: recording(f"[known]\ndata = {v}\n")),
    "table of errors": ("errors.csv", lambda v: recording(machine=OURS + f"[errors]\ntable = {v}\n")),
    "covariance": ("cov.csv", lambda v: recording(machine=OURS + f'[errors]\ntable = "m.toml"\ncovariance = {v}\n') | {"errors.csv": SECRETS["errors.csv"]}),
    "table in an inline machine": ("errors.csv", lambda v: recording(head=HEAD.replace('"m.toml"', '{ kind = "cmm", structure = "w b Y X Z t", axes = { X = { travel = ["0 mm", "600 mm"] }, Y = { travel = ["0 mm", "500 mm"] }, Z = { travel = ["-400 mm", "0 mm"] } }, errors = { table = ' + v + ' } }'))),
    "machine of a cut": ("m.toml", lambda v: cutting(scenario=f'"mill.toml" => {v}')),
    "program": ("part.nc", lambda v: cutting(scenario=f'"part.nc" => {v}')),
    "set-up": ("setup.toml", lambda v: cutting(scenario=f'"setup.toml" => {v}')),
    "machine of a set-up": ("m.toml", lambda v: cutting(scenario='machine = "mill.toml"\n => ', setup=f'dialect = "fanuc"\n => dialect = "fanuc"\nmachine = {v}\n')),
    "table of a mill": ("errors.csv", lambda v: cutting(mill=f'[axes.X]\n => [errors]\ntable = {v}\n[axes.X]\n')),
    "job in a file": ("job.toml", lambda v: cutting(scenario="[job]\ntrials = 2000\n => ", mill="[axes.X] => [axes.X]") | {"boss.toml": shop.SCENARIO.replace("[job]\ntrials = 2000\n", "").replace('machine = "mill.toml"\n', f'machine = "mill.toml"\njob = {v}\n')}),
    "mesh": ("cube.stl", lambda v: cutting(scenario=f"[part.features]\n => [part]\nmesh = {v}\n[part.features]\n")),
    "nominal points": ("points.csv", lambda v: cutting(scenario=f'[[part.characteristics]]\n => free = {{ type = "points", nominal = {v} }}\n[[part.characteristics]]\n')),
    "force log": ("force.csv", lambda v: cutting(scenario=f'[cut]\n => [cut]\nforce_log = {v}\n')),
    "inspecting machine": ("m.toml", lambda v: cutting(scenario=f'[job]\n => [inspection]\nmachine = {v}\npose = {{ shift = "0 0 0 mm", turn = "0 0 0 deg" }}\n[job]\n')),
    "points of a plan": ("points.csv", lambda v: cutting(scenario=f'[job]\n => [plan]\ntouch = {{ speed = "5 mm/s", approach = "3 mm" }}\nstyli.down = {{ offset = "0 0 -120 mm", tip_diameter = "4 mm" }}\n[[plan.steps]]\nfeature = "boss"\nstylus = "down"\npoints = {v}\n[job]\n')),
}  # fmt: skip

# a name of FILE in the folder OUT as a TOML value; UP is that folder from where the files are dropped
SPELLINGS = {
    "absolute": lambda out, file: f'"{out}/{file}"',
    "climbing": lambda out, file: f'"{"../" * 12}{str(out).lstrip("/")}/{file}"',
    "beside": lambda out, file: f'"../{out.name}/{file}"',
}
MORE_SPELLINGS = {
    "through a folder that is not": lambda out, file: f'"x/../../{out.name}/{file}"',
    "two slashes": lambda out, file: f'"//{str(out).lstrip("/")}//{file}"',
    "dots": lambda out, file: f'"./././../{out.name}/./{file}"',
    "raw text": lambda out, file: f"'{out}/{file}'",
    "text of several lines": lambda out, file: f'"""\n{out}/{file}"""',
    "raw text of several lines": lambda out, file: f"'''\n{out}/{file}'''",
    "a line that goes on": lambda out, file: f'"""{str(out)[:3]}\\\n   {str(out)[3:]}/{file}"""',
    "escaped": lambda out, file: '"' + "".join(f"\\u{ord(c):04x}" for c in f"{out}/{file}") + '"',
    "escaped by eight": lambda out, file: '"' + "".join(f"\\U{ord(c):08x}" for c in f"{out}/{file}") + '"',
    "by this process": lambda out, file: f'"/proc/self/root{out}/{file}"',
    "by the folder of this process": lambda out, file: f'"/proc/self/cwd/{"../" * 12}{str(out).lstrip("/")}/{file}"',
    "in a comment's shadow": lambda out, file: f'"{out}/{file}" # "m.toml"',
}  # fmt: skip
HIDDEN = {  # ways to write a key
    "key in quotes": 'vcmm = "recording/1"\nkind = "probe"\n"machine" = "m.toml"\n"data" = {0}\n',
    "key in single quotes": "vcmm = 'recording/1'\nkind = 'probe'\nmachine = 'm.toml'\n'data' = {0}\n",
    "key by its code": 'vcmm = "recording/1"\nkind = "probe"\nmachine = "m.toml"\n"d\\u0061ta" = {0}\n',
    "dotted": 'vcmm = "recording/1"\nkind = "probe"\nmachine = "m.toml"\ndata = "a.csv"\nknown.data = {0}\n',
    "in a list of tables": 'vcmm = "recording/1"\nkind = "probe"\nmachine = "m.toml"\ndata = "a.csv"\nseries = [ {{ data = {0} }} ]\n',
    "behind an apostrophe": "vcmm = 'recording/1'\nkind = 'probe'\nmachine = 'm.toml' # it's\ndata = {0}\n",
    "behind a text like a table": 'vcmm = "recording/1"\nname = """\n[known]\ndata = "a.csv"\n"""\nkind = "probe"\nmachine = "m.toml"\ndata = {0}\n',
    "carriage returns": 'vcmm = "recording/1"\r\nkind = "probe"\r\nmachine = "m.toml"\r\ndata = {0}\r\n',
    "a mark of byte order": '\ufeffvcmm = "recording/1"\nkind = "probe"\nmachine = "m.toml"\ndata = {0}\n',
}  # fmt: skip
ENDLESS = (
    "/dev/zero", "/dev/stdin", "/dev/tty", "/dev/fd/0", "/proc/self/environ", "/proc/self/maps", "/proc/1/cmdline", "/etc/hostname", "/etc/passwd",
    "~/.bashrc", "$HOME/x.csv", "%2e%2e/x.csv", "file:///etc/hostname", "http://127.0.0.1/x.csv", "..\\\\..\\\\x.csv", "C:\\\\x.csv", "a.csv\\u0000", "x/" * 2000,
    "", ".", "..", "/", "a.csv/../../etc/hostname", "nul", "|ls", "a.csv;ls", "m.toml/..",
)  # fmt: skip
CALLS = {  # programs that call a program outside
    "M98": ("fanuc", "M98 P({0})\n"), "M98 by name": ("fanuc", "M98 <{0}>\n"), "G65": ("fanuc", "G65 <{0}>\n"),
    "EXTCALL": ("sinumerik", 'EXTCALL("{0}")\n'), "EXTCALL by path": ("sinumerik", 'EXTCALL "{0}"\n'), "CALL PGM": ("heidenhain", "1 CALL PGM {0}\n"), "o-word": ("linuxcnc", "o<{0}> call\n"),
}  # fmt: skip


def file_cases(out: Path) -> Iterator[tuple[str, Files]]:
    """(name, dropped files) of every case that names a file of the folder `out`."""
    for slot, (file, make) in SLOTS.items():
        for spelling, write in SPELLINGS.items():
            yield f"{slot}, {spelling}", make(write(out, file))
    for slot in ("data of a recording", "table of errors", "program"):
        file, make = SLOTS[slot]
        for spelling, write in MORE_SPELLINGS.items():
            yield f"{slot}, {spelling}", make(write(out, file))
    for way, text in HIDDEN.items():
        file = "t.csv" if "list" in way else "a.csv"
        yield way, recording(head=text.format(f'"{out}/{file}"'))
    for call, (dialect, line) in CALLS.items():
        body = f"%\nO1\nG21 G90\nT1 M6\n{line.format(out / 'sub.nc')}M30\n%\n"
        yield f"{call} in {dialect}", cutting(setup=f'"fanuc" => "{dialect}"') | {"part.nc": body}
    yield "folders of subprograms", cutting(nc="G21 => M98 P7\nG21", setup=f'dialect = "fanuc"\n => dialect = "fanuc"\nsubprograms = ["{out}"]\n')  # fmt: skip


def odd_names() -> Iterator[tuple[str, Files]]:
    """Names that are none of a dropped file: no job may come of them."""
    for name in ENDLESS:
        yield f'data = "{name[:30]}"', recording(head=HEAD.replace('"a.csv"', f'"{name}"'))


@dataclass(frozen=True)
class Question:
    """A question with the right token and a body that is none: it is refused, and nothing breaks."""

    path: str
    body: Any


def _files(**given: Any) -> Question:
    return Question("/job", {"job": "", "knobs": {}, "files": given})


NAMES = (
    "../x.toml", "/etc/x.toml", "a/../../x.toml", ".hidden.toml", "..", ".", "", "a//b.toml", "a/b/c/d/e/f/g.toml", "x\u0000.toml", "C:\\x.toml", "a\\..\\x.toml",
    "x.toml\n", "x.toml/", "．．／x.toml", "x" * 101, "~x.toml", "$x.toml", "é.toml", "\ud800.toml", " x.toml", "-x.toml", "a/.git/x.toml", "a/ x.toml", "x\t.toml",
)  # fmt: skip
BODIES = {
    **{f"name {n[:20]!r}": Question("/job", {"job": "", "knobs": {}, "files": {n: "vcmm"}}) for n in NAMES},
    "21 files": _files(**{f"f{i}.toml": "" for i in range(21)}),
    "a file and a folder of one name": _files(**{"a": "x", "a/b.toml": "x"}),
    "files as a text": Question("/job", {"job": "", "knobs": {}, "files": "r.toml"}),
    "files as a number": Question("/job", {"job": "", "knobs": {}, "files": 3}),
    "content as a list": _files(**{"r.toml": [1]}),
    "half a character": _files(**{"r.toml": "\ud800"}),
    "a job that is none": Question("/job", {"job": "../serve", "knobs": {}, "files": {"r.toml": "x"}}),
    "a job as a list": Question("/job", {"job": ["diagnose"], "knobs": {}, "files": {"r.toml": "x"}}),
    "no job": Question("/job", {"knobs": {}}),
    "empty files": _files(**{"r.toml": "", "a.csv": ""}),
    "10^5 brackets": _files(**{"r.toml": 'vcmm = "recording/1"\ndata = ' + "[" * 100_000}),
    "a number of 5000 digits": _files(**{"r.toml": f'vcmm = "recording/1"\nkind = {"9" * 5000}\n'}),
    "no knobs": Question("/settled", {}),
    "knobs as a list": Question("/settled", {"knobs": [1, 2]}),
    "knobs as a text": Question("/preview", {"knobs": "x"}),
    "a knob that is none": Question("/preview", {"knobs": {"__class__": 1.0}}),
    "a knob as a text": Question("/preview", {"knobs": {"x": "300"}}),
    "a knob as an object": Question("/settled", {"knobs": {"x": {"y": 1}}}),
    "a knob that is true": Question("/settled", {"knobs": {"x": True}}),
    "a knob that is null": Question("/settled", {"knobs": {"x": None}}),
    "a knob that is no number": Question("/settled", {"knobs": {"x": float("nan")}}),
    "a knob without end": Question("/preview", {"knobs": {"x": float("inf")}}),
    "a knob of 10^400": Question("/preview", {"knobs": {"x": 10**400}}),
    "a knob out of range": Question("/preview", {"knobs": {"touches": 1e9}}),
    "touches by half": Question("/preview", {"knobs": {"touches": 1.5}}),
    "spread below zero": Question("/preview", {"knobs": {"spread": -1.0}}),
    "a sweep of no knob": Question("/sweep", {"knobs": {}, "knob": "../x"}),
    "a sweep of a list": Question("/sweep", {"knobs": {}, "knob": ["x"]}),
    "no sweep": Question("/sweep", {"knobs": {}}),
    "saved to a place": Question("/save", {"knobs": {"path": "/tmp/x.toml"}}),
    "no such question": Question("/../../etc/passwd", {}),
    "the page asked": Question("/", {}),
    "a longer path": Question("/state/..", {}),
    "a path in code": Question("/%73tate", {}),
    "a file by its name": Question("/plate.toml", {}),
}  # fmt: skip

GOOD = "POST /state HTTP/1.1\nHost: HOST\nX-Token: TOKEN\nContent-Length: 2\n\n{}"
PAGE = "GET /?token=TOKEN HTTP/1.1\nHost: HOST\n"
NEXT = PAGE + "\n"
RAW = {  # bytes of a request; HOST and TOKEN are put in
    "another host": GOOD.replace("HOST", "evil.example"), "localhost": GOOD.replace("HOST", "localhost:PORT"), "no host": GOOD.replace("Host: HOST\n", ""),
    "two hosts": GOOD.replace("Host: HOST", "Host: HOST\nHost: evil.example"), "a host with a name before it": GOOD.replace("HOST", "x@HOST"), "a host in capitals of another": GOOD.replace("HOST", "127.1:PORT"),
    "another port": GOOD.replace("HOST", "127.0.0.1:1"), "a foreign origin": GOOD.replace("X-Token", "Origin: http://evil.example\nX-Token"), "no origin": GOOD.replace("X-Token", "Origin: null\nX-Token"),
    "no token": GOOD.replace("X-Token: TOKEN\n", ""), "an empty token": GOOD.replace("TOKEN", ""), "half a token": GOOD.replace("TOKEN", "TOKEN"[:3]), "a token of other letters": GOOD.replace("TOKEN", "é" * 32),
    "the token in the address": "POST /state?token=TOKEN HTTP/1.1\nHost: HOST\nContent-Length: 2\n\n{}", "a page without token": "GET / HTTP/1.1\nHost: HOST\n\n", "a page with a wrong token": "GET /?token=x HTTP/1.1\nHost: HOST\n\n",
    "a file": "GET /plate.toml?token=TOKEN HTTP/1.1\nHost: HOST\n\n", "a file above": "GET /../../etc/passwd?token=TOKEN HTTP/1.1\nHost: HOST\n\n", "a file in code": "GET /%2e%2e/%2e%2e/etc/passwd?token=TOKEN HTTP/1.1\nHost: HOST\n\n",
    "a picture": "GET /favicon.ico HTTP/1.1\nHost: HOST\n\n", "another server": "GET http://evil.example/?token=TOKEN HTTP/1.1\nHost: evil.example\n\n", "a tunnel": "CONNECT evil.example:80 HTTP/1.1\nHost: HOST\n\n",
    "DELETE": "DELETE /state HTTP/1.1\nHost: HOST\n\n", "TRACE": "TRACE / HTTP/1.1\nHost: HOST\n\n", "PATCH": "PATCH /state HTTP/1.1\nHost: HOST\nX-Token: TOKEN\nContent-Length: 2\n\n{}", "PROPFIND": "PROPFIND / HTTP/1.1\nHost: HOST\n\n",
    "small letters": "get / HTTP/1.1\nHost: HOST\n\n", "no method": " / HTTP/1.1\nHost: HOST\n\n", "half a line": "GET\n\n", "no version": "GET /?token=TOKEN\n\n", "version one and a half": "GET / HTTP/1.x\nHost: HOST\n\n", "version -1": "GET / HTTP/-1.1\nHost: HOST\n\n", "version 2": "GET / HTTP/2.0\nHost: HOST\n\n",
    "length in sixteens": GOOD.replace("Length: 2", "Length: 0x2"), "length with a sign": GOOD.replace("Length: 2", "Length: +2"), "length with a stop": GOOD.replace("Length: 2", "Length: 2.0"), "lengths in a list": GOOD.replace("Length: 2", "Length: 2, 2"), "length of nothing": GOOD.replace("Length: 2", "Length:"),
    "length too large": GOOD.replace("Length: 2", "Length: 20000001"), "two equal lengths": GOOD.replace("Content-Length: 2", "Content-Length: 2\nContent-Length: 2"), "chunks and a length": GOOD.replace("Content-Length", "Transfer-Encoding: chunked\nContent-Length"), "chunks in capitals": GOOD.replace("Content-Length", "TRANSFER-ENCODING: Chunked\nContent-Length"), "gzip": GOOD.replace("Content-Length", "Transfer-Encoding: gzip\nContent-Length"),
    "a space before the colon": GOOD.replace("Content-Length: 2", "Content-Length : 2"), "a page with a body": PAGE + "Content-Length: 4\n\nGET ", "a page in chunks": PAGE + "Transfer-Encoding: chunked\n\n0\n\n",
    "body too short": GOOD.replace("Length: 2", "Length: 200"), "no JSON": GOOD.replace("{}", "{]"), "a list": GOOD.replace("{}", "[]"), "no text": GOOD.replace("{}", "\x01\x02"), "deep": GOOD.replace("Length: 2", "Length: 100000").replace("{}", "[" * 100_000), "a header of 10^5 letters": "GET / HTTP/1.1\nHost: HOST\nA: " + "a" * 100_000 + "\n\n", "1000 headers": "GET / HTTP/1.1\nHost: HOST\n" + "".join(f"A{i}: 1\n" for i in range(1000)) + "\n",
    "a second request in the body of a refused one": GOOD.replace("TOKEN", "x").replace("Length: 2", "Length: LENGTH").replace("{}", NEXT), "a zero in the address": "GET /\x00?token=TOKEN HTTP/1.1\nHost: HOST\n\n",
}  # fmt: skip


def body_of(question: Question) -> bytes:
    return json.dumps(question.body).encode()
