"""Forms that no catalogue of machine errors holds, and map mistakes (fixed coefficients)."""

from __future__ import annotations

import numpy as np

from benchmarks.exam.case import Concealed, Maker, unit_axis
from benchmarks.exam.concealed_axis import UM, pick
from benchmarks.exam.design import Design
from benchmarks.exam.foreign_time import TIME
from benchmarks.exam.kinema import Array
from benchmarks.exam.machines import Machine
from benchmarks.exam.observe import Hidden

Rng = np.random.Generator


def _shift(name: str, shape: Array, e: Array, covariates: tuple[str, ...]) -> Concealed:
    shape = shape / max(float(np.sqrt(np.mean(shape**2))), 1e-12)
    return Concealed(name, lambda k: Hidden(shift=k * UM * shape[:, None] * e), covariates=covariates)


def _e(rng: Rng) -> Array:
    return unit_axis(str(rng.choice(["X", "Y", "Z"])))


def chirp(d: Design, m: Machine, rng: Rng) -> Concealed:
    """A waviness whose period shrinks along the axis."""
    a = pick(rng, d)
    u = (d.q[a] - d.q[a].min()) / np.ptp(d.q[a])
    return _shift("chirp", np.sin(2 * np.pi * (2 * u + 5 * u**2) + rng.uniform(0, 6)), _e(rng), (a,))


def dust(d: Design, m: Machine, rng: Rng) -> Concealed:
    """A chip on the way: a sharp bump in one small zone of two axes."""
    a, b = (str(v) for v in rng.permutation([x for x in "XYZ" if np.ptp(d.q[x]) > 30])[:2])
    spot = int(rng.integers(0, d.rows))
    far = np.hypot((d.q[a] - d.q[a][spot]) / 60, (d.q[b] - d.q[b][spot]) / 60)
    return _shift("dust", np.exp(-(far**4)), _e(rng), (a, b))


def stairs(d: Design, m: Machine, rng: Rng) -> Concealed:
    """A scale glued from unequal pieces."""
    a = pick(rng, d)
    edges = np.sort(rng.uniform(d.q[a].min(), d.q[a].max(), 5))
    return _shift("stairs", rng.normal(0, 1, 6)[np.searchsorted(edges, d.q[a])], _e(rng), (a,))


def radial(d: Design, m: Machine, rng: Rng) -> Concealed:
    """A swirl about a point of the volume: turns with the distance from it."""
    p = d.nominal_tip()
    p = p - p.mean(axis=0) - rng.normal(0, 30, 3)
    r = np.linalg.norm(p[:, :2], axis=1)
    swirl = np.column_stack([-p[:, 1], p[:, 0], 0 * r]) * np.sin(r / 35)[:, None]
    swirl = swirl / np.sqrt(np.mean(swirl**2))
    return Concealed("radial", lambda k: Hidden(shift=k * UM * swirl), covariates=("X", "Y"))


def daily(d: Design, m: Machine, rng: Rng) -> Concealed:
    """A compressor that comes on every 41 minutes or so: a square wave of time."""
    t = d.columns["time_s"]
    period = rng.uniform(0.04, 0.11) * (t[-1] - t[0])
    return _shift("daily", np.sign(np.sin(2 * np.pi * t / period + rng.uniform(0, 6))), _e(rng), ("time",))


def hot_speed(d: Design, m: Machine, rng: Rng) -> Concealed:
    """An error that needs speed and place together."""
    a = pick(rng, d)
    v = np.linalg.norm(np.column_stack([d.columns[f"speed_{x}_mm_s"] for x in "XYZ"]), axis=1)
    u = (d.q[a] - d.q[a].mean()) / d.q[a].std()
    return _shift("hot_speed", np.sqrt(v) * np.cos(3.1 * u), _e(rng), ("speed", a))


def parity(d: Design, m: Machine, rng: Rng) -> Concealed:
    """Every other row differs: a double-buffered read-out."""
    three = np.arange(d.rows) % 3
    return _shift("parity", np.array([1.0, -0.4, -0.6])[three], _e(rng), ("row",))


def crossing(d: Design, m: Machine, rng: Rng) -> Concealed:
    """A ridge that runs across the axes: depends on X + 0.7 Y - 0.4 Z."""
    s = d.q["X"] + 0.7 * d.q["Y"] - 0.4 * d.q["Z"]
    return _shift(
        "crossing", np.tanh((s - np.median(s)) / 25) + 0.8 * np.sin(s / 21.0), _e(rng), ("X", "Y", "Z")
    )


def threshold(d: Design, m: Machine, rng: Rng) -> Concealed:
    """A relief valve: nothing below a temperature, a jump and a slope above."""
    t = d.get("temp_air_C")
    over = np.maximum(t - np.quantile(t, 0.6), 0)
    a = pick(rng, d)
    u = np.abs(d.q[a] - d.q[a].mean())
    return _shift("threshold", (over > 0) * (0.4 + over) * u, _e(rng), ("temp_air_C", a))


FOREIGN: dict[str, Maker] = {
    f.__name__: f for f in (chirp, dust, stairs, radial, daily, hot_speed, parity, crossing, threshold)
} | TIME


def mistake(d: Design, m: Machine, rng: Rng, what: str) -> Concealed:
    """The real machine holds an edit of the stored table: `what` is sign, missing, counted twice, unit, swapped."""
    a = str(rng.choice([x for x in d.machine.linear if np.ptp(d.q[x]) > 60]))
    i = int(rng.integers(0, 6))
    words = ("EX", "EY", "EZ", "EA", "EB", "EC")
    j = (i // 3) * 3 + (i % 3 + int(rng.integers(1, 3))) % 3
    stored = m.stored(a, d.q[a])
    six = np.zeros((d.rows, 6))
    factor = {
        "sign": -2.0,
        "missing": -1.0,
        "counted twice": 1.0,
        "unit": (25.4 if i < 3 else 4.84813681) - 1,
    }
    if what == "swapped":
        six[:, i], six[:, j] = stored[:, j] - stored[:, i], stored[:, i] - stored[:, j]
    else:
        six[:, i] = factor[what] * stored[:, i]
    text = f"swapped with {words[j]}{a}" if what == "swapped" else what
    also = (f"{words[j]}{a}:swapped with {words[i]}{a}",) if what == "swapped" else ()
    where = {"component": words[i] + a, "what": text}
    return Concealed("map_mistake", lambda k: Hidden(six={a: six}), where=where, covariates=(a,), also=also)
