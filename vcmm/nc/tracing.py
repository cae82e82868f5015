"""Tracer: what the front-ends for Sinumerik and Klartext note of every block, for whoever rewrites the program.

Moves belong to the innermost block that made them: a block that calls a subprogram keeps only its own.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from vcmm.nc.control import Affine, Compensation, Modal
from vcmm.nc.moves import Move, Point
from vcmm.nc.recorder import Recorder
from vcmm.nc.rounding import planar
from vcmm.nc.trace import Cut, Step, Trace, WordAt

NUMBER = re.compile(r"[-+]?[ \t]*(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:EX[-+]?\d+)?\Z", re.IGNORECASE)
SPARE = 1.2  # times the length that a rounding takes away stays unsplit


_LINE = re.compile(r"([^\r\n]*)(\r\n|\n|\r|\Z)")


def lines_with_ends(text: str) -> list[tuple[str, str]]:
    """Lines and their ends; CR LF, LF and CR end a line."""
    return [(m[1], m[2]) for m in _LINE.finditer(text)]


def decimals_of(text: str) -> int | None:
    """Digits behind the point or comma; None without one."""
    found = re.search(r"[.,](\d*)", text)
    return None if found is None else len(found[1])


def plain(text: str) -> bool:
    """Whether a value is written as a plain decimal number."""
    return NUMBER.match(text.strip()) is not None and "EX" not in text.upper()


def word_at(
    letter: str, line: str, number: int, span: tuple[int, int], value: tuple[int, int], mode: str = ""
) -> WordAt:
    """A word of a line; span and value: columns from 1, one past the last."""
    text = line[value[0] - 1 : value[1] - 1]
    return WordAt(
        letter, *span, text, plain(text), decimals_of(text) if plain(text) else None, *value, mode, number
    )


def written_out(value: float, sign: bool = False) -> str:
    """A number instead of an expression: nine decimals at most."""
    text = f"{value:+.9f}" if sign else f"{value:.9f}"
    text = text.rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else "+0" if text == "+0" else text


@dataclass(eq=False)
class Tracer:
    """lines: of the text. cycle: words of the definition of the cycle in force."""

    file: str
    lines: Sequence[str]
    traces: dict[int, Trace] = field(default_factory=dict)
    steps: list[Step] = field(default_factory=list)
    runs: dict[int, int] = field(default_factory=dict)
    cycle: Mapping[str, WordAt] = field(default_factory=dict)

    def step(self, line: int, last: int, call: int, cuts: Sequence[Cut]) -> None:
        """A block is executed."""
        self.runs[line] = self.runs.get(line, 0) + 1
        self.steps.append(Step(self.file, line, last, call, tuple(cuts)))

    def note(
        self, r: Recorder, made: int, before: Modal, after: Modal, words: Mapping[str, WordAt], line: int, call: int
    ) -> None:  # fmt: skip
        """Traces of the moves from `made` on that no inner block has noted."""
        world = r.whole()
        affine = Affine(world.matrix, world.shift)
        for i in range(made, len(r.moves)):
            if i in self.traces:
                continue
            move, side = r.moves[i], r.sides[i]
            marker = r.markers[i]
            ends: tuple[Point, Point] = (world.undo(move.start), world.undo(move.end))
            self.traces[i] = Trace(
                self.file, line, self.cycle if marker else words, before, after, ends, affine, 0, marker, call, move,
                None if side.side is None else Compensation(side.side, side.radius),
            )  # fmt: skip

    def result(self, r: Recorder) -> tuple[tuple[Trace, ...], tuple[Step, ...]]:
        """All traces in order of the moves, with what roundings take away."""
        guards = _guards(r)
        found = [
            self.traces[i]._replace(
                runs=self.runs.get(self.traces[i].line, 1),
                guard=guards.get(i, (0.0, 0.0)),
                contour=_shown(r.moves[i]),
            )
            for i in sorted(self.traces)
        ]
        return tuple(found), tuple(self.steps)


def _shown(move: Move) -> Move:
    """An approach as the line to its first point."""
    return move._replace(kind="line", seconds=0.0) if move.kind == "approach" else move


def _guards(r: Recorder) -> dict[int, tuple[float, float]]:
    """Lengths that roundings and chamfers take from the ends of the moves beside them: r tan(turn / 2) of two lines."""
    out: dict[int, tuple[float, float]] = {}
    for one in r.corners:
        following = next((k for k in range(one.after + 1, len(r.moves)) if planar(r.moves[k])), None)
        if following is None:
            continue
        length = SPARE * one.size * _share(r, one.after, following, one.kind)
        first, second = out.get(one.after, (0.0, 0.0)), out.get(following, (0.0, 0.0))
        out[one.after], out[following] = (first[0], length), (length, second[1])
    return out


def _share(r: Recorder, k: int, following: int, kind: str) -> float:
    from vcmm.nc.offsetting import turn_between
    from vcmm.nc.rounding import piece_of

    turn = abs(turn_between(piece_of(r.moves[k]), piece_of(r.moves[following])))
    if kind == "round":
        return math.tan(min(turn, 3.1) / 2.0)
    return 1.0 if kind == "chamfer" else 0.5 / max(math.cos(turn / 2.0), 0.02)


def modal_of(
    r: Recorder, motion: str | None, unit: float, absolute: bool, side: str | None, diameter: bool
) -> Modal:
    """The modal state of a recorder and of the front-end that feeds it."""
    feed = 0.0 if r.feed_mode == "G93" else r.feed or 0.0  # inverse time is that of each block
    return Modal(
        motion, r.plane, unit, absolute, False, r.feed_mode, feed, "G96" if r.surface else "G97", r.speed, r.offset, side,
        "", r.tool, r.tool_offset, r.exact_stop, r.tolerance, diameter,
    )  # fmt: skip
