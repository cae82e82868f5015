"""Hostile evidence packs, written from the outside: an archive that somebody sends, and `vcmm rerun` of it.

Each case makes the bytes of an archive out of those of an honest one. OUT stands for a folder beside the pack in which all files lie that a pack may
want; a case that names it is asked twice, with that folder filled and empty.
"""

from __future__ import annotations

import hashlib
import io
import json
import stat
import struct
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

Data = dict[str, bytes]
SCENARIO, MACHINE, VALUES = "files/jobs/plate.toml", "files/machines/m.toml", "files/values.csv"
NAMED = b'machine = "../machines/m.toml"'
REFUSED, DIFFERS = (2,), (1, 2)  # exit codes: wrong input; or run, and told to be another


@dataclass(frozen=True)
class Pack:
    """name; the archive; whether it names OUT; the exit codes that are right."""

    name: str
    archive: bytes
    outside: bool = False
    codes: tuple[int, ...] = REFUSED


def unpacked(archive: bytes) -> Data:
    with zipfile.ZipFile(io.BytesIO(archive)) as held:
        return {n: held.read(n) for n in held.namelist()}


def packed(data: Data, method: int = zipfile.ZIP_DEFLATED) -> bytes:
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w", method) as pack:
        for name, content in data.items():
            pack.writestr(name, content)
    return whole.getvalue()


def sealed(data: Data) -> bytes:
    """With the SHA-256 of its files as they are now, as a forger writes them."""
    said = json.loads(data["evidence.json"])
    for one in said["files"]:
        if one["file"] in data:
            one["sha256"] = hashlib.sha256(data[one["file"]]).hexdigest()
    return packed(data | {"evidence.json": json.dumps(said).encode()})


def cases(honest: bytes, out: Path) -> Iterator[Pack]:
    yield from _files_outside(honest, out)
    yield from _commands(honest, out)
    yield from _members(honest)
    yield from _documents(honest)
    yield from _archives(honest)


def _said(data: Data, edit: Callable[[dict[str, Any]], object]) -> Data:
    said = json.loads(data["evidence.json"])
    edit(said)
    return data | {"evidence.json": json.dumps(said).encode()}


def _files_outside(honest: bytes, out: Path) -> Iterator[Pack]:
    """A scenario, machine or table of the pack that names a file outside it; every SHA-256 is right."""
    data, up = unpacked(honest), "../" * 12 + str(out).lstrip("/")
    escaped = "".join(f"\\u{ord(c):04x}" for c in f"{out}/m.toml")
    values = {
        "absolute": f'"{out}/m.toml"', "climbing": f'"{up}/m.toml"', "raw text": f"'{out}/m.toml'", "several lines": f'"""\n{out}/m.toml"""',
        "raw text of several lines": f"'''\n{up}/m.toml'''", "escaped": f'"{escaped}"', "by this process": f'"/proc/self/root{out}/m.toml"',
        "two slashes": f'"//{str(out).lstrip("/")}/m.toml"', "through a folder that is not": f'"x/../{up}/m.toml"', "by the working folder": f'"/proc/self/cwd/{up}/m.toml"',
    }  # fmt: skip
    for how, value in values.items():
        new = data[SCENARIO].replace(NAMED, f"machine = {value}".encode())
        yield Pack(f"machine outside, {how}", sealed(data | {SCENARIO: new}), True)
    for how, value in (("absolute", f'"{out}/errors.csv"'), ("climbing", f'"{up}/errors.csv"'), ("several lines", f"'''\n{out}/errors.csv'''")):  # fmt: skip
        table = f'\n[errors]\ntable = {value}\nuncertainty = {{ translation = "0.1 um", rotation = "0 urad", squareness = "0 urad", correlation_length = "9 mm" }}\n'
        yield Pack(f"table outside, {how}", sealed(data | {MACHINE: data[MACHINE] + table.encode()}), True)
    for key, file in (("mesh", "cube.stl"),):
        new = data[SCENARIO].replace(b"[part]\n", f'[part]\n{key} = "{out}/{file}"\n'.encode(), 1)
        yield Pack(f"{key} outside", sealed(data | {SCENARIO: new}), True)
    for table, file in (("plan", "plan.toml"), ("environment", "environment.toml"), ("part", "part.toml"), ("job", "job.toml")):  # fmt: skip
        text = f'vcmm = "scenario/1"\nmachine = "../machines/m.toml"\n{table} = "{out}/{file}"\n'
        yield Pack(f"{table} outside", sealed(data | {SCENARIO: text.encode()}), True)
    for device in ("/dev/zero", "/dev/stdin", "/proc/self/environ", "/etc/passwd", "/etc/hostname"):
        new = data[SCENARIO].replace(NAMED, f'machine = "{device}"'.encode())
        yield Pack(f"machine = {device}", sealed(data | {SCENARIO: new}))


