"""TCH PROBE 0: a coordinate into a Q parameter.

Source: HEIDENHAIN, TNC 640 User's Manual Cycle Programming, "Touch probe cycles": to the nominal position, back by the set-up
clearance, then along the axis; the result, the radius of the ball taken into account, in the Q parameter named in the cycle.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from vcmm.program.heidenhain.text import KlartextReader
from vcmm.program.heidenhain.words import read_words
from vcmm.program.probing import Feeler, at
from vcmm.program.recorder import Recorder

CLEARANCE = 2.0  # mm beside the ball at which probing begins: SET_UP of the touch probe table, whose value is the machine's
FEED = 2000.0  # mm/min, FMAX of that table


@dataclass(eq=False)
class KlartextProbing:
    """The cycles, on a recorder; probe_block: result, axis and sense of TCH PROBE 0.0."""

    recorder: Recorder
    values: dict[str, float] = field(default_factory=dict)  # Q parameters of the program
    probe_block: tuple[str, int, float] = ("", 0, 0.0)

    def first(self, reader: KlartextReader) -> None:
        """Read TCH PROBE 0.0 REF. PLANE Q5 X-"""
        while not reader.is_done and not reader.is_parameter():
            reader.at += 1
        name = reader.parameter()
        axis = "XYZ".find(reader.upper())
        if axis < 0 or reader.upper(1) not in ("+", "-"):
            raise reader.fault(
                "TCH PROBE 0.0 takes a Q parameter, an axis and a direction, as in TCH PROBE 0.0 REF. PLANE Q5 X-"
            )
        self.probe_block = (name, axis, 1.0 if reader.upper(1) == "+" else -1.0)
        reader.at += 2

    def second(self, reader: KlartextReader) -> None:
        """Read TCH PROBE 0.1 X+5 Y+0 Z-5: probes."""
        name, axis, sense = self.probe_block
        r, words = self.recorder, read_words(reader, ())
        if not name:
            raise reader.fault("TCH PROBE 0.1 has no TCH PROBE 0.0 before it")
        target = r.p
        for i, letter in enumerate("XYZ"):
            if letter in words.values:
                target = at(target, i, words.values[letter] * r.unit)
        self.values[name] = self.probe(target, axis, sense) / r.unit
        for k, value in enumerate(r.skip or ()):
            self.values[f"Q{115 + k}"] = value / r.unit
        self.probe_block = ("", 0, 0.0)

    def probe(self, target: tuple[float, float, float], axis: int, sense: float) -> float:
        """Return the coordinate of the surface expected at `target` (mm), along an axis in a sense."""
        r = self.recorder
        feeler = Feeler(r, r.tool_data)
        before, r.feed_mode, r.feed = (r.feed_mode, r.feed), "G94", FEED
        r.straight(at(target, axis, target[axis] - sense * (CLEARANCE + feeler.radius)), True)
        reads = feeler.surface(axis, target[axis], sense)
        r.feed_mode, r.feed = before
        return reads
