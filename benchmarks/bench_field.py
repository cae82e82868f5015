"""Tip error of 10^6 rows, first order and exact, in one run: python benchmarks/bench_field.py"""

from __future__ import annotations

import time

import numpy as np

from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.physics.structure.component import ComponentTable
from vcmm.physics.structure.squareness import Squareness

ROWS = 1_000_000


def machine() -> Machine:
    """18 component tables of 25 nodes and three squareness errors."""
    rng = np.random.default_rng(1)
    grid = np.linspace(0.0, 1000.0, 25)
    effects = [
        ComponentTable(f"E{d}{a}", (a,), (grid,), rng.normal(size=25) * (2e-3 if d in "XYZ" else 1e-5))
        for a in "XYZ"
        for d in "XYZABC"
    ]
    effects += [Squareness(p, 1e-5) for p in ("C0Y", "B0Z", "A0Z")]
    axes = {a: Axis(a, (0.0, 1000.0)) for a in "XYZ"}
    return Machine("bench", "cmm", parse_structure("w b Y X Z t"), axes, tuple(effects))


def main() -> None:
    rng = np.random.default_rng(2)
    run = Run({a: rng.uniform(0, 1000, ROWS) for a in "XYZ"}, np.tile([0.0, 0.0, -150.0], (ROWS, 1)))
    tested = machine()
    start = time.perf_counter()
    linear = tested.tip_error(run)
    first = time.perf_counter() - start
    start = time.perf_counter()
    exact = tested.tip_error(run.take(slice(0, 100_000)), exact=True)
    second = (time.perf_counter() - start) * 10
    worst = np.abs(linear[:100_000] - exact).max() * 1e6
    print(f"first order  {first:6.2f} s for 10^6 rows (bar: 3 s)")
    print(f"exact        {second:6.2f} s for 10^6 rows (from 10^5), ratio {second / first:.1f}")
    print(f"largest difference {worst:.2f} nm")


if __name__ == "__main__":
    main()
