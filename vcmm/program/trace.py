"""Trace: for each move, its words and the values in force; for rewriting the program.

Made only on request (interpret(..., trace=True)), parallel to Program.moves. Where radius compensation is on, moves at
outside corners are added and the two are no longer parallel: the traces are those of the programmed contour.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Protocol

from vcmm.program.frames import AffineMap
from vcmm.program.moves import Move
from vcmm.program.radius import RadiusCompensation
from vcmm.program.state import Modal


class WordAt(NamedTuple):
    """A word of the block. Columns from 1, one past the last: line[first - 1 : last - 1] is the word as written.

    text: the value as written; plain: a number, no expression; decimals: digits after the point, None without a point.
    """

    letter: str
    first: int
    last: int
    text: str
    plain: bool
    decimals: int | None
    begin: int = 0  # column at which the value begins, and one past its end; 0: behind the letter, to the end of the word
    end: int = 0
    mode: str = ""  # "AC", "IC": absolute or incremental in this word alone
    line: int = 0  # of the word, where the block has several lines; 0: that of the trace


class Trace(NamedTuple):
    """Origin of one move.

    file and line: the block; words: its words by letter (G and M words are not in it); before and after: modal state
    around the block; transformation: programmed point -> tip point at the end of the move; runs: how often the block was executed in
    the whole program; cycle: the canned cycle that made the move, "" for a move of its own; call: how many subprograms
    are under way; contour: the move as programmed, before radius compensation (the move itself where there is none);
    compensation: side and radius in force.
    """

    file: str
    line: int
    words: Mapping[str, WordAt]
    before: Modal
    after: Modal
    transformation: AffineMap
    runs: int
    cycle: str
    call: int
    contour: Move
    compensation: RadiusCompensation | None
    guard: tuple[float, float] = (0.0, 0.0)  # mm at start and end that a rounding or chamfer takes away


class TextCut(NamedTuple):
    """A place of a line that changes when the program is written out: columns from 1, `text` replaces them."""

    line: int
    first: int
    last: int
    text: str


class BlockPlace(NamedTuple):
    """Place of a block, and the number of calls under way."""

    file: str
    line: int
    call: int


class ExecutedBlock(NamedTuple):
    """One executed block: its lines, how deep in calls it stands, and how it reads without expressions and flow control."""

    file: str
    line: int
    last: int
    call: int
    cuts: tuple[TextCut, ...]


class Tracing(Protocol):
    """Interface of the tracer (vcmm.program.tracer.Tracer) for the recorder and the readers. r: the recorder."""

    lines: Sequence[str]
    cycle: Mapping[str, WordAt]

    def step(self, step: ExecutedBlock) -> None: ...

    def note(
        self, r: Any, made: int, before: Modal, words: Mapping[str, WordAt], place: BlockPlace
    ) -> None: ...

    def result(self, r: Any) -> tuple[tuple[Trace, ...], tuple[ExecutedBlock, ...]]: ...
