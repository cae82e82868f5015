"""Recordings with concealed effects, made by direct formulas and without a single line of vcmm/effects.

A bridge machine "w b Y X Z t" (tool-side axes only, so positions are those of the tip less its offset) touches balls
of an artefact in several poses. Shapes are off the grids of the dictionary: odd time constants and periods, a second
harmonic, a slight curvature; noise is a t law with 6 degrees of freedom.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.laws import StudentT
from vcmm.core.machine import Machine
from vcmm.core.run import Run, Series
from vcmm.task.response.recording import Recording

SIGMA = 0.7e-3  # mm, scale of the t law
NOISE = StudentT(SIGMA, 6.0)


def machine(*effects, inputs=()) -> Machine:
    axes = {a: Axis(a, (-1000.0, 1000.0)) for a in "XYZ"}
    return Machine("bridge", "cmm", parse_structure("w b Y X Z t"), axes, tuple(effects), tuple(inputs))


@dataclass(frozen=True)
class Design:
    """How a recording is made. Poor: one pose, one stylus, one speed, sides of one axis only."""

    n: int = 500
    poses: int = 5
    styli: int = 3
    speeds: tuple[float, ...] = (2.0, 5.0, 8.0)
    hours: float = 8.0
    preload_both: bool = True


RICH = Design()
POOR = Design(poses=1, styli=1, speeds=(5.0,), hours=2.0, preload_both=False)


def turn(rng: np.random.Generator) -> np.ndarray:
    """A random rotation about z and a tilt of up to 30 degrees."""
    a, t, b = rng.uniform(0, 2 * np.pi), rng.uniform(0, 0.5), rng.uniform(0, 2 * np.pi)

    def rz(w: float) -> np.ndarray:
        return np.array([[np.cos(w), -np.sin(w), 0], [np.sin(w), np.cos(w), 0], [0, 0, 1]])

    rx = np.array([[1, 0, 0], [0, np.cos(t), -np.sin(t)], [0, np.sin(t), np.cos(t)]])
    return rz(a) @ rx @ rz(b)


def make_run(design: Design, seed: int) -> tuple[Run, np.ndarray]:
    """Run and outward normals (n, 3)."""
    rng = np.random.default_rng([seed, 1])
    n = design.n
    pose = np.minimum(np.arange(n) * design.poses // n, design.poses - 1)
    balls = rng.uniform(-1, 1, (12, 3)) * [180, 150, 100]
    turns = [turn(rng) for _ in range(design.poses)]
    centre = rng.uniform([230, 200, -260], [370, 300, -180], (design.poses, 3))
    ball = rng.integers(0, 12, n)
    normal = rng.standard_normal((n, 3))
    normal[:, 2] = np.abs(normal[:, 2]) * rng.choice([1, -0.3], n)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    part = np.stack([turns[p] @ balls[b] for p, b in zip(pose, ball)])
    tip = part + centre[pose] + 10 * normal
    lengths = np.array([40.0, 75.0, 120.0])[: design.styli]
    stylus = rng.integers(0, design.styli, n)
    offset = np.zeros((n, 3))
    offset[:, 2] = -lengths[stylus] - 60
    offset[:, 0] = np.where(stylus == 2, 60.0, 0.0)
    time = np.sort(rng.uniform(0, design.hours * 3600, n))
    speed = rng.choice(design.speeds, n)
    sense = -np.sign(normal)
    if design.preload_both:  # the axes turn round before many touches
        sense = sense * rng.choice([1, -1], (n, 3), p=[0.6, 0.4])
    columns = {"time_s": time, "stylus_length_mm": lengths[stylus]}
    for i, a in enumerate("XYZ"):
        columns[f"sense_{a}"] = sense[:, i]
        columns[f"since_reversal_{a}_mm"] = rng.exponential(3.0, n) + 0.01
        columns[f"speed_{a}_mm_s"] = -normal[:, i] * speed
        columns[f"n{a.lower()}"] = normal[:, i]
        columns[f"part_{a.lower()}_mm"] = part[:, i]
    columns["probe_angle_rad"] = np.arctan2(normal[:, 1], normal[:, 0])
    columns["probe_lateral"] = np.hypot(normal[:, 0], normal[:, 1])
    series = temperatures(design.hours, rng)
    for name, log in series.items():
        columns[f"temp_{name}_C"] = np.interp(time, log.time, log.value)
    labels = {
        "pose": np.array([f"p{p}" for p in pose]),
        "stylus": np.array([f"s{s}" for s in stylus]),
        "event": np.array([f"e{k}" for k in (np.arange(n) * 9 // n)]),
    }
    position = {a: tip[:, i] - offset[:, i] for i, a in enumerate("XYZ")}
    return Run(position, offset, columns, labels, series), normal


def temperatures(hours: float, rng: np.random.Generator) -> dict[str, Series]:
    """Air swings with the day and the doors, the rest follows at its own pace."""
    time = np.arange(0, hours * 3600 + 300, 120.0)
    swing = 1.2 * np.sin(2 * np.pi * time / 14000 + rng.uniform(0, 6)) + 0.8 * np.sin(
        2 * np.pi * time / 5300 + rng.uniform(0, 6)
    )
    air = 20.5 + swing + 0.6 * (time > rng.uniform(0.3, 0.7) * time[-1])
    out = {"air": air}
    for i, (name, tau) in enumerate(
        (("scale_x", 2400.0), ("scale_y", 3300.0), ("scale_z", 4100.0), ("part", 6000.0))
    ):
        out[name] = follow(time, air, tau) + 0.3 * i + 0.4 * np.sin(2 * np.pi * time / (9000 + 2500 * i) + i)
    out["gradient"] = 0.4 * np.sin(2 * np.pi * time / 11000 + rng.uniform(0, 6)) + 0.2
    return {name: Series(time, value) for name, value in out.items()}


def follow(time: np.ndarray, value: np.ndarray, tau: float) -> np.ndarray:
    out, h = np.empty_like(value), time[1] - time[0]
    out[0] = value[0]
    for i in range(1, len(value)):
        out[i] = out[i - 1] + (value[i] - out[i - 1]) * (1 - np.exp(-h / tau))
    return out


@dataclass(frozen=True)
class Case:
    """recording; the concealed names with places; signal (n,); delta reached."""

    recording: Recording
    names: tuple[str, ...]
    where: tuple[str, ...]
    signal: np.ndarray
    amplitude: tuple[float, ...] = ()


def signal(name: str, run: Run, normal: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, str]:
    """(n,) indicated - true along n for an amplitude of the order of 1 um, and the place."""
    c, n = run.columns, run.n
    tip = np.stack([run.position[a] for a in "XYZ"], axis=1) + run.offset
    q = {a: run.position[a] for a in "XYZ"}
    axis = "XYZ"[rng.integers(3)]
    i = "XYZ".index(axis)
    ni, t = normal[:, i], c["time_s"]
    um = 1e-3
    if name == "backlash":
        return 0.5 * um * c[f"sense_{axis}"] * ni, axis
    if name == "lost_motion":
        return 0.5 * um * (0.3 + 0.02 * (q[axis] - q[axis].mean())) * c[f"sense_{axis}"] * ni, axis
    if name == "scale_factor":
        return -5e-6 * q[axis] * ni, axis
    if name == "squareness":
        pair = ("C0Y", "B0Z", "A0Z")[i]
        move = {"C0Y": (-q["Y"], 0), "B0Z": (q["Z"], 0), "A0Z": (-q["Z"], 1)}[pair]
        return -5e-6 * move[0] * normal[:, move[1]], pair
    if name == "thermal_drift":
        log = run.series["air"]
        warm = np.interp(t, log.time, follow(log.time, log.value, rng.uniform(500, 4000))) - 20
        return -um * warm * ni, axis.lower()
    if name == "linear_drift":
        return -um * t / 3600 * ni, axis.lower()
    if name == "step_change":
        t1 = np.quantile(t, rng.choice([0.3, 0.5, 0.7]) + rng.uniform(-0.06, 0.06))  # inside a placement
        return -um * (t > t1) * ni, axis.lower()
    if name == "probe_lobing":
        th, ph = c["probe_angle_rad"], rng.uniform(0, 2 * np.pi)
        return um * (np.cos(3 * th - ph) + 0.12 * np.cos(6 * th - 1.3 * ph)) * c["probe_lateral"] ** 1.1, ""
    if name == "tip_radius":
        return np.full(n, um), ""
    if name == "trigger_delay":
        v = sum(c[f"speed_{a}_mm_s"] * normal[:, j] for j, a in enumerate("XYZ"))
        return v * 2e-4, ""
    if name == "stylus_bending":
        return -um * (c["stylus_length_mm"] / 50) ** 3 * c["probe_lateral"] ** 2, ""
    if name == "screw_pitch":
        p = rng.uniform(6, 14)
        phase = 2 * np.pi * q[axis] / p + rng.uniform(0, 6)
        return -um * (np.sin(phase) + 0.15 * np.sin(2 * phase + 1)) * ni, axis
    if name == "scale_expansion":
        return -8e-6 * (c[f"temp_scale_{axis.lower()}_C"] - 20) * q[axis] * ni, axis
    if name == "part_expansion":
        p = np.stack([c[f"part_{a}_mm"] for a in "xyz"], axis=1)
        return 8e-6 * (c["temp_part_C"] - 20) * (p * normal).sum(axis=1), ""
    if name == "cross_axis_flexure":
        a, b, d = ("X", "Y", 2), ("Y", "Z", 0), ("Z", "X", 1)
        one, two, k = (a, b, d)[i]
        return -1e-8 * 20 * q[one] * q[two] * normal[:, k], f"{one}{two}"
    if name == "hysteresis":
        s = c[f"since_reversal_{axis}_mm"]
        return um * c[f"sense_{axis}"] * (1 - 2 * np.exp(-s / rng.uniform(1.5, 4.0))) * ni, axis
    if name == "reindexing":
        shift = rng.standard_normal((9, 3)) * um
        code = np.array([int(e[1:]) for e in run.labels["event"]])
        return -(shift[code] * normal).sum(axis=1), ""
    if name == "gradient_bending":
        j = (2, 2, 0)[i]
        arm = tip - 0
        g = c["temp_gradient_C"] * 1e-8
        bow = g * q[axis] ** 2
        slope = 2 * g * q[axis]
        e = np.zeros((n, 3))
        e[:, j] += bow
        about = np.cross(np.eye(3)[i], np.eye(3)[j])
        at = {
            "X": run.offset + np.stack([0 * t, 0 * t, q["Z"]], 1),
            "Y": arm - np.stack([0 * t, q["Y"], 0 * t], 1),
            "Z": run.offset,
        }[axis]
        e += slope[:, None] * np.cross(about, at)
        return -(e * normal).sum(axis=1), axis
    if name == "tip_form":
        x, y, z = normal.T
        return um * (x * y + 0.6 * (z**2 - 1 / 3) + 0.4 * x * z), ""
    if name == "geometric_change":
        s = (q[axis] - q[axis].min()) / np.ptp(q[axis])
        j = (2, 0, 1)[i]
        return -um * (np.sin(2.6 * s + 0.4) + 0.5 * s**3) * normal[:, j], f"E{'XYZ'[j]}{axis}"
    if name == "unknown_product":  # outside the catalogue: probe angle and height together
        z = (q["Z"] - q["Z"].mean()) / q["Z"].std()
        return um * np.cos(5 * c["probe_angle_rad"] + 1) * z**2 * c["probe_lateral"], ""
    if name == "unknown_region":  # outside: a soft spot of the guide
        return -um * np.exp(-(((q["X"] - 320) / 60) ** 2) - ((q["Y"] - 260) / 70) ** 2) * normal[:, 2], ""
    if name == "unknown_rhythm":  # outside: the building's pumps
        return um * np.sign(np.sin(2 * np.pi * t / 1700)) * ni, ""
    raise KeyError(name)


NAMES = (
    "backlash", "lost_motion", "scale_factor", "squareness", "thermal_drift", "linear_drift", "step_change",
    "probe_lobing", "tip_radius", "trigger_delay", "stylus_bending", "screw_pitch", "scale_expansion",
    "part_expansion", "cross_axis_flexure", "hysteresis", "reindexing", "gradient_bending", "tip_form", "geometric_change",
)  # fmt: skip
OUTSIDE = ("unknown_product", "unknown_region", "unknown_rhythm")


def nuisance(run: Run, normal: np.ndarray) -> np.ndarray:
    """Columns of a rigid pose per placement and an offset per stylus, built here once more."""
    tip = np.stack([run.position[a] for a in "XYZ"], axis=1) + run.offset
    out = []
    for p in np.unique(run.labels["pose"]):
        use = (run.labels["pose"] == p)[:, None]
        out += [normal * use, np.cross(tip - tip.mean(axis=0), normal) * use / 100]
    for s in np.unique(run.labels["stylus"]):
        out.append(normal * (run.labels["stylus"] == s)[:, None])
    return np.concatenate(out, axis=1)


def size(values: np.ndarray, columns: np.ndarray) -> float:
    """delta: length after projection in units of the noise's standard deviation."""
    q, r, _ = np.linalg.svd(columns, full_matrices=False)
    q = q[:, r > 1e-9 * r[0]]
    return float(np.linalg.norm(values - q @ (q.T @ values))) / NOISE.u


