"""Recut: some of the points once more, with the tools really moved by the errors, to say how far the contacts err.

The contacts move the surface by (N . e) / (N . n). In vcmm.cutting.contactmap.audit the sweeps themselves are
displaced by the errors along their way and asked again. Left out of both sides: effects that depend on the normal of the
surface (wear, runout, scatter) and the tilt of the tool, which are no displacement of a whole tool; and what jumps or
starts like a root from rest: reversal, speed and acceleration, rounded corners.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vcmm.cutting.contactmap import Ints, audit
from vcmm.cutting.envelope import CUT, CutSurface
from vcmm.cutting.sweeps import Sweep
from vcmm.errors import ModelLimit
from vcmm.machine import Machine
from vcmm.machining.states import states_at
from vcmm.machining.toolside import cutting_effects
from vcmm.nc.toolpath import Toolpath
from vcmm.run import Array, Run

JUMPING = ("sense_", "since_reversal_", "play_", "speed_", "accel_", "time_since_accel")
POINTS, BESIDE = 60, 2  # points that are cut again; moves before and after those that touch them


@dataclass(frozen=True, eq=False)
class Recut:
    """Largest difference between contacts and displaced sweeps, mm, over `points` points."""

    largest: float
    points: int


def recut(
    path: Toolpath, sweep: Sweep, machine: Machine, surface: CutSurface, constants: dict[str, float]
) -> Recut | None:
    """Compare on at most POINTS of the points of `surface`, evenly chosen; None where the errors change too fast for it."""
    cut = np.flatnonzero(surface.status == CUT)
    if not len(cut):
        return None
    part = surface.take(cut[np.unique(np.linspace(0, len(cut) - 1, POINTS).astype(int))])
    plain = _whole_tool(machine)
    rows = _around(part.row, len(sweep))
    near = sweep.take(rows)

    def moved(at: Array, row: Ints, share: Array) -> Array:
        states, _ = states_at(path, near.move[row], share, at)
        return -plain.indication_error(_bare(states, constants))

    near_row = np.where(part.row < 0, -1, np.searchsorted(rows, part.row))
    try:
        found = audit(replace(part, row=near_row), near, moved)
    except ModelLimit:
        return None
    return Recut(found.largest, found.compared)


def _whole_tool(machine: Machine) -> Machine:
    """The machine without what depends on the surface or jumps."""
    moves, _, _ = cutting_effects(machine)
    kept = [e for e in moves.effects if "nx" not in e.required() and e.link != "reading"]
    smooth = tuple(e for e in kept if not any(c.startswith(JUMPING) for c in e.required()))
    return replace(moves, effects=smooth)


def _around(row: Ints, count: int) -> Ints:
    """The rows that touch a point, and a few before and after each, in order."""
    touched = np.unique(row[row >= 0])
    wide = (touched[:, None] + np.arange(-BESIDE, BESIDE + 1)).ravel()
    return np.unique(wide[(wide >= 0) & (wide < count)])


def _bare(states: Run, constants: dict[str, float]) -> Run:
    columns = {k: v for k, v in states.columns.items() if not k.startswith("tip_")}
    columns |= {name: np.full(states.n, value) for name, value in constants.items()}
    return Run(states.position, states.offset, columns, states.labels, states.series)
