"""The bar in a lathe: its meridian during turning, rapids that run through it, and the forces that follow from the chip.

The outside and the bore are kept as radii at places along Z. A move that removes the area dA of the meridian over the length
L takes a chip of cross-section S = dA f / L, f = feed per turn. With the length b of edge at work (arc of the nose, then
straight) the mean thickness is h = S / b, the equivalent chip thickness of Woxen (CIRP: h_eq), and Kienzle gives

    Fc = b kc1.1 h^(1 - mc)        (Kienzle, VDI-Z 94 (1952) 299; coefficients in vcmm.program.setup)

along the cut. Across the edge acts thrust x Fc, square to the chord of the edge at work (Colwell, Trans. ASME 76 (1954) 199):
away from the surface, and against the feed. A move towards the work, square to the axis within CLEARANCE, faces: the edge beside the nose
removes the material before the shoulder up to its free end, DISC wide at most; a wider ring stays, and a rapid through it is one. The
thrust is not in Kienzle's table; where the set-up states no thrust_ratio the
workshop rule Fc : Fp : Ff = 5 : 2 : 1 is taken, 0.45. Good to tens of percent; deviations never come from the bar itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vcmm.core.run import Array
from vcmm.program.moves import Move, Program
from vcmm.program.setup import Bar, Setup, kienzle
from vcmm.shop.cutting import nose
from vcmm.shop.cutting.force import turning_force
from vcmm.shop.machining.turned_surface import Turning

NODES = 4000  # along the axis
LOOKS, OUT_OF_REACH = 9, 0.05  # places along a stretch that are looked at; mm beyond the nose
DEEP = 0.01  # mm, from which a rapid through the bar is one
NECK, DISC = 0.01, 5.0  # mm: what hangs on less falls off; the most that is faced off in one pass (chosen)
CLEARANCE = float(np.tan(np.radians(5.0)))  # of the edge that faces (holders of 95 deg)
THRUST = float(np.hypot(2.0, 1.0) / 5.0)  # of the rule 5 : 2 : 1
SIDES = 96  # of the picture


@dataclass(frozen=True, eq=False)
class Profile:
    """A body of revolution: radii outer and inner (n,) at places z (n,), machine axes, mm; inner >= outer: nothing left."""

    z: Array
    outer: Array
    inner: Array
    centre: Array  # (2,) x and y of the axis

    @property
    def volume(self) -> float:
        """Volume in mm^3."""
        left = np.maximum(self.outer**2 - self.inner**2, 0.0)
        return float(np.pi * np.trapezoid(left, self.z))


@dataclass(frozen=True, eq=False)
class TurnedBlank:
    """before and after; removed mm^3; collisions: (line, depth mm) of rapids; forces (rows, 3) N, meridian frame, or None."""

    before: Profile
    after: Profile
    removed_volume: float
    collisions: tuple[tuple[int, float], ...]
    forces: Array | None
    remarks: tuple[str, ...] = ()
    shanks: tuple[tuple[int, int, float], ...] = ()  # as of Blank; shanks of turning tools are not looked at
    kept_as: str = "a profile about the axis of the spindle"


def turned_blank(setup: Setup, program: Program, turning: Turning, zero: float) -> TurnedBlank | None:
    """Turn the bar of a set-up with all moves; None where none is stated. zero: Z of the work zero, machine axes."""
    if setup.bar is None:
        return None
    before = _bar(setup.bar, turning, zero)
    outer, inner = before.outer.copy(), before.inner.copy()
    count = len(turning.sweep)
    area, side, deepest, worked = (np.zeros(count) for _ in range(4))
    moves = [program.moves[i] for i in turning.sweep.move.tolist()]
    for i in range(len(turning.paths.r)):
        row = int(turning.paths.row[i])
        bite = _cut(before.z, outer, inner, turning, _stretch(setup, moves[row], turning, i))
        area[row] += bite.area
        worked[row] += bite.length
        side[row] += bite.side * bite.area
        deepest[row] = max(deepest[row], bite.depth)
        if bite.area > 0:
            _fall_off(before.z, outer, inner)
    after = Profile(before.z, outer, inner, before.centre)
    hits: dict[int, float] = {}  # a line of a subprogram or a cycle is run more than once, and told once
    for m, depth in zip(moves, deepest.tolist()):
        if m.kind == "rapid" and depth > DEEP:
            hits[m.source.line] = max(hits.get(m.source.line, 0.0), depth)
    forces: Array | None = None
    remarks: tuple[str, ...] = ()
    if setup.material is not None:
        forces = _forces(setup, moves, turning, area, worked, side)
        if setup.bar.thrust is None:
            remarks = (
                f"cutting forces: thrust_ratio of the stock is not stated; {THRUST:.2f} of the main force is taken (5 : 2 : 1)",
            )
    return TurnedBlank(before, after, before.volume - after.volume, tuple(hits.items()), forces, remarks)


def _bar(bar: Bar, turning: Turning, zero: float) -> Profile:
    front = zero + bar.front
    z = np.linspace(front - bar.length, front, NODES)
    return Profile(z, np.full(NODES, bar.diameter / 2), np.full(NODES, bar.bore / 2), turning.centre)


@dataclass(frozen=True, eq=False)
class NoseStretch:
    """A straight stretch of a nose of radius r: its centre from start to end, (radius, z), mm; i: its number in the paths.

    edge: the range along Z, from the centre, of a straight edge of the same height beside it (a groove tool).
    bore: it cuts the inside. faces: the side, +1 or -1 along Z, on which an edge removes the material before the nose; 0: none.
    """

    i: int
    start: Array
    end: Array
    r: float
    edge: tuple[float, float]
    bore: bool
    faces: float


def _stretch(setup: Setup, move: Move, turning: Turning, i: int) -> NoseStretch:
    start, end, r = turning.paths.start[i], turning.paths.end[i], float(turning.paths.r[i])
    tip = turning.to_tip[int(turning.paths.row[i])]
    beside = max((setup.tools[move.tool].width or 0.0) - 2.0 * r, 0.0)
    low = -0.5 * beside * (1.0 + float(tip[1]))  # tip at the lower end, at the upper one, or in the middle
    dx, dz = end - start
    faces = move.kind == "line" and not beside and dx * tip[0] > 0 and abs(dz) <= CLEARANCE * abs(dx)
    return NoseStretch(
        i, start, end, r, edge=(low, low + beside), bore=bool(tip[0] > 0), faces=-float(tip[1]) * faces
    )


@dataclass(frozen=True)
class Bite:
    """Material removed by one straight stretch: mm^2 of the meridian, greatest depth mm, length of path at work mm.

    side: +1 where the finished surface lies to the side (-dz, dx) of the way (dx, dz), -1 on the other, 0 on both or none.
    """

    area: float
    depth: float
    length: float
    side: float


def _cut(z: Array, outer: Array, inner: Array, turning: Turning, path: NoseStretch) -> Bite:
    """Cut the radii in place by one straight stretch."""
    low, high = _reach(z, path)
    hit = (low <= high) & (outer > inner)
    before = inner.copy() if path.bore else outer.copy()
    after = inner if path.bore else outer
    after[:] = np.where(hit, np.clip(high if path.bore else low, inner, outer), after)
    if path.faces:
        _face(z, outer, inner, path)
    taken = np.abs(after - before)
    gone = np.flatnonzero(taken > 0)
    along = path.end - path.start
    length = float(np.hypot(*along))
    if not len(gone) or length == 0.0:
        return Bite(float(taken.sum() * (z[1] - z[0])), float(taken.max(initial=0.0)), 0.0, 0.0)
    way = along / length
    reached = np.concatenate([z[gone] * way[1] + x[gone] * way[0] for x in (before, after)])
    worked = min(length, float(np.ptp(reached)))
    side = _finished_side(z, outer, inner, turning, path.i, way)
    return Bite(float(taken.sum() * (z[1] - z[0])), float(taken.max()), worked, side)


def _face(z: Array, outer: Array, inner: Array, path: NoseStretch) -> None:
    """Remove with the edge beside the nose the material before a shoulder, in place, where its free end is no further than DISC."""
    away = np.flatnonzero((z - path.end[1]) * path.faces >= 0.0)
    away = away if path.faces > 0 else away[::-1]
    reach = path.end[0] + (path.r if path.bore else -path.r)
    standing = (inner[away] < reach - NECK) if path.bore else (outer[away] > reach + NECK)
    standing &= outer[away] > inner[away]
    if not standing.any():
        return
    first = int(standing.argmax())
    ends = np.flatnonzero(~standing[first:])
    last = first + int(ends[0]) if len(ends) else len(away)
    width = abs(z[away[last - 1]] - path.end[1]) + path.r
    if abs(z[away[first]] - path.end[1]) <= path.r + (z[1] - z[0]) and width <= DISC:
        ring = away[first:last]
        body = inner if path.bore else outer
        body[ring] = np.clip(reach, inner[ring], outer[ring])


def _fall_off(z: Array, outer: Array, inner: Array) -> None:
    """Drop the material that a facing cut severs, in place: a nose of 0.4 mm sweeps 0.8 mm of an allowance of 1 mm, its edge the rest.

    The bar is held at its lower end. A longer piece is a part that was parted off, and stays in the picture.
    """
    through = np.flatnonzero(outer - inner < NECK)
    if not len(through):
        return
    beyond = slice(int(through[0]), len(z))
    left = np.flatnonzero(outer[beyond] - inner[beyond] >= NECK)
    if len(left) and z[beyond][left[-1]] - z[through[0]] < DISC:
        outer[beyond] = inner[beyond]


def _finished_side(z: Array, outer: Array, inner: Array, turning: Turning, i: int, way: Array) -> float:
    """Return the side of a stretch on which the bar remains, just out of reach of the nose."""
    t = np.linspace(0.0, 1.0, LOOKS)[:, None]
    centre = turning.paths.start[i] + t * (turning.paths.end[i] - turning.paths.start[i])
    beside = np.array([-way[1], way[0]]) * (turning.paths.r[i] + OUT_OF_REACH)
    balance = 0.0
    for sign in (1.0, -1.0):
        x, at = (centre + sign * beside).T
        inside = (x < np.interp(at, z, outer)) & (x > np.interp(at, z, inner)) & (at > z[0]) & (at < z[-1])
        balance += sign * inside.sum()
    return float(np.sign(balance))


def _reach(z: Array, path: NoseStretch) -> tuple[Array, Array]:
    """Return the lowest and highest radius (n,) that a stretch reaches at places z (n,); inf and -inf beside it."""
    low, high = np.full(len(z), np.inf), np.full(len(z), -np.inf)
    for shift in dict.fromkeys(path.edge):
        reach = _nose_reach(z, path.start + [0.0, shift], path.end + [0.0, shift], path.r)
        low, high = np.minimum(low, reach[0]), np.maximum(high, reach[1])
    if path.edge[1] > path.edge[0]:
        reach = _edge_reach(z, path)
        low, high = np.minimum(low, reach[0]), np.maximum(high, reach[1])
    return low, high


def _edge_reach(z: Array, path: NoseStretch) -> tuple[Array, Array]:
    """Return the reach of the straight edge between the corners of a groove tool: z lies under it over a share of the way."""
    dx, dz = path.end - path.start
    first, last = z - path.start[1] - path.edge[1], z - path.start[1] - path.edge[0]
    if abs(dz) > 1e-12:
        at_first, at_second = first / dz, last / dz
        begins, ends = (
            np.maximum(np.minimum(at_first, at_second), 0.0),
            np.minimum(np.maximum(at_first, at_second), 1.0),
        )
    else:
        begins, ends = (
            np.where((first <= 0) & (last >= 0), 0.0, 1.0),
            np.where((first <= 0) & (last >= 0), 1.0, 0.0),
        )
    under = begins <= ends
    x = path.start[0] + np.stack([begins, ends]) * dx
    low = np.where(under, x.min(axis=0) - path.r, np.inf)
    return low, np.where(under, x.max(axis=0) + path.r, -np.inf)


def _nose_reach(z: Array, a: Array, b: Array, r: float) -> tuple[Array, Array]:
    """Return the reach of a circle of radius r whose centre goes from a to b."""
    low, high = np.full(len(z), np.inf), np.full(len(z), -np.inf)
    for c in (a, b):
        square = r * r - (z - c[1]) ** 2
        root = np.sqrt(np.maximum(square, 0.0))
        low = np.minimum(low, np.where(square >= 0, c[0] - root, np.inf))
        high = np.maximum(high, np.where(square >= 0, c[0] + root, -np.inf))
    dx, dz = b - a
    length = np.hypot(dx, dz)
    if abs(dz) > 1e-12:  # its two tangent lines, between the points where they touch the end circles
        for sign in (-1.0, 1.0):
            normal = np.array([abs(dz), -np.sign(dz) * dx]) / length * sign
            t = (z - (a[1] + r * normal[1])) / dz
            x = a[0] + r * normal[0] + t * dx
            on = (t >= 0) & (t <= 1)
            low, high = np.minimum(low, np.where(on, x, np.inf)), np.maximum(high, np.where(on, x, -np.inf))
    elif length > 0:  # a plunge: everything between the two circles
        inside = np.abs(z - a[1]) <= r
        low = np.where(inside, np.minimum(low, min(a[0], b[0])), low)
        high = np.where(inside, np.maximum(high, max(a[0], b[0])), high)
    return low, high


def _forces(
    setup: Setup, moves: list[Move], turning: Turning, area: Array, worked: Array, side: Array
) -> Array:
    """Return the mean force of the part on the insert (rows, 3) N while each move cuts: x away from the axis, y along the cut, z."""
    from vcmm.shop.cutting.sweeps import lengths, position

    assert setup.bar is not None
    assert setup.material is not None
    r, length = nose.nose_radius(turning.sweep), lengths(turning.sweep)
    rpm = np.array([m.spindle for m in moves])
    feed = np.array([m.feed or 0.0 for m in moves])
    per_turn = np.divide(feed, np.abs(rpm), out=np.zeros(len(feed)), where=rpm != 0)
    depth = np.divide(area, worked, out=np.zeros(len(area)), where=worked > 0)
    chip = depth * per_turn
    half = np.arccos(np.clip(1.0 - depth / r, 0.0, 1.0))  # angle of the nose at work
    width = r * half + np.maximum(depth - r, 0.0)
    thickness = np.divide(chip, width, out=np.zeros(len(chip)), where=width > 0)
    main = np.where(chip > 0, turning_force(width, thickness, kienzle(setup.material)), 0.0)
    thrust = main * (THRUST if setup.bar.thrust is None else setup.bar.thrust)
    middle = position(turning.sweep, np.array([[0.49], [0.51]]))
    way = (middle[1] - middle[0])[:, [0, 2]]
    way = way / np.where(length > 0, np.hypot(way[:, 0], way[:, 1]), 1.0)[:, None]
    # the finished surface lies to `side` of the way; the tool is pushed to the other, and back
    beside = np.stack([-way[:, 1], way[:, 0]], axis=1)
    lean = np.arctan2(1.0 - np.cos(half) + np.maximum(depth / r - 1.0, 0.0), np.sin(half))
    push = -np.sign(side)[:, None] * beside * np.cos(lean)[:, None] - way * np.sin(lean)[:, None]
    return np.stack([thrust * push[:, 0], main * np.sign(rpm), thrust * push[:, 1]], axis=1)


def mesh(profile: Profile, every: int = 1) -> tuple[Array, Array]:
    """Return vertices (v, 3) mm and triangles (f, 3) of the remaining bar, outward; machine axes."""
    keep = np.flatnonzero(profile.outer > profile.inner + 1e-9)
    if len(keep) < 2:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    outer = _corners(profile.z[keep], profile.outer[keep], every)
    inner = _corners(profile.z[keep], profile.inner[keep], every)[::-1]
    loop = np.concatenate([outer, inner])  # (radius, z), up the outside and down the bore
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    x = loop[:, 0:1] * np.cos(angle) + profile.centre[0]
    y = loop[:, 0:1] * np.sin(angle) + profile.centre[1]
    vertices = np.stack([x, y, np.broadcast_to(loop[:, 1:2], x.shape)], axis=-1).reshape(-1, 3)
    k, s = len(loop), np.arange(SIDES)
    a = (np.arange(k)[:, None] * SIDES + s).ravel()
    b = (np.arange(k)[:, None] * SIDES + (s + 1) % SIDES).ravel()
    c, d = (a + SIDES) % (k * SIDES), (b + SIDES) % (k * SIDES)
    faces = np.concatenate([np.stack([a, b, d], -1), np.stack([a, d, c], -1)])
    first, second, third = (vertices[faces[:, j]] for j in range(3))
    real = np.linalg.norm(np.cross(second - first, third - first), axis=1) > 1e-12  # none on the axis
    return vertices, faces[real].astype(np.int64)


def _corners(z: Array, r: Array, every: int) -> Array:
    """Return (radius, z) of the profile without the points that lie on a straight line, or each `every`-th of curves."""
    bend = np.abs(np.diff(r, 2)) > 1e-7
    wanted = np.zeros(len(z), dtype=bool)
    wanted[[0, -1]] = True
    wanted[1:-1] = bend & (np.arange(1, len(z) - 1) % every == 0)
    step = np.abs(np.diff(r)) > 20 * (z[1] - z[0])  # shoulders keep both their ends
    wanted[:-1] |= step
    wanted[1:] |= step
    return np.stack([r[wanted], z[wanted]], axis=1)


def write_turned_stl(profile: Profile, path: str | Path) -> None:
    """Write a binary STL of the remaining bar, mm."""
    import trimesh

    vertices, faces = mesh(profile)
    trimesh.Trimesh(vertices, faces, process=True).export(str(path), file_type="stl")