def make(names: tuple[str, ...], delta: float, seed: int, design: Design = RICH, noise: str = "t6") -> Case:
    """A recording with the named effects concealed, each of size delta."""
    run, normal = make_run(design, seed)
    rng = np.random.default_rng([seed, 2])
    columns = nuisance(run, normal)
    total, where, factors = np.zeros(run.n), [], []
    for name in names:
        e, place = signal(name, run, normal, rng)
        factor = delta / max(size(e, columns), 1e-9) * rng.choice([-1, 1])
        total += factor * e
        where.append(place)
        factors.append(float(factor))
    value = total + columns @ (rng.standard_normal(columns.shape[1]) * 2e-3) + draw(noise, run, rng)
    n = run.n
    recording = Recording(
        "made", "probe", run, value, True, np.arange(n), normal, np.full(n, -1), None,
        {"rigid": "pose", "offset": "stylus"}, NOISE,
    )  # fmt: skip
    return Case(recording, names, tuple(where), total, tuple(factors))


def draw(noise: str, run: Run, rng: np.random.Generator) -> np.ndarray:
    n = run.n
    if noise == "t3":
        return rng.standard_t(3, n) * NOISE.u / np.sqrt(3)
    e = rng.standard_t(6, n) * SIGMA
    if noise == "outliers":
        bad = rng.random(n) < 0.02
        e[bad] += rng.choice([-1, 1], bad.sum()) * rng.uniform(5, 12, bad.sum()) * SIGMA
    if noise.startswith("ar"):
        rho = float(noise[2:])
        for i in range(1, n):
            e[i] = rho * e[i - 1] + np.sqrt(1 - rho**2) * e[i]
    if noise == "speed":
        v = np.linalg.norm(run.vector("speed_X_mm_s", "speed_Y_mm_s", "speed_Z_mm_s"), axis=1)
        e *= 0.6 + 0.16 * v
    return e
