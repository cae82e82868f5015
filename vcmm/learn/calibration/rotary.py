"""Rotary axes: the axis average line, and a curve as harmonics.

A centre line shifted by (lx, ly) in the frame that carries the axis is, in the axis's own moving frame, the motion

    first = cos q lx - s sin q ly      second = s sin q lx + cos q ly        s = +1 or -1 by side of the chain and letter

so a once-per-turn motion is location or error motion as one likes. The axis average line (ISO 230-7:2015, 3.1.7) is the mean over a
turn in the frame that does not turn: then the error motion has none.
"""

from __future__ import annotations

import numpy as np

from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.calibration.model import LOCATIONS, Curve, ErrorModel

ORDERS = (1, 2, 3, 4)


def sense(axis: str, machine: Machine) -> float:
    """Return s of the docstring of this module: the turn of the moving frame, from the first to the second direction across the axis."""
    handed = -1.0 if axis[0] == "B" else 1.0  # X Z of B is the left-handed pair
    return handed if axis in machine.chain.work else -handed


def average_line(model: ErrorModel, machine: Machine) -> Array:
    """Return the matrix (size, size) from any theta to the one about the axis average line, whose once-per-turn motion has no mean in the
    frame at rest.

    Only of axes that went round, whose errors move with them (error_frame = "moving"); the described machine is the same.
    """
    out = np.eye(model.size)
    curves = {c.component: c for c in model.curves}
    for first in (c for c in model.curves if c.is_centred and c.periodic):
        axis = first.axis
        pair = LOCATIONS[axis[0]][2:] if first.turns else LOCATIONS[axis[0]][:2]
        second = curves.get(f"E{pair[1][0]}{axis}")
        names = [f"{p}{axis}" for p in pair]
        if second is None or machine.axes[axis].error_frame == "fixed":
            continue
        s = sense(axis, machine)
        wave = np.stack([np.cos(first.nodes), np.sin(first.nodes)], axis=1)
        first_slice, second_slice = model.slices[first.component], model.slices[second.component]
        for here, (x, y) in (
            (first_slice, _mean_of_first(first, s)),
            (second_slice, _mean_of_second(second, s)),
        ):
            for name, row in zip(names, (x, y)):
                if name in model.pairs:  # else it is the placement, as of a head
                    out[model.slices[name], here] += row
            out[first_slice, here] -= wave @ np.stack([x, -s * y])
            out[second_slice, here] -= wave @ np.stack([y, s * x])
    return out


def _mean_of_first(curve: Curve, s: float) -> Array:
    """Return the contribution of the motion in the first direction to the mean over a turn in the frame that does not turn, (2, k)."""
    cosine, sine = once_per_turn(curve)
    return np.stack([cosine / 2, -s * sine / 2])


def _mean_of_second(curve: Curve, s: float) -> Array:
    """Return the same of the second direction, (2, k)."""
    cosine, sine = once_per_turn(curve)
    return np.stack([s * sine / 2, cosine / 2])


def once_per_turn(curve: Curve) -> Array:
    """Return the cosine and sine of the first harmonic, per value at the nodes of a whole turn, as (2, k)."""
    return harmonic(curve, 1)


def harmonic(curve: Curve, order: int) -> Array:
    """Return the cosine and sine of one harmonic of a curve over a whole turn (the last node is the first, and is not counted), as (2, k)."""
    q = curve.nodes[:-1]
    out = np.zeros((2, len(curve.nodes)))
    out[:, :-1] = np.stack([np.cos(order * q), np.sin(order * q)]) * 2 / len(q)
    return out


def harmonics(curve: Curve, values: Array, covariance: Array) -> list[dict[str, float]]:
    """Return the amplitude of the first harmonics of a curve, mm or rad, with standard uncertainty (of the vector, per component)."""
    out = []
    for order in ORDERS:
        if 2 * order > len(curve.nodes) - 1:
            break
        weights = harmonic(curve, order)
        parts = weights @ values
        u = float(np.sqrt(np.trace(weights @ covariance @ weights.T) / 2))
        out.append({"order": float(order), "amplitude": float(np.hypot(*parts)), "u": u})
    return out
