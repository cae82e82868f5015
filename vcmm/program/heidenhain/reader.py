"""Front-end for HEIDENHAIN Klartext programs (.h): text -> canonical moves. The docs list the supported blocks.

Source: HEIDENHAIN, TNC 640 User's Manual Klartext Programming, "Subprograms and program section repeats" for LBL.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from vcmm.core.errors import choose_from
from vcmm.program.faults import BlockFault, ProgramFault
from vcmm.program.heidenhain.contour_reading import contour_moves, labels_of
from vcmm.program.heidenhain.cycles import KlartextCycles
from vcmm.program.heidenhain.features import function, transform
from vcmm.program.heidenhain.free import FREE, FreeContours
from vcmm.program.heidenhain.orienting import retracting
from vcmm.program.heidenhain.parameters import KlartextParameters
from vcmm.program.heidenhain.paths import KlartextPaths
from vcmm.program.heidenhain.patterns import Spot, pattern_points
from vcmm.program.heidenhain.planes import plane
from vcmm.program.heidenhain.probing import KlartextProbing
from vcmm.program.heidenhain.text import KlartextBlock, KlartextReader, blocks_of, tokenize
from vcmm.program.heidenhain.tools import call_tool, define_tool
from vcmm.program.heidenhain.touch_cycles import CYCLES, LATER, touch_cycle
from vcmm.program.heidenhain.traces import cuts_of, words_of
from vcmm.program.heidenhain.words import read_words
from vcmm.program.levels import NOT_MOVED
from vcmm.program.moves import PLANES, Move, Program, Source
from vcmm.program.reading import read_bytes
from vcmm.program.recorder import Recorder
from vcmm.program.repeating import LATEST
from vcmm.program.search import find_file, folders_of
from vcmm.program.setup import Setup
from vcmm.program.trace import BlockPlace, ExecutedBlock, WordAt
from vcmm.program.tracer import Tracer, lines_with_ends

__all__ = ["read", "tokenize"]
LONGEST = 500_000  # blocks executed again before a program counts as endless
DEEPEST = 19  # nested subprograms, as on the control
PARAXIAL = tuple(f"{i}{a}" for a in "XYZABCUVW" for i in ("", "I"))
NOT_MOVING = {  # blocks that move nothing here, and whether the path hangs on them
    "SEL": True, "OPEN": False, "CLOSE": False, "CONTOUR": True, "PRESET": True, "SQL": True, "LOAD": False, "DEFINE": False, "AFC": False,
    "TRANSFER": False, "POLARKIN": True, "TABDATA": True, "MONITORING": False, "SECTION": False, "OCM": True, "DIALOG": False, "TURNDATA": True,
}  # fmt: skip


def read(text: str, file: str, setup: Setup, trace: bool = False) -> Program:
    """Return the moves of a program. `file` is its name for messages; called programs are in the same folder.

    Raises ProgramFault (file, line, column, reason, fix) for what cannot be understood, and ModelLimit for a contour that
    the tool cannot follow.
    """
    recorder = Recorder(file=file, setup=setup, dialect="heidenhain")
    if trace:
        recorder.tracer = Tracer([line for line, _ in lines_with_ends(text)])
    paths = KlartextPaths(recorder, KlartextCycles(recorder))
    recorder.finishes.append(paths.finish)
    _Runner(recorder, paths, blocks_of(text), KlartextParameters(recorder)).run()
    return recorder.program(file)


@dataclass(eq=False)
class _Runner:
    """One program under way; those that it calls have runners of their own."""

    recorder: Recorder
    paths: KlartextPaths
    lines: list[KlartextBlock]
    parameters: KlartextParameters
    depth: int = 0
    labels: dict[str, int] = field(default_factory=dict)
    returns: list[int] = field(default_factory=list)
    repeats_left: dict[int, int] = field(default_factory=dict)  # repetitions left, by block
    at: int = 0
    blocks_run: int = 0
    pole: dict[str, WordAt] = field(default_factory=dict)  # words of the CC in force, where traces are kept
    spots: list[Spot] = field(default_factory=list)  # of PATTERN DEF
    probing: KlartextProbing = field(init=False)
    free: FreeContours = field(init=False)

    def __post_init__(self) -> None:
        self.probing = KlartextProbing(self.recorder, self.parameters.values)
        self.free = FreeContours(self.recorder, self.paths)

    def run(self) -> bool:
        """Run the program. True where M2 or M30 has ended it."""
        self.labels = labels_of(self.lines, self.recorder.file)
        self.give_way()
        while self.at < len(self.lines):
            line = self.lines[self.at]
            if self.free.waiting and not self.free.goes_on(line) and self.free.flush():
                return True
            self.recorder.source = Source(line.number, line.first, line.last)
            self.blocks_run += 1
            if self.blocks_run > LONGEST + len(self.lines):
                self.recorder.fault(
                    f"more than {LONGEST} blocks have been executed again; the program seems to be endless, check its jumps"
                )
            self.at = after = self.at + 1
            if line.plain and self.paths.short(line):
                continue
            try:
                reader = KlartextReader(line.tokens, self.parameters.values, self.parameters.unset)
                if self.trace_block(reader, line):
                    return True
                if self.at < after and self._endless():
                    self.recorder.states.leave_wait(self.recorder, line.first)
                    self.at = after
            except BlockFault as fault:
                raise ProgramFault(
                    self.recorder.file, line.number, max(fault.column, 1), fault.text
                ) from None
        return self.free.flush()

    def _endless(self) -> bool:
        """Return whether the state is that of an earlier jump back: an endless loop."""
        r = self.recorder

        def values() -> object:
            return (dict(self.parameters.values), list(self.returns), dict(self.repeats_left))

        return r.states.is_repetition(
            (self.at, r.p, r.q, r.rotary), values, lambda: (values(), self, r.moves[-LATEST:])
        )

    def trace_block(self, reader: KlartextReader, line: KlartextBlock) -> bool:
        """Execute one block, and keep its notes."""
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

    def block(self, reader: KlartextReader) -> bool:
        """Execute one block. True at the end of the program."""
        if reader.is_hidden() and self.recorder.setup.block_delete:
            reader.rest()
            return False
        word, paths = reader.upper(), self.paths
        if reader.is_parameter():
            self.parameters.assign(reader)
            return False
        if word in ("C", "CR", "CT", "CP", "CTP"):
            reader.at += 1
            return paths.circle(reader, word)
        simple: dict[str, Callable[[KlartextReader], bool | None]] = {
            "L": paths.straight, "LP": paths.polar_line, "CC": paths.set_pole, "APPR": paths.approach, "DEP": paths.departure,
            "RND": lambda r: self.free.corner(r, "round"), "CHF": lambda r: self.free.corner(r, "chamfer"), "BEGIN": self.begin, "END": self.end,
            "BLK": lambda r: bool(r.rest()) and False, "TOOL": self.tool, "LBL": self.label, "CALL": self.call, "FN": self.function, "CYCL": self.cycle,
            "CYCLE": self.cycle, "STOP": self.functions, "LN": paths.normal_line, "SPL": paths.spline, "PLANE": lambda r: plane(paths.cycles.frames, r),
            "PATTERN": self.pattern, "TCH": self.probe, "FUNCTION": lambda r: function(paths, r), "TRANS": lambda r: transform(paths.cycles.frames, r),
            "QS": self.parameters.text, "DECLARE": self.parameters.declare, "ERROR": self.parameters.text,
        }  # fmt: skip
        if word in simple:
            reader.at += word != "QS"
            over = bool(simple[word](reader))
            if not reader.is_done:
                raise reader.fault(f'"{reader.upper()}" cannot be understood behind {word}; remove it')
            return over
        if word in PARAXIAL:
            return self.paraxial(reader)
        if word in ("M", "F", "FMAX", "FAUTO", "RL", "RR"):
            return self.functions(reader)
        if word in FREE:
            self.free.read(reader, self.lines[self.at - 1].block)
            return False
        if word in NOT_MOVING:
            return self.strange(reader, word)
        return self.unknown(reader, [*simple, "C", "CR", "CT", "CP", "CTP", "Q"])

    def strange(self, reader: KlartextReader, word: str) -> bool:
        """Pass over blocks that have no effect here, with a remark."""
        column, matters = reader.column, NOT_MOVING.get(word, True)
        what, refusal = (
            f"{word} {reader.upper(1)}".strip(),
            f"{word} is not understood; rewrite the block with L, C, CR",
        )
        self.recorder.assume(what, "passed over", refusal, column=column, matters=matters)
        reader.rest()
        return False

    def paraxial(self, reader: KlartextReader) -> bool:
        """Execute X+10 R+ F200: positioning by an axis key. More than one axis needs L."""
        self.recorder.assume(
            "a position without L", "read as a straight line (L)",
            f"{reader.upper()} is not understood without L before it; write L {reader.upper()} ...",
        )  # fmt: skip
        return self.paths.straight(reader)

    def probe(self, reader: KlartextReader) -> None:
        """Run TCH PROBE 0 and those of touch_cycles; results of others depend on the machine."""
        reader.accept("PROBE")
        number, column = reader.upper(), reader.column
        probing = self.probing
        code = int(number) if number.isdigit() else 0
        if number in ("0.0", "0.1") or code in CYCLES:
            reader.at += 1
        if number == "0.0":
            probing.first(reader)
        elif number == "0.1":
            probing.second(reader)
        elif code in CYCLES:
            values = self.parameters.values
            touch_cycle(self.recorder, values, code, self.paths.cycles.q_values(reader, values), column)
        else:
            reader.rest()
            why = f" ({LATER[code]})" if code in LATER else ""
            self.recorder.assume(
                f"TCH PROBE {number}", "passed over: nothing is probed, its results are 0",
                f"TCH PROBE {number}{why} is not understood; known are 0, {', '.join(map(str, CYCLES))}: probe with these, or take it out",
            )  # fmt: skip

    def pattern(self, reader: KlartextReader) -> None:
        """Read PATTERN DEF."""
        reader.expect("DEF", "after PATTERN")
        self.spots = pattern_points(reader)

    def unknown(self, reader: KlartextReader, names: list[str]) -> bool:
        token = reader.peek()
        assert token is not None
        raise reader.fault(
            f"{token.text} is not understood.{choose_from(token.text.upper(), names)} Rewrite the block with these"
        )

    def functions(self, reader: KlartextReader) -> bool:
        """Execute a block of M functions only; STOP with M functions: M2 and M30 end the program."""
        if any(t.text.upper() in PARAXIAL for t in reader.tokens):
            return self.paraxial(reader)
        words = read_words(reader, ())
        if words.away is not None:
            return retracting(self.paths, words)
        self.paths.technology(words)
        return self.paths.after(words)

    # -- frame of the program --
    def begin(self, reader: KlartextReader) -> None:
        """Read BEGIN PGM NAME MM | INCH."""
        reader.expect("PGM", "after BEGIN")
        unit = reader.tokens[-1].text.upper()
        if unit not in ("MM", "INCH"):
            raise reader.fault("BEGIN PGM ends with the unit, MM or INCH")
        self.recorder.unit = 25.4 if unit == "INCH" else 1.0
        reader.rest()

    def end(self, reader: KlartextReader) -> bool:
        reader.rest()
        return True

    def tool(self, reader: KlartextReader) -> None:
        if reader.accept("CALL"):
            call_tool(self.paths, reader)
        elif reader.accept("DEF"):
            define_tool(self.paths, reader)
        else:
            raise reader.fault("TOOL is followed by CALL or DEF")

    def cycle(self, reader: KlartextReader) -> None:
        """Read CYCL DEF, CYCL CALL; CYCLE is taken for CYCL with a remark."""
        if reader.upper(-1) == "CYCLE":
            self.recorder.remark("CYCLE is read as CYCL")
        if reader.accept("DEF"):
            cycles, before = self.paths.cycles, self.paths.cycles.active
            cycles.auto_feed = self.paths.auto_feed
            cycles.define(reader, self.parameters.values)
            self.paths.modal_call &= (
                cycles.active is before
            )  # a new machining cycle ends M89, and so does CYCL CALL
        elif reader.accept("CALL"):
            self.cycle_call(reader)
        else:
            raise reader.fault("CYCL is followed by DEF or CALL")

    def cycle_call(self, reader: KlartextReader) -> None:
        """Execute CYCL CALL, CYCL CALL POS X Y Z, CYCL CALL PAT F."""
        paths, kind = self.paths, reader.upper()
        paths.modal_call = False
        reader.at += kind in ("POS", "PAT")
        words = read_words(reader, ())
        rapid = paths.technology(words)
        if kind == "PAT" and not self.spots:
            paths.r.assume("the points of CYCL CALL PAT", NOT_MOVED, "CYCL CALL PAT needs PATTERN DEF before it")  # fmt: skip
        elif kind == "PAT":
            for x, y, z in self.spots:
                unit = paths.r.unit
                paths.cycles.call_at(x * unit, y * unit, z * unit, rapid or words.feed is None)
        elif kind == "POS":
            point = paths.target(words)
            first, second, normal = PLANES[paths.r.plane]
            paths.cycles.call_at(point[first], point[second], point[normal], rapid)
        else:
            paths.cycles.call()
        if kind != "POS":
            paths.leftover(words)

    # -- labels --
    def name(self, reader: KlartextReader) -> str:
        token = reader.peek()
        if token is None or token.kind not in ("number", "string"):
            raise reader.fault('a label is a number or a name in quotes, as in LBL 1 or LBL "SLOT"')
        reader.at += 1
        return token.text.upper()

    def label(self, reader: KlartextReader) -> None:
        """Read a label: LBL 0 ends a subprogram that has been called."""
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
        """Execute CALL LBL n [REP m]: a subprogram, or a repetition of the blocks between label and call."""
        here = self.at - 1
        if reader.accept("PGM") or reader.upper() == "SELECTED":
            name = reader.rest()
            self.program(self.parameters.texts.values.get(name.upper().removeprefix("QS"), name))
            return
        if not reader.accept("LBL"):
            raise reader.fault(
                f"CALL {reader.upper()} is not understood; put the called program into this file as LBL ... LBL 0"
            )
        target = self.find(reader)
        if reader.accept("REP"):
            times = round(reader.value("REP"))
            if times > LONGEST:
                raise reader.fault(f"{times} repetitions are more than {LONGEST} blocks; check REP")
            if reader.accept("/"):
                reader.value("REP")
            if (
                target > here
            ):  # a repetition counts its passes at the call, which the way on does not meet again
                self.recorder.assume("CALL LBL REP with its label behind it", "a jump to the label, once")
            remaining = self.repeats_left.pop(here, times)
            if remaining > 0:
                self.repeats_left[here] = remaining - 1
                self.at = target
            return
        if len(self.returns) >= DEEPEST:
            raise reader.fault(f"subprograms are nested deeper than {DEEPEST}; does a label call itself?")
        self.returns.append(self.at)
        self.at = target

    def program(self, name: str) -> None:
        """Execute CALL PGM: a program beside this one, with the parameters as they are."""
        base = name.strip().strip('"').replace("\\", "/").split("/")[-1].split(":")[-1] or "?"
        folders = folders_of(Path(self.recorder.file), self.recorder.setup.subprograms)
        path = find_file(folders, [base])
        if path is None:
            self.recorder.assume(
                f"the program {base}", NOT_MOVED, f"CALL PGM {base}: there is no such file beside the program; put it there, or into "
                "this file as LBL ... LBL 0",
            )  # fmt: skip
            return
        if self.depth >= DEEPEST:
            self.recorder.fault(f"programs are nested deeper than {DEEPEST}; does {base} call itself?")
        file, source = self.recorder.file, self.recorder.source
        self.recorder.file = str(path)
        blocks = blocks_of(read_bytes(path))
        _Runner(self.recorder, self.paths, blocks, self.parameters, self.depth + 1).run()
        self.recorder.file, self.recorder.source = file, source
        self.give_way()

    def contour(self, name: str) -> tuple[list[Move], str | None]:
        """Return the moves of a label that a contour cycle follows, with the side of their compensation."""
        inner = _Runner(self.recorder, self.paths, self.lines, self.parameters, self.depth + 1)
        made = contour_moves(self.paths, inner, self.labels, name)
        self.give_way()
        return made

    def give_way(self) -> None:
        """Free the references, because cycles find here whatever they call."""
        self.paths.cycles.program, self.paths.cycles.contours.read = self.program, self.contour

    def function(self, reader: KlartextReader) -> bool:
        """Execute FN 0 to FN 38; FN 9 to FN 12 jump."""
        column = reader.column
        code = round(reader.value("FN"))
        reader.expect(":", f"after FN {code}")
        if not 9 <= code <= 12:
            return self.parameters.function(reader, code, column)
        holds = self.parameters.condition(reader)
        target = self.find(reader)
        if holds:
            self.at = target
        return False
