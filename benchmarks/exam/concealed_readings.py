"""Concealed effects of probe, stylus, part fixture, laser and cutting tool."""

from __future__ import annotations

import numpy as np

from benchmarks.exam.case import Concealed, Maker
from benchmarks.exam.concealed_axis import UM, pick
from benchmarks.exam.design import Design
from benchmarks.exam.kinema import Array
from benchmarks.exam.machines import Machine
from benchmarks.exam.observe import Hidden

Rng = np.random.Generator


def _approach(d: Design) -> Array:
    """v . n, negative while approaching."""
    v = np.column_stack([d.columns[f"speed_{a}_mm_s"] for a in "XYZ"])
    return np.asarray((v * d.normal).sum(axis=1))


def trigger_delay(d: Design, m: Machine, rng: Rng) -> Concealed:
    """The tip travels on between contact and the latch, and slows a little as the probe gives way."""
    run_on = _approach(d)
    late = {x: -1e-3 * d.columns[f"speed_{x}_mm_s"] for x in "XYZ"}
    return Concealed("trigger_delay", lambda k: Hidden(reading=k * 1e-3 * run_on * (1 - 0.002 * np.abs(run_on))),
                     lambda k: {"delay": (k, "ms")}, {}, ("speed",), 0.1,
                     simpler={"readout_delay": [lambda k: Hidden(actual=late)]})  # fmt: skip


def tip_radius(d: Design, m: Machine, rng: Rng) -> Concealed:
    name = str(rng.choice(np.unique(d.labels["stylus"])))
    mine, s = np.array(d.labels["stylus"]) == name, rng.choice([-1.0, 1.0])
    return Concealed("tip_radius", lambda k: Hidden(reading=s * k * UM * mine), lambda k: {"dr": (s * k, "um")},
                     {"stylus": name}, ("stylus",))  # fmt: skip


def probe_lobing(d: Design, m: Machine, rng: Rng) -> Concealed:
    """Three-legged seat: force to lift one leg, 1/max cos over the legs, a rounded triangle, not a cosine."""
    turn = rng.uniform(0, 2 * np.pi)
    theta = np.radians(d.columns["probe_angle_deg"]) - turn
    near = (theta + np.pi / 3) % (2 * np.pi / 3) - np.pi / 3
    pretravel = 1 / np.cos(near)
    shape = (pretravel - 1.27) / 0.35 * d.hidden["lateral"]
    return Concealed(
        "probe_lobing", lambda k: Hidden(reading=-k * UM * shape), where={}, covariates=("probe_angle",)
    )


def stylus_bending(d: Design, m: Machine, rng: Rng) -> Concealed:
    """Cantilever with a mount of its own give: (L/50)^2.9 sin^2, and a little along the shaft."""
    length, lateral = d.columns["stylus_length_mm"], d.hidden["lateral"]
    shape = (length / 50.0) ** 2.9 * (lateral**2 + 0.01 * (1 - lateral**2))
    return Concealed("stylus_bending", lambda k: Hidden(reading=-k * UM * shape), lambda k: {"c": (k, "um at 50 mm")},
                     {}, ("stylus_length",))  # fmt: skip


def tip_form(d: Design, m: Machine, rng: Rng) -> Concealed:
    """An oval ball with a worn flat, one stylus."""
    name = str(rng.choice(np.unique(d.labels["stylus"])))
    mine = np.array(d.labels["stylus"]) == name
    a = rng.normal(size=(3, 3))
    a = a + a.T - np.trace(a + a.T) / 3 * np.eye(3)
    oval = np.einsum("ni,ij,nj->n", d.normal, a / np.linalg.norm(a) * 1.5, d.normal)
    worn = d.normal[np.flatnonzero(mine)[0]]
    flat = -np.exp((d.normal @ worn - 1) / 0.15)
    return Concealed("tip_form", lambda k: Hidden(reading=k * UM * mine * (oval + 0.4 * flat)), where={"stylus": name},
                     covariates=("nx", "ny", "nz"))  # fmt: skip


def clamping(d: Design, m: Machine, rng: Rng) -> Concealed:
    """The plate is bent when clamped: saddle and bow, anew each time, with the tilt of its balls' posts."""
    codes = d.codes("clamp")
    p = d.hidden["part_frame"] / 120.0
    k = rng.normal(0, 1.0, (codes.max() + 1, 3))[codes]
    x, y, z = p.T
    w = k[:, 0] * x**2 + k[:, 1] * y**2 + k[:, 2] * x * y
    slope = np.column_stack([2 * k[:, 0] * x + k[:, 2] * y, 2 * k[:, 1] * y + k[:, 2] * x])
    move = np.column_stack([-z[:, None] * slope, w])
    shape = (move * d.hidden["part_normal"]).sum(axis=1)
    return Concealed(
        "clamping", lambda a: Hidden(reading=a * UM * shape), where={}, covariates=("clamp", "pose")
    )


