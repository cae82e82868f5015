"""Recut: some of the points once more, with the tools really moved by the errors, to say how far the contacts err.

The contacts keep a few cuts per point, and the tool beside them along its path, and move the surface by (N . e) / (N . n).
Here the sweeps themselves are displaced by the errors along their way and asked again. Left out of both sides: effects that
depend on the normal of the surface (wear, runout, scatter) and the tilt of the tool, which are no displacement of a whole
tool; what jumps or starts like a root from rest: reversal, speed and acceleration, rounded corners; and, where rotary axes
turn, the mean error along the machine axes, which a work offset holds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.errors import ModelLimit
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.cutting.contactmap import Contacts, Ints
from vcmm.cutting.displaced import displaced
from vcmm.cutting.envelope import CUT, CutSurface, surface_left, tips
from vcmm.cutting.index import build
from vcmm.cutting.sweeps import Sweep
from vcmm.machining.neighbours import candidates
from vcmm.machining.rotary import Motion, commands_to_work
from vcmm.machining.states import states_at, turning_states
from vcmm.machining.tool_errors import cutting_effects
from vcmm.motion.toolpath import Toolpath

JUMPING = ("sense_", "since_reversal_", "play_", "speed_", "accel_", "time_since_accel")
POINTS, BESIDE = 60, 2  # points that are cut again; moves before and after those that touch them


@dataclass(frozen=True, eq=False)
class Recut:
    """Largest difference between contacts and displaced sweeps, mm, over `points` points."""

    largest: float
    points: int


def recut(
    path: Toolpath, sweep: Sweep, machine: Machine, surface: CutSurface, constants: dict[str, float], motion: Motion | None = None,
) -> Recut | None:  # fmt: skip
    """Compare on at most POINTS of the points of `surface`, evenly chosen; None where the errors change too fast for it."""
    cut = np.flatnonzero(surface.status == CUT)
    if not len(cut):
        return None
    part = surface.take(cut[np.unique(np.linspace(0, len(cut) - 1, POINTS).astype(int))])
    plain = _whole_tool(machine)
    feed = np.array([path.timing.moves[i].kind != "rapid" for i in sweep.move.tolist()])
    known = candidates(part, sweep, tips(part, sweep), motion=motion)
    rows = _around(known.row, feed)
    near = sweep.take(rows)

    zero = np.zeros(3)  # what a work offset would hold, machine axes

    def moved(at: Array, row: Ints, share: Array) -> Array:
        if motion is None:
            states, _ = states_at(path, near.move[row], share, at)
            return -plain.indication_error(_bare(states, constants))
        states, _ = turning_states(path, motion, rows[row], share, at)
        return -plain.indication_error(_bare(states, constants)) - commands_to_work(machine, states) @ zero

    where = known.row >= 0
    at, row, share = known.tip[where], np.searchsorted(rows, known.row[where]), known.share[where]
    if motion is not None:
        zero = _mean_in_machine_axes(moved(at, row, share), path, motion, rows[row], share, at)
    try:
        bent = displaced(near, moved)
    except ModelLimit:
        return None
    again = surface_left(part.points, part.normals, build(bent), candidates=1)
    shift = np.zeros((*where.shape, 3))
    shift[where] = moved(at, row, share)
    number = np.where(where, np.arange(where.size).reshape(where.shape), -1)
    found = Contacts(known.height, known.cutter, part.normals, number).surface(shift.reshape(-1, 3))
    both = np.isfinite(again.s) & np.isfinite(found)
    return Recut(float(np.abs(again.s - found)[both].max(initial=0.0)), int(both.sum()))


def _mean_in_machine_axes(
    moved: Array, path: Toolpath, motion: Motion, row: Ints, share: Array, at: Array
) -> Array:
    """Mean error (3,) along X, Y, Z: a zero set on the machine takes it, and the table turns the rest."""
    ways = commands_to_work(motion.machine, turning_states(path, motion, row, share, at)[0])
    return np.asarray(np.einsum("nji,nj->ni", ways, moved).mean(axis=0))


def _whole_tool(machine: Machine) -> Machine:
    """The machine without what depends on the surface or jumps."""
    moves, _, _ = cutting_effects(machine)
    kept = [e for e in moves.effects if "nx" not in e.required() and e.link != "reading"]
    smooth = tuple(e for e in kept if not any(c.startswith(JUMPING) for c in e.required()))
    return replace(moves, effects=smooth)


def _around(row: Ints, feed: np.typing.NDArray[np.bool_]) -> Ints:
    """The rows that touch a point, and a few feed moves before and after each, in order. feed (m,): of each row."""
    touched = np.unique(row[row >= 0])
    wide = (touched[:, None] + np.arange(-BESIDE, BESIDE + 1)).ravel()
    wide = wide[(wide >= 0) & (wide < len(feed))]
    return np.unique(np.concatenate([touched, wide[feed[wide]]]))


def _bare(states: Run, constants: dict[str, float]) -> Run:
    columns = {k: v for k, v in states.columns.items() if not k.startswith("tip_")}
    columns |= {name: np.full(states.n, value) for name, value in constants.items()}
    return Run(states.position, states.offset, columns, states.labels, states.series)
