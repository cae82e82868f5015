"""The 6-D laser of the paper's Table 2, and what it reads along one line of an axis.

Limits are taken as half widths of uniform laws. Linear: one share of the length for the whole line (the wavelength), and roundness of
reading; straightness and angles: per reading. "0.5 / m" for pitch and yaw of the precision option is read as 0.05 / m, as in
the other two columns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm import Array

ARCSEC = np.pi / 180.0 / 3600.0


@dataclass(frozen=True)
class LaserOption:
    """linear 1; straightness mm and mm/mm; tilt rad and rad/mm; roll, squareness rad: all half widths."""

    linear: float
    straightness: tuple[float, float]
    tilt: tuple[float, float]
    roll: float
    square: float


OPTIONS = {
    "regular": LaserOption(0.5e-6, (1.0e-3, 0.2e-6), (1.0 * ARCSEC, 0.1e-3 * ARCSEC), 1.0 * ARCSEC, 1.0 * ARCSEC),
    "precision": LaserOption(0.2e-6, (0.5e-3, 0.1e-6), (0.5 * ARCSEC, 0.05e-3 * ARCSEC), 0.5 * ARCSEC, 0.5 * ARCSEC),
}  # fmt: skip


def read(option: LaserOption, axis: str, position: Array, errors: Array, rng: np.random.Generator) -> Array:
    """Readings (n, 6) of errors (n, 6) in the order X Y Z A B C at positions (n,) mm: zero at the first position.

    Straightness has no line of its own: the reading is zero at both ends, its slope counts as squareness.
    """
    out = np.array(errors)
    way = position - position[0]
    for k, name in enumerate("XYZABC"):
        if name == axis:
            noise = option.linear * rng.uniform(-1.0, 1.0) * way
        elif name in "XYZ":
            limit = option.straightness[0] + option.straightness[1] * way
            noise = limit * rng.uniform(-1.0, 1.0, len(position))
        elif name == "ABC"["XYZ".index(axis)]:
            noise = option.roll * rng.uniform(-1.0, 1.0, len(position))
        else:
            noise = (option.tilt[0] + option.tilt[1] * way) * rng.uniform(-1.0, 1.0, len(position))
        out[:, k] += noise
        out[:, k] -= out[0, k]
        if name in "XYZ" and name != axis:
            out[:, k] -= out[-1, k] * way / way[-1]
    return out
