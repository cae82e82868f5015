"""Concealed effects of axes, drives and structure. Exact positions are changed and the chain is multiplied again."""

from __future__ import annotations

import numpy as np

from benchmarks.exam.case import Concealed, Maker, unit_axis
from benchmarks.exam.design import Design
from benchmarks.exam.kinema import Array
from benchmarks.exam.machines import Machine, smooth
from benchmarks.exam.observe import Hidden

Rng = np.random.Generator
UM, URAD = 1e-3, 1e-6


def axes_of(design: Design) -> list[str]:
    """Linear axes that this design moves enough to say anything."""
    return [a for a in design.machine.linear if np.ptp(design.q[a]) > 30.0]


def pick(rng: Rng, design: Design) -> str:
    return str(rng.choice(axes_of(design)))


def scale_factor(d: Design, m: Machine, rng: Rng) -> Concealed:
    a, s = pick(rng, d), rng.choice([-1.0, 1.0])
    return Concealed("scale_factor", lambda k: Hidden(actual={a: s * k * 1e-6 * d.q[a]}),
                     lambda k: {"k": (s * k, "um/m")}, {"axis": a}, (a,), 10.0)  # fmt: skip


def squareness(d: Design, m: Machine, rng: Rng) -> Concealed:
    p, s = str(rng.choice(["A0Z", "B0Z", "C0Y"])), rng.choice([-1.0, 1.0])
    return Concealed("squareness", lambda k: Hidden(square={p: s * k * URAD}), lambda k: {"angle": (s * k, "urad")},
                     {"pair": p}, (p[2],), 10.0)  # fmt: skip


def geometric_change(d: Design, m: Machine, rng: Rng) -> Concealed:
    """A guide that changed: a smooth draw of another correlation length, with one bump, on one component."""
    a = pick(rng, d)
    i = int(rng.integers(0, 6))
    draw = smooth(rng, 1.0, 0.22 * np.ptp(d.machine.travel[a]))
    middle, width = rng.uniform(*np.quantile(d.q[a], [0.2, 0.8])), 0.2 * np.ptp(d.machine.travel[a])
    shape = draw(d.q[a]) + 1.2 / np.cosh((d.q[a] - middle) / width) ** 2
    shape = shape - shape.mean()
    unit = UM if i < 3 else URAD
    line = {a: _one(d, i, unit * (d.q[a] - d.q[a].mean()) / 100)}
    simpler = {"scale_factor": [lambda k: Hidden(six=line)]} if i == "XYZ".index(a) else {}
    if i < 3 and i != "XYZ".index(a):
        simpler = {"squareness": [lambda k: Hidden(six=line)]}
    name = ("EX", "EY", "EZ", "EA", "EB", "EC")[i] + a
    return Concealed("geometric_change", lambda k: Hidden(six={a: _one(d, i, k * unit * shape)}), lambda k: {},
                     {"component": name}, (a,), 3.0, simpler=simpler)  # fmt: skip


def _one(d: Design, i: int, values: Array) -> Array:
    six = np.zeros((d.rows, 6))
    six[:, i] = values
    return six


def abbe_offset(d: Design, m: Machine, rng: Rng) -> Concealed:
    """The reference line lay elsewhere than stated: the stored rotations act on a further arm."""
    a = pick(rng, d)
    arm = unit_axis("XYZ"[int(rng.choice([i for i in range(3) if "XYZ"[i] != a]))])
    rot = m.stored(a, d.q[a])[:, 3:]

    def build(k: float) -> Hidden:
        return Hidden(six={a: np.column_stack([np.cross(rot, k * arm), np.zeros((d.rows, 3))])})

    return Concealed("abbe_offset", build, lambda k: {}, {"axis": a}, (a,), 100.0)


def map_interpolation(d: Design, m: Machine, rng: Rng) -> Concealed:
    """Straight lines between nodes, where the guide is bent: a parabola of its own height in each mesh."""
    a, i = pick(rng, d), int(rng.integers(0, 3))
    i = "XYZ".index(a) if d.kind == "displacement" else i  # a laser sees along the line only
    nodes, q = m.nodes[a], d.q[a]
    cell = np.clip(np.searchsorted(nodes, q) - 1, 0, len(nodes) - 2)
    u = (q - nodes[cell]) / (nodes[cell + 1] - nodes[cell])
    height = rng.normal(0, 0.6, len(nodes) - 1) + rng.choice([-1.0, 1.0])
    shape = 4 * u * (1 - u) * height[cell] * (1 + 0.25 * (u - 0.5))
    return Concealed("map_interpolation", lambda k: Hidden(six={a: _one(d, i, k * UM * shape)}), where={"axis": a},
                     covariates=(a,))  # fmt: skip


