"""Interpolations on drawn machines: positions held out, error against the truth, the band, time. The table of docs/calibrate.md.

python tools/calibrate_interpolations.py 10
"""

from __future__ import annotations

import sys
from collections import defaultdict
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.learn.calibration.drawn import bare, draw, laser_and_plates, recorded, truth
from vcmm.learn.calibration.cross_validation import compare_interpolations
from vcmm.learn.calibration.interpolation import INTERPOLATIONS
from vcmm.learn.calibration.job import calibrate


def main(machines: int) -> None:
    rows: dict[str, list[tuple[float, ...]]] = defaultdict(list)
    for seed in range(machines):
        rng = np.random.default_rng([seed, 5])
        machine = draw(rng)
        readings = recorded(machine, laser_and_plates(bare()), rng)
        for held in compare_interpolations(readings, bare()):
            found = calibrate(readings, bare(), interpolation=held.name)
            inside, left = [], []
            for curve in found.kept_model.curves:
                nodes, value, u = found.band(curve.component)
                true = truth(machine, curve.component, nodes)
                inside.append(float((np.abs(value - true) < 1.96 * u).mean()))
                left.append(float(np.sqrt(((value - true) ** 2).mean() / (true**2).mean())))
            said = (held.rms_um or 0.0, held.rms_urad or 0.0, held.inside, held.nats)
            rows[held.name].append((*said, float(np.mean(left)), float(np.mean(inside)), held.seconds))
    print(
        "| interpolation | held out: lengths | angles | in the 95 % band | log score | left of a curve | band of the curves | time |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for name in INTERPOLATIONS:
        um, urad, inside, nats, left, band, seconds = np.mean(rows[name], axis=0)
        print(
            f"| `{name}` | {um:.2f} um | {urad:.2f} urad | {inside:.3f} | {nats:.2f} | {left:.1%} | {band:.3f} | {seconds:.1f} s |"
        )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10)
