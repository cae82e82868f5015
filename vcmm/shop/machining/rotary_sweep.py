"""The sweep of a program in workpiece axes with rotary axes off zero: exact while they rest, short lines while they turn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vcmm.core.errors import ModelLimit
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.shop.cutting.contactmap import Ints
from vcmm.shop.cutting.sweeps import LINE, Sweep, check_sweep
from vcmm.shop.cutting.tools import Cutter
from vcmm.shop.machining.rotary import Bools, RotaryMotion, machine_position
from vcmm.shop.motion.tool_pose import tip_and_axis

SEARCH = 0.002  # mm: by which a row may miss the turning tool; what it finds is then put right exactly
SEARCH_RAPID = 0.05  # mm: the same of rapids, which should touch nothing
EVERY = 0.05  # rad of the rotary axes between two looks at the way
LEAST_LOOKS = 16
MOST_ROWS = 2_000_000  # rows
NO_TURN_RAD = 1e-10  # rad
LEAST_ROW_MM = 1e-9  # mm: a row needs a length
SQUARE = 1e-9


def turns(turned: Array) -> Bools:
    """Return the rows (m, 2, 3) whose rotary axes move."""
    return np.asarray(np.abs(turned[:, 1] - turned[:, 0]).max(axis=1) > NO_TURN_RAD)


def in_workpiece(
    machine: Machine, base: Sweep, turned: Array, offset: Array, rapid: Bools, search: float = SEARCH
) -> tuple[Sweep, RotaryMotion]:
    """Return the sweep in workpiece axes, in the order of the moves. base, turned, offset: as in RotaryMotion; rapid (m,); search: mm by which a
    row may miss a turning tool that cuts."""
    is_affine, bent = _affine(machine, base, turned, offset)
    free = turns(turned) | (bent & (base.kind != LINE))
    counts = np.ones(len(base), dtype=int)
    if free.any():
        rows = np.flatnonzero(free)
        limit = np.where(rapid[rows], max(SEARCH_RAPID, search), search)
        counts[rows] = _counts(machine, base, turned, offset, rows, limit)
    _check_count(counts, base)
    row = np.repeat(np.arange(len(base)), counts)
    number = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)
    first, last = number / counts[row], (number + 1) / counts[row]
    sweep = is_affine.take(row)
    whole = RotaryMotion(
        machine=machine,
        base=base,
        angles=turned,
        offset=offset,
        row=row,
        first=first,
        last=last,
        inexact=free[row],
        sweep=sweep,
        rapid=rapid,
    )
    loose = np.flatnonzero(free[row])
    sweep = check_sweep(_with_pieces(sweep, whole, loose))
    return sweep, replace(whole, sweep=sweep)


def _affine(machine: Machine, base: Sweep, turned: Array, offset: Array) -> tuple[Sweep, Bools]:
    """Return (the moves seen from the part with rotary axes held as at their start, rows (m,) in which circles do not stay circles)."""

    def seen(points: Array) -> tuple[Array, Array]:
        return tip_and_axis(machine, points, turned[:, 0], offset, base.axis)

    origin = seen(np.zeros_like(base.start))[0]
    ways = np.stack([seen(np.tile(e, (len(base), 1)))[0] - origin for e in np.eye(3)], axis=2).round(15)
    bent = np.abs(np.einsum("mji,mjk->mik", ways, ways) - np.eye(3)).max(axis=(1, 2)) > SQUARE
    start, axis = seen(base.start)
    centre = origin + np.einsum("mij,mj->mi", ways, base.centre)
    normal = np.einsum("mij,mj->mi", ways, base.normal)
    return replace(
        base, start=start, end=seen(base.end)[0], centre=centre, normal=normal, axis=axis
    ), np.asarray(bent)


def _reference(tools: tuple[Cutter, ...]) -> tuple[Array, Array]:
    """Return (height of the point of each tool that is led exactly, mm; lever from there to its cutting edges, mm)."""
    height = np.array([t.corner for t in tools])  # centre of a ball: its nose does not feel a tilt
    lever = np.array([np.hypot(t.radius, min(2 * t.radius, t.length)) for t in tools])
    return height, lever


def _counts(
    machine: Machine, base: Sweep, turned: Array, offset: Array, rows: Ints, limit: Array
) -> np.typing.NDArray[np.int64]:
    """Return the pieces of each row that keep chord and tilt within its limit (mm)."""
    angle = np.abs(turned[rows, 1] - turned[rows, 0]).max(axis=1) + np.abs(base.turn[rows])
    looks = np.maximum(np.ceil(angle / EVERY), LEAST_LOOKS).astype(int)
    out = np.ones(len(rows), dtype=np.int64)
    height, lever = (values[base.tool[rows]] for values in _reference(base.tools))
    for some in np.unique(looks):
        mine = np.flatnonzero(looks == some)
        at = np.repeat(rows[mine], some + 1)
        share = np.tile(np.linspace(0.0, 1.0, some + 1), len(mine))
        position = machine_position(base, turned, at, share)
        tip, axis = (
            v.reshape(len(mine), some + 1, 3)
            for v in tip_and_axis(machine, *position, offset[at], base.axis[at])
        )
        led = tip + height[mine, None, None] * axis
        bend = np.linalg.norm(np.diff(led, 2, axis=1), axis=2).max(axis=1) * some**2
        tilt = np.linalg.norm(np.diff(axis, axis=1), axis=2).max(axis=1) * some
        chords = np.sqrt(bend / (8.0 * limit[mine]))  # sagitta of a piece: |p''| / 8 n^2
        tilts = tilt * lever[mine] / (2.0 * limit[mine])
        out[mine] = np.maximum(np.ceil(np.maximum(chords, tilts)), 1)
    return out


def _check_count(counts: Array, base: Sweep) -> None:
    if counts.sum() > MOST_ROWS:
        raise ModelLimit(
            f"the turning moves of the program would need {counts.sum():.3g} pieces, more than {MOST_ROWS:.0e}; most of them in its "
            f"move {base.move[int(np.argmax(counts))] + 1}. Cut the program into parts and simulate them one by one"
        )


def _with_pieces(sweep: Sweep, motion: RotaryMotion, rows: Ints) -> Sweep:
    """Return the sweep with `rows` replaced by lines along which the tool keeps the direction of their middle."""
    if not len(rows):
        return sweep
    middle = 0.5 * (motion.first[rows] + motion.last[rows])
    height = _reference(sweep.tools)[0][sweep.tool[rows]][:, None]
    axis = motion.pose(motion.row[rows], middle)[1]

    def tip_path(share: Array) -> Array:
        tip, direction = motion.pose(motion.row[rows], share)
        return tip + height * (direction - axis)

    start, end = tip_path(motion.first[rows]), tip_path(motion.last[rows])
    short = np.linalg.norm(end - start, axis=1) < LEAST_ROW_MM
    end = end + np.where(short[:, None], LEAST_ROW_MM * axis, 0.0)
    out = {
        name: getattr(sweep, name).copy()
        for name in ("start", "end", "centre", "normal", "turn", "kind", "axis")
    }
    out["start"][rows], out["end"][rows], out["axis"][rows] = start, end, axis
    out["centre"][rows] = out["normal"][rows] = np.nan
    out["turn"][rows], out["kind"][rows] = 0.0, LINE
    return replace(sweep, **out)
