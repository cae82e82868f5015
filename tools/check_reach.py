"""Constraint violations in random checks against tests written without the code under test.

    python tools/check_reach.py [capsules] [poses]

Capsules: a moving shaft that is called clear of a block with a bore is sampled densely. Poses: a whole tool (shaft, extension,
head, quill; two styli, clamp, table, travels) that is called feasible is sampled at every touch. Prints the counts.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from tests.answer.placing.placing_independent import compare  # noqa: E402
from tests.answer.placing.test_collision import random_checks  # noqa: E402


def main() -> None:
    capsules, poses = (int(a) for a in (sys.argv[1:] + ["10000", "10000"][len(sys.argv) - 1 :]))
    begin = time.perf_counter()
    totals = [0, 0, 0]
    for seed in range(max(1, capsules // 1000)):
        totals = [a + b for a, b in zip(totals, random_checks(1000, 100 + seed))]
    print(
        f"shafts: {totals[0]} called clear, {totals[1]} not, {totals[2]} called clear in error ({time.perf_counter() - begin:.0f} s)"
    )
    begin = time.perf_counter()
    feasible, infeasible, wrong = compare(poses, seed=2026)
    print(
        f"poses: {feasible} called feasible, {infeasible} not, {wrong} called feasible in error ({time.perf_counter() - begin:.0f} s)"
    )


if __name__ == "__main__":
    main()
