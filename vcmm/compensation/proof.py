"""Proof: the new program is read again, compared block by block with the old one, and run again on the machine.

departure = distance of the point where the tool tip (centre) really is from the programmed path of the original program,
            at the ends of blocks from the programmed end
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from vcmm.compensation.contours import length_of, nominal_distance, points, sweep_of
from vcmm.compensation.field import PathErrors
from vcmm.compensation.result import Departure
from vcmm.compensation.source import at_line
from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array
from vcmm.program.moves import Move, Program
from vcmm.program.trace import Trace
from vcmm.shop.cutting.contactmap import Ints

CUTS = ("line", "arc", "thread")
SHORTEST = 1e-3  # mm: a block that moves less takes no time of the control
_COMMENT = re.compile(r"\([^()\r\n]*\)|;[^\r\n]*")
_SEMICOLON = re.compile(r";[^\r\n]*")
SPACING, MOST_MOVE_PARTS = 2.0, 200


@dataclass(frozen=True, eq=False)
class Walk:
    """Points along the cutting moves of a program: move (k,), share (k,), tip (k, 3) as commanded, weight (k,) mm."""

    move: Ints
    share: Array
    tip: Array
    weight: Array


def walk(moves: Sequence[Move]) -> Walk:
    """Return knots on every cutting move that may be rewritten, its ends among them."""
    which, share, tip, weight = [], [], [], []
    for i, m in enumerate(moves):
        if m.kind not in CUTS or not m.rewritable:
            continue
        length = length_of(m)
        parts = max(math.ceil(length / SPACING), math.ceil(abs(sweep_of(m)) / 0.1), 2 if length > 0.5 else 1)
        s = np.linspace(0.0, 1.0, min(parts, MOST_MOVE_PARTS) + 1)
        which.append(np.full(len(s), i))
        share.append(s)
        tip.append(points(m, s))
        weight.append(np.full(len(s), length / len(s)))
    if not which:
        return Walk(np.zeros(0, dtype=np.intp), np.zeros(0), np.zeros((0, 3)), np.zeros(0))
    return Walk(
        np.concatenate(which).astype(np.intp),
        np.concatenate(share),
        np.concatenate(tip),
        np.concatenate(weight),
    )


def errors_on(field: PathErrors, w: Walk) -> Array:
    """Return the error (k, 3) at the points of a walk along the field's own moves."""
    if not len(w.move):
        return np.zeros((0, 3))
    return field.errors(field.run(w.move, w.share, w.tip), w.move)


def departures(at: Array, moves: Sequence[Move], low: Ints, high: Ints) -> Array:
    """Return the distance (k,) of points from the nearest of moves low..high (k,)."""
    out = np.full(len(at), np.inf)
    for by in range(int((high - low).max(initial=0)) + 1):
        rows = np.flatnonzero(low + by <= high)
        distance = np.linalg.norm(nominal_distance(at[rows], moves, low[rows] + by), axis=1)
        out[rows] = np.minimum(out[rows], distance)
    return out


def end_departures(
    at: Array, w: Walk, moves: Sequence[Move], old: Sequence[Move], low: Ints, high: Ints
) -> Array:
    """Return the distance (k,) from the programmed ends, at the ends of blocks; 0 elsewhere and where radius compensation moves the ends."""
    out = np.zeros(len(at))
    for rows, first in ((np.flatnonzero(w.share == 0.0), True), (np.flatnonzero(w.share == 1.0), False)):
        for row in rows.tolist():
            i = int(w.move[row])
            k = int(low[i])
            beside = moves[i].compensation or old[k].compensation
            other = i - 1 if first else i + 1
            inner = (
                0 <= other < len(moves) and low[other] == k == high[other]
            )  # another block of the same move
            if low[i] == high[i] and not inner and not beside:
                out[row] = float(np.linalg.norm(at[row] - np.array(old[k].start if first else old[k].end)))
    return out


def departure(values: Array, weight: Array, lines: Sequence[int]) -> Departure:
    """Return the largest departure, the rms over the length of the path, and the line of the largest."""
    if not len(values):
        return Departure(0.0, 0.0, 0)
    worst = int(values.argmax())
    total = float(weight.sum())
    rms = math.sqrt(float(weight @ values**2) / total) if total > 0 else float(np.sqrt(np.mean(values**2)))
    return Departure(float(values[worst]), rms, int(lines[worst]))


def best_shifts(error: Array, w: Walk, moves: Sequence[Move]) -> dict[str, Array]:
    """Return by least squares the shift (3,) mm of each work offset that removes most of the error; minus its mean along the path."""
    names = np.array([moves[i].offset for i in w.move.tolist()])
    out = {}
    for name in dict.fromkeys(names.tolist()):
        rows = names == name
        weight = np.maximum(w.weight[rows], 1e-12)
        out[name] = -np.asarray((weight[:, None] * error[rows]).sum(axis=0) / weight.sum())
    return out


def shift_errors(error: Array, w: Walk, moves: Sequence[Move], shifts: Mapping[str, Array]) -> Array:
    """Return the errors (k, 3) with the work offsets shifted."""
    return error + np.array([shifts[moves[i].offset] for i in w.move.tolist()]).reshape(-1, 3)


