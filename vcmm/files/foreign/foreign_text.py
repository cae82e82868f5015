"""Read text of measuring software on other computers: UTF-8, UTF-16 or Windows-1252, points or commas in numbers."""

from __future__ import annotations

import re
from pathlib import Path

from vcmm.core.errors import DataError
from vcmm.core.text import raw_bytes, read_text, to_number

_COMMA = re.compile(r"[-+]?[0-9]+,[0-9]+(?:[eE][-+]?[0-9]+)?")
UTF_16 = (b"\xff\xfe", b"\xfe\xff")


def foreign_text(path: str | Path) -> tuple[str, tuple[str, ...]]:
    """Return (text with plain ends of lines, assumption about its encoding). DataError: no text at all, a packed file."""
    path = Path(path)
    raw = raw_bytes(path)
    if raw.startswith(b"{\\rtf"):
        raise DataError(
            f"{path}:1: this is RTF; let the report be written as text (.txt), or save it as plain text"
        )
    if raw.startswith(UTF_16):
        try:
            return _lines(raw.decode("utf-16")), ()
        except UnicodeDecodeError as error:
            raise DataError(
                f"{path}:1: it begins as UTF-16 and is none ({error.reason}); save it as UTF-8"
            ) from None
    try:
        return read_text(path), ()
    except DataError as refused:
        if b"\0" in raw or raw.startswith((b"PK\x03\x04", b"\x1f\x8b", b"%PDF")):
            raise refused
    text = raw.decode("cp1252", errors="replace")
    return _lines(text), (
        f"{path}: it is not UTF-8; read as Windows-1252, check names with other letters than a to z",
    )


def foreign_number(cell: str) -> float:
    """Parse a number with a point or with a decimal comma (15,0031). ValueError: anything else, 1.234,5 too.

    >>> foreign_number("15,0031"), foreign_number("-0.5"), foreign_number("1,5e-3")
    (15.0031, -0.5, 0.0015)
    """
    plain = cell.strip()
    return to_number(plain.replace(",", ".") if _COMMA.fullmatch(plain) else plain)


def _lines(text: str) -> str:
    return text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
