"""Instruments on a mill: laser along lines (ISO 230-2), tracking interferometer at four stations, R-test on a table."""

from __future__ import annotations

import numpy as np

from benchmarks.exam.design import Design, motion_columns, room, unit
from benchmarks.exam.kinema import Array, Errors, tip
from benchmarks.exam.machines import MILL, TURNTABLE

AIR = ("temp_air_C", "temp_scale_x_C", "temp_scale_y_C", "temp_scale_z_C")


def laser(rng: np.random.Generator, rows: int = 600, rich: bool = True) -> Design:
    """Two lines per axis (other offset, instrument set up anew), two cycles both ways over 10 h. Poor: X, one line.

    In the default sense of a displacement, indicated - true, in which the catalogue states what an instrument reads."""
    lines = [(a, k) for k in (0, 1) for a in "XYZ"] if rich else [("X", 0)]
    cycles = 2
    per = max(rows // (len(lines) * cycles * 2), 8)
    parts, time = [], 0.0
    for number, (axis, which) in enumerate(lines):
        part, time = _line(rng, axis, which, per, cycles, time, number)
        parts.append(part)
        time += 2400.0
    stack = {k: np.concatenate([p[k] for p in parts]) for k in parts[0] if k != "labels"}
    labels = {w: [v for p in parts for v in p["labels"][w]] for w in ("setup", "run", "instrument")}
    q, n = stack["q"], len(stack["q"])
    speed, accel = stack["sense"] * 0.0, np.zeros((n, 3))
    columns = {"time_s": stack["time"]} | motion_columns(stack["sense"], stack["since"], speed, accel)
    columns |= {f"raw_{a}_mm": q[:, i] + 0.0091 * (i + 1) for i, a in enumerate("XYZ")}
    columns = {k: v for k, v in columns.items() if "accel" not in k and "speed" not in k}
    log = room(rng, float(stack["time"][-1]), AIR)
    t = log["time_s"]
    swell = rng.normal(0, 1, (3, 1)) * np.sin(
        2 * np.pi * t / np.array([[2.1e4], [3.7e4], [7e4]]) + rng.uniform(0, 6, (3, 1))
    )
    log["pressure_hPa"] = 1004.0 + 6.0 * swell.sum(axis=0)
    log["humidity_pct"] = 45.0 + 6.0 * np.sin(t / 9000.0 + rng.uniform(0, 6))
    return Design(
        "laser rich" if rich else "laser poor", MILL, "displacement", "indicated - true",
        {a: q[:, i] for i, a in enumerate("XYZ")}, stack["offset"], stack["normal"], columns, labels,
        {"zero": "setup"}, log, hidden={"way": stack["way"], "run": stack["run"]},
    )  # fmt: skip


def _line(rng: np.random.Generator, axis: str, which: int, per: int, cycles: int, time: float, number: int):
    i = "XYZ".index(axis)
    low, high = MILL.travel[axis]
    targets = np.linspace(low + 12, high - 12, per) + rng.uniform(-4, 4, per)
    order = np.concatenate([np.concatenate([targets, targets[::-1]]) for _ in range(cycles)])
    sense_one = np.concatenate([np.concatenate([np.ones(per), -np.ones(per)]) for _ in range(cycles)])
    n = len(order)
    other = np.array([[-80.0, 60.0, -60.0], [130.0, -120.0, -240.0]])[which]
    q = np.tile(other, (n, 1))
    q[:, i] = order
    offset = np.tile([[20.0, 0.0, -90.0], [-30.0, 25.0, -160.0]][which], (n, 1))
    sense = np.ones((n, 3))
    sense[:, i] = sense_one
    turned = np.where(sense_one > 0, targets.min() - 5.0, targets.max() + 5.0)
    since = np.full((n, 3), 30.0)
    since[:, i] = np.abs(order - turned)
    normal = np.zeros((n, 3))
    normal[:, i] = 1.0
    t = time + np.cumsum(rng.uniform(18, 30, n) * 600 / (6 * n))
    run = np.repeat(np.arange(cycles), 2 * per)
    labels = {
        "setup": [f"line{number}"] * n,
        "run": [f"l{number}c{r}" for r in run],
        "instrument": [f"laser{number}"] * n,
    }
    part = {"q": q, "offset": offset, "sense": sense, "since": since, "normal": normal, "time": t,
            "way": order - targets.min(), "run": run.astype(float) + 10 * number, "labels": labels}  # fmt: skip
    return part, float(t[-1])


def tracer(rng: np.random.Generator, rows: int = 520) -> Design:
    """Tracking interferometer at four places on the table: lengths to points all over the volume, both approaches."""
    stations = np.array([[-220, -180, -420], [240, -170, -400], [-200, 200, -410], [30, 20, -430.0]])
    stations = stations + rng.uniform(-15, 15, stations.shape)
    which = np.arange(rows) * 4 // rows
    grid = rng.uniform([-290, -240, -340], [290, 240, -10], (rows, 3))
    offset = np.array([[15.0, 0, -70], [-20, 10, -70], [0, 25, -150], [0, 0, -150]])[which]
    q = grid
    steps = np.diff(np.concatenate([q[:1] - 5.0, q]), axis=0)
    sense = np.sign(steps)
    place = q + offset
    normal = unit(place - stations[which])
    time = np.cumsum(rng.uniform(6, 14, rows)) + 2400.0 * which
    since = np.abs(steps)
    columns = {"time_s": time} | motion_columns(sense, since, 0 * sense, 0 * sense)
    columns = {k: v for k, v in columns.items() if "speed" not in k and "accel" not in k}
    columns |= {f"from_{a}_mm": stations[which][:, i] for i, a in enumerate("xyz")}
    labels = {"setup": [f"station{w}" for w in which]}
    return Design(
        "tracer rich", MILL, "length", "actual - commanded", {a: q[:, i] for i, a in enumerate("XYZ")}, offset, normal,
        columns, labels, {"station": "setup", "zero": "setup"}, room(rng, float(time[-1]), AIR),
        hidden={"station": stations[which]},
    )  # fmt: skip


def r_test(rng: np.random.Generator, rows: int = 300) -> Design:
    """Ball on the table followed by the tool while the table turns: x y z of the tip against the ball, four balls."""
    which = np.arange(rows) * 4 // rows
    ball = np.array([[120.0, 20.0, -250], [60.0, -20, -330], [-90, 80, -160], [150, -60, -290]])[which]
    c = np.concatenate(
        [np.linspace(-3.0, 3.0, rows // 4)[:: (-1) ** k] + rng.uniform(-0.1, 0.1) for k in range(4)]
    )
    offset = np.tile([0.0, 0.0, -110.0], (rows, 1))
    q = _follow(ball, c, offset)
    steps = np.diff(np.concatenate([q[:1] - 3.0, q]), axis=0)
    sense = np.where(steps == 0, 1.0, np.sign(steps))
    time = np.cumsum(rng.uniform(5, 9, rows)) + 600.0 * which
    columns = {"time_s": time} | {f"sense_{a}": sense[:, i] for i, a in enumerate("XYZ")}
    columns["sense_C"] = np.repeat([1.0, -1.0, 1.0, -1.0], rows // 4)
    labels = {"setup": [f"ball{w}" for w in which]}
    axes = {a: q[:, i] for i, a in enumerate("XYZ")} | {"C": c}
    return Design(
        "r-test rich", TURNTABLE, "displacement", "actual - commanded", axes, offset, None, columns, labels,
        {"centre": "setup"},
    )  # fmt: skip


def _follow(ball: Array, c: Array, offset: Array) -> Array:
    """X Y Z positions that hold the tip on the ball (n, 3), which is given in workpiece axes, at table angle c."""
    zero = {a: np.zeros(len(c)) for a in "XYZ"} | {"C": c}
    chain = TURNTABLE.chain
    here = tip(chain, zero, offset, Errors())
    basis = []
    for a in "XYZ":
        one = dict(zero)
        one[a] = np.ones(len(c))
        basis.append(tip(chain, one, offset, Errors()) - here)
    return np.linalg.solve(np.stack(basis, axis=2), (ball - here)[:, :, None])[:, :, 0]
