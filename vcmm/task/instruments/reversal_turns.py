"""Readings of a probe on a turning axis, turn by turn, as orders of undulations per turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import UsageError
from vcmm.core.run import Array

Complex = npt.NDArray[np.complex128]
TURN = 2 * np.pi
ANGLES = 360  # at which turns are compared


@dataclass(frozen=True, eq=False)
class TurnGroup:
    """The turns of one probe in one set-up.

    coefficients (turns, K) complex, orders 1 to K: reading = Re sum c_k exp(i k q), mm or rad.
    plot (turns, ANGLES): the readings at equal angles, less mean and drift. noise_variance: variance of a cosine coefficient that a
    stated noise makes; 0 where none was stated. incomplete: turns that were not complete.
    """

    setup: str
    probe: str
    coefficients: Complex
    plot: Array
    noise_variance: float = 0.0
    incomplete: int = 0


def turn_group(
    setup: str, probe: str, angle: Array, value: Array, orders: int, u: float | None = None
) -> TurnGroup:
    """Convert readings into turns. angle (n,) rad, going on over the turns; value (n,) mm or rad; u: stated noise of one reading.

    Turns are counted from the first angle; a slow drift (a line through the means of the turns) is taken off. Raises UsageError
    where no turn is complete, readings are too few for the orders, or there is one turn and no stated noise.
    """
    where = f'set-up "{setup}"' + (f', probe "{probe}"' if probe else "")
    way = (angle - angle[0]) * np.sign(angle[-1] - angle[0])
    number = np.floor(way / TURN + 1e-9).astype(int)
    whole, dropped = [], 0
    for group in range(int(number.max(initial=0)) + 1):
        rows = np.flatnonzero(number == group)
        gap = TURN if len(rows) < 3 else _largest_gap(angle[rows])
        if gap > TURN / (2 * orders):
            dropped += 1
        else:
            whole.append(rows)
    if not whole:
        raise UsageError(
            f"{where}: no turn has readings closer than {360 / (2 * orders):.3g} deg all round, which {orders} orders need; "
            "record a full turn of C_deg, more densely, or write harmonics smaller"
        )
    if len(whole) < 2 and u is None:
        raise UsageError(
            f'{where}: one turn alone shows no scatter; record more turns, or state [noise] u = "1 nm"'
        )
    value = value - _drift(angle, value, whole)
    fitted = np.stack([_orders(angle[rows], value[rows], orders) for rows in whole])
    plots = np.stack([_at_equal_angles(angle[rows], value[rows]) for rows in whole])
    stated = 0.0 if u is None else 2.0 * u**2 / sum(len(rows) for rows in whole)
    return TurnGroup(setup, probe, fitted, plots, stated, dropped)


def _largest_gap(angle: Array) -> float:
    there = np.sort(np.mod(angle, TURN))
    return float(max(np.diff(there).max(initial=0.0), there[0] + TURN - there[-1]))


def _drift(angle: Array, value: Array, whole: list[npt.NDArray[np.intp]]) -> Array:
    """Return the line through the means of whole turns (n,), over the angle."""
    at = np.array([angle[rows].mean() for rows in whole])
    mean = np.array([value[rows].mean() for rows in whole])
    if len(whole) < 2:
        return np.full(len(value), mean[0])
    slope = float(((at - at.mean()) * (mean - mean.mean())).sum() / ((at - at.mean()) ** 2).sum())
    return np.asarray(mean.mean() + slope * (angle - at.mean()))


def _orders(angle: Array, value: Array, orders: int) -> Complex:
    """Fit a constant and K orders by least squares (K,)."""
    k = np.arange(1, orders + 1)
    waves = np.outer(angle, k)
    columns = np.concatenate([np.ones((len(angle), 1)), np.cos(waves), np.sin(waves)], axis=1)
    solution = np.linalg.lstsq(columns, value, rcond=None)[0]
    return np.asarray(solution[1 : orders + 1] - 1j * solution[orders + 1 :])


def _at_equal_angles(angle: Array, value: Array) -> Array:
    there = np.mod(angle, TURN)
    order = np.argsort(there)
    grid = np.arange(ANGLES) * TURN / ANGLES
    return np.interp(grid, there[order], value[order], period=TURN)
