"""Macro B of Fanuc: GOTO, IF, WHILE, M98 and M99, G65 to G67."""

from __future__ import annotations

from typing import NamedTuple

from vcmm.program.expressions import Value, whole_number
from vcmm.program.faults import BlockFault
from vcmm.program.iso.blocks import IsoFlow
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.flow import ActiveCall, IsoRunner
from vcmm.program.iso.lengths import pass_over_axes
from vcmm.program.iso.probing_macros import measuring_macro
from vcmm.program.iso.texts import Text

ARGUMENTS = dict(
    zip("ABCIJKDEFHMQRSTUVWXYZ", (1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 13, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26))
)


def macro(r: IsoRunner, flow: IsoFlow, here: int) -> None:
    """Execute GOTO, IF, WHILE, END."""
    if flow.kind == "goto":
        _goto(r, flow.values[0], flow.column, here)
    elif flow.kind == "if-goto":
        if r.truth(flow.values[0], flow.column):
            _goto(r, flow.values[1], flow.column, here)
    elif flow.kind == "if-then":
        if r.truth(flow.values[0], flow.column):
            r.settle(r.assign(flow.then))
    elif flow.kind in ("while", "do"):
        end = r.text.loop_end(str(flow.label), here)
        if end is None:
            raise BlockFault(flow.column, f"END{flow.label} is missing after this line; add it")
        if flow.kind == "while" and not r.truth(flow.values[0], flow.column):
            r.at = end + 1
    elif flow.kind == "end":
        start = r.text.loop_start(str(flow.label), here)
        if start is None:
            raise BlockFault(flow.column, f"END{flow.label} without WHILE[...] DO{flow.label} before it")
        r.jump(start, here, flow.column)


def _goto(r: IsoRunner, value: Value, column: int, here: int) -> None:
    number = whole_number(r.compute(value, column), "the block number of GOTO")
    index = r.text.number(number, here)
    if index is None:
        raise BlockFault(column, f"GOTO {number}: this program has no block N{number}")
    r.jump(index, here, column)


def call_program(r: IsoRunner, w: IsoWords, here: int, column: int) -> None:
    """Call M98 Pn Lm, or P with the repeats before four digits (P50012: five times O12)."""
    number = w.whole("P", column)
    times = w.whole("L", column)
    if number is None:
        raise BlockFault(column, "M98 needs P, the number of the subprogram, as in M98 P100 L3")
    if times is None and number > 9999 and number not in r.text.programs:
        times, number = divmod(number, 10000)
    start_program(r, ProgramCall("M98", number, 1 if times is None else times), here, column)


def call_by_name(r: IsoRunner, called: tuple[str, int], here: int) -> None:
    """Call M98 <NAME> Lm (Fanuc), M98 (NAME.nc) Lm (Haas): a subprogram in a file of that name."""
    name, times = called
    other = r.load([name])
    if other is None:
        r.missing(name, name, 1)
    elif times:
        r.push(ActiveCall(r.text, here + 1, "M98", name, 0, times), None, 1)
        r.enter(other, 0)


def call_block(r: IsoRunner, w: IsoWords, here: int, column: int) -> None:
    """Call M97 Pn Lm (Haas): the subprogram that begins at block N n of this file."""
    number, times = w.whole("P", column), w.whole("L", column)
    index = None if number is None else r.text.number(number, here)
    if index is None:
        raise BlockFault(column, f"M97 needs P, the number of a block of this program; there is no N{number}")
    if times != 0:
        r.push(ActiveCall(r.text, here + 1, "M98", f"N{number}", index, times or 1), None, column)
        r.enter(r.text, index)


class ProgramCall(NamedTuple):
    """Call by M98 or G65: the number of the program, repetitions, and its local variables."""

    code: str
    number: int
    times: int = 1
    arguments: dict[int, float] | None = None


