"""Smoothing: rows of short lines as one curve within the contour tolerance, as the look-ahead of a control leads them.

Rounding off the numbers of a program turns every chord a little; followed block by block, these turns cost most of the feed. Here
every turn u (change of direction) at s_k is spread evenly over a way h to both sides of it:

    q(s) = p(s) + sum of u g(s - s_k),   g(x) = (h - |x|)^3 / 6 h^2  for |x| < h,   g'' = (h - |x|) / h^2

p: the programmed lines. g cancels the kink of p, so that q has continuous curvature; where the ways of several turns overlap, turns to
opposite sides cancel, which is what smoothing is. One turn alone leaves the program by u h / 6, with |q''| <= u / h and
|q'''| = u / h^2. On a circle of radius R this would cut the corner by h^2 / 12 R; therefore crowded points are first moved
outwards by what the smoothing would take (one step of the inverse), which leaves its square.

h is as large as the feed asks for, so that 0.6 of the acceleration and half of the jerk of every axis carry it, and no larger than the
tolerance allows. Method: convolution of the path with a hat, the first two moments of Sencer, Ishizaki & Shamoto, Int. J. Adv.
Manuf. Technol. 76 (2015) 1731 (FIR smoothing of corners), here over the way instead of the time, with a way of its own for each turn.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from vcmm.core.run import Array
from vcmm.program.limits import Limits
from vcmm.shop.motion.blend import WEIGHT, direction_jump, widest_reach
from vcmm.shop.motion.curves import Curves, Ints

SHARP = 0.5  # rad: a turn above is a corner of its own
CROWDED = 1.0 - 1e-9  # share of half a line from which its two roundings would meet
# of the search for h: it grows until the feed is carried, and shrinks into the tolerance
ROUNDS = 16
GROWTH = 1.4
SHRINK = 0.7
LAST_ROUNDS = 60
SAME_BREAK_MM = 1e-9  # mm: breaks closer than this are one
LOOKS = (0.0, 0.25, 0.5, 0.75, 1.0)  # shares of a piece at which the deviation is looked at
KEPT = 0.98  # share of the tolerance that may be used at the points that are compared
ACCELERATION, JERK = 0.6, 0.5  # shares of the limits that bends may take (vcmm.shop.motion.timing)
Bools = np.typing.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Pieces:
    """k pieces of cubics: begin (k,) and length (k,) in programmed distance, coefficients (k, 6, 6), move (k,).

    joints (m,): those that are smoothed;  kept_short (m,): whose h the tolerance limits;  whole (n,): moves that the pieces replace
    altogether.
    """

    begin: Array
    length: Array
    coefficients: Array
    move: Ints
    joints: Ints
    kept_short: Bools
    whole: Bools


@dataclass(frozen=True, eq=False)
class ShortLines:
    """Points of all rows, one after another: s (m,), place (m, 6), line (m,) that begins there, joint (m,) or -1 at the ends."""

    s: Array
    place: Array
    line: Ints
    joint: Ints
    row: Ints
    limit: Array  # (m,) mm: distance to the nearer end of the row, 0 at the ends

    def take(self, at: Ints) -> ShortLines:
        return ShortLines(*(getattr(self, f.name)[at] for f in fields(self)))


@dataclass(frozen=True, eq=False)
class PathWishes:
    """Wishes of the moves: speed (n,) mm/s, tolerance (n,) mm and jerk along the path (n,) mm/s^3 per line; stops at (k,) mm; axes."""

    speed: Array
    tolerance: Array
    jerk: Array
    stops: Array
    limits: Limits
    kernel: bool = True

    def speed_at(self, s: Array, line: Ints) -> Array:
        """Return the highest speed (b,) at s: from rest at a stop x away no more than (9/2 j x^2)^(1/3), from x = j t^3 / 6, v = j t^2 / 2."""
        k = np.clip(np.searchsorted(self.stops, s), 1, len(self.stops) - 1)
        x = np.minimum(np.abs(s - self.stops[k - 1]), np.abs(self.stops[k] - s))
        return np.asarray(np.minimum(self.speed[line], np.cbrt(4.5 * self.jerk[line] * x**2)))


def no_pieces(n: int) -> Pieces:
    """Return no pieces, for a path without smoothing."""
    none = np.zeros(0, dtype=np.intp)
    return Pieces(
        begin=np.zeros(0), length=np.zeros(0), coefficients=np.zeros((0, 6, 6)), move=none, joints=none,
        kept_short=none.astype(bool), whole=np.zeros(n, dtype=bool),
    )  # fmt: skip


def crowded_joints(curves: Curves, reach: Array, tolerance: Array, stop: Bools) -> Bools:
    """Return the joints (n-1,) that are smoothed together: rows of lines with at least one whose roundings at both ends would meet.

    reach (n-1,): of the roundings that the feed asks for. A corner that its tolerance keeps short stays one by itself.
    """
    first, second = np.arange(curves.n - 1), np.arange(1, curves.n)
    half = 0.5 * np.minimum(curves.length[first], curves.length[second]) * CROWDED
    turn, _ = direction_jump(curves, first, second)
    size = np.linalg.norm(turn * WEIGHT, axis=1)
    lines = (curves.arc[first] < 0) & (curves.arc[second] < 0)
    fits = lines & ~stop & (tolerance > 0) & (np.linalg.norm(turn, axis=1) < SHARP)
    fits &= widest_reach(size, tolerance) >= half
    row = np.cumsum(np.diff(fits, prepend=False))  # a number for each run of equal answers
    meets = np.zeros(int(row.max(initial=0)) + 1, dtype=bool)
    meets[row[fits & (reach >= half)]] = True
    return fits & meets[row]


def smooth_pieces(curves: Curves, chosen: Bools, reach: Array, wishes: PathWishes) -> Pieces:
    """Return the rows of the joints `chosen` (n-1,) as pieces; reach (n-1,): of the roundings at the joints that are not chosen."""
    if not chosen.any():
        return no_pieces(curves.n)
    rows = _rows(curves, chosen, np.where(chosen, 0.0, reach))
    width, short = _widths(rows, wishes)
    return _pieces(rows, _path(rows, width, wishes.kernel), short, curves.n)


def _widths(rows: ShortLines, wishes: PathWishes) -> tuple[Array, Bools]:
    """Return (h (m,) mm, where the tolerance decides on it): h grows until the feed is carried, and shrinks until the tolerance is kept."""
    width, cap = _first_widths(rows, wishes), rows.limit.copy()
    short, unsettled = np.zeros(len(width), dtype=bool), np.ones(len(width), dtype=bool)
    for turn in range(ROUNDS + LAST_ROUNDS):
        at = np.flatnonzero(unsettled)
        part = rows.take(at)
        off, slow = _worst(part, _path(part, width[at], wishes.kernel, False), wishes)
        cap[at] = np.where(off > KEPT, SHRINK * width[at], cap[at])
        short[at] = (cap[at] < rows.limit[at]) | (slow > 1.0)
        wanted = np.where((slow > 1.0) & (turn < ROUNDS), GROWTH * width[at], width[at])
        after = np.minimum(wanted, cap[at])
        changed = np.zeros(int(rows.row[-1]) + 1, dtype=bool)
        changed[part.row[after != width[at]]] = True
        width[at] = after
        unsettled = changed[rows.row]
        if not unsettled.any():
            break
    return width, short


def _rows(curves: Curves, chosen: Bools, reach: Array) -> ShortLines:
    """Return the points of the rows: where a rounding before them ends, the joints, where one after them begins."""
    begins, ends = np.cumsum(curves.length) - curves.length, np.cumsum(curves.length)
    joints = np.flatnonzero(chosen)
    heads = joints[np.append(True, np.diff(joints) > 1)]
    tails = joints[np.append(np.diff(joints) > 1, True)]
    lead = np.where(heads > 0, reach[heads - 1], 0.0)
    trail = np.where(tails + 1 < len(chosen), np.append(reach, 0.0)[tails + 1], 0.0)
    s = np.concatenate([begins[heads] + lead, ends[joints], ends[tails + 1] - trail])
    line = np.concatenate([heads, joints + 1, tails + 1])
    joint = np.concatenate([np.full(len(heads), -1), joints, np.full(len(tails), -1)])
    order = np.lexsort((np.repeat([0, 1, 2], [len(heads), len(joints), len(tails)]), line))
    s, line, joint = s[order], line[order], joint[order]
    row = np.searchsorted(heads, line, side="right") - 1
    low, high = s[np.searchsorted(row, row, side="left")], s[np.searchsorted(row, row, side="right") - 1]
    return ShortLines(s, curves.at(line, s - begins[line]), line, joint, row, np.minimum(s - low, high - s))


def _first_widths(rows: ShortLines, wishes: PathWishes) -> Array:
    """Return h (m,) mm to begin with: what a turn alone needs at its feed, between the shorter and the mean of the lines beside it."""
    turn = np.abs(_turns(rows, rows.place))
    v = wishes.speed[rows.line][:, None]
    needed = np.maximum(
        turn * v**2 / (ACCELERATION * wishes.limits.acceleration),
        np.sqrt(turn * v**3 / (JERK * wishes.limits.jerk)),
    ).max(axis=1)
    before, after = np.diff(rows.s, prepend=rows.s[:1]), np.diff(rows.s, append=rows.s[-1:])
    return np.minimum(np.clip(needed, np.minimum(before, after), 0.5 * (before + after)), rows.limit)


def _turns(rows: ShortLines, place: Array) -> Array:
    """Change of direction (m, 6) at the joints of lines through `place` (m, 6); 0 at the ends of the rows."""
    length = np.diff(rows.s)[:, None]
    slope = np.diff(place, axis=0) / np.where(length > 0, length, 1.0)
    turn = np.zeros_like(place)
    turn[1:-1] = np.diff(slope, axis=0)
    turn[rows.joint < 0] = 0.0
    return turn


@dataclass(frozen=True, eq=False)
class Path:
    """The smoothed path at its breaks (b,): s, line, row; q and its first two derivatives (b, 6); off (b, 6) from the program; by kernel.

    first, last (m,): the breaks that the spread turn of a point reaches.
    """

    s: Array
    line: Ints
    row: Ints
    q: tuple[Array, Array, Array]
    off: Array
    first: Ints
    last: Ints
    kernel: bool


def _path(rows: ShortLines, width: Array, kernel: bool = True, slopes: bool = True) -> Path:
    """Return the breaks of the sum of spread turns, and the path there; the search for widths needs no slopes, which are 0 then."""
    s, row, point = _breaks(rows, width)
    inside = np.flatnonzero((rows.joint >= 0) & (width > 0))
    first = np.searchsorted(s, rows.s - width - SAME_BREAK_MM, side="left")
    last = np.searchsorted(s, rows.s + width + SAME_BREAK_MM, side="right") - 1
    spread = _Spread(s, rows.s[inside], width[inside], first[inside], last[inside], kernel)
    place = _moved_outwards(rows, width, spread.sum(_turns(rows, rows.place)[inside], 0), s)
    turn = _turns(rows, place)[inside]
    base, slope = _on_lines(rows, place, s, point)
    programmed, _ = _on_lines(rows, rows.place, s, point)
    slope = slope + spread.sum(turn, 1) if slopes else np.zeros_like(slope)
    q = base + spread.sum(turn, 0), slope, spread.sum(turn, 2)
    return Path(s, rows.line[point], row, q, off=q[0] - programmed, first=first, last=last, kernel=kernel)


def _breaks(rows: ShortLines, width: Array) -> tuple[Array, Ints, Ints]:
    """Return (s, row, point at or before) (b,) of the breaks: points, and where spread turns begin and end; those closer than SAME_BREAK_MM are one."""
    inside = rows.joint >= 0
    s = np.concatenate([rows.s, (rows.s - width)[inside], (rows.s + width)[inside]])
    row = np.concatenate([rows.row, rows.row[inside], rows.row[inside]])
    between = np.repeat([False, True], [len(rows.s), 2 * int(inside.sum())])
    order = np.lexsort((between, s, row))
    s, row, between = s[order], row[order], between[order]
    opens = np.append(True, (np.diff(s) >= SAME_BREAK_MM) | (np.diff(row) != 0))
    heap = np.cumsum(opens) - 1
    kept = ~between | (opens & (np.bincount(heap, weights=~between)[heap] == 0))
    s, row, between = s[kept], row[kept], between[kept]
    return s, row, np.cumsum(~between) - 1


@dataclass(frozen=True, eq=False)
class _Spread:
    """Ranges over which k turns are spread: breaks s (b,), at (k,) and width (k,) mm, first and last break of each."""

    s: Array
    at: Array
    width: Array
    first: Ints
    last: Ints
    kernel: bool

    def sum(self, turn: Array, order: int) -> Array:
        """Sum (b, 6) of turn (k, 6) times g (order 0), its slope to the right of a break (1) or its second derivative (2)."""
        if self.kernel:
            from vcmm.shop.motion._smoothing_kernels import spread_turns

            return np.asarray(
                spread_turns(self.s, self.at, self.width, self.first, self.last, turn=turn, order=order)
            )
        count = self.last - self.first + 1
        k = np.repeat(np.arange(len(self.at)), count)
        i = np.arange(len(k)) - np.repeat(np.cumsum(count) - count, count) + self.first[k]
        h, x = self.width[k], self.s[i] - self.at[k]
        rest, side = np.maximum(h - np.abs(x), 0.0), np.where(x >= 0, -1.0, 1.0)
        value = (rest * rest * rest / (6 * (h * h)), side * (rest * rest) / (2 * (h * h)), rest / (h * h))[
            order
        ]
        out = np.zeros((len(self.s), turn.shape[1]))
        np.add.at(out, i, value[:, None] * turn[k])
        return out


def _on_lines(rows: ShortLines, place: Array, s: Array, point: Ints) -> tuple[Array, Array]:
    """Return (position, direction) (b, 6) at s on the lines through `place`; at the end of a row the direction before it."""
    opens = np.append(rows.row[1:] == rows.row[:-1], False)
    at = np.where(opens[point], point, point - 1)
    slope = (place[at + 1] - place[at]) / (rows.s[at + 1] - rows.s[at])[:, None]
    return place[at] + slope * (s - rows.s[at])[:, None], slope


def _moved_outwards(rows: ShortLines, width: Array, off: Array, s: Array) -> Array:
    """Return points (m, 6) moved against the deviation by smoothing, off (b, 6), where ways overlap.

    Not at all up to h = half the longer line beside, wholly from h = that line.
    """
    longer = np.maximum(np.diff(rows.s, prepend=rows.s[:1]), np.diff(rows.s, append=rows.s[-1:]))
    share = np.clip(2 * width / np.where(longer > 0, longer, 1.0) - 1.0, 0.0, 1.0)
    share[rows.joint < 0] = 0.0
    return np.asarray(rows.place - share[:, None] * off[np.searchsorted(s, rows.s, side="left")])


def _worst(rows: ShortLines, path: Path, wishes: PathWishes) -> tuple[Array, Array]:
    """Return for each point (m,) the largest share of the tolerance, and of the capacity of the axes at the feed, where its turn is spread."""
    off = np.append(_deviation(path) / wishes.tolerance[path.line[:-1]], 0.0)
    bend, third, line = path.q[2], _third(path), path.line[:-1]
    v = np.maximum(wishes.speed_at(path.s[:-1], line), wishes.speed_at(path.s[1:], line))[:, None]
    most = np.maximum(np.abs(bend[:-1]), np.abs(bend[1:]))
    slow = np.maximum(
        most * v**2 / (ACCELERATION * wishes.limits.acceleration), third * v**3 / (JERK * wishes.limits.jerk)
    ).max(axis=1)
    slow = np.where(np.diff(path.row) == 0, slow, 0.0)
    inside = np.flatnonzero(rows.joint >= 0)
    ends = np.stack([path.first[inside], path.last[inside]], axis=1).ravel()
    out_off, out_slow = np.zeros(len(rows.s)), np.zeros(len(rows.s))
    out_off[inside] = np.maximum.reduceat(off, ends)[
        ::2
    ]  # of the pieces between the first and the last break
    out_slow[inside] = np.maximum.reduceat(np.append(slow, 0.0), ends)[::2]
    return out_off, out_slow


def _deviation(path: Path) -> Array:
    """Return the largest distance (b-1,) mm from the program at five places between two breaks, where it is a cubic; 0 between two rows."""
    if path.kernel:
        from vcmm.shop.motion._curve_kernels import largest_deviation

        largest = largest_deviation(path.s, path.off, path.q[2], WEIGHT, np.array(LOOKS))
        return np.where(np.diff(path.row) == 0, largest, 0.0)
    length, bend, worst = np.diff(path.s)[:, None], path.q[2], np.zeros(len(path.s) - 1)
    for t in LOOKS:
        a, b = (1 - t) ** 3 - (1 - t), t**3 - t
        off = (1 - t) * path.off[:-1] + t * path.off[1:] + length**2 / 6 * (a * bend[:-1] + b * bend[1:])
        worst = np.maximum(worst, np.linalg.norm(off * WEIGHT, axis=1))
    return np.where(np.diff(path.row) == 0, worst, 0.0)


def _third(path: Path) -> Array:
    """Return the size (b-1, 6) of the third derivative between breaks."""
    length = np.diff(path.s)[:, None]
    return np.abs(np.diff(path.q[2], axis=0)) / np.where(length > 0, length, np.inf)


def _pieces(rows: ShortLines, path: Path, short: Bools, n: int) -> Pieces:
    """Return cubics between the breaks, by Taylor from each."""
    begin = np.flatnonzero(np.diff(path.row) == 0)
    length = path.s[begin + 1] - path.s[begin]
    step = length[:, None]
    coefficients = np.zeros((len(begin), 6, 6))
    coefficients[:, 0] = path.q[0][begin]
    coefficients[:, 1] = path.q[1][begin] * step
    coefficients[:, 2] = path.q[2][begin] * step**2 / 2
    coefficients[:, 3] = (path.q[2][begin + 1] - path.q[2][begin]) * step**2 / 6
    whole = np.zeros(n, dtype=bool)
    whole[rows.line] = True
    inside = rows.joint >= 0
    return Pieces(
        begin=path.s[begin], length=length, coefficients=coefficients, move=path.line[begin],
        joints=rows.joint[inside], kept_short=short[inside], whole=whole,
    )  # fmt: skip
