"""Forces across a wall while an edge makes it, beside the mean of a turn, as Markdown for docs/tooth_forces.md.

python tools/tooth_forces.py
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from vcmm.core.laws import Array
from vcmm.program.setup import linear_edge
from vcmm.shop.cutting.force import milling_force
from vcmm.shop.cutting.tooth_force import ToothCuts

RADIUS, DEPTH, CHIP, TEETH, RADIAL = 10.0, 10.0, 0.1, 3, 2.0
HEIGHTS = (0.0, 2.5, 5.0, 7.5, 10.0)


def engagement(climb: bool) -> tuple[Array, Array]:
    """Angles (1,) at which an edge enters and leaves, rad: it enters or leaves the blank RADIAL from the wall."""
    angle = np.arccos(1.0 - np.array([RADIAL]) / RADIUS)
    return (np.pi - angle, np.full_like(angle, np.pi)) if climb else (np.zeros_like(angle), angle)


def across(helix: float, climb: bool) -> list[float]:
    """N away from the wall at HEIGHTS over the tip; helix deg."""
    start, exit_ = engagement(climb)
    one = np.ones(1)
    lag = math.tan(math.radians(helix)) / RADIUS * one
    cuts = ToothCuts(start, exit_, DEPTH * one, CHIP * one, np.array([TEETH]), lag, linear_edge("Al7075"))
    angle, sign = (math.pi, 1.0) if climb else (0.0, -1.0)
    return [sign * float(cuts.generating(np.array([angle]), np.array([z]))[0, 1]) for z in HEIGHTS]


def main() -> None:
    print(
        f"| cut | helix | {' | '.join(f'{z:g} mm' for z in HEIGHTS)} | mean of a turn |\n|---|---|{'---|' * 6}"
    )
    for climb in (True, False):
        start, exit_ = engagement(climb)
        one = np.ones(1)
        mean = float(
            milling_force(start, exit_, DEPTH * one, CHIP * one, TEETH * one, linear_edge("Al7075"))[0, 1]
        )
        for helix in (0.0, 15.0, 30.0, 45.0):
            cells = " | ".join(f"{v + 0.0:.0f}" for v in across(helix, climb))
            kind = "climb" if climb else "conventional"
            print(f"| {kind} | {helix:g} deg | {cells} | {mean if climb else -mean:.0f} N |")


if __name__ == "__main__":
    main()
