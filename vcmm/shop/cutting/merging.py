"""Reduce the rows of a sweep: consecutive lines become one where no tool is then displaced by more than is allowed.

A path that five axes lead is written in thousands of short lines, each with the direction of its tool. For rays some tenths of a millimetre apart one
line replaces many: that from the first to the last place of the point of the tool that is led (the centre of a ball), with the direction
of the row in their
middle. Two errors count: the distance of the places between from that line, and the turn of the tool over its cutting edges.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vcmm.core.run import Array
from vcmm.shop.cutting.contactmap import Ints
from vcmm.shop.cutting.sweeps import LINE, Sweep

GAP = 1e-3  # mm between the end of a line and the start of the next, which is none
Bools = np.typing.NDArray[np.bool_]


def merge_lines(sweep: Sweep, free: Bools, within: float) -> Sweep:
    """Return the sweep with lines of the rows `free` (rows,) joined where neither error is larger than half of `within` mm."""
    height = np.array([t.corner for t in sweep.tools])[sweep.tool][:, None]
    lever = np.array([np.hypot(t.radius, min(2 * t.radius, t.length)) for t in sweep.tools])[sweep.tool]
    begins, ends = sweep.start + height * sweep.axis, sweep.end + height * sweep.axis
    joins = (
        (free & (sweep.kind == LINE))[:-1]
        & (free & (sweep.kind == LINE))[1:]
        & (sweep.tool[:-1] == sweep.tool[1:])
    )
    joins &= np.linalg.norm(begins[1:] - ends[:-1], axis=1) <= GAP
    first, last = np.arange(len(sweep)), np.arange(len(sweep))  # of every group of rows
    while len(first) > 1:
        pair = _pairs(joins[last[:-1]])
        if not len(pair):
            break
        good = pair[
            _fit(first[pair], last[pair + 1], begins, ends, axis=sweep.axis, lever=lever, most=0.5 * within)
        ]
        if not len(good):
            break
        last[good] = last[good + 1]
        kept = np.ones(len(first), dtype=bool)
        kept[good + 1] = False
        first, last = first[kept], last[kept]
    return _join_rows(sweep, first, last, begins, ends, height)


def _pairs(joins: Bools) -> Ints:
    """Return the groups (k,) to be tried with the next one, none of them twice: every other one of each connected run."""
    starts = np.concatenate([[True], ~joins[:-1]]) if len(joins) else np.zeros(0, dtype=bool)
    run = (
        np.maximum.accumulate(np.where(starts, np.arange(len(joins)), 0))
        if len(joins)
        else np.zeros(0, dtype=int)
    )
    return np.flatnonzero(joins & ((np.arange(len(joins)) - run) % 2 == 0))


def _fit(
    first: Ints, last: Ints, begins: Array, ends: Array, axis: Array, lever: Array, most: float
) -> Bools:
    """Return which groups of rows first to last (k,) may be one line each."""
    count = last - first + 1
    group = np.repeat(np.arange(len(first)), count)
    row = np.arange(len(group)) - np.repeat(np.cumsum(count) - count, count) + first[group]
    start, way = begins[first], ends[last] - begins[first]
    length = np.einsum("ki,ki->k", way, way)
    arm = ends[row] - start[group]
    share = np.clip(np.einsum("ki,ki->k", arm, way[group]) / np.maximum(length[group], 1e-18), 0.0, 1.0)
    off = np.linalg.norm(arm - share[:, None] * way[group], axis=1)
    turned = lever[row] * np.linalg.norm(axis[row] - axis[(first + last) // 2][group], axis=1)
    at = np.cumsum(count) - count
    return np.asarray((np.maximum.reduceat(off, at) <= most) & (np.maximum.reduceat(turned, at) <= most))


def _join_rows(sweep: Sweep, first: Ints, last: Ints, begins: Array, ends: Array, height: Array) -> Sweep:
    out = sweep.take((first + last) // 2)
    many = last > first
    lead = height[first] * out.axis
    start = np.where(many[:, None], begins[first] - lead, out.start)
    end = np.where(many[:, None], ends[last] - lead, out.end)
    return replace(out, start=start, end=end, move=sweep.move[first])