def cross_axis_flexure(d: Design, m: Machine, rng: Rng) -> Concealed:
    """One axis bends under another's place. Half of the cases: the plain c q_a q_b from the zero of the axes; half: from
    the middle of the travels, and a little more than bilinear."""
    letters = axes_of(d)
    a, b = (str(v) for v in rng.permutation(letters)[:2])
    e = unit_axis(str(rng.choice(["X", "Y", "Z"])))
    middle = bool(rng.integers(0, 2))
    u, v = (d.q[c] - middle * np.mean(d.machine.travel[c]) for c in (a, b))
    shape = u * v * (1 + middle * 0.15 * v / np.ptp(d.machine.travel[b])) * 1e-9  # um/m^2 -> mm
    return Concealed("cross_axis_flexure", lambda k: Hidden(shift=k * shape[:, None] * e),
                     lambda k: {} if middle else {"c": (k, "um/m^2")}, {}, (a, b), 30.0,
                     note="from the middle of the travels" if middle else "from the zero of the axes")  # fmt: skip


def part_load(d: Design, m: Machine, rng: Rng) -> Concealed:
    """Heavier part, longer carriage beam: c load q along the loaded direction."""
    a, e = pick(rng, d), unit_axis(str(rng.choice(["X", "Y", "Z"])))
    amount = d.get("load_kg") * (d.q[a] - np.mean(d.machine.travel[a])) * 1e-6
    return Concealed("part_load", lambda k: Hidden(shift=k * amount[:, None] * e), where={"axis": a},
                     covariates=("load_kg", a))  # fmt: skip


def backlash(d: Design, m: Machine, rng: Rng) -> Concealed:
    """A play operator of width gap, walked along the dense path where there is one."""
    a = pick(rng, d)

    def build(k: float) -> Hidden:
        return Hidden(actual={a: play(d, a, k * UM)})

    return Concealed("backlash", build, lambda k: {"gap": (k, "um")}, {"axis": a}, ("sense_" + a,), 2.0,
                     also=())  # fmt: skip


def play(d: Design, a: str, gap: float) -> Array:
    """Carriage minus command: the carriage is dragged once the command has crossed the gap."""
    if d.nodes is None:
        since = d.columns.get(f"since_reversal_{a}_mm", np.full(d.rows, 1.0))
        return d.columns[f"sense_{a}"] * (-gap / 2 + np.maximum(gap - since, 0.0))
    i = "XYZ".index(a)
    command, carriage = d.nodes[:, i], np.empty(len(d.nodes))
    here = command[0]
    for k, q in enumerate(command):
        here = min(max(here, q - gap / 2), q + gap / 2)
        carriage[k] = here
    return (carriage - command)[d.row_node]


def lost_motion(d: Design, m: Machine, rng: Rng) -> Concealed:
    """Wear in the middle of a screw or wind-up towards its end: reversal that grows along the axis."""
    a, s = pick(rng, d), rng.choice([-1.0, 1.0])
    sense = d.columns[f"sense_{a}"]
    q = d.q[a]
    base = rng.uniform(0.0, 0.3)

    def build(k: float) -> Hidden:
        far = q - (q.min() if s > 0 else q.max())
        width = (abs(k) * base * 0.2 + s * k * far * 1e-3) * UM
        return Hidden(actual={a: -0.5 * width * sense})

    flat = Hidden(actual={a: -0.5 * UM * sense})
    return Concealed("lost_motion", build, lambda k: {"g1": (s * k, "um/m")}, {"axis": a}, ("sense_" + a, a), 8.0,
                     simpler={"backlash": [lambda k: flat]})  # fmt: skip


