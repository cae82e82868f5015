"""Read text files and the numbers in them, with messages that name the problem and the files beside the missing one."""

from __future__ import annotations

import csv
import io
import json
import math
import re
import stat
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import IO

from vcmm.core.confinement import check_inside
from vcmm.core.errors import DataError, did_you_mean
from vcmm.core.own_files import note_read

LARGEST_FILE = 2_000_000_000  # bytes; what is read from a pipe counts the same
PORTION = 1 << 20  # bytes asked of the system at a time
LARGEST = 1e12  # of any number in a table, and of a quantity in usual values: no machine has anything near it
_NUMBER = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")
_NOT_FINITE = ("nan", "inf", "infinity")
_ARCHIVE_MARKS = {b"PK\x03\x04": "a zip archive", b"\x1f\x8b": "a gzip archive", b"%PDF": "a PDF"}


def read_text(path: Path) -> str:
    """Return the text of a UTF-8 file, with or without byte order mark. Raises DataError naming the file, the line and the fix."""
    raw = raw_bytes(path)
    packed = next((what for head, what in _ARCHIVE_MARKS.items() if raw.startswith(head)), "")
    if packed:
        raise DataError(f"{path}:1: this is {packed}, no text; unpack or export it first")
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise DataError(f"{path}:1: this is UTF-16; save it as UTF-8")
    if b"\0" in raw:
        raise DataError(
            f"{path}:{_line(raw, raw.index(0))}: this line contains a zero byte, so the file is no text; remove the byte or name another file"
        )
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise DataError(
            f"{path}:{_line(raw, error.start)}: the file is not UTF-8 text ({error.reason} at byte {error.start}); save it as UTF-8"
        ) from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def lines_of(text: str) -> list[str]:
    """Return the lines as an editor counts them (str.splitlines knows ten further ends of a line)."""
    return text.removesuffix("\n").split("\n")


def to_number(text: str) -> float:
    """Return a number written with ASCII digits, a point and an exponent, or nan and inf. Raises ValueError for anything else.

    float() also accepts 1_000 and the digits of other scripts, which are mistakes in a data file.
    """
    plain = text.strip()
    if not _NUMBER.fullmatch(plain) and plain.lstrip("+-").lower() not in _NOT_FINITE:
        raise ValueError(f'"{text}" is not a number')
    return float(plain)


def is_usual(value: float) -> bool:
    """Return whether a number is finite and no larger than any quantity of a machine (LARGEST)."""
    return math.isfinite(value) and abs(value) <= LARGEST


RUN_BY_SPREADSHEETS = ("=", "+", "-", "@", "\t", "\r")  # first in a cell: a formula


def csv_of(rows: Iterable[Iterable[object]]) -> str:
    """Return rows as CSV; a text that a spreadsheet would run as a formula gets an apostrophe before it (`unescape_cell` undoes it)."""
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows([escape_cell(cell) for cell in row] for row in rows)
    return out.getvalue()


def escape_cell(cell: object) -> object:
    """Return a cell escaped for a CSV file: "=1+1" becomes "'=1+1", numbers stay unchanged."""
    if not isinstance(cell, str) or not cell.lstrip("'").startswith(RUN_BY_SPREADSHEETS):
        return cell
    try:
        to_number(cell)
    except ValueError:
        return "'" + cell
    return cell


def unescape_cell(cell: str) -> str:
    """Return the text of a cell that `escape_cell` wrote."""
    return cell[1:] if cell[:1] == "'" and cell.lstrip("'").startswith(RUN_BY_SPREADSHEETS) else cell


def quote(text: str) -> str:
    """Return a text quoted for TOML, on one line."""
    return json.dumps(text, ensure_ascii=False)


def brief(text: str, length: int = 60) -> str:
    """Return a text shortened for a message: its middle is left out where it is longer than `length` characters."""
    if len(text) <= length:
        return text
    half = (length - 3) // 2
    return f"{text[:half]}...{text[len(text) - half :]}"


def is_file(path: Path) -> bool:
    """Return whether there is such a file; False for a name that no file can have. Raises DataError outside the folder of `confined`."""
    check_inside(path)
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def read_head(path: Path) -> None:
    """Raises DataError where a file cannot be read at all: missing, a folder, a device, larger than LARGEST_FILE."""
    raw_bytes(path, 1)


def raw_bytes(path: Path, most: int = LARGEST_FILE + 1) -> bytes:
    """Return all bytes of a file, or the first `most`. Raises DataError: missing, a folder, a device, a pipe, larger than LARGEST_FILE."""
    check_inside(path)
    try:
        kind = path.stat()
        if stat.S_ISDIR(kind.st_mode):
            raise DataError(f"{path} is a folder; name a file in it")
        if stat.S_ISCHR(kind.st_mode) or stat.S_ISBLK(kind.st_mode):
            raise DataError(f"{path}:1: this is a device, not a file; name a file")
        if stat.S_ISFIFO(kind.st_mode) or stat.S_ISSOCK(kind.st_mode):
            raise DataError(
                f"{path}:1: this is a pipe, and files are read more than once; write it to a file first"
            )
        if kind.st_size > LARGEST_FILE:
            raise DataError(_too_large(path, f"{kind.st_size:,} bytes"))
        with path.open("rb") as file:
            raw = b"".join(_portions(file, most))
    except FileNotFoundError:
        raise DataError(f"{path} does not exist.{_beside(path)}") from None
    except OSError as error:
        raise DataError(f"{brief(str(path), 200)} cannot be read: {error.strerror}") from None
    except ValueError:
        raise DataError(f"{brief(str(path))!r} cannot be the name of a file; correct it") from None
    if len(raw) > LARGEST_FILE:
        raise DataError(_too_large(path, f"more than {LARGEST_FILE:,} bytes"))
    note_read(path)
    return raw


def _portions(file: IO[bytes], most: int) -> Iterator[bytes]:
    """Yield the first `most` bytes in pieces: read(n) asks the system for n bytes at once, whatever the file holds."""
    left = most
    while left > 0 and (piece := file.read(min(left, PORTION))):
        left -= len(piece)
        yield piece


def _too_large(path: Path, what: str) -> str:
    return f"{path}:1: {what}, and at most {LARGEST_FILE:,} are read; split the file"


def _line(raw: bytes, position: int) -> int:
    """Return the line (1 = first) of a byte."""
    return raw.count(b"\n", 0, position) + 1


def _beside(path: Path) -> str:
    """Return ' Did you mean "plate.toml"?' or the files of that kind in the folder."""
    if not path.parent.is_dir():
        return f" There is no folder {path.parent}"
    near = sorted(p.name for p in path.parent.glob(f"*{path.suffix}") if p.is_file())
    listed = f" Files there: {', '.join(near[:8])}" if near and path.suffix else ""
    return did_you_mean(path.name, near) or listed
