"""How often the 95 % bands of a calibration hold the truth: drawn machines, two complete designs, per curve and pooled.

python tools/calibrate_statistics.py 200 [laser|tracer]
"""

from __future__ import annotations

import sys
from collections import defaultdict
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.calibrating.drawn import bare, draw, laser_and_plates, recorded, tracers, truth
from vcmm.calibrating.job import calibrate

DESIGNS = {"laser": laser_and_plates, "tracer": tracers}


def main(machines: int, design: str) -> None:
    inside: dict[str, list[float]] = defaultdict(list)
    for seed in range(machines):
        rng = np.random.default_rng([seed, len(design)])
        machine = draw(rng)
        found = calibrate(recorded(machine, DESIGNS[design](bare()), rng), bare())
        for curve in found.kept.curves:
            nodes, value, u = found.band(curve.component)
            inside[curve.component].append(
                float((np.abs(value - truth(machine, curve.component, nodes)) < 1.96 * u).mean())
            )
    for name, shares in inside.items():
        print(f"{name} {np.mean(shares):.3f}")
    pooled = np.array(list(inside.values()))
    error = pooled.mean(axis=0).std(ddof=1) / np.sqrt(machines)
    print(f"{design}: pooled over {machines} machines {pooled.mean():.4f} +- {error:.4f}")
    if abs(pooled.mean() - 0.95) > 0.02 + 3 * error:
        sys.exit(f"{design}: the 95 % bands hold {pooled.mean():.1%} of the truth")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200, sys.argv[2] if len(sys.argv) > 2 else "laser")
