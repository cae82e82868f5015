"""Read the text of a G-code program as a Program: block after block, with a short cut for plain lines.
A plain line holds nothing but N, G0 or G1, X, Y, Z and F with plain numbers; while nothing special is in force it is read by one regular
expression. All other lines go through the block reader.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

from vcmm.program.dialects import G_CODE, Dialect
from vcmm.program.facing import with_angles
from vcmm.program.faults import BlockFault, ProgramFault
from vcmm.program.frames import UNITY
from vcmm.program.iso.blocks import IsoBlock
from vcmm.program.iso.channels import marks_of, one_channel, tell_other_channels
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.control import IsoControl, new_control
from vcmm.program.iso.drawing import turns_c
from vcmm.program.iso.execute import execute, unused_words
from vcmm.program.iso.fixed_format import fixed_format, read_fixed_format
from vcmm.program.iso.flow import ActiveCall, EndOfReading, IsoRunner, o_word
from vcmm.program.iso.macros import (
    call_block,
    call_by_name,
    call_program,
    end_program,
    macro,
    macro_call,
    modal_call,
)
from vcmm.program.iso.misfits import tell_misfits
from vcmm.program.iso.numbers import has_points_written, tell_unit
from vcmm.program.iso.parameters import attach
from vcmm.program.iso.pocketing import mill_pocket
from vcmm.program.iso.steps import step_of, words_of
from vcmm.program.iso.texts import Text
from vcmm.program.iso.tools import tell_left_in_the_changer
from vcmm.program.iso.turning import turning
from vcmm.program.leading import unmoved_axes_behind, waits_for_words
from vcmm.program.moves import ORIGIN, Move, MoveFlow, Program, Source
from vcmm.program.search import folders_of
from vcmm.program.setup import Setup
from vcmm.program.trace import BlockPlace
from vcmm.program.tracer import Tracer

_N = r"[-+]?(?:\d{1,12}\.?\d*|\.\d+)"  # no number that could overflow
_PLAIN = re.compile(
    rf"([ \t]*(?:N\d+[ \t]*)?)(?:G0?([01])[ \t]*)?(?:X({_N})[ \t]*)?(?:Y({_N})[ \t]*)?(?:Z({_N})[ \t]*)?(?:F({_N})[ \t]*)?\Z"
)
_MOVING = re.compile(r"[ \t]*(?:N\d+[ \t]*)?(?:[GMTXYZOF:]|#)[ \t]*[-+.\d<\[]", re.IGNORECASE)
_ENDING = re.compile(r"^[^(;\n]*M(?:0?2|30)(?!\d)", re.MULTILINE | re.IGNORECASE)
_AXIS_WORDS = re.compile(r"(?<![A-Z#<_])[XYZ][ \t]*[-+]?[ \t]*[.\d#\[]", re.IGNORECASE)
_NOTE = re.compile(r"\([^()]*\)|;.*")
LEADER = 500  # lines among which the first % is looked for
_new = tuple.__new__


def run(
    text: str, dialect: str | Dialect, setup: Setup, name: str, trace: bool, *, flow: MoveFlow | None = None
) -> Program:
    """Return the meaning of a program in a dialect of the G-code family. Raises DataError and ModelLimit.

    flow: takes the moves as they come; the Program has none of them then.
    """
    language = _adapt(G_CODE[dialect] if isinstance(dialect, str) else dialect, setup)
    if language.survey and language.decimal_point == "calculator" and fixed_format(text):
        return read_fixed_format(
            lambda adapted, to: run(text, adapted, setup, name, trace, flow=to), text, language, flow
        )
    marks = marks_of(text) if language.lathe and "$" in text else {}
    c = new_control(name, language, setup)
    c.tracer = Tracer() if trace else None
    c.points_written = not setup.decimal_point and has_points_written(text)
    c.c_turns = language.lathe and turns_c(text)
    if marks:
        text = one_channel(text, marks, setup.channel)
        tell_other_channels(c, marks)
    runner = IsoRunner(c, attach(c), Text(name, text, language), folders_of(Path(name), setup.subprograms))
    runner.flow = flow
    _blocks(runner)
    made = flow.count if flow else 0
    if language.survey and not (c.moves or made):
        _alone(runner)
    made = made or len(c.moves)
    if made and not c.unit_said:
        tell_unit(c, text)
    if not made:
        c.remark("no axis moves in this program", 1)
        if language.survey and _AXIS_WORDS.search(_NOTE.sub("", text)):
            c.assume(
                "the moves of this program",
                "none: what it needs from its caller or its machine keeps them from being reached",
            )
    tell_misfits(c, c.misfits)
    tell_left_in_the_changer(c)
    program = c.program(name)
    if c.wound_from is not None:
        program = replace(program, moves=with_angles(program.moves, c.wound_from))
    if flow is None:
        return program
    flow.take(program.moves)
    return replace(program, moves=())


def _adapt(dialect: Dialect, setup: Setup) -> Dialect:
    """Return the dialect with the statements of the set-up on the control."""
    if setup.decimal_point:
        dialect = replace(dialect, decimal_point=setup.decimal_point)
    if setup.arc_centre:
        dialect = replace(dialect, arc_centre=setup.arc_centre)
    return dialect if setup.strict else replace(dialect, survey=True)


def _blocks(r: IsoRunner) -> None:
    """Run until the program ends. Every complaint gets its file and line here."""
    started = _leading_percent(r)
    r.fragment = r.c.language.survey and r.c.language.words == "macro" and not _ENDING.search(r.main.whole)
    _loop(r, started)
    _text_after_end(r)


def _loop(r: IsoRunner, started: bool) -> None:
    c = r.c
    try:
        while not c.has_ended:
            if r.at >= len(r.text.lines):
                _end_of_text(r, started)
                continue
            r.hand_on()
            if c.tracer is None and r.modal_macro is None:
                _plain_lines(r)
                if r.at >= len(r.text.lines) or len(c.moves) >= MoveFlow.CHUNK:
                    r.hand_on()
                    if r.at >= len(r.text.lines):
                        continue
            index = r.at
            r.at += 1
            c.source = Source(index + 1, 1, 1)
            block = r.text.block(index)
            try:
                _execute(r, block, index)
            except BlockFault as fault:
                if not r.fragment:
                    raise
                raise EndOfReading(fault.text) from None
    except BlockFault as fault:
        raise ProgramFault(c.file, c.line, max(fault.column, 1), fault.text) from None
    except EndOfReading as end:
        c.assume("the rest of a subprogram on its own", f"not read, its arguments are missing: {end}")
        c.has_ended = True


def _alone(r: IsoRunner) -> None:
    """Read subprograms without a caller, where the text has nothing else: each as if called without arguments."""
    subs = {label: words[0][0] for label, words in r.main.o_words.items() if words[0][1] == "sub"}
    called = {label for label, words in r.main.o_words.items() if any(kind == "call" for _, kind in words)}
    r.fragment = True
    for label, start in subs.items():
        if label in called:
            continue
        r.calls.clear()
        r.c.has_ended, r.c.source, r.c.states_of_m73 = False, Source(start + 1, 1, 1), []
        r.c.assume(f"the call of o<{label}>, a subprogram on its own", "one without arguments: they are 0")
        r.push(ActiveCall(r.main, len(r.main.lines), "o", f"o<{label}>", start + 1), {}, 1)
        r.enter(r.main, start + 1)
        _loop(r, False)


def _leading_percent(r: IsoRunner) -> bool:
    """Return whether the program begins with %; the text before it is a leader that no control reads, unless it holds blocks."""
    first = next((i for i, line in enumerate(r.text.lines) if line.strip()), None)
    if first is None:
        raise ProgramFault(r.c.file, 1, 1, "the program is empty; name the right file")
    for index in range(first, min(len(r.text.lines), first + LEADER)):
        line = r.text.lines[index].strip()
        if line.startswith("%"):
            r.at = index + 1
            return True
        if _MOVING.match(_NOTE.sub("", line) if r.c.language.survey else line):
            return False
    return False


def _end_of_text(r: IsoRunner, started: bool) -> None:
    c = r.c
    c.source = Source(max(len(r.text.lines), 1), 1, 1)
    if r.calls:
        call = r.calls[-1]
        if r.text is not r.main and call.kind != "o":
            r.pop()
            return
        end = "M99" if call.kind != "o" else "endsub"
        raise BlockFault(1, f"the text ends inside the subprogram {call.label}; add {end}")
    what = "a second %" if started else "M2 or M30"
    if c.language.needs_end:
        refusal = f"the program has no end: {what} is missing; add M2 as the last line"
        c.assume("the end of the program (M2)", "the end of the text", refusal, column=1, matters=False)
    else:
        c.remark("the program has no end (M30); it is taken to end with the text")
    c.has_ended = True


def _text_after_end(r: IsoRunner) -> None:
    rest = [i for i in range(r.at, len(r.main.lines)) if r.main.lines[i].strip() not in ("", "%")]
    inside = r.main.programs or r.main.o_words
    if r.text is r.main and rest and not inside:
        r.c.source = Source(rest[0] + 1, 1, 1)
        r.c.remark("the text after the end of the program is not read")
    for number, start in r.main.programs.items():
        if start >= r.at and not r.main.runs[start] and _ENDING.search("\n".join(r.main.lines[start:])):
            r.c.source = Source(start + 1, 1, 1)
            r.c.remark(
                f"a second program, O{number}, begins here; the first one alone is read: put each into a file of its own"
            )
            break


def _execute(r: IsoRunner, block: IsoBlock, index: int) -> None:
    """Execute one block, with its flow control and assignments."""
    c = r.c
    if block.percent:
        c.has_ended = not r.calls or r.text is r.main
        return
    if block.has_slash and c.setup.block_delete:
        return
    if block.beside:
        c.remark(f"{block.beside}: no axis moves; it is passed over", 1, block.beside)
        return
    r.count_runs(index, index + 1)
    if c.tracer is not None:
        c.tracer.step(step_of(r, block, index))
    if block.subprogram_call is not None:
        call_by_name(r, block.subprogram_call, index)
        return
    if block.optional is not None and c.setup.block_delete:
        words, assigns = block.optional
        block = replace(block, words=block.words[:words], assigns=block.assigns[:assigns], flow=None)
    elif block.has_slash or block.optional is not None:
        c.remark(
            'blocks with "/" are executed; write block_delete = true in the set-up file to leave them out',
            kind="delete",
        )
    if block.flow is not None and block.flow.kind != "program":
        if block.words or block.assigns:
            text = "flow control must stand alone in its block; write the other words on a line of their own"
            raise BlockFault(block.flow.column, text)
        (o_word if c.language.words == "o" else macro)(r, block.flow, index)
        return
    if block.flow is not None:
        _program_number(r, block, index)
    values = r.assign(block.assigns)
    if block.words:
        _words(r, block, index)
    r.settle(values)


def _program_number(r: IsoRunner, block: IsoBlock, index: int) -> None:
    """Note an O number between programs: the one before has no end."""
    flow, c = block.flow, r.c
    assert flow is not None
    starts = r.text is r.main and r.text.programs.get(int(str(flow.label))) == index
    if not (c.moves and starts and not r.calls and c.language.words == "macro"):
        return
    refusal = f"program O{flow.label} begins here, but the one before has no end; add M30 or M99 before it"
    if min(r.text.programs.values()) < index:
        c.assume(
            f"the end of the program before O{flow.label}", "where that begins", refusal, column=flow.column
        )
        c.has_ended = True
        return
    c.assume(f"lines before O{flow.label}", "no part of the program", refusal, column=flow.column)
    c.moves.clear()
    c.sides.clear()
    c.q = ORIGIN
    c.locate()


def _words(r: IsoRunner, block: IsoBlock, index: int) -> None:
    """Execute the words of a block, and the calls among them."""
    c = r.c
    w = IsoWords(c, block)
    before, made = c.modal() if c.tracer else None, len(c.moves)
    if "macro" in w.g:
        macro_call(r, w, index)
        return
    call = w.m.get("call")
    if "turning" in w.g:
        w.used |= set("PQUWRXYZVIKDAE")
    if call is not None:
        w.used |= {"P", "L"}
    execute(c, w)
    if "irregular" in w.g:
        mill_pocket(r, w, index, lambda at: _run_line(r, at))
    if c.tracer is not None and before is not None and len(c.moves) > made:
        c.tracer.note(c, made, before, words_of(w), BlockPlace(r.text.name, index + 1, len(r.calls)))
    if "turning" in w.g:
        w.used -= set("PQUWRXYZVIKDAE")
        here = c.source
        turning(r, w, index, lambda at: _run_line(r, at))
        c.source = here
        unused_words(c, w)
    if call == 198 and not w.has("P"):
        c.assume(
            "M198, a code of the machine builder",
            "passed over: no motion",
            "M198 needs P, the number of the subprogram",
        )
    elif call in (98, 198):
        call_program(r, w, index, w.m_columns["call"])
    elif call == 97:
        call_block(r, w, index, w.m_columns["call"])
    elif call == 99:
        end_program(r, w, w.m_columns["call"], index)
    elif r.modal_macro is not None and len(c.moves) > made:
        modal_call(r, index)


def _run_line(r: IsoRunner, index: int) -> None:
    """Run one line of the text, out of its turn."""
    r.at = index + 1
    r.c.source = Source(index + 1, 1, 1)
    _execute(r, r.text.block(index), index)


# -- plain lines ----------------------------------------------------------------------------------------------------------
def _plain_lines(r: IsoRunner) -> None:
    """Read plain lines until one is not; leaves r.at on that one."""
    c = r.c
    if (
        c.motion not in ("G0", "G1") or c.world.matrix is not UNITY or c.feed_mode != "G94" or c.surface
        or c.diameter or c.exact_once or c.language.lathe or c.polar is not None or c.winding is not None
        or (c.language.words == "macro" and c.language.decimal_point != "calculator") or waits_for_words(c)
    ):  # fmt: skip
        return
    lines, match, emit, sides = r.text.lines, _PLAIN.match, c.moves.append, c.sides.append
    rapid_tail, line_tail = _tails(c)
    strict = c.language.words == "macro" and "decimal point" not in c.remark_keys
    unit, absolute, compensation, rapid = c.unit, c.absolute, c.compensation, c.motion == "G0"
    (x, y, z), (sx, sy, sz), start, at, end = (
        c.p,
        c.world.shift,
        c.tip(),
        r.at,
        min(len(lines), r.at + MoveFlow.CHUNK),
    )
    while at < end:
        text = lines[at]
        words = match(text)
        if words is None:
            break
        head, g, wx, wy, wz, f = words.groups()
        if strict and _pointless(wx, wy, wz):
            break  # time for the remark about decimal points
        if f is not None:
            if not float(f) >= 0.0:
                break
            c.feed = c.turning_feed = float(f)
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
        kind, tail = ("rapid", rapid_tail) if rapid else ("line", line_tail)
        emit(_new(Move, (kind, source, start, goal) + tail))
        sides(compensation)
        start = goal
    c.source = Source(r.at + 1, 1, 1)
    r.count_runs(r.at, at)
    r.at, c.motion, c.unmoved_axes = at, "G0" if rapid else "G1", unmoved_axes_behind(c, c.moves)
    o = c.tool_offset
    c.p, c.q = (x, y, z), (start[0] + o[0], start[1] + o[1], start[2] + o[2])


def _pointless(*words: str | None) -> bool:
    """Return whether a number other than zero is written without a decimal point."""
    return any(w is not None and "." not in w and float(w) for w in words)


def _tails(c: IsoControl) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """Return the fields of a rapid and a line behind their ends: of a move that goes nowhere."""
    here = c.tip()
    feed = None if c.feed is None else c.feed * c.feed_scale
    return tuple(c.move("rapid", here, here)[4:]), tuple(c.move("line", here, here, feed=feed)[4:])
