"""Concealed effects of temperature and time."""

from __future__ import annotations

import numpy as np

from benchmarks.exam.case import Concealed, Maker, unit_axis
from benchmarks.exam.concealed_axis import UM, pick
from benchmarks.exam.design import Design
from benchmarks.exam.kinema import Array
from benchmarks.exam.machines import Machine
from benchmarks.exam.observe import Hidden

Rng = np.random.Generator


def _way(rng: Rng) -> tuple[str, Array]:
    letter = str(rng.choice(["X", "Y", "Z"]))
    return letter, unit_axis(letter)


def scale_expansion(d: Design, m: Machine, rng: Rng) -> Concealed:
    a = pick(rng, d)
    warm = d.get(f"temp_scale_{a.lower()}_C") - 20.0
    return Concealed("scale_expansion", lambda k: Hidden(actual={a: k * 1e-6 * warm * d.q[a]}),
                     lambda k: {"alpha": (k, "um/(m K)")}, {"axis": a}, ("temp_scale_" + a.lower(),), 8.0)  # fmt: skip


def part_expansion(d: Design, m: Machine, rng: Rng) -> Concealed:
    """The ball plate grows about its middle, in its own frame: every ball is elsewhere."""
    warm = (d.get("temp_part_C") - 20.0)[:, None]
    grown = np.einsum("nij,nj->ni", d.hidden["turns"], d.hidden["part_frame"])
    along = (grown * d.normal).sum(axis=1)[:, None]
    return Concealed("part_expansion", lambda k: Hidden(reading=(k * 1e-6 * warm * along)[:, 0]),
                     lambda k: {"alpha": (k, "um/(m K)")}, {}, ("temp_part_C",), 8.0)  # fmt: skip


def lagged(t: Array, temperature: Array, tau: float, bend: float = 0.15) -> Array:
    """A lag filter whose time constant falls with the difference (free convection): Heun's method on the log's clock."""
    out = np.empty(len(t))
    out[0] = temperature[0]

    def rate(x: float, u: float) -> float:
        return (u - x) / tau * (1 + bend * abs(u - x)) ** 0.25

    for i in range(1, len(t)):
        h = t[i] - t[i - 1]
        first = rate(out[i - 1], temperature[i - 1])
        out[i] = out[i - 1] + h / 2 * (first + rate(out[i - 1] + h * first, temperature[i]))
    return out


def thermal_drift(d: Design, m: Machine, rng: Rng) -> Concealed:
    letter, e = _way(rng)
    sensor = "temp_air_C"
    tau = float(np.exp(rng.uniform(np.log(600), np.log(6000))))
    log = lagged(d.series["time_s"], d.series[sensor], tau)
    value = np.interp(d.columns["time_s"], d.series["time_s"], log) - 20.0
    return Concealed("thermal_drift", lambda k: Hidden(shift=k * UM * value[:, None] * e), lambda k: {"k": (k, "um/K")},
                     {"direction": letter.lower()}, ("time", sensor), 5.0)  # fmt: skip


def linear_drift(d: Design, m: Machine, rng: Rng) -> Concealed:
    letter, e = _way(rng)
    s = rng.choice([-1.0, 1.0])
    hours = d.columns["time_s"] / 3600
    return Concealed("linear_drift", lambda k: Hidden(shift=s * k * UM * hours[:, None] * e),
                     lambda k: {"c": (s * k, "um/h")}, {"direction": letter.lower()}, ("time",), 5.0)  # fmt: skip


def step_change(d: Design, m: Machine, rng: Rng) -> Concealed:
    """A slip within a few seconds, somewhere between 15 and 85 % of one placement."""
    letter, e = _way(rng)
    s, t = rng.choice([-1.0, 1.0]), d.columns["time_s"]
    group = d.codes("pose") if "pose" in d.labels else np.zeros(d.rows, dtype=int)
    inside = t[group == rng.choice(np.unique(group))]
    t1 = float(np.quantile(inside, rng.uniform(0.25, 0.75)))
    on = 1.0 / (1.0 + np.exp(-np.clip((t - t1) / 3.0, -50, 50)))
    return Concealed("step_change", lambda k: Hidden(shift=s * k * UM * on[:, None] * e),
                     lambda k: {"a": (s * k, "um"), "t1": (t1, "s")}, {"direction": letter.lower()}, ("time",), 4.0)  # fmt: skip


