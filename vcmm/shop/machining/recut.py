"""Recut some of the points with the tools moved by the errors, to check the error of the contacts.

Milled: the contacts keep a few cuts per point, and the tool beside them along its path, and move the surface by
(N . e) / (N . n). Here the sweeps themselves are displaced by the errors along their way and searched again. Left out of both
sides: effects that depend on the normal of the surface (wear, runout, scatter) and the tilt of the tool, which are no
displacement of a whole tool; what jumps or starts like a root from rest: reversal, speed and acceleration, forces, rounded
corners; and, where rotary axes turn, the mean error along the machine axes, which a work offset holds.

Turned: every pass of some turns before and after the contacts, each displaced by the errors of the machine at that very time
and angle of the spindle; the deepest remains.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.effect import required
from vcmm.core.errors import ModelLimit
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.shop.cutting.contactmap import Contacts, Ints
from vcmm.shop.cutting.displacement import displace
from vcmm.shop.cutting.envelope import CUT, CutSurface, surface_left, tips
from vcmm.shop.cutting.index import build
from vcmm.shop.machining.contact_path import tool_side
from vcmm.shop.machining.lathe import LatheProcess, LatheSurface
from vcmm.shop.machining.milling import MillingProcess
from vcmm.shop.machining.neighbours import candidates
from vcmm.shop.machining.process import GOUGE, PreparedCut
from vcmm.shop.machining.rotary import commands_to_work
from vcmm.shop.machining.rotary_milling import RotaryMillingProcess
from vcmm.shop.machining.tool_errors import cutting_effects
from vcmm.shop.machining.turned_passes import with_all_passes
from vcmm.shop.machining.turned_surface import TurnedSurface
from vcmm.shop.machining.turning import TurningProcess
from vcmm.shop.machining.warming import add_temperatures

JUMPING = ("sense_", "since_reversal_", "play_", "speed_", "accel_", "time_since_accel", "force_")
POINTS, BESIDE = 60, 2  # points that are cut again; moves before and after those that touch them


@dataclass(frozen=True, eq=False)
class Recut:
    """Largest difference between contacts and displaced sweeps, mm, over `points` points."""

    largest: float
    points: int


def recut(job: PreparedCut, surface: CutSurface) -> Recut | None:
    """Compare on at most POINTS of the points of `surface`, evenly chosen; None where the errors change too fast for it.

    Points in the side of a gouge by the program itself are left out: they move by more than any error.
    """
    if isinstance(job.process, TurningProcess):
        assert isinstance(surface, TurnedSurface)
        return _with_all_passes(job, job.process, surface)
    if isinstance(job.process, LatheProcess):
        return _on_lathe(job, job.process, surface)
    assert isinstance(job.process, MillingProcess)
    cut = np.flatnonzero((surface.status == CUT) & (surface.contact_s[:, 0] >= -GOUGE))
    return _recut(job, job.process, surface.take(_evenly(cut))) if len(cut) else None


def _on_lathe(job: PreparedCut, process: LatheProcess, surface: CutSurface) -> Recut | None:
    """Compare both ways of cutting, each over its own points."""
    assert isinstance(surface, LatheSurface)
    cuts = []
    for of_tools, part_surface, mine in (
        (process.turning, surface.by_turning, ~surface.driven),
        (process.driving, surface.by_milling, surface.driven),
    ):
        part = part_surface.take(np.flatnonzero(mine))
        if len(part.points):
            cuts.append(recut(replace(job, process=of_tools), part))
    possible = [r for r in cuts if r is not None]
    return (
        Recut(max(r.largest for r in possible), sum(r.points for r in possible))
        if len(possible) == len(cuts)
        else None
    )


def _evenly(points: Ints) -> Ints:
    return points[np.unique(np.linspace(0, len(points) - 1, POINTS).astype(int))]


def _with_all_passes(job: PreparedCut, process: TurningProcess, surface: TurnedSurface) -> Recut:
    part = surface.take(_evenly(np.arange(len(surface.points))))
    few, many = (_heights(job, cut_surface) for cut_surface in (part, with_all_passes(process.turning, part)))
    return Recut(float(np.abs(many - few).max(initial=0.0)), len(part.points))


def _heights(job: PreparedCut, surface: CutSurface) -> Array:
    names = np.array([str(i) for i in range(len(surface.points))])
    tool, contacts = tool_side(job, surface, names, names)
    return contacts.surface(tool.errors())


def _recut(job: PreparedCut, process: MillingProcess, part: CutSurface) -> Recut | None:
    sweep, plain = process.sweep, _whole_tool(job.machine)
    contacts = candidates(part, sweep, tips(part, sweep), process.standing)
    feed = np.array([job.path.timing.moves[i].kind != "rapid" for i in sweep.move.tolist()])
    rows = _around(contacts.row, feed)
    near = sweep.take(rows)
    turns = isinstance(process, RotaryMillingProcess)
    zero = np.zeros(3)  # what a work offset would hold, machine axes

    def ways(at: Array, row: Ints, share: Array) -> tuple[Array, Array | None]:
        """Return errors (k, 3), and the effect of a shift of the machine axes there (k, 3, 3)."""
        states, _ = process.on_path(job, rows[row], share, at)
        error = -plain.indication_error(_with_constants(states, job))
        return error, commands_to_work(job.machine, states) if turns else None

    def tip_error(at: Array, row: Ints, share: Array) -> Array:
        error, way = ways(at, row, share)
        return error if way is None else error - way @ zero

    where = contacts.row >= 0
    at, row, share = contacts.tip[where], np.searchsorted(rows, contacts.row[where]), contacts.share[where]
    error, way = ways(at, row, share)
    if (
        way is not None
    ):  # a zero set on the machine takes the mean along X, Y, Z, and the table turns the rest
        zero = np.asarray(np.einsum("nji,nj->ni", way, error).mean(axis=0))
    try:
        bent = displace(near, tip_error)
    except ModelLimit:
        return None
    again = surface_left(part.points, part.normals, build(bent), candidates=1)
    shift = np.zeros((*where.shape, 3))
    shift[where] = error if way is None else error - way @ zero
    number = np.where(where, np.arange(where.size).reshape(where.shape), -1)
    surface = Contacts(contacts.height, contacts.cutter, part.normals, number).surface(shift.reshape(-1, 3))
    both = np.isfinite(again.s) & np.isfinite(surface)
    return Recut(float(np.abs(again.s - surface)[both].max(initial=0.0)), int(both.sum()))


def _whole_tool(machine: Machine) -> Machine:
    """Return the machine without effects that depend on the surface or jump."""
    moves, _, _ = cutting_effects(machine)
    kept = [e for e in moves.effects if "nx" not in required(e) and e.link != "reading"]
    smooth = tuple(e for e in kept if not any(c.startswith(JUMPING) for c in required(e)))
    return replace(moves, effects=smooth)


def _around(row: Ints, feed: np.typing.NDArray[np.bool_]) -> Ints:
    """Return the rows that touch a point, and a few feed moves before and after each, in order. feed (m,): of each row."""
    touched = np.unique(row[row >= 0])
    wide = (touched[:, None] + np.arange(-BESIDE, BESIDE + 1)).ravel()
    wide = wide[(wide >= 0) & (wide < len(feed))]
    return np.unique(np.concatenate([touched, wide[feed[wide]]]))


def _with_constants(states: Run, job: PreparedCut) -> Run:
    states = states.with_columns({n: np.full(states.n, v) for n, v in job.scenario.constants.items()})
    return add_temperatures(states, job.scenario.setup.log)