def hysteresis(d: Design, m: Machine, rng: Rng) -> Concealed:
    """Pre-sliding of guides: three Jenkin elements, walked along the dense path (or since the last reversal)."""
    a = pick(rng, d)
    yields, shares = np.exp(rng.uniform(np.log(0.3), np.log(4.0), 3)), rng.dirichlet([2.0, 2.0, 2.0])
    i = "XYZ".index(a)
    if d.nodes is None:
        since = d.columns[f"since_reversal_{a}_mm"]
        force = sum(w * (1 - 2 * np.maximum(1 - since / (2 * y), 0)) for y, w in zip(yields, shares))
        state = d.columns[f"sense_{a}"] * force
    else:
        z, states = np.zeros(3), []
        for step in np.diff(d.nodes[:, i], prepend=d.nodes[0, i]):
            z = np.clip(z + step / yields, -1, 1)
            states.append(float(z @ shares))
        state = np.array(states)[d.row_node]
    flat = Hidden(actual={a: -UM * d.columns[f"sense_{a}"]})
    return Concealed("hysteresis", lambda k: Hidden(actual={a: -k * UM * state}), where={"axis": a},
                     covariates=("sense_" + a, "since_reversal_" + a), simpler={"backlash": [lambda k: flat]})  # fmt: skip


def reversal_spike(d: Design, m: Machine, rng: Rng) -> Concealed:
    """A lopsided pulse after the turn: fast rise, power-law fall (neither exponential nor gamma)."""
    a = pick(rng, d)
    s = d.columns[f"since_reversal_{a}_mm"] / np.exp(rng.uniform(np.log(0.4), np.log(2.5)))
    shape = 2.2 * s / (0.35 + s**2.4) * np.exp(-s / 9)
    return Concealed("reversal_spike", lambda k: Hidden(actual={a: -k * UM * shape * d.columns[f"sense_{a}"]}),
                     where={"axis": a}, covariates=("since_reversal_" + a,), start=3.0)  # fmt: skip


def screw_pitch(d: Design, m: Machine, rng: Rng) -> Concealed:
    a = pick(rng, d)
    period = rng.choice([5.0, 8.0, 10.0, 12.0, 16.0, 20.0]) * (1 + rng.uniform(-0.004, 0.004))
    p1, p2 = rng.uniform(0, 2 * np.pi, 2)
    share = rng.uniform(0, 0.3)
    w = 2 * np.pi * d.q[a] / period
    shape = np.sin(w + p1) + share * np.sin(2 * w + p2)
    return Concealed("screw_pitch", lambda k: Hidden(actual={a: k * UM * shape}),
                     lambda k: {"amplitude": (k, "um"), "period": (period, "mm")}, {"axis": a}, (a,), 1.0, True)  # fmt: skip


def encoder_interpolation(d: Design, m: Machine, rng: Rng) -> Concealed:
    a = pick(rng, d)
    period = rng.choice([0.02, 0.04, 0.1, 0.5, 2.0])
    w = 2 * np.pi * d.get(f"raw_{a}_mm") / period
    p1, p2 = rng.uniform(0, 2 * np.pi, 2)
    shape = np.sin(w + p1) + 0.25 * np.sin(2 * w + p2)
    return Concealed("encoder_interpolation", lambda k: Hidden(actual={a: k * UM * shape}),
                     lambda k: {"amplitude": (k, "um"), "period": (period, "mm")}, {"axis": a}, ("raw_" + a,), 0.5, True)  # fmt: skip


def servo_lag(d: Design, m: Machine, rng: Rng) -> Concealed:
    """One axis follows late, with a first-order loop: lag v/Kv, less a little with acceleration."""
    a = str(rng.choice([x for x in "XYZ" if np.abs(d.columns[f"speed_{x}_mm_s"]).max() > 1]))
    v, acc = d.columns[f"speed_{a}_mm_s"], d.columns.get(f"accel_{a}_mm_s2", 0.0)
    return Concealed("servo_lag", lambda k: Hidden(actual={a: -(k * 1e-3 * v - (k * 1e-3) ** 2 * acc)}),
                     lambda k: {"1/Kv": (k, "ms")}, {"axis": a}, ("speed_" + a,), 0.1)  # fmt: skip