def reindexing(d: Design, m: Machine, rng: Rng) -> Concealed:
    """The head comes back a little elsewhere at each change: bounded, not normal."""
    codes = d.codes("event")
    jumps = rng.uniform(-1.73, 1.73, (codes.max() + 1, 3))
    return Concealed(
        "reindexing", lambda k: Hidden(shift=k * UM * jumps[codes]), where={}, covariates=("event",)
    )


def gradient_bending(d: Design, m: Machine, rng: Rng) -> Concealed:
    """A beam under a gradient is a circle: deflection and pitch of the carriage from the exact arc. Level at the zero of
    the axis in half of the cases, at the middle of its travel in the other half."""
    a = str(rng.choice([x for x in "XY" if x in d.q]))
    middle = bool(rng.integers(0, 2))
    grad, q = d.get("temp_gradient_C"), d.q[a] - middle * np.mean(d.machine.travel[a])
    i = "XYZ".index(a)

    def build(k: float) -> Hidden:
        bend = k * 1e-9 * grad * 2  # 1/radius, 1/mm
        safe = np.where(np.abs(bend) < 1e-15, 1e-15, bend)
        six = np.zeros((d.rows, 6))
        six[:, 2] = (1 - np.cos(safe * q)) / safe
        nose_up = -1.0 if i == 0 else 1.0  # slope of z along the axis: -B for X, +A for Y
        six[:, 3 + (1 - i)] = nose_up * safe * q
        return Hidden(six={a: six})

    return Concealed(
        "gradient_bending",
        build,
        lambda k: {} if middle else {"k": (k, "um/(m^2 K)")},
        where={"axis": a},
        covariates=("temp_gradient_C", a),
        start=10.0,
        note="level at mid-travel" if middle else "level at the zero of the axis",
    )


def spindle_growth(d: Design, m: Machine, rng: Rng) -> Concealed:
    """The spindle grows after each change of speed towards its own end value (speed^1.3), the tool moves out (-z)."""
    t, rpm = d.columns["time_s"], d.columns["spindle_rpm"]
    tau, target = rng.uniform(600, 2400), (rpm / 12000.0) ** 1.3
    state = np.zeros(d.rows)
    for i in range(1, d.rows):
        state[i] = target[i] + (state[i - 1] - target[i]) * np.exp(-(t[i] - t[i - 1]) / tau)
    e = np.array([0.0, 0.0, -1.0])
    return Concealed("spindle_growth", lambda k: Hidden(shift=k * UM * state[:, None] * e), where={},
                     covariates=("time", "spindle"), start=10.0)  # fmt: skip


def screw_heating(d: Design, m: Machine, rng: Rng) -> Concealed:
    """The screw stretches as its nut runs over it and saturates: expansion about its fixed end, reset by long rests."""
    a = pick(rng, d)
    way = np.zeros(d.rows)
    for i in range(1, d.rows):
        rest = d.columns["time_s"][i] - d.columns["time_s"][i - 1]
        way[i] = way[i - 1] * np.exp(-rest / 5400.0) + abs(d.q[a][i] - d.q[a][i - 1]) / 1000.0
    heat = way / (1 + 0.1 * way)
    from_end = d.q[a] - d.machine.travel[a][0]
    return Concealed("screw_heating", lambda k: Hidden(actual={a: k * 1e-6 * heat * from_end}), where={"axis": a},
                     covariates=("travel", a), start=5.0)  # fmt: skip


def workpiece_heating(d: Design, m: Machine, rng: Rng) -> Concealed:
    """Heat of cutting, slowly lost: the part was warm when cut, and is short by k t p after cooling."""
    hours = (d.columns["time_s"] - d.columns["time_s"][0]) / 3600
    place = d.nominal_tip()
    spot = place - place.mean(axis=0)
    grown = (spot * d.normal).sum(axis=1)
    return Concealed("workpiece_heating", lambda k: Hidden(reading=-k * 1e-6 * hours * (1 - 0.01 * hours) * grown),
                     lambda k: {"k": (k, "um/(m h)")}, {}, ("time",), 10.0)  # fmt: skip


FAMILIES: dict[str, Maker] = {
    f.__name__: f for f in (
        scale_expansion, part_expansion, thermal_drift, linear_drift, step_change, reindexing, gradient_bending,
        spindle_growth, screw_heating, workpiece_heating,
    )
}  # fmt: skip
