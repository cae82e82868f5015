"""Batched least-squares fits against the per-trial loop that everybody writes first (scipy.optimize.least_squares).

    python benchmarks/bench_fit.py [trials]

Both fit the same noisy cylinders (50 points, 1 um) from the same nominal start in the same run; the ratio is the
result, absolute times depend on the machine.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from vcmm.part.fit import FittedElement, gauss, linear_fit, sensitivity

Array = NDArray[np.float64]
T = TypeVar("T")
LOOP = 200  # trials of the slow loop; scaled up


def cylinder(n: int, radius: float, length: float, rng: np.random.Generator) -> Array:
    """Nominal points (n, 3) about the z axis."""
    turn, z = rng.uniform(0.0, 2.0 * np.pi, n), rng.uniform(-0.5, 0.5, n) * length
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=1)


def fit_by_loop(trials: Array, nominal: FittedElement) -> Array:
    """Radius of each trial by least_squares (MINPACK, its default differences and tolerances), axis near z."""
    from scipy.optimize import least_squares

    def distances(p: Array, points: Array) -> Array:
        axis = np.array([p[2], p[3], 1.0]) / np.sqrt(1.0 + p[2] ** 2 + p[3] ** 2)
        return np.asarray(np.linalg.norm(np.cross(points - [p[0], p[1], 0.0], axis), axis=1) - p[4])

    begin = np.array([*nominal.point[:2], 0.0, 0.0, nominal.sizes[0]])
    return np.array([least_squares(distances, begin, method="lm", args=(points,)).x[4] for points in trials])


def timed(call: Callable[[], T], repeats: int = 3) -> tuple[float, T]:
    """Best time in s of a few calls, and the last answer."""
    best = np.inf
    for _ in range(repeats):
        begin = time.perf_counter()
        answer = call()
        best = min(best, time.perf_counter() - begin)
    return best, answer


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    rng = np.random.default_rng(1)
    points = cylinder(50, 20.0, 40.0, rng)
    noise = 1e-3 * rng.standard_normal((count, *points.shape))
    trials, nominal = points + noise, gauss("cylinder", points)
    batched, fit = timed(lambda: gauss("cylinder", trials, nominal))
    operator, linear = timed(lambda: linear_fit(nominal, sensitivity(nominal, points), noise))
    fit_by_loop(trials[:2], nominal)  # imports scipy outside the clock
    loop, radii = timed(lambda: fit_by_loop(trials[:LOOP], nominal), 1)
    loop *= count / min(LOOP, count)
    print(f"cylinder, {count} trials x 50 points")
    print(f"  gauss, batched          {batched:9.3f} s  {1e6 * batched / count:9.1f} us/fit")
    print(f"  linear_fit, with its set-up {operator:5.3f} s  {1e6 * operator / count:9.1f} us/fit")
    print(f"  least_squares loop      {loop:9.3f} s  {1e6 * loop / count:9.1f} us/fit  (from {LOOP} trials)")
    print(f"  ratio loop / gauss      {loop / batched:9.0f}")
    print(f"  same radius within      {np.max(np.abs(fit.sizes[:LOOP, 0] - radii)) * 1e6:9.2g} nm")
    print(f"  linear radius within    {np.max(np.abs(fit.sizes - linear.sizes)) * 1e6:9.2g} nm")


if __name__ == "__main__":
    main()
