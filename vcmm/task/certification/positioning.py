"""Simulate the test of ISO 230-2 on sampled axes, and scale their errors and their scatter to the limits."""

from __future__ import annotations

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.task.certification.certificate import MachineCertificate

TARGETS, RUNS = 11, 5
HALVINGS = 24


def axis_run(machine: Machine, axis: str) -> Run:
    """Return the axis at its targets, the others in their middle."""
    at = {
        a: np.full(TARGETS, (x.travel[0] + x.travel[1]) / 2 if a in "XYZ" else 0.0)
        for a, x in machine.axes.items()
    }
    at[axis] = np.linspace(*machine.axes[axis].travel, TARGETS)
    columns = {f"sense_{a}": np.zeros(TARGETS) for a in machine.axes}
    columns |= {f"n{c}": np.full(TARGETS, float(c.upper() == axis)) for c in "xyz"}
    return Run(at, np.zeros((TARGETS, 3)), columns)


def fit_to_limits(
    c: MachineCertificate,
    axis: str,
    shape: Array,
    rng: np.random.Generator,
    shares: tuple[Array, Array],
    alone: bool = False,
) -> tuple[Array, Array]:
    """Return (standard deviation of one position (m,) mm, factor (m,) of the errors shape (m, targets) mm).

    shares: of the accuracy and of the repeatability limit that every machine uses. alone: errors use all of the accuracy limit
    by themselves, without scatter. UsageError: no limit of the axis.
    """
    accuracy = c.positioning_limit("A", axis)
    fallback_limit = c.positioning_limit("E", axis) or c.positioning_limit("M", axis)
    if accuracy is None and fallback_limit is None:
        raise UsageError(f'iso230_2 states no A, E or M of axis {axis}; write A for all axes, or "A {axis}"')
    limit = accuracy if accuracy is not None else fallback_limit
    assert limit is not None
    stated = c.positioning_limit("R", axis)
    noise = rng.normal(size=(len(shape), TARGETS, RUNS, 2))
    unit = 4.0 * noise.std(axis=2, ddof=1).max(axis=(1, 2))  # R per standard deviation
    scatter = shares[1] * (stated if stated is not None else 0.5 * limit) / float(unit.mean())
    if alone:
        scatter = np.minimum(scatter, limit / float(unit.mean()))
    noise = noise * (0.0 if alone else scatter[:, None, None, None])
    spread = 2.0 * noise.std(axis=2, ddof=1) if accuracy is not None else np.zeros(noise.mean(axis=2).shape)
    mean = noise.mean(axis=2)
    factor, high = (
        np.zeros(len(shape)),
        np.full(len(shape), 20.0 * limit) / np.maximum(np.ptp(shape, axis=1), 1e-12),
    )
    for _ in range(HALVINGS):
        middle = (factor + high) / 2
        error = (middle[:, None] * shape)[..., None] + mean
        over = (error + spread).max(axis=(1, 2)) - (error - spread).min(axis=(1, 2)) > shares[0] * limit
        factor, high = np.where(over, factor, middle), np.where(over, middle, high)
    return scatter, factor
