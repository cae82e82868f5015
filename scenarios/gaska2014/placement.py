"""What Gaska et al. 2014 wished for: the best place found by the program, probe errors included, and fewer nodes.

Three questions, each over many machines that agree with the paper's published figures (twin.py):

ranking     in what share of them are places 3 and 5 the best of the five, as in the paper's Table 3?
optimum     which pose is best of all, with interpolated standard deviations and with a correlated field? Independent
            draws at the nodes are never interpolated: their variance shrinks between the nodes, so that an optimiser
            moves the touches away from all nodes, where nothing was measured.
nodes       how few reference points still give the right place, picked at random and picked well?
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from vcmm import Array, Input, Scenario, laws, placement
from vcmm import characteristics as gps
from vcmm import effects as fx
from vcmm.answer.placing.objective import Uncertain
from vcmm.task.measuring.plan import Ints

from .nodes import NODES, SHOWN, draw_deviations
from .readings import REDRAWS, SHOWN_READING, matrix

LENGTH = 150.0  # mm: correlation length of the correlated field, the distance between the nodes
OTHERS = 40  # machines on which the pose found is tried
TRAINED, TRAIN_POSES = 60, 150
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
    """U at the five places for many consistent machines, both redraw rules of the reading that is shown."""
    drawn = np.array([draw_deviations(seed) for seed in range(1, draws + 1)])
    readings = [replace(SHOWN_READING, redraw=redraw) for redraw in REDRAWS]
    found = matrix(scenario, drawn, readings, progress=progress or (lambda text, share: None))
    return [Ranking(f.reading.redraw, tuple(scenario.places), f.form, f.distance) for f in found]


def field_scenario(scenario: Scenario, redraw: str, deviations: Array | None = None) -> Scenario:
    """The scenario with a correlated field in place of interpolated draws.

    redraw "touch": every touch has its own draw with the interpolated standard deviation; "run": one Gaussian field per
    measurement. deviations: d (52, 3) um as standard deviations, those of the machine that is shown unless given.
    """
    kind = fx.ResidualField.name
    d = draw_deviations(SHOWN) if deviations is None else deviations
    one = fx.CorrelatedField(nodes=NODES, deviation=d * 1e-3, length=LENGTH)
    machine = scenario.machine
    effects = tuple(one if e.name == kind else e for e in machine.effects)
    law = laws.MultivariateNormal(one.covariance())
    known = Input(one.name, "", "values", law, redraw, "Tables 1 and 2; 44 of 52 nodes drawn")
    inputs = tuple(known if i.effect == kind else i for i in machine.inputs)
    return replace(scenario, machine=replace(machine, effects=effects, inputs=inputs))


def free_fixture() -> placement.Fixture:
    """Anywhere among the nodes, turned at will about the vertical."""
    ends = (-np.inf, np.inf)
    names = ("x", "y", "z")
    return placement.Fixture(
        (*(placement.Freedom(n, *ends) for n in names), placement.Freedom("turn_z", -np.pi, np.pi))
    )


def goal(scenario: Scenario) -> placement.Goal:
    """U of form and distance, equal weights: the two columns of the paper's Table 3."""
    names = [c.name for c in scenario.part.characteristics]
    return placement.Goal({"U": 1.0}, {n: 1.0 / len(names) for n in names})


@dataclass(frozen=True, eq=False)
class Optimum:
    """The pose found for one reading of the field, and the objective (mm) at the paper's five places, on the machine that is shown.

    better: share of other machines on which this pose, found for another, still beats the best of the five; saved: median of what it saves
    there, as a share of U.
    """

    redraw: str
    found: placement.PlacementResult
    places: dict[str, float]
    better: float
    saved: float


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
    found = placement.place(
        changed, fixture=free_fixture(), goal=goal(scenario), evaluations=evaluations, scanned=scanned, trials=trials, seed=seed,
        progress=progress,
    )  # fmt: skip
    six = np.array([*(placement.six_of(p) for p in scenario.places.values()), found.best.pose])
    values = found.objective.values(six)
    others = np.array([_values(scenario, redraw, draw_deviations(k), six) for k in range(1, OTHERS + 1)])
    saved = 1 - others[:, -1] / others[:, :-1].min(axis=1)
    named = {n: float(v) for n, v in zip(scenario.places, values)}
    return Optimum(redraw, found, named, float((saved > 0).mean()), float(np.median(saved)))


def _values(scenario: Scenario, redraw: str, deviations: Array, six: Array) -> Array:
    """The objective (m,) mm at poses (m, 6) on a machine with d (52, 3) um."""
    return Uncertain.of(field_scenario(scenario, redraw, deviations), goal(scenario)).values(six)


@dataclass(frozen=True)
class NodeReduction:
    """For one number of nodes: how much worse (share) the place chosen with them is than the one chosen with all 52.

    picked: "random" (another subset for every machine), "columns" (whole columns, at random) or "optimised" (one subset for all).
    """

    nodes: int
    picked: str
    median: float
    worst: float  # exceeded in 5 % of the draws
    right: float  # share of draws in which the loss is below 2 %


