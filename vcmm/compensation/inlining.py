"""Write out subprograms, loops and macros as the blocks that are executed, in order, each with numbers of its own.

The correction depends on the place, so a block that is executed at several places must be there once for each. The
text keeps every executed block with its comments; expressions become numbers; assignments, calls, jumps and labels
go; block numbers stay where they are the first of their kind. Comments say where the blocks come from. The written-out
program is read again and must make the same moves.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from vcmm.compensation.block_skip import check_end, check_step
from vcmm.compensation.header import SEMICOLON, comment
from vcmm.compensation.source import SourceText, code_of, read_source, semicolon_code
from vcmm.core.errors import DataError, ModelLimit
from vcmm.program.dialects import Dialect
from vcmm.program.moves import Move, Program
from vcmm.program.trace import ExecutedBlock, TextCut, Trace

SAME_MOVE_MM = (
    1e-6  # mm between a move and the same one written out: expressions are written with nine decimals
)
INLINE = 200.0  # executed blocks for each line of the program, beyond which nothing is written out
_NUMBER = re.compile(r"([ \t]*/?\d?[ \t]*)(N[ \t]*(\d+)[ \t]*)", re.IGNORECASE)
_KLARTEXT_NUMBER = re.compile(r"([ \t]*)((\d+)[ \t]+)")
_END = re.compile(r"\s*(?:\d+\s+)?END\s+PGM\b", re.IGNORECASE)


def must_be_written_out(traces: Sequence[Trace], name: str) -> Trace | None:
    """Return the first trace whose block is executed several times, is in a file of its own, or needs numbers for a cycle."""
    for t in traces:
        if not t.contour.rewritable or t.contour.kind == "dwell":
            continue
        computed = (
            t.cycle and t.cycle[0] == "C" and any(not w.plain for k, w in t.words.items() if k in _HEIGHTS)
        )
        if t.runs > 1 or t.file != name or computed:
            return t
    return None


_HEIGHTS = ("RTP", "RFP", "SDIS", "DP", "DPR", "FDEP", "Q203")


def written_out(
    program: Program, source: SourceText, dialect: Dialect, limit: float
) -> tuple[SourceText, tuple[int, ...]]:
    """Return the program as its executed blocks, and the line that each of its lines comes from. Raises DataError."""
    steps = program.steps
    lines = max(len(source.lines), 1)
    if len(steps) > limit * lines:
        (file, line), most = Counter((s.file, s.line) for s in steps).most_common(1)[0]
        raise DataError(
            f"{file}:{line}: written out, the program has {len(steps)} blocks, {len(steps) / lines:.0f} times as many as its lines (limit "
            f"{limit:g}); this one is executed {most} times. Raise --inline, or post the program in parts"
        )
    out = _Sheet(source, dialect)
    for step in steps:
        out.step(step)
    if steps:
        check_end(steps, out.text(steps[-1].file)[steps[-1].line - 1], dialect)
    out.finish()
    text = SourceText(source.name, tuple(out.lines), source.encoding, source.bom)
    return text, tuple(out.origin)


@dataclass(eq=False)
class _Sheet:
    """The written-out text so far."""

    source: SourceText
    dialect: Dialect
    lines: list[tuple[str, str]] = field(default_factory=list)
    origin: list[int] = field(default_factory=list)
    numbers: set[str] = field(default_factory=set)  # block numbers that stand in the text
    passes: Counter[tuple[str, int]] = field(default_factory=Counter)
    last: ExecutedBlock | None = None
    texts: dict[str, list[str]] = field(default_factory=dict)
    pending: str = ""  # a comment before the next block, and whether it announces a pass of a loop
    again: bool = False
    back: int = 0  # line of the block that led back to the beginning of that pass

    def text(self, file: str) -> list[str]:
        if file not in self.texts:
            source = self.source if file == self.source.name else read_source(Path(file))
            self.texts[file] = [body for body, _ in source.lines]
        return self.texts[file]

    def code(self, line: str) -> str:
        return (semicolon_code(line) if self.dialect.name in SEMICOLON else code_of(line)).strip()

    def put(self, body: str, origin: int) -> None:
        if self.pending:
            self.lines.append((self.pending, self.source.end))
            self.origin.append(origin)
            self.pending = ""
        self.lines.append((body, self.source.end))
        self.origin.append(origin)

    def step(self, step: ExecutedBlock) -> None:
        """Write one executed block, with the comments and blank lines before it, and its origin."""
        self.passes[(step.file, step.line)] += 1
        self.between(step)
        self.whence(step)
        body = self.text(step.file)
        for number in range(step.line, min(step.last, len(body)) + 1):
            line = body[number - 1]
            cuts = [c for c in step.cuts if c.line == number]
            check_step(step, number, line, cuts)
            new = self.renumber(_cut(line, cuts))
            if _empty(self.code(new)) and not _empty(self.code(line)):
                new = self.remark_of(line)
                if not new:
                    continue
            self.put(new, number if step.file == self.source.name else step.line)
        self.last = step

    def between(self, step: ExecutedBlock) -> None:
        """Write the lines without code since the block before."""
        before = self.last.last if self.last is not None and self.last.file == step.file else 0
        if self.last is not None and (self.last.file != step.file or before >= step.line):
            return
        body = self.text(step.file)
        there = range(before + 1, step.line)
        if self.last is not None and any(self.code(body[n - 1]) for n in there):
            return  # a jump
        for n in there:
            if self.last is None or not self.code(body[n - 1]):
                self.put(body[n - 1], n)

    def whence(self, step: ExecutedBlock) -> None:
        """Write a comment where a call begins or ends, and where a loop begins anew."""
        last = self.last
        if last is None:
            return
        if self.again and step.file == last.file and step.line > self.back:
            self.pending = ""  # the loop has ended instead
        self.again = False if not self.pending else self.again
        if step.call > last.call:
            text = f"FROM LINE {step.line}, CALLED IN LINE {last.line}"
        elif step.call < last.call:
            text = f"BACK AT LINE {step.line}"
        elif step.line <= last.line or step.file != last.file:
            text = f"FROM LINE {step.line} AGAIN, PASS {self.passes[(step.file, step.line)]}"
        else:
            return
        self.pending, self.again, self.back = comment(text, self.dialect), "AGAIN" in text, last.line

    def renumber(self, line: str) -> str:
        """Return the line; its block number stays where it is the first of its kind."""
        number = (_KLARTEXT_NUMBER if self.dialect.name == "heidenhain" else _NUMBER).match(line)
        if number is None:
            return line
        if number[3] in self.numbers:
            return number[1] + line[number.end() :]
        self.numbers.add(number[3])
        return line

    def remark_of(self, line: str) -> str:
        """Return the comment of a line whose code goes."""
        if self.dialect.name in SEMICOLON:
            return line[len(semicolon_code(line).rstrip()) :].strip()
        return " ".join(re.findall(r"\([^()]*\)|;.*", line))

    def finish(self) -> None:
        """Write what a control needs at the end: END PGM, a second percent sign."""
        body = self.text(self.source.name)
        if self.dialect.name == "heidenhain" and not any(_END.match(line) for line, _ in self.lines):
            for number, line in enumerate(body, 1):
                if _END.match(line):
                    self.put(line, number)
        signs = [n for n, line in enumerate(body, 1) if line.strip() == "%"]
        if self.dialect.name not in SEMICOLON and len(signs) > 1 and self.lines[-1][0].strip() != "%":
            self.put(body[signs[-1] - 1], signs[-1])


def _cut(line: str, cuts: Sequence[TextCut]) -> str:
    """Return a line with its cuts made; two blanks that meet become one."""
    for cut in sorted(cuts, key=lambda c: c.first)[::-1]:
        before, behind = line[: cut.first - 1], line[cut.last - 1 :]
        if not cut.text and before.endswith(" ") and behind[:1] in (" ", ""):
            before = before.rstrip(" ") if not behind else before[:-1]
        line = before + cut.text + behind
    return line


def _empty(code: str) -> bool:
    """Return whether there is nothing but a block number."""
    return re.fullmatch(r"/?\d?\s*(?:N\s*\d+)?|\d+", code, re.IGNORECASE) is not None


def check_written_out(old: Program, new: Program, origin: Sequence[int], name: str) -> None:
    """Check that both programs make the same moves. Raises ModelLimit with the line of the first difference."""
    for i, (a, b) in enumerate(zip(old.moves, new.moves)):
        if not _same(a, b):
            raise ModelLimit(_differs(name, old.moves[i].source.line))
    if len(old.moves) != len(new.moves):
        at = min(len(old.moves), len(new.moves)) - 1
        raise ModelLimit(_differs(name, old.moves[min(max(at, 0), len(old.moves) - 1)].source.line))
    if any(t.runs > 1 for t in new.traces):
        line = next(t.line for t in new.traces if t.runs > 1)
        raise ModelLimit(_differs(name, origin[line - 1]))


def _differs(name: str, line: int) -> str:
    return (
        f"{name}:{line}: blocks that are executed several times are written out one by one, but here that would change the motion; "
        "post the program without subprograms, loops and macros"
    )


def _same(a: Move, b: Move) -> bool:
    ends = [*zip(a.start, b.start), *zip(a.end, b.end), *zip(a.centre or (), b.centre or ())]
    feeds = (a.feed or 0.0, b.feed or 0.0)
    return (
        (a.kind, a.plane, a.turns, a.clockwise, a.tool, a.offset, a.compensation, a.exact_stop)
        == (b.kind, b.plane, b.turns, b.clockwise, b.tool, b.offset, b.compensation, b.exact_stop)
        and all(math.isclose(x, y, abs_tol=SAME_MOVE_MM) for x, y in ends)
        and math.isclose(*feeds, rel_tol=1e-6, abs_tol=1e-9)
        and math.isclose(a.spindle, b.spindle, rel_tol=1e-6, abs_tol=1e-6)
        and math.isclose(a.seconds, b.seconds, rel_tol=1e-6, abs_tol=1e-9)
    )
