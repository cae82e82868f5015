"""Sweep: motions of tools, as arrays. Positions of the tool tip in the frame of the part, mm.

A row is a line, an arc or a helix; the tool keeps its direction during a row (indexed rotary axes). An arc runs from
start to end about `centre`, `turn` rad about `normal` by the right-hand rule, whole turns included; end beside the plane
makes it a helix, a different radius at the end a spiral, both linear in the angle. This is how controls interpolate them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.laws import Array
from vcmm.shop.cutting.tools import Cutter

LINE, ARC, HELIX = 0, 1, 2
UP: Array = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class Sweep:
    """m moves of tools. centre and normal are nan, turn 0 for lines; tool: index into `tools`; move: id of the source."""

    start: Array  # (m, 3)
    end: Array  # (m, 3)
    centre: Array  # (m, 3)
    normal: Array  # (m, 3)
    turn: Array  # (m,) rad, signed
    kind: Array  # (m,) LINE, ARC or HELIX
    tool: Array  # (m,) int
    move: Array  # (m,) int
    axis: Array  # (m, 3) unit, from the tip to the spindle
    tools: tuple[Cutter, ...]
    axis_end: Array | None = None  # (m, 3), where the tool tilts while it moves
    drift: Array | None = None  # (m, 3), added in proportion to t: an arc whose error changes along it

    def __len__(self) -> int:
        return len(self.start)

    def take(self, rows: Array) -> Sweep:
        """Return the rows of the sweep."""
        names = ("start", "end", "centre", "normal", "turn", "kind", "tool", "move", "axis")
        picked = {name: getattr(self, name)[rows] for name in names}
        for name in ("axis_end", "drift"):
            column = getattr(self, name)
            picked[name] = None if column is None else column[rows]
        return replace(self, **picked)


def lines(
    start: Array, end: Array, tools: tuple[Cutter, ...], tool: Array | int = 0, axis: Array = UP
) -> Sweep:
    """Return the straight moves (m, 3) -> (m, 3)."""
    start, end = np.atleast_2d(np.asarray(start, float)), np.atleast_2d(np.asarray(end, float))
    m = len(start)
    nothing = np.full((m, 3), np.nan)
    which = np.broadcast_to(np.asarray(tool, int), (m,)).copy()
    axes = np.broadcast_to(np.asarray(axis, float), (m, 3)).copy()
    kind = np.full(m, LINE)
    return check_sweep(
        Sweep(
            start=start,
            end=end,
            centre=nothing,
            normal=nothing.copy(),
            turn=np.zeros(m),
            kind=kind,
            tool=which,
            move=np.arange(m),
            axis=axes,
            tools=tools,
        )
    )


def path(points: Array, tools: tuple[Cutter, ...], tool: int = 0, axis: Array = UP) -> Sweep:
    """Return the straight moves through points (m + 1, 3)."""
    points = np.asarray(points, float)
    return lines(points[:-1], points[1:], tools, tool, axis)


def arcs(
    start: Array,
    end: Array,
    centre: Array,
    turn: Array,
    tools: tuple[Cutter, ...],
    tool: Array | int = 0,
    normal: Array = UP,
    axis: Array = UP,
) -> Sweep:
    """Return the arcs and helices (m, 3) about centres (m, 3), by `turn` (m,) rad about `normal`."""
    base = lines(start, end, tools, tool, axis)
    m = len(base)
    middle = np.broadcast_to(np.asarray(centre, float), (m, 3)).copy()
    about = np.broadcast_to(np.asarray(normal, float), (m, 3)).copy()
    angle = np.broadcast_to(np.asarray(turn, float), (m,)).copy()
    rise = np.abs(np.einsum("mi,mi->m", base.end - base.start, about))
    kind = np.where(rise > 1e-12, HELIX, ARC)
    return check_sweep(replace(base, centre=middle, normal=about, turn=angle, kind=kind))


def join(sweeps: Iterable[Sweep]) -> Sweep:
    """Return the sweeps one after another; all must have the same tools. Moves are numbered anew."""
    parts = list(sweeps)
    if not parts or any(p.tools != parts[0].tools for p in parts):
        raise UsageError("join: give at least one sweep, and the same tuple of tools to each of them")
    names = ("start", "end", "centre", "normal", "turn", "kind", "tool", "axis")
    stacked = {name: np.concatenate([getattr(p, name) for p in parts]) for name in names}
    m = len(stacked["start"])
    tilts = None
    if any(p.axis_end is not None for p in parts):
        tilts = np.concatenate([p.axis if p.axis_end is None else p.axis_end for p in parts])
    drift = None
    if any(p.drift is not None for p in parts):
        drift = np.concatenate([np.zeros_like(p.start) if p.drift is None else p.drift for p in parts])
    joined: dict[str, Any] = stacked
    return replace(parts[0], **joined, move=np.arange(m), axis_end=tilts, drift=drift)


def check_sweep(sweep: Sweep) -> Sweep:
    """Return the sweep itself, or an error that names the first bad row."""
    for name in ("start", "end", "axis"):
        bad = np.flatnonzero(~np.isfinite(getattr(sweep, name)).all(axis=1))
        if len(bad):
            raise UsageError(
                f"sweep: {name} of row {bad[0]} is not a number; every tip position must be known"
            )
    if np.any((sweep.tool < 0) | (sweep.tool >= len(sweep.tools))):
        raise UsageError(f"sweep: tool must be an index into the {len(sweep.tools)} tools given")
    for name, wanted in (("axis", np.ones(len(sweep), bool)), ("normal", sweep.kind != LINE)):
        lengths = np.linalg.norm(getattr(sweep, name)[wanted], axis=1)
        if np.any(np.abs(lengths - 1.0) > 1e-9):
            raise UsageError(
                f"sweep: {name} must hold unit vectors; row {np.argmax(abs(lengths - 1.0))} has not"
            )
    _check_arcs(sweep)
    return sweep


def _check_arcs(sweep: Sweep) -> None:
    rows = np.flatnonzero(sweep.kind != LINE)
    if not len(rows):
        return
    start, end = position(replace(sweep.take(rows), drift=None), np.array([[0.0], [1.0]]))
    miss = np.maximum(
        np.linalg.norm(start - sweep.start[rows], axis=1), np.linalg.norm(end - sweep.end[rows], axis=1)
    )
    worst = int(np.argmax(miss))
    if not miss[worst] <= 1e-6:
        raise UsageError(
            f"sweep: the arc in row {rows[worst]} misses its end by {miss[worst]:.3g} mm; centre, normal and turn must "
            "lead from start to end"
        )


def basis(sweep: Sweep) -> tuple[Array, Array, Array, Array, Array]:
    """Return the first and second direction (m, 3), radius at start and end (m,) and advance along the normal (m, 3) of arcs."""
    normal = sweep.normal
    arm = sweep.start - sweep.centre
    arm = arm - np.einsum("mi,mi->m", arm, normal)[:, None] * normal
    first_radius = np.linalg.norm(arm, axis=1)
    first = arm / np.where(first_radius > 0.0, first_radius, 1.0)[:, None]
    far = sweep.end - sweep.centre
    far = far - np.einsum("mi,mi->m", far, normal)[:, None] * normal
    rise = np.einsum("mi,mi->m", sweep.end - sweep.start, normal)[:, None] * normal
    return first, np.cross(normal, first), first_radius, np.linalg.norm(far, axis=1), rise


def position(sweep: Sweep, t: Array) -> Array:
    """Return the tip positions (..., m, 3) at fractions t (..., m) or (..., 1) of each row."""
    t = np.asarray(t, float)[..., None]
    out = sweep.start + t * (sweep.end - sweep.start)
    if sweep.drift is not None:
        out = out + t * sweep.drift
    rows = np.flatnonzero(sweep.kind != LINE)
    if not len(rows):
        return out
    arcs_ = sweep.take(rows)
    first, second, r0, r1, rise = basis(arcs_)
    part = t if t.shape[-2] == 1 else t[..., rows, :]
    angle = part * arcs_.turn[:, None]
    radius = r0[:, None] + part * (r1 - r0)[:, None]
    level = np.einsum("mi,mi->m", arcs_.start - arcs_.centre, arcs_.normal)[:, None] * arcs_.normal
    if arcs_.drift is not None:
        rise = rise + arcs_.drift
    out = np.broadcast_to(out, (*out.shape[:-2], len(sweep), 3)).copy()
    out[..., rows, :] = (
        arcs_.centre + level + radius * (np.cos(angle) * first + np.sin(angle) * second) + part * rise
    )
    return out


def lengths(sweep: Sweep) -> Array:
    """Return the length of path (m,) mm; of spirals that of the helix with their mean radius."""
    out = np.linalg.norm(sweep.end - sweep.start, axis=1)
    rows = np.flatnonzero(sweep.kind != LINE)
    if len(rows):
        arcs_ = sweep.take(rows)
        _, _, r0, r1, rise = basis(arcs_)
        out[rows] = np.hypot(arcs_.turn * (r0 + r1) / 2, np.linalg.norm(rise, axis=1))
    return out


def pieces(sweep: Sweep, counts: Array) -> tuple[Sweep, Array, Array, Array]:
    """Return every row cut into counts (m,) equal pieces of the same kind: pieces, their row, first and last fraction t."""
    counts = np.asarray(counts, int)
    row = np.repeat(np.arange(len(sweep)), counts)
    number = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)
    t0, t1 = number / counts[row], (number + 1) / counts[row]
    parent = sweep.take(row)
    if sweep.axis_end is not None:
        raise ModelLimit(
            "the tool tilts during a move: swept volumes are exact for a constant tool direction only. Cut such moves "
            "into short ones of constant axis first: vcmm.shop.cutting.displacement.split_by_direction(sweep, tolerance)"
        )
    start, end = position(parent, t0), position(parent, t1)
    start[number == 0] = parent.start[number == 0]
    centre, drift = parent.centre, parent.drift
    if drift is not None:
        centre, drift = centre + t0[:, None] * drift, drift * (t1 - t0)[:, None]
        end = end - drift
    else:
        end[t1 == 1.0] = parent.end[t1 == 1.0]
    turn = parent.turn * (t1 - t0)
    return replace(parent, start=start, end=end, centre=centre, turn=turn, drift=drift), row, t0, t1


def frames_of(axis: Array) -> Array:
    """Return right-handed frames (k, 3, 3) whose third row is the tool axis (k, 3); the identity for +Z."""
    other = np.eye(3)[np.argmin(np.abs(axis), axis=1)]
    first = np.cross(other, axis)
    first = first / np.linalg.norm(first, axis=1)[:, None]
    out = np.stack([first, np.cross(axis, first), axis], axis=1)
    return np.where((axis[:, 2] == 1.0)[:, None, None], np.eye(3), out)
