"""How often the 95 % bands of a calibration hold the truth: drawn machines, two complete designs, per curve and pooled.

python tools/calibrate_statistics.py 200 [laser|tracer|table|head] [--workers N | --cluster ADDRESS]
python tools/calibrate_statistics.py 100 design         # proposed designs against 1000 random ones of equal time each
python tools/calibrate_statistics.py 2000 speed         # seconds of processor and memory for so many lengths
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.learn.calibration import turning as rotary
from tests.learn.calibration.drawn import U, bare, draw, laser_and_plates, recorded, tracers, truth
from vcmm.core.crew import Crew, crew_of
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.learn.calibration.design import PlannedSetup, SetupPlan, best_within, plan_of
from vcmm.learn.calibration.job import calibrate
from vcmm.task.instruments.artefact import grid_of_balls, plate
from vcmm.task.instruments.laser import diagonal, six_d

DESIGNS = {"laser": laser_and_plates, "tracer": tracers}


def turning(machines: int, structure: str, axis: str, crew: Crew) -> None:
    """Shares inside the bands of the curves of a rotary axis, pooled."""
    inside = [share for one in in_order(crew, turned, (structure, axis), machines) for share in one]
    error = np.std(inside, ddof=1) / np.sqrt(len(inside))
    print(f"{axis} of {structure}: pooled over {machines} machines {np.mean(inside):.4f} +- {error:.4f}")


def turned(asked: tuple[str, str], seed: int) -> list[float]:
    """One machine: the share of each curve inside its band."""
    structure, axis = asked
    rng = np.random.default_rng([seed, 7])
    machine = rotary.draw(structure, axis, rng)
    meant = rotary.set_ups(rotary.bare(structure), axis)
    found = calibrate(
        rotary.recorded(machine, meant, rng), rotary.bare(structure), only=rotary.errors_of(axis)
    )
    inside = []
    for curve in found.kept_model.curves:
        nodes, value, u = found.band(curve.component)
        true = rotary.truth(machine, axis, nodes)[curve.component]
        inside.append(float((np.abs(value - true) < 1.96 * u).mean()))
    return inside


def in_order(crew: Crew, work: Any, payload: Any, machines: int) -> list[Any]:
    """Results of all seeds, whoever had them ready first."""
    found = dict(crew(work, payload, range(machines)))
    return [found[seed] for seed in range(machines)]


def designs(machines: int) -> None:
    """Share of machines on which the proposed design is within 5 % of the best of 1000 random ones."""
    gaps = []
    for seed in range(machines):
        rng = np.random.default_rng([seed, 3])
        plan, budget = random_plan(rng)
        proposed = plan.volume(best_within(plan, budget, seed))
        best = min(plan.volume(random_choice(plan, budget, rng)) for _ in range(1000))
        gaps.append(proposed / best - 1)
    good = float((np.array(gaps) <= 0.05).mean())
    print(f"designs: within 5 % of the best of 1000 random ones on {good:.1%} of {machines} machines")
    print(f"  median {np.median(gaps):+.1%}, worst {max(gaps):+.1%}")
    if good < 0.95:
        sys.exit("the search misses the bar of 95 %")


def random_plan(rng: np.random.Generator) -> tuple[SetupPlan, float]:
    """A machine of random travels with six-error lines on random lines, plates and body diagonals of random time, and a budget."""
    travel = {a: (0.0, float(rng.uniform(200, 1500))) for a in "XYZ"}
    axes = {a: Axis(a, t) for a, t in travel.items()}
    machine = Machine(
        "drawn", "cmm", parse_structure(rng.choice(["w b Y X Z t", "w X' b Y Z t", "w Y' X' b Z t"])), axes
    )
    setups = []
    for axis, (low, high) in travel.items():
        at = {a: float(rng.uniform(*t)) for a, t in travel.items()}
        tip = np.array([0.0, 0.0, -float(rng.uniform(50, 300))])
        for one in six_d(machine, axis, np.linspace(low, high, 11), at, tip, U):
            setups.append(PlannedSetup(one.name, (one,), float(rng.uniform(5, 30))))
    size = np.array([t[1] for t in travel.values()])
    for k, (i, j) in enumerate(((0, 1), (0, 2), (1, 2), (0, 1))):
        along, across = np.zeros(3), np.zeros(3)
        along[i], across[j] = 0.7 * size[i], 0.7 * size[j]
        corner = 0.1 * size
        corner[3 - i - j] = rng.uniform(0.1, 0.9) * size[3 - i - j]
        tip = np.array([0.0, 0.0, -float(rng.uniform(0, 200))])
        balls = grid_of_balls(corner + tip, along.tolist(), across.tolist(), (5, 4))
        setups.append(
            PlannedSetup(
                f"plate {k}",
                (plate(machine, balls, str(k), tip.tolist(), 0.4e-3),),
                float(rng.uniform(15, 60)),
            )
        )
    for k, flip in enumerate(((0, 0), (0, 1), (1, 0), (1, 1))):
        side = np.array([0, *flip])
        ends = (np.where(side, size, 0.0).tolist(), np.where(side, 0.0, size).tolist())
        setups.append(
            PlannedSetup(f"diagonal {k}", (diagonal(machine, ends, 9, 0.3e-3),), float(rng.uniform(10, 40)))
        )
    plan = plan_of(setups, machine)
    return plan, float(rng.uniform(0.2, 0.6) * plan.minutes.sum())


def random_choice(plan: SetupPlan, budget: float, rng: np.random.Generator) -> list[int]:
    """Set-ups in random order as long as there is time."""
    chosen, left = [], budget
    for i in rng.permutation(len(plan.names)):
        if plan.minutes[i] <= left:
            chosen.append(int(i))
            left -= plan.minutes[i]
    return chosen


def speed(lengths: int) -> None:
    """21 errors from lengths to a LaserTracer at six stations."""
    import resource

    rng = np.random.default_rng(0)
    step = round((lengths / 6) ** (1 / 3))
    read = recorded(draw(rng), tracers(bare(), step=step), rng)
    before, wall = time.process_time(), time.perf_counter()
    found = calibrate(read, bare())
    used, waited = time.process_time() - before, time.perf_counter() - wall
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(
        f"{sum(r.m for r in read)} lengths: {len(found.identified.names)} errors in {used:.1f} s of processor "
        f"({waited:.1f} s), {memory:.2f} GB"
    )


def measured(design: str, seed: int) -> dict[str, float]:
    """One machine: the share of each curve inside its band."""
    rng = np.random.default_rng([seed, len(design)])
    machine = draw(rng)
    found = calibrate(recorded(machine, DESIGNS[design](bare()), rng), bare())
    inside = {}
    for curve in found.kept_model.curves:
        nodes, value, u = found.band(curve.component)
        near = np.abs(value - truth(machine, curve.component, nodes)) < 1.96 * u
        inside[curve.component] = float(near.mean())
    return inside


def main(machines: int, design: str, crew: Crew) -> None:
    inside: dict[str, list[float]] = defaultdict(list)
    for one in in_order(crew, measured, design, machines):
        for name, share in one.items():
            inside[name].append(share)
    for name, shares in inside.items():
        print(f"{name} {np.mean(shares):.3f}")
    pooled = np.array(list(inside.values()))
    error = pooled.mean(axis=0).std(ddof=1) / np.sqrt(machines)
    print(f"{design}: pooled over {machines} machines {pooled.mean():.4f} +- {error:.4f}")
    if abs(pooled.mean() - 0.95) > 0.02 + 3 * error:
        sys.exit(f"{design}: the 95 % bands hold {pooled.mean():.1%} of the truth")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("machines", type=int, nargs="?", default=200)
    words = ["laser", "tracer", "table", "head", "design", "speed"]
    parser.add_argument("what", nargs="?", default="laser", choices=words)
    parser.add_argument("--workers", type=int, default=None)
    parser.add_argument("--cluster", default=None)
    given = parser.parse_args()
    count, what, workers = given.machines, given.what, crew_of(given.workers, given.cluster)
    if what == "design":
        designs(count)
    elif what == "speed":
        speed(count)
    elif what in ("table", "head"):
        turning(count, *((rotary.TABLE, "C") if what == "table" else (rotary.HEAD, "B")), workers)
    else:
        main(count, what, workers)
