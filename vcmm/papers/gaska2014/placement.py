"""What Gaska et al. 2014 wished for: the best place found by the program, probe errors included, and fewer nodes.

Three questions, each over many machines that agree with the paper's published figures (vcmm.papers.gaska2014.twin):

ranking     in what share of them are places 3 and 5 the best of the five, as in the paper's Table 3?
optimum     which pose is best of all, with interpolated standard deviations and with a correlated field? Independent
            draws at the nodes are never interpolated: their variance shrinks between the nodes, so that an optimiser
            moves the touches away from all nodes, where nothing was measured.
nodes       how few reference points still give the right place?
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.inputs import Input
from vcmm.core.laws import MultivariateNormal, StudentT
from vcmm.core.run import Array
from vcmm.effects.residual import CorrelatedField
from vcmm.evaluation.linear import build
from vcmm.gps import characteristics as gps
from vcmm.measuring.fixture import Fixture, Freedom, Goal, six_of
from vcmm.measuring.plan import Ints
from vcmm.measuring.scenario import Scenario
from vcmm.papers.gaska2014.nodes import NODES, NU, draw_deviations
from vcmm.papers.gaska2014.twin import (
    FIELD,
    REDRAWS,
    _FormTrials,
    _per_lane,
    field_scales,
    with_field,
)
from vcmm.placing.objective import Uncertain
from vcmm.placing.placement import place
from vcmm.placing.result import Placed

LENGTH = 150.0  # mm: correlation length of the correlated field, the distance between the nodes
INFLATION = float(StudentT(1.0, NU).u)  # standard deviation of the t-law of unit scale
SUBSETS = (52, 39, 26, 20, 13, 8, 4)
Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Ranking:
    """U (draws, places) mm of form and distance for one redraw rule, k = 2 standard deviations for the distance."""

    redraw: str
    places: tuple[str, ...]
    form: Array
    distance: Array

    def shares(self) -> dict[str, tuple[float, float, float]]:
        """Per place: share of draws in which it is best by form, by distance, and by the sum of both ranks."""
        total = _ranks(self.form) + _ranks(self.distance)
        return {
            name: tuple(float(_wins(v)[:, i].mean()) for v in (self.form, self.distance, total))  # type: ignore[misc]
            for i, name in enumerate(self.places)
        }

    def both_best(self, names: tuple[str, str] = ("3", "5")) -> tuple[float, float, float]:
        """Share of draws in which these two places are the best two: by form, by distance, by the sum of ranks."""
        total = _ranks(self.form) + _ranks(self.distance)
        which = [self.places.index(n) for n in names]
        others = [i for i in range(len(self.places)) if i not in which]
        found = [
            float((v[:, which].max(axis=1) < v[:, others].min(axis=1)).mean())
            for v in (self.form, self.distance, total)
        ]
        return found[0], found[1], found[2]


def _ranks(values: Array) -> Array:
    return np.asarray(values.argsort(axis=1).argsort(axis=1), dtype=float)


def _wins(values: Array) -> Array:
    """1 for the lowest of each row, shared by equals."""
    lowest = values == values.min(axis=1, keepdims=True)
    return np.asarray(lowest / lowest.sum(axis=1, keepdims=True))


def ranking(scenario: Scenario, draws: int = 200, progress: Progress | None = None) -> list[Ranking]:
    """U at the five places for many consistent machines, both redraw rules."""
    report = progress or (lambda text, share: None)
    scales = np.array([draw_deviations(seed).ravel() * 1e-3 for seed in range(1, draws + 1)])
    out = []
    for redraw in REDRAWS:
        form, distance = [], []
        for k, (name, pose) in enumerate(scenario.places.items()):
            report(f"place {name}, field per {redraw}", k / len(scenario.places))
            one = _place_u(with_field(scenario, redraw).at(pose), scales)
            form.append(one[0])
            distance.append(one[1])
        out.append(Ranking(redraw, tuple(scenario.places), np.array(form).T, np.array(distance).T))
    return out


def _place_u(scenario: Scenario, scales: Array) -> tuple[Array, Array]:
    """U (draws,) of form and distance at one place: the form from common trials, the distance in closed form, k = 2."""
    model = build(scenario.task())
    names = {c.type: (i, c.name) for i, c in enumerate(model.characteristics)}
    gradient = model.gradient()[names["distance"][0]]
    others = [model.term(i) for i in model.influences if i.input.effect != FIELD]
    influence = next(i for i in model.influences if i.input.effect == FIELD)
    rest = sum(float(((gradient @ t.gain) ** 2).sum()) * float(t.law.u) ** 2 for t in others)
    lanes = _per_lane(gradient @ model.operator, model.along_normal(influence), influence.codes)
    u = np.sqrt(scales**2 @ (lanes**2).sum(axis=0) * INFLATION**2 + rest)
    trials = _FormTrials(model, influence, others, names["cylindricity"][1], scenario.settings.seed)
    parts = np.array_split(scales, max(1, len(scales) // 25))
    return np.concatenate([trials.expanded(p) for p in parts]), 2 * u


def field_scenario(scenario: Scenario, redraw: str, deviations: Array | None = None) -> Scenario:
    """The scenario with a correlated field in place of interpolated draws.

    redraw "touch": every touch has its own draw with the interpolated standard deviation; "run": one Gaussian field per
    measurement. deviations (52, 3) um: scales of the t-law, those of the scenario unless given; their u is taken.
    """
    scale = field_scales(scenario) if deviations is None else deviations * 1e-3
    one = CorrelatedField(nodes=NODES, deviation=scale * INFLATION, length=LENGTH)
    machine = scenario.machine
    effects = tuple(one if e.name == FIELD else e for e in machine.effects)
    known = Input(
        one.name,
        "",
        "values",
        MultivariateNormal(one.covariance()),
        redraw,
        "Tables 1 and 2; 44 of 52 nodes drawn",
    )
    inputs = tuple(known if i.effect == FIELD else i for i in machine.inputs)
    return replace(scenario, machine=replace(machine, effects=effects, inputs=inputs))


def free_fixture() -> Fixture:
    """Anywhere among the nodes, turned at will about the vertical."""
    ends = (-np.inf, np.inf)
    names = ("x", "y", "z")
    return Fixture((*(Freedom(n, *ends) for n in names), Freedom("turn_z", -np.pi, np.pi)))


def goal(scenario: Scenario) -> Goal:
    """U of form and distance, equal weights: the two columns of the paper's Table 3."""
    names = [c.name for c in scenario.part.characteristics]
    return Goal({"U": 1.0}, {n: 1.0 / len(names) for n in names})


