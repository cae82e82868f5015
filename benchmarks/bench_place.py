"""Closed-form evaluation of a pose against a dense matrix evaluation and against 10^4 Monte Carlo trials, one run.

    python benchmarks/bench_place.py [poses]

matrix: the plan placed at the pose, G of all inputs as one dense matrix (points x lanes), G Sigma G^T through the fit
operator; what one writes in plain numpy. Monte Carlo: 10^4 trials of the same inputs, errors of all touches by one
matrix product, the fitted elements and the characteristics of every trial. The three agree before they are timed.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from vcmm.answer.evaluation.linear import LinearModel
from vcmm.answer.evaluation.streams import draw
from vcmm.answer.placing.fixture_boxes import boxes, default_fixture
from vcmm.answer.placing.objective import Uncertain
from vcmm.answer.placing.travels import Travels
from vcmm.core.run import Array
from vcmm.files.own.library import example
from vcmm.files.own.scenario import load_scenario
from vcmm.task.measuring.fixture import Goal, pose_of, six_of
from vcmm.task.measuring.scenario import Scenario
from vcmm.task.response.influence import influences

TRIALS = 10_000


def dense(scenario: Scenario, model: LinearModel, six: Array) -> tuple[Array, Array]:
    """G (n, lanes) of the touches along their normals, and the u of every lane, at one pose."""
    task = scenario.at(pose_of(six)).task()
    columns, spread = [], []
    for one in influences(task.machine, task.touches.run, task.inputs):
        law, factor = one.input.spread(one.response.shape[2])
        along = np.einsum("nik,ni->nk", one.response, task.touches.run.normal) @ factor
        for copy in range(len(one.copies)):
            columns.append(np.where((one.codes == copy)[:, None], along, 0.0))
            spread.append(np.full(along.shape[1], float(np.ravel(law.u)[0])))
    return np.concatenate(columns, axis=1), np.concatenate(spread)


def by_matrix(scenario: Scenario, model: LinearModel, weights: Array, six: Array) -> Array:
    """u of the characteristics."""
    g, spread = dense(scenario, model, six)
    gain = weights @ g
    return np.sqrt(np.diag(gain @ np.diag(spread**2) @ gain.T))


def by_trials(scenario: Scenario, model: LinearModel, weights: Array, six: Array) -> Array:
    """u of the characteristics from 10^4 trials."""
    from vcmm.core.laws import Normal

    g, spread = dense(scenario, model, six)
    lanes = np.stack([np.arange(g.shape[1]), np.zeros(g.shape[1])], axis=1).astype(np.uint32)
    z = draw(1, "benchmark", lanes, Normal(1.0), 0, TRIALS) * spread
    values = model.values(model.q0 + (z @ g.T) @ model.operator.T)
    return np.asarray(values.std(axis=0))


def timed(call: Callable[[], object], repeats: int = 3) -> float:
    """Best time of a few calls, s."""
    best = np.inf
    for _ in range(repeats):
        begin = time.perf_counter()
        call()
        best = min(best, time.perf_counter() - begin)
    return best


def compare(name: str, poses: int) -> str:
    """One line: times of the three ways on the smooth characteristics of an embedded scenario."""
    scenario = load_scenario(example(name))
    smooth = [c for c in scenario.part.characteristics if c.type in ("size", "distance")]
    scenario = replace(scenario, part=replace(scenario.part, characteristics=tuple(smooth)))
    objective = Uncertain.of(scenario, Goal({"U": 1.0}))
    box = boxes(default_fixture(), six_of(scenario.pose), Travels(objective.closed.rows))[0]
    six = box.poses(np.random.default_rng(0).random((poses, box.d)))[0]
    model = objective.closed.model
    weights = model.gradient() @ model.operator
    closed = objective.spread(six[:1]).u[0]
    matrix, trials = (f(scenario, model, weights, six[0]) for f in (by_matrix, by_trials))
    assert np.allclose(closed, matrix, rtol=0.02), (closed, matrix)
    assert np.allclose(closed, trials, rtol=0.05), (closed, trials)
    t = timed(lambda: objective.values(six)) / poses
    t_matrix = timed(lambda: [by_matrix(scenario, model, weights, p) for p in six[:10]]) / 10
    t_trials = timed(lambda: by_trials(scenario, model, weights, six[0]))
    return (
        f"{name}: {objective.closed.rows.n} touches; closed form {t * 1e6:.0f} us per pose; matrix {t_matrix * 1e3:.2f} ms, "
        f"{t_matrix / t:.0f} times (bar 20); 10^4 trials {t_trials * 1e3:.0f} ms, {t_trials / t:.0f} times (bar 2000)"
    )


def main() -> None:
    poses = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    for name in ("plate", "gaska2014"):
        print(compare(name, poses))


if __name__ == "__main__":
    main()
