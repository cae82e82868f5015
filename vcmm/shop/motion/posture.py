"""Solve for the angles of the rotary axes that turn the tool into a direction, and choose those that a program requires.

Newton's method with the pseudo-inverse from several starts, which leaves an axis that does not matter (a singular position) at its
angle. Two rotary axes mostly point the tool alike at two positions. The one that is taken:

    without a word     the nearest: its largest turn is the smallest; of two equally near the one whose primary axis is positive, as in
                       the example of HEIDENHAIN, iTNC 530 conversational programming, "Selection of alternate tilting possibilities"
    PLANE SEQ+ SEQ-    the one whose primary axis, the first seen from the tool or the last seen from the table, is positive, negative
    PLANE SYM+ SYM-    the one whose primary axis lies on the positive, negative side of the point between both
    CYCLE800 _DIR      the larger (1) or smaller (-1) value of the axis to which the direction refers, which the builder chooses and the
                       editor calls rotary axis 1; the other one where that cannot be reached (SINUMERIK 828D operating manual, "swiveling")
    G53.1              FANUC: the one whose first axis turns least, of equal ones whose second axis turns least, then the one whose first and
                       then whose second axis is nearest to zero; of a head and a table the table counts first (FANUC 16i/18i-MB
                       operator's manual, "angle of rotation axis", output judgement conditions)
    G53.1 P1 P2        the one whose first axis is positive, negative, as postprocessors for FANUC and Mazak controls write it

First axis: of two on one side of the machine the one nearer to the bed, else the one of the head (FANUC 16i operator's manual, "angle of
rotation axis": tool = first, table = second rotation axis).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from vcmm.core.axes import ROTARY
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.program.moves import Posture
from vcmm.shop.motion.tool_pose import by_letter, ends_of, rotary_of, tip_and_axis

LEAST_TILT = 1e-12  # of the tool axis, rad
STEPS, DIFFERENCE_STEP_RAD = 60, 1e-6
STARTS = (0.0, 0.5 * np.pi, -0.5 * np.pi, np.pi)
TURN = 2.0 * np.pi
SLACK = 1e-9  # rad beyond a travel
JUMP = 0.2  # rad from one point of a path to the next, beyond an even turn: an axis jumps
SAME_ANGLE = 1e-6  # rad between two positions that are the same


def primary_axis(machine: Machine) -> int:
    """Return the number (0 = A) of the first rotary axis seen from the tool; without one in the head, the last seen from the table."""
    tool = [a for a in machine.chain.tool if a in ROTARY]  # from the bed outwards
    work = [a for a in machine.chain.work if a in ROTARY]
    return ROTARY.index(tool[-1] if tool else work[0])


def first_axis(machine: Machine) -> int:
    """Return the number of the first rotary axis as FANUC and Siemens count: of the head before that of the table, from the bed outwards."""
    return rotary_of(machine)[0]


def reference_axis(machine: Machine, posture: Posture) -> int:
    """Return the number of the axis that a word of the program means."""
    return primary_axis(machine) if posture.axis == "primary" else first_axis(machine)


def rotary_position(
    machine: Machine, axis: Array, near: Array, posture: Posture | None = None
) -> Array | None:
    """Return angles A, B, C (3,) rad that turn the tool into a direction (3,) of the workpiece: the nearest to `near` (3,), or as requested.

    None where no position of the rotary axes within their travels does.
    """
    letters = rotary_of(machine)
    if posture is None:
        close_by = _newton(machine, axis, near, letters)
        step = None if close_by is None else _within(machine, close_by, near, letters)
        if step is not None and np.abs(step - near).max() < 0.1:
            return step  # a small step from where the axes stand
    every = positions(machine, axis, near)
    if posture is not None:
        every = _asked_for(machine, every, near, posture)
    reached = [q for q in (_within(machine, angles, near, letters) for angles in every) if q is not None]
    if not reached:
        return None
    if posture is not None and posture.by_axis and not posture.sign:
        return min(reached, key=lambda q: _turns_by_axis(machine, q, near))
    main = primary_axis(machine)
    least = min(float(np.abs(q - near).max()) for q in reached)
    nearest = [q for q in reached if np.abs(q - near).max() < least + SAME_ANGLE]
    best = max(nearest, key=lambda q: q[main])
    along = None if posture is None else posture.along
    return best if along is None else _laid_along(machine, best, np.array(along))


def swept_angles(machine: Machine, start: Array, end: Array, share: Array) -> Array | None:
    """Return the angles (k, 3) at shares (k,) of a path on which the tool axis turns evenly in the plane of its directions at both ends.

    a(s) = (sin((1 - s) w) a0 + sin(s w) a1) / sin w, w the angle between them. None where an axis would have to jump.
    """
    first, last = _direction(machine, np.stack([start, end]))
    between = float(np.arctan2(np.linalg.norm(np.cross(first, last)), first @ last))
    if between < 1e-9:
        return np.asarray(start + share[:, None] * (end - start))
    if between > np.pi - 1e-6:
        return None
    out, now = np.empty((len(share), 3)), start
    for k, s in enumerate(share.tolist()):
        axis = (np.sin((1.0 - s) * between) * first + np.sin(s * between) * last) / np.sin(between)
        angles = rotary_position(machine, axis / np.linalg.norm(axis), now)
        if angles is None or np.abs(angles - now).max() > JUMP + np.abs(end - start).max() / max(
            len(share) - 1, 1
        ):
            return None
        out[k] = now = angles
    if share[-1] == 1.0 and np.abs(out[-1] - end).max() > 1e-6:
        return None
    return out


def positions(machine: Machine, axis: Array, near: Array) -> list[Array]:
    """Return all angles (3,) that point the tool along `axis`, each within half a turn of zero. Of a singular position, where one axis may
    have any angle, the solution from `near`."""
    letters = rotary_of(machine)
    out: list[Array] = []
    has_free = False
    for start in _starts(near, letters):
        position = _newton(machine, axis, start, letters)
        if position is None:
            continue
        if _is_free(machine, position, letters):
            if has_free:
                continue
            has_free = True
        if all(np.abs(_wrap_angle(position - other)).max() > SAME_ANGLE for other in out):
            out.append(position)
    return out


def _wrap_angle(angle: Array) -> Array:
    """Return the angle within half a turn of zero."""
    return np.asarray(np.pi - np.remainder(np.pi - angle, TURN))


def _starts(near: Array, letters: list[int]) -> Iterator[Array]:
    yield near
    for first in STARTS:
        for second in STARTS if len(letters) > 1 else (0.0,):
            out = near.copy()
            for letter, value in zip(letters, (first, second)):
                out[letter] = value
            yield out


def _value(machine: Machine, angle: float, letter: int) -> float | None:
    """Return the angle plus whole turns, within the travel and as near to zero as can be; None where it cannot be reached."""
    low, high = machine.axes[ROTARY[letter]].limits
    first = float(_wrap_angle(np.array(angle)))
    allowed = [v for v in (first, first - TURN, first + TURN) if low - SLACK <= v <= high + SLACK]
    return min(allowed, key=abs, default=None)


def _asked_for(machine: Machine, every: Sequence[Array], near: Array, posture: Posture) -> list[Array]:
    """Return the positions that a word of the program allows."""
    axis, letters = reference_axis(machine, posture), rotary_of(machine)
    if posture.sign:
        kept = []
        for angles in every:
            value = _value(machine, float(angles[axis]), axis)
            value = float(_wrap_angle(angles[axis])) if value is None else value
            if value * posture.sign > -SAME_ANGLE:
                kept.append(angles)
        return kept
    if not posture.larger:
        return list(every)
    reached = [angles for angles in every if _within(machine, angles, near, letters) is not None]
    chosen = every if posture.binding else reached
    if not chosen:
        return []

    def size(angles: Array) -> float:
        value = _value(machine, float(angles[axis]), axis)
        return posture.larger * (float(_wrap_angle(angles[axis])) if value is None else value)

    most = max(size(angles) for angles in chosen)
    return [angles for angles in chosen if size(angles) > most - SAME_ANGLE]


def _turns_by_axis(machine: Machine, angle: Array, near: Array) -> tuple[float, ...]:
    """Return the quantities that FANUC compares, one after another: the turns of both axes, then their distances from zero; in steps of
    SAME_ANGLE."""
    tool = [a for a in machine.chain.tool if a in ROTARY]
    work = [a for a in machine.chain.work if a in ROTARY]
    order = [
        ROTARY.index(a) for a in (work + tool if tool and work else tool or work)
    ]  # from the bed outwards; the table first
    turns = [abs(float(angle[i] - near[i])) for i in order]
    away = [abs(float(angle[i])) for i in order]
    return tuple(round(v / SAME_ANGLE) * SAME_ANGLE for v in (*turns, *away))


def _is_free(machine: Machine, angle: Array, letters: list[int]) -> bool:
    """Return whether an axis may turn without turning the tool."""
    moved = np.tile(angle, (len(letters) + 1, 1))
    for row, letter in enumerate(letters, 1):
        moved[row, letter] += DIFFERENCE_STEP_RAD
    directions = _direction(machine, moved)
    return bool(np.linalg.norm(directions[1:] - directions[0], axis=1).min() < 1e-5 * DIFFERENCE_STEP_RAD)


def _laid_along(machine: Machine, angle: Array, along: Array) -> Array | None:
    """Return the angles with the free axis that carries the part turned so that the direction `along` (3,) of the workpiece lies along X
    of the machine;
    unchanged where that axis is not free. None beyond its travel."""
    carrier = machine.chain.work[-1:]
    letters = [ROTARY.index(a) for a in carrier if a in ROTARY]
    if not letters or not _is_free(machine, angle, letters):
        return angle
    both = np.stack([angle, angle])
    both[1, letters] += 0.25
    _, tool, work = ends_of(machine, by_letter(machine, np.zeros((2, 3)), both))
    now, then = work.turn(np.tile(along, (2, 1)))
    up = tool.turn(np.tile([0.0, 0.0, 1.0], (2, 1)))[0]
    wanted = np.array([1.0, 0.0, 0.0])
    sense = np.sign(float(np.cross(now, then) @ up))
    out = angle.copy()
    out[letters] += sense * float(np.arctan2(np.cross(now, wanted) @ up, now @ wanted))
    return _within(machine, out, angle, letters)


def _direction(machine: Machine, angle: Array) -> Array:
    """Return the tool axes (k, 3) at angles (k, 3)."""
    none = np.zeros_like(angle)
    return tip_and_axis(machine, none, angle, none)[1]


def _newton(machine: Machine, axis: Array, start: Array, letters: list[int]) -> Array | None:
    """Solve for the angles from a start at which the tool axis is `axis`; None where it does not converge."""
    angle = start.copy()
    for _ in range(STEPS):
        moved = np.tile(angle, (len(letters) + 1, 1))
        for row, letter in enumerate(letters, 1):
            moved[row, letter] += DIFFERENCE_STEP_RAD
        directions = _direction(machine, moved)
        miss = axis - directions[0]
        if np.linalg.norm(miss) < LEAST_TILT * 10:
            return angle
        slope = (directions[1:] - directions[0]).T / DIFFERENCE_STEP_RAD
        step = np.linalg.pinv(slope, rcond=1e-5) @ miss
        size = float(np.abs(step).max(initial=0.0))
        if size < 1e-14:
            return angle if np.linalg.norm(miss) < 1e-9 else None
        angle[letters] += step * min(1.0, 0.5 / size)
    return angle if np.linalg.norm(axis - _direction(machine, angle[None])[0]) < 1e-9 else None


def _within(machine: Machine, angle: Array, near: Array, letters: list[int]) -> Array | None:
    """Return the same orientation with every axis turned by whole turns: within its travel and as near as can be."""
    out = angle.copy()
    for letter in letters:
        low, high = machine.axes[ROTARY[letter]].limits
        first = near[letter] + np.remainder(angle[letter] - near[letter] + np.pi, TURN) - np.pi
        allowed = [v for v in (first, first - TURN, first + TURN) if low - SLACK <= v <= high + SLACK]
        if not allowed:
            return None
        out[letter] = min(allowed, key=lambda v, letter=letter: abs(v - near[letter]))  # type: ignore[misc]
    return out
