"""Blocks with a slash, which run or not by a switch of the control, and the rewriting that they rule out.

A slash stays with every block that stays. A call, a jump, an assignment or an end behind a slash decides what else is
executed: it cannot be written out for both positions of the switch, and no number can replace an expression behind it.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from vcmm.compensation.codes import codes_in
from vcmm.compensation.source import SourceText, at_line
from vcmm.core.errors import DataError
from vcmm.program.dialects import Dialect
from vcmm.program.moves import Program
from vcmm.program.trace import ExecutedBlock, TextCut

ENDS = (2, 30)


def decided_by(line: str, cuts: Sequence[TextCut]) -> str:
    """Return the words of a block with a slash that decide what else is executed; "" for any other block."""
    if not line.lstrip().startswith("/"):
        return ""
    gone = (line[c.first - 1 : c.last - 1].strip() for c in cuts if not c.text)
    return next((text for text in gone if text and not text.endswith(":")), "")  # a label decides nothing


def check_step(step: ExecutedBlock, number: int, line: str, cuts: Sequence[TextCut]) -> None:
    """Check a block that is to be written out. Raises DataError."""
    what = decided_by(line, cuts)
    if what:
        raise DataError(
            f'{step.file}:{number}: the program has to be written out (blocks are executed several times), and "{what}" is in a block '
            f"with a slash: what is executed hangs on a switch of the control. {_advice()}"
        )


def check_end(steps: Sequence[ExecutedBlock], line: str, dialect: Dialect) -> None:
    """Check the end of the program. line: of the last executed block. Raises DataError."""
    slash = line.lstrip().startswith("/")
    if slash and any(c.name == "M" and c.number in ENDS for c in codes_in(line, dialect)):
        raise DataError(
            f"{steps[-1].file}:{steps[-1].line}: the program has to be written out (blocks are executed several times), and it ends in a "
            f"block with a slash: what is executed hangs on a switch of the control. {_advice()}"
        )


def check_expressions(program: Program, source: SourceText, changed: Collection[int]) -> None:
    """Check the lines in which an expression has become a number. changed: their indices."""
    if not changed:
        return
    behind = None
    for step in program.steps:
        if behind is not None and step.file == source.name and step.line - 1 in changed:
            message = (
                f"the expression of this block has to become a number, but "
                f'"{behind[1]}" in line {behind[0]} is in a block with a slash, and its value may depend on it. {_advice()}'
            )
            raise at_line(DataError, source.name, step.line, message)
        if behind is None and step.cuts and step.file == source.name:
            body = source.lines[step.line - 1][0]
            what = decided_by(body, [c for c in step.cuts if c.line == step.line])
            behind = (step.line, what) if what else None


def _advice() -> str:
    return "Remove the slash, or compensate two programs, one with the block and one without it"
