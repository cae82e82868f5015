"""Courses of time without a name: a smooth vector of time, the scale of an axis that changes with time, the size of the part.

    d(t) e            the tip moves along e; all three directions together are one question (see kernels)
    s(t) (q - q0) e   the scale of an axis: held at its zero, or anywhere (then d(t) e is a part of it)
    g(t) p            the part grows about its middle, p the place on it

d, s and g are sums of bumps over the clock, as wide as SMOOTH of the recording's duration: what heats up and cools down by a
source that nothing logs. A name that follows a thermometer, or several together, may mimic such a course; with these the
unknown competes in the same freedom.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.effect import Effect, motion
from vcmm.core.run import Array, Run
from vcmm.learn.diagnosis.closeness import moved_by
from vcmm.learn.diagnosis.problem import Problem

SMOOTH = (0.06, 0.15, 0.4)  # of the duration: half an hour, an hour, half of a shift
WITH_A_PART = ("probe", "path")  # kinds that know where on the part a row is


@dataclass(frozen=True, eq=False)
class Course:
    """What a smooth course of time does to the observations, columns (m, k). names: covariates; what: in words."""

    names: tuple[str, ...]
    columns: Array
    what: str


def clock(problem: Problem) -> Array | None:
    """time_s (n,) where the recording has a clock that moves."""
    time = problem.run.columns.get("time_s")
    return time if time is not None and np.ptp(time) > 0 else None


def over_clock(time: Array, width: float) -> Array:
    """Bumps (n, k) over the clock, `width` of its range wide and half as far apart: their sum is as smooth everywhere."""
    z = (time - time.min()) / np.ptp(time)
    centres = np.linspace(0.0, 1.0, round(2.0 / width) + 1)
    return np.asarray(np.exp(-0.5 * ((z[:, None] - centres) / width) ** 2))


def wandering(problem: Problem) -> Iterator[Array]:
    """Bumps (m, k) over the clock, for any direction."""
    time = clock(problem)
    if time is not None:
        yield from (problem.of_rows(over_clock(time, width)) for width in SMOOTH)


def stretching(problem: Problem) -> Iterator[Course]:
    """Scales of axes and the size of the part that change with time."""
    time = clock(problem)
    if time is None:
        return
    grown = _growth_column(problem)
    for width in SMOOTH:
        bumps = over_clock(time, width)
        for axis, q in problem.run.position.items():
            if not is_rotary(axis) and np.ptp(q) > 0:
                yield from _of_scale(problem, axis, bumps)
        if grown is not None:
            what = "a size of the part that changes with time"
            yield Course(("time",), problem.of_rows(bumps) * grown[:, None], what)


def _of_scale(problem: Problem, axis: str, bumps: Array) -> Iterator[Course]:
    """The scale of an axis held at its zero, and held anywhere; the largest factor is 1."""
    q = problem.run.position[axis]
    middle = q - q.mean()
    zero, spread = (v[:, None] / np.abs(v).max() for v in (q, middle))
    for shapes in (bumps * zero, np.concatenate([bumps, bumps * spread], axis=1)):
        moved = moved_by(problem, f"E{axis}{axis}", shapes)
        yield Course(("time", axis), moved, f"a scale of {axis} that changes with time")


def _growth_column(problem: Problem) -> Array | None:
    """What a larger part does to the observations (m,), 1 at its largest; None for machines that measure no part."""
    run = problem.run
    if problem.recording.kind not in WITH_A_PART or "part_x_mm" not in run.columns:
        return None
    x, y, z = run.part_point.T
    grown = problem.observer.through(_PartGrowth(), motion(run, X=x, Y=y, Z=z))
    largest = float(np.abs(grown).max())
    return grown / largest if largest > 0 else None


@dataclass(frozen=True, eq=False)
class _PartGrowth(Effect):
    """The part, which is indicated larger."""

    @property
    def link(self) -> str:
        return "reading"

    def error_motion(self, run: Run) -> Array:
        return motion(run)
