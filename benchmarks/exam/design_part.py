"""A machined part, inspected afterwards: walls cut by three tools over six hours, with forces, wear and spindle logs."""

from __future__ import annotations

import numpy as np

from benchmarks.exam.design import Design, motion_columns, room, unit
from benchmarks.exam.machines import MILL

TOOLS = ((10.0, 80.0), (6.0, 55.0), (4.0, 100.0))  # radius, length mm
SENSORS = (
    "temp_spindle_C",
    "temp_scale_x_C",
    "temp_scale_y_C",
    "temp_scale_z_C",
    "temp_air_C",
    "temp_part_C",
)


def machined(rng: np.random.Generator, rows: int = 500, rich: bool = True) -> Design:
    """Side walls, pockets and floors; climb and conventional cuts, three feeds, two speeds, tools changed in turn."""
    block = np.arange(rows) * 15 // rows  # cuts
    tool = block % 3 if rich else np.zeros(rows, dtype=int)
    kind = rng.permutation(15)[block] % 3  # outer wall, pocket wall, floor
    angle = rng.uniform(0, 2 * np.pi, rows)
    wall = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(rows)])
    floor = np.tile([0.0, 0.0, 1.0], (rows, 1))
    normal = np.where((kind == 2)[:, None], floor, np.where((kind == 1)[:, None], -wall, wall))
    reach = np.array([[180.0, 150.0], [90.0, 70.0], [60.0, 60.0]])[kind] * rng.uniform(0.75, 1.0, (rows, 1))
    spot = np.column_stack([wall[:, :2] * reach, rng.uniform(-60, -5, rows) - 200.0])
    radius, length = (np.array([TOOLS[t][k] for t in tool]) for k in (0, 1))
    centre = spot + np.where((kind == 2)[:, None], 0.0, radius[:, None] * normal)
    offset = np.column_stack([np.zeros((rows, 2)), -length])
    q = centre - offset
    way = np.where(np.array([1.0, -1.0])[block % 2][:, None] > 0, 1.0, -1.0) * unit(
        np.cross(np.array([0.0, 0, 1.0]), wall)
    )
    feed = rng.choice([300.0, 800.0, 2000.0], 15)[block] if rich else np.full(rows, 800.0)
    rpm = np.array([6000.0, 0.0, 12000.0, 9000.0])[np.searchsorted([3, 5, 10], block, side="right")]
    rpm = np.where(rpm == 0, 3000.0, rpm) if rich else np.full(rows, 8000.0)
    time = np.cumsum(rng.uniform(25, 45, rows)) + 240.0 * block
    cut = np.zeros(rows)
    for t in range(3):
        mine = tool == t
        cut[mine] = np.cumsum(rng.uniform(40, 160, int(mine.sum())))
    load = rng.uniform(0.3, 1.0, rows) * np.array([1.0, 0.4, 0.15])[rng.integers(0, 3, rows)]
    force = load[:, None] * (60.0 * normal + 35.0 * way + rng.normal(0, 6.0, (rows, 3)))
    steps = np.diff(np.concatenate([q[:1] - 3.0, q]), axis=0)
    sense = np.where(np.abs(way) > 0.02, np.sign(way), np.sign(steps))
    columns = {
        "time_s": time, "cut_length_mm": cut, "spindle_rpm": rpm, "spindle_angle_deg": rng.uniform(0, 360, rows),
        "tool_radius_mm": radius, "tool_length_mm": length, "feed_mm_min": feed, "chip_load_mm": load * 0.08,
    }  # fmt: skip
    columns |= {f"force_{a}_N": force[:, i] for i, a in enumerate("xyz")}
    motion = motion_columns(sense, np.full((rows, 3), 20.0), feed[:, None] / 60 * way, np.zeros((rows, 3)))
    columns |= {k: v for k, v in motion.items() if k.startswith(("sense", "speed"))}
    labels = {
        "tool": [f"t{t}" for t in tool],
        "part": ["block"] * rows,
        "feature": [f"cut{b}" for b in block],
    }
    return Design(
        "part rich" if rich else "part poor", MILL, "path", "actual - commanded",
        {a: q[:, i] for i, a in enumerate("XYZ")}, offset, normal, columns, labels, {"alignment": "part"},
        room(rng, float(time[-1]), SENSORS),
    )  # fmt: skip
