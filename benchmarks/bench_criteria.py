"""Minimum-zone cylinders by exchange of contacts, in a batch, against a sequence of linear programs per fit (HiGHS).

    python benchmarks/bench_criteria.py [trials]

Both fit the same noisy cylinders (50 points, 1 um) from the same nominal start in the same run; the ratio is the
result, absolute times depend on the machine. Both must find the same zones.
"""

from __future__ import annotations

import sys

import numpy as np

from benchmarks.bench_fit import cylinder, timed
from tests.part.fit.lp_twin import sequential_lp
from vcmm.part.fit import FittedElement, associate

LOOP = 10  # fits of the slow way; scaled up


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 4_000
    rng = np.random.default_rng(1)
    points = cylinder(50, 20.0, 40.0, rng)
    trials = points + 1e-3 * rng.standard_normal((count, *points.shape))
    nominal = FittedElement(
        "cylinder", np.zeros(3), np.array([0.0, 0.0, 1.0]), np.array([20.0]), np.empty(0), np.empty((0, 3))
    )
    start = np.array([0.0, 0, 0, 0, 0, 1, 20])
    associate("cylinder", "C", trials[:2], nominal)  # loads the compiled kernels
    for criterion, word in (("C", "minimum zone"), ("N", "circumscribed"), ("X", "inscribed")):
        fast, found = timed(lambda c=criterion: associate("cylinder", c, trials, nominal, judged=False))  # type: ignore[misc]
        slow, by_lp = timed(
            lambda c=criterion: [sequential_lp("cylinder", c, p, start, trust=0.1) for p in trials[:LOOP]],  # type: ignore[misc]
            1,
        )
        level = np.abs(found.element.residuals).max(-1) if criterion == "C" else found.element.sizes[:, 0]
        other = [one[1] if criterion == "C" else one[0][6] for one in by_lp]
        apart = float(np.abs(level[:LOOP] - other).max())
        programs = sum(one[2] for one in by_lp) / LOOP
        print(
            f"cylinder of 50 points, {word}: {fast / count * 1e6:.0f} us, linear programs {slow / LOOP * 1e3:.0f} ms "
            f"({programs:.1f} programs): {slow / LOOP / (fast / count):.0f}x; one program each: "
            f"{slow / LOOP / programs / (fast / count):.0f}x; zones {apart * 1e6:.1g} nm apart"
        )


if __name__ == "__main__":
    main()
