"""Displaced sweeps: tool tips moved by errors, cut into pieces along which the error is linear enough."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from vcmm.core.errors import ModelLimit
from vcmm.core.laws import Array
from vcmm.shop.cutting.sweeps import LINE, Sweep, pieces, position

CHORD = 5e-5  # mm: 0.05 um
MOST_PIECES = 4096  # pieces of one move
_INSIDE = np.array([0.25, 0.5, 0.75])

Displacement = Callable[[Array, Array, Array], Array]
"""Displacement (m, 3) mm at tip positions (m, 3), rows (m,) of the sweep and fractions t (m,) of the row."""


def displace(sweep: Sweep, field: Displacement, tolerance: float = CHORD) -> Sweep:
    """Return the sweep moved by `field`, cut so that the error departs from its chord by at most `tolerance` (mm) at the quarters.

    Arcs stay arcs: the piece of the circle is moved by the error at its start and the change of the error along the piece
    is added in proportion to the angle. `move` still names the source.
    """
    counts = knots(sweep, field, tolerance)
    parts, row, t0, t1 = pieces(sweep, counts)
    e0, e1 = field(position(sweep.take(row), t0), row, t0), field(position(sweep.take(row), t1), row, t1)
    straight = (parts.kind == LINE)[:, None]
    change = np.where(straight, 0.0, e1 - e0)
    before = np.zeros_like(e0) if parts.drift is None else parts.drift
    return replace(
        parts,
        start=parts.start + e0,
        end=parts.end + np.where(straight, e1, e0),
        centre=parts.centre + e0,
        drift=before + change,
    )


def knots(sweep: Sweep, field: Displacement, tolerance: float) -> Array:
    """Return the number of equal pieces (m,) of every row that keeps the chord of the error within tolerance."""
    counts = np.ones(len(sweep), int)
    open_ = np.arange(len(sweep))
    while len(open_):
        parts = sweep.take(open_)
        worst = np.zeros(len(open_))
        row = np.repeat(np.arange(len(open_)), counts[open_])
        number = np.arange(len(row)) - np.repeat(np.cumsum(counts[open_]) - counts[open_], counts[open_])
        each = parts.take(row)
        size = 1.0 / counts[open_][row]

        def error(
            at: float, each: Sweep = each, row: Array = row, number: Array = number, size: Array = size
        ) -> Array:
            t = (number + at) * size
            return field(position(each, t), open_[row], t)  # noqa: B023 - used within this turn of the loop only

        e0, e1 = error(0.0), error(1.0)
        for w in _INSIDE:
            off = np.linalg.norm(error(float(w)) - (1 - w) * e0 - w * e1, axis=1)
            np.maximum.at(worst, row, off)
        more = worst > tolerance
        open_ = open_[more]
        counts[open_] = np.ceil(
            counts[open_] * np.clip(np.sqrt(worst[more] / tolerance) * 1.1, 1.5, 8.0)
        ).astype(int)
        if np.any(counts > MOST_PIECES):
            bad = int(np.argmax(counts))
            raise ModelLimit(
                f"displaced: move {sweep.move[bad]} would need more than {MOST_PIECES} pieces for a chord of {tolerance * 1e3:.3g} "
                "um; the error changes too fast along it. Ask for a larger tolerance, or check the error for jumps."
            )
    return counts


def split_by_direction(sweep: Sweep, tolerance: float) -> Sweep:
    """Return the simultaneous 5-axis moves as short moves of constant tool direction: an approximation, its step is stated.

    The direction of a piece is that at its middle; the part of the tool at most one nose height or radius from the tip is
    then out of place by at most `tolerance` mm (half the change of direction times the larger of the two). Lines only.
    """
    if sweep.axis_end is None:
        return sweep
    if np.any(sweep.kind != LINE):
        raise ModelLimit("indexed: only straight moves can tilt; cut arcs into lines first")
    angle = np.arccos(np.clip(np.einsum("mi,mi->m", sweep.axis, sweep.axis_end), -1.0, 1.0))
    lever = np.array([np.hypot(t.radius, min(2 * t.radius, t.length)) for t in sweep.tools])[sweep.tool]
    counts = np.maximum(np.ceil(angle * lever / (2.0 * tolerance)), 1).astype(int)
    parts, row, t0, t1 = pieces(replace(sweep, axis_end=None), counts)
    middle = 0.5 * (t0 + t1)[:, None]
    sine = np.sin(angle[row])[:, None]
    near = sine < 1e-12
    a, b = np.sin((1 - middle) * angle[row][:, None]), np.sin(middle * angle[row][:, None])
    axis = np.where(
        near, sweep.axis[row], (a * sweep.axis[row] + b * sweep.axis_end[row]) / np.where(near, 1.0, sine)
    )
    return replace(parts, axis=axis / np.linalg.norm(axis, axis=1)[:, None])
