"""The search of vcmm.program.free_contour: which line or circle an element may be, and every contour that fits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import count, product

from vcmm.program.free_contour import MOST_CONTOURS, FreeContour, FreeElement
from vcmm.program.offsetting import Vec
from vcmm.program.tangents import (
    Carrier,
    DirectedCircle,
    DirectedLine,
    Row,
    circles,
    line_at,
    lines_touching,
    rows_at,
    touch_row,
)


class TooMany(Exception):
    """More steps than STEPS: the words leave too much open."""


class Undetermined(Exception):
    """No step determines more. contour: what is known."""

    def __init__(self, contour: FreeContour) -> None:
        super().__init__()
        self.contour = contour


STEPS = 20_000  # of a search


def contours(elements: Sequence[FreeElement], start: Vec, before: float | None) -> list[FreeContour]:
    """Return all contours from `start` that fit, no more than MOST. Raises Undetermined where the words leave one open, and TooMany."""
    joints: list[Vec | None] = [start, *(None for _ in elements)]
    out: list[FreeContour] = []
    for made in _complete(FreeContour(elements, joints, [None] * len(elements), before), count(1)):
        if not any(_same(made, other) for other in out):
            out.append(made)
        if len(out) >= MOST_CONTOURS:
            break
    return out


def _same(a: FreeContour, b: FreeContour) -> bool:
    def centres(c: FreeContour) -> list[Vec]:
        return [k.centre for k in c.carriers if isinstance(k, DirectedCircle)]

    pairs = [*zip(a.joints, b.joints), *zip(centres(a), centres(b))]
    return all(p is not None and q is not None and math.dist(p, q) < 1e-6 for p, q in pairs)


def _complete(c: FreeContour, steps: Iterator[int]) -> Iterator[FreeContour]:
    """Take the unknown with the fewest candidates, and follow each."""
    if next(steps) > STEPS:
        raise TooMany
    unknown = [i for i, carrier in enumerate(c.carriers) if carrier is None]
    open_joints = [j for j, point in enumerate(c.joints) if point is None]
    if not unknown and not open_joints:
        yield c
        return
    carriers = [
        (len(candidates), i, candidates) for i in unknown if (candidates := _candidates(c, i)) is not None
    ]
    joints = [(len(where), j, where) for j in open_joints if (where := c.points(j)) is not None]
    if not carriers and not joints:
        raise Undetermined(c)
    fewest = min(carriers, key=lambda f: f[0], default=None)
    place = min(joints, key=lambda f: f[0], default=None)
    branches: list[FreeContour] = []
    if fewest is not None and (place is None or fewest[0] <= place[0]):
        for carrier in fewest[2]:
            then = [*c.carriers]
            then[fewest[1]] = carrier
            branches.append(FreeContour(c.elements, [*c.joints], then, c.before))
    elif place is not None:
        for point in place[2]:
            at = [*c.joints]
            at[place[1]] = point
            branches.append(FreeContour(c.elements, at, [*c.carriers], c.before))
    for branch in branches:
        if all(branch.fits(i) for i in range(len(c.elements))):
            yield from _complete(branch, steps)


def _candidates(c: FreeContour, i: int) -> Sequence[Carrier] | None:
    """Return the candidates for element i."""
    return _arcs(c, i) if c.elements[i].arc else _lines(c, i)


# -- lines --
def _lines(c: FreeContour, i: int) -> list[DirectedLine] | None:
    """Return the possible lines of element i; None where they are not determined."""
    e, start, end = c.elements[i], c.joints[i], c.joints[i + 1]
    after = c.carriers[i + 1] if i + 1 < len(c.elements) and c.elements[i + 1].tangential else None
    came = c.carriers[i - 1] if e.tangential and i else None
    for same in (came, after):
        if isinstance(same, DirectedLine):
            return [same]
    angles = _angles(c, i, after)
    parallel = c.parallel_to(i)
    if parallel is not None and e.apart is not None:
        return _parallels(parallel, e.apart, angles)
    if start is not None and end is not None and math.dist(start, end) > 1e-9:
        return [line_at(math.atan2(end[1] - start[1], end[0] - start[0]), DirectedCircle(start, 0.0))]
    touches = [[DirectedCircle(p, 0.0)] for p in (start, end, *e.through) if p is not None]
    touches += [[t] for t in (came, after) if isinstance(t, DirectedCircle)]
    if e.beside is not None:
        touches.append([DirectedCircle(e.beside[0], s * e.beside[1]) for s in (1.0, -1.0)])
    if angles is not None:
        return [line_at(a, t) for a in angles for t in touches[0]] if touches else None
    for k, group in enumerate(touches):
        for other in touches[k + 1 :]:
            if math.dist(group[0].centre, other[0].centre) > 1e-9:
                return [line for a, b in product(group, other) for line in lines_touching(a, b)]
    return None


def _angles(c: FreeContour, i: int, after: Carrier | None) -> list[float] | None:
    """Return the directions that a line may have."""
    e, end = c.elements[i], c.joints[i + 1]
    entry = c.entry(i)
    if entry is None and e.tangential:
        entry = c.end_tangent(i - 1)
    if entry is None and isinstance(after, DirectedCircle) and end is not None:
        entry = after.tangent_at(end)
    if entry is not None:
        return [entry]
    parallel = c.parallel_to(i)
    return None if parallel is None else [parallel.angle, parallel.angle + math.pi]


def _parallels(line: DirectedLine, apart: float, angles: list[float] | None) -> list[DirectedLine]:
    """Return the lines beside a line, on both sides, either way."""
    n = line.normal
    out = []
    for side in (1.0, -1.0):
        reach = line.offset + side * apart
        point = (reach * n[0], reach * n[1])
        ways = [line.angle, line.angle + math.pi] if angles is None else angles
        out += [line_at(a, DirectedCircle(point, 0.0)) for a in ways]
    return out


# -- arcs --
def _arcs(c: FreeContour, i: int) -> list[DirectedCircle] | None:
    """Return the possible circles of element i; None where they are not determined."""
    e = c.elements[i]
    senses = (1.0, -1.0) if e.clockwise is None else (-1.0,) if e.clockwise else (1.0,)
    sides = (1.0, -1.0) if e.beside is not None else (1.0,)
    rows, touching = _arc_data(c, i)
    out: list[DirectedCircle] = []
    for sense, side in product(senses, sides):
        radius = _radius(c, i)
        of_radius: list[Row] = [] if radius is None else [(0.0, 0.0, 1.0, sense * radius)]
        more = [] if e.beside is None else [DirectedCircle(e.beside[0], side * e.beside[1])]
        cpr = c.polar(e.cpr, e.pole, False)
        near = [] if cpr is None else [(e.pole, abs(cpr))]
        made = circles([*of_radius, *rows], [*touching, *more], near)
        if made is None:
            return None
        out += [m for m in made if m.rho * sense > 1e-9]
    return out


def _radius(c: FreeContour, i: int) -> float | None:
    """Return the radius of an arc: R, or from its chord s and its centre angle, s = 2 R sin(angle / 2)."""
    e, start, end = c.elements[i], c.joints[i], c.joints[i + 1]
    chord = math.dist(start, end) if start is not None and end is not None else e.length
    half = math.sin(e.turn / 2.0) if e.turn is not None else 0.0
    if e.radius is None and chord and abs(half) > 1e-9:
        return chord / (2.0 * abs(half))
    return e.radius


def _arc_data(c: FreeContour, i: int) -> tuple[list[Row], list[DirectedCircle]]:
    """Return the known data of centre and radius of an arc besides its own radius."""
    e = c.elements[i]
    rows: list[Row] = []
    touching = [DirectedCircle(p, 0.0) for p in e.through]
    x, y = c.coordinate(e.cx, 0), c.coordinate(e.cy, 1)
    rows += [] if x is None else [(1.0, 0.0, 0.0, x)]
    rows += [] if y is None else [(0.0, 1.0, 0.0, y)]
    cpr, cpa = c.polar(e.cpr, e.pole, False), c.polar(e.cpa, e.pole, True)
    if cpa is not None and cpr is not None:
        rows.append((1.0, 0.0, 0.0, e.pole[0] + cpr * math.cos(cpa)))
        rows.append((0.0, 1.0, 0.0, e.pole[1] + cpr * math.sin(cpa)))
    elif cpa is not None:
        n = (-math.sin(cpa), math.cos(cpa))
        rows.append((n[0], n[1], 0.0, n[0] * e.pole[0] + n[1] * e.pole[1]))
    entry = c.entry(i)
    if entry is None and e.tangential:
        entry = c.end_tangent(i - 1)
    follows = i + 1 < len(c.elements) and c.elements[i + 1].tangential
    _end_data(c.joints[i], entry, c.carriers[i - 1] if e.tangential and i else None, rows, touching)
    exit_way = c.tangent(i + 1, i + 1) if follows else None
    _end_data(c.joints[i + 1], exit_way, c.carriers[i + 1] if follows else None, rows, touching)
    return rows, touching


def _end_data(
    point: Vec | None,
    way: float | None,
    beside: Carrier | None,
    rows: list[Row],
    touching: list[DirectedCircle],
) -> None:
    """Evaluate the end of an arc: a point with or without its direction, or the element that the arc touches there."""
    if point is not None and way is not None:
        rows += rows_at(point, way)
    elif point is not None:
        touching.append(DirectedCircle(point, 0.0))
    elif isinstance(beside, DirectedLine):
        rows.append(touch_row(beside))
    elif beside is not None:
        touching.append(beside)
