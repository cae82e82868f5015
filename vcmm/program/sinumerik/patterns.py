"""Hole patterns of Sinumerik as a table: HOLES1 HOLES2 CYCLE801 CYCLE802.

Source: Siemens, SINUMERIK 840D sl / 828D, Programming Manual Cycles (HMI), "Drilling patterns".
"""

from __future__ import annotations

import math

from vcmm.program.cutter import Cutter
from vcmm.program.drilling import whole_count
from vcmm.program.sinumerik.blocks import Item
from vcmm.program.sinumerik.flow import SinumerikRunner
from vcmm.program.sinumerik.paths import SinumerikPaths

Spots = list[tuple[float, float]]
Numbers = list[float | None]


def pad(given: Numbers, count: int) -> list[float]:
    """So many arguments; 0 for those left out."""
    return [v or 0.0 for v in (*given, *[None] * count)][:count]


# -- patterns -----------------------------------------------------------------------------------------------------------
def row(i: SinumerikPaths, given: Numbers) -> Spots:
    """HOLES1(SPCA, SPCO, STA1, FDIS, DBH, NUM): on a line, from the end that is nearer to the tool."""
    a, b, turn, first, step, count = pad(given, 6)
    w, u = math.radians(turn), i.r.unit
    out = [
        ((a + (first + k * step) * math.cos(w)) * u, (b + (first + k * step) * math.sin(w)) * u)
        for k in range(whole_count(count))
    ]
    here = Cutter(i.r).here()
    return out[::-1] if out and math.dist(out[-1], here) < math.dist(out[0], here) else out


def ring(i: SinumerikPaths, given: Numbers) -> Spots:
    """HOLES2(CPA, CPO, RAD, STA1, INDA, NUM): on a circle; INDA 0 spreads them evenly."""
    a, b, radius, start, step, count = pad(given, 6)
    step, u = step or 360.0 / max(count, 1.0), i.r.unit
    angles = [math.radians(start + k * step) for k in range(whole_count(count))]
    return [((a + abs(radius) * math.cos(w)) * u, (b + abs(radius) * math.sin(w)) * u) for w in angles]


def grid(i: SinumerikPaths, given: Numbers) -> Spots:
    """CYCLE801(SPCA, SPCO, STA, DIS1, DIS2, NUM1, NUM2): rows to and fro, along the shorter of the two distances."""
    a, b, turn, d1, d2, n1, n2 = pad(given, 7)
    w, u = math.radians(turn), i.r.unit
    along = abs(d1) <= abs(d2)
    inner, outer = (
        (whole_count(abs(n1)), whole_count(abs(n2)))
        if along
        else (whole_count(abs(n2)), whole_count(abs(n1)))
    )
    out: Spots = []
    for line in range(outer):
        for k in range(inner) if line % 2 == 0 else reversed(range(inner)):
            x, y = (k * abs(d1), line * abs(d2)) if along else (line * abs(d1), k * abs(d2))
            out.append(
                ((a + x * math.cos(w) - y * math.sin(w)) * u, (b + x * math.sin(w) + y * math.cos(w)) * u)
            )
    return out


def list_spots(i: SinumerikPaths, given: Numbers) -> Spots:
    """CYCLE802(_XA, _YA, X0, Y0, X1, Y1, ...): X0 and Y0 as they are; 9 points at most."""
    values = pad(given, 20)[2:]
    count = math.ceil(sum(v is not None for v in given[2:20]) / 2)
    return [(values[2 * k] * i.r.unit, values[2 * k + 1] * i.r.unit) for k in range(count)]


PATTERNS = {"HOLES1": row, "HOLES2": ring, "CYCLE801": grid, "CYCLE802": list_spots}


def visit(i: SinumerikPaths, runner: SinumerikRunner, item: Item, given: Numbers) -> None:
    """Rapid to each point; the modal cycle at each."""
    for a, b in PATTERNS[item.name](i, given):
        Cutter(i.r).to((a, b), None, True)
        if i.modes.cycle is not None:
            i.command(runner, i.modes.cycle, 1)
