"""Neighbourhoods of observations over covariates: bumps about some of the rows, as columns.

A bump about row j is exp(-d^2 / 2 l^2) of the distance d of the others from it, over one covariate, over two, or over a
place in space: axis positions, tip position, place on the part. Lengths are shares of the range (of the
ranks for temperatures and times, which crowd). Products with a component of the sensitive direction say what is displaced.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.core.axes import axis_of
from vcmm.core.effect import COLUMN, Effect, motion
from vcmm.core.run import Array, Run
from vcmm.learn.diagnosis.constants import UNSEEN
from vcmm.learn.diagnosis.locate import SKIP, path_speed, without_unit
from vcmm.learn.diagnosis.problem import Problem, generator

ON_A_LINE, PAIRED, IN_SPACE = 50, 100, 200  # rows about which bumps stand
FINE, MIDDLE, COARSE, WIDE = 0.02, 0.06, 0.15, 0.2  # lengths over one covariate
NEAR_LENGTHS, FAR_LENGTHS = 0.1, 0.25  # lengths in space
STEPS = 60
CONDITIONS = ("time", "speed")  # beside temperatures: what a place is paired with


@dataclass(frozen=True, eq=False)
class ScaledCovariate:
    """A covariate, scaled: values (m,) from 0 to 1, or in turns where it comes back after one."""

    name: str
    values: Array
    cyclic: bool = False


@dataclass(frozen=True, eq=False)
class Neighbourhood:
    """Bumps (m, k) over the covariates `names`."""

    names: tuple[str, ...]
    bumps: Array


def neighbourhoods(problem: Problem) -> Iterator[Neighbourhood]:
    """Yield every kind of neighbourhood that the columns of the recording allow."""
    axes, conditions = _axes(problem), _conditions(problem)
    yield from _on_lines(axes, (FINE, MIDDLE, WIDE))
    yield from _on_lines(conditions, (FINE, COARSE))
    yield from _in_space(axes)
    for what in ("tip", "part"):
        place = _positions(problem, what)
        new = [a for a in place if not any(float(np.abs(a.values - o.values).max()) < UNSEEN for o in axes)]
        yield from _on_lines(new, (FINE, MIDDLE, WIDE))
        yield from _in_space(place) if new else ()
    paired = [c for c in conditions if c.name in CONDITIONS or c.name.startswith("temp_")]
    for pair in itertools.product(axes, paired):
        yield from _bumps(pair, (COARSE,), PAIRED)


def _in_space(place: Sequence[ScaledCovariate]) -> Iterator[Neighbourhood]:
    for pair in itertools.combinations(place, 2):
        yield from _bumps(pair, (MIDDLE, COARSE), IN_SPACE)
    if len(place) > 2:
        yield from _bumps(place, (NEAR_LENGTHS, FAR_LENGTHS), IN_SPACE)


def _on_lines(axes: Sequence[ScaledCovariate], lengths: tuple[float, ...]) -> Iterator[Neighbourhood]:
    for axis in axes:
        yield from _bumps((axis,), lengths, ON_A_LINE)


def _bumps(
    axes: Sequence[ScaledCovariate], lengths: tuple[float, ...], places: int
) -> Iterator[Neighbourhood]:
    m = len(axes[0].values)
    at = np.sort(generator(0, "places").permutation(m)[:places])
    apart = np.zeros((m, len(at)))
    for axis in axes:
        gap = axis.values[:, None] - axis.values[None, at]
        apart += (np.sin(np.pi * gap) / np.pi if axis.cyclic else gap) ** 2
    for length in lengths:
        yield Neighbourhood(tuple(a.name for a in axes), np.exp(-0.5 * apart / length**2))


def _axes(problem: Problem) -> tuple[ScaledCovariate, ...]:
    positions = {a: problem.per_observation(q) for a, q in problem.run.position.items()}
    return tuple(ScaledCovariate(a, _scale_to_unit(q)) for a, q in positions.items() if np.ptp(q) > 0)


def _positions(problem: Problem, what: str) -> tuple[ScaledCovariate, ...]:
    """Return the place of the tip ("tip") or of the touch on the part ("part")."""
    columns = {f"{what}_{c}": problem.run.columns.get(f"{what}_{c}_mm") for c in "xyz"}
    values = {name: problem.per_observation(v) for name, v in columns.items() if v is not None}
    return tuple(ScaledCovariate(name, _scale_to_unit(v)) for name, v in values.items() if np.ptp(v) > 0)


def _conditions(problem: Problem) -> tuple[ScaledCovariate, ...]:
    out = []
    for name, values in problem.run.columns.items():
        if name.startswith((*SKIP, "counted_")) or not np.ptp(values) > 0:  # counted: a position once more
            continue
        v = problem.per_observation(values)
        turns = name.endswith("_rad") and "since" not in name
        out.append(ScaledCovariate(without_unit(name), v / (2 * np.pi) if turns else _ranks(v), turns))
    speed = path_speed(problem.run)
    if speed is not None and np.ptp(speed) > 0:
        out.append(ScaledCovariate("speed", _ranks(problem.per_observation(speed))))
    return tuple(out)


def _scale_to_unit(v: Array) -> Array:
    return np.asarray((v - v.min()) / np.ptp(v))


def _ranks(v: Array) -> Array:
    """Return the rank of every value among the different ones, 0 to 1."""
    kinds, number = np.unique(v, return_inverse=True)
    return np.asarray(number / max(len(kinds) - 1, 1))


def component_shapes(problem: Problem, component: str) -> Iterator[Array]:
    """Yield the effect of free shapes of one component over its axis on the observations (m, k): bumps of three lengths, and steps."""
    q = problem.run.position[axis_of(component)]
    z = _scale_to_unit(q)
    for length in (FINE, 0.05, 0.12):
        centres = np.linspace(0.0, 1.0, round(1 / length) + 1)
        yield observe_component(problem, component, np.exp(-0.5 * ((z[:, None] - centres) / length) ** 2))
    edges = (np.arange(STEPS) + 0.5) / STEPS
    yield observe_component(problem, component, (z[:, None] > edges).astype(float))


def observe_component(problem: Problem, component: str, shapes: Array) -> Array:
    """Return the observations (m, k) by shapes (n, k) of a component, mm or rad."""
    six = np.zeros((problem.run.n, 6, shapes.shape[1]))
    six[:, COLUMN[component[1]]] = shapes
    return problem.observer.through(_Link(axis_of(component)), six)


@dataclass(frozen=True, eq=False)
class _Link(Effect):
    """The axis that a free shape moves."""

    axis: str

    @property
    def link(self) -> str:
        return self.axis

    def error_motion(self, run: Run) -> Array:
        return motion(run)
