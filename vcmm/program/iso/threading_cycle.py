"""G76 of LinuxCNC: a thread in several passes along a drive line, expanded into single moves.

P pitch, Z end of the drive line, I offset of the thread peak (negative: outside thread), J first depth, K full depth, R
degression (depth of pass n = J n^(1/R); 1 equal steps, 2 equal areas), Q compound angle in degrees, H spring passes, E
length of the tapers along the drive line, L which ends: 0 none, 1 entry, 2 exit, 3 both. I, J and K are radii, with G7 diameters.
Each pass retracts by |I| + K; the last one ends beside Z.
Source: LinuxCNC documentation, G76 Threading Cycle; positions checked against the output of its own test of G76.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from vcmm.program.cycle_tables import Values, cycle
from vcmm.program.faults import BlockFault
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.control import IsoControl
from vcmm.program.iso.lengths import read_words
from vcmm.program.iso.motion import thread_to
from vcmm.program.moves import Point

MOST_PASSES = 1000
THREAD = cycle(
    "P=pitch mm!, I=peak radius!, J=first radius!, K=full radius!, R=degression plain?, Q=angle deg, H=springs count, E=taper mm, L=where count",
    None,
)


def depths(first: float, full: float, degression: float, springs: int) -> list[float]:
    """Return the depth of each pass below the peak, mm: J n^(1/R) up to K, and K again for every spring pass."""
    out: list[float] = []
    while True:
        depth = first * (len(out) + 1) ** (1.0 / degression)
        if depth >= full * (1.0 - 1e-9):
            return [*out, full, *[full] * springs]
        out.append(depth)
        if len(out) > MOST_PASSES:
            raise BlockFault(1, f"G76 needs more than {MOST_PASSES} passes; make J larger")


def thread_cycle(c: IsoControl, w: IsoWords) -> None:
    """Execute a block with G76."""
    column = c.column
    if c.plane != "ZX":
        raise BlockFault(column, "G76 (threading) needs the plane ZX; write G18 before")
    if c.compensation is not None:
        raise BlockFault(column, "G76 while cutter radius compensation is on; cancel it with G40 before")
    end = _end(c, w, column)
    for name in THREAD.required_names:
        w.need(name, f"G76 needs P, Z, I, J and K; {name} is absent", column)
    v = read_words(c, w, THREAD)
    _check(w, v)
    degression, taper, where = v.without("degression", 1.0), v["taper"], v.number("where")
    if degression < 1.0:
        raise BlockFault(w.column("R"), "the degression R of G76 must be 1 or more")
    if where > 3 or (where and (taper <= 0 or taper > abs(end - c.p[2]) / (2 if where == 3 else 1))):
        raise BlockFault(column, "the tapers of G76 need L 0 to 3 and a length E that fits into the thread")
    thread = _Thread(c, c.p, end, v)
    for depth in depths(v["first"], v["full"], degression, v.number("springs")):
        thread.cut(depth)


def _end(c: IsoControl, w: IsoWords, column: int) -> float:
    z = w.need("Z", "the end of the drive line", column) * c.unit
    x = w.take("X")
    if (
        x is not None
        and abs((x * c.unit / (2.0 if c.diametral() else 1.0) if c.absolute else x + c.p[0]) - c.p[0]) > 1e-9
    ):
        raise BlockFault(w.column("X"), "tapered threads (X in G76) are not understood; leave X out")
    return z if c.absolute else c.p[2] + z


def _check(w: IsoWords, v: Values) -> None:
    if v["pitch"] <= 0:
        raise BlockFault(w.column("P"), "the pitch P of G76 must be positive")
    if v["peak"] == 0:
        raise BlockFault(
            w.column("I"),
            "I of G76, the offset of the thread peak, cannot be zero; negative is an outside thread",
        )
    if not 0 < v["first"] <= v["full"]:
        raise BlockFault(w.column("J"), "G76 needs a first depth J above zero and not above the full depth K")


@dataclass(frozen=True, eq=False)
class _Thread:
    """Data common to all passes."""

    c: IsoControl
    start: Point
    end: float
    v: Values

    def cut(self, depth: float) -> None:
        """Cut one pass. The deepest ends at Z; shallower ones begin and end earlier, by the advance that is still to come."""
        v, slope = self.v, math.tan(self.v["angle"])  # advance along the thread per depth, along the flank
        away = -1.0 if v["peak"] > 0 else 1.0
        way = 1.0 if self.end > self.start[2] else -1.0
        x = self.start[0] + v["peak"] - away * depth
        clear = x + away * (abs(v["peak"]) + v["full"])
        begin = self.start[2] + way * depth * slope
        end = self.end - way * (v["full"] - depth) * slope
        self._rapid(clear, begin)
        if v.number("where") & 1:
            self._rapid(x + away * v["full"], begin)
            self._feed(x, begin + way * v["taper"])
        else:
            self._rapid(x, begin)
        if v.number("where") & 2:
            self._feed(x, end - way * v["taper"])
            self._feed(x + away * v["full"], end)
        else:
            self._feed(x, end)
        self._rapid(clear, end)

    def _rapid(self, x: float, z: float) -> None:
        self.c.straight((x, self.start[1], z), True)

    def _feed(self, x: float, z: float) -> None:
        """Set the feed: the pitch counts along the axis, so that the lead along a taper is longer."""
        dx, dz = x - self.c.p[0], z - self.c.p[2]
        lead = self.v["pitch"] * math.hypot(dx, dz) / abs(dz)
        thread_to(self.c, (x, self.start[1], z), lead)
