"""PATTERN DEF of Klartext: the points at which CYCL CALL PAT calls the machining cycle.

Source: HEIDENHAIN, TNC 640 User's Manual Cycle Programming, "PATTERN DEF". Z of a point is where its machining begins; it counts on
top of the surface of the cycle.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from vcmm.program.drilling import whole_count
from vcmm.program.heidenhain.text import KlartextReader

Spot = tuple[float, float, float]  # in the plane and along the tool axis, in the unit of the program
KINDS = ("POS", "ROW", "PAT", "FRAME", "CIRC", "PITCHCIRC")


def pattern_points(reader: KlartextReader) -> list[Spot]:
    """All points of a PATTERN DEF block, in the order in which they are machined."""
    out: list[Spot] = []
    while not reader.is_done:
        kind = reader.upper()
        if kind not in KINDS:
            raise reader.fault(f"PATTERN DEF takes {', '.join(KINDS)}, {kind} stands there")
        reader.at += 1
        token = reader.peek()
        if token is not None and token.kind == "number":  # POS1, POS2
            reader.at += 1
        out += _points(kind, _words(reader, kind))
    return out


def _words(reader: KlartextReader, kind: str) -> dict[str, float]:
    """( X+25 Y+33.5 Z+0 )."""
    reader.expect("(", f"after {kind}, as in POS1 (X+25 Y+33.5 Z+0)")
    out: dict[str, float] = {}
    while not reader.accept(")"):
        name = reader.upper()
        if reader.is_done:
            raise reader.fault(f'")" is missing behind {kind}')
        reader.at += 1
        out[name] = reader.value(name)
    return out


def _points(kind: str, w: Mapping[str, float]) -> Iterator[Spot]:
    x, y, z = w.get("X", 0.0), w.get("Y", 0.0), w.get("Z", 0.0)
    if kind == "POS":
        yield x, y, z
    elif kind == "ROW":
        turn = math.radians(w.get("ROT", 0.0))
        for k in range(whole_count(w.get("NUM", 1.0))):
            d = k * w.get("D", 0.0)
            yield x + d * math.cos(turn), y + d * math.sin(turn), z
    elif kind in ("PAT", "FRAME"):
        yield from _grid(kind, w, (x, y, z))
    else:
        count, start = whole_count(w.get("NUM", 1.0)), w.get("START", 0.0)
        step = w.get("STEP", 0.0) if kind == "PITCHCIRC" else 360.0 / max(count, 1)
        for k in range(count):
            angle = math.radians(start + k * step)
            yield x + w.get("D", 0.0) / 2 * math.cos(angle), y + w.get("D", 0.0) / 2 * math.sin(angle), z


def _grid(kind: str, w: Mapping[str, float], origin: Spot) -> Iterator[Spot]:
    """Rows to and fro; of a frame its border only. ROTX and ROTY turn the two directions, ROT the whole."""
    columns, lines = whole_count(w.get("NUMX", 1.0)), whole_count(w.get("NUMY", 1.0))
    turn = w.get("ROT", 0.0)
    p, q = math.radians(turn + w.get("ROTX", 0.0)), math.radians(turn + 90.0 + w.get("ROTY", 0.0))
    for line in range(lines):
        for k in range(columns) if line % 2 == 0 else reversed(range(columns)):
            if kind == "FRAME" and 0 < line < lines - 1 and 0 < k < columns - 1:
                continue
            a, b = k * w.get("DX", 0.0), line * w.get("DY", 0.0)
            yield (
                origin[0] + a * math.cos(p) + b * math.cos(q),
                origin[1] + a * math.sin(p) + b * math.sin(q),
                origin[2],
            )