def start_program(r: IsoRunner, call: ProgramCall, here: int, column: int) -> None:
    """Continue in a program of this file or of one beside it."""
    number = call.number
    if call.times == 0:
        return
    text, start = r.text, r.text.programs.get(number)
    if start is None:
        text, start = r.main, r.main.programs.get(number)
    if start is None:
        other = r.load(
            [f"O{number:04d}", f"O{number}", f"{number}", f"{number:04d}", f"O{number:05d}", f"O{number:08d}"]
        )
        if other is not None:
            text, start = other, other.programs.get(number, 0)
    if start is None and call.code == "G65" and measuring_macro(r.c, number, call.arguments or {}, column):
        return
    if start is None:
        r.missing(f"O{number}", f"O{number:04d}.nc", column)
        return
    first = start + 1 if text.programs.get(number) == start and not _more_on_line(text, start) else start
    under_way = ActiveCall(r.text, here + 1, call.code, f"O{number}", first, call.times)
    r.push(under_way, call.arguments, column)
    r.enter(text, first)


def _more_on_line(text: Text, index: int) -> bool:
    return bool(text.block(index).words)


def end_program(r: IsoRunner, w: IsoWords, column: int, here: int) -> None:
    """End a program with M99: back to the caller, to its block P if given; in the main program: the program would start again."""
    number = w.whole("P", column)
    if not r.calls:
        _main_again(r, number, column, here)
        return
    again = r.calls[-1].runs_left > 1
    r.pop()
    if number is not None and not again:
        index = r.text.number(number, r.at - 1)
        if index is None:
            raise BlockFault(column, f"M99 P{number}: the calling program has no block N{number}")
        r.jump(index, r.at, column)


def _main_again(r: IsoRunner, number: int | None, column: int, here: int) -> None:
    """Execute M99 in the main program: from its start again; with P it goes on at that block, for ever where no jump leads out."""
    index = None if number is None else r.text.number(number, here)
    if number is not None and index is None:
        raise BlockFault(column, f"M99 P{number}: this program has no block N{number}")
    if index is not None and (index > here or r.text.has_jumps(index, here)):
        r.jump(index, here, column)
        return
    where = "starts it again" if index is None else f"goes back to N{number}"
    r.c.remark(f"M99 in the main program {where} for ever; it is read once", column)
    r.c.has_ended = True


def macro_call(r: IsoRunner, w: IsoWords, here: int) -> None:
    """Execute G65 (once), G66 (after every motion), G67 (no longer)."""
    code, column = w.g["macro"], w.g_columns["macro"]
    if code == "G67":
        r.modal_macro = None
        pass_over_axes(r.c, w)
        return
    number = w.whole("P", column)
    times = w.whole("L", column)
    if number is None:
        raise BlockFault(column, f"{code} needs P, the number of the macro program, as in {code} P9100 A1.0")
    w.used |= set(w.values)
    arguments = [(letter, value) for letter, value in w.repeated if letter not in "PL"]
    if code == "G66":
        r.modal_macro = (number, arguments)
        return
    start_program(
        r, ProgramCall("G65", number, 1 if times is None else times, arguments_of(arguments)), here, column
    )


def modal_call(r: IsoRunner, here: int) -> None:
    """Call the macro of G66 after a block that has moved."""
    if r.modal_macro is not None and not any(f.kind == "G65" for f in r.calls):
        number, arguments = r.modal_macro
        start_program(r, ProgramCall("G65", number, 1, arguments_of(arguments)), r.at - 1, 1)


def arguments_of(arguments: list[tuple[str, float]]) -> dict[int, float]:
    """Return the local variables of a macro call: A is #1 ... Z is #26; repeated I J K fill #4, #5, #6, then #7, #8, #9 and so on."""
    out: dict[int, float] = {}
    sets = {"I": 0, "J": 0, "K": 0}
    for letter, value in arguments:
        if letter in sets:
            out[ARGUMENTS[letter] + 3 * sets[letter]] = value
            sets[letter] += 1
        elif letter in ARGUMENTS:
            out[ARGUMENTS[letter]] = value
    return out
