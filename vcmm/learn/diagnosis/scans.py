"""Trial values of the parameters that act non-linearly, and the shapes of an effect that has several.

An effect declares coarse trial values by `scan`. A time constant is filled in between, a period gets a spectral grid
fine enough for the travel of the recording, a change point is placed between the rows. Values carry a log weight: the
average over them is the look-elsewhere penalty.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import Field, fields
from typing import Any

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.effect import Effect, parameter_fields
from vcmm.core.run import Array, Run
from vcmm.learn.diagnosis.periods import (
    DIGITS,
    FEWEST,
    TURNS,
    aliases,
    can_show_harmonic,
    can_show_period,
    coordinate,
    shortest_period,
    whole_fractions,
)

EACH_SIDE = 10  # rows that a change point needs on either side
MOST_LINES = 300  # spectral lines per axis
MOST_STEPS = 80  # change points
ASIDE = 0.5  # of the largest share across: a touch nearer to the pole holds less than a quarter of the information about an angle
WeightedChanges = list[tuple[dict[str, Any], float]]


def trials(effect: Effect, run: Run) -> WeightedChanges:
    """Return keyword changes of an effect and their log weights (summing to 1): all scans times all shapes."""
    if not effect.diagnosis.shows_in(effect, run):
        return []
    lists = [
        _values(effect, spec, run)
        for spec in parameter_fields(effect)
        if spec.metadata["scan"] or is_change(spec)
    ]
    lists += [_shapes(effect, f, run) for f in fields(effect)]
    lists += [_weigh(f.name, _zeros(f)) for f in fields(effect)]
    out: WeightedChanges = []
    for combination in itertools.product(*lists):
        changes: dict[str, Any] = {}
        for part, _ in combination:
            changes.update(part)
        wave = changes.get("harmonic", 1) > 1 and "period" in changes
        if wave and not _shows(
            effect, run, changes["period"] / changes["harmonic"], min(c["period"] for c, _ in lists[0])
        ):
            continue
        out.append((changes, float(sum(weight for _, weight in combination))))
    return out


def _shows(effect: Effect, run: Run, period: float, finest: float) -> bool:
    """Return whether the rows show a harmonic of a trial period, the shortest of which is `finest`."""
    q = coordinate(effect, run)
    if q is not None and turns_round(effect):
        return any(abs(p / period - 1.0) < 1e-6 for p in whole_fractions([period], q))
    return can_show_period(q, period, shortest_period(q, finest / 2))


def _shapes(effect: Effect, spec: Field[Any], run: Run) -> WeightedChanges:
    """Return discrete trial values; of waves over an angle only those that its values can show, which may be none."""
    effect_trials = effect.diagnosis.trials(effect, spec.name)
    if effect_trials is not None:
        return effect_trials
    tries = spec.metadata.get("tries", ())
    kept = [k for k in tries if not _is_unresolved(spec, k, run)]
    return _weigh(spec.name, kept) if kept or not tries else []


def _is_unresolved(spec: Field[Any], waves: int, run: Run) -> bool:
    angle = run.columns.get(spec.metadata.get("waves_over", ""))
    if angle is None:
        return False
    size = np.abs(run.columns.get(spec.metadata["waves_by"], np.ones(run.n)))
    return not can_show_harmonic(int(waves), angle[size >= ASIDE * size.max(initial=0.0)])


def unresolved_changes(kind: type[Effect], run: Run) -> list[dict[str, Any]]:
    """Return keyword changes of the shapes of an effect that `_shapes` leaves out: lobes that the directions do not resolve."""
    return [
        {f.name: k} for f in fields(kind) for k in f.metadata.get("tries", ()) if _is_unresolved(f, k, run)
    ]


def is_change(spec: Field[Any]) -> bool:
    """Return whether a parameter is a point in time after which something is different."""
    return spec.name in ("t1", "time", "start")


def _values(effect: Effect, spec: Field[Any], run: Run) -> WeightedChanges:
    if is_change(spec):
        return _even(spec.name, change_points(run))
    coarse = [float(v) for v in spec.metadata["scan"]]
    if spec.name == "period":
        q = coordinate(effect, run)
        lines = spectral_lines(_coordinate(effect, run))
        if turns_round(effect) and q is not None:
            return _even(spec.name, whole_fractions(lines or coarse, q))
        least = shortest_period(q, min([*coarse, *lines])) if q is not None else float("inf")
        coarse = [v for v in coarse if can_show_period(q, v, least)]
        fine = [v for v in lines if can_show_period(q, v, least) and _may_be(v, effect, spec, q)]
        if not coarse:
            return _even(spec.name, fine)
        share = np.log(0.5) if fine else 0.0
        listed = [(c, w + share) for c, w in _even(spec.name, coarse)]
        return listed + [(c, w + np.log(0.5)) for c, w in _even(spec.name, fine)] if fine else listed
    if spec.name == "tau" and spec.default == 0.0:
        coarse = [0.0, *coarse]  # follows at once
    alone = sum(bool(f.metadata["scan"]) for f in parameter_fields(effect)) == 1
    return _even(spec.name, fill_gaps(coarse) if alone else coarse)


def turns_round(effect: Effect) -> bool:
    """Return whether it is an error of an axis that turns. Its periods are whole fractions of a turn, and none between them."""
    return is_rotary(str(getattr(effect, "axis", "")))


def _may_be(period: float, effect: Effect, spec: Field[Any], q: Array | None) -> bool:
    """Return whether the physics has such a period, or one of its usual ones looks so at these places (n,).

    On a lattice of step h a lead p is seen at |n/h - 1/p|: within half a line of the spectrum it is the lead that counts.
    """
    if q is None or period <= spec.metadata["most"]:
        return True
    half = 0.25 / float(np.ptp(q))
    frequencies = [1.0 / p for lead in spec.metadata["scan"] for p in aliases(q, lead)]
    return any(abs(f - 1.0 / period) <= half for f in frequencies)


def _even(name: str, values: Sequence[float]) -> WeightedChanges:
    return [({name: float(v)}, -float(np.log(len(values)))) for v in values]


def _weigh(name: str, values: Sequence[Any]) -> WeightedChanges:
    """Return the weights: the first value carries half of the weight; no values, no change."""
    if not len(values):
        return [({}, 0.0)]
    if len(values) == 1:
        return [({name: values[0]}, 0.0)]
    rest = [({name: v}, float(np.log(0.5 / (len(values) - 1)))) for v in values[1:]]
    return [({name: values[0]}, float(np.log(0.5))), *rest]


def _zeros(spec: Field[Any]) -> list[Array]:
    """Return the lengths that an array parameter is tried with."""
    return [np.zeros(k) for k in spec.metadata.get("lengths", ())]


def fill_gaps(values: Sequence[float]) -> list[float]:
    """Return positive values with one geometric mean between neighbours that lie more than a factor 2 apart; zeros stay."""
    out = sorted(v for v in values if v <= 0)
    positive = sorted(v for v in values if v > 0)
    for low, high in itertools.pairwise(positive):
        out.append(low)
        if high / low > 2.0:
            out.append(float(np.sqrt(low * high)))
    return out + positive[-1:]


def change_points(run: Run) -> list[float]:
    """Return times (s) between rows with EACH_SIDE rows on either side, at most MOST_STEPS of them."""
    if "time_s" not in run.columns:
        return []
    time = np.sort(run.column("time_s"))
    middle = (time[1:] + time[:-1]) / 2
    inner = middle[EACH_SIDE - 1 : len(middle) - EACH_SIDE + 1]
    inner = np.unique(inner[np.diff(time)[EACH_SIDE - 1 : len(middle) - EACH_SIDE + 1] > 0])
    if len(inner) > MOST_STEPS:
        inner = inner[np.linspace(0, len(inner) - 1, MOST_STEPS).astype(int)]
    return [float(t) for t in inner]


def _coordinate(effect: Effect, run: Run) -> Array | None:
    """Return the axis position over which a cyclic error is periodic; None where only listed periods make sense (raw scales)."""
    axis = getattr(effect, "axis", "")
    too_fine = effect.diagnosis.follows_raw_scale  # for a spectrum of places
    return None if too_fine or axis not in run.position else run.position[axis]


def spectral_lines(q: Array | None) -> list[float]:
    """Return periods (units of q) at half the resolution of the travel: frequencies 1.5/L, 2/L ... up to the sampling limit."""
    if q is None:
        return []
    places = np.unique(np.round(q, DIGITS))
    length = float(np.ptp(q))
    if len(places) < FEWEST or length <= 0:
        return []
    highest = min(len(places) / 2, MOST_LINES / 2 + TURNS)
    return [float(length / f) for f in np.arange(TURNS, highest, 0.5)]
