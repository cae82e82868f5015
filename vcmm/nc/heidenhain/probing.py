"""TCH PROBE 0 (a coordinate into a Q parameter) and 419 (datum in one axis).

Source: HEIDENHAIN, TNC 640 User's Manual Cycle Programming, "Touch probe cycles": 0: to the nominal position, back by the set-up
clearance, then along the axis; the result, the radius of the ball taken into account, in the Q parameter named in the cycle. 419:
the point Q263 Q264 at height Q261 along axis Q272 in sense Q267; it then reads Q333.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from vcmm.nc.heidenhain.text import KlartextReader
from vcmm.nc.heidenhain.words import read_words
from vcmm.nc.moves import ORIGIN
from vcmm.nc.probing import at, ball_radius, corrected_zero, read_surface
from vcmm.nc.recorder import Recorder

CLEARANCE = 2.0  # mm beside the ball at which probing begins: SET_UP of the touch probe table, whose value is the machine's
FEED = 2000.0  # mm/min, FMAX of that table
NEEDED = ("Q263", "Q264", "Q272", "Q267", "Q261")


@dataclass(eq=False)
class KlartextProbing:
    """The cycles, on a recorder; named: result, axis and sense of TCH PROBE 0.0."""

    recorder: Recorder
    values: dict[str, float] = field(default_factory=dict)  # Q parameters of the program
    named: tuple[str, int, float] = ("", 0, 0.0)

    def first(self, reader: KlartextReader) -> None:
        """TCH PROBE 0.0 REF. PLANE Q5 X-"""
        while not reader.done and not reader.is_parameter():
            reader.at += 1
        name = reader.parameter()
        axis = "XYZ".find(reader.upper())
        if axis < 0 or reader.upper(1) not in ("+", "-"):
            raise reader.fault(
                "TCH PROBE 0.0 takes a Q parameter, an axis and a direction, as in TCH PROBE 0.0 REF. PLANE Q5 X-"
            )
        self.named = (name, axis, 1.0 if reader.upper(1) == "+" else -1.0)
        reader.at += 2

    def second(self, reader: KlartextReader) -> None:
        """TCH PROBE 0.1 X+5 Y+0 Z-5: probes."""
        name, axis, sense = self.named
        r, words = self.recorder, read_words(reader, ())
        if not name:
            raise reader.fault("TCH PROBE 0.1 has no TCH PROBE 0.0 before it")
        target = r.p
        for i, letter in enumerate("XYZ"):
            if letter in words.values:
                target = at(target, i, words.values[letter] * r.unit)
        self.values[name] = self.touched(target, axis, sense) / r.unit
        for k, value in enumerate(r.skip or ()):
            self.values[f"Q{115 + k}"] = value / r.unit
        self.named = ("", 0, 0.0)

    def touched(self, target: tuple[float, float, float], axis: int, sense: float) -> float:
        """Coordinate of the surface expected at `target` (mm), along an axis in a sense."""
        r, tool = self.recorder, self.recorder.tool_data
        kept, r.feed_mode, r.feed = (r.feed_mode, r.feed), "G94", FEED
        r.straight(at(target, axis, target[axis] - sense * (CLEARANCE + ball_radius(tool))), True)
        found = read_surface(r, axis, target[axis], sense, tool)
        r.feed_mode, r.feed = kept
        return found

    def _check(self, q: dict[str, float], column: int) -> None:
        """What 419 cannot do without, and what its words may be."""
        missing = next((name for name in NEEDED if name not in q), None)
        if missing:
            self.recorder.fault(f"TCH PROBE 419 needs {missing}; add it", column)
        for name, allowed, means in (
            ("Q272", (1.0, 2.0, 3.0), "1, 2 or 3, the axis along which it measures"),
            ("Q267", (-1.0, 1.0), "-1 or +1, the way to the surface"),
        ):
            if q[name] not in allowed:
                self.recorder.fault(f"TCH PROBE 419: {name} = {q[name]:g} must be {means}", column)

    def datum(self, q: dict[str, float], column: int) -> None:
        """419. What is found reads Q333 in preset Q305 (0: the one in force, 1 to 6: G54 to G59 of the set-up)."""
        r = self.recorder
        self._check(q, column)
        axis, number = round(q["Q272"]) - 1, round(q.get("Q305", 0.0))
        mm = {name: value * r.unit for name, value in q.items()}
        if "Q260" in mm:
            r.straight(at(r.p, 2, mm["Q260"]), True)
            r.straight((mm["Q263"], mm["Q264"], r.p[2]), True)
        found = self.touched((mm["Q263"], mm["Q264"], mm["Q261"]), axis, 1.0 if q["Q267"] > 0 else -1.0)
        if "Q260" in mm:
            r.straight(at(r.p, 2, mm["Q260"]), True)
        if number > 6:
            r.assume(
                f"preset {number}", "not written: the set-up has 1 to 6, which are G54 to G59",
                f"TCH PROBE 419 writes preset {number} (Q305), which the set-up has not; 1 to 6 are G54 to G59 there, 0 is the one in force",
            )  # fmt: skip
            return
        name = r.offset if number == 0 else f"G{53 + number}"
        shifted, own = corrected_zero(r, axis, found, mm.get("Q333", 0.0)), r.offsets.get(name, ORIGIN)
        r.offsets[name] = shifted if name == r.offset else at(own, axis, shifted[axis])
        r.refresh()
