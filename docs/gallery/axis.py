"""Writes axis.csv: a laser along X of a machine that is 9 um/m too long, winds once in 300 mm by 1.2 um and has 2.4 um of reversal.

Eleven targets, five runs in both directions (ISO 230-2); the scatter of 0.4 um is drawn with seed 1. Synthetic: no machine was measured.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

TARGETS, RUNS = np.linspace(0.0, 500.0, 11), 5


def main() -> None:
    rng = np.random.default_rng(1)
    rows = ["X_mm,Y_mm,Z_mm,sense_X,nx,ny,nz,d_um"]
    for _ in range(RUNS):
        for way, places in ((1, TARGETS), (-1, TARGETS[::-1])):
            for q in places:
                d = 9e-3 * q + 1.2 * np.sin(2 * np.pi * q / 300.0) - 1.2 * way + 0.4 * rng.standard_normal()
                rows.append(f"{q:g},0,0,{way},1,0,0,{d:.2f}")
    Path(__file__).with_suffix(".csv").write_text("\n".join(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
