"""Simulate the reversals: readings of the probes of a test on a given machine with a given artefact.

The machine's own kinematics make the readings, so that errors that a test does not determine (another tilt, an Abbe arm, an
offset of the axis) are in them as on a real machine.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.task.instruments.reversal import REVERSED, ReversalTest
from vcmm.task.instruments.reversal_turns import TURN

Form = Callable[[Array], Array]  # angle (n,) rad or place (n,) mm -> (n,) mm


@dataclass(frozen=True)
class Sampling:
    """turns of per_turn readings each; u: noise of a reading, mm; mounting: once per turn, rad (face) or mm, sampled per set-up."""

    turns: int = 20
    per_turn: int = 360
    u: float = 0.0
    mounting: float = 0.0


def axis_motion(
    machine: Machine,
    axis: str,
    angle: Array,
    place: Sequence[float],
    others: Mapping[str, float] | None = None,
) -> Array:
    """Return the motion of the turning part (n, 3) mm at a fixed place (3,) mm, in fixed directions, as its own motion, at angles (n,) rad.

    place: from the centre line of the axis. others: positions of the other axes, mm and rad; default zero. Exact kinematics.
    """
    run = fixed_places(machine, axis, angle, place, others)
    return own_motion(machine, axis, angle, machine.tip_error(run, exact=True))


def fixed_places(
    machine: Machine,
    axis: str,
    angle: Array,
    place: Sequence[float],
    others: Mapping[str, float] | None = None,
) -> Run:
    """Return the rows of `axis_motion`. Raises UsageError for an axis that the machine lacks or that does not turn about Z."""
    if axis not in machine.axes or axis[0] != "C":
        raise UsageError(
            f'the axis "{axis}" does not turn about Z here; the machine has {" ".join(machine.axes)}'
        )
    n = len(angle)
    at = {a: np.full(n, (others or {}).get(a, 0.0)) for a in machine.chain.letters}
    fixed = np.tile(np.asarray(place, dtype=float) + np.asarray(machine.axes[axis].centre), (n, 1))
    if axis not in machine.chain.work:
        return Run({**at, axis: angle}, _turn_vectors(fixed, -angle))
    for i, letter in enumerate("XYZ"):
        fixed[:, i] -= at.get(letter, 0.0)
    return Run({**at, axis: angle}, fixed)


def own_motion(machine: Machine, axis: str, angle: Array, moved: Array) -> Array:
    """Return the tip errors (..., n, 3) mm in workpiece axes as the axis's own motion in fixed directions."""
    return -_turn_vectors(moved, -angle) if axis in machine.chain.work else moved


def _turn_vectors(vectors: Array, angle: Array) -> Array:
    """Turn vectors (..., n, 3) about z by angles (n,)."""
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.stack([c * x - s * y, s * x + c * y, z], axis=-1)


def simulated_values(
    test: ReversalTest,
    machine: Machine,
    artefact: Form,
    setups: Sequence[str],
    sampling: Sampling,
    rng: np.random.Generator,
    axis: str = "C",
) -> Iterator[tuple[str, str, Array, Array]]:
    """Yield (set-up, probe, angles (n,) rad, readings (n,) mm) of a whole test."""
    angle = np.arange(sampling.turns * sampling.per_turn) * TURN / sampling.per_turn
    for setup in setups:
        lies = sampling.mounting * (rng.standard_normal(2) if sampling.mounting else np.zeros(2))
        for probe, arm in (test.arms or {"": 0.0}).items():
            at = angle[: sampling.per_turn]
            read = reading(test, machine, artefact, setup=setup, probe=probe, angle=at, axis=axis)
            reach = (arm if setup != REVERSED else -arm) if test.test == "face" else 1.0
            wave = lies[0] * np.cos(angle) + lies[1] * np.sin(angle)
            noise = sampling.u * rng.standard_normal(len(angle))
            yield setup, probe, angle, np.tile(read, sampling.turns) + reach * wave + noise


def reading(
    test: ReversalTest,
    machine: Machine,
    artefact: Form,
    setup: str,
    probe: str,
    angle: Array,
    axis: str = "C",
) -> Array:
    """Return the reading (n,) mm of one probe in one set-up at angles (n,) rad, without noise and mounting."""
    turned = setup == REVERSED
    if test.test == "face":
        arm = (test.arms or {})[probe] * (-1.0 if turned else 1.0)
        place = (arm, 0.0, 0.0) if test.tilt[1] == "B" else (0.0, arm, 0.0)
        indication = axis_motion(machine, axis, angle, place)[:, 2]
        return np.asarray(test.sense * indication + (0.0 if test.on_axis(probe) else artefact(angle)))
    indication = axis_motion(machine, axis, angle, (0.0, 0.0, 0.0))[:, "XYZ".index(test.error[1])]
    sense = test.sense * (-1.0 if turned and test.test == "donaldson" else 1.0)
    if test.test == "direct":
        return np.asarray(sense * indication)
    index = np.radians(float(setup)) if test.test == "multi-step" else 0.0
    return np.asarray(sense * indication + artefact(angle - index))
