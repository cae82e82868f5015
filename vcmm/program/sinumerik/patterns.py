"""Hole patterns of Sinumerik as a table: HOLES1 HOLES2 CYCLE801 CYCLE802.

Source: Siemens, SINUMERIK 840D sl / 828D, Programming Manual Cycles (HMI), "Drilling patterns".
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from vcmm.program.cutter import CycleCutter
from vcmm.program.cycle_tables import Cycle, Values, cycle
from vcmm.program.drilling import whole_count
from vcmm.program.sinumerik.blocks import Item
from vcmm.program.sinumerik.flow import SinumerikRunner
from vcmm.program.sinumerik.paths import SinumerikPaths

Spots = list[tuple[float, float]]
Pattern = Callable[[SinumerikPaths, Values], Spots]


def row(i: SinumerikPaths, v: Values) -> Spots:
    """HOLES1: on a line, from the end that is nearer to the tool."""
    w = v["STA1"]
    out = [
        (
            v["SPCA"] + (v["FDIS"] + k * v["DBH"]) * math.cos(w),
            v["SPCO"] + (v["FDIS"] + k * v["DBH"]) * math.sin(w),
        )
        for k in range(whole_count(v["NUM"]))
    ]
    here = CycleCutter(i.r).here()
    return out[::-1] if out and math.dist(out[-1], here) < math.dist(out[0], here) else out


def ring(i: SinumerikPaths, v: Values) -> Spots:
    """HOLES2: on a circle; INDA 0 spreads them evenly."""
    step = v["INDA"] or 360.0 / max(v["NUM"], 1.0)
    angles = [math.radians(v["STA1"] + k * step) for k in range(whole_count(v["NUM"]))]
    return [(v["CPA"] + v["RAD"] * math.cos(w), v["CPO"] + v["RAD"] * math.sin(w)) for w in angles]


def grid(i: SinumerikPaths, v: Values) -> Spots:
    """CYCLE801: rows to and fro, along the shorter of the two distances."""
    w, along = v["STA"], v["DIS1"] <= v["DIS2"]
    counts = whole_count(abs(v["NUM1"])), whole_count(abs(v["NUM2"]))
    inner, outer = counts if along else counts[::-1]
    out: Spots = []
    for line in range(outer):
        for k in range(inner) if line % 2 == 0 else reversed(range(inner)):
            x, y = (k * v["DIS1"], line * v["DIS2"]) if along else (line * v["DIS1"], k * v["DIS2"])
            out.append(
                (v["SPCA"] + x * math.cos(w) - y * math.sin(w), v["SPCO"] + x * math.sin(w) + y * math.cos(w))
            )
    return out


def list_spots(i: SinumerikPaths, v: Values) -> Spots:
    """CYCLE802: X0 and Y0 as they are; 9 points at most."""
    count = math.ceil(sum(v.has(name) for k in range(9) for name in (f"X{k}", f"Y{k}")) / 2)
    return [(v[f"X{k}"], v[f"Y{k}"]) for k in range(count)]


PATTERNS: Mapping[str, Cycle[Pattern]] = {
    "HOLES1": cycle("SPCA mm, SPCO mm, STA1 deg, FDIS mm, DBH mm, NUM count", row),
    "HOLES2": cycle("CPA mm, CPO mm, RAD size, STA1 plain, INDA plain, NUM count", ring),
    "CYCLE801": cycle("SPCA mm, SPCO mm, STA deg, DIS1 size, DIS2 size, NUM1 count, NUM2 count", grid),
    "CYCLE802": cycle("XA count, YA count, " + ", ".join(f"X{k} mm?, Y{k} mm?" for k in range(9)), list_spots),
}  # fmt: skip


def visit(i: SinumerikPaths, runner: SinumerikRunner, item: Item, given: Sequence[float | None]) -> None:
    """Rapid to each point; the modal cycle at each."""
    row = PATTERNS[item.name]
    for a, b in row.primitive(i, i.values(row, given)):
        CycleCutter(i.r).to((a, b), None, True)
        if i.modes.cycle is not None:
            i.command(runner, i.modes.cycle, 1)
