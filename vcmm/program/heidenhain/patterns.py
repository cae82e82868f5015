"""PATTERN DEF of Klartext: the points at which CYCL CALL PAT calls the machining cycle; cycles 220 and 221, which call it at once.

Source: HEIDENHAIN, TNC 640 User's Manual Cycle Programming, "PATTERN DEF", "Point patterns". Z of a point is where its machining begins; it counts on
top of the surface of the cycle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial

from vcmm.program.cutter import Flat
from vcmm.program.cycle_tables import Cycle, Values, cycle, in_units
from vcmm.program.drilling import whole_count
from vcmm.program.heidenhain.text import KlartextReader
from vcmm.program.hole_patterns import hole_circle, hole_grid, hole_line

Spot = tuple[float, float, float]  # in the plane and along the tool axis, in the unit of the program


def pattern_points(reader: KlartextReader) -> list[Spot]:
    """Return all points of a PATTERN DEF block, in the order in which they are machined."""
    out: list[Spot] = []
    while not reader.is_done:
        kind = reader.upper()
        if kind not in SHAPES:
            raise reader.fault(f"PATTERN DEF takes {', '.join(SHAPES)}, found {kind}")
        reader.at += 1
        token = reader.peek()
        if token is not None and token.kind == "number":  # POS1, POS2
            reader.at += 1
        words, row = _words(reader, kind), SHAPES[kind]
        for name in row.required_names:
            if name not in words:
                raise reader.fault(f"{kind} of PATTERN DEF has no {name}; add it")
        for name in words:
            if not row.uses(name):
                names = ", ".join(p.name for p in row.parameters)
                raise reader.fault(
                    f"{kind} of PATTERN DEF has no word {name}; its words are {names}; correct it"
                )
        v = row.read(words, in_units(1.0, 1.0))
        out += ((x, y, v["Z"]) for x, y in row.primitive(v))
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


def holes_in_a_row(v: Values) -> list[Flat]:
    """Return the points of ROW: NUM points D apart."""
    return hole_line((v["X"], v["Y"]), v["ROT"], [k * v["D"] for k in range(whole_count(v["NUM"]))])


def ring(v: Values) -> list[Flat]:
    """Return the points of CIRC, evenly; of PITCHCIRC in steps of STEP."""
    count = whole_count(v["NUM"])
    step = v.without("STEP", 360.0 / max(count, 1))
    angles = [math.radians(v["START"] + k * step) for k in range(count)]
    return hole_circle((v["X"], v["Y"]), v["D"] / 2, angles)


def matrix(v: Values, border: bool = False) -> list[Flat]:
    """Return rows to and fro; `border`: those of a frame only. ROTX and ROTY turn the two directions, ROT the whole."""
    columns, lines, out = whole_count(v["NUMX"]), whole_count(v["NUMY"]), []
    p, q = math.radians(v["ROT"] + v["ROTX"]), math.radians(v["ROT"] + 90.0 + v["ROTY"])
    for line in range(lines):
        for k in range(columns) if line % 2 == 0 else reversed(range(columns)):
            if not (border and 0 < line < lines - 1 and 0 < k < columns - 1):
                a, b = k * v["DX"], line * v["DY"]
                out.append(
                    (v["X"] + a * math.cos(p) + b * math.cos(q), v["Y"] + a * math.sin(p) + b * math.sin(q))
                )
    return out


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


_AT = "X mm!, Y mm!, Z mm"
_MATRIX = f"{_AT}, DX mm!, DY mm!, NUMX count!, NUMY count!, ROT plain, ROTX plain, ROTY plain"
SHAPES: Mapping[
    str, Cycle[Callable[[Values], list[Flat]]]
] = {  # of PATTERN DEF, lengths in the unit of the program
    "POS": cycle(_AT, lambda v: [(v["X"], v["Y"])]),
    "ROW": cycle(f"{_AT}, D mm!, NUM count!, ROT deg", holes_in_a_row),
    "PAT": cycle(_MATRIX, matrix),
    "FRAME": cycle(_MATRIX, partial(matrix, border=True)),
    "CIRC": cycle(f"{_AT}, D mm!, NUM count!, START plain", ring),
    "PITCHCIRC": cycle(f"{_AT}, D mm!, STEP plain!, NUM count!, START plain", ring),
}
PATTERNS: Mapping[str, Cycle[Callable[[Values], list[Flat]]]] = {
    "220": cycle("Q216=x mm!, Q217=y mm!, Q244=diameter mm!, Q245=first plain!, Q246=last plain!, Q247=step plain!, Q241=count count!", circle_points),
    "221": cycle("Q225=x mm!, Q226=y mm!, Q237=along mm!, Q238=across mm!, Q242=columns count!, Q243=rows count!, Q224=turn deg!", row_points),
}  # fmt: skip
