"""Programs that never end: the control has exactly the state of an earlier pass at the same block, so all later blocks repeat.

A program has no other input than its state. Where that is the same at two passes of one block, every later pass is the same too;
the states are compared after Brent, An improved Monte Carlo factorization algorithm, BIT 20 (1980) 176: with one that was kept
at a pass whose number is a power of two.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from vcmm.program.faults import BlockFault
from vcmm.program.levels import Telling

LATEST = 3  # moves that later ones may look back at
FIRST = 1024  # passes backwards before states are looked at: hardly a program has as many
OUTSIDE_STATE = frozenset({  # what is read or written only, never asked by a block: text, results, counts of blocks
    "setup", "language", "text", "main", "others", "lines", "labels", "sections", "folders", "work", "short", "current", "missing",
    "moves", "sides", "finishes", "remarks", "remark_keys", "assumptions", "unused_words", "misfits", "work_offsets", "tool_names", "markers", "tracer", "flow", "source", "column",
    "blocks_run", "last_motion", "moves_seen", "idle", "repeated", "block_count", "states",
})  # fmt: skip
ENDLESS = (
    "this loop is endless: position, variables and modes are exactly those of an earlier pass, and clocks and signals of the "
    "machine stand still here, so every pass follows again; "
    "give it a condition that changes, or an end (M30)"
)
PLAIN = (type(None), bool, int, float, str, bytes, complex)


class WaitingRecorder(Telling, Protocol):
    """vcmm.program.recorder.Recorder."""

    states: RepeatedStates


@dataclass(slots=True)
class RepeatedStates:
    """The state kept, and how many passes there have been."""

    passes: int = 0
    place: Hashable = None
    values: object = None
    whole: Hashable = None
    machine_value: str = ""  # what only the machine knows and blocks have asked since that pass

    def is_repetition(
        self, place: Hashable, values: Callable[[], object], whole: Callable[[], object]
    ) -> bool:
        """Note one pass backwards. place: block and position; values: variables, as something that compares; whole: all that blocks ask.

        Returns True where the state equals that of the pass that was kept.
        """
        self.passes += 1
        if self.passes < FIRST:
            return False
        if self.passes & (self.passes - 1) == 0:
            self.place, self.values, self.whole = place, values(), content_of(whole())
            self.machine_value = ""
            return False
        return place == self.place and values() == self.values and content_of(whole()) == self.whole

    def leave_wait(self, recorder: Telling, column: int, sure: bool = True) -> bool:
        """Return where a state repeats: whether the loop waits for what only the machine knows. A survey goes on behind it, and says so.

        Raises BlockFault where it asks for nothing of that kind and all values are `sure`: it never ends.
        """
        if not self.machine_value and sure:
            raise BlockFault(column, ENDLESS)
        if not self.machine_value:
            return False
        recorder.assume(
            f"the end of the wait in line {recorder.line}, for {self.machine_value}",
            "reached: the program goes on behind the loop",
            f"this loop waits for {self.machine_value}, which only the machine knows; set it in the program, or leave the wait out",
        )
        self.passes = FIRST - 1
        return True


@contextmanager
def own_states(recorder: WaitingRecorder) -> Iterator[None]:
    """Give each run of a repeated part of a program states of its own, because the count of repetitions is no variable."""
    outer = recorder.states
    recorder.states = RepeatedStates()
    try:
        yield
    finally:
        outer.machine_value = recorder.states.machine_value or outer.machine_value
        recorder.states = outer


def content_of(thing: Any) -> Hashable:
    """Return the contents of objects, except values that no block uses, as nested tuples that can be compared; what cannot be looked into
    counts as itself."""
    return _content_of(thing, {})


def _content_of(thing: Any, numbers: dict[int, int]) -> Hashable:
    if isinstance(thing, PLAIN):
        return (type(thing).__name__, repr(thing))
    if id(thing) in numbers:
        return ("numbers", numbers[id(thing)])
    numbers[id(thing)] = len(numbers)
    if isinstance(thing, dict):
        return ("dict", tuple((_content_of(k, numbers), _content_of(v, numbers)) for k, v in thing.items()))
    if isinstance(thing, list | tuple):
        return (type(thing).__name__, tuple(_content_of(v, numbers) for v in thing))
    if isinstance(thing, set | frozenset):
        return ("set", tuple(sorted(repr(_content_of(v, {})) for v in thing)))
    if isinstance(thing, np.ndarray):
        return ("array", thing.shape, thing.tobytes())
    fields = sorted(_fields(thing))
    if not fields:
        return (type(thing).__name__, id(thing))  # functions and the like
    return (
        type(thing).__name__,
        tuple((name, _content_of(getattr(thing, name), numbers)) for name in fields),
    )


def _fields(thing: Any) -> Iterable[str]:
    if callable(thing):
        return ()
    slots = {
        s for c in type(thing).__mro__ for s in _as_tuple(getattr(c, "__slots__", ())) if hasattr(thing, s)
    }
    return (slots | set(getattr(thing, "__dict__", ()))) - OUTSIDE_STATE


def _as_tuple(slots: Any) -> tuple[str, ...]:
    return (slots,) if isinstance(slots, str) else tuple(slots)
