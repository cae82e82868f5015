"""Front-end for HEIDENHAIN Klartext programs (.h): text -> canonical moves. What is understood stands in the docs.

Source: HEIDENHAIN, TNC 640 User's Manual Klartext Programming, "Subprograms and program section repeats" for LBL.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from vcmm.core.errors import choose_from
from vcmm.nc.faults import BlockFault, ProgramFault
from vcmm.nc.heidenhain.cycles import KlartextCycles
from vcmm.nc.heidenhain.paths import KlartextPaths
from vcmm.nc.heidenhain.text import KlartextBlock, KlartextReader, blocks_of, tokenize
from vcmm.nc.heidenhain.tools import call_tool, define_tool
from vcmm.nc.heidenhain.traces import cuts_of, words_of
from vcmm.nc.heidenhain.words import read_words
from vcmm.nc.moves import Program, Source
from vcmm.nc.recorder import Recorder
from vcmm.nc.setup import Setup
from vcmm.nc.trace import BlockPlace, ExecutedBlock, WordAt
from vcmm.nc.tracer import Tracer, lines_with_ends

__all__ = ["read", "tokenize"]
LONGEST = 500_000  # blocks executed again before a program counts as endless
DEEPEST = 19  # nested subprograms, as on the control
CONDITIONS: dict[str, Callable[[float, float], bool]] = {
    "EQU": lambda a, b: math.isclose(a, b, rel_tol=1e-12, abs_tol=1e-12),
    "NE": lambda a, b: not math.isclose(a, b, rel_tol=1e-12, abs_tol=1e-12),
    "GT": lambda a, b: a > b,
    "LT": lambda a, b: a < b,
}


def read(text: str, file: str, setup: Setup, trace: bool = False) -> Program:
    """The moves of a program. `file` is its name for messages.

    Raises ProgramFault (file, line, column, reason, fix) for what cannot be understood, and ModelLimit for a contour that
    the tool cannot follow.
    """
    recorder = Recorder(file=file, setup=setup, dialect="heidenhain")
    if trace:
        recorder.tracer = Tracer([line for line, _ in lines_with_ends(text)])
    paths = KlartextPaths(recorder, KlartextCycles(recorder))
    recorder.finishes.append(paths.finish)
    _Runner(recorder, paths, blocks_of(text)).run()
    return recorder.program()


@dataclass(eq=False)
class _Runner:
    recorder: Recorder
    paths: KlartextPaths
    lines: list[KlartextBlock]
    parameters: dict[str, float] = field(default_factory=dict)
    labels: dict[str, int] = field(default_factory=dict)
    returns: list[int] = field(default_factory=list)
    left: dict[int, int] = field(default_factory=dict)  # repetitions left, by block
    at: int = 0
    pole: dict[str, WordAt] = field(default_factory=dict)  # words of the CC in force, where traces are kept

    def run(self) -> None:
        self.find_labels()
        executed = 0
        while self.at < len(self.lines):
            line = self.lines[self.at]
            self.recorder.source = Source(line.number, line.first, line.last)
            executed += 1
            if executed > LONGEST + len(self.lines):
                self.recorder.fault(
                    f"more than {LONGEST} blocks have been executed again; the program seems to be endless, check its jumps"
                )
            self.at += 1
            try:
                if self.traced(KlartextReader(line.tokens, self.parameters, self.unset), line):
                    return
            except BlockFault as fault:
                raise ProgramFault(
                    self.recorder.file, line.number, max(fault.column, 1), fault.text
                ) from None

    def traced(self, reader: KlartextReader, line: KlartextBlock) -> bool:
        """One block, and what is noted of it."""
        tracer = self.recorder.tracer
        if tracer is None:
            return self.block(reader)
        made, call = len(self.recorder.moves), len(self.returns)
        before = self.recorder.modal()
        over = self.block(reader)
        file = self.recorder.file
        tracer.step(ExecutedBlock(file, line.number, line.tokens[-1].line, call, tuple(cuts_of(reader))))
        words = words_of(reader, tracer)
        if words["path"].text == "CC":
            self.pole = {f"CC {k}": w for k, w in words.items()}
        tracer.note(self.recorder, made, before, {**words, **self.pole}, BlockPlace(file, line.number, call))
        return over

    def unset(self, name: str) -> None:
        self.recorder.remark(f"{name} is used before it is set; 0 is taken")

    def find_labels(self) -> None:
        for k, line in enumerate(self.lines):
            words = [t.text.upper() for t in line.tokens]
            if words[0] != "LBL" or len(words) < 2 or words[1] == "0":
                continue
            if words[1] in self.labels:
                raise ProgramFault(
                    self.recorder.file,
                    line.number,
                    line.first,
                    f"LBL {words[1]} stands twice in this program; rename one",
                )
            self.labels[words[1]] = k

    def block(self, reader: KlartextReader) -> bool:
        """One block. True at the end of the program."""
        word, paths = reader.upper(), self.paths
        if reader.is_parameter():
            self.assign(reader)
            return False
        if word in ("C", "CR", "CT", "CP", "CTP"):
            reader.at += 1
            return paths.circle(reader, word)
        simple: dict[str, Callable[[KlartextReader], bool | None]] = {
            "L": paths.straight, "LP": paths.polar_line, "CC": paths.set_pole, "APPR": paths.approach, "DEP": paths.departure,
            "RND": lambda r: paths.corner(r, "round"), "CHF": lambda r: paths.corner(r, "chamfer"), "BEGIN": self.begin, "END": self.end,
            "BLK": self.blank, "TOOL": self.tool, "LBL": self.label, "CALL": self.call, "FN": self.function, "CYCL": self.cycle,
            "CYCLE": self.cycle, "STOP": self.stop,
        }  # fmt: skip
        if word in simple:
            reader.at += 1
            over = bool(simple[word](reader))
            if not reader.done:
                raise reader.fault(f'"{reader.upper()}" cannot be understood behind {word}; remove it')
            return over
        if word == "M":
            return self.functions(reader)
        return self.unknown(reader, [*simple, "C", "CR", "CT", "CP", "CTP", "Q"])

    def unknown(self, reader: KlartextReader, known: list[str]) -> bool:
        token = reader.peek()
        assert token is not None
        raise reader.fault(
            f"{token.text} is not understood.{choose_from(token.text.upper(), known)} Rewrite the block with these"
        )

    def functions(self, reader: KlartextReader) -> bool:
        """A block of M functions only."""
        words = read_words(reader, ())
        self.paths.technology(words)
        return self.paths.after(words)

    def stop(self, reader: KlartextReader) -> bool:
        """STOP with M functions: they act as in a block of their own, and M2 and M30 end the program."""
        return self.functions(reader)

    # -- frame of the program --
    def begin(self, reader: KlartextReader) -> None:
        """BEGIN PGM NAME MM | INCH."""
        reader.expect("PGM", "after BEGIN")
        unit = reader.tokens[-1].text.upper()
        if unit not in ("MM", "INCH"):
            raise reader.fault("BEGIN PGM ends with the unit, MM or INCH")
        self.recorder.unit = 25.4 if unit == "INCH" else 1.0
        reader.rest()

    def end(self, reader: KlartextReader) -> bool:
        reader.rest()
        return True

    def blank(self, reader: KlartextReader) -> None:
        """BLK FORM: the raw part; for simulation graphics, moves nothing."""
        reader.rest()

    def tool(self, reader: KlartextReader) -> None:
        if reader.accept("CALL"):
            call_tool(self.paths, reader)
        elif reader.accept("DEF"):
            define_tool(self.paths, reader)
        else:
            raise reader.fault("TOOL is followed by CALL or DEF")

    def cycle(self, reader: KlartextReader) -> None:
        """CYCL DEF, CYCL CALL; CYCLE is taken for CYCL with a remark."""
        if reader.upper(-1) == "CYCLE":
            self.recorder.remark("CYCLE is read as CYCL")
        if reader.accept("DEF"):
            self.paths.cycles.define(reader, self.parameters)
        elif reader.accept("CALL"):
            words = read_words(reader, ())
            self.paths.technology(words)
            self.paths.cycles.call()
        else:
            raise reader.fault("CYCL is followed by DEF or CALL (without POS or PAT)")

    # -- labels --
    def name(self, reader: KlartextReader) -> str:
        token = reader.peek()
        if token is None or token.kind not in ("number", "string"):
            raise reader.fault('a label is a number or a name in quotes, as in LBL 1 or LBL "SLOT"')
        reader.at += 1
        return token.text.upper()

    def label(self, reader: KlartextReader) -> None:
        """LBL 0 ends a subprogram that has been called."""
        if self.name(reader) == "0" and self.returns:
            self.at = self.returns.pop()

    def find(self, reader: KlartextReader) -> int:
        column, name = reader.column, self.name(reader)
        if name not in self.labels:
            raise reader.fault(
                f"there is no LBL {name}; add it or correct the call.{choose_from(name, self.labels)}", column
            )
        return self.labels[name]

    def call(self, reader: KlartextReader) -> None:
        """CALL LBL n [REP m]: a subprogram, or a repetition of the blocks between label and call."""
        here = self.at - 1
        if not reader.accept("LBL"):
            raise reader.fault(
                f"CALL {reader.upper()} is not understood; put the called program into this file as LBL ... LBL 0"
            )
        target = self.find(reader)
        if reader.accept("REP"):
            times = round(reader.value("REP"))
            if reader.accept("/"):
                reader.value("REP")
            remaining = self.left.pop(here, times)
            if remaining > 0:
                self.left[here] = remaining - 1
                self.at = target
            return
        if len(self.returns) >= DEEPEST:
            raise reader.fault(f"subprograms are nested deeper than {DEEPEST}; does a label call itself?")
        self.returns.append(self.at)
        self.at = target

    # -- Q parameters --
    def assign(self, reader: KlartextReader) -> None:
        """Q1 = formula."""
        name = reader.parameter()
        reader.expect("=", f"after {name}")
        self.parameters[name] = reader.formula()
        if not reader.done:
            raise reader.fault(f'"{reader.upper()}" cannot be understood in a formula')

    def function(self, reader: KlartextReader) -> None:
        """FN 0 to FN 13, FN 18 for the present position."""
        column = reader.column
        code = round(reader.value("FN"))
        reader.expect(":", f"after FN {code}")
        if 9 <= code <= 12:
            self.jump(reader)
        elif code == 18:
            self.system_data(reader, column)
        elif code in (0, 1, 2, 3, 4, 5, 6, 7, 8, 13):
            self.calculate(reader, code)
        else:
            raise reader.fault(f"FN {code} is not understood; use a formula (Q1 = ...) or remove it", column)

    def calculate(self, reader: KlartextReader, code: int) -> None:
        name = reader.parameter()
        reader.expect("=", f"after {name}")
        bracketed = reader.upper() == "("
        first = reader.single() if bracketed else self.operand(reader, code)
        if code in (0, 5, 6, 7):
            value = {
                0: lambda x: x,
                5: math.sqrt,
                6: lambda x: math.sin(math.radians(x)),
                7: lambda x: math.cos(math.radians(x)),
            }[code](first)
        else:
            word = {1: "+", 2: "-", 3: "*", 4: "DIV", 8: "LEN", 13: "ANG"}[code]
            if not (reader.accept(word) or (code == 4 and reader.accept("/"))):
                raise reader.fault(f'"{word}" is due between the two values of FN {code}')
            second = reader.value("FN")
            if code == 4 and second == 0.0:
                raise reader.fault("division by zero; check the parameters used here")
            value = _two(code, first, second)
        self.parameters[name] = float(value)

    def operand(self, reader: KlartextReader, code: int) -> float:
        for word in {5: ("SQRT",), 6: ("SIN",), 7: ("COS",)}.get(code, ()):
            reader.accept(word)
        value = reader.value("FN")
        if code == 5 and value < 0:
            raise reader.fault(f"SQRT {value:g} has no real value; check the parameters")
        return value

    def jump(self, reader: KlartextReader) -> None:
        """IF a EQU | NE | GT | LT b GOTO LBL n."""
        reader.expect("IF", "in a jump, as in FN 9: IF +Q1 EQU +5 GOTO LBL 2")
        first = reader.value("IF")
        word = reader.upper()
        if word not in CONDITIONS:
            raise reader.fault(f"a condition is due here.{choose_from(word, CONDITIONS)}")
        reader.at += 1
        second = reader.value("IF")
        reader.expect("GOTO", "after the condition")
        reader.expect("LBL", "after GOTO")
        target = self.find(reader)
        if CONDITIONS[word](first, second):
            self.at = target

    def system_data(self, reader: KlartextReader, column: int) -> None:
        """FN 18: SYSREAD Q1 = ID270 NR1 IDX1: the present position; nothing else is known before the machine runs."""
        reader.expect("SYSREAD", "after FN 18:")
        name = reader.parameter()
        reader.expect("=", f"after {name}")
        given: dict[str, int] = {}
        for word in ("ID", "NR", "IDX"):
            reader.expect(word, "of SYSREAD, as in ID270 NR1 IDX3")
            given[word] = round(reader.value(word))
        if given["ID"] != 270 or given["NR"] != 1 or given["IDX"] not in (1, 2, 3):
            raise reader.fault(
                f"SYSREAD ID{given['ID']} NR{given['NR']} IDX{given['IDX']} is known to the machine only; set {name} in the program instead",
                column,
            )
        self.parameters[name] = self.recorder.p[given["IDX"] - 1] / self.recorder.unit


def _two(code: int, a: float, b: float) -> float:
    if code == 8:
        return math.hypot(a, b)
    if code == 13:
        return math.degrees(math.atan2(a, b)) % 360.0
    return {1: a + b, 2: a - b, 3: a * b}[code] if code != 4 else a / b
