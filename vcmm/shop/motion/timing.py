"""Time law: canonical moves to jerk- and acceleration-limited motion of every axis, as a function of time.

    timing = plan_motion(program.moves, machine)
    timing.seconds                                   cycle time
    timing.state(times)                              position, speed, acceleration and jerk of XYZABC at any time

Position, speed and acceleration are continuous; speed, acceleration and jerk of every axis stay within its limits. The
path is the programmed one but for corners, which are rounded within the tolerance (`blend`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.program.limits import AXES, Control, Limits, axis_limits
from vcmm.program.moves import Move, Program
from vcmm.shop.motion.blend import blend_coefficients
from vcmm.shop.motion.curves import TINY, Curves, Ints, curves_of, largest_derivatives
from vcmm.shop.motion.joints import Bools, Joints, joints_of

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


@dataclass(frozen=True, eq=False)
class AxisState:
    """Axes XYZABC at k times, (k, 6) each; path: s, ds/dt and element, (k,)."""

    position: Array
    speed: Array
    acceleration: Array
    jerk: Array
    s: Array
    path_speed: Array
    element: Ints


@dataclass(frozen=True, eq=False)
class Timing:
    """Motion of a program in time. Stretches run from rest to rest; `phase` rows are s, v, a, jerk, seconds."""

    moves: tuple[Move, ...]
    moving: Ints  # index of each moving move in `moves`
    ends: Array  # s at which each moving move ends
    curves: Curves
    elements: Elements
    joints: Joints
    first: Ints
    last: Ints
    phase: Array
    stretch: Ints
    start: Array  # s: start of each phase
    limits: Limits
    control: Control

    @property
    def begun(self) -> Array:
        """Start of each stretch, s."""
        return self.start[np.searchsorted(self.stretch, np.arange(len(self.first)))]

    @property
    def stretch_ends(self) -> Array:
        """End of each stretch, s."""
        final = np.searchsorted(self.stretch, np.arange(len(self.first)), side="right") - 1
        return self.start[final] + self.phase[final, 4]

    @property
    def seconds(self) -> float:
        """Cycle time, pauses included."""
        return (
            float(self.stretch_ends[-1] + self.joints.pause[-1])
            if len(self.first)
            else float(self.joints.pause.sum())
        )

    def state(self, times: Array) -> AxisState:
        """Where every axis is and how it moves at times (k,) s; at rest before, between and after the stretches."""
        row = np.clip(np.searchsorted(self.start, times, side="right") - 1, 0, len(self.start) - 1)
        s0, v0, a0, jerk, length = self.phase[row].T
        since = times - self.start[row]
        resting = (since > length * (1 + 1e-12)) | (since < 0)
        t = np.clip(since, 0.0, length)
        s = s0 + t * (v0 + t * (a0 / 2 + t * jerk / 6))
        v = np.where(resting, 0.0, v0 + t * (a0 + t * jerk / 2))
        a = np.where(resting, 0.0, a0 + t * jerk)
        return self.state_on_path(s, v, a, np.where(resting, 0.0, jerk), self.stretch[row])

    def state_on_path(self, s: Array, v: Array, a: Array, jerk: Array, stretch: Ints) -> AxisState:
        """The chain rule: q' = q_s v, q'' = q_s a + q_ss v^2, q''' = q_s j + 3 q_ss v a + q_sss v^3."""
        e = self.elements
        element = np.searchsorted(e.edge, s, side="right") - 1
        element = np.clip(element, self.first[stretch], self.last[stretch])
        along = s - e.edge[element] + e.offset[element]
        q, q1, q2, q3 = (self.curves.at(e.curve[element], along, order) for order in range(4))
        v_, a_, j_ = v[:, None], a[:, None], jerk[:, None]
        acceleration = q1 * a_ + q2 * v_**2
        out = q, q1 * v_, acceleration, q1 * j_ + 3 * q2 * v_ * a_ + q3 * v_**3
        return AxisState(*out, s=s, path_speed=v, element=element)

    def move_at(self, s: Array, element: Ints) -> Ints:
        """Index in `moves` of the move at s (k,); a rounded corner belongs half to either."""
        owner = np.searchsorted(self.ends, s - 1e-12 * (1 + np.abs(s)), side="left")
        before = np.searchsorted(self.ends, self.elements.edge[element] + TINY, side="right")
        out: Ints = self.moving[np.clip(np.maximum(owner, before), 0, len(self.moving) - 1)]
        return out


def plan_motion(
    program: Program | Sequence[Move], machine: Machine, control: Control | None = None, kernel: bool = True
) -> Timing:
    """Plan the whole program. kernel=False takes the twin in plain Python.

    Raises UsageError, naming the line, where a move needs an axis the machine lacks or a feed that is missing.
    """
    moves = program.moves if isinstance(program, Program) else tuple(program)
    control, limits = control or Control(), axis_limits(machine)
    curves = curves_of(moves)
    _check(moves, curves, limits)
    moving = np.flatnonzero(curves.length > TINY)
    own = _only(curves, moving)
    work = _Work(moves, moving, own, control, limits, kernel)
    timing = _planned(work, None)
    if not timing.joints.rounded.any():
        return timing
    halting = _planned(work, timing.joints.rounded)
    slower = _way_seconds(halting, timing.joints.stop) < _way_seconds(timing, timing.joints.stop) * (1 - 1e-12)
    way = np.cumsum(np.append(0, timing.joints.stop))[1:]
    return _planned(work, slower[way]) if slower.any() else timing


@dataclass(frozen=True, eq=False)
class _Work:
    """What is to be planned: moves, those that move, their curves."""

    moves: Sequence[Move]
    moving: Ints
    own: Curves
    control: Control
    limits: Limits
    kernel: bool


def _planned(work: _Work, halt: Bools | None) -> Timing:
    """The motion with a stop at the corners `halt`."""
    own, moves = work.own, work.moves
    joints = joints_of(moves, work.moving, own, work.control, work.limits, halt)
    elements, all_curves, first, last = _elements([moves[i] for i in work.moving], own, joints, work.limits)
    phase, stretch = plan_stretches(elements, first, last, work.kernel)
    start = np.cumsum(phase[:, 4]) - phase[:, 4]
    held = np.concatenate([joints.pause[:1], joints.pause[1:-1][joints.stop]]) if len(first) else np.zeros(0)
    start += np.cumsum(held)[stretch]
    return Timing(
        moves=tuple(moves), moving=work.moving, ends=np.cumsum(own.length), curves=all_curves, elements=elements, joints=joints,
        first=first, last=last, phase=phase, stretch=stretch, start=start, limits=work.limits, control=work.control,
    )  # fmt: skip


def _way_seconds(timing: Timing, stop: Bools) -> Array:
    """Time of motion between the joints `stop` (n-1,), at each of which `timing` stops, too."""
    own = np.append(0, np.cumsum(stop))[np.append(0, np.flatnonzero(timing.joints.stop) + 1)]
    return np.asarray(np.bincount(own[timing.stretch], weights=timing.phase[:, 4]))


def _check(moves: Sequence[Move], curves: Curves, limits: Limits) -> None:
    """Every axis that moves exists, and every cutting move has a feed."""
    absent = [i for i, letter in enumerate(AXES) if letter not in limits.letters]
    amplitude = np.abs(curves.coefficients[:, 1])
    rows = np.flatnonzero(curves.arc >= 0)
    amplitude[rows] += np.hypot(curves.cosine, curves.sine)[curves.arc[rows]]
    lost = np.argwhere(amplitude[:, absent] > TINY)
    if len(lost):
        line, letter = moves[lost[0, 0]].source.line, AXES[absent[lost[0, 1]]]
        raise UsageError(
            f"line {line} moves axis {letter}, which the machine lacks; it has {', '.join(limits.letters)}. "
            "Choose the machine the program was written for"
        )
    for move in moves:
        if move.kind in ("line", "arc", "thread") and not (move.feed or 0) > 0:
            raise UsageError(f"line {move.source.line}: the move has no feed; write one, for example F500")


def _only(curves: Curves, rows: Ints) -> Curves:
    return Curves(
        curves.coefficients[rows],
        curves.length[rows],
        curves.arc[rows],
        curves.sweep,
        curves.cosine,
        curves.sine,
    )


def _elements(
    moves: Sequence[Move], own: Curves, joints: Joints, limits: Limits
) -> tuple[Elements, Curves, Ints, Ints]:
    """(elements, curves with the roundings behind those of the moves, first and last element of each stretch)."""
    n, rounded, smooth = own.n, np.flatnonzero(joints.reach > 0), joints.smooth
    reach = joints.reach[rounded]
    curves = own.with_polynomials(blend_coefficients(own, rounded, rounded + 1, reach, reach), 2 * reach)
    curves = curves.with_polynomials(smooth.coefficients, smooth.length)
    lead = np.concatenate([np.zeros(min(n, 1)), joints.reach])
    begins = np.cumsum(own.length) - own.length
    straight = own.length - lead - np.concatenate([joints.reach, np.zeros(min(n, 1))])
    kept = np.flatnonzero((straight > TINY) & ~smooth.whole)
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
    edge = np.append(starts, begins[-1] + own.length[-1]) if n else np.zeros(1)
    edge[first] = np.append(0.0, begins[stops + 1])[: len(first)]
    speed, needs = _ability(curves, curve, feeds, limits)
    return Elements(edge, curve, offset, speed, needs), curves, first, last.astype(np.intp)


def _ability(curves: Curves, curve: Ints, feed: Array, limits: Limits) -> tuple[Array, Array]:
    """Highest speed (n,) and needs (n, 5) of the elements: what each unit of path motion asks of the axes."""
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
    """(phases (k, 5), stretch of each phase) of stretches first..last of elements."""
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
