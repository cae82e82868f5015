"""PATTERN DEF of Klartext: the points at which CYCL CALL PAT calls the machining cycle; cycles 220 and 221, which call it at once.

Source: HEIDENHAIN, TNC 640 User's Manual Cycle Programming, "PATTERN DEF", "Point patterns". Z of a point is where its machining begins; it counts on
top of the surface of the cycle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping

from vcmm.program.cutter import Flat
from vcmm.program.cycle_tables import Cycle, Values, cycle
from vcmm.program.drilling import whole_count
from vcmm.program.heidenhain.text import KlartextReader
from vcmm.program.hole_patterns import hole_circle, hole_grid, hole_line

Spot = tuple[float, float, float]  # in the plane and along the tool axis, in the unit of the program
PATTERN_KINDS = {  # and the words without which its points are not known
    "POS": "X Y", "ROW": "X Y D NUM", "PAT": "X Y DX DY NUMX NUMY", "FRAME": "X Y DX DY NUMX NUMY", "CIRC": "X Y D NUM", "PITCHCIRC": "X Y D STEP NUM",
}  # fmt: skip


def pattern_points(reader: KlartextReader) -> list[Spot]:
    """Return all points of a PATTERN DEF block, in the order in which they are machined."""
    out: list[Spot] = []
    while not reader.is_done:
        kind = reader.upper()
        if kind not in PATTERN_KINDS:
            raise reader.fault(f"PATTERN DEF takes {', '.join(PATTERN_KINDS)}, found {kind}")
        reader.at += 1
        token = reader.peek()
        if token is not None and token.kind == "number":  # POS1, POS2
            reader.at += 1
        words = _words(reader, kind)
        for name in PATTERN_KINDS[kind].split():
            if name not in words:
                raise reader.fault(f"{kind} of PATTERN DEF has no {name}; add it")
        out += _points(kind, words)
    return out


def _words(reader: KlartextReader, kind: str) -> dict[str, float]:
    """Return the words of ( X+25 Y+33.5 Z+0 )."""
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
    spot, z = (w.get("X", 0.0), w.get("Y", 0.0)), w.get("Z", 0.0)
    if kind in ("PAT", "FRAME"):
        yield from _grid(kind, w, (*spot, z))
        return
    count, start = whole_count(w.get("NUM", 1.0)), w.get("START", 0.0)
    step = w.get("STEP", 0.0) if kind == "PITCHCIRC" else 360.0 / max(count, 1)
    if kind == "POS":
        spots = [spot]
    elif kind == "ROW":
        spots = hole_line(spot, math.radians(w.get("ROT", 0.0)), [k * w.get("D", 0.0) for k in range(count)])
    else:
        spots = hole_circle(spot, w.get("D", 0.0) / 2, [math.radians(start + k * step) for k in range(count)])
    yield from ((x, y, z) for x, y in spots)


def _grid(kind: str, w: Mapping[str, float], origin: Spot) -> Iterator[Spot]:
    """Yield the rows to and fro; of a frame its border only. ROTX and ROTY turn the two directions, ROT the whole."""
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


def circle_points(v: Values) -> list[Flat]:
    """Return the points of cycle 220: from Q245 by Q247, or evenly to Q246."""
    count, first, span = whole_count(v["count"]), v["first"], v["last"] - v["first"]
    closed = abs(abs(span) - 360.0) < 1e-9
    step = v["step"] or span / max(count if closed else count - 1, 1)
    angles = [math.radians(first + k * step) for k in range(count)]
    return hole_circle((v["x"], v["y"]), v["diameter"] / 2.0, angles)


def row_points(v: Values) -> list[Flat]:
    """Return the points of cycle 221: Q243 rows of Q242 points, Q238 and Q237 apart, turned by Q224."""
    counts = whole_count(v["columns"]), whole_count(v.without("rows", 1.0))
    return hole_grid((v["x"], v["y"]), v["turn"], counts, (v["along"], v["across"]))


PATTERNS: Mapping[str, Cycle[Callable[[Values], list[Flat]]]] = {
    "220": cycle("Q216=x mm!, Q217=y mm!, Q244=diameter mm!, Q245=first plain!, Q246=last plain!, Q247=step plain!, Q241=count count!", circle_points),
    "221": cycle("Q225=x mm!, Q226=y mm!, Q237=along mm!, Q238=across mm!, Q242=columns count!, Q243=rows count!, Q224=turn deg!", row_points),
}  # fmt: skip
