"""Refuse programs before anything is rewritten: where the machine's position or the state of its control is not known."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from vcmm.compensation.codes import codes_in
from vcmm.compensation.loading import MachineOfFile, machine_of
from vcmm.compensation.source import SourceText, at_line, code_of
from vcmm.core.errors import DataError, ModelLimit, UsageError
from vcmm.core.machine import Machine
from vcmm.program.dialects import FRONT_ENDS, G_CODE, TRACE_READERS, Dialect, check_name
from vcmm.program.iso.channels import marks_of
from vcmm.program.iso.cycles import DRILLING
from vcmm.program.moves import Move, Program
from vcmm.program.reading import read_bytes
from vcmm.program.setup import Setup
from vcmm.program.trace import Trace
from vcmm.shop.motion.tool_centre import in_machine_axes

MARK = "VCMM COMPENSATED"
TRAVEL = 1e-6  # mm or rad of rounding that is allowed beyond a travel


def check_dialect(name: str) -> None:
    """Refuse dialects whose front-end does not state which word made which move."""
    check_name(name)
    if name in FRONT_ENDS and name not in TRACE_READERS:
        raise UsageError(
            f"programs of the dialect {name} cannot be rewritten: its reader does not say which word made which move. Have the "
            f"program posted for {' or '.join((*G_CODE, *TRACE_READERS))}, or see what a shift of the work offset does (--offset-only)"
        )


def check_mark(source: SourceText) -> None:
    """Refuse a program that has been compensated already."""
    for number, (line, _) in enumerate(source.lines, 1):
        if MARK in line.upper():
            raise DataError(
                f"{source.name}:{number}:{line.upper().index(MARK) + 1}: the program carries our mark: it is compensated already. "
                "Compensate the original program"
            )


def check_channels(source: SourceText, dialect: str) -> None:
    """Refuse a file with the programs of several channels."""
    if dialect in G_CODE and G_CODE[dialect].lathe:
        for number, (line, _) in enumerate(source.lines, 1):
            if marks_of(line):
                raise DataError(
                    f"{source.name}:{number}:1: a channel begins here; a file of several channels is not rewritten. Compensate each on its own"
                )


def check_face(program: Program, name: str) -> None:
    """Refuse polar interpolation."""
    face = next((m for m in program.moves if m.over_face), None)
    if face is not None:
        raise ModelLimit(
            f"{name}:{face.source.line}:{face.source.first}: X and C lead the tip over the end face (polar interpolation), which is not rewritten; "
            "leave these blocks out"
        )


def check_state(given: MachineOfFile | Machine, setup: Setup) -> list[str]:
    """Check that the control runs with the compensations with which the errors were measured. Returns remarks."""
    machine, where = machine_of(given), f"{setup.path}: " if setup.path else ""
    if setup.compensation is None:
        raise UsageError(
            f"{where}which of its own compensations the control has switched on is not said; add [control] compensation = "
            '["pitch"] (as the machine file names them), or compensation = [] for none'
        )
    here, there = (
        sorted(c.strip().lower() for c in names) for names in (setup.compensation, machine.compensation)
    )
    stated = given.state if isinstance(given, MachineOfFile) else "as given"
    if stated is None and not there:
        return [
            f"the machine file has no [errors] table: its effects are taken to hold with the control as stated ({', '.join(setup.compensation) or 'no compensation'})"
        ]
    if isinstance(given, MachineOfFile) and stated == "":
        raise DataError(
            f'{given.file}: [errors] does not say in which state the table was measured; add state = "residual" with the '
            'compensation that was on, or state = "raw"'
        )
    if here != there:
        raise UsageError(
            f"{where}the control runs with {_names(here)}, but the errors of {machine.name} were measured with {_names(there)}: they "
            "are not the errors that will be there. Measure in this state, or switch the control"
        )
    return []


def _names(names: Sequence[str]) -> str:
    return ", ".join(names) if names else "no compensation"


_WOUND = re.compile(r"G0*(?:12\.1|112|7\.1|107)(?![\d.])", re.IGNORECASE)


_POLAR = re.compile(r"G0*16(?![\d.])", re.IGNORECASE)
POLAR_WORDS = ("AP", "RP", "@", "^")  # of Sinumerik and LinuxCNC


def check_wound(source: SourceText, dialect: Dialect) -> None:
    """Refuse polar and cylindrical interpolation, in which C is a length that the axis words of a new block do not express; and polar
    words (G16), where X is a radius and Y an angle."""
    wound = [_WOUND] if dialect.words == "macro" else []
    polar = [_POLAR] if dialect.name in G_CODE and not dialect.lathe else []
    _check_codes(source.name, [line for line, _ in source.lines], (*wound, *polar))


def _check_codes(name: str, lines: Sequence[str], patterns: Sequence[re.Pattern[str]]) -> None:
    for index, line in enumerate(lines):
        for pattern in patterns:
            if match := pattern.search(code_of(line)):
                means = (
                    "makes X and Y a radius and an angle"
                    if pattern is _POLAR
                    else "winds the path about a turning axis"
                )
                message = f"{match[0]} {means}; such a program is not rewritten. Post it with X, Y and Z"
                raise at_line(DataError, name, index + 1, message, match.start() + 1)


def check_words(program: Program, source: SourceText, dialect: Dialect) -> None:
    """Refuse polar words and cycles other than those for holes: their moves are not those of the words of the block.

    Before anything is written out: the contour of a turning cycle is executed several times as well.
    """
    lines = {t.line for t in program.traces}
    if dialect.name in G_CODE and not dialect.lathe:
        for other in sorted(
            {t.file for t in program.traces} - {source.name}
        ):  # subprograms in files of their own
            _check_codes(other, read_bytes(Path(other)).splitlines(), [_POLAR])
    for m in program.moves if dialect.lathe else ():  # those of a multiple cycle have no trace
        if m.rewritable and m.kind != "dwell" and m.source.line not in lines:
            code = re.search(r"G0*7\d", code_of(source.lines[m.source.line - 1][0]), re.IGNORECASE)
            raise _not_rewritten(
                source.name, m.source.line, m.source.first, code[0] if code else "of this line"
            )
    for t in program.traces:
        if word := next((k for k in POLAR_WORDS if k in t.words), None):
            message = f"the polar word {word} is not rewritten; write the end point with X and Y"
            raise at_line(DataError, t.file, t.line, message, t.words[word].first)
        if t.cycle == "FK":
            message = "the free contour (FK) is not rewritten; write its elements with L, C and CR (vcmm nc --moves prints their ends)"
            raise at_line(DataError, t.file, t.line, message, t.contour.source.first)
        if t.cycle.startswith("CYC") and t.cycle not in HEIGHTS_MOVE:
            message = f"the cycle {t.cycle} is not rewritten; write its moves as single blocks, or use {', '.join(HEIGHTS_MOVE)}"
            raise at_line(DataError, t.file, t.line, message, t.contour.source.first)
        if t.cycle.startswith("G") and (t.cycle not in DRILLING or (dialect.lathe and t.cycle in TURNING)):
            line, column = _cycle_position(source, t)
            raise _not_rewritten(t.file, line, column, t.cycle)


def _cycle_position(source: SourceText, trace: Trace) -> tuple[int, int]:
    """Return line and column of the code of a cycle, which may be apart from the contour that it runs along."""
    code = re.compile(rf"{trace.cycle}(?![\d.])", re.IGNORECASE)
    for number, (line, _) in enumerate(source.lines if trace.file == source.name else (), 1):
        if match := code.search(code_of(line)):
            return number, match.start() + 1
    return trace.line, trace.contour.source.first


def _not_rewritten(name: str, line: int, column: int, cycle: str) -> DataError:
    message = (
        f"the cycle {cycle} is not rewritten, since its moves need different corrections; have the program posted with its moves as "
        "single blocks, or see what a shift of the work offset does (--offset-only)"
    )
    return at_line(DataError, name, line, message, column)


TURNING = ("G73", "G74", "G76")  # on lathes: pattern, pecking and threads, not holes
HEIGHTS_MOVE = ("CYCLE81", "CYCLE82", "CYCLE83", "CYCL DEF 200")  # holes that drilled.py knows how to shift


def check_program(program: Program, machine: Machine, setup: Setup, name: str) -> None:
    """Check work offsets, tools, rotary axes, words and blocks for those that cannot be rewritten."""
    check_moves([t.contour for t in program.traces], machine, setup, name)
    if program.touches:
        raise ModelLimit(
            f"{name}:{program.touches[0].line}: the program probes; where it goes on depends on what it finds, so its numbers cannot be rewritten "
            "beforehand. Take the probing out and state [offsets], or see with vcmm cut what the probing leaves"
        )
    for trace in program.traces:
        if trace.contour.rewritable and trace.contour.kind != "dwell":
            _check_rewritable(trace, name, f"{trace.file}:{trace.line}:{trace.contour.source.first}")


def check_moves(moves: Sequence[Move], machine: Machine, setup: Setup, name: str) -> None:
    """Check that work offsets, tools and axes of all moves are known."""
    if not moves:
        raise UsageError(f"{name}: the program has no motion; there is nothing to compensate")
    for m in moves:
        if m.rewritable and m.kind != "dwell":
            _check_known(m, machine, setup, f"{name}:{m.source.line}:{m.source.first}")
    if setup.set_as_cut:
        _check_set_as_cut(moves, name)


def _check_set_as_cut(moves: Sequence[Move], name: str) -> None:
    """Check that an offset that was set with the rotary axes as they cut is used in one position of them."""
    at: dict[str, tuple[float, ...]] = {}
    for m in (m for m in moves if m.kind != "rapid" and m.rewritable and not m.is_tip_led):
        if max(abs(a - b) for a, b in zip(at.setdefault(m.offset, m.rotary_end), m.rotary_end)) > TRAVEL:
            raise UsageError(
                f'{name}:{m.source.line}:{m.source.first}: work_offset.rotary = "as cut": {m.offset} cuts with the rotary axes in several places, but it '
                'was set in one of them; write rotary = "zero", or give each place a work offset of its own'
            )


def _check_known(m: Move, machine: Machine, setup: Setup, at: str) -> None:
    if m.offset not in setup.offsets:
        raise DataError(
            f'{at}: the work offset {m.offset} is in force, but the set-up does not say where it lies; add [offsets] "{m.offset}" = '
            '["100 mm", "50 mm", "-200 mm"]'
        )
    if m.tool and m.tool not in setup.tools and m.kind != "rapid":
        raise DataError(
            f'{at}: tool {m.tool} cuts here, but the set-up does not know it; add [tools.{m.tool}] length = "80 mm"'
        )
    if not m.is_tip_led:
        _check_rotary_axes(m, machine, at)
    if m.work_spindle != 1:
        raise ModelLimit(
            f"{at}: the part in spindle {m.work_spindle} is cut here, and {machine.name} is one spindle; compensate a program for each spindle"
        )
    for i, letter in enumerate("XYZ"):
        if letter not in machine.axes and abs(m.start[i] - m.end[i]) > TRAVEL:
            raise ModelLimit(
                f"{at}: the program moves {letter}, which {machine.name} has not; name the right machine"
            )


def _check_rotary_axes(m: Move, machine: Machine, at: str) -> None:
    """Check rotary axes: they may have any angle while X, Y and Z cut, and turn on the way there; nothing else is rewritten without its tip led."""
    if machine.kind == "lathe" and (any(m.rotary_start) or any(m.rotary_end)):
        raise ModelLimit(
            f"{at}: axis C of a lathe is off zero; driven tools are not rewritten. Remove their blocks, or check their result with vcmm cut"
        )
    if m.kind != "rapid" and max(abs(a - b) for a, b in zip(m.rotary_start, m.rotary_end)) > TRAVEL:
        raise ModelLimit(
            f"{at}: a rotary axis turns while the tool cuts; such a block is rewritten only where the program leads the tip over the workpiece "
            "(G43.4, TRAORI, M128), since a straight way of the axes is none in the part. Post it with tool centre point control, or index the "
            "axis by a rapid of its own and cut with it standing"
        )


def _check_rewritable(trace: Trace, name: str, at: str) -> None:
    if trace.file != name:
        raise DataError(
            f"{at}: the subprogram in a file of its own is not rewritten; copy it into the program"
        )
    if any(k in trace.words for k in "UVW"):
        raise DataError(f"{at}: increments by U, V or W are not rewritten; use X, Y and Z with G91")
    if trace.cycle == "G76" and trace.contour.kind == "thread":
        raise DataError(
            f"{at}: the threading cycle G76 is not rewritten; write its passes as single G33 moves"
        )


def check_travel(
    program: Program, machine: Machine, after: bool, name: str, lines: Sequence[int] = ()
) -> None:
    """Check that axes are within their travels at the ends of all moves. lines: source line of each line of the new program."""
    moves, _ = in_machine_axes(program.moves, machine, name)
    for m in moves:
        for i, letter in enumerate("XYZ"):
            if letter not in machine.axes:
                continue
            low, high = machine.axes[letter].travel
            q = m.end[i] + m.tool_offset[i]
            if low - TRAVEL <= q <= high + TRAVEL:
                continue
            line = lines[m.source.line - 1] if lines else m.source.line
            what = "after correction" if after else "already as programmed"
            message = (
                f"axis {letter} = {q:.4f} mm is outside its travel {low:g} to {high:g} mm {what}; move the work offset or check "
                "the tool length"
            )
            raise at_line(ModelLimit, name, line, message, m.source.first)


def codes_of(source: SourceText, dialect: Dialect) -> list[frozenset[str]]:
    """Return the M codes of each line: M08 -> "M8", "M?" where the number is computed."""
    return [
        frozenset(
            f"M{'?' if c.number is None else c.number}" for c in codes_in(line, dialect) if c.name == "M"
        )
        for line, _ in source.lines
    ]