def reduction(
    scenario: Scenario, draws: int = 100, poses: int = 400, seed: int = 1, progress: Progress | None = None
) -> list[NodeReduction]:
    """How few reference points still give the right place: distance of the faces, interpolated standard deviations.

    The best of `poses` even poses is chosen with the nodes that are kept, and judged with all of them. Optimised subsets are found on other
    machines than those on which they are judged: whose nodes matter must be known before a node is measured.
    """
    report = progress or (lambda text, share: None)
    gains, kernel = _touch_gains(field_scenario(scenario, "touch"), poses, seed)
    rng = np.random.default_rng([seed, 52])
    fields = np.array([draw_deviations(s) * 1e-3 for s in range(1, draws + 1)])
    truth = _variances(gains, kernel, fields, np.arange(len(NODES)))
    best = optimised(gains, kernel, seed, report)
    out = []
    for count in SUBSETS:
        report(f"{count} nodes", SUBSETS.index(count) / len(SUBSETS))
        at_random = [np.sort(rng.permutation(len(NODES))[:count]) for _ in fields]
        columns = [
            np.concatenate([4 * c + np.arange(4) for c in rng.permutation(13)[: count // 4]]) for _ in fields
        ]
        picked = {"random": at_random, "optimised": [best[count]] * len(fields)}
        if count % 4 == 0:
            picked["columns"] = columns
        for how, subsets in picked.items():
            loss = np.array([_loss(gains, kernel, *one) for one in zip(fields, truth, subsets)])
            out.append(_reduced(count, how, loss))
    return [r for r in out if r.nodes < len(NODES) or r.picked == "random"]


def _loss(gains: Array, kernel: Array, field: Array, full: Array, kept: Ints) -> float:
    chosen = int(_variances(gains, kernel, field[None], kept)[0].argmin())
    return float(np.sqrt(full[chosen] / full.min()) - 1)


def _reduced(count: int, how: str, loss: Array) -> NodeReduction:
    worst = float(np.quantile(loss, 0.95))
    return NodeReduction(count, how, float(np.median(loss)), worst, float((loss < 0.02).mean()))


def _touch_gains(scenario: Scenario, count: int, seed: int) -> tuple[Array, Array]:
    """(poses, n, 3) squared gains of the distance per direction at every touch; (poses, n, nodes) kernel to the nodes."""
    from vcmm.answer.placing.fixture_boxes import boxes
    from vcmm.answer.placing.travels import Travels

    objective = Uncertain.of(scenario, goal(scenario))
    rows = objective.closed.rows
    box = boxes(free_fixture(), placement.six_of(scenario.pose), Travels(rows))[0]
    six, _ = box.poses(np.random.default_rng([seed, 400]).random((count, box.d)))
    number = next(i for i, c in enumerate(objective.characteristics) if gps.is_linear(c))
    weights = objective.gradient_rows[number]
    run = rows.run(six)
    used = np.flatnonzero(np.abs(weights) > 0)
    gains = ((weights[:, None] * run.normal.reshape(count, rows.n, 3)) ** 2)[:, used]
    tip = run.tip.reshape(count, rows.n, 3)[:, used]
    squared = ((tip[:, :, None, :] - NODES) ** 2).sum(axis=3)
    return gains, np.exp(-squared / (2 * LENGTH**2))


def _variances(gains: Array, kernel: Array, deviations: Array, kept: Ints) -> Array:
    """(M, poses): variance of the distance with standard deviations (M, 52, 3) known at the kept nodes only."""
    near = kernel[:, :, kept]
    share = near / near.sum(axis=2, keepdims=True)
    local = np.tensordot(share, deviations[:, kept], axes=(2, 1))  # (poses, n, M, 3)
    return np.asarray(np.einsum("pni,pnmi->mp", gains, local**2, optimize=True))


def optimised(gains: Array, kernel: Array, seed: int, report: Progress) -> dict[int, Ints]:
    """Number of nodes -> subset, by taking away one node after another: always the one whose loss makes the chosen place worse by least, in the
    mean over TRAINED machines.
    """
    fields = np.array([draw_deviations(1000 * seed + s) * 1e-3 for s in range(TRAINED)])
    some = np.linspace(0, len(kernel) - 1, TRAIN_POSES).astype(int)
    gains, kernel = gains[some], kernel[some]
    full = _variances(gains, kernel, fields, np.arange(len(NODES)))
    kept, out = np.arange(len(NODES)), {len(NODES): np.arange(len(NODES))}
    while len(kept) > min(SUBSETS):
        report(f"subsets of {len(kept)} nodes", 1 - len(kept) / len(NODES))
        losses = [_mean_loss(gains, kernel, fields, full, np.delete(kept, i)) for i in range(len(kept))]
        kept = np.delete(kept, int(np.argmin(losses)))
        out[len(kept)] = kept
    return out


def _mean_loss(gains: Array, kernel: Array, fields: Array, full: Array, kept: Ints) -> float:
    chosen = _variances(gains, kernel, fields, kept).argmin(axis=1)
    return float(np.mean(np.sqrt(full[np.arange(len(full)), chosen] / full.min(axis=1)) - 1))
