"""Overlap: a control that may leave a corner by the tolerance starts the next move before the previous one has come to rest.

Both moves keep the time law that brings them to rest and sets them going; the last T of the first and the first T of the second are
run at the same time. With the jerks j1 and j2 of these two phases, t from the start of the overlap and directions u1, u2,

    q = corner - u1 j1 (T - t)^3 / 6 + u2 j2 t^3 / 6,

so that every axis has the constant jerk u1 j1 + u2 j2, the program is left by |u2 - u1| times the smaller of j1 (T - t)^3 / 6 and
j2 t^3 / 6, and exactly T is saved. For j1 = j2 = j the deviation is largest at T / 2: T = 2 (6 tolerance / j |u2 - u1|)^(1/3).
A quarter turn of X into Y within 10 um at 50 m/s^3: (6 x 0.010 / (50000 x 1.4142))^(1/3) = 9.47 ms, T = 18.9 ms.

Where the jerks of both moves together are more than an axis has (a turn of less than 90 degrees), nothing overlaps: the control stops.
Method: that of the trajectory planner of LinuxCNC, which blends the acceleration of one move into the deceleration of the
other within the tolerance of G64 P; here with limited jerk.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vcmm.core.run import Array
from vcmm.program.limits import Limits
from vcmm.shop.motion.blend import WEIGHT
from vcmm.shop.motion.curves import Curves, Ints
from vcmm.shop.motion.elements import Elements
from vcmm.shop.motion.joints import Joints

Bools = np.typing.NDArray[np.bool_]
LEAST_OVERLAP_MM = 1e-5  # mm: an overlap over less of a move is none
JERK_ROUNDING_SHARE = 1e-9  # share by which the jerk of an axis may be exceeded: rounding


class StretchPlan(NamedTuple):
    """Elements, their curves, first and last element of each stretch, phases (k, 5) and the stretch of each."""

    elements: Elements
    curves: Curves
    first: Ints
    last: Ints
    phase: Array
    stretch: Ints


class _Overlaps(NamedTuple):
    """Data of k corners: number of the stop (k,), seconds T, jerks j1 and j2, directions u1 and u2 (k, 6), place of the corner (k, 6)."""

    stop: Ints
    seconds: Array
    before: Array
    after: Array
    leaving: Array
    joining: Array
    corner: Array

    @property
    def reach(self) -> Array:
        """Programmed distance of both moves that is run at the same time (k, 2) mm."""
        return np.stack([self.before, self.after], axis=1) * (self.seconds**3 / 6)[:, None]


def overlap_stops(
    plan: StretchPlan, curves: Curves, joints: Joints, limits: Limits
) -> tuple[StretchPlan, Bools]:
    """Return (the plan with overlaps at the stops that only a corner requires, which of the joints (n-1,) they are)."""
    none = np.zeros(len(joints.stop), dtype=bool)
    if not joints.is_held.any():
        return plan, none
    overlaps = _overlaps(plan, curves, joints, limits)
    if not len(overlaps.stop):
        return plan, none
    overlapped = none.copy()
    overlapped[np.flatnonzero(joints.stop)[overlaps.stop]] = True
    return _join(plan, overlaps), overlapped


def _overlaps(plan: StretchPlan, curves: Curves, joints: Joints, limits: Limits) -> _Overlaps:
    """Return the stops at corners of two lines whose axes can do both at once, with the longest overlap that tolerance and phases allow."""
    joint = np.flatnonzero(joints.stop)
    stop = np.flatnonzero(joints.is_held[joint])
    joint = joint[stop]
    end, begin = plan.last[stop], plan.first[stop + 1]
    lines = _is_straight(plan, end) & _is_straight(plan, begin)
    last = np.searchsorted(plan.stretch, stop, side="right") - 1
    j1, j2 = plan.phase[last, 3], plan.phase[last + 1, 3]
    u1 = curves.at(joint, curves.length[joint], 1)
    u2, corner = curves.at(joint + 1, np.zeros(len(joint)), 1), curves.at(joint + 1, np.zeros(len(joint)))
    most = np.abs(u1 * j1[:, None] + u2 * j2[:, None])
    able = lines & (j1 > 0) & (j2 > 0) & (most <= limits.jerk * (1 + JERK_ROUNDING_SHARE)).all(axis=1)
    j1, j2 = np.where(able, j1, 1.0), np.where(able, j2, 1.0)
    ratio, size = np.cbrt(j1 / j2), np.linalg.norm((u2 - u1) * WEIGHT, axis=1)
    seconds = np.cbrt(6 * joints.tolerance[joint] / (np.maximum(size, 1e-300) * j2)) * (1 + ratio) / ratio
    for row, element, jerk in ((last, end, j1), (last + 1, begin, j2)):
        length = plan.elements.edge[element + 1] - plan.elements.edge[element]
        seconds = np.minimum(seconds, np.minimum(plan.phase[row, 4], np.cbrt(6 * length / jerk)))
    kept = able & (np.minimum(j1, j2) * seconds**3 / 6 > LEAST_OVERLAP_MM)
    return _Overlaps(*(x[kept] for x in (stop, seconds, j1, j2, u1, u2, corner)))


def _is_straight(plan: StretchPlan, element: Ints) -> Bools:
    curve = plan.elements.curve[element]
    return np.asarray((plan.curves.arc[curve] < 0) & ~plan.curves.coefficients[curve, 2:].any(axis=(1, 2)))


def _join(plan: StretchPlan, overlaps: _Overlaps) -> StretchPlan:
    """Join two stretches and the overlap between them into one."""
    e, d = plan.elements, overlaps.reach
    begin = plan.first[overlaps.stop + 1]  # the elements behind the corners
    corner = e.edge[begin]
    edge, offset = e.edge.copy(), e.offset.copy()
    edge[begin] += d[:, 1]
    offset[begin] += d[:, 1]
    curves = plan.curves.with_timed(_coefficients(overlaps), d)
    number = plan.curves.n + np.arange(len(begin))
    slowest = overlaps.before * overlaps.after / (overlaps.before + overlaps.after) * overlaps.seconds**2 / 2
    elements = Elements(
        np.insert(edge, begin, corner - d[:, 0]),
        np.insert(e.curve, begin, number),
        np.insert(offset, begin, 0.0),
        np.insert(e.speed, begin, slowest),
        np.insert(e.needs, begin, 0.0, axis=0),
    )
    stays = np.ones(len(plan.first), dtype=bool)
    stays[overlaps.stop + 1] = False
    first = plan.first[stays]
    first = first + np.searchsorted(begin, first, side="left")
    last = np.append(first[1:], len(elements.curve)) - 1
    phase, stretch = _phases(plan, overlaps, corner, stays)
    return StretchPlan(elements, curves, first, last.astype(np.intp), phase, stretch)


def _coefficients(overlaps: _Overlaps) -> Array:
    """Return q = corner - u1 d1 (1 - u)^3 + u2 d2 u^3 by powers of u = t / T, (k, 6, 6)."""
    leaving, joining = overlaps.leaving * overlaps.reach[:, :1], overlaps.joining * overlaps.reach[:, 1:]
    nothing = np.zeros_like(leaving)
    return np.stack(
        [overlaps.corner - leaving, 3 * leaving, -3 * leaving, leaving + joining, nothing, nothing], axis=1
    )


def _phases(plan: StretchPlan, overlaps: _Overlaps, corner: Array, stays: Bools) -> tuple[Array, Ints]:
    """Return the phases with the last T before and the first T behind each corner as one of constant jerk j1 + j2."""
    phase, t, d = plan.phase.copy(), overlaps.seconds, overlaps.reach
    behind = np.searchsorted(plan.stretch, overlaps.stop + 1, side="left")
    phase[behind - 1, 4] -= t
    phase[behind, 0] = corner + d[:, 1]
    phase[behind, 1], phase[behind, 2] = overlaps.after * t**2 / 2, overlaps.after * t
    phase[behind, 4] -= t
    both = np.stack(
        [
            corner - d[:, 0],
            overlaps.before * t**2 / 2,
            -overlaps.before * t,
            overlaps.before + overlaps.after,
            t,
        ],
        axis=1,
    )
    number = (np.cumsum(stays) - 1)[plan.stretch]
    phase, stretch = np.insert(phase, behind, both, axis=0), np.insert(number, behind, number[behind])
    kept = phase[:, 4] > 1e-13
    return phase[kept], stretch[kept].astype(np.intp)