# -- block by block -------------------------------------------------------------------------------------------------
def spans(old: Program, new: Program, lines: Sequence[int]) -> tuple[Ints, Ints]:
    """Return the first and last old move (k,) that each new move may lie on; lines: source line of each line of the new program."""
    first: dict[int, list[int]] = {}
    for i, m in enumerate(old.moves):
        first.setdefault(m.source.line, []).append(i)
    groups: dict[int, list[int]] = {}
    for i, m in enumerate(new.moves):
        groups.setdefault(lines[m.source.line - 1], []).append(i)
    low, high = np.zeros(len(new.moves), dtype=np.intp), np.zeros(len(new.moves), dtype=np.intp)
    for line, members in groups.items():
        there = first[line]
        for k, i in enumerate(members):
            if len(there) == len(members):
                low[i] = high[i] = there[k]
            else:
                low[i], high[i] = there[0], there[-1]
            if new.moves[i].compensation:  # corners may belong to the block before or after
                low[i], high[i] = max(there[0] - 1, 0), min(there[-1] + 1, len(old.moves) - 1)
    return low, high


def compare(old: Program, new: Program, lines: Sequence[int], name: str) -> None:
    """Compare modal state, kinds, feeds and frames of every block. Raises ModelLimit where the new program does not mean the same."""
    before, after = _by_line(old.traces), _by_line(new.traces, lines)
    if list(before) != list(after):
        missing = [line for line in before if line not in after] or [
            line for line in after if line not in before
        ]
        raise _differs(name, (missing or [0])[0], "the blocks that move are not the same")
    for line, there in before.items():
        here = after[line]
        _compare_block(there, here, name, line)


def _by_line(traces: Sequence[Trace], lines: Sequence[int] = ()) -> dict[int, list[Trace]]:
    out: dict[int, list[Trace]] = {}
    for t in traces:
        out.setdefault(lines[t.line - 1] if lines else t.line, []).append(t)
    return out


def _compare_block(old: Sequence[Trace], new: Sequence[Trace], name: str, line: int) -> None:
    if old[0].before != new[0].before or old[-1].after != new[-1].after:
        pairs = zip((*old[0].before, *old[-1].after), (*new[0].before, *new[-1].after))
        was, now = next((a, b) for a, b in pairs if a != b)
        raise _differs(name, line, f"the modal state differs ({was} has become {now})")
    a, b = old[-1].transformation, new[-1].transformation
    if max(abs(x - y) for x, y in zip(a.shift, b.shift)) > 1e-6 or a.matrix != b.matrix:
        what = "the work coordinates depend on the position of the tool (G92, G10 L20, G68 without a centre)"
        raise _differs(
            name, line, what, "; set them where nothing is corrected yet, or use fixed work offsets"
        )
    passes = list(zip(old, new)) if len(old) == len(new) else [(old[-1], new[-1])]
    ends = [
        (first.contour.rotary_end, second.contour.rotary_end)
        for first, second in passes
        if not first.contour.is_tip_led
    ]
    if any(abs(p - q) > math.pi for first, second in ends for p, q in zip(first, second)):
        raise _differs(name, line, "a rotary axis goes another way round")
    kinds = {t.contour.kind for t in old}
    if {t.contour.kind for t in new} - kinds:
        raise _differs(name, line, "the kind of a move has changed")
    for t in new:
        there = next(o for o in old if o.contour.kind == t.contour.kind)
        f, g = there.contour.feed, t.contour.feed
        several = len({o.contour.feed for o in old}) > 1 or there.after.spindle_mode == "G96"
        if (not several and (f is None) != (g is None)) or (
            f and g and not several and abs(f - g) > 1e-3 * f
        ):
            raise _differs(name, line, f"the feed has become {g} instead of {f} mm/min")


def _differs(name: str, line: int, what: str, advice: str = "") -> ModelLimit:
    message = f"reading the new program again shows that {what}; nothing was written{advice}"
    return at_line(ModelLimit, name, line, message)


def compare_comments(old: str, new: str, mark: Sequence[str], semicolon: bool = False) -> None:
    """Check that the comments are those of the source, in their order, after the mark."""
    pattern = _SEMICOLON if semicolon else _COMMENT
    comments = pattern.findall(new)
    for comment in mark:
        comments.remove(comment)
    if comments != pattern.findall(old):
        raise ModelLimit("reading the new program again shows other comments; nothing was written")


def block_rate(moves: Sequence[Move]) -> tuple[float, int]:
    """Return the largest number of blocks per second at the programmed feed, and the line.

    Moves that radius compensation adds at a corner belong to the same block: on a contour that is tangential but for the last
    digit such
    a move is an arc of a micrometre.
    """
    best, line = 0.0, 0
    for _, group in groupby(
        enumerate(moves),
        key=lambda numbered: numbered[1].source.line if numbered[1].compensation else -numbered[0] - 1,
    ):
        feeds = [m for _, m in group if m.feed and m.kind in CUTS]
        length = sum(length_of(m) for m in feeds)
        if length > SHORTEST and feeds[0].feed:
            rate = feeds[0].feed / 60.0 / length
            if rate > best:
                best, line = rate, feeds[0].source.line
    return best, line
