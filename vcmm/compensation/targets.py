"""Compute the commands of every move with which the machine with its errors runs the programmed path."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.compensation.contours import directions, left_normal, length_of, points, sweep_of
from vcmm.compensation.field import PathErrors
from vcmm.compensation.fitting import BlockFit, BlockPiece, arcs, chords
from vcmm.core.run import Array
from vcmm.program.moves import Move
from vcmm.program.trace import Trace
from vcmm.shop.cutting.contactmap import Ints

# mm between the points at which a correction is computed; and at most per move
SPACING = 2.0
MOST_SAMPLES = 400
CUTTING = ("line", "arc")
# times the stretch by which radius compensation shortens or lengthens the centre path at a corner
CORNER = 1.1
NEVER_SPLIT = (
    "M98",
    "M99",
    "M89",
    "M?",
)  # they act after the motion of their block; M?: who knows, it is computed
HALF_TURN = 0.3  # |cos| of half the sweep, below which R fixes the centre badly: a digit of R moves it by 3 digits or more


@dataclass(frozen=True, eq=False)
class MoveSamples:
    """Points along the moves of traces: trace (k,), share (k,), nominal (k, 3), beside (k, 3); first (n + 1,) row of each trace."""

    first: Ints
    trace: Ints
    share: Array
    nominal: Array
    beside: Array

    def rows(self, i: int) -> slice:
        return slice(int(self.first[i]), int(self.first[i + 1]))


def moves_of(traces: Sequence[Trace], moves: Sequence[Move]) -> Ints:
    """Return the index (n,) of the move of the executed path that belongs to each trace; corners of radius compensation add moves."""
    if len(traces) == len(moves):
        return np.arange(len(traces))
    out, at = [], 0
    for trace in traces:
        line = trace.contour.source.line
        place = at
        while place < len(moves) and (
            moves[place].source.line != line or moves[place].kind != trace.contour.kind
        ):
            place += 1
        number = place if place < len(moves) else min(at, len(moves) - 1)
        out.append(number)
        at = number + 1 if place < len(moves) else at
    return np.array(out, dtype=np.intp)


def shares_of(trace: Trace, guard: tuple[float, float] = (0.0, 0.0)) -> Array:
    """Return the shares at which a move is sampled: only at its end where nothing is cut. guard: mm at its ends that stay whole, with its own."""
    m = trace.contour
    length = length_of(m)
    if m.kind not in CUTTING or trace.cycle or not m.rewritable:
        return np.array([1.0])
    if m.kind == "arc":
        count = 8 if length < 1.0 else 48 if length < 20.0 or abs(sweep_of(m)) < 0.2 else 96
        return np.linspace(0.0, 1.0, count + 1)
    count = min(max(math.ceil(length / SPACING), 2 if length > 0.5 else 1), MOST_SAMPLES)
    share = np.linspace(0.0, 1.0, count + 1)
    low, high = np.maximum(trace.guard, guard)  # a rounding at an end needs the end of the line whole
    if not low and not high:
        return share
    at = share * length
    kept = (at > low) & (at < length - high)
    kept[[0, -1]] = True
    return share[kept]


def samples_of(traces: Sequence[Trace]) -> MoveSamples:
    """Return all points of all traces."""
    share = [shares_of(t, corner_stretches(traces, i)) for i, t in enumerate(traces)]
    first = np.concatenate([[0], np.cumsum([len(s) for s in share])]).astype(np.intp)
    nominal = [points(t.contour, s) for t, s in zip(traces, share)]
    beside = [_beside(traces, i, s) for i, s in enumerate(share)]
    index = np.repeat(np.arange(len(traces)), np.diff(first))
    return MoveSamples(first, index, np.concatenate(share), np.concatenate(nominal), np.concatenate(beside))


def _beside(traces: Sequence[Trace], i: int, share: Array) -> Array:
    """Return the vectors from the programmed contour to the tool centre (k, 3): radius compensation, with its corners and its way in and out."""
    side, before = _side(traces, i), _side(traces, i - 1)
    if not side and not before:
        return np.zeros((len(share), 3))
    m = traces[i].contour
    if not before or not side:
        whole = _corner(traces, i) if side else _corner(traces, i - 1)
        return np.asarray((share if side else 1.0 - share)[:, None] * whole)
    out = side * left_normal(directions(m, share), m.plane)
    if share[-1] == 1.0:
        out[-1] = _corner(traces, i)
    return np.asarray(out)


def corner_stretches(traces: Sequence[Trace], i: int) -> tuple[float, float]:
    """Return the mm at both ends of move i along which the tool centre goes less or farther than the contour: no piece ends there.

    At an inside corner a shorter piece cannot be reached by the tool; at an outside one it would lead the centre on in the
    direction of a few rounded digits.
    """
    if not _side(traces, i) or traces[i].contour.kind != "line":
        return 0.0, 0.0
    way = directions(traces[i].contour, np.zeros(1))[0]
    starts = _corner(traces, i - 1) if _side(traces, i - 1) else np.zeros(3)
    ends = _corner(traces, i) if _side(traces, i + 1) else np.zeros(3)
    return CORNER * abs(float(starts @ way)), CORNER * abs(float(ends @ way))


def _side(traces: Sequence[Trace], i: int) -> float:
    """Return the signed radius of compensation, positive to the left of travel; 0 where there is none."""
    cutter = traces[i].compensation if 0 <= i < len(traces) else None
    if cutter is None:
        return 0.0
    return cutter.radius if cutter.side == "left" else -cutter.radius


def _corner(traces: Sequence[Trace], i: int) -> Array:
    """Return the tool centre at the end of move i: inside corners where both parallels meet, outside half way round."""
    h, m = _side(traces, i), traces[i].contour
    normal = left_normal(directions(m, np.ones(1)), m.plane)[0]
    if not _side(traces, i + 1):
        return np.asarray(h * normal)
    following = traces[i + 1].contour
    two = left_normal(directions(following, np.zeros(1)), m.plane)[0]
    if _side(traces, i - 1) == 0.0:  # the way in ends square to the first cut
        return np.asarray(h * (two if np.any(two) else normal))
    middle = normal + two
    size = float(np.linalg.norm(middle))
    if size < 0.2:
        return np.asarray(h * normal)
    turn = float(np.cross(normal, two).sum())
    inside = turn * h > 0
    factor = 2.0 / size if inside else 1.0
    return np.asarray(h * factor * middle / size)


def may_split(
    trace: Trace, codes: frozenset[str], following: Trace | None = None, previous: Trace | None = None
) -> bool:
    """Return whether blocks may be added: not where compensation starts or ends, nor where a code acts after the motion.

    It starts with the first move under it, also where G41 is in a block of its own before that.
    """
    before, after = trace.before, trace.after
    starts = previous is not None and (previous.compensation is None) != (trace.compensation is None)
    cycle_follows = False if following is None else bool(following.cycle) and following.line == trace.line
    one_stop = trace.contour.exact_stop and not after.exact_stop
    return (
        trace.contour.kind in CUTTING
        and before.side == after.side
        and not starts
        and not (trace.contour.is_tip_led and trace.contour.rotary_start != trace.contour.rotary_end)
        and not one_stop
        and not cycle_follows
        and (trace.contour.kind != "arc" or trace.guard == (0.0, 0.0))
        and codes.isdisjoint(NEVER_SPLIT)
    )


def _least(trace: Trace, wanted: Array, nominal: Array) -> int:
    """Return two arcs at least for a half circle by R that must change: there its centre depends on the last digit of R."""
    bad = "R" in trace.words and abs(math.cos(sweep_of(trace.contour) / 2)) < HALF_TURN
    return 2 if bad and float(np.abs(wanted - nominal).max()) > 1e-6 else 1


def targets(
    traces: Sequence[Trace], field: PathErrors, index: Ints, limit: float, codes: Sequence[frozenset[str]],
    beside: bool = True, most: int = 48,
) -> tuple[BlockFit | None, ...]:  # fmt: skip
    """Compute corrected end points, centres and split points of all traces; None where a trace is not rewritten.

    codes: M codes of each trace's block. beside: blocks under radius compensation may be split too.
    """
    if not traces:
        return ()
    samples = samples_of(traces)
    wanted = field.correct(index[samples.trace], samples.share, samples.nominal, samples.beside)
    fits: list[BlockFit | None] = []
    for i, trace in enumerate(traces):
        rows = samples.rows(i)
        m = trace.contour
        following = traces[i + 1] if i + 1 < len(traces) else None
        free = may_split(trace, codes[i], following, traces[i - 1] if i else None) and (
            beside or trace.compensation is None
        )
        if not m.rewritable or m.kind == "dwell":
            fits.append(None)
        elif m.kind == "arc":
            fits.append(
                arcs(
                    m,
                    wanted[rows],
                    limit,
                    most if free else 1,
                    _least(trace, wanted[rows], samples.nominal[rows]),
                )
            )
        elif rows.stop - rows.start <= 2:
            fits.append(BlockFit((BlockPiece(1.0, wanted[rows.stop - 1]),), 0.0))
        else:
            way = directions(m, np.zeros(1))[0]
            across = np.broadcast_to(np.eye(3) - np.outer(way, way), (rows.stop - rows.start, 3, 3))
            fits.append(chords(m, samples.share[rows], wanted[rows], across, limit, free))
    return tuple(fits)
