"""Processor time and memory of evaluations: many points on a circle, scans, an audit, the plate and the demo's recipe.

    python benchmarks/bench_evaluate.py

Every case runs in a process of its own, imports included in its memory and not in its time; ratios are of the same run.
"""

from __future__ import annotations

import multiprocessing
import resource
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from vcmm.answer.evaluation.uncertainty import evaluate
from vcmm.answer.inference.audit import audit_task
from vcmm.files.own.library import example
from vcmm.files.own.scenario import load_scenario
from vcmm.part.part import Characteristic, Feature, Part
from vcmm.task.measuring.plan import Plan, Step
from vcmm.task.measuring.settings import Settings
from vcmm.task.measuring.strategies import Around, plan_points
from vcmm.task.measuring.task import Task

RING = Feature("ring", "circle", np.zeros(3), np.array([0.0, 0, 1]), np.array([15.0]), inside=True)
SIZE = Characteristic("diameter", "size", of=("ring",), limits=(-0.01, 0.01))
ROUND = Characteristic("roundness", "roundness", of=("ring",), zone=0.01)
SETTINGS = Settings(trials=24_000, certify=100)


def ring(n: int, c: Characteristic) -> Task:
    """n points on a ring in the machine of the plate."""
    plate = load_scenario(example("plate"))
    plan = Plan((Step("ring", "down", *plan_points(RING, Around(n))),), plate.plan.styli)
    return replace(plate, part=Part({"ring": RING}, (c,)), plan=plan).task()


def size_of(n: int) -> Callable[[], object]:
    task = ring(n, SIZE)
    return lambda: evaluate(task, SETTINGS)


def roundness_of(n: int) -> Callable[[], object]:
    task = ring(n, ROUND)
    return lambda: evaluate(task, SETTINGS)


def audit_of(c: Characteristic) -> Callable[[], object]:
    task = ring(25, c)
    return lambda: audit_task(task, SETTINGS, 2000)


def plate() -> Callable[[], object]:
    scenario = load_scenario(example("plate"))
    return lambda: evaluate(scenario.task(), scenario.settings)


CASES: dict[str, Callable[[], Callable[[], object]]] = {
    "circle of 1000 points, diameter": lambda: size_of(1000),
    "circle of 10 000 points, diameter": lambda: size_of(10_000),
    "circle of 100 000 points, diameter": lambda: size_of(100_000),
    "circle of 219 points, roundness by belts": lambda: roundness_of(219),
    "plate, 3 characteristics": plate,
    "audit of a roundness, 2000 parts x 6": lambda: audit_of(ROUND),
    "audit of a diameter, 2000 parts": lambda: audit_of(SIZE),
}


def one(name: str, out: multiprocessing.SimpleQueue[tuple[float, float]]) -> None:
    evaluate(ring(16, SIZE), replace(SETTINGS, trials=2000))  # loads the compiled kernels
    job = CASES[name]()
    start = time.process_time()
    job()
    out.put((time.process_time() - start, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024))


def measured(name: str) -> tuple[float, float]:
    """Processor time s, largest memory MB."""
    context = multiprocessing.get_context("spawn")
    out = context.SimpleQueue()
    process = context.Process(target=one, args=(name, out))
    process.start()
    found = out.get()
    process.join()
    return found


def main() -> None:
    print("| case | processor time | memory |\n|---|---|---|")
    found = {name: measured(name) for name in CASES}
    for name, (seconds, memory) in found.items():
        print(f"| {name} | {seconds:.2f} s | {memory:.0f} MB |", flush=True)
    few, many = (found[f"circle of {n} points, diameter"][0] for n in ("1000", "10 000"))
    print(f"10 000 points take {many / few:.1f} times the time of 1000")


if __name__ == "__main__":
    main()
