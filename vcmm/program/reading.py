"""The text of a program file, and the likely dialect of it."""

from __future__ import annotations

import re
from pathlib import Path

from vcmm.core.errors import DataError
from vcmm.core.text import raw_bytes
from vcmm.program.dialects import names
from vcmm.program.recognition import HERE, Candidate, candidates, ranking_text, unsure

MOST_DIGITS = 100  # of one number of a program
_LONG_NUMBER = re.compile(rb"[0-9]{%d,}" % (MOST_DIGITS + 1))
_WORD = re.compile(
    r"(?<![A-Z])[A-Z][ \t]*[-+]?[ \t]*[.\d#\[(=]|^[ \t]*[%$#]|^[ \t]*(?:BEGIN|END) PGM|^[ \t]*[(;]",
    re.MULTILINE,
)


def read_bytes(path: Path) -> str:
    """Return the text of a program, line ends unchanged. UTF-8, else Latin-1 (comments of old posts). Raises DataError."""
    raw = raw_bytes(path).strip(b"\0")  # leader and trailer of a tape, which controls pass over
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise DataError(
            f"{path}:1:1: this text is UTF-16, which no control reads; save it as plain text (ASCII or UTF-8)"
        )
    if b"\0" in raw and min(len(raw[k::2].replace(b"\0", b"")) for k in (0, 1)) < 0.2 * len(raw) / 2:
        raise DataError(
            f"{path}:1:1: this text seems to be UTF-16, which no control reads; save it as plain text (ASCII or UTF-8)"
        )
    if b"\0" in raw:
        line = raw.count(b"\n", 0, raw.index(b"\0")) + 1
        column = raw.index(b"\0") - (raw.rfind(b"\n", 0, raw.index(b"\0")) + 1) + 1
        raise DataError(
            f"{path}:{line}:{column}: a NUL byte in the text: this is no NC program; remove it or name the NC program"
        )
    long = _LONG_NUMBER.search(raw)
    if long is not None:
        line = raw.count(b"\n", 0, long.start()) + 1
        column = long.start() - (raw.rfind(b"\n", 0, long.start()) + 1) + 1
        raise DataError(
            f"{path}:{line}:{column}: a number of {len(long[0]):,} digits; no control reads more than "
            f"{MOST_DIGITS}; correct it"
        )
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("latin-1")


def guess(text: str, path: Path | None) -> tuple[str, str]:
    """Return the dialect that a program seems to be written in, and the reason, which states doubt. Raises DataError where it is
    one that is not here."""
    ranking = candidates(text, path)
    if text.strip() and not _WORD.search(text.upper()):
        raise DataError(
            f"{path or 'the program'}:1:1: no line of this text holds a word of a control (a letter with a number, as X12.5); name the NC program"
        )
    if not ranking:
        return "fanuc", "nothing distinguishes it, so name it with --dialect where that is wrong"
    here = [c for c in ranking if c.dialect in names()]
    best = ranking[0]
    if best.dialect not in HERE and (not here or best.score > here[0].score):
        place = path or "the program"
        second = f"; the nearest that is: {here[0]}" if here else ""
        raise DataError(
            f"{place}:1:1: this seems to be written for {best.dialect} ({', '.join(best.signs[:2])}), a dialect that is not here"
            f"{second}; have it posted for one of {', '.join(names())}, or name one with --dialect"
        )
    return (here[0].dialect, ranking_text(here)) if here else ("fanuc", ranking_text(ranking))


def likely(path: Path) -> str:
    """Return the likely dialect of a file, "" where it is not here or cannot be read as text."""
    try:
        return guess(read_bytes(path), path)[0]
    except DataError:
        return ""


def runner_up(text: str, path: Path | None) -> Candidate | None:
    """Return the second likely dialect, where the first is not sure."""
    here = [c for c in candidates(text, path) if c.dialect in names()]
    return here[1] if unsure(here) else None