def _commands(honest: bytes, out: Path) -> Iterator[Pack]:
    data = unpacked(honest)
    command = json.loads(data["evidence.json"])["command"]

    def words(name: str, new: Any, outside: bool = False, codes: tuple[int, ...] = REFUSED) -> Pack:
        return Pack(name, packed(_said(data, lambda s: s.update(command=new))), outside, codes)

    at = command.index("--values") + 1
    yield words("values outside", [*command[:at], f"{out}/values.csv", *command[at + 1 :]], True)
    yield words("values climbing", [*command[:at], f"../../{out.name}/values.csv", *command[at + 1 :]], True)
    yield words("values with an equals sign", [*command[: at - 1], f"--values={out}/values.csv", *command[at + 1 :]], True)  # fmt: skip
    yield words("points outside", [*command[:2], "--points", f"{out}/points.csv", *command[at + 1 :]], True)
    yield words("scenario outside", ["evaluate", f"{out}/plate.toml", *command[2:]], True)
    yield words("scenario outside behind the options", ["evaluate", *command[2:], f"{out}/plate.toml"], True)
    yield words("two scenarios", [*command, f"{out}/plate.toml"], True)
    for verb in (
        "new",
        "demo",
        "serve",
        "rerun",
        "compensate",
        "merge",
        "convert",
        "../evaluate",
        "",
        "-",
        "--version",
        "EVALUATE",
    ):
        yield words(f"verb {verb!r}", [verb, *command[1:]])
    for option in (
        "--out",
        "--report",
        "--evidence",
        "--sheet",
        "--plot",
        "--export",
        "--workers",
        "--cluster",
        "--shard",
        "-o",
        "--help",
        "--json",
        "--install-completion",
        "--",
        "---",
        "--no-values",
    ):
        yield words(f"option {option}", [*command, option, f"{out}/new"])
    huge = "99999999999"
    i = command.index("--trials") + 1
    yield words("10^11 trials", [*command[:i], huge, *command[i + 1 :]])
    yield words("10^11 trials as the second number", [*command, "--trials", huge])
    yield words(
        "10^11 trials with an equals sign", [*command[: i - 1], f"--trials={huge}", *command[i + 1 :]]
    )
    yield words("trials with exponent", [*command[:i], "1e11", *command[i + 1 :]])
    yield words("trials in other digits", [*command[:i], "９" * 11, *command[i + 1 :]])
    yield words("trials of 5000 digits", [*command[:i], "9" * 5000, *command[i + 1 :]])
    yield words("trials below zero", [*command[:i], "-5", *command[i + 1 :]])
    text = data[SCENARIO].replace(b"trials = 20000", f"trials = {huge}".encode())
    heavy = data | {SCENARIO: text}
    bare = [w for k, w in enumerate(command) if k not in (i - 1, i)]
    yield Pack("10^11 trials in the scenario", sealed(_said(heavy, lambda s: s.update(command=bare))))
    turned = ["evaluate", *bare[2:], bare[1]]
    yield Pack("the same, the scenario last", sealed(_said(heavy, lambda s: s.update(command=turned))))
    named = ["evaluate", "--scenario", bare[1], *bare[2:]]
    yield Pack("the same, the scenario by name", sealed(_said(heavy, lambda s: s.update(command=named))))
    routes = ["routes", command[1], "--trials", "1000"]
    for option in ("--repeats", "--positions"):
        yield words(f"{option} of 10^9", [*routes, option, "1000000000"])
    yield words("a file of the pack beside the options", [*command, "files/values.csv"])
    yield words("a job alone", command[:1])
    yield words("seed of 5000 digits", [*command[: command.index("--seed") + 1], "9" * 5000])
    for name, value in (
        ("no command", None),
        ("command as text", "evaluate x"),
        ("command of numbers", [1, 2]),
        ("an empty command", []),
        ("a command of a million words", ["evaluate"] * 10**6),
        ("a command that paints", ["evaluate\x1b[2J", "\x1b]0;owned\x07"]),
    ):
        yield words(name, value)


