"""M codes of a line, found by the reader of its dialect: no text in quotes, no name of a variable and no label is one.

Which of them act behind the motion of their block, and so go to the last of the blocks that replace it:

stops and ends (M0, M1, M2, M30, M60), M17   everywhere
M5, M9                                       Fanuc, Sinumerik, Klartext: ISO 6983-1, M05 and M09 act after the motion of their block
                                             not LinuxCNC: the order of execution of RS274/NGC (NISTIR 6556, table 8) has M3 M4 M5
                                             and M7 M8 M9 before the motion, M0 M1 M2 M30 M60 after it
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

from vcmm.program.dialects import Dialect
from vcmm.program.faults import BlockFault
from vcmm.program.iso.blocks import parse_block

STOPS = frozenset((0, 1, 2, 30, 60))
BEHIND = {
    "linuxcnc": STOPS,
    "sinumerik": STOPS - {60} | {5, 9, 17},
    "heidenhain": STOPS - {60} | {5, 9},
}
ISO = STOPS | {5, 9}
CORNERS = ("RND", "CHF", "CHR")  # at the end of a Sinumerik block


class Code(NamedTuple):
    """columns from 1, one past the last; name: M, or RND, CHF, CHR; number: None where it is computed."""

    first: int
    last: int
    text: str
    name: str
    number: int | None
    spindle: int | None = None  # M2=3: M3 of spindle 2


def codes_in(line: str, dialect: Dialect) -> list[Code]:
    """Return the M codes (and corners) of a line; none in a line that cannot be read by itself."""
    if "M" not in (upper := line.upper()) and not any(name in upper for name in CORNERS):
        return []
    read = {"sinumerik": _sinumerik, "heidenhain": _klartext}.get(dialect.name)
    try:
        return list(read(line) if read else _g_code(line, dialect))
    except BlockFault:
        return []


def codes_after_motion(line: str, dialect: Dialect) -> list[Code]:
    """Return the codes that act behind the motion of the line."""
    return [
        c
        for c in codes_in(line, dialect)
        if c.name != "M"
        or (c.number == 5 if c.spindle is not None else c.number in BEHIND.get(dialect.name, ISO))
    ]


def _g_code(line: str, dialect: Dialect) -> Iterator[Code]:
    for word in parse_block(line, 1, dialect).words:
        if word.letter == "M":
            number = None if callable(word.value) or word.value % 1 else int(word.value)
            yield Code(word.first, word.last, line[word.first - 1 : word.last - 1], "M", number)


def _sinumerik(line: str) -> Iterator[Code]:
    from vcmm.program.sinumerik.blocks import parse_block as parsed
    from vcmm.program.sinumerik.text import lines_of
    from vcmm.program.sinumerik.traces import span_of

    for item in parsed(lines_of(line)[0], 1).items:
        text = line[item.first - 1 : item.last - 1]
        if item.name in CORNERS and item.value is not None:
            yield Code(item.first, item.last, text, item.name, None)
        elif item.name == "M" and (span := span_of(item, line)) is not None:
            value = line[span[0] - 1 : span[1] - 1].strip()
            head = text.split("=")[0][1:].strip() if "=" in text else ""
            number = int(value) if value.isdigit() else None
            yield Code(item.first, item.last, text, "M", number, int(head) if head.isdigit() else None)


def _klartext(line: str) -> Iterator[Code]:
    from vcmm.program.heidenhain.text import tokenize

    tokens = [t for t in tokenize(line) if t.kind not in ("space", "comment") and t.text != "+"]
    for here, value in pairwise(tokens):
        if here.kind == "name" and here.text.upper() == "M":
            number = int(value.text) if value.text.isdigit() else None
            last = value.column + len(value.text)
            yield Code(here.column, last, line[here.column - 1 : last - 1], "M", number)
