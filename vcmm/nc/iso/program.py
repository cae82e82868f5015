"""From the text of a G-code program to a Program: block after block, with a short cut for plain lines.

A plain line holds nothing but N, G0 or G1, X, Y, Z and F with plain numbers; while nothing special is in force it is read
by one regular expression. All other lines go through the block reader.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

from vcmm.nc.compensation import resolve_compensation
from vcmm.nc.control import IDENTITY, Affine, Control, new_control
from vcmm.nc.dialects import G_CODE, Dialect
from vcmm.nc.faults import BlockFault
from vcmm.nc.iso.blocks import Block
from vcmm.nc.iso.codes import Words
from vcmm.nc.iso.execute import execute
from vcmm.nc.iso.flow import Runner, o_word
from vcmm.nc.iso.macros import call_program, end_program, macro, macro_call, modal_call
from vcmm.nc.iso.motion import signed_speed
from vcmm.nc.iso.parameters import attach
from vcmm.nc.iso.steps import step_of
from vcmm.nc.iso.texts import Text
from vcmm.nc.moves import Move, Point, Program, Remark, Source
from vcmm.nc.setup import Setup
from vcmm.nc.trace import Trace, WordAt

_N = r"[-+]?(?:\d{1,12}\.?\d*|\.\d+)"  # no number that could overflow
_PLAIN = re.compile(
    rf"([ \t]*(?:N\d+[ \t]*)?)(?:G0?([01])[ \t]*)?(?:X({_N})[ \t]*)?(?:Y({_N})[ \t]*)?(?:Z({_N})[ \t]*)?(?:F({_N})[ \t]*)?\Z"
)
_new = tuple.__new__


def run(text: str, dialect: str, setup: Setup, name: str, trace: bool) -> Program:
    """The meaning of a program in a dialect of the G-code family. Raises DataError and ModelLimit."""
    spoken = _adapted(G_CODE[dialect], setup)
    c = new_control(name, spoken, setup)
    table = attach(c)
    runner = Runner(c, table, Text(name, text, spoken), Path(name).parent)
    tracer: list[Any] | None = [] if trace else None
    if trace:
        c.markers, runner.steps = [], []
    _blocks(runner, tracer)
    moves: list[Move] = c.moves
    if any(c.sides):
        moves = resolve_compensation(moves, c.sides, spoken.words, name)
    _tool_left_in_the_changer(c, moves)
    traces = _with_runs(runner, tracer) if tracer is not None else ()
    return Program(
        spoken.name, tuple(moves), tuple(c.remarks), dict(c.called), traces, tuple(runner.steps or ())
    )


def _adapted(dialect: Dialect, setup: Setup) -> Dialect:
    if setup.decimal_point:
        dialect = replace(dialect, decimal_point=setup.decimal_point)
    if setup.arc_centre:
        dialect = replace(dialect, arc_centre=setup.arc_centre)
    return dialect


def _tool_left_in_the_changer(c: Control, moves: list[Move]) -> None:
    """A T without M6 selects a tool and puts none in the spindle."""
    if c.next_tool and not c.tool and not c.called:
        first = next((m.source.line for m in moves if m.kind in ("line", "arc")), 0)
        if first:
            text = f"this cuts without a tool: T{c.next_tool} is selected, but M6, which puts it in the spindle, is missing"
            c.remarks.append(Remark(first, 1, text))


def _blocks(r: Runner, tracer: list[Any] | None) -> None:
    """Run until the program ends. Every complaint gets its file and line here."""
    c = r.c
    started = _leading_percent(r)
    try:
        while not c.ended:
            if r.at >= len(r.text.lines):
                _end_of_text(r, started)
                continue
            if tracer is None and r.modal_macro is None:
                _plain_lines(r)
                if r.at >= len(r.text.lines):
                    continue
            index = r.at
            r.at += 1
            c.line = index + 1
            _one(r, r.text.block(index), index, tracer)
    except BlockFault as fault:
        raise c.program_fault(c.line, fault.column, fault.text) from None
    _text_after_end(r)


def _leading_percent(r: Runner) -> bool:
    """Whether the program begins with %; blank lines before it do not count."""
    for index, line in enumerate(r.text.lines):
        if line.strip():
            if line.strip().startswith("%"):
                r.at = index + 1
                return True
            return False
    raise r.c.program_fault(1, 1, "the program is empty; name the right file")


def _end_of_text(r: Runner, started: bool) -> None:
    c = r.c
    c.line = max(len(r.text.lines), 1)
    if r.frames:
        frame = r.frames[-1]
        if r.text is not r.main and frame.kind != "o":
            r.pop()
            return
        end = "M99" if frame.kind != "o" else "endsub"
        raise BlockFault(1, f"the text ends inside the subprogram {frame.label}; add {end}")
    what = "a second %" if started else "M2 or M30"
    if c.dialect.needs_end:
        raise BlockFault(1, f"the program has no end: {what} is missing; add M2 as the last line")
    c.remark("the program has no end (M30); it is taken to end with the text")
    c.ended = True


def _text_after_end(r: Runner) -> None:
    rest = [i for i in range(r.at, len(r.main.lines)) if r.main.lines[i].strip() not in ("", "%")]
    inside = r.main.programs or r.main.o_words
    if r.text is r.main and rest and not inside:
        r.c.line = rest[0] + 1
        r.c.remark("the text after the end of the program is not read")


def _one(r: Runner, block: Block, index: int, tracer: list[Any] | None) -> None:
    """Execute one block."""
    c = r.c
    if block.percent:
        c.ended = not r.frames or r.text is r.main
        return
    if block.deleted and c.setup.block_delete:
        return
    r.executed(index, index + 1)
    if r.steps is not None:
        r.steps.append(step_of(r, block, index))
    if block.deleted:
        c.remark(
            'blocks with "/" are executed; write block_delete = true in the set-up file to leave them out',
            once="delete",
        )
    if block.flow is not None and block.flow.kind != "program":
        if block.words or block.assigns:
            text = "flow control must stand alone in its block; write the other words on a line of their own"
            raise BlockFault(block.flow.column, text)
        (o_word if c.dialect.words == "o" else macro)(r, block.flow, index)
        return
    if block.flow is not None:
        _program_number(r, block, index)
    values = r.assign(block.assigns)
    if block.words:
        _words(r, block, index, tracer)
    r.settle(values)


def _program_number(r: Runner, block: Block, index: int) -> None:
    """An O number between programs: the one before has no end."""
    flow = block.flow
    assert flow is not None
    if (
        r.c.moves
        and r.text is r.main
        and r.text.programs.get(int(str(flow.label))) == index
        and not r.frames
        and r.c.dialect.words == "macro"
    ):
        raise BlockFault(
            flow.column,
            f"program O{flow.label} begins here, but the one before has no end; add M30 or M99 before it",
        )


def _words(r: Runner, block: Block, index: int, tracer: list[Any] | None) -> None:
    c = r.c
    w = Words(c, block)
    before, made = (c.modal(), len(c.moves)) if tracer is not None else (None, len(c.moves))
    if "macro" in w.g:
        macro_call(r, w, index)
        return
    call = w.m.get("call")
    if call is not None:
        w.used |= {"P", "L"}
    execute(c, w)
    if tracer is not None:
        _trace(r, w, index, before, made, tracer)
    if call == 98:
        call_program(r, w, index, w.m_columns["call"])
    elif call == 99:
        end_program(r, w, w.m_columns["call"], index)
    elif r.modal_macro is not None and len(c.moves) > made:
        modal_call(r, index)


# -- plain lines ----------------------------------------------------------------------------------------------------------
def _plain_lines(r: Runner) -> None:
    """Read plain lines until one is not; leaves r.at on that one."""
    c = r.c
    if (
        c.motion not in ("G0", "G1") or c.matrix is not None or c.feed_mode != "G94" or c.spindle_mode != "G97"
        or c.diameter or c.exact_once or c.dialect.lathe
        or (c.dialect.words == "macro" and c.dialect.decimal_point != "calculator")
    ):  # fmt: skip
        return
    lines, match, emit, sides = r.text.lines, _PLAIN.match, c.moves.append, c.sides.append
    rapid_tail, line_tail = _tails(c)
    strict = c.dialect.words == "macro" and "decimal point" not in c.remarked
    unit, absolute, compensation, rapid = c.unit, c.absolute, c.compensation, c.motion == "G0"
    (x, y, z), (sx, sy, sz), start, at, end = c.p, c.shift, c.tip(), r.at, len(lines)
    while at < end:
        text = lines[at]
        found = match(text)
        if found is None:
            break
        head, g, wx, wy, wz, f = found.groups()
        if strict and _pointless(wx, wy, wz):
            break  # the remark about decimal points is due
        if f is not None:
            if not float(f) >= 0.0:
                break
            c.feed = float(f)
            line_tail = _tails(c)[1]
        if g is not None:
            rapid = g == "0"
        if wx is wy is wz is None:
            at += 1
            continue
        if not (rapid or c.feed):
            break
        if absolute:
            x = x if wx is None else float(wx) * unit
            y = y if wy is None else float(wy) * unit
            z = z if wz is None else float(wz) * unit
        else:
            x = x if wx is None else x + float(wx) * unit
            y = y if wy is None else y + float(wy) * unit
            z = z if wz is None else z + float(wz) * unit
        goal = (x + sx, y + sy, z + sz)
        at += 1
        source = _new(Source, (at, len(head) + 1, len(text) + 1))
        emit(
            _new(
                Move,
                ("rapid" if rapid else "line", source, start, goal) + (rapid_tail if rapid else line_tail),
            )
        )
        sides(compensation)
        start = goal
    c.line = r.at + 1
    r.executed(r.at, at)
    r.at, c.motion = at, "G0" if rapid else "G1"
    c.arrive([x, y, z], start)


def _pointless(*words: str | None) -> bool:
    """Whether a number other than zero is written without a decimal point."""
    return any(w is not None and "." not in w and float(w) for w in words)


def _tails(c: Control) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """The fields of a move after its end: of a rapid and of a line."""
    side = c.compensation.side if c.compensation else None
    tail = (
        signed_speed(c, 0.0), c.tool, c.tool_offset, side, 0.0, c.exact, None if c.exact else c.tolerance, c.offset, True,
    )  # fmt: skip
    head = (c.rotary, c.rotary, c.plane, None, 1, None)
    feed = None if c.feed is None else c.feed * c.unit
    return (*head, None, *tail), (*head, feed, *tail)


# -- traces ---------------------------------------------------------------------------------------------------------------
def _trace(r: Runner, w: Words, index: int, before: Any, made: int, out: list[Any]) -> None:
    c = r.c
    words = {
        letter: WordAt(
            letter, word.first, word.last, word.text, not callable(word.value), _decimals(word.text)
        )
        for letter, word in w.words.items()
    }
    affine, after = Affine(c.matrix or IDENTITY, c.shift), c.modal()
    assert c.markers is not None
    for i in range(made, len(c.moves)):
        move = c.moves[i]
        ends = (_programmed(affine, move.start), _programmed(affine, move.end))
        one = Trace(
            r.text.name,
            index + 1,
            words,
            before,
            after,
            ends,
            affine,
            0,
            c.markers[i],
            len(r.frames),
            move,
            c.sides[i],
        )
        out.append((one, r.text, index))


def _programmed(affine: Affine, tip: Point) -> Point:
    d = [tip[i] - affine.shift[i] for i in range(3)]
    m = affine.matrix
    p = [m[0][i] * d[0] + m[1][i] * d[1] + m[2][i] * d[2] for i in range(3)]
    return (p[0], p[1], p[2])


def _decimals(text: str) -> int | None:
    return len(text.rstrip().partition(".")[2].replace(" ", "")) if "." in text else None


def _with_runs(r: Runner, tracer: list[Any]) -> tuple[Trace, ...]:
    return tuple(one._replace(runs=text.runs.get(index, 1)) for one, text, index in tracer)
