"""CYCL DEF and CYCL CALL of Klartext: the defined cycle, and the time of its call.

Source: HEIDENHAIN, TNC 640 User's Manual Cycle Programming, "Working with cycles". Cycles that define something act where they
stand; machining cycles act at CYCL CALL, M99 and M89. Unmodelled cycles are noted by number and leave a hole in the path.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from vcmm.program.heidenhain.contours import CONTOUR_CYCLES, CONTOUR_DATA, ContourCycles
from vcmm.program.heidenhain.holes import HOLES, OLD_HOLES
from vcmm.program.heidenhain.machining import MachiningCycle, of_row, read_row
from vcmm.program.heidenhain.milling import OLD_POCKETS, POCKETS, THREADS
from vcmm.program.heidenhain.patterns import PATTERNS
from vcmm.program.heidenhain.planes import working_plane
from vcmm.program.heidenhain.text import KlartextReader
from vcmm.program.heidenhain.traces import words_of
from vcmm.program.heidenhain.transforms import KlartextFrames
from vcmm.program.levels import NOT_MOVED
from vcmm.program.moves import PLANES
from vcmm.program.recorder import Recorder
from vcmm.program.trace import WordAt

MACHINING = {**HOLES, **POCKETS, **THREADS}
OLD = {**OLD_HOLES, **OLD_POCKETS}
STRANGE = {  # old cycles that leave a hole in the path, and whether they act where they stand
    "6": ("cycle 6, rough-out", False), "12": ("cycle 12, program call", False), "15": ("cycle 15, pilot drilling", False),
    "16": ("cycle 16, contour milling", False),
    "27": ("cycle 27, cylinder surface", False), "28": ("cycle 28, cylinder surface slot", False),
    "29": ("cycle 29, cylinder surface ridge", False), "30": ("cycle 30, 3-D data", False), "31": ("cycle 31, line of 3-D data", False),
    "39": ("cycle 39, cylinder surface contour", False),
}  # fmt: skip
DATA = range(270, 275)  # contour data: they machine nothing themselves


@dataclass(eq=False)
class KlartextCycles:
    """Transformations and the machining cycle that are defined. call_program: what cycle 12 calls."""

    recorder: Recorder
    frames: KlartextFrames = field(init=False)
    active: MachiningCycle | None = None
    auto_feed: float | None = None
    words: Mapping[str, WordAt] = field(default_factory=dict)  # of the definition, where traces are kept
    program: Callable[[str], None] = lambda name: None
    program_name: str = ""  # the program of cycle 12
    contours: ContourCycles = field(default_factory=ContourCycles)

    def __post_init__(self) -> None:
        self.frames = KlartextFrames(self.recorder)

    def define(self, reader: KlartextReader, parameters: dict[str, float]) -> None:
        """Read one CYCL DEF block."""
        token = reader.peek()
        if token is None or token.kind != "number":
            raise reader.fault("CYCL DEF takes the number of a cycle, as in CYCL DEF 7.0 or CYCL DEF 200")
        reader.at += 1
        number, dot, part = token.text.replace(",", ".").partition(".")
        number = str(int(number)) if number else "0"
        if not dot and int(number) >= 200:
            self.with_parameters(number, reader, parameters, token.column)
            return
        if number in ("20", *CONTOUR_CYCLES) and not dot:
            self.of_contours(number, reader, parameters, token.column)
            return
        self.classic(number, int(part or 0), reader, token.column)

    # -- 200 and above --
    def with_parameters(
        self, number: str, reader: KlartextReader, parameters: dict[str, float], column: int
    ) -> None:
        """Define a cycle whose data are Q parameters."""
        values = self.q_values(reader, parameters)
        if number == "247":
            self.frames.preset(round(values.get("Q339", 0.0)))
        elif number in PATTERNS:
            self.pattern(number, values, column)
        elif number in MACHINING:
            row = MACHINING[number]
            self.check(number, row.required_names, values, column)
            self.active = MachiningCycle(self.recorder, number, values, of_row(row), self.auto_feed)
            if self.recorder.tracer is not None:
                self.words = words_of(reader, self.recorder.tracer)
        elif int(number) in DATA:
            self.strange(f"cycle {number}", "passed over: its data belong to cycles of contours", column)
        else:
            self.active = MachiningCycle(self.recorder, number, values, _missing, self.auto_feed)
            if int(number) >= 400 or self.recorder.setup.strict:  # touch probe cycles act where they stand
                self.strange(f"cycle {number}", NOT_MOVED, column)

    def of_contours(
        self, number: str, reader: KlartextReader, parameters: dict[str, float], column: int
    ) -> None:
        """Define cycle 20, data that 21 to 24 take; or 21 to 25, cycles over the contours of cycle 14."""
        values = self.q_values(reader, parameters)
        if number == "20":
            self.contours.data = values
            return
        if number != "25":
            self.check("20", CONTOUR_DATA.required_names, self.contours.data, column)
            values = {**self.contours.data, **values}
        self.check(number, CONTOUR_CYCLES[number].required_names, values, column)
        self.active = MachiningCycle(self.recorder, number, values, self.contours.mill, self.auto_feed)
        if self.recorder.tracer is not None:
            self.words = words_of(reader, self.recorder.tracer)

    def name_contours(self, reader: KlartextReader) -> None:
        """Name the contours of cycle 14.1: CONTOUR LABEL1/2/3."""
        self.contours.labels = re.findall(r"\d+", reader.rest())

    def strange(self, what: str, value: str, column: int = 0) -> None:
        """Note a cycle that is not modelled."""
        self.recorder.assume(
            what, value, column=column or None,
            otherwise=f"{what[:1].upper()}{what[1:]} is not understood; known are 1 to 5, 7 to 11, 13, 14, 17 to 26, 32, 220, 221, 247 and "
            f"{', '.join(MACHINING)}; write the motion with L, C, CR",
        )  # fmt: skip

    def q_values(self, reader: KlartextReader, parameters: dict[str, float]) -> dict[str, float]:
        """Return Q200=... of a cycle; they are parameters like any other. MAX is infinite, AUTO is not a number."""
        given: dict[str, float] = {}
        while not reader.is_done:
            if not reader.is_parameter() or reader.upper(2) != "=":
                reader.at += 1  # the name of the cycle, QS500="text"
                continue
            name = reader.parameter()
            reader.expect("=", f"after {name}")
            begin = reader.at
            given[name] = _feed_word(reader)
            if math.isfinite(given[name]):
                parameters[name] = given[name]
            reader.spans[name] = (begin - 3, begin, reader.at)
        return given

    def check(self, number: str, needed: tuple[str, ...], values: Mapping[str, float], column: int) -> None:
        """Check the values that a machining cycle needs."""
        for name in needed:
            if name not in values:
                self.recorder.fault(f"cycle {number} has no {name}; add it", column)
        if number == "200" and values["Q202"] <= 0:
            self.recorder.fault(
                "cycle 200 needs a negative depth Q201 and a positive plunging depth Q202", column
            )
        depth = values.get("Q201", -1.0)
        if depth > 0 or (depth == 0 and number == "200"):
            what = f"cycle {number} needs a negative depth Q201"
            self.recorder.fault(
                f"{what} and a positive plunging depth Q202" if number == "200" else what, column
            )

    def pattern(self, number: str, values: Mapping[str, float], column: int) -> None:
        """Run 220 and 221: the machining cycle in force at the points of a circle or of rows, at once."""
        c = self.active
        if c is None:
            self.recorder.fault(f"cycle {number} repeats a machining cycle, but none is defined")
        self.check(number, PATTERNS[number].required_names, values, column)
        heights = {k: values[k] for k in ("Q200", "Q203", "Q204") if k in values}
        c = replace(c, values={**c.values, **heights})
        row = PATTERNS[number]
        over = c.second if round(values.get("Q301", 1.0)) == 1 else c.clearance
        c.to(None, None, c.second, True)
        for a, b in row.primitive(read_row(self.recorder, row, values)):
            c.to(a, b, None, True)
            self.run(c)
            c.to(None, None, over, True)
        c.to(None, None, c.second, True)

    # -- below 200 --
    def classic(self, number: str, part: int, reader: KlartextReader, column: int) -> None:
        """Read a block n.0, n.1 ... of an old cycle."""
        if number in OLD:
            self.old(number, part, reader)
        elif number in STRANGE:
            self.refuse_cycle(number, part, reader, column)
        elif number not in _CLASSIC:
            name = reader.rest()
            raise reader.fault(
                f"CYCL DEF {number} {name.strip()} is not a cycle; known are {', '.join([*OLD, *_CLASSIC])}, 200 and above",
                column,
            )
        elif part == 0:
            reader.rest()  # its name
            if number == "32":
                self.recorder.tolerance = None
        else:
            _CLASSIC[number](self, reader)

    def refuse_cycle(self, number: str, part: int, reader: KlartextReader, column: int) -> None:
        """Refuse a cycle of contours, of cylinders, a program called as a cycle."""
        what, at_once = STRANGE[number]
        if number == "12" and part == 1:
            for word in ("PGM", "PROG"):
                reader.accept(word)
            self.program_name = reader.rest()
        reader.rest()
        if part:
            return
        if at_once or self.recorder.setup.strict:
            self.strange(
                what,
                "passed over: its data belong to cycles of contours" if at_once else NOT_MOVED,
                column,
            )
        if not at_once:
            action = (lambda c: self.program(self.program_name)) if number == "12" else _missing
            self.active = MachiningCycle(self.recorder, number, {}, action)

    def old(self, number: str, part: int, reader: KlartextReader) -> None:
        """Read a block of cycles 1 to 5, 17, 18: each block holds one or two numbers, named in the language of the control."""
        if part == 0:
            reader.rest()
            self.active = MachiningCycle(self.recorder, number, {}, of_row(OLD[number].row), self.auto_feed)
            self.words = {}
            return
        if self.active is None or self.active.number != number:
            raise reader.fault(f"CYCL DEF {number}.{part} has no CYCL DEF {number}.0 before it")
        numbers = _numbers(reader)
        blocks = OLD[number].blocks
        names = blocks[part - 1] if part <= len(blocks) else ()
        values = {**self.active.values, **dict(zip(names, (v for k, v in numbers if k != "DR")))}
        values.update({k: v for k, v in numbers if k in ("X", "Y", "DR")})
        self.active = replace(self.active, values=values)

    def wait(self, reader: KlartextReader) -> None:
        """Run cycle 9: DWELL in seconds; acts at once."""
        for word in ("DWELL", "V", ".", "ZEIT", "TIME"):
            reader.accept(word)
        self.recorder.dwell(reader.value("DWELL"))

    def tolerance(self, reader: KlartextReader) -> None:
        """Run cycle 32: T in mm; HSC mode and TA are passed over."""
        if reader.accept("T") and not reader.is_done:
            self.recorder.tolerance = reader.value("T") * self.recorder.unit
        reader.rest()

    def nothing(self, reader: KlartextReader) -> None:
        reader.rest()

    # -- calls --
    def call(self, surface: float = 0.0) -> None:
        """Run the machining cycle at the point reached (CYCL CALL, M99). surface: mm by which its surface lies higher."""
        if self.active is None:
            self.recorder.fault("a cycle is called, but none is defined; add CYCL DEF 200 before")
        c = self.active
        if surface:
            c = replace(c, values={**c.values, "Q203": c.plain("Q203") + surface / self.recorder.unit})
        self.run(c)

    def call_at(self, a: float, b: float, height: float, rapid: bool) -> None:
        """Run the machining cycle for CYCL CALL POS and PAT: at a point of the plane; its height counts on top of the surface of the cycle, mm."""
        if self.active is None:
            self.recorder.fault("a cycle is called, but none is defined; add CYCL DEF 200 before")
        c, (_, _, normal) = self.active, PLANES[self.recorder.plane]
        over = height + c.clearance
        if self.recorder.p[normal] < over:
            c.to(None, None, over, True)
        c.to(a, b, None, rapid)
        self.call(height)

    def run(self, c: MachiningCycle) -> None:
        """Run a machining cycle at the position of the tool, its moves marked."""
        r = self.recorder
        r.marker = c.name if c.action is not _missing and c.number != "12" else ""
        if r.tracer is not None:
            r.tracer.cycle = self.words
        c.action(c)
        r.marker = ""


def _feed_word(reader: KlartextReader) -> float:
    """Return a value of a cycle: a number, MAX or AUTO."""
    for word in ("F", "FU", "FZ"):
        reader.accept(word)
    if reader.accept("MAX") or reader.accept("FMAX"):
        return math.inf
    if reader.accept("AUTO") or reader.accept("FAUTO"):
        return math.nan
    return reader.value("a cycle")


def _numbers(reader: KlartextReader) -> list[tuple[str, float]]:
    """Return the values of a block and the words before them, in order."""
    out: list[tuple[str, float]] = []
    word = ""
    while not reader.is_done:
        token = reader.peek()
        assert token is not None
        if token.kind == "name" and not reader.is_parameter():
            word = token.text.upper()
            reader.at += 1
            if word in ("FMAX", "FAUTO"):
                out.append(("F", math.inf if word == "FMAX" else math.nan))
            elif word == "DR" and reader.upper() in ("+", "-"):
                out.append(("DR", 1.0 if reader.upper() == "+" else -1.0))
                reader.at += 1
        elif token.kind == "symbol" and token.text not in "+-":
            reader.at += 1  # the point of V.ZEIT
        else:
            out.append(
                (word.lstrip("I") if word in ("IX", "IY") else word, reader.value(word or "the cycle"))
            )
    return out


def _missing(c: MachiningCycle) -> None:
    """Note a machining cycle that is not modelled, at its call."""
    what = STRANGE.get(c.number, (f"cycle {c.number}", False))[0]
    c.recorder.assume(what, NOT_MOVED, f"{what} is not understood; write its motion with L, C, CR")


_CLASSIC: dict[str, Callable[[KlartextCycles, KlartextReader], None]] = {
    "7": lambda c, r: c.frames.datum(r), "8": lambda c, r: c.frames.mirror(r), "9": KlartextCycles.wait,
    "10": lambda c, r: c.frames.rotate(r), "11": lambda c, r: c.frames.enlarge(r), "13": KlartextCycles.nothing, "14": KlartextCycles.name_contours,
    "19": lambda c, r: working_plane(c.frames, r), "26": lambda c, r: c.frames.stretch(r), "32": KlartextCycles.tolerance,
}  # fmt: skip
