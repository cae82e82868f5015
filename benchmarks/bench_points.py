"""U against time: optimised touches against every standard strategy, feature by feature, in the same run.

    python benchmarks/bench_points.py [most touches]

Same machine, form and scatter for both; a standard strategy dominates where it is not slower and its U is smaller than that of
every optimised plan of no more touches. Touches on one feature take the same time, so equal number is equal time but for the
way between them.
"""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np

from vcmm.answer.placing.candidates import nearest, problem_of, spots
from vcmm.answer.placing.growing_plans import growing, standard_points
from vcmm.answer.placing.plan_goal import goal_of
from vcmm.answer.placing.planning import standard_spots
from vcmm.core.errors import ModelLimit
from vcmm.core.inputs import Input
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.laws import Normal
from vcmm.core.machine import Machine
from vcmm.core.pose import Pose
from vcmm.part.part import Characteristic, Feature, Part
from vcmm.physics.structure.scatter import Scatter
from vcmm.physics.structure.squareness import Squareness
from vcmm.task.measuring.plan import Plan, Step, Stylus
from vcmm.task.measuring.scenario import Scenario

Z = np.array([0.0, 0.0, 1.0])
DATUM = Feature("datum", "plane", np.array([0, 0, 40.0]), Z, np.zeros(0), extent=(20.0, 20.0))
CASES = {
    "plane, height": (Feature("f", "plane", np.zeros(3), Z, np.zeros(0), extent=(80.0, 50.0)), "height"),
    "plane, parallelism": (Feature("f", "plane", np.zeros(3), Z, np.zeros(0), extent=(80.0, 50.0)), "parallelism"),
    "circle, diameter": (Feature("f", "circle", np.zeros(3), Z, np.array([20.0]), inside=True), "size"),
    "bore, diameter": (Feature("f", "cylinder", np.zeros(3), Z, np.array([20.0]), inside=True, extent=(40.0,)), "size"),
    "bore, perpendicularity": (Feature("f", "cylinder", np.zeros(3), Z, np.array([20.0]), inside=True, extent=(40.0,)), "perpendicularity"),
    "sphere, diameter": (Feature("f", "sphere", np.zeros(3), np.zeros(3), np.array([12.5])), "size"),
}  # fmt: skip


def scenario(feature: Feature, what: str) -> Scenario:
    """One feature with its characteristic; a datum plane where it needs one."""
    needs_datum = what in ("parallelism", "perpendicularity", "height")
    if what == "height":
        c = Characteristic("c", "distance", between=("datum", "f"))
    elif needs_datum:
        c = Characteristic("c", what, of=("f",), datums=("datum",), zone=0.01)
    else:
        c = Characteristic("c", what, of=("f",))
    features = [feature] + ([DATUM] if needs_datum else [])
    at = np.array([200.0, 0.0, 0.0])
    if needs_datum:  # beside the feature, so that nothing stands in the way
        features[1] = replace(DATUM, point=DATUM.point + at)
    steps = []
    for f in features:
        points = next(p for _, p in standard_points(f, 25, 2.0))
        from vcmm.part.part import normal

        steps.append(Step(f.name, "down", points, normal(f, points)))
    axes = {a: Axis(a, (-500.0, 500.0)) for a in "XYZ"}
    known = (
        Input("scatter", "", "value", Normal(0.4e-3), "touch"),
        Input("squareness", "B0Z", "angle", Normal(1e-6), "machine"),
        Input("squareness", "C0Y", "angle", Normal(1e-6), "machine"),
    )
    effects = (Scatter(), Squareness("B0Z", 0.0), Squareness("C0Y", 0.0))
    machine = Machine("m", "cmm", parse_structure("w b Y X Z t"), axes, effects, known)
    plan = Plan(tuple(steps), {"down": Stylus("down", np.array([0.0, 0.0, -120.0]), 1.5, 120.0)})
    return Scenario(
        "job", machine, Part({f.name: f for f in features}, (c,)), plan, Pose(np.eye(3), np.zeros(3))
    )


def compare(feature: Feature, what: str, most: int) -> list[tuple[str, int, float, float]]:
    """(strategy, touches on the feature, its u, u of the best optimised plan of no more touches), um."""
    job = scenario(feature, what)
    styli = {s.feature: s.stylus for s in job.plan.steps}
    problem = problem_of(job, styli, spots(job, styli, standard_spots(job)), {})
    goal = goal_of(problem, None, "U", 0)
    c = problem.candidates
    f = c.names.index("f")
    out = []
    curve = growing(problem, goal, 1e9, 0.0, most + (10 if len(c.names) > 1 else 0), lambda text, share: None)
    best = [(d, goal.variances(d)["c"]) for d in curve]
    for name, points in standard_points(feature, most, 1.5):
        found = nearest(c, "f", points)
        if (found < 0).any():
            continue  # not all of it can be touched
        for d, _ in best:  # the datum as in an optimised plan: only the feature is compared
            trial = d.copy()
            trial.counts[trial.rows_of[f]] = 0
            np.add.at(trial.counts, found, 1)
            if trial.n > max(e.n for e, _ in best):
                continue  # more touches than any optimised plan: not at equal number
            try:
                trial.refresh()
            except ModelLimit:
                break
            ours = min((v for e, v in best if e.n <= trial.n), default=np.inf)
            out.append((name, trial.n, 1e3 * np.sqrt(goal.variances(trial)["c"]), 1e3 * np.sqrt(ours)))
    return out


def main() -> None:
    most = int(sys.argv[1]) if len(sys.argv) > 1 else 16
    print(
        f"{'feature':24s} {'plans compared':>14s} {'dominated':>10s} {'median gain':>12s} {'least gain':>11s}"
    )
    for case, (feature, what) in CASES.items():
        rows = compare(feature, what, most)
        gain = np.array([theirs / ours for _, _, theirs, ours in rows if np.isfinite(ours)])
        print(
            f"{case:24s} {len(gain):14d} {int((gain < 1 - 1e-6).sum()):10d} {np.median(gain):12.2f} {gain.min():11.3f}"
        )


if __name__ == "__main__":
    main()
