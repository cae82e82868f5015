"""What the paper leaves open of its model, read every way, each beside Table 3.

    curve    b-spline of a column through its four nodes, or with them as control points     section 4, Fig. 5
    plane    linear between the columns, or the nearest column                                section 4, 5
    amount   d is the standard deviation of the t-law (Table 2), or its scale (t(x, sigma, nu))
    redraw   the field is drawn anew at every touch (Fig. 6: "for a single measuring point"), or once per measurement

Each reading is put to three tests over machines that agree with the published figures: do their ranges of U hold the ten of
Table 3; is U of the form above U of the distance at all five places, as there; do results that scatter by such U have the spread of
the five results there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import product

import numpy as np
import numpy.typing as npt

from vcmm import Array, Scenario, laws, measuring
from vcmm import effects as fx
from vcmm.answer.evaluation.linear import build
from vcmm.answer.evaluation.streams import draw
from vcmm.core.residual_weights import CURVES, field_weights

from .nodes import NODES, NU

PAPER_FORM_U = {"1": 0.6, "2": 0.8, "3": 0.5, "4": 0.9, "5": 0.5}  # Table 3, um
PAPER_DISTANCE_U = {"1": 0.4, "2": 0.5, "3": 0.4, "4": 0.6, "5": 0.3}
PAPER_U = np.array([*PAPER_FORM_U.values(), *PAPER_DISTANCE_U.values()])
PAPER_FORM = (11.7, 11.6, 11.4, 11.3, 11.6)  # um, results at places 1 to 5
PAPER_DISTANCE = (188.9299, 188.9295, 188.9298, 188.9292, 188.9297)  # mm
ROUNDED = 0.05  # um: half the last digit of Table 3
PLANES = {"linear": "columns-linear", "nearest": "columns-nearest"}
AMOUNTS = {"deviation": 1.0 / laws.StudentT(1.0, NU).u, "scale": 1.0}  # scale of the t-law per d
REDRAWS = ("touch", "run")
Ints = npt.NDArray[np.intp]
TRIALS, RESULTS = 1000, 2000
SHOWN, LOW, HIGH = 0.95, 0.025, 0.975
Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Reading:
    """One way to read the paper; see the head of this file."""

    curve: str
    plane: str
    amount: str
    redraw: str

    @property
    def words(self) -> str:
        amount = "sd" if self.amount == "deviation" else self.amount
        return f"{self.curve}, {self.plane}, {amount}, {self.redraw}"


SHOWN_READING = Reading("control", "linear", "deviation", "touch")  # of the scenario: closest to Table 3
READINGS = tuple(Reading(*one) for one in product(CURVES, PLANES, AMOUNTS, REDRAWS))


@dataclass(frozen=True, eq=False)
class ReadingResult:
    """U and standard deviations (machines, places) mm of form and distance under one reading."""

    reading: Reading
    form: Array
    distance: Array
    form_sd: Array
    distance_sd: Array

    def first(self, count: int) -> ReadingResult:
        """Of the first machines only."""
        return ReadingResult(
            self.reading, *(u[:count] for u in (self.form, self.distance, self.form_sd, self.distance_sd))
        )

    def hits(self) -> tuple[int, int]:
        """Of the five U of the form and the five of the distance: how many lie, rounded, in the central 95 % of the machines."""
        return int(self._inside(PAPER_U)[:5].sum()), int(self._inside(PAPER_U)[5:].sum())

    @cached_property
    def hits_p(self) -> float:
        """Share of the machines whose own ten U have no more hits than the paper's: one machine's U go up and down together."""
        ten = np.concatenate([self.form, self.distance], axis=1) * 1e3
        return float((self._inside(ten).sum(axis=1) <= sum(self.hits())).mean())

    def _inside(self, u: Array) -> Array:
        """Whether U (..., 10) um, rounded as in Table 3, lie in the ranges."""
        low, high = np.quantile(np.concatenate([self.form, self.distance], axis=1), [LOW, HIGH], axis=0) * 1e3
        return np.asarray((u + ROUNDED >= low) & (u - ROUNDED <= high))

    def ratio(self) -> tuple[float, float]:
        """U(form)/U(distance), mean over the places: its median over machines, and in what share of them it is above 1 at all five."""
        ratio = self.form / self.distance
        return float(np.median(ratio.mean(axis=1))), float((ratio > 1).all(axis=1).mean())

    @cached_property
    def spread(self) -> tuple[float, float]:
        """Two-sided p of the spread of the five results of form and of distance, over machines and draws of results."""
        return _spread_p(self.form_sd, PAPER_FORM, 1e-3), _spread_p(self.distance_sd, PAPER_DISTANCE, 1.0)

    def against(self) -> tuple[str, ...]:
        """Which tests contradict the reading at 5 %."""
        out = ["U"] if self.hits_p < 1 - SHOWN else []
        out += ["ratio"] if self.ratio()[1] < 1 - SHOWN else []
        return (*out, *(["spread"] if min(self.spread) < (1 - SHOWN) / 2 else []))


def _spread_p(sd: Array, results: Sequence[float], unit: float) -> float:
    """Two-sided p of the standard deviation of five results (times unit mm), each normal about one value with sd (machines, 5)."""
    total, square = np.zeros((len(sd), RESULTS)), np.zeros((len(sd), RESULTS))
    for one, z in zip(sd.T, _normals(*sd.shape)):
        x = one[:, None] * z
        total += x
        square += x * x
    count = sd.shape[1]
    variance = (square - total**2 / count) / (count - 1)
    below = float((variance <= (np.std(results, ddof=1) * unit) ** 2).mean())
    return min(1.0, 2 * min(below, 1 - below))


@lru_cache(maxsize=2)
def _normals(machines: int, count: int) -> Array:
    """(count, machines, RESULTS) standard normals, the same for every reading."""
    drawn = np.random.default_rng(20140505).standard_normal((machines, RESULTS, count))
    return np.ascontiguousarray(drawn.transpose(2, 0, 1))


def with_reading(scenario: Scenario, reading: Reading, deviations: Array) -> Scenario:
    """The scenario with its field read that way; deviations: d (52, 3) um."""
    machine, kind = scenario.machine, fx.ResidualField
    scale = deviations.ravel() * 1e-3 * AMOUNTS[reading.amount]
    effects = tuple(
        kind(nodes=e.nodes, interpolation=PLANES[reading.plane], curve=reading.curve)
        if isinstance(e, kind)
        else e
        for e in machine.effects
    )
    inputs = tuple(
        replace(i, redraw=reading.redraw, scale=scale) if i.effect == kind.name else i for i in machine.inputs
    )
    return replace(scenario, machine=replace(machine, effects=effects, inputs=inputs))


class _PlaceTrials:
    """One place: what turns errors of the touches into form and distance. The draws are common to all machines and readings."""

    def __init__(self, scenario: Scenario, trials: int) -> None:
        model = build(scenario.task())
        kind = fx.ResidualField
        self.trials, self.seed = trials, scenario.settings.seed
        run = model.task.touches.run
        self.tip, self.normal = run.tip, run.normal
        names = {c.type: i for i, c in enumerate(model.characteristics)}
        feature = model.characteristics[names["cylindricity"]].of[0]
        block, self.rows = model.blocks[feature], model.task.touches.rows[feature]
        residuals = slice(block.stop - block.residuals, block.stop)
        self.operator = model.operator[residuals][:, self.rows]
        gradient = model.gradient()[names["distance"]]
        self.weights = gradient @ model.operator
        others = [model.term(i) for i in model.influences if i.input.effect != kind.name]
        self.rest = sum(float(((gradient @ t.gain) ** 2).sum()) * float(np.max(t.law.u)) ** 2 for t in others)
        self.base = np.tile(model.q0[residuals, None], (1, trials))
        for term in others:
            assert not isinstance(
                term.law, laws.MultivariateNormal
            )  # its draws are standard normals times a factor
            self.base += term.gain[residuals] @ draw(self.seed, term.name, term.lanes, term.law, 0, trials).T

    def along(self, reading: Reading) -> Array:
        """(n, 52, 3): error of each touch along its normal per error of each node."""
        lateral, vertical = field_weights(NODES, PLANES[reading.plane], self.tip, curve=reading.curve)
        return np.stack([lateral, lateral, vertical], axis=2) * self.normal[:, None, :]

    def distance(self, along: Array, scales: Array, redraw: str) -> Array:
        """Standard deviation (M,) mm of the distance, closed form, for scales (M, 52, 3) mm."""
        lanes = self.weights[:, None, None] * along
        lanes = lanes if redraw == "touch" else lanes.sum(axis=0, keepdims=True)
        square = (lanes**2).sum(axis=0)
        return np.asarray(
            np.sqrt(np.einsum("mki,ki->m", scales**2, square) * laws.StudentT(1.0, NU).u ** 2 + self.rest)
        )

    def form(self, drawn: list[tuple[Ints, Array]], scales: Array) -> tuple[Array, Array]:
        """U, half of where 95 % of the simulated forms lie, and standard deviation (M,) mm, for scales (M, 52, 3) mm."""
        parts = np.array_split(scales.reshape(len(scales), -1), max(1, len(scales) // 5))
        forms = np.concatenate([self._forms(part, drawn) for part in parts])
        low, high = np.quantile(forms, [LOW, HIGH], axis=1)
        return np.asarray(high - low) / 2, forms.std(axis=1)

    def drawn(self, along: Array, redraw: str) -> list[tuple[Ints, Array]]:
        """Per touch of the bore (lanes that act on it, (lanes, trials) error along the normal for a scale of 1)."""
        along = along[self.rows].reshape(len(self.rows), -1)
        rng = np.random.default_rng([self.seed, 2014])
        common = rng.standard_t(NU, (along.shape[1], self.trials)) if redraw == "run" else None
        out = []
        for touch in along:
            mine = np.flatnonzero(touch)
            z = rng.standard_t(NU, (len(mine), self.trials)) if common is None else common[mine]
            out.append((mine, touch[mine, None] * z))
        return out

    def _forms(self, scales: Array, drawn: list[tuple[Ints, Array]]) -> Array:
        """(M, trials) mm."""
        errors = np.empty((len(drawn), len(scales), self.trials))
        for into, (mine, z) in zip(errors, drawn):
            np.matmul(scales[:, mine], z, out=into)
        residuals = (self.operator @ errors.reshape(len(drawn), -1)).reshape(-1, *errors.shape[1:])
        residuals += self.base[:, None, :]
        return np.asarray(residuals.max(axis=0) - residuals.min(axis=0))


def matrix(
    scenario: Scenario,
    deviations: Array,
    readings: Sequence[Reading] = READINGS,
    trials: int = TRIALS,
    progress: Progress = lambda text, share: None,
) -> list[ReadingResult]:
    """Every reading at every place for machines with d (M, 52, 3) um."""
    sums: dict[Reading, list[tuple[Array, Array, Array]]] = {one: [] for one in readings}
    alike: dict[tuple[str, str, str], list[Reading]] = {}  # but for the amount, which only multiplies
    for one in readings:
        alike.setdefault((one.curve, one.plane, one.redraw), []).append(one)
    for k, (name, pose) in enumerate(scenario.places.items()):
        progress(f"readings at place {name}", k / len(scenario.places))
        place = _PlaceTrials(scenario.at(pose), trials)
        for same in alike.values():
            along, redraw = place.along(same[0]), same[0].redraw
            drawn = place.drawn(along, redraw)
            for one in same:
                scales = deviations * 1e-3 * AMOUNTS[one.amount]
                sums[one].append((*place.form(drawn, scales), place.distance(along, scales, redraw)))
    out = []
    for one, places in sums.items():
        form, form_sd, sd = (np.stack(v, axis=1) for v in zip(*places))
        out.append(ReadingResult(one, form, 2 * sd, form_sd, sd))
    return out


def with_touches(scenario: Scenario, face: int, level: int) -> Scenario:
    """The scenario with face x face touches on each plane and `level` touches on each level of the bore; the paper gives no plan."""
    steps = []
    for step in scenario.plan.steps:
        feature = scenario.part.features[step.feature]
        way = (
            measuring.Grid((face, face), 10.0)
            if feature.kind == "plane"
            else measuring.Levels((10.0, 40.0, 70.0), level)
        )
        points, normals = measuring.plan_points(feature, way)
        steps.append(replace(step, points=points, normals=normals))
    return replace(scenario, plan=replace(scenario.plan, steps=tuple(steps)))


def central(result: ReadingResult) -> int:
    """The machine whose mean U of the form and mean U of the distance both rank nearest to the middle of all machines."""
    ranks = [u.mean(axis=1).argsort().argsort() for u in (result.form, result.distance)]
    return int(np.abs(np.array(ranks) - (len(result.form) - 1) / 2).max(axis=0).argmin())


def rank(u: Array, machine: int) -> int:
    """From 1, by the mean U (machines, places) over the places."""
    mean = u.mean(axis=1)
    return int((mean < mean[machine]).sum()) + 1