def readout_delay(d: Design, m: Machine, rng: Rng) -> Concealed:
    """All axes are latched late. Along the normal of a touch this is what a late trigger does: either name counts."""
    v = np.column_stack([d.columns[f"speed_{x}_mm_s"] for x in "XYZ"])
    late = {x: v[:, i] for i, x in enumerate("XYZ")}
    simpler = {}
    if d.kind == "probe":
        along = (v * d.normal).sum(axis=1)
        simpler = {"trigger_delay": [lambda k: Hidden(reading=1e-3 * along)]}
    return Concealed("readout_delay", lambda k: Hidden(actual={x: -k * 1e-3 * w for x, w in late.items()}),
                     lambda k: {"delay": (k, "ms")}, {}, ("speed",), 0.1, simpler=simpler)  # fmt: skip


def dynamic_pitch(d: Design, m: Machine, rng: Rng) -> Concealed:
    """The carriage pitches as it accelerates: a rotation of the axis, carried to the tip by the exact chain."""
    a = pick(rng, d)
    i = int(rng.choice([k for k in range(3) if "XYZ"[k] != a]))
    acc = d.columns[f"accel_{a}_mm_s2"] * 1e-3
    return Concealed("dynamic_pitch", lambda k: Hidden(six={a: _one(d, 3 + i, k * URAD * acc)}), where={"axis": a},
                     covariates=("accel_" + a,), start=50.0)  # fmt: skip


def structural_vibration(d: Design, m: Machine, rng: Rng) -> Concealed:
    """Ring-down after each jump of the acceleration, the response of one mode to the whole history (exact steps)."""
    a = str(rng.choice([x for x in "XY" if np.abs(d.columns[f"accel_{x}_mm_s2"]).max() > 1]))
    hertz, damping = rng.uniform(11, 38), rng.uniform(0.03, 0.09)
    t, acc = d.columns["time_s"], d.columns[f"accel_{a}_mm_s2"]
    jumps = np.flatnonzero(np.abs(np.diff(acc, prepend=acc[0])) > 1.0)
    w = 2 * np.pi * hertz
    wave = np.zeros(d.rows)
    size = np.abs(acc).max()
    for j in jumps:
        late = t - (t[j] - 2e-3)
        on = late > 0
        step = (acc[j] - acc[j - 1]) / size if j else 0.0
        wave[on] += step * np.exp(-damping * w * late[on]) * np.sin(w * np.sqrt(1 - damping**2) * late[on])
    return Concealed("structural_vibration", lambda k: Hidden(actual={a: k * UM * wave}),
                     lambda k: {"frequency": (hertz, "Hz")}, {"axis": a}, ("time", "accel_" + a), 1.0, True)  # fmt: skip


def rotary_location(d: Design, m: Machine, rng: Rng) -> Concealed:
    i, s = int(rng.choice([0, 1, 3, 4])), rng.choice([-1.0, 1.0])
    unit = UM if i < 3 else URAD

    def build(k: float) -> Hidden:
        return Hidden(place={"C": _one(d, i, s * k * unit)})

    name = "offset" if i < 3 else "tilt"
    return Concealed("rotary_location", build, lambda k: {name: (s * k, "um" if i < 3 else "urad")},
                     {"component": ("X0C", "Y0C", "Z0C", "A0C", "B0C")[i]}, ("C",),
                     5.0)  # fmt: skip


def rotary_cyclic(d: Design, m: Machine, rng: Rng) -> Concealed:
    """Encoder eccentricity or a wobbling bearing: second harmonic with a share of the third."""
    i = int(rng.choice([2, 3, 4, 5]))
    k1 = int(rng.choice([1, 2])) if i in (2, 5) else 2
    p = rng.uniform(0, 2 * np.pi, 2)
    shape = np.sin(k1 * d.q["C"] + p[0]) + 0.2 * np.sin((k1 + 1) * d.q["C"] + p[1])
    unit = UM if i < 3 else URAD
    return Concealed("rotary_cyclic", lambda k: Hidden(six={"C": _one(d, i, k * unit * shape)}), where={"axis": "C"},
                     covariates=("C",), start=5.0)  # fmt: skip


FAMILIES: dict[str, Maker] = {
    f.__name__: f for f in (
        scale_factor, squareness, geometric_change, abbe_offset, map_interpolation, cross_axis_flexure, part_load, backlash,
        lost_motion, hysteresis, reversal_spike, screw_pitch, encoder_interpolation, servo_lag, readout_delay, dynamic_pitch,
        structural_vibration, rotary_location, rotary_cyclic,
    )
}  # fmt: skip
