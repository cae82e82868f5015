"""How often the search of `vcmm place` finds what ten times as many evaluations by other methods find.

    python tools/place_statistics.py [problems] [first]

Problems are drawn (tests/answer/placing/drawn.py): one to five freedoms, discrete turns in some. The search may use 5000
evaluations; the reference is the better of a dense Sobol scan of 25 000 poses and a differential evolution of 25 000
evaluations (together ten times the 5000), spread over the boxes of a fixture. The bar: within 0.1 % of the reference in 95 % of 200 problems.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tests.answer.placing.drawn import Problem, problem
from vcmm.answer.placing.search import CountedObjective, search

SCAN, EVOLUTION, BAR = 25_000, 26_000, 1e-3


def reference(one: Problem, seed: int, scan: int = SCAN, evolution: int = EVOLUTION) -> tuple[float, int]:
    """The lowest value that scan and evolution find, and the evaluations they used."""
    from scipy.optimize import differential_evolution
    from scipy.stats import qmc

    best, count = np.inf, 0
    for box in one.boxes:
        ask = CountedObjective(box, one.objective)
        for part in np.array_split(
            qmc.Sobol(box.d, seed=seed).random_base2(17)[: scan // len(one.boxes)], 20
        ):
            best = min(best, float(ask(part).min()))
        size = 15 * box.d
        rounds = max(1, evolution // len(one.boxes) // size - 1)
        found = differential_evolution(
            lambda x, ask=ask: ask(x.T), [(0.0, 1.0)] * box.d, popsize=15, maxiter=rounds, tol=0.0, seed=seed, polish=False,
            vectorized=True, updating="deferred",
        )  # fmt: skip
        best, count = min(best, float(found.fun)), count + ask.count
    return best, count


def main() -> None:
    problems = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    losses, most, others, begin = [], 0, [], time.perf_counter()
    for seed in range(first, first + problems):
        one = problem(seed)
        found = search(one.objective, one.boxes, evaluations=5000, seed=seed)
        best, count = reference(one, seed + 10_000)
        losses.append(found.value / best - 1)
        most, others = max(most, found.evaluations), [*others, count]
        print(
            f"problem {seed}: {one.boxes[0].d} freedoms, {len(one.boxes)} boxes, {found.evaluations} evaluations, "
            f"loss {losses[-1]:+.3%} against {count} evaluations; within the bar {np.mean(np.array(losses) <= BAR):.1%}",
            flush=True,
        )
    found_losses = np.array(losses)
    print(
        f"{problems} problems: within {BAR:.1%} of the reference in {np.mean(found_losses <= BAR):.1%}; worst loss {found_losses.max():.3%}; "
        f"at most {most} evaluations against {np.mean(others):.0f} on average; {time.perf_counter() - begin:.0f} s"
    )


if __name__ == "__main__":
    main()
