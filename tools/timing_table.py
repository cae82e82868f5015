"""Times of corners and of rows of short lines, as Markdown for docs/timing.md.

python tools/timing_table.py

F6000, axes with 3 m/s^2 and 50 m/s^3. The last column of the second table holds the time of exact stops at every joint for comparison.
"""

from __future__ import annotations

import math
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.program.limits import Control
from vcmm.program.moves import Move, Source
from vcmm.shop.motion.timing import plan_motion
from vcmm.shop.motion.toolpath import naive_seconds

FEED = 6000.0
STOPS, NARROW, USUAL, WIDE = 0.0, 0.001, 0.010, 0.100  # mm


def mill() -> Machine:
    dynamics = {"speed": 500.0, "acceleration": 3000.0, "jerk": 50_000.0}
    axes = {a: Axis(a, (-1e4, 1e4), dynamics=dynamics) for a in "XYZ"}
    return Machine("mill", "machine-tool", parse_structure("w X' Y' b Z t"), axes)


def lines(points: Array) -> list[Move]:
    return [
        Move("line", Source(1, 1, 1), tuple(a), tuple(b), feed=FEED) for a, b in pairwise(points.tolist())
    ]


def stairs(n: int, length: float) -> list[Move]:
    """n corners of 90 degrees between lines of that length."""
    steps = [length * np.eye(3)[k % 2] for k in range(n + 1)]
    return lines(np.cumsum([np.zeros(3), *steps], axis=0))


def zigzag(n: int, degrees: float, length: float) -> list[Move]:
    half = math.radians(degrees / 2)
    steps = [length * np.array([math.cos(half), math.sin(half) * (-1) ** k, 0.0]) for k in range(n + 1)]
    return lines(np.cumsum([np.zeros(3), *steps], axis=0))


def smooth_line(decimals: int) -> list[Move]:
    """500 steps of 0.2 mm along waves of 60 and 37 mm."""
    x = np.arange(501) * 0.2
    y, z = 5 * np.sin(2 * np.pi * x / 60), 0.5 * np.sin(2 * np.pi * x / 37)
    return lines(np.round(np.stack([x, y, z], axis=1), decimals))


def circle(decimals: int) -> list[Move]:
    """1000 chords of R 50."""
    angle = np.linspace(0, 2 * np.pi, 1001)
    return lines(np.round(50 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1), decimals))


def cam(decimals: int) -> list[Move]:
    """1800 chords of a cam: R 40 with three lifts of 6 mm."""
    angle = np.linspace(0, 2 * np.pi, 1801)
    reach = 40 + 6 * np.cos(3 * angle)
    return lines(
        np.round(np.stack([reach * np.cos(angle), reach * np.sin(angle), 0 * angle], axis=1), decimals)
    )


def superellipse(decimals: int) -> list[Move]:
    """1800 chords of |x / 60|^4 + |y / 35|^4 = 1, which has near corners."""
    angle = np.linspace(0, 2 * np.pi, 1801)
    x, y = (np.sign(v) * np.sqrt(np.abs(v)) for v in (np.cos(angle), np.sin(angle)))
    return lines(np.round(np.stack([60 * x, 35 * y, 0 * angle], axis=1), decimals))


def hump(decimals: int) -> list[Move]:
    """A row of 0.3 mm steps over a hump 4 mm high with waves of 0.8 mm: what a ball does on a mould."""
    x = np.arange(267) * 0.3
    z = 4 * np.exp(-(((x - 40) / 15) ** 2)) + 0.8 * np.cos(x / 6)
    return lines(np.round(np.stack([x, 0 * x, z], axis=1), decimals))


def seconds(moves: list[Move], tolerance: float) -> float:
    return plan_motion(moves, mill(), Control(tolerance=tolerance)).seconds


def main() -> None:
    print("| corners | stops | 1 um | 10 um | 100 um |\n|---|---|---|---|---|")
    corners = {
        "20 corners of 90 degrees, 50 mm": stairs(20, 50.0), "20 corners of 90 degrees, 5 mm": stairs(20, 5.0),
        "zigzag of 150 degrees, 10 mm": zigzag(20, 150, 10.0), "zigzag of 30 degrees, 10 mm": zigzag(20, 30, 10.0),
    }  # fmt: skip
    for name, moves in corners.items():
        print(
            f"| {name} | "
            + " | ".join(f"{seconds(moves, t):.2f} s" for t in (STOPS, NARROW, USUAL, WIDE))
            + " |"
        )
    print("\n| short lines, 10 um | length over feed | cycle time | ratio | stops |\n|---|---|---|---|---|")
    rows = {
        "500 steps of 0.2 mm, 3 decimals": smooth_line(3), "1000 chords of R 50, 3 decimals": circle(3), "the same, 5 decimals": circle(5),
        "cam of three lifts, 1800 chords, 3 decimals": cam(3), "superellipse, 1800 chords, 4 decimals": superellipse(4), "row over a hump, 266 steps of 0.3 mm, 3 decimals": hump(3),
    }  # fmt: skip
    for name, moves in rows.items():
        plain, timed = naive_seconds(plan_motion(moves, mill())), seconds(moves, USUAL)
        print(
            f"| {name} | {plain:.2f} s | {timed:.2f} s | {timed / plain:.2f} | {seconds(moves, STOPS):.2f} s |"
        )


if __name__ == "__main__":
    main()