def _members(honest: bytes) -> Iterator[Pack]:
    """Names and kinds of members."""
    data = unpacked(honest)

    def renamed(name: str, listed: str = "") -> bytes:
        new = {(name if n == VALUES else n): c for n, c in data.items()}
        return packed(
            _said(new, lambda s: [f.update(file=listed or name) for f in s["files"] if f["file"] == VALUES])
        )

    for name in (
        "../values.csv",
        "/tmp/values.csv",
        "files/../../values.csv",
        "..\\values.csv",
        "C:\\values.csv",
        "C:values.csv",
        "files/./../../v.csv",
        "//server/v.csv",
        "files/" + "x" * 300,
        "files/" + "a/" * 900 + "v",
        "./../v.csv",
    ):
        yield Pack(f"member {name[:30]}", renamed(name))
    yield Pack(
        "a file where a folder is",
        packed(
            _said(
                data | {"files": b"x"},
                lambda s: s["files"].append({"file": "files", "sha256": hashlib.sha256(b"x").hexdigest()}),
            )
        ),
    )
    yield Pack("a member that is not listed", packed(data | {"files/more.csv": b"x"}))
    yield Pack("a listed file that is missing", packed({n: c for n, c in data.items() if n != VALUES}))
    yield Pack("a file that was changed", packed(data | {VALUES: data[VALUES] + b"\n"}))
    for name in ("evidence.json", "document.json"):
        yield Pack(f"no {name}", packed({n: c for n, c in data.items() if n != name}))
    link = io.BytesIO()
    with zipfile.ZipFile(link, "w") as pack:
        for n, c in data.items():
            info = zipfile.ZipInfo(n)
            if n == VALUES:
                info.external_attr = (stat.S_IFLNK | 0o777) << 16
                c = b"/etc/passwd"
            pack.writestr(info, c)
    yield Pack("a symbolic link", link.getvalue())
    yield Pack("a symbolic link, sealed", _resealed(link.getvalue()), codes=DIFFERS)
    twice = io.BytesIO()
    with zipfile.ZipFile(twice, "w") as pack:
        for n, c in data.items():
            pack.writestr(n, c)
        import warnings

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            pack.writestr(VALUES, b"characteristic,deviation_um\nbore diameter,0\n")
    yield Pack("a member twice", twice.getvalue())
    yield Pack("2001 members", packed(data | {f"files/{i}": b"" for i in range(2001)}))


def _resealed(archive: bytes) -> bytes:
    """A symbolic link as a listed file: the SHA-256 of its text is right."""
    data = unpacked(archive)
    said = json.loads(data["evidence.json"])
    whole = io.BytesIO()
    for one in said["files"]:
        one["sha256"] = hashlib.sha256(data[one["file"]]).hexdigest()
    with zipfile.ZipFile(whole, "w") as pack:
        for n, c in (data | {"evidence.json": json.dumps(said).encode()}).items():
            info = zipfile.ZipInfo(n)
            if n == VALUES:
                info.external_attr = (stat.S_IFLNK | 0o777) << 16
            pack.writestr(info, c)
    return whole.getvalue()


