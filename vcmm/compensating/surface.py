"""What the tool does to the finished surface beside the known errors of its path, as an error of the path that can be corrected.

    gain_k . e(move_k, share_k) = d_k        d_k: departure of the finished surface at point k; gain: what a shift of the tool does there

A tool that bends, wears, runs out or is larger than its table entry, an axis that lags, a part that springs back: each leaves the
surface off by d. Any shift e of the tool with that gain does the same, so e is looked for along the program, linear between knots, moves
that follow one another sharing theirs; at a corner one shift serves both walls. Least squares over points on all features, smooth
where no point says anything (Tikhonov). e is then one more error of the machine, and everything else of compensate goes on as it is:
fixed point, splits, proof.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.compensating.contours import length_of, points, sweep_of
from vcmm.compensating.field import PathErrors, absent, known_errors_of
from vcmm.core.effect import Effect
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.cutting.contactmap import Contacts, Ints
from vcmm.cutting.envelope import CUT
from vcmm.machining.contact_path import contact_rows, surface_at, tool_side
from vcmm.machining.gauge import gauge_plan
from vcmm.machining.milling import MillingProcess
from vcmm.machining.preparation import set_up
from vcmm.machining.process import GOUGE, PreparedCut, Words
from vcmm.machining.scenario import CutScenario
from vcmm.nc.moves import Move

KNOT, MOST_KNOTS = 12.0, 24  # mm between knots of a line; of one move
TURN = np.pi / 8  # between knots of an arc
SMOOTH, SMALL = (
    0.03,
    1e-3,
)  # weights of what changes along a move and of its size against a point that is measured: chosen
STIFF = (
    3.0  # the same of moves that make no point of the surface: they go along as a whole, and stay one block
)
SEARCHED = 24  # places along a move, for the share of a point that stands beside it
MUCH = 0.3  # of the largest departure that is left on a feature, to be told by name: chosen
ALIKE = 0.02  # rad between the normals with which two passes touch one point: chosen
UNSEEN = 1e-6  # mm: below it there is nothing to correct


@dataclass(frozen=True, eq=False)
class SurfaceErrors:
    """moves of the program as it was; knots (n + 1,): first of those of each move in `value` (k, 3) mm; effects: ids that are in it."""

    moves: tuple[Move, ...]
    knots: Ints
    value: Array
    effects: tuple[str, ...]
    points: int
    left: float  # mm rms of d that no shift of the path takes out
    largest: float  # mm of d
    against: tuple[
        str, ...
    ]  # features on which most of it is left: their walls want the same tool to go two ways at once

    def at(self, low: Ints, high: Ints, tips: Array) -> Array:
        """e (k, 3) of tips (k, 3) on the nearest of moves low to high (k,)."""
        out, nearest = np.zeros((len(tips), 3)), np.full(len(tips), np.inf)
        for by in range(int((high - low).max(initial=0)) + 1):
            for move in np.unique(low[low + by <= high] + by).tolist():
                rows = np.flatnonzero((low + by == move) & (low + by <= high))
                share, gap = nearest_share(self.moves[move], tips[rows])
                closer = gap < nearest[rows] - 1e-9
                mine = rows[closer]
                out[mine] = self._along(move, share[closer])
                nearest[mine] = gap[closer]
        return out

    def _along(self, move: int, share: Array) -> Array:
        mine = self.value[self.knots[move] : self.knots[move + 1]]
        at = np.linspace(0.0, 1.0, len(mine))
        return np.stack([np.interp(share, at, mine[:, k]) for k in range(3)], axis=1)


def nearest_share(move: Move, tips: Array) -> tuple[Array, Array]:
    """Share (k,) of a move next to tips (k, 3), and how far they are from it, mm."""
    if move.kind != "arc":
        start, way = np.array(move.start), np.array(move.end) - np.array(move.start)
        square = float(way @ way)
        share = np.clip((tips - start) @ way / square, 0.0, 1.0) if square > 0 else np.ones(len(tips))
    else:
        grid = np.linspace(0.0, 1.0, max(SEARCHED, int(abs(sweep_of(move)) / 0.02)))
        on = points(move, grid)
        share = grid[np.argmin(((tips[:, None] - on) ** 2).sum(axis=2), axis=1)]
    return share, np.asarray(np.linalg.norm(tips - points(move, share), axis=1))


def surface_errors(scenario: CutScenario) -> SurfaceErrors | None:
    """What the path does not know of, on the features of the part; None where it is nothing.

    Raises UsageError for lathes, programs that turn rotary axes, and parts none of whose features is cut.
    """
    machine, ids = _beside_path(scenario.machine)
    job = set_up(replace(scenario, machine=machine, inputs=()))
    if type(job.process) is not MillingProcess:
        raise UsageError(
            "--surface corrects milling with the rotary axes at rest; on lathes and with turning rotary axes take --surface away: the path is "
            "corrected, and what belongs into the tool table stands in the answer of diagnose"
        )
    move, share, gain, gap, feature, count = _on_features(job)
    largest = float(np.abs(gap).max(initial=0.0))
    if largest < UNSEEN:
        return None
    moves = job.program.moves
    knots, same = _knots(moves)
    value, left = _solved(knots, same, _stiffness(moves, move), move=move, share=share, gain=gain, gap=gap)
    rms = float(np.sqrt(np.mean(left**2)))
    names = [str(n) for n in np.unique(feature) if np.abs(left[feature == n]).max() > MUCH * largest]
    return SurfaceErrors(
        moves=tuple(moves), knots=knots, value=value, effects=ids, points=count, left=rms, largest=largest, against=tuple(names),
    )  # fmt: skip


def _beside_path(machine: Machine) -> tuple[Machine, tuple[str, ...]]:
    """The machine with the effects only that the path is not corrected for, and their ids."""
    kept = set(map(id, known_errors_of(machine).machine.effects))
    rest: tuple[Effect, ...] = tuple(
        e for e in machine.effects if id(e) not in kept and not e.random and not absent(e)
    )
    return replace(machine, effects=rest, inputs=()), tuple(e.id for e in rest)


def _on_features(job: PreparedCut) -> tuple[Ints, Array, Array, Array, Words, int]:
    """Of cuts of points on the features of characteristics: move (k,) and share (k,) of it that cut them, gain (k, 3), departure (k,) mm outwards, feature;
    and how many points these are."""
    steps = gauge_plan(job.scenario.part, None).steps
    at, normals = (np.concatenate([getattr(s, name) for s in steps]) for name in ("points", "normals"))
    surface = surface_at(job, at, normals)
    good = np.flatnonzero((surface.status == CUT) & (surface.contact_s[:, 0] >= -GOUGE))
    if not len(good):
        raise UsageError("the program cuts no feature of the part, so there is no surface to correct")
    surface = surface.take(good)
    feature = np.concatenate([np.full(len(s.points), s.feature) for s in steps])[good]
    touch = np.array([str(i) for i in range(len(good))])
    tool, contacts = tool_side(job, surface, touch, feature)
    rows, errors = contact_rows(job, surface), tool.errors()
    of_row = job.sweep.move[rows.row].astype(np.intp)
    point, candidate = _making(contacts, errors, of_row)
    row, gain = contacts.row[point, candidate], contacts.gain[point, candidate]
    gap = (
        contacts.heights(errors)[point, candidate] - contacts.heights(np.zeros_like(errors))[point, candidate]
    )
    move = of_row[row]
    tips = rows.tip[row]
    share = np.array([float(nearest_share(job.program.moves[m], t[None])[0][0]) for m, t in zip(move, tips)])
    return move, share, gain, gap, feature[point], len(np.unique(point))


def _making(contacts: Contacts, errors: Array, move_of: Ints) -> tuple[Ints, Ints]:
    """(point, candidate) of the cuts that make the surface: at each point the deepest, and of every other move the one that comes as near
    with the same normal. A second pass along a wall, a floor or a ramp is to move as the first does, or it cuts what the first was led
    away from.

    move_of (rows,): the move of each row of the run.
    """
    alone, moved = contacts.heights(np.zeros_like(errors)), contacts.heights(errors)
    points, deepest = np.arange(len(alone)), moved.argmin(axis=1)
    gap = moved[points, deepest] - alone[points, deepest]
    good = np.isfinite(gap)
    near = 2.0 * np.abs(gap[good]).max(initial=0.0) + UNSEEN
    move = np.where(contacts.row >= 0, move_of[np.maximum(contacts.row, 0)], -1)
    aside = np.linalg.norm(contacts.cutter - contacts.cutter[points, deepest][:, None], axis=2)
    other = (move >= 0) & (move != move[points, deepest][:, None]) & np.isfinite(alone) & np.isfinite(moved)
    other &= (np.where(other, alone, np.inf) - alone[points, deepest][:, None] <= near) & (aside < ALIKE)
    for k in range(other.shape[1]):  # of several cuts of one move the lowest
        same = other & (move == move[:, [k]])
        other[:, k] &= moved[:, k] <= np.where(same, moved, np.inf).min(axis=1)
    other[points, deepest] = True
    point, candidate = np.nonzero(other & good[:, None])
    return point, candidate


def _knots(moves: Sequence[Move]) -> tuple[Ints, Ints]:
    """(first knot of each move (n + 1,), number of the unknown of each knot): a move begins with the shift with which the one before ends."""
    count = [
        2 + min(int(abs(sweep_of(m)) / TURN if m.kind == "arc" else length_of(m) / KNOT), MOST_KNOTS)
        if m.kind not in ("rapid", "dwell") else 2
        for m in moves
    ]  # fmt: skip
    first = np.concatenate([[0], np.cumsum(count)]).astype(np.intp)
    same = np.zeros(first[-1], dtype=np.intp)
    last = free = 0
    for m, k, low in zip(moves, count, first.tolist()):
        same[low : low + k] = [last, *range(free + 1, free + k)]
        free += k - 1
        if m.kind == "arc" and m.start == m.end:  # a full circle comes back to the shift with which it began
            same[low + k - 1] = last
        last = int(same[low + k - 1])
    return first, same


def _stiffness(moves: Sequence[Move], touched: Ints) -> Array:
    """Weight of a change along each move (n,): what cuts a point may bend, a rapid across may lead anywhere, the rest stays straight."""
    out = np.full(len(moves), STIFF)
    out[np.unique(touched)] = SMOOTH
    across = [m.kind == "rapid" and m.start[:2] != m.end[:2] for m in moves]
    out[np.array(across, dtype=bool)] = SMOOTH * SMALL
    return out


def _solved(
    knots: Ints, same: Ints, stiff: Array, *, move: Ints, share: Array, gain: Array, gap: Array
) -> tuple[Array, Array]:
    """e at the knots (k, 3), and what of every point no e takes out."""
    from scipy.sparse import coo_matrix, vstack
    from scipy.sparse.linalg import spsolve

    unknown, n = int(same.max()) + 1, len(gap)
    place = share * (knots[move + 1] - knots[move] - 1)
    low = np.minimum(place.astype(np.intp), knots[move + 1] - knots[move] - 2)
    weight = np.stack([1.0 - (place - low), place - low], axis=1)
    at = np.stack([same[knots[move] + low], same[knots[move] + low + 1]], axis=1)
    column = (3 * at[:, :, None] + np.arange(3)).reshape(n, 6)
    values = (weight[:, :, None] * gain[:, None, :]).reshape(n, 6)
    shows = coo_matrix((values.ravel(), (np.repeat(np.arange(n), 6), column.ravel())), (n, 3 * unknown))
    steps = np.delete(
        np.arange(len(same) - 1), knots[1:-1] - 1
    )  # within a move; its end is the start of the next
    a, b = (3 * same[steps + k][:, None] + np.arange(3) for k in (0, 1))
    pull = np.repeat(np.repeat(stiff, np.diff(knots))[steps], 3)
    change = coo_matrix(
        (
            np.concatenate([-pull, pull]),
            (np.tile(np.arange(a.size), 2), np.concatenate([a.ravel(), b.ravel()])),
        ),
        (a.size, 3 * unknown),
    )
    small = coo_matrix((np.full(3 * unknown, SMALL), (np.arange(3 * unknown),) * 2))
    whole = vstack([shows, change, small]).tocsc()
    right = np.concatenate([gap, np.zeros(whole.shape[0] - n)])
    found = spsolve((whole.T @ whole).tocsc(), whole.T @ right)
    return found.reshape(-1, 3)[same], np.asarray(gap - shows @ found)


def what_is_left(left: tuple[str, ...], surface: SurfaceErrors | None) -> tuple[str, ...]:
    """What is not corrected, and what is corrected on the finished surface instead of the path."""
    if surface is None:
        return left
    left = tuple(said for said in left if said.split(" ")[0] not in surface.effects)
    told = (
        f"{', '.join(surface.effects) or 'the path that the control takes (corners, lag)'}: corrected where {surface.points} points of the features are cut, up to {surface.largest * 1e3:.2f} um "
        f"along their normals; {surface.left * 1e3:.2f} um rms of it no shift of the path takes out. The same size is assumed for the next "
        "part: state of the tool, clamping, stock"
    )
    if not surface.against:
        return (*left, told)
    names = ", ".join(surface.against[:6]) + (" and others" if len(surface.against) > 6 else "")
    return (
        *left, told,
        f"{names}: what is off there stays in part, since one way of the tool makes surfaces that would have to move apart (both walls of a "
        "slot, both sides of a hole): cut them one after the other, with a smaller tool, or with one whose radius is the nominal one",
    )  # fmt: skip


def with_surface(field: PathErrors, surface: SurfaceErrors | None, name: str) -> PathErrors:
    """The field with what happens on the surface. UsageError where that was found with other moves than those that are rewritten."""
    if surface is not None and [(m.start, m.end) for m in field.moves] != [
        (m.start, m.end) for m in surface.moves
    ]:
        raise UsageError(
            f"{name}: the moves that were cut virtually are not those that are rewritten (another program or set-up?); name the "
            "scenario whose program this is"
        )
    return replace(field, surface=surface)
