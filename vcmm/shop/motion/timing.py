"""Time law: canonical moves to jerk- and acceleration-limited motion of every axis, as a function of time.

    timing = plan_motion(program.moves, machine)
    timing.seconds                                   cycle time
    timing.state(times)                              position, speed, acceleration and jerk of XYZABC at any time

Position, speed and acceleration are continuous; speed, acceleration and jerk of every axis stay within its limits. The
path is the programmed one but for corners, which are rounded within the tolerance (`blend`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.program.limits import AXES, Control, Limits, axis_limits
from vcmm.program.moves import Move, Program
from vcmm.shop.motion.curves import LEAST_MOVE_MM, Curves, Ints, curves_of
from vcmm.shop.motion.elements import Elements, elements_of, plan_stretches
from vcmm.shop.motion.joints import Bools, Joints, Wish, joints_of
from vcmm.shop.motion.overlap import StretchPlan, overlap_stops

TRIED = tuple(
    x * 10.0**n for n in (-3, -2, -1, 0) for x in (1.0, 2.0, 3.0, 5.0)
)  # mm: tolerances below that of a corner

MOST_TRIED = 2000  # moves for which that is done; beyond, only the stop is tried


@dataclass(frozen=True, eq=False)
class AxisState:
    """Axes XYZABC at k times, (k, 6) each; path: s, ds/dt and element, (k,)."""

    position: Array
    speed: Array
    acceleration: Array
    jerk: Array
    s: Array
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
    def stretch_starts(self) -> Array:
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
        """Return position and motion of every axis at times (k,) s; at rest before, between and after the stretches."""
        row = np.clip(np.searchsorted(self.start, times, side="right") - 1, 0, len(self.start) - 1)
        s0, v0, a0, jerk, length = self.phase[row].T
        since = times - self.start[row]
        resting = (since > length * (1 + 1e-12)) | (since < 0)
        t = np.clip(since, 0.0, length)
        end = self.elements.edge[self.last[self.stretch[row]] + 1] if len(self.last) else s0
        s = np.minimum(s0 + t * (v0 + t * (a0 / 2 + t * jerk / 6)), end)
        v = np.where(resting, 0.0, v0 + t * (a0 + t * jerk / 2))
        a = np.where(resting, 0.0, a0 + t * jerk)
        return self.state_on_path(s, v, a, np.where(resting, 0.0, jerk), self.stretch[row])

    def state_on_path(self, s: Array, v: Array, a: Array, jerk: Array, stretch: Ints) -> AxisState:
        """Return the state by the chain rule: q' = q_s v, q'' = q_s a + q_ss v^2, q''' = q_s j + 3 q_ss v a + q_sss v^3."""
        e = self.elements
        element = np.searchsorted(e.edge, s, side="right") - 1
        element = np.clip(element, self.first[stretch], self.last[stretch])
        along = s - e.edge[element] + e.offset[element]
        q, q1, q2, q3 = (self.curves.at(e.curve[element], along, order) for order in range(4))
        v_, a_, j_ = v[:, None], a[:, None], jerk[:, None]
        acceleration = q1 * a_ + q2 * v_**2
        out = q, q1 * v_, acceleration, q1 * j_ + 3 * q2 * v_ * a_ + q3 * v_**3
        return AxisState(*out, s=s, element=element)

    def move_at(self, s: Array, element: Ints) -> Ints:
        """Return the index in `moves` of the move at s (k,); a rounded corner belongs half to either."""
        owner = np.searchsorted(self.ends, s - 1e-12 * (1 + np.abs(s)), side="left")
        before = np.searchsorted(self.ends, self.elements.edge[element] + LEAST_MOVE_MM, side="right")
        out: Ints = self.moving[np.clip(np.maximum(owner, before), 0, len(self.moving) - 1)]
        return out


def plan_motion(
    program: Program | Sequence[Move], machine: Machine, control: Control | None = None, kernel: bool = True
) -> Timing:
    """Plan the motion of the whole program. kernel=False takes the twin in plain Python.

    Raises UsageError, naming the line, where a move needs an axis the machine lacks or a feed that is missing.
    """
    moves = program.moves if isinstance(program, Program) else tuple(program)
    control, limits = control or Control(), axis_limits(machine)
    curves = curves_of(moves)
    _check(moves, curves, limits)
    moving = np.flatnonzero(curves.length > LEAST_MOVE_MM)
    moving_curves = _only(curves, moving)
    return _fastest(_Work(moves, moving, moving_curves, control, limits, kernel))


def _fastest(work: _Work) -> Timing:
    """Plan each way between two ordered stops with the tolerance, or less of it, or a stop at its corners: whichever takes least time.

    So nothing is slower than stopping, and a wider tolerance is not slower than a narrower one of `TRIED`. Where only rows of short lines
    or a great many moves are open, the trials that cannot help or would last are left out.
    """
    timing = _plan(work, Wish())
    joints = timing.joints
    way = np.cumsum(np.append(0, joints.is_ordered))
    matters = joints.is_rounded | joints.is_held
    matters[joints.smooth.joints] |= joints.smooth.kept_short
    open_ways = np.unique(way[:-1][matters])
    part = np.flatnonzero(np.isin(way, open_ways))
    if not len(part) or (len(part) > MOST_TRIED and not joints.is_rounded.any()):
        return timing
    best, halt, below = _try(work, part, way[part], float(joints.tolerance.max()))
    if not best.any():
        return timing
    chosen = np.zeros(way[-1] + 1, dtype=bool), np.full(way[-1] + 1, np.inf)
    chosen[0][open_ways], chosen[1][open_ways] = halt, below
    return _plan(work, Wish(chosen[0][way[:-1]], chosen[1][way[:-1]]))


def _try(work: _Work, part: Ints, way: Ints, widest: float) -> tuple[Bools, Bools, Array]:
    """Try a plan: for each way of the moves `part`, return (is it faster than the tolerance itself, does it stop at corners, its tolerance)."""
    kept = [work.moves[i] for i in work.moving[part]]
    small = replace(work, moves=kept, moving=np.arange(len(part)), curves=_only(work.curves, part))
    ends = np.diff(way) > 0
    joints = len(ends)
    trials = [Wish(stop=ends), Wish(np.ones(joints, dtype=bool), stop=ends)]
    tried = [x for x in TRIED if x < widest] if len(part) <= MOST_TRIED else []
    trials += [Wish(below=np.full(joints, x), stop=ends) for x in tried]
    seconds = np.stack([_way_seconds(_plan(small, wish), ends) for wish in trials])
    faster = seconds < seconds[0] * (1 - 1e-9)
    which = np.where(faster.any(axis=0), np.where(faster, seconds, np.inf).argmin(axis=0), 0)
    return which > 0, which == 1, np.concatenate([[np.inf, np.inf], tried])[which]


@dataclass(frozen=True, eq=False)
class _Work:
    """Input of the planning: moves, those that move, their curves."""

    moves: Sequence[Move]
    moving: Ints
    curves: Curves
    control: Control
    limits: Limits
    kernel: bool


def _plan(work: _Work, wish: Wish) -> Timing:
    """Plan the motion with a stop at some corners, or below some tolerance."""
    curves, moves = work.curves, work.moves
    joints = joints_of(
        moves, work.moving, curves, work.control, work.limits, replace(wish, kernel=work.kernel)
    )
    elements, all_curves, first, last = elements_of(
        [moves[i] for i in work.moving], curves, joints, work.limits
    )
    phase, stretch = plan_stretches(elements, first, last, work.kernel)
    plan, overlapped = overlap_stops(
        StretchPlan(elements, all_curves, first, last, phase, stretch), curves, joints, work.limits
    )
    stop = joints.stop & ~overlapped
    start = np.cumsum(plan.phase[:, 4]) - plan.phase[:, 4]
    pauses = np.concatenate([joints.pause[:1], joints.pause[1:-1][stop]]) if len(first) else np.zeros(0)
    start += np.cumsum(pauses)[plan.stretch]
    return Timing(
        moves=tuple(moves), moving=work.moving, ends=np.cumsum(curves.length), curves=plan.curves, elements=plan.elements,
        joints=replace(joints, stop=stop, is_overlapped=overlapped), first=plan.first, last=plan.last, phase=plan.phase,
        stretch=plan.stretch, start=start, limits=work.limits, control=work.control,
    )  # fmt: skip


def _way_seconds(timing: Timing, stop: Bools) -> Array:
    """Return the time of motion between the joints `stop` (n-1,), at each of which `timing` stops, too."""
    stretch = np.append(0, np.cumsum(stop))[np.append(0, np.flatnonzero(timing.joints.stop) + 1)]
    return np.asarray(np.bincount(stretch[timing.stretch], weights=timing.phase[:, 4]))


def _check(moves: Sequence[Move], curves: Curves, limits: Limits) -> None:
    """Check that every axis that moves exists, and that every cutting move has a feed."""
    absent = [i for i, letter in enumerate(AXES) if letter not in limits.letters]
    amplitude = np.abs(curves.coefficients[:, 1])
    rows = np.flatnonzero(curves.arc >= 0)
    amplitude[rows] += np.hypot(curves.cosine, curves.sine)[curves.arc[rows]]
    lost = np.argwhere(amplitude[:, absent] > LEAST_MOVE_MM)
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
