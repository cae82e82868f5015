"""CYCL DEF of Klartext: datum shift, mirror, dwell, rotation, scaling, tolerance, preset, drilling (200).

Source: HEIDENHAIN, TNC 640 User's Manual Cycle Programming. Transformations are applied in the order shift, mirror,
rotation, scaling, the later inside the earlier.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from vcmm.nc.drilling import Hole
from vcmm.nc.frames import AffineMap, rotation, stretched, translation
from vcmm.nc.heidenhain.text import KlartextReader
from vcmm.nc.heidenhain.traces import words_of
from vcmm.nc.moves import PLANES, Point
from vcmm.nc.recorder import Recorder
from vcmm.nc.trace import WordAt

AXES = "XYZ"


@dataclass(eq=False)
class KlartextCycles:
    """Transformations and the machining cycle that are defined."""

    recorder: Recorder
    shift: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    mirrored: frozenset[int] = frozenset()
    turn: float = 0.0  # deg
    scale: float = 1.0
    drilling: dict[str, float] | None = None
    name: str = ""
    words: Mapping[str, WordAt] = field(default_factory=dict)  # of the definition, where traces are kept

    def define(self, reader: KlartextReader, parameters: dict[str, float]) -> None:
        """One CYCL DEF block."""
        token = reader.peek()
        if token is None or token.kind != "number":
            raise reader.fault("CYCL DEF takes the number of a cycle, as in CYCL DEF 7.0 or CYCL DEF 200")
        reader.at += 1
        number, _, part = token.text.replace(",", ".").partition(".")
        if number == "200" or number == "247":
            values = self.q_values(reader, parameters)
            if number == "247":
                self.preset(values, token.column)
                return
            self.drill_data(values, token.column)
            if self.recorder.tracer is not None:
                self.words = words_of(reader, self.recorder.tracer)
            return
        handler = _CLASSIC.get(number)
        if handler is None:
            name = reader.rest()
            raise reader.fault(
                f"CYCL DEF {token.text} {name.strip()} is not understood; known are 7 8 9 10 11 13 32 200 247, write the motion with L, C, CR",
                token.column,
            )
        if not part or int(part) == 0:
            reader.rest()  # its name
            if number == "32":
                self.recorder.tolerance = None
            return
        handler(self, reader)

    def q_values(self, reader: KlartextReader, parameters: dict[str, float]) -> dict[str, float]:
        """The Q200=... of a cycle; they are parameters like any other."""
        given: dict[str, float] = {}
        while not reader.done:
            if not reader.is_parameter() or reader.upper(2) != "=":
                reader.at += 1  # the name of the cycle
                continue
            name = reader.parameter()
            reader.expect("=", f"after {name}")
            begin = reader.at
            given[name] = parameters[name] = reader.value(name)
            reader.spans[name] = (begin - 3, begin, reader.at)
        return given

    def rebuild(self) -> None:
        made = translation((self.shift[0], self.shift[1], self.shift[2]))
        if self.mirrored:
            made = made.then(stretched(_three([-1.0 if k in self.mirrored else 1.0 for k in range(3)])))
        made = made.then(rotation(PLANES[self.recorder.plane][2], math.radians(self.turn)))
        if self.scale != 1.0:
            made = made.then(stretched((self.scale, self.scale, self.scale)))
        self.recorder.set_frame(made if made != AffineMap() else AffineMap())

    # -- classic cycles --
    def datum(self, reader: KlartextReader) -> None:
        """7: X Y Z, absolute from the preset or incremental."""
        if reader.upper() == "#":
            raise reader.fault("a datum shift from a datum table (#) is not understood; write its X Y Z")
        while not reader.done:
            name = reader.upper()
            axis = AXES.find(name[-1:]) if name in (*AXES, *(f"I{a}" for a in AXES)) else -1
            if axis < 0:
                raise reader.fault(f'a datum shift takes X, Y, Z, "{reader.upper()}" stands there')
            column = reader.column
            reader.at += 1
            value = reader.value(name) * self.recorder.unit
            value = self.shift[axis] + value if name[0] == "I" else value
            if (
                value != self.shift[axis]
                and value != 0.0
                and (self.turn or self.mirrored or self.scale != 1.0)
            ):
                raise reader.fault(
                    "a datum shift after rotation, mirror or scaling is not understood; shift first, then rotate",
                    column,
                )
            self.shift[axis] = value
        self.rebuild()

    def mirror(self, reader: KlartextReader) -> None:
        """8: the axes that are mirrored; none ends it."""
        axes = reader.rest().upper()
        if any(a not in AXES for a in axes):
            raise reader.fault(f"a mirror image takes X, Y, Z, got {axes}")
        if axes and self.turn:
            raise reader.fault("mirror and rotation together are not understood; use one of them")
        self.mirrored = frozenset(AXES.index(a) for a in axes)
        self.rebuild()

    def rotate(self, reader: KlartextReader) -> None:
        """10: ROT, absolute or incremental, deg."""
        incremental = reader.accept("IROT")
        if not incremental:
            reader.expect("ROT", "of the rotation, as in CYCL DEF 10.1 ROT+35")
        value = reader.value("ROT")
        self.turn = self.turn + value if incremental else value
        if self.turn and self.mirrored:
            raise reader.fault("mirror and rotation together are not understood; use one of them")
        self.rebuild()

    def enlarge(self, reader: KlartextReader) -> None:
        """11: SCL."""
        reader.expect("SCL", "of the scaling, as in CYCL DEF 11.1 SCL 0.99")
        value = reader.value("SCL")
        if value <= 0:
            raise reader.fault("SCL must be above zero")
        self.scale = value
        self.rebuild()

    def wait(self, reader: KlartextReader) -> None:
        """9: DWELL in seconds; acts at once."""
        for word in ("DWELL", "V", ".", "ZEIT", "TIME"):
            reader.accept(word)
        self.recorder.dwell(reader.value("DWELL"))

    def tolerance(self, reader: KlartextReader) -> None:
        """32: T in mm; HSC mode and TA are passed over."""
        if reader.accept("T"):
            self.recorder.tolerance = reader.value("T") * self.recorder.unit
        reader.rest()

    def nothing(self, reader: KlartextReader) -> None:
        reader.rest()

    # -- cycles with Q parameters --
    def preset(self, values: dict[str, float], column: int) -> None:
        """247: preset number Q339; 1 is G54 of the set-up, 2 is G55 ..."""
        number = round(values.get("Q339", 0.0))
        if not 1 <= number <= 6:
            self.recorder.fault(
                f"preset {number} has no work offset in the set-up; presets 1 to 6 are G54 to G59 there",
                column,
            )
        self.recorder.set_offset(f"G{53 + number}")

    def drill_data(self, values: dict[str, float], column: int) -> None:
        for name in ("Q200", "Q201", "Q206", "Q202", "Q203"):
            if name not in values:
                self.recorder.fault(f"cycle 200 has no {name}; add it", column)
        if values["Q201"] >= 0 or values["Q202"] <= 0:
            self.recorder.fault(
                "cycle 200 needs a negative depth Q201 and a positive plunging depth Q202", column
            )
        self.drilling = values

    def call(self) -> None:
        """CYCL CALL, M99: cycle 200 at the point reached.

        Rapid to Q203 + Q200; feed Q206 by Q202; rapid back to the set-up clearance, dwell Q210, rapid to Q200 above the
        depth reached; at the bottom dwell Q211; rapid out to the set-up clearance or, if higher, the second one, Q204.
        """
        q, r = self.drilling, self.recorder
        if q is None:
            r.fault("a cycle is called, but none is defined; add CYCL DEF 200 before")
        surface, clear = q["Q203"] * r.unit, q["Q200"] * r.unit
        final, step = surface + q["Q201"] * r.unit, q["Q202"] * r.unit
        depths = [max(surface - step, final)]
        while depths[-1] > final + 1e-9:
            depths.append(max(depths[-1] - step, final))
        r.marker = "CYCL DEF 200"
        if r.tracer is not None:
            r.tracer.cycle = self.words
        feed, r.feed = r.feed, q["Q206"] * (2.54 if r.unit > 1.0 else 1.0)
        mode, r.feed_mode = r.feed_mode, "G94"
        retract = surface + max(clear, q.get("Q204", 0.0) * r.unit)
        hole = Hole(r, surface + clear, final, retract, idle=True)
        hole.to(hole.clearance, True)
        hole.pecks(depths, lambda depth: min(depth + clear, hole.clearance), pause=q.get("Q210", 0.0))
        hole.wait(q.get("Q211", 0.0))
        hole.leave()
        r.feed, r.feed_mode, r.marker = feed, mode, ""


def _three(values: list[float]) -> Point:
    return values[0], values[1], values[2]


_CLASSIC: dict[str, Callable[[KlartextCycles, KlartextReader], None]] = {
    "7": KlartextCycles.datum, "8": KlartextCycles.mirror, "9": KlartextCycles.wait, "10": KlartextCycles.rotate, "11": KlartextCycles.enlarge, "13": KlartextCycles.nothing,
    "32": KlartextCycles.tolerance,
}  # fmt: skip
