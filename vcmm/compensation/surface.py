"""Effects of the tool on the finished surface beside the known errors of its path, as an error of the path that can be corrected.

    gain_k . e(move_k, share_k) = d_k        d_k: departure of the finished surface at point k; gain: effect of a shift of the tool there

A tool that bends, wears, runs out or is larger than its table entry, an axis that lags, a part that springs back: each leaves the
surface off by d. Any shift e of the tool with that gain does the same, so e is looked for along the program (vcmm.compensation.shifts); at a
corner one shift serves both walls. Corners that the control rounds within an unstated tolerance are not corrected. Their rounding is then one more error of the machine, and everything else of compensate goes on as it is:
fixed point, splits, proof.

The shift of the tool along a program that leaves the surface where it is to be, linear between knots, by least squares.

    at each point     over_k - gain_k . e  = 0   of the cut that makes it
                      over_k - gain_k . e >= 0   of every other cut that comes as near: it must not go deeper, and need not go as deep

Moves that follow one another share the knot between them. The inequalities are kept by squares of what violates them, so the problem is
convex; the set of those that count is found by turns (active set: Nocedal & Wright, Numerical Optimization, 2nd ed. (2006), ch. 16.5).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vcmm.compensation.contours import length_of, points, sweep_of
from vcmm.compensation.field import PathErrors, absent, known_errors_of
from vcmm.core.effect import Effect
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.program.moves import Move
from vcmm.shop.cutting.contactmap import Contacts, Ints
from vcmm.shop.cutting.envelope import CUT, CutSurface
from vcmm.shop.machining.contact_path import contact_rows, surface_at, tool_side
from vcmm.shop.machining.gauge import gauge_plan
from vcmm.shop.machining.milling import MillingProcess
from vcmm.shop.machining.preparation import set_up
from vcmm.shop.machining.process import GOUGE, ContactRows, PreparedCut, Words
from vcmm.task.measuring.cut_scenario import CutScenario

Bools = np.typing.NDArray[np.bool_]
KNOT, MOST_KNOTS = 12.0, 24  # mm between knots of a line; of one move
TURN = np.pi / 8  # between knots of an arc
# weights of what changes along a move and of its size against a point that is measured: chosen
CHANGE_WEIGHT = 0.03
SIZE_WEIGHT = 1e-3
# the same of moves that make no point of the surface: they go along as a whole, and stay one block
STIFF = 3.0
UNSEEN = 1e-6  # mm: below it there is nothing to correct
TURNS = 30  # of the search for the cuts that count


@dataclass(frozen=True, eq=False)
class Cuts:
    """k cuts of points on features: point, move and share of it, gain (k, 3), over (k,) mm above the nominal surface, and whether
    each makes its point; feature (points,)."""

    point: Ints
    move: Ints
    share: Array
    gain: Array
    over: Array
    makes: Bools
    feature: Words


def shifts_of(moves: Sequence[Move], cuts: Cuts) -> tuple[Ints, Array, Array]:
    """Return (first knot of each move (n + 1,), e at the knots (k, 3) mm, residual of every point (points,) mm)."""
    first, same = _knots(moves)
    counts, released = cuts.makes.copy(), np.zeros(len(cuts.over), dtype=bool)
    for _ in range(TURNS):
        stiff = _stiffness(moves, cuts.move[counts])
        value, shown = _solve(first, same, stiff, cuts, counts)
        over = cuts.over - shown
        deeper = ~counts & (over < -UNSEEN)
        free = counts & ~cuts.makes & ~released & (over > UNSEEN)  # it would be drawn down, which it need not
        if not deeper.any() and not free.any():
            break
        counts = (counts & ~free) | deeper
        released |= free  # once: what goes too deep again counts to the end
    left = np.full(len(cuts.feature), np.inf)
    np.minimum.at(left, cuts.point, cuts.over - shown)
    return first, value, left[np.isfinite(left)]


def _knots(moves: Sequence[Move]) -> tuple[Ints, Ints]:
    """Return (first knot of each move (n + 1,), number of the unknown of each knot): a move begins with the shift with which the one before ends."""
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
    """Return the weight of a change along each move (n,): moves that cut a point may bend, a rapid across may lead anywhere, the rest
    stays straight."""
    out = np.full(len(moves), STIFF)
    out[np.unique(touched)] = CHANGE_WEIGHT
    across = [m.kind == "rapid" and m.start[:2] != m.end[:2] for m in moves]
    out[np.array(across, dtype=bool)] = CHANGE_WEIGHT * SIZE_WEIGHT
    return out


def _solve(first: Ints, same: Ints, stiff: Array, cuts: Cuts, counts: Bools) -> tuple[Array, Array]:
    """Solve for e at the knots (k, 3) by the cuts that count, and its effect at every cut (k,)."""
    from scipy.sparse import coo_matrix, csr_matrix, vstack
    from scipy.sparse.linalg import spsolve

    unknown, n, move = int(same.max()) + 1, len(cuts.over), cuts.move
    place = cuts.share * (first[move + 1] - first[move] - 1)
    low = np.minimum(place.astype(np.intp), first[move + 1] - first[move] - 2)
    weight = np.stack([1.0 - (place - low), place - low], axis=1)
    at = np.stack([same[first[move] + low], same[first[move] + low + 1]], axis=1)
    column = (3 * at[:, :, None] + np.arange(3)).reshape(n, 6)
    values = (weight[:, :, None] * cuts.gain[:, None, :]).reshape(n, 6)
    shows = csr_matrix((values.ravel(), (np.repeat(np.arange(n), 6), column.ravel())), (n, 3 * unknown))
    steps = np.delete(
        np.arange(len(same) - 1), first[1:-1] - 1
    )  # within a move; its end is the start of the next
    a, b = (3 * same[steps + k][:, None] + np.arange(3) for k in (0, 1))
    pull = np.repeat(np.repeat(stiff, np.diff(first))[steps], 3)
    rows = np.tile(np.arange(a.size), 2)
    change = coo_matrix(
        (np.concatenate([-pull, pull]), (rows, np.concatenate([a.ravel(), b.ravel()]))), (a.size, 3 * unknown)
    )
    small = coo_matrix((np.full(3 * unknown, SIZE_WEIGHT), (np.arange(3 * unknown),) * 2))
    whole = vstack([shows[counts], change, small], format="csc")
    right = np.concatenate([cuts.over[counts], np.zeros(whole.shape[0] - int(counts.sum()))])
    solution = spsolve((whole.T @ whole).tocsc(), whole.T @ right)
    return solution.reshape(-1, 3)[same], np.asarray(shows @ solution)


SEARCH_PLACES = 24  # places along a move, for the share of a point beside it
MUCH = 0.3  # of the largest departure that is left on a feature, to be told by name: chosen
DAMPED = 0.5  # of what a round leaves, corrected in the next: at corners the whole of it swings
LARGEST_ANGLE = 0.02  # rad between the normals with which two passes touch one point: chosen
# times the largest departure: cuts that stay farther off take no part in a correction of that size
NEAR_BY = 3.0


@dataclass(frozen=True, eq=False)
class FeaturePoints:
    """Points (n, 3) on features with their normals, the height (n,) mm of the surface without errors, and the cuts that reach them."""

    at: Array
    normals: Array
    level: Array
    cuts: Cuts


@dataclass(frozen=True, eq=False)
class SurfaceErrors:
    """moves of the program as it was; knots (n + 1,): first of those of each move in `value` (k, 3) mm; effects: ids that are in it."""

    moves: tuple[Move, ...]
    knots: Ints
    value: Array
    effects: tuple[str, ...]
    points: int
    rest_rms: float  # mm rms of d that no shift of the path takes out
    largest: float  # mm of d
    against: tuple[
        str, ...
    ]  # features on which most of it is left: their walls want the same tool to go two ways at once
    on_features: FeaturePoints | None = None  # None: not found by a virtual cut
    origin: str = ""  # what it is, where it was not found by a virtual cut

    def at(self, low: Ints, high: Ints, tips: Array) -> Array:
        """Return e (k, 3) of tips (k, 3) on the nearest of moves low to high (k,)."""
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
    """Return the share (k,) of a move next to tips (k, 3), and how far they are from it, mm."""
    if move.kind != "arc":
        start, way = np.array(move.start), np.array(move.end) - np.array(move.start)
        square = float(way @ way)
        share = np.clip((tips - start) @ way / square, 0.0, 1.0) if square > 0 else np.ones(len(tips))
    else:
        grid = np.linspace(0.0, 1.0, max(SEARCH_PLACES, int(abs(sweep_of(move)) / 0.02)))
        on = points(move, grid)
        share = grid[np.argmin(((tips[:, None] - on) ** 2).sum(axis=2), axis=1)]
    return share, np.asarray(np.linalg.norm(tips - points(move, share), axis=1))


def surface_errors(scenario: CutScenario) -> SurfaceErrors | None:
    """Return the errors that the path does not know, on the features of the part; None where there are none.

    Raises UsageError for lathes, programs that turn rotary axes, and parts none of whose features is cut.
    """
    machine, ids = _beside_path(scenario.machine)
    job = set_up(replace(scenario, machine=machine, inputs=()))
    if type(job.process) is not MillingProcess:
        raise UsageError(
            "--surface corrects milling with the rotary axes at rest; on lathes and with turning rotary axes take --surface away: the path is "
            "corrected, and diagnose reports the entries for the tool table"
        )
    points = _on_features(job)
    cuts = points.cuts
    largest = float(np.abs(cuts.over[cuts.makes]).max(initial=0.0))
    if largest < UNSEEN:
        return None
    return _correction(job.program.moves, points, ids)


def _correction(moves: Sequence[Move], points_on: FeaturePoints, ids: tuple[str, ...]) -> SurfaceErrors:
    """Return the shifts of the tool for the heights of the cuts above the nominal surface."""
    cuts = points_on.cuts
    largest = float(np.abs(cuts.over[cuts.makes]).max(initial=0.0))
    knots, value, left = shifts_of(moves, cuts)
    feature, points = cuts.feature, len(left)
    rms = float(np.sqrt(np.mean(left**2)))
    names = [str(n) for n in np.unique(feature) if np.abs(left[feature == n]).max() > MUCH * largest]
    return SurfaceErrors(
        moves=tuple(moves), knots=knots, value=value, effects=ids, points=points, rest_rms=rms, largest=largest, against=tuple(names), on_features=points_on,
    )  # fmt: skip


def _beside_path(machine: Machine) -> tuple[Machine, tuple[str, ...]]:
    """Return the machine with the effects only that the path is not corrected for, and their ids."""
    kept = set(map(id, known_errors_of(machine).machine.effects))
    rest: tuple[Effect, ...] = tuple(
        e for e in machine.effects if id(e) not in kept and not e.about.is_random and not absent(e)
    )
    return replace(machine, effects=rest, inputs=()), tuple(e.id for e in rest)


def refined_surface(scenario: CutScenario, first: SurfaceErrors, program: Path) -> SurfaceErrors:
    """Return the correction after a further round: the departure of the part that the corrected program cuts (with all errors of the machine)
    is added to it. A tool on another path bends by another amount, so the first round is not exact."""
    job = set_up(replace(scenario, program=program))
    on_features = first.on_features
    if on_features is None:
        raise UsageError("what was measured on a face is not found anew by a virtual cut")
    surface = surface_at(job, on_features.at, on_features.normals)
    good = np.flatnonzero(surface.status == CUT)
    contacts, errors, _ = _cut_at(job, surface.take(good), on_features.cuts.feature[good])
    still = np.zeros(len(on_features.at))
    still[good] = contacts.surface(errors) - on_features.level[good]
    cuts = on_features.cuts
    over = cuts.over + DAMPED * np.where(cuts.makes, still[cuts.point], 0.0)
    return _correction(first.moves, replace(on_features, cuts=replace(cuts, over=over)), first.effects)


def _on_features(job: PreparedCut) -> FeaturePoints:
    """Return the cuts of points on the features of characteristics."""
    steps = gauge_plan(job.scenario.part, None).steps
    at, normals = (np.concatenate([getattr(s, name) for s in steps]) for name in ("points", "normals"))
    surface = surface_at(job, at, normals)
    good = np.flatnonzero((surface.status == CUT) & (surface.contact_s[:, 0] >= -GOUGE))
    if not len(good):
        raise UsageError("the program cuts no feature of the part, so there is no surface to correct")
    surface = surface.take(good)
    feature = np.concatenate([np.full(len(s.points), s.feature) for s in steps])[good]
    contacts, errors, rows = _cut_at(job, surface, feature)
    of_row = job.sweep.move[rows.row].astype(np.intp)
    point, candidate, over, makes = _reaching(contacts, errors, of_row)
    row, gain = contacts.row[point, candidate], contacts.gain[point, candidate]
    move, tips = of_row[row], rows.tip[row]
    share = np.array([float(nearest_share(job.program.moves[m], t[None])[0][0]) for m, t in zip(move, tips)])
    cuts = Cuts(point, move, share, gain=gain, over=over, makes=makes, feature=feature)
    return FeaturePoints(at[good], normals[good], contacts.surface(np.zeros_like(errors)), cuts)


def _cut_at(job: PreparedCut, surface: CutSurface, feature: Words) -> tuple[Contacts, Array, ContactRows]:
    """Return contacts of points that are cut, errors of their rows without corners that the control rounds within an unstated tolerance."""
    touch = np.array([str(i) for i in range(len(feature))])
    tool, contacts = tool_side(job, surface, touch, feature)
    rows = contact_rows(job, surface)
    errors = tool.errors()
    errors[: len(rows.row)] -= _rounding(job, rows)
    return contacts, errors, rows


def _rounding(job: PreparedCut, rows: ContactRows) -> Array:
    """Return the share of the path (rows, 3) mm that is a corner rounded by the control within an unstated tolerance: not corrected."""
    if "tolerance" in job.path.timing.control.stated:
        return np.zeros((len(rows.row), 3))
    states, known_error = job.process.states(job, rows)
    return known_error - np.column_stack([states.column(f"follow_{c}_mm") for c in "xyz"])


def _reaching(contacts: Contacts, errors: Array, move_of: Ints) -> tuple[Ints, Ints, Array, Bools]:
    """Return (point, candidate) of the cuts that make the surface, how far each is above the nominal surface (k,) mm, and whether it makes
    its point: at each point the deepest, and of every other move the one that comes as near with the same normal. A second pass along a
    wall, a floor or a ramp must not cut what the first was led away from.

    move_of (rows,): the move of each row of the run.
    """
    alone, moved = contacts.heights(np.zeros_like(errors)), contacts.heights(errors)
    points, deepest, wanted = np.arange(len(alone)), moved.argmin(axis=1), alone.min(axis=1)
    gap = moved[points, deepest] - wanted
    good = np.isfinite(gap)
    near = NEAR_BY * np.abs(gap[good]).max(initial=0.0) + UNSEEN
    move = np.where(contacts.row >= 0, move_of[np.maximum(contacts.row, 0)], -1)
    aside = np.linalg.norm(contacts.cutter - contacts.cutter[points, deepest][:, None], axis=2)
    other = (move >= 0) & np.isfinite(alone) & np.isfinite(moved) & (aside < LARGEST_ANGLE)
    other &= np.where(other, moved, np.inf) - wanted[:, None] <= near
    for k in range(other.shape[1]):  # of several cuts of one move the lowest
        same = other & (move == move[:, [k]])
        other[:, k] &= moved[:, k] <= np.where(same, moved, np.inf).min(axis=1)
    other[points, deepest] = True
    point, candidate = np.nonzero(other & good[:, None])
    return point, candidate, moved[point, candidate] - wanted[point], candidate == deepest[point]


def what_is_left(left: tuple[str, ...], surface: SurfaceErrors | None) -> tuple[str, ...]:
    """Return remarks on errors that are not corrected, and on errors that are corrected on the finished surface instead of the path."""
    if surface is None:
        return left
    if surface.origin:
        return (*left, surface.origin)
    left = tuple(sentence for sentence in left if sentence.split(" ")[0] not in surface.effects)
    text = (
        f"{', '.join(surface.effects) or 'the path that the control takes (corners, lag)'}: corrected where {surface.points} points of the features are cut, up to {surface.largest * 1e3:.2f} um "
        f"along their normals; {surface.rest_rms * 1e3:.2f} um rms of it no shift of the path takes out. The same size is assumed for the next "
        "part: state of the tool, clamping, stock"
    )
    if not surface.against:
        return (*left, text)
    names = ", ".join(surface.against[:6]) + (" and others" if len(surface.against) > 6 else "")
    return (
        *left, text,
        f"{names}: what is off there stays in part, since one way of the tool makes surfaces that would have to move apart (both walls of a "
        "slot, both sides of a hole): cut them one after the other, with a smaller tool, or with one whose radius is the nominal one",
    )  # fmt: skip


def with_surface(field: PathErrors, surface: SurfaceErrors | None, name: str) -> PathErrors:
    """Return the field with the effects on the surface. UsageError where these belong to other moves than those that are rewritten."""
    if surface is not None and [(m.start, m.end) for m in field.moves] != [
        (m.start, m.end) for m in surface.moves
    ]:
        raise UsageError(
            f"{name}: the moves that were cut virtually are not those that are rewritten (another program or set-up?); name the "
            "scenario whose program this is"
        )
    return replace(field, surface=surface)
