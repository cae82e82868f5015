"""Localise without a model: find the covariate and the direction on which the residual depends.

Shapes: four Legendre polynomials of a covariate, products for two positions, harmonics of an angle, spectral lines
of a position, a step in time, levels of a label, products of a position and the speed on the way; each times one component of the sensitive direction, or as it is.
Every shape is scored like an effect, and its p value is the share of null recordings whose best shape scores higher.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vcmm.core.run import Array, Run
from vcmm.learn.diagnosis.candidates import Family, Option
from vcmm.learn.diagnosis.constants import LEAST_FRACTION, SECURE, UNSEEN
from vcmm.learn.diagnosis.evidence import Scorer
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.scans import change_points, spectral_lines

DEGREES = 4
LINES = 80
HARMONICS = (1, 2, 3, 4)
ZONE_WIDTHS = (0.12, 0.25)  # of the range
ZONE_ROWS = 8.0  # that a zone must hold
LEVELS = 20
SKIP = ("raw_", "travel_", "tip_", "part_", "nx", "ny", "nz", "u_", "reading_")
MOST_SHOWN = 6


@dataclass(frozen=True)
class Place:
    """A place where the residual departs: covariate, direction ("x", "y", "z" or "normal"), p value, words, score in nats."""

    covariate: str
    direction: str
    p: float
    text: str
    score: float


def generic_families(problem: Problem) -> tuple[Family, ...]:
    """Return shapes over every covariate and direction, columns in units of the noise."""
    return tuple(each_shape(problem))


def each_shape(problem: Problem) -> Iterator[Family]:
    """Yield the same one after another: together they are many columns."""
    size = float(np.median(problem.u))
    over, factors = covariates(problem), direction_factors(problem)
    prior = -float(np.log(max(len(over) * len(factors), 1)))
    for name, groups in over.items():
        for direction, factor in factors.items():
            options = [_option(c * factor[:, None] * size, len(groups)) for c in groups]
            yield Family(name, {"direction": direction}, tuple(options), prior)


def _option(columns: Array, among: int) -> Option:
    k = columns.shape[1]
    return Option(None, columns, np.ones(k), tuple(map(str, range(k))), -float(np.log(among)))


def direction_factors(problem: Problem) -> dict[str, Array]:
    """Return direction -> factor (m,): the observation as it is, and the components of its direction that vary."""
    out = {"normal": np.ones(problem.m)}
    d = problem.recording.direction
    for i, name in enumerate("xyz"):
        if np.ptp(d[:, i]) > UNSEEN:
            out[name] = d[:, i]
    if len(out) == 1:  # one fixed direction: call it by its axis
        main = int(np.argmax(np.abs(d[0])))
        return {"xyz"[main] if abs(d[0, main]) > 0.9 else "normal": out["normal"]}
    return out


def covariates(problem: Problem) -> dict[str, list[Array]]:
    """Return covariate name -> groups of columns (m, k), each group one option."""
    run, out = problem.run, {}
    axes = [a for a in run.position if np.ptp(run.position[a]) > 0]
    for axis in axes:
        out[axis] = [polynomials(problem.per_observation(run.position[axis]))]
        lines = spectral_lines(run.position[axis])[:LINES]
        if lines:
            out[f"{axis} (periodic)"] = [_wave(problem.per_observation(run.position[axis]), p) for p in lines]
    for a, b in itertools.combinations(axes, 2):
        out[f"{a} and {b}"] = [
            surface(problem.per_observation(run.position[a]), problem.per_observation(run.position[b]))
        ]
        zones = zone_bumps(problem.per_observation(run.position[a]), problem.per_observation(run.position[b]))
        if zones:
            out[f"{a} and {b} (zone)"] = zones
    for a, (name, values) in itertools.product(axes, _shared_conditions(problem)):
        out[f"{a} and {name}"] = [surface(problem.per_observation(run.position[a]), values)]
    for a, angle in itertools.product(axes, [c for c in run.columns if c.endswith("angle_rad")]):
        out[f"{a} and {without_unit(angle)}"] = [
            _waves_by(problem.per_observation(run.columns[angle]), problem.per_observation(run.position[a]))
        ]
    for name, values in run.columns.items():
        if np.ptp(values) > 0 and not name.startswith(SKIP):
            out[without_unit(name)] = _of_column(name, problem.per_observation(values))
    steps = change_points(run)
    if steps:
        time = problem.per_observation(run.column("time_s"))
        out["time (periodic)"] = [_wave(time, p) for p in spectral_lines(run.column("time_s"))[:LINES]]
        out["time (step)"] = [(time > t).astype(float)[:, None] for t in steps]
    for name, labels in run.labels.items():
        kinds, codes = np.unique(labels[problem.recording.row], return_inverse=True)
        if 1 < len(kinds) <= LEVELS and name not in ("feature",):
            out[name] = [(codes[:, None] == np.arange(len(kinds))).astype(float)]
    return {name: [g for g in groups if g.shape[1]] for name, groups in out.items() if groups}


def _shared_conditions(problem: Problem) -> list[tuple[str, Array]]:
    """Return the conditions whose product with a place is looked at: the speed on the way, whatever its direction."""
    speed = path_speed(problem.run)
    return [] if speed is None or np.ptp(speed) <= UNSEEN else [("speed", problem.per_observation(speed))]


def path_speed(run: Run) -> Array | None:
    """Return |v| of the linear axes (n,) mm/s, or None where the run has no speeds."""
    names = [f"speed_{a}_mm_s" for a in "XYZ" if f"speed_{a}_mm_s" in run.columns]
    return np.asarray(np.linalg.norm(run.vector(*names), axis=1)) if names else None


def without_unit(column: str) -> str:
    """Return the name of a column without its unit: time_s -> time, temp_part_C -> temp_part, speed_X_mm_s -> speed_X."""
    for unit in (
        "_mm_s2",
        "_rad_s2",
        "_rad_s",
        "_mm_s",
        "_mm_min",
        "_rad",
        "_deg",
        "_mm",
        "_kg",
        "_rpm",
        "_hPa",
        "_pct",
        "_s",
        "_C",
        "_N",
    ):
        if column.endswith(unit):
            return column.removesuffix(unit)
    return column


def _of_column(name: str, values: Array) -> list[Array]:
    if name.endswith("_rad"):
        return [np.concatenate([_wave(values, 2 * np.pi / k) for k in HARMONICS], axis=1)]
    return [polynomials(values)]


def polynomials(x: Array, degrees: int = DEGREES) -> Array:
    """Return constant and Legendre polynomials of the rank-free scaled covariate (m, k), no more than its values carry."""
    kinds = len(np.unique(x))
    scaled = 2 * (x - x.min()) / max(float(np.ptp(x)), LEAST_FRACTION) - 1
    return np.asarray(np.polynomial.legendre.legvander(scaled, min(degrees, kinds - 1)))


def surface(x: Array, y: Array, degree: int = DEGREES) -> Array:
    """Return the products P_i P_j of two positions, i and j at least 1, of degree `degree` together at most (m, 6)."""
    a, b = polynomials(x, degree), polynomials(y, degree)
    pairs = [(i, j) for i in range(1, a.shape[1]) for j in range(1, b.shape[1]) if i + j <= degree]
    return np.stack([a[:, i] * b[:, j] for i, j in pairs], axis=1) if pairs else np.zeros((len(x), 0))


def zone_bumps(x: Array, y: Array) -> list[Array]:
    """Return Gaussian spots (m, 1) for one bad zone, on a grid of places, two widths; none where they hold few rows."""
    a, b = ((v - v.min()) / max(float(np.ptp(v)), LEAST_FRACTION) for v in (x, y))
    out = []
    for width in ZONE_WIDTHS:
        centres = np.arange(width, 1.0, width)
        for i, j in itertools.product(centres, centres):
            spot = np.exp(-0.5 * ((a - i) ** 2 + (b - j) ** 2) / width**2)
            if spot.sum() > ZONE_ROWS:
                out.append(spot[:, None])
    return out


def _waves_by(angle: Array, x: Array) -> Array:
    """Return the harmonics 1 to 4 of an angle times P1 and P2 of a position (m, 16)."""
    waves = np.concatenate([_wave(angle, 2 * np.pi / k) for k in HARMONICS], axis=1)
    degrees = polynomials(x, 2)[:, 1:]
    return np.concatenate(
        [waves * degrees[:, [k]] for k in range(degrees.shape[1])] or [waves[:, :0]], axis=1
    )


def _wave(x: Array, period: float) -> Array:
    phase = 2 * np.pi / period * x
    return np.stack([np.cos(phase), np.sin(phase)], axis=1)


def locate(generic: Scorer, y: Array, chance: Array) -> tuple[Place, ...]:
    """Return the places in the order of their scores. chance (M,): largest score of each null recording."""
    if not generic.candidates.families:
        return ()
    scores = generic.scores(y[:, None])[:, 0]
    out: list[Place] = []
    names: set[str] = set()
    for i in np.argsort(-scores, kind="stable"):
        family = generic.candidates.families[i]
        p = (1 + int(np.sum(chance >= scores[i]))) / (1 + len(chance))
        if p > 1.0 - SECURE or len(out) == MOST_SHOWN:
            break
        if family.name not in names:
            names.add(family.name)
            direction = family.where["direction"]
            out.append(Place(family.name, direction, p, _words(family.name, direction), float(scores[i])))
    return tuple(out)


def score_map(generic: Scorer, y: Array) -> tuple[Place, ...]:
    """Return the evidence over every covariate in its best direction, in the order of the scores; for the picture."""
    if not generic.candidates.families:
        return ()
    scores = generic.scores(y[:, None])[:, 0]
    best: dict[str, Place] = {}
    for i in np.argsort(-scores, kind="stable"):
        family = generic.candidates.families[i]
        direction = family.where["direction"]
        best.setdefault(family.name, Place(family.name, direction, float("nan"), "", float(scores[i])))
    return tuple(best.values())


def direction_text(direction: str) -> str:
    """Return 'in x', or 'along the normal'."""
    return "along the normal" if direction == "normal" else f"in {direction}"


def _words(covariate: str, direction: str) -> str:
    return f"the residual {direction_text(direction)} depends on {covariate}"
