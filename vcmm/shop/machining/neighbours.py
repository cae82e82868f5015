"""Neighbours: the tool a little before and after each contact, as further candidates for the deepest cut.

A perfect machine touches a point at one place of the path. With errors another place may cut deeper: a floor is covered by
the disc of a flat cutter over a length of path, a wall is passed within d^2 / 2R for a distance d on either side, and at a
corner of the path the rounding of the control moves the corner itself but not what lies beside it. Each neighbour is the
tool standing at that place, met by the ray along the normal; its height and the normal of the cutter there are exact.

A tool that plunges along its own axis touches the wall of its hole all the way from where its full radius arrives down to
the bottom, pecks and the way out included: it is put at several places of that stroke, its two ends among them.

Where the nominal motion leaves the programmed path by an amount that changes along it (`OffPath`), the deepest cut lies between
such steps. It is looked for there by closer and closer steps, down to nanometres of path, and is one more neighbour.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vcmm.core.run import Array
from vcmm.shop.cutting.contactmap import Ints
from vcmm.shop.cutting.envelope import CutSurface
from vcmm.shop.cutting.standing_tool import entry
from vcmm.shop.cutting.sweeps import LINE, Sweep, lengths
from vcmm.shop.cutting.tools import Cutter, implicit, nose_height
from vcmm.shop.machining.process import CutCandidates
from vcmm.shop.machining.rotary import Bools, turn_to_workpiece, turned_back

OFFSETS = np.array([0.002, 0.005, 0.02, 0.1, 0.3, 0.6, 0.9, 0.999])
SOURCES = 2  # contacts of a point whose neighbours are evaluated
STEPS = np.concatenate([-OFFSETS[::-1], [0.0], OFFSETS])
BAND = 0.05  # mm: a neighbour that lies further above the contact than any error is none
ROUNDS, ACROSS = 7, 9  # the bracket shrinks to a quarter in each round: 0.3 mm to 0.02 um
TURNS = 1e-6  # mm: what moves by no more than this differently, from step to step, is not searched
LOWER = 1e-7  # mm: a place between steps counts if it is so much deeper than they


STROKE = 9  # places along a stroke into a hole
ALONG = 1e-9  # sine of the angle between a plunge and the axis of its tool; mm between strokes of one hole
INSIDE = 0.02  # mm that the full radius has passed a point at the upper end of its stroke: more than it may stand off by


OffPath = Callable[[Ints, Array, Array], Array]
"""Distance of the nominal motion from the programmed path (n, 3) mm at rows (n,), shares (n,), tips (n, 3)."""


Standing = Callable[[Ints, Array], tuple[Array, Array | None]]
"""Tips (k, 3) at shares (k,) of rows (k,) of the sweep, and frames (k, 3, 3) of the tools there; None: all along Z."""

Heights = Callable[[Ints, Array], tuple[Array, Array]]
"""Height (n, m) of the surface over points (n,) if the tool stood at offsets (n, m) only, and by how much it is moved
there off its path (n, m, 3), mm."""


def candidates(
    surface: CutSurface, sweep: Sweep, tips: Array, standing: Standing, off: OffPath | None = None
) -> CutCandidates:
    """Return the contacts of a surface and their neighbours along the path. tips (P, K, 3): those of the contacts.

    standing: where the tool stands. off: where given, the deepest cut under it is looked for between the steps too.
    """
    is_cut = surface.row >= 0
    of_contacts = CutCandidates(
        np.where(is_cut, surface.contact_s, np.inf),
        np.where(is_cut[:, :, None], surface.normal, surface.normals[:, None, :]),
        np.where(is_cut[:, :, None], tips, 0.0),
        np.where(is_cut, surface.row, -1).astype(np.intp),
        np.where(is_cut, surface.t, 0.0),
    )
    parts = [of_contacts]
    for k in range(min(SOURCES, surface.row.shape[1])):
        points = np.flatnonzero(is_cut[:, k])
        if len(points):
            parts += [
                _beside(surface, sweep, standing, points, k, np.full(len(points), sign * offset))
                for offset in OFFSETS
                for sign in (-1, 1)
            ]
            parts += _strokes(surface, sweep, standing, points, k)
            if off is not None:
                heights = _moved_heights(surface, sweep, standing, points, k, off)
                deeper, at = deepest_between(heights, len(points), STEPS)
                if len(deeper):
                    parts.append(_beside(surface, sweep, standing, points[deeper], k, at))
    return CutCandidates(
        *(np.concatenate([getattr(p, n) for p in parts], axis=1) for n in CutCandidates.__annotations__)
    )


def _beside(
    surface: CutSurface, sweep: Sweep, standing: Standing, points: Ints, k: int, offset: Array
) -> CutCandidates:
    """Return the tool `offset` (n,) radii further along the path than the k-th contact of each of the points."""
    radius = np.array([t.radius for t in sweep.tools])[sweep.tool]
    from_ = surface.row[points, k]
    row, share = _walk(sweep, from_, surface.t[points, k], offset * radius[from_])
    return _candidates_at(surface, sweep, standing, points, k, (row, share))


def _candidates_at(
    surface: CutSurface, sweep: Sweep, standing: Standing, points: Ints, k: int, at: tuple[Ints, Array]
) -> CutCandidates:
    """Return the tool at (rows, shares) (n,) as one more candidate of each of the points, whose k-th contact is another place."""
    count, (row, share) = len(surface.points), at
    tip, frame = standing(row, share)
    height, cutter = np.full(len(points), np.inf), surface.normals[points].copy()
    for number, tool in enumerate(sweep.tools):
        mine = np.flatnonzero(sweep.tool[row] == number)
        axes = None if frame is None else frame[mine]
        arm = turn_to_workpiece(axes, surface.points[points[mine]] - tip[mine])
        n = turn_to_workpiece(axes, surface.normals[points[mine]])
        height[mine] = entry(tool, arm, n)
        met = arm + np.where(np.isfinite(height[mine]), height[mine], 0.0)[:, None] * n
        cutter[mine] = turned_back(axes, _outward(tool, met, n))
    same_tool = sweep.tool[row] == sweep.tool[surface.row[points, k]]
    good = same_tool & np.isfinite(height) & (height < surface.contact_s[points, 0] + BAND)
    good &= (
        height >= surface.contact_s[points, 0] - 1e-6
    )  # deeper than the envelope: the ray has met another stretch
    out = CutCandidates(
        np.full((count, 1), np.inf), surface.normals[:, None, :].copy(), np.zeros((count, 1, 3)),
        np.full((count, 1), -1, dtype=np.intp), np.zeros((count, 1)),
    )  # fmt: skip
    mine = points[good]
    out.height[mine, 0], out.cutter[mine, 0], out.tip[mine, 0] = height[good], cutter[good], tip[good]
    out.row[mine, 0], out.share[mine, 0] = row[good], share[good]
    return out


def _strokes(
    surface: CutSurface, sweep: Sweep, standing: Standing, points: Ints, k: int
) -> list[CutCandidates]:
    """Return the places along the strokes into holes whose walls are touched by the k-th contact of the points."""
    axial, hole = _holes(sweep)
    points = points[axial[surface.row[points, k]]]
    if not len(points):
        return []
    contact_row = surface.row[points, k].astype(np.intp)
    level = np.einsum("ni,ni->n", surface.points[points], sweep.axis[contact_row])
    nose = np.array([nose_height(t) for t in sweep.tools])[sweep.tool[contact_row]] + INSIDE
    row, first, last = _stroke(sweep, hole, contact_row, level - nose)
    out = []
    for part in np.linspace(0.0, 1.0, STROKE):
        out.append(_candidates_at(surface, sweep, standing, points, k, (row, first + part * (last - first))))
    return out


def _holes(sweep: Sweep) -> tuple[Bools, Ints]:
    """Return the rows (m,) that lead their tool along its own axis, and a number (m,) for each run of them on one line."""
    way = sweep.end - sweep.start
    length = np.linalg.norm(way, axis=1)
    across = np.linalg.norm(np.cross(way, sweep.axis), axis=1)
    axial = (sweep.kind == LINE) & (length > 0.0) & (across <= ALONG * np.maximum(length, 1.0))
    aside = np.cross(sweep.start[1:] - sweep.end[:-1], sweep.axis[1:])
    going_on = axial[1:] & axial[:-1] & (sweep.tool[1:] == sweep.tool[:-1])
    going_on &= np.linalg.norm(aside, axis=1) <= ALONG
    going_on &= np.abs(sweep.axis[1:] - sweep.axis[:-1]).max(axis=1) <= ALONG
    return axial, np.concatenate([[0], np.cumsum(~going_on)]).astype(np.intp)


def _stroke(sweep: Sweep, hole: Ints, contact_row: Ints, top: Array) -> tuple[Ints, Array, Array]:
    """Return the row (n,) that leads the tool from heights `top` (n,) over its axis to the bottom of the hole, and its shares there.

    The row of the contact itself where it does, else the longest of the strokes of that hole (the way out after pecks).
    """
    ends = [np.einsum("mi,mi->m", p, sweep.axis) for p in (sweep.start, sweep.end)]
    low, high = np.minimum(*ends), np.maximum(*ends)
    bottom = np.full(int(hole[-1]) + 1, np.inf)
    np.minimum.at(bottom, hole, low)
    order = np.lexsort((low - high, hole))  # the longest of each hole first
    longest = order[np.searchsorted(hole[order], np.arange(len(bottom)))]
    whole = (low[contact_row] <= bottom[hole[contact_row]] + ALONG) & (high[contact_row] >= top)
    row = np.where(whole, contact_row, longest[hole[contact_row]]).astype(np.intp)
    begin, rise = ends[0][row], (ends[1] - ends[0])[row]
    first = np.clip((np.minimum(top, high[row]) - begin) / rise, 0.0, 1.0)
    return row, first, np.where(rise < 0.0, 1.0, 0.0)


def _further(
    surface: CutSurface, sweep: Sweep, standing: Standing, points: Ints, k: int, offset: Array
) -> tuple[Ints, Array, Array, Array | None]:
    """Return the row, share, tip and frame of the tool `offset` radii further along the path than the k-th contact of the points.

    frame (n, 3, 3): axes of the tool, None where all tools point along Z.
    """
    radius = np.array([t.radius for t in sweep.tools])[sweep.tool]
    from_ = surface.row[points, k]
    row, share = _walk(sweep, from_, surface.t[points, k], offset * radius[from_])
    return row, share, *standing(row, share)


def _moved_heights(
    surface: CutSurface, sweep: Sweep, standing: Standing, points: Ints, k: int, off: OffPath
) -> Heights:
    """Return the heights of points (n,) of `points` cut by the tool `at` radii from their k-th contact and moved by `off`."""

    def heights(which: Ints, at: Array) -> tuple[Array, Array]:
        flat = np.repeat(points[which], at.shape[1])
        row, share, tip, frame = _further(surface, sweep, standing, flat, k, at.ravel())
        moved = off(row, share, tip)
        s = np.full(len(flat), np.inf)
        for number in np.unique(sweep.tool[row]):
            mine = np.flatnonzero(sweep.tool[row] == number)
            axes = None if frame is None else frame[mine]
            arm = turn_to_workpiece(axes, surface.points[flat[mine]] - tip[mine] - moved[mine])
            s[mine] = entry(
                sweep.tools[int(number)], arm, turn_to_workpiece(axes, surface.normals[flat[mine]])
            )
        s[sweep.tool[row] != sweep.tool[surface.row[flat, k]]] = np.inf
        return s.reshape(at.shape), moved.reshape(*at.shape, 3)

    return heights


def deepest_between(heights: Heights, count: int, steps: Array) -> tuple[Ints, Array]:
    """Return which of `count` points (m,) are cut deepest between the steps (k,), ascending, and at which offset (m,).

    A point is searched where the tool is moved differently at the steps beside its deepest one; without that the steps
    themselves, which hold the contact of the programmed path, are the answer. Each round asks at ACROSS places of the
    bracket and goes on about the deepest; one minimum per bracket is taken for granted.
    """
    points = np.arange(count)
    s, moved = heights(points, np.broadcast_to(steps, (count, len(steps))))
    best = np.clip(np.argmin(s, axis=1), 1, len(steps) - 2)
    beside = moved[points[:, None], best[:, None] + [-1, 1]] - moved[points, best][:, None]
    differs = np.linalg.norm(beside, axis=2).max(axis=1) > TURNS
    open_ = np.flatnonzero(differs & np.isfinite(s.min(axis=1)))
    if not len(open_):
        return open_, np.zeros(0)
    best = best[open_]
    before = low = s[open_].min(axis=1)
    at, middle = steps[best], 0.5 * (steps[best + 1] + steps[best - 1])
    reach, rows = 0.5 * (steps[best + 1] - steps[best - 1]), np.arange(len(open_))
    for _ in range(ROUNDS):
        tried = middle[:, None] + reach[:, None] * np.linspace(-1.0, 1.0, ACROSS)
        s, _moved = heights(open_, tried)
        pick = np.argmin(s, axis=1)
        least, middle = s[rows, pick], tried[rows, pick]
        at, low = np.where(least < low, middle, at), np.minimum(least, low)
        reach = reach * 2.0 / (ACROSS - 1)
    deeper = low < before - LOWER
    return open_[deeper], at[deeper]


def _walk(sweep: Sweep, row: Ints, share: Array, along: Array) -> tuple[Ints, Array]:
    """Return the row and share (n,) reached after `along` mm of path from (row, share); the ends of the program stop the walk."""
    length = lengths(sweep)
    edge = np.concatenate([[0.0], np.cumsum(length)])
    s = np.clip(edge[row] + share * length[row] + along, 0.0, edge[-1])
    to = np.clip(np.searchsorted(edge, s, side="right") - 1, 0, len(sweep) - 1)
    inside = (s - edge[to]) / np.where(length[to] > 0, length[to], 1.0)
    return to.astype(np.intp), np.clip(inside, 0.0, 1.0)


def _outward(tool: Cutter, at: Array, n: Array) -> Array:
    """Return the normal of the cutter (m, 3) at points of its surface (tip at the origin), from the gradient of its implicit form."""
    rho, step = np.hypot(at[:, 0], at[:, 1]), 1e-7
    by_rho = (implicit(tool, rho + step, at[:, 2]) - implicit(tool, np.abs(rho - step), at[:, 2])) / (
        2 * step
    )
    by_h = (implicit(tool, rho, at[:, 2] + step) - implicit(tool, rho, at[:, 2] - step)) / (2 * step)
    radial = at[:, :2] / np.where(rho > 0, rho, 1.0)[:, None]
    out = np.column_stack([by_rho[:, None] * radial, by_h])
    size = np.linalg.norm(out, axis=1)
    edge = np.abs(np.einsum("ni,ni->n", out, n)) < 0.1 * size  # on an edge the ray leaves by the other face
    return np.where((edge | (size == 0))[:, None], n, out / np.where(size > 0, size, 1.0)[:, None])