@dataclass(frozen=True, eq=False)
class Optimum:
    """The pose found for one reading of the field, and the objective (mm) at the paper's five places."""

    redraw: str
    found: Placed
    places: dict[str, float]


def optimum(
    scenario: Scenario,
    redraw: str,
    progress: Progress | None = None,
    evaluations: int = 3000,
    scanned: int = 2048,
    trials: int = 20_000,
    seed: int | None = None,
) -> Optimum:
    """The best pose found on a correlated field (redraw "run") or on interpolated standard deviations ("touch")."""
    changed = field_scenario(scenario, redraw)
    found = place(
        changed, fixture=free_fixture(), goal=goal(scenario), evaluations=evaluations, scanned=scanned, trials=trials, seed=seed,
        progress=progress,
    )  # fmt: skip
    six = np.array([six_of(p) for p in scenario.places.values()])
    values = found.objective.values(six)
    return Optimum(redraw, found, {n: float(v) for n, v in zip(scenario.places, values)})


@dataclass(frozen=True)
class NodeReduction:
    """For one number of nodes: how much worse (share) the place chosen with them is than the one chosen with all 52."""

    nodes: int
    median: float
    worst: float  # exceeded in 5 % of the draws
    right: float  # share of draws in which the loss is below 2 %


def reduction(
    scenario: Scenario, draws: int = 100, poses: int = 400, seed: int = 1, progress: Progress | None = None
) -> list[NodeReduction]:
    """How few reference points still give the right place: distance of the faces, interpolated standard deviations.

    For every draw of a consistent machine and every number of nodes a random subset is kept (evenly drawn, so that the
    same subsets need not be good ones), the best of `poses` even poses is chosen with it and judged with all nodes.
    """
    report = progress or (lambda text, share: None)
    gains, kernel = _touch_gains(field_scenario(scenario, "touch"), poses, seed)
    rng = np.random.default_rng([seed, 52])
    fields = [draw_deviations(s) * 1e-3 * INFLATION for s in range(1, draws + 1)]
    truth = np.array([_variance(gains, kernel, f, np.arange(len(NODES))) for f in fields])
    out = []
    for count in SUBSETS:
        report(f"{count} nodes", SUBSETS.index(count) / len(SUBSETS))
        loss = []
        for field, full in zip(fields, truth):
            kept = np.sort(rng.permutation(len(NODES))[:count])
            chosen = int(_variance(gains, kernel, field, kept).argmin())
            loss.append(np.sqrt(full[chosen] / full.min()) - 1)
        values = np.array(loss)
        out.append(
            NodeReduction(
                count,
                float(np.median(values)),
                float(np.quantile(values, 0.95)),
                float((values < 0.02).mean()),
            )
        )
    return out


def _touch_gains(scenario: Scenario, count: int, seed: int) -> tuple[Array, Array]:
    """(poses, n, 3) squared gains of the distance per direction at every touch; (poses, n, nodes) kernel to the nodes."""
    from vcmm.placing.fixture_boxes import boxes
    from vcmm.placing.travels import Travels

    objective = Uncertain.of(scenario, goal(scenario))
    rows = objective.closed.rows
    box = boxes(free_fixture(), six_of(scenario.pose), Travels(rows))[0]
    six, _ = box.poses(np.random.default_rng([seed, 400]).random((count, box.d)))
    number = next(i for i, c in enumerate(objective.characteristics) if gps.is_linear(c))
    weights = objective.gradient_rows[number]
    run = rows.run(six)
    used = np.flatnonzero(np.abs(weights) > 0)
    gains = ((weights[:, None] * run.normal.reshape(count, rows.n, 3)) ** 2)[:, used]
    tip = run.tip.reshape(count, rows.n, 3)[:, used]
    squared = ((tip[:, :, None, :] - NODES) ** 2).sum(axis=3)
    return gains, np.exp(-squared / (2 * LENGTH**2))


def _variance(gains: Array, kernel: Array, deviation: Array, kept: Ints) -> Array:
    """(poses,): variance of the distance with standard deviations (52, 3) known at the kept nodes only."""
    near = kernel[:, :, kept]
    local = near @ deviation[kept] / near.sum(axis=2, keepdims=True)
    return np.asarray((gains * local**2).sum(axis=(1, 2)))
