"""Worlds of scatter, mm. All but `t6` depart from what the machine file states."""

from __future__ import annotations

import numpy as np

from benchmarks.exam.design import Design
from benchmarks.exam.kinema import Array

WORLDS = ("t6", "t3", "outliers", "ar3", "ar6", "speed", "scale7", "scale13")


def scatter(world: str, design: Design, size: int, rng: np.random.Generator) -> Array:
    """(size,) noise in mm; `scale` of the machine is the t scale."""
    s = design.machine.scale
    base = rng.standard_t(6, size)
    if world == "t6":
        return s * base
    if world == "t3":  # same interquartile range, heavier tails
        return s * rng.standard_t(3, size) * 0.938
    if world == "outliers":
        wild = rng.random(size) < 0.02
        return s * np.where(wild, rng.uniform(6, 15, size) * rng.choice([-1, 1], size), base)
    if world in ("ar3", "ar6"):
        return s * _ar(base, 0.3 if world == "ar3" else 0.6)
    if world == "speed":
        per = size // design.rows
        v = np.linalg.norm(np.column_stack([_speed(design, a) for a in "XYZ"]), axis=1)
        v = v / max(np.median(v), 1e-12) if v.any() else np.ones(design.rows)
        return s * base * np.repeat(np.clip(0.7 + 0.3 * v, 0.7, 3.0), per)
    if world in ("scale7", "scale13"):
        return s * base * (0.7 if world == "scale7" else 1.3)
    raise ValueError(f"unknown world {world}; choose from {', '.join(WORLDS)}")


def _speed(design: Design, axis: str) -> Array:
    return np.asarray(design.columns.get(f"speed_{axis}_mm_s", np.zeros(design.rows)), dtype=float)


def _ar(base: Array, rho: float) -> Array:
    """AR(1) of the same variance as its innovations' law."""
    out = base.copy()
    for i in range(1, len(out)):
        out[i] = rho * out[i - 1] + np.sqrt(1 - rho**2) * base[i]
    return out
