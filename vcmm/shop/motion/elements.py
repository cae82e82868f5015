"""Elements: the path piece by piece, each with its highest speed and its demands on the axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.core.run import Array
from vcmm.program.limits import Limits
from vcmm.program.moves import Move
from vcmm.shop.motion.blend import blend_coefficients
from vcmm.shop.motion.curves import LEAST_MOVE_MM, Curves, Ints, largest_derivatives
from vcmm.shop.motion.joints import Joints

ON_CURVES = 0.6  # share of the acceleration that a bend may take; the rest is for speeding up and braking
ON_ARCS = 0.8  # on arcs both are at right angles: 0.8 sideways leaves 0.6 along, 0.8^2 + 0.6^2 = 1
JERK_ON_CURVES = 0.5


@dataclass(frozen=True, eq=False)
class Elements:
    """The path piece by piece, rounded corners among them. edge (n+1,) programmed distance; speed (n,) highest."""

    edge: Array
    curve: Ints
    offset: Array
    speed: Array
    needs: Array  # (n, 5), see vcmm.shop.motion.profile


def elements_of(
    moves: Sequence[Move], curves_of_moves: Curves, joints: Joints, limits: Limits
) -> tuple[Elements, Curves, Ints, Ints]:
    """Return (elements, curves with the roundings behind those of the moves, first and last element of each stretch)."""
    n, rounded, smooth = curves_of_moves.n, np.flatnonzero(joints.reach > 0), joints.smooth
    reach = joints.reach[rounded]
    curves = curves_of_moves.with_polynomials(
        blend_coefficients(curves_of_moves, rounded, rounded + 1, reach, reach), 2 * reach
    )
    curves = curves.with_polynomials(smooth.coefficients, smooth.length)
    lead = np.concatenate([np.zeros(min(n, 1)), joints.reach])
    begins = np.cumsum(curves_of_moves.length) - curves_of_moves.length
    straight = curves_of_moves.length - lead - np.concatenate([joints.reach, np.zeros(min(n, 1))])
    kept = np.flatnonzero((straight > LEAST_MOVE_MM) & ~smooth.whole)
    corners, pieces = len(rounded), len(smooth.begin)
    kind = np.repeat([0, 0, 1], [len(kept), pieces, corners])  # a rounding comes after its move
    owner = np.concatenate([kept, smooth.move, rounded])
    starts = np.concatenate([begins[kept] + lead[kept], smooth.begin, begins[rounded + 1] - reach])
    order = np.lexsort((starts, kind, owner))
    curve = np.concatenate([kept, n + corners + np.arange(pieces), n + np.arange(corners)])[order]
    offset = np.concatenate([lead[kept], np.zeros(pieces + corners)])[order]
    feed = np.array([np.inf if m.feed is None else m.feed / 60.0 for m in moves])
    corner_feed = np.minimum(feed[rounded], feed[rounded + 1])
    feeds = np.concatenate([feed[kept], feed[smooth.move], corner_feed])[order]
    starts, owner = starts[order], owner[order]
    stops = np.flatnonzero(joints.stop)
    later: Ints = np.searchsorted(owner, stops, side="right")
    first = np.concatenate([np.zeros(min(n, 1), dtype=np.intp), later])
    last = np.append(first[1:], len(curve))[: len(first)] - 1
    edge = np.append(starts, begins[-1] + curves_of_moves.length[-1]) if n else np.zeros(1)
    edge[first] = np.append(0.0, begins[stops + 1])[: len(first)]
    speed, needs = _ability(curves, curve, feeds, limits)
    return Elements(edge, curve, offset, speed, needs), curves, first, last.astype(np.intp)


def _ability(curves: Curves, curve: Ints, feed: Array, limits: Limits) -> tuple[Array, Array]:
    """Return the highest speed (n,) and needs (n, 5) of the elements: demands on the axes per unit of path motion."""
    q1, q2, q3 = largest_derivatives(curves)
    arc = curves.arc >= 0
    p1, p2 = (q1 / limits.acceleration).max(axis=1), (q2 / limits.acceleration).max(axis=1)
    r1, r2, r3 = ((factor * q / limits.jerk).max(axis=1) for factor, q in ((1.0, q1), (3.0, q2), (1.0, q3)))
    with np.errstate(divide="ignore"):
        fastest = 1.0 / (q1 / limits.speed).max(axis=1)
        bend = np.sqrt(np.where(arc, ON_ARCS, ON_CURVES) / p2)
        jerk = np.cbrt(JERK_ON_CURVES / r3)
    speed = np.minimum(np.minimum(fastest, bend), jerk)[curve]
    half = np.where(arc, 0.5, 1.0)  # sqrt(1 - x^2) >= 1 - x/2 up to x = 0.8
    needs = np.stack([p1, half * p2, r1, r2, r3], axis=1)[curve]
    return np.minimum(speed, feed), needs


def plan_stretches(elements: Elements, first: Ints, last: Ints, kernel: bool) -> tuple[Array, Ints]:
    """Return (phases (k, 5), stretch of each phase) of stretches first..last of elements."""
    if not len(first):
        return np.zeros((0, 5)), np.zeros(0, dtype=np.intp)
    if kernel:
        from vcmm.shop.motion._timing_kernels import plan_stretches

        phase, stretch = plan_stretches(elements.edge, elements.speed, elements.needs, first, last)
        return phase, stretch.astype(np.intp)
    from vcmm.shop.motion.profile import plan_stretch

    rows = [plan_stretch(elements.edge, elements.speed, elements.needs, a, b) for a, b in zip(first, last)]
    counts = [len(r) for r in rows]
    return np.array([phase for r in rows for phase in r]), np.repeat(np.arange(len(rows)), counts)
