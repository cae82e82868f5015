"""Tracer: notes of the readers of all languages on every block, for rewriting the program.

Moves belong to the innermost block that made them: a block that calls a subprogram keeps only its own.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from vcmm.program.moves import Move
from vcmm.program.offsetting import piece_of, planar, turn_between
from vcmm.program.recorder import Recorder
from vcmm.program.state import Modal
from vcmm.program.trace import BlockPlace, ExecutedBlock, Trace, WordAt

NUMBER = re.compile(r"[-+]?[ \t]*(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:EX[-+]?\d+)?\Z", re.IGNORECASE)
SPARE = 1.2  # times the length that a rounding takes away stays unsplit


_LINE = re.compile(r"([^\r\n]*)(\r\n|\n|\r|\Z)")


def lines_with_ends(text: str) -> list[tuple[str, str]]:
    """Return the lines and their ends; CR LF, LF and CR end a line."""
    return [(m[1], m[2]) for m in _LINE.finditer(text)]


def decimals_of(text: str) -> int | None:
    """Return the digits behind the point or comma; None without one."""
    behind = re.search(r"[.,](\d*)", text)
    return None if behind is None else len(behind[1])


def is_plain_decimal(text: str) -> bool:
    """Return whether a value is written as a plain decimal number."""
    return NUMBER.match(text.strip()) is not None and "EX" not in text.upper()


def word_at(
    letter: str, line: str, number: int, span: tuple[int, int], value: tuple[int, int], mode: str = ""
) -> WordAt:
    """Return a word of a line; span and value: columns from 1, one past the last."""
    text = line[value[0] - 1 : value[1] - 1]
    return WordAt(
        letter, *span, text, plain=is_plain_decimal(text), decimals=decimals_of(text) if is_plain_decimal(text) else None,
        begin=value[0], end=value[1], mode=mode, line=number,
    )  # fmt: skip


def written_out(value: float, sign: bool = False) -> str:
    """Return a number instead of an expression: nine decimals at most."""
    text = f"{value:+.9f}" if sign else f"{value:.9f}"
    text = text.rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else "+0" if text == "+0" else text


@dataclass(eq=False)
class Tracer:
    """lines: of the text. cycle: words of the definition of the cycle in force."""

    lines: Sequence[str] = ()
    traces: dict[int, Trace] = field(default_factory=dict)
    steps: list[ExecutedBlock] = field(default_factory=list)
    runs: dict[tuple[str, int], int] = field(default_factory=dict)
    cycle: Mapping[str, WordAt] = field(default_factory=dict)
    state: Any = None  # the modal state noted last

    def step(self, step: ExecutedBlock) -> None:
        """Begin a block."""
        at = step.file, step.line
        self.runs[at] = self.runs.get(at, 0) + 1
        self.steps.append(step)

    def note(
        self, r: Recorder, made: int, before: Modal, words: Mapping[str, WordAt], place: BlockPlace
    ) -> None:
        """Keep traces of the moves from `made` on that no inner block has noted."""
        before, after, world = self._intern(before), self._intern(r.modal()), r.world
        for i in range(made, len(r.moves)):
            if i in self.traces:
                continue
            move, marker = r.moves[i], r.markers[i]
            self.traces[i] = Trace(
                file=place.file, line=place.line, words=self.cycle if marker and self.lines else words, before=before,
                after=after, transformation=world, runs=0,
                cycle=marker, call=place.call, contour=move, compensation=r.sides[i],
            )  # fmt: skip

    def _intern(self, state: Modal) -> Modal:
        """Return the same object for the same state as last time: most blocks change nothing, and a program has 10^5 of them."""
        if state != self.state:
            self.state = state
        return self.state

    def result(self, r: Recorder) -> tuple[tuple[Trace, ...], tuple[ExecutedBlock, ...]]:
        """Return all traces in order of the moves, with what roundings take away."""
        guards = _guards(r)
        traces = [
            trace._replace(
                runs=self.runs.get((trace.file, trace.line), 1),
                guard=guards.get(i, (0.0, 0.0)),
                contour=_as_line(r.moves[i]),
            )
            for i, trace in sorted(self.traces.items())
        ]
        return tuple(traces), tuple(self.steps)


def _as_line(move: Move) -> Move:
    """Return an approach as the line to its first point."""
    return move._replace(kind="line", seconds=0.0) if move.kind == "approach" else move


def _guards(r: Recorder) -> dict[int, tuple[float, float]]:
    """Return the lengths that roundings and chamfers take from the ends of the moves beside them: r tan(turn / 2) of two lines."""
    out: dict[int, tuple[float, float]] = {}
    for corner in r.corners:
        following = next((k for k in range(corner.after + 1, len(r.moves)) if planar(r.moves[k])), None)
        if following is None:
            continue
        length = SPARE * corner.size * _share(r.moves[corner.after], r.moves[following], corner.kind)
        first, second = out.get(corner.after, (0.0, 0.0)), out.get(following, (0.0, 0.0))
        out[corner.after], out[following] = (first[0], length), (length, second[1])
    return out


def _share(before: Move, behind: Move, kind: str) -> float:
    turn = abs(turn_between(piece_of(before), piece_of(behind)))
    if kind == "round":
        return math.tan(min(turn, 3.1) / 2.0)
    return 1.0 if kind == "chamfer" else 0.5 / max(math.cos(turn / 2.0), 0.02)
