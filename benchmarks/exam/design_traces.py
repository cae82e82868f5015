"""Ball-bar traces (both ways, two feeds, three planes) and servo traces of a contour with corners, on a mill."""

from __future__ import annotations

import numpy as np

from benchmarks.exam.design import Design, motion_columns
from benchmarks.exam.kinema import Array
from benchmarks.exam.machines import MILL

PLANES = {"XY": (0, 1), "YZ": (1, 2), "ZX": (2, 0)}


def ball_bar(rng: np.random.Generator, rows: int = 600, rich: bool = True) -> Design:
    """Radius 150 mm. Rich: CW and CCW, 500 and 2000 mm/min, circle in XY, half circles in YZ and ZX. Poor: one trace."""
    plans = []
    if rich:
        for plane in PLANES:
            share = 0.5 if plane == "XY" else 0.25
            plans += [
                (plane, way, feed, int(rows * share / 4)) for way in (1, -1) for feed in (500.0, 2000.0)
            ]
    else:
        plans = [("XY", 1, 1000.0, rows)]
    parts = [_arc(rng, *plan) for plan in plans]
    q, normal, sense, since, speed, accel, time = (np.concatenate([p[i] for p in parts]) for i in range(7))
    run = np.concatenate([np.full(len(p[0]), i) for i, p in enumerate(parts)])
    time = time + 120.0 * run + np.concatenate([[0.0], np.cumsum([p[6][-1] for p in parts])])[run]
    plane = [plans[r][0] for r in run]
    columns = {"time_s": time, "feed_mm_min": np.array([plans[r][2] for r in run])}
    columns |= motion_columns(sense, since, speed, accel)
    labels = {"setup": plane, "run": [f"r{r}" for r in run]}
    offset = np.tile([0.0, 0.0, -120.0], (len(q), 1))
    return Design(
        "ball-bar rich" if rich else "ball-bar poor", MILL, "path", "actual - commanded",
        {a: q[:, i] for i, a in enumerate("XYZ")}, offset, normal, columns, labels, {"centre": "setup"},
        hidden={"run": run.astype(float)},
    )  # fmt: skip


def _arc(rng: np.random.Generator, plane: str, way: int, feed: float, rows: int) -> tuple[Array, ...]:
    """Position, radial direction, sense, distance since reversal, speed, acceleration, time of one trace."""
    i, j = PLANES[plane]
    radius, centre = 150.0, np.array([10.0, -15.0, -160.0])
    angles = _angles(rng, rows, plane == "XY")
    angles = angles[::-1] if way < 0 else angles
    phi = {"XY": angles, "YZ": angles, "ZX": angles + np.pi / 2}[plane]
    radial, tangent, q = np.zeros((rows, 3)), np.zeros((rows, 3)), np.tile(centre, (rows, 1))
    radial[:, i], radial[:, j] = np.cos(phi), np.sin(phi)
    tangent[:, i], tangent[:, j] = -way * np.sin(phi), way * np.cos(phi)
    q = q + radius * radial
    v = feed / 60.0
    sense, since = np.ones((rows, 3)), np.full((rows, 3), 40.0)
    for axis in (i, j):
        sense[:, axis] = np.sign(tangent[:, axis])
        start = centre[axis] - sense[:, axis] * radius  # where this axis last turned round
        whole = np.abs(q[:, axis] - start)
        began = (
            abs(radial[0, axis] * radius + centre[axis] - q[0, axis]) + 15.0
        )  # run-in of the first stretch
        first = np.cumprod(sense[:, axis] == sense[0, axis]).astype(bool)
        since[:, axis] = np.where(first, np.minimum(whole, np.abs(q[:, axis] - q[0, axis]) + began), whole)
    accel = -(v**2) / radius * radial
    time = np.abs(phi - phi[0]) * radius / v
    return q, radial, sense, since, v * tangent, accel, time