def _documents(honest: bytes) -> Iterator[Pack]:
    """What the documents say: no tracebacks, and "the same" only of what is the same."""
    data = unpacked(honest)
    document = data["document.json"].decode()
    spot = '"measured_mm": 30.01'
    assert spot in document
    for name, text in (
        ("NaN", "NaN"),
        ("Infinity", "Infinity"),
        ("10^400", "1" + "0" * 400),
        ("1e400", "1e400"),
        ("true", "true"),
        ("a text", '"30.01"'),
        ("null", "null"),
        ("a list", "[30.01]"),
        ("an object", '{"x": 30.01}'),
        ("one part in 10^5", "30.0103"),
    ):
        new = document.replace(spot, f'"measured_mm": {text}', 1)
        yield Pack(f"a value that is {name}", packed(data | {"document.json": new.encode()}), codes=DIFFERS)
        close = new.replace('"p": 0.95', '"p": 0.9500000009', 1)
        yield Pack(
            f"the same behind a change of 1e-9: {name}",
            packed(data | {"document.json": close.encode()}),
            codes=DIFFERS,
        )
    lone = json.loads(document)
    lone["characteristics"] = []
    yield Pack("no results", packed(data | {"document.json": json.dumps(lone).encode()}), codes=DIFFERS)
    yield Pack("an empty document", packed(data | {"document.json": b"{}"}), codes=DIFFERS)
    for file in ("evidence.json", "document.json"):
        for name, content in (
            ("a list", b"[]"),
            ("a number", b"3"),
            ("null", b"null"),
            ("nothing", b""),
            ("10^5 levels", b"[" * 100_000),
            ("10^5 levels, closed", b"[" * 100_000 + b"]" * 100_000),
            ("5000 digits", b'{"x": ' + b"9" * 5000 + b"}"),
            ("no text", b"\xff\xfe\x00"),
            ("half of itself", data[file][: len(data[file]) // 2]),
            ("UTF-16", data[file].decode().encode("utf-16")),
        ):
            codes = (0,) if (file, name) == ("document.json", "UTF-16") else REFUSED
            if (file, name) != ("evidence.json", "UTF-16"):  # JSON as good as any, and the same
                yield Pack(f"{file} is {name}", packed(data | {file: content}), codes=codes)
    for key in ("schema", "version", "libraries", "influences", "files", "command"):
        for name, value in (
            ("null", None),
            ("a number", 3),
            ("an object", {"x": 1}),
            ("a list of null", [None]),
        ):
            if (key, name) != ("libraries", "an object"):
                yield Pack(
                    f"{key} is {name}", packed(_said(data, lambda s, k=key, v=value: s.update({k: v})))
                )
    paints = _said(data, lambda s: s.update(version="\x1b[2J\x1b]0;owned\x07"))
    yield Pack("a version that paints", packed(paints), codes=(0,))


def _archives(honest: bytes) -> Iterator[Pack]:
    """Spoilt archives."""
    data = unpacked(honest)
    yield Pack("no archive", b"no zip")
    yield Pack("nothing", b"")
    yield Pack("an empty archive", packed({}))
    yield Pack("half an archive", honest[: len(honest) // 2])
    yield Pack("without its end", honest[:-22])
    yield Pack(
        "something before it", b"\x1f\x8b" + honest, codes=(0,)
    )  # as programs that unpack themselves have it
    for name, method in (
        ("LZMA", zipfile.ZIP_LZMA),
        ("BZ2", zipfile.ZIP_BZIP2),
        ("deflate", zipfile.ZIP_DEFLATED),
    ):
        whole = bytearray(packed(data, method))
        at = whole.index(b"evidence.json") + 30
        whole[at : at + 20] = b"\xff" * 20
        yield Pack(f"a spoilt member, {name}", bytes(whole))
    unknown = bytearray(honest)
    at = unknown.index(b"PK\x01\x02")
    unknown[at + 10 : at + 12] = struct.pack("<H", 97)
    yield Pack("a method that is none", bytes(unknown))
    secret = bytearray(honest)
    secret[at + 8] |= 1
    yield Pack("locked by a password", bytes(secret))
    size = bytearray(honest)
    size[at + 24 : at + 28] = struct.pack("<I", 2**32 - 2)
    yield Pack("a size of 4 GB", bytes(size))
    yield Pack("a bomb of 2 GB", _bomb(data))


def _bomb(data: Data) -> bytes:
    """Twenty files of 100 MB of zeros each, packed."""
    whole = io.BytesIO()
    zeros = bytes(1 << 20)
    with zipfile.ZipFile(whole, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as pack:
        for n, c in data.items():
            pack.writestr(n, c)
        with pack.open("files/zeros", "w", force_zip64=True) as out:
            for _ in range(100):
                out.write(zeros)
    spoilt = bytearray(whole.getvalue())
    at = spoilt.rindex(b"PK\x01\x02")
    spoilt[at + 24 : at + 28] = struct.pack("<I", 2**31)
    return bytes(spoilt)
