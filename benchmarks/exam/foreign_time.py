"""Courses of time that no sensor logs and no catalogue holds: a heat source that goes on and off at moments of its own.

What it warms follows behind two lags (the source's own body, then the structure), so every course is smooth and follows no
thermometer of the recording.
"""

from __future__ import annotations

import numpy as np

from benchmarks.exam.case import Concealed, Maker
from benchmarks.exam.concealed_axis import UM, pick
from benchmarks.exam.design import Design
from benchmarks.exam.kinema import Array
from benchmarks.exam.machines import Machine
from benchmarks.exam.observe import Hidden

Rng = np.random.Generator


def source(d: Design, rng: Rng) -> tuple[Array, Array]:
    """A clock (k,) each 30 s and the source on it, 0 or more: four to seven switchings, heat of its own each time."""
    t = d.columns["time_s"]
    clock = np.arange(t[0] - 1800.0, t[-1] + 31.0, 30.0)
    moments = np.sort(rng.uniform(clock[0], clock[-1], int(rng.integers(4, 8))))
    heat = np.where(np.arange(len(moments) + 1) % 2, rng.uniform(0.5, 1.5, len(moments) + 1), 0.0)
    return clock, heat[np.searchsorted(moments, clock)]


def followed(clock: Array, heat: Array, lags: Array) -> Array:
    """heat (k,) behind one first-order lag after the other."""
    for lag in lags:
        share, out = 1.0 - np.exp(-np.diff(clock, prepend=clock[0]) / lag), heat.copy()
        for i in range(1, len(clock)):
            out[i] = out[i - 1] + (heat[i] - out[i - 1]) * share[i]
        heat = out
    return heat


def course(d: Design, rng: Rng, clock: Array, heat: Array) -> Array:
    """The source as one part of the machine feels it (n,), mean 0, rms 1 over the rows."""
    lags = np.exp(rng.uniform(np.log([300.0, 600.0]), np.log([1800.0, 4800.0])))
    out = np.interp(d.columns["time_s"], clock, followed(clock, heat, lags))
    out = out - out.mean()
    return np.asarray(out / max(float(out.std()), 1e-12))


def wander(d: Design, m: Machine, rng: Rng) -> Concealed:
    """The tip wanders: each direction with its own lags and size."""
    clock, heat = source(d, rng)
    three = np.column_stack([rng.normal(0, 1) * course(d, rng, clock, heat) for _ in "XYZ"])
    return Concealed("wander", lambda k: Hidden(shift=k * UM * three), covariates=("time",))


def stretching(d: Design, m: Machine, rng: Rng) -> Concealed:
    """The scale of one axis breathes about its zero."""
    a = pick(rng, d)
    c = course(d, rng, *source(d, rng))
    return Concealed(
        "stretching", lambda k: Hidden(actual={a: k * 1e-6 * c * d.q[a]}), covariates=("time", a)
    )


def growing_part(d: Design, m: Machine, rng: Rng) -> Concealed:
    """The part grows and shrinks about its middle, in its own frame."""
    c = course(d, rng, *source(d, rng))
    grown = np.einsum("nij,nj->ni", d.hidden["turns"], d.hidden["part_frame"])
    along = (grown * d.normal).sum(axis=1)
    return Concealed(
        "growing_part",
        lambda k: Hidden(reading=k * 1e-6 * c * along),
        covariates=("time", "part_x", "part_y", "part_z"),
    )


TIME: dict[str, Maker] = {f.__name__: f for f in (wander, stretching, growing_part)}