def _angles(rng: np.random.Generator, rows: int, full: bool) -> Array:
    """Angles, denser within 8 deg of the quadrants."""
    span = 2 * np.pi if full else 0.98 * np.pi
    start = 0.2 if full else 0.01 * np.pi
    even = np.linspace(start, start + span, 4 * rows)
    near = np.abs((even + np.pi / 4) % (np.pi / 2) - np.pi / 4) < np.radians(8.0)
    weight = np.cumsum(np.where(near, 5.0, 1.0))
    picks = np.interp(np.linspace(weight[0], weight[-1], rows), weight, even)
    return picks + rng.uniform(0, 1e-4)


def servo(rng: np.random.Generator, rows: int = 600) -> Design:
    """Commanded and actual position of X and Y on straight moves with ramps, logged densely after each change."""
    moves = rows // 30
    start, t0 = np.zeros(2), 0.0
    out: list[tuple[Array, ...]] = []
    for k in range(moves):
        turn = rng.uniform(0, 2 * np.pi)
        if np.abs(start).max() > 150:
            turn = np.arctan2(-start[1], -start[0]) + rng.normal(0, 0.4)
        way, length = np.array([np.cos(turn), np.sin(turn)]), rng.uniform(25.0, 90.0)
        speed, acc = rng.choice([20.0, 60.0, 150.0, 300.0]), rng.choice([500.0, 1500.0, 3000.0])
        speed = min(speed, np.sqrt(0.8 * acc * length))
        t, s, v, a = _trapezoid(length, speed, acc)
        xy = start + s[:, None] * way
        out.append(
            (
                xy,
                v[:, None] * way,
                a[:, None] * way,
                t + t0,
                np.tile(np.sign(way), (len(t), 1)),
                np.full(len(t), k),
            )
        )
        start, t0 = start + length * way, t0 + t[-1] + rng.uniform(0.5, 1.5)
    xy, v, a, time, sense, run = (np.concatenate([o[i] for o in out]) for i in range(6))
    n = len(time)
    q = np.column_stack([xy, np.full(n, -150.0)])
    three = [np.column_stack([w, np.zeros(n)]) for w in (v, a)]
    sense3 = np.column_stack([sense, np.ones(n)])
    since = _since(q, sense3)
    columns = {"time_s": time} | motion_columns(sense3, since, three[0], three[1])
    return Design(
        "servo rich", MILL, "path", "actual - commanded", {c: q[:, i] for i, c in enumerate("XYZ")},
        np.tile([0.0, 0.0, -80.0], (n, 1)), None, columns, {"run": [f"m{int(r)}" for r in run]}, {"centre": ""},
        hidden={"run": run.astype(float)},
    )  # fmt: skip


def _since(q: Array, sense: Array) -> Array:
    out = np.zeros(q.shape)
    out[0] = 10.0
    for i in range(1, len(q)):
        same = sense[i] == sense[i - 1]
        out[i] = np.where(same, out[i - 1], 0.0) + np.abs(q[i] - q[i - 1])
    return out


def _trapezoid(length: float, speed: float, acc: float) -> tuple[Array, Array, Array, Array]:
    """Time, way, speed, acceleration at 30 instants: ten in each of ramp, cruise and ramp, bunched at their start."""
    ramp = speed / acc
    cruise = (length - speed * ramp) / speed
    bunch = np.linspace(0.02, 0.98, 10) ** 1.6
    t = np.concatenate([ramp * bunch, ramp + min(cruise, 0.25) * bunch, ramp + cruise + ramp * bunch])
    phase = np.searchsorted([ramp, ramp + cruise], t, side="right")
    late = t - ramp - cruise
    s = np.select(
        [phase == 0, phase == 1], [0.5 * acc * t**2, 0.5 * speed * ramp + speed * (t - ramp)],
        0.5 * speed * ramp + speed * cruise + speed * late - 0.5 * acc * late**2,
    )  # fmt: skip
    v = np.select([phase == 0, phase == 1], [acc * t, np.full(len(t), speed)], speed - acc * late)
    return t, s, v, np.select([phase == 0, phase == 1], [acc, 0.0], -acc) + 0.0 * t
