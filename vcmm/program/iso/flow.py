"""Subprograms, loops and jumps: O-words of LinuxCNC, macro B of Fanuc, M98 and M99. All of them are bounded."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from vcmm.program.expressions import Value, evaluate, whole_number
from vcmm.program.faults import BlockFault
from vcmm.program.iso.blocks import Assign, IsoFlow
from vcmm.program.iso.control import IsoControl
from vcmm.program.iso.modes import restore
from vcmm.program.iso.parameters import ParameterTable
from vcmm.program.iso.texts import Text
from vcmm.program.levels import NOT_MOVED
from vcmm.program.moves import MoveFlow
from vcmm.program.radius import centre_path
from vcmm.program.repeating import LATEST
from vcmm.program.search import find_file

DEEPEST = 50
LOOKING_BACK = 20  # moves after radius compensation before its exit is past
IDLE_JUMPS = 100_000  # backward jumps without any motion: an endless loop
MOST_REPETITIONS = 500_000  # blocks executed again, in loops and subprograms


class EndOfReading(Exception):
    """The end of what can be read of a subprogram on its own, and why."""


@dataclass(slots=True)
class ActiveCall:
    """A subprogram under way: where to go on, and how often it still has to be run."""

    text: Text
    back: int
    kind: str  # "o" | "M98" | "G65"
    label: str
    start: int
    runs_left: int = 0
    has_parameters: bool = False  # of its own


class IsoRunner:
    """Position in the program. `at` is the index of the next line."""

    def __init__(self, c: IsoControl, table: ParameterTable, text: Text, folders: Sequence[Path]) -> None:
        self.c, self.table, self.text, self.folders = c, table, text, folders
        self.main = text
        self.at = 0
        self.calls: list[ActiveCall] = []
        self.counters: dict[tuple[int, str], int] = {}
        self.others: dict[str, Text] = {}
        self.idle, self.moves_seen, self.repeated = 0, 0, 0
        self.flow: MoveFlow | None = None  # who takes finished moves as they come
        self.fragment = False  # a subprogram on its own: its arguments are missing
        self.modal_macro: tuple[int, list[tuple[str, float]]] | None = None

    def hand_on(self) -> None:
        """Hand final moves on to `flow`: none is under radius compensation or awaits its corner."""
        c = self.c
        settled = c.compensation is None and not c.corners and not any(c.sides[-LOOKING_BACK:])
        if self.flow is None or len(c.moves) < MoveFlow.CHUNK or not settled:
            return
        moves = centre_path(c.moves, c.sides, self.main.name) if any(c.sides) else c.moves
        self.flow.take(moves)
        c.moves, c.sides = [], []
        self.moves_seen = -1

    # -- jumps ----------------------------------------------------------------------------------------------------
    def jump(self, index: int, here: int, column: int) -> None:
        """Continue at a line; counts backward jumps that produce nothing."""
        if index <= here:
            if len(self.c.moves) != self.moves_seen:
                self.idle, self.moves_seen = 0, len(self.c.moves)
            self.idle += 1
            if self._endless(index) and self.c.states.leave_wait(self.c, column):
                return
            if self.idle > IDLE_JUMPS and self.fragment:
                raise EndOfReading("the loop that ends here runs for ever without its arguments")
            if self.idle > IDLE_JUMPS:
                raise BlockFault(
                    column,
                    f"the loop has run {IDLE_JUMPS} times without a motion: it seems endless; check its condition",
                )
        self.at = index

    def _endless(self, index: int) -> bool:
        """Return whether a jump back to a line finds everything as an earlier one found it."""
        c, table = self.c, self.table

        def values() -> object:
            calls = [(id(k.text), k.back, k.start, k.runs_left) for k in self.calls]
            return (
                calls,
                dict(table.common),
                dict(table.locals[-1]),
                dict(table.named_locals[-1]),
                dict(self.counters),
            )

        def whole() -> object:
            return (values(), self.calls, table, self.modal_macro, c.moves[-LATEST:])

        return c.states.is_repetition((id(self.text), index, c.p, c.q, c.rotary), values, whole)

    def count_runs(self, first: int, last: int) -> None:
        """Count the runs of lines first to last - 1. Raises BlockFault where too many are repeated."""
        runs = self.text.runs
        for index in range(first, last):
            runs[index] += 1
        if last > first and runs[first] > 1:
            self.repeated += last - first
            if self.repeated > MOST_REPETITIONS:
                text = f"loops and subprograms have executed more than {MOST_REPETITIONS} blocks again; check their conditions"
                raise BlockFault(1, text)

    def truth(self, value: Value, column: int) -> bool:
        number = self.compute(value, column)
        return bool(number)

    def compute(self, value: Value, column: int) -> float | None:
        try:
            return evaluate(value, self.table)
        except BlockFault as fault:
            raise BlockFault(fault.column or column, fault.text) from None

    def assign(
        self, assigns: list[Assign] | tuple[Assign, ...]
    ) -> list[tuple[str | float | None, float | None, int]]:
        """Return targets and values now; `settle` sets them later, because all assignments of a block are made at once."""
        out: list[tuple[str | float | None, float | None, int]] = []
        for assignment in assigns:
            target = (
                self.compute(assignment.target, assignment.column)
                if callable(assignment.target)
                else assignment.target
            )
            out.append((target, self.compute(assignment.value, assignment.column), assignment.column))
        return out

    def settle(self, values: list[tuple[str | float | None, float | None, int]]) -> None:
        for target, value, column in values:
            try:
                self.table.set(target, value, column)
            except BlockFault as fault:
                raise BlockFault(fault.column or column, fault.text) from None

    # -- calls ----------------------------------------------------------------------------------------------------
    def push(self, call: ActiveCall, arguments: dict[int, float] | None, column: int) -> None:
        if len(self.calls) >= DEEPEST:
            raise BlockFault(
                column,
                f"subprograms call one another more than {DEEPEST} deep; {call.label} seems to call itself",
            )
        runs = math.prod(max(1, c.runs_left) for c in (*self.calls, call))
        if runs > MOST_REPETITIONS:
            raise BlockFault(
                column,
                f"{call.label} would be run {runs} times; {MOST_REPETITIONS} are the most, check the repeats",
            )
        if arguments is not None:
            self.table.locals.append(arguments)
            self.table.named_locals.append({})
            call.has_parameters = True
        self.calls.append(call)
        self.c.states_of_m73.append(None)

    def pop(self) -> None:
        """End a subprogram: again from its start, or back."""
        call = self.calls[-1]
        if call.runs_left > 1:
            call.runs_left -= 1
            self.at = call.start
            return
        self.calls.pop()
        if self.c.states_of_m73 and (saved := self.c.states_of_m73.pop()) is not None:
            restore(self.c, saved)
        if call.has_parameters:
            self.table.locals.pop()
            self.table.named_locals.pop()
        self.text, self.at = call.text, call.back
        self.c.file = self.text.name

    def enter(self, text: Text, start: int) -> None:
        self.text, self.at = text, start
        self.c.file = text.name

    def missing(self, label: str, file: str, column: int) -> None:
        """Note a missing subprogram: a hole in the path."""
        refusal = f"the subprogram {label} is neither in this program nor in a file {file} beside it; add it"
        if self.c.language.words == "macro":
            refusal = f"the subprogram {label} is neither in this file nor in a file {file} beside it; add it"
        value = NOT_MOVED
        self.c.assume(f"the subprogram {label} ({file})", value, refusal, column=column)

    def load(self, names: list[str]) -> Text | None:
        """Return a subprogram in a file of its own."""
        path = find_file(self.folders, names)
        if path is None:
            return None
        if str(path) not in self.others:
            from vcmm.program.reading import read_bytes

            self.others[str(path)] = Text(str(path), read_bytes(path), self.text.dialect)
        return self.others[str(path)]


# -- O-words --------------------------------------------------------------------------------------------------------------
def o_word(r: IsoRunner, flow: IsoFlow, here: int) -> None:
    """Execute an O-word of line `here` (an index)."""
    label = (
        flow.label
        if isinstance(flow.label, str)
        else str(whole_number(r.compute(flow.label, flow.column), "the label"))
    )
    _O_WORDS[flow.kind](r, flow, label, here)


def _sub(r: IsoRunner, flow: IsoFlow, label: str, here: int) -> None:
    r.at = r.text.next_o(label, ("endsub",), here, flow.column) + 1


def _call(r: IsoRunner, flow: IsoFlow, label: str, here: int) -> None:
    arguments = {i: r.compute(v, flow.column) or 0.0 for i, v in enumerate(flow.values, 1)}
    text, start = r.text, r.text.subprogram(label)
    if start is None:
        text, start = r.main, r.main.subprogram(label)
    if start is None:
        other = r.load([label])
        start = other.subprogram(label) if other else None
        text = other or r.text
    if start is None:
        r.missing(f"o<{label}>", f"{label}.ngc", flow.column)
        return
    r.push(ActiveCall(r.text, here + 1, "o", f"o<{label}>", start + 1), arguments, flow.column)
    r.enter(text, start + 1)


def _return(r: IsoRunner, flow: IsoFlow, label: str, here: int) -> None:
    if not r.calls or r.calls[-1].kind != "o":
        if flow.kind == "return" and not r.calls:
            raise BlockFault(flow.column, "return outside a subprogram; remove it")
        raise BlockFault(
            flow.column, f"o{label} {flow.kind} without a call that led here; add o{label} sub before it"
        )
    value = r.compute(flow.values[0], flow.column) if flow.values else None
    r.pop()
    r.table.named_common["_value"] = value or 0.0
    r.table.named_common["_value_returned"] = 1.0 if flow.values else 0.0


def _if(r: IsoRunner, flow: IsoFlow, label: str, here: int) -> None:
    if r.truth(flow.values[0], flow.column):
        return
    index = here
    while True:
        index = r.text.next_o(label, ("elseif", "else", "endif"), index, flow.column)
        branch = r.text.block(index).flow
        assert branch is not None
        if branch.kind != "elseif" or r.truth(branch.values[0], branch.column):
            r.at = index + 1
            return


def _else(r: IsoRunner, flow: IsoFlow, label: str, here: int) -> None:
    r.text.last_o(label, ("if",), here, flow.column)
    r.at = r.text.next_o(label, ("endif",), here, flow.column) + 1


def _endif(r: IsoRunner, flow: IsoFlow, label: str, here: int) -> None:
    r.text.last_o(label, ("if",), here, flow.column)


def _while(r: IsoRunner, flow: IsoFlow, label: str, here: int) -> None:
    start = _do_of(r, label, here)
    if start is not None:  # the end of do ... while
        if r.truth(flow.values[0], flow.column):
            r.jump(start + 1, here, flow.column)
        return
    end = r.text.next_o(label, ("endwhile",), here, flow.column)
    if not r.truth(flow.values[0], flow.column):
        r.at = end + 1


def _do_of(r: IsoRunner, label: str, here: int) -> int | None:
    """Return the `do` that a `while` closes: the nearest word of that label before it."""
    before = [
        (i, kind)
        for i, kind in r.text.o_words.get(label, ())
        if i < here and kind not in ("break", "continue")
    ]
    return before[-1][0] if before and before[-1][1] == "do" else None


def _endwhile(r: IsoRunner, flow: IsoFlow, label: str, here: int) -> None:
    r.jump(r.text.last_o(label, ("while",), here, flow.column), here, flow.column)


def _do(r: IsoRunner, flow: IsoFlow, label: str, here: int) -> None:
    r.text.next_o(label, ("while",), here, flow.column)


def _repeat(r: IsoRunner, flow: IsoFlow, label: str, here: int) -> None:
    count = r.compute(flow.values[0], flow.column) or 0.0
    if count < 1:
        r.at = r.text.next_o(label, ("endrepeat",), here, flow.column) + 1
        return
    r.text.next_o(label, ("endrepeat",), here, flow.column)
    if count > MOST_REPETITIONS:
        raise BlockFault(
            flow.column,
            f"o{label} would be repeated {count:.0f} times; {MOST_REPETITIONS} are the most, check its number",
        )
    r.counters[(len(r.calls), label)] = int(count)


def _endrepeat(r: IsoRunner, flow: IsoFlow, label: str, here: int) -> None:
    start = r.text.last_o(label, ("repeat",), here, flow.column)
    key = (len(r.calls), label)
    left = r.counters.get(key, 0) - 1
    r.counters[key] = left
    if left > 0:
        r.jump(start + 1, here, flow.column)


def _break(r: IsoRunner, flow: IsoFlow, label: str, here: int) -> None:
    r.at = _loop_end(r, flow, label, here) + 1


def _continue(r: IsoRunner, flow: IsoFlow, label: str, here: int) -> None:
    r.at = _loop_end(r, flow, label, here)


def _loop_end(r: IsoRunner, flow: IsoFlow, label: str, here: int) -> int:
    return r.text.next_o(label, ("endwhile", "endrepeat", "while"), here, flow.column)


_O_WORDS = {
    "sub": _sub, "call": _call, "endsub": _return, "return": _return, "if": _if, "elseif": _else, "else": _else,
    "endif": _endif, "while": _while, "endwhile": _endwhile, "do": _do, "repeat": _repeat, "endrepeat": _endrepeat,
    "break": _break, "continue": _continue,
}  # fmt: skip