def cosine_error(d: Design, m: Machine, rng: Rng) -> Concealed:
    """The beam of one set-up is not along the line: the exact 1/cos - 1 of its way."""
    name = str(rng.choice(np.unique(d.labels["instrument"])))
    mine = np.array(d.labels["instrument"]) == name
    way = d.hidden["way"] * mine
    return Concealed("cosine_error", lambda k: Hidden(reading=(1 / np.cos(np.sqrt(abs(k)) * 1e-3) - 1) * way),
                     lambda k: {"theta": (float(np.sqrt(abs(k))), "mrad")}, {"instrument": name}, ("instrument",), 1.0)  # fmt: skip


def index_change(d: Design) -> Array:
    """Change of the refractive index from 20 degC, 1013.25 hPa, 50 %, by the density of moist air (not linear)."""
    t, p, h = (d.get(c) for c in ("temp_air_C", "pressure_hPa", "humidity_pct"))
    saturated = 6.112 * np.exp(17.62 * t / (243.12 + t))
    dry = 2.7176e-4 * (p / 1013.25) * 293.15 / (273.15 + t)
    base = 2.7176e-4
    damp = -3.7e-8 * (h / 100 * saturated - 0.5 * 23.37)
    return np.asarray(dry - base + damp)


def air_index(d: Design, m: Machine, rng: Rng) -> Concealed:
    """Weather correction left off (scale 1) or wrong by a factor: the laser reads its path too long in thick air."""
    way = d.hidden["way"] * index_change(d)
    return Concealed("air_index", lambda k: Hidden(reading=k * way), lambda k: {"scale": (k, "1")}, {},
                     ("pressure_hPa", "temp_air_C"))  # fmt: skip


def dead_path(d: Design, m: Machine, rng: Rng) -> Concealed:
    """Air between the interferometer and the zero, in every set-up: its index changes after the zero was set."""
    n = index_change(d)
    codes = d.codes("setup")
    first = np.array([n[codes == c][0] for c in np.unique(codes)])[codes]
    return Concealed("dead_path", lambda k: Hidden(reading=k * (n - first)), lambda k: {"length": (k, "mm")}, {},
                     ("pressure_hPa", "temp_air_C", "time"), 200.0)  # fmt: skip


def tool_deflection(d: Design, m: Machine, rng: Rng) -> Concealed:
    force = np.column_stack([d.columns[f"force_{a}_N"] for a in "xyz"])
    soft = np.array([1.0, 1.0, rng.uniform(0.03, 0.1)])
    return Concealed("tool_deflection", lambda k: Hidden(shift=k * UM * force * soft),
                     lambda k: {"compliance": (k, "um/N")}, {}, ("force",), 0.1)  # fmt: skip


def tool_wear(d: Design, m: Machine, rng: Rng) -> Concealed:
    """One tool loses radius with the way it has cut, a little faster at first; material is left."""
    name = str(rng.choice(np.unique(d.labels["tool"])))
    cut = d.columns["cut_length_mm"] / 1000 * (np.array(d.labels["tool"]) == name)
    top = cut.max()
    return Concealed("tool_wear", lambda k: Hidden(reading=k * UM * top * (cut / top) ** 0.95),
                     lambda k: {"rate": (k, "um/m")}, {"tool": name}, ("cut_length",), 0.5)  # fmt: skip


def tool_runout(d: Design, m: Machine, rng: Rng) -> Concealed:
    phi = np.radians(d.columns["spindle_angle_deg"])
    p = rng.uniform(0, 2 * np.pi, 2)
    shape = np.cos(phi + p[0]) + 0.2 * np.cos(2 * phi + p[1])
    return Concealed("tool_runout", lambda k: Hidden(reading=k * UM * shape), lambda k: {"amplitude": (k, "um")}, {},
                     ("spindle_angle",), 1.0, True)  # fmt: skip


def abbe_counted_twice(d: Design, m: Machine, rng: Rng) -> Concealed:
    """Minus (stored rotation x arm of the reference line), once. There is no amplitude; see blocks.stretched."""
    a = (
        str(rng.choice([x for x in d.machine.measured_at if x in d.machine.linear]))
        if d.machine.measured_at
        else pick(rng, d)
    )
    arm = np.array(d.machine.measured_at[a])
    rot = m.stored(a, d.q[a])[:, 3:]
    six = np.column_stack([-np.cross(rot, arm), np.zeros((d.rows, 3))])
    return Concealed("abbe_counted_twice", lambda k: Hidden(six={a: six}), where={"axis": a}, covariates=(a,))


FAMILIES: dict[str, Maker] = {
    f.__name__: f for f in (
        trigger_delay, tip_radius, probe_lobing, stylus_bending, tip_form, clamping, cosine_error, air_index, dead_path,
        tool_deflection, tool_wear, tool_runout, abbe_counted_twice,
    )
}  # fmt: skip
