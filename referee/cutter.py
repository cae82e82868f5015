"""A milling machine of three axes that cuts a program and has its part measured, by plain geometry.

A program of straight moves and circles is a list of stretches of the tool's path in the workpiece system, with times. A wall point is
made where the tool stands beside it, a floor point while the flat end covers it; of several passes the deepest counts. The deviation
is the path's own gap plus the tip error (actual - commanded, workpiece axes, ISO 230-1) along the outward normal, to first order.

Sources: ISO 841 (axes), ISO 230-1:2012 (squareness C0Y: Y leans by -c y in x), Kienzle (force grows as feed per tooth to 0.75).
"""

import itertools
import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field, fields

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ACCELERATION = 3000.0  # mm/s^2
RAPID = 500.0  # mm/s
CHORD = math.radians(0.1)  # of a circle: its sagitta at 10 mm is 4 nm
NEAR = 0.2  # mm: a pass further off makes no part of the surface asked for
PLAY = 0.02  # mm: more than any play, less than any way
ENDS = 41  # places looked at along a stretch for a floor


@dataclass
class Cutting:
    """What the tool does, a row each.

    tool: number; feed mm/min, 0 for rapids; speed 1/min; block: number of the NC block; cutting: number of the pass, -1 for rapids;
    pull (n, 3): acceleration towards the centre of a circle, mm/s^2.
    """

    tool: NDArray[np.int_]
    feed: Array
    speed: Array
    block: NDArray[np.int_]
    cutting: NDArray[np.int_]
    pull: Array


@dataclass
class Path(Cutting):
    """Stretches of a program. start, end (n, 3) mm, tool tip in the workpiece system; began, ended: times in s."""

    start: Array
    end: Array
    began: Array
    ended: Array


def read_program(text: str) -> Path:
    """Stretches of a program of G0, G1, G2, G3 (I, J), G4 P (ms), absolute, mm.

    Raises
    ------
    ValueError
        For a preparatory function that is none of these.
    """
    rows: list[tuple] = []
    here, time, mode, feed, speed, tool, cutting, was_rapid = (
        np.array([0.0, 0, 100]),
        0.0,
        0,
        0.0,
        0.0,
        0,
        -1,
        True,
    )
    known = {0, 1, 2, 3, 4, 17, 21, 40, 43, 49, 54, 80, 90, 94}
    for number, line in enumerate(text.splitlines()):
        words = re.findall(r"([A-Z])([-+]?[0-9]*\.?[0-9]+)", re.sub(r"\(.*?\)", "", line))
        values = {letter: float(value) for letter, value in words if letter not in "GM"}
        codes = [int(float(value)) for letter, value in words if letter == "G"]
        if strange := set(codes) - known:
            raise ValueError(f"line {number + 1}: G{strange.pop()} is not known to this cutter")
        if line.startswith("O"):
            continue
        feed, speed, tool = values.get("F", feed), values.get("S", speed), int(values.get("T", tool))
        if 4 in codes:
            time += values["P"] / 1000
            continue
        mode = next((c for c in codes if c < 4), mode)
        goal = np.array([values.get(a, v) for a, v in zip("XYZ", here, strict=True)])
        if not set("XYZIJ") & set(values):
            continue
        corners, centre = [here, goal], None
        if mode in (2, 3):
            centre = here + (values.get("I", 0.0), values.get("J", 0.0), 0)
            corners = _circle(here, goal, values.get("I", 0.0), values.get("J", 0.0), mode == 3)
        rapid = mode == 0
        if not rapid and was_rapid:
            cutting += 1
        was_rapid = rapid
        pace = RAPID if rapid else feed / 60
        lengths = [float(np.linalg.norm(b - a)) for a, b in itertools.pairwise(corners)]
        if not sum(lengths):
            continue
        stop = pace / ACCELERATION  # a trapezoid of speed takes that much longer
        scale = (sum(lengths) / pace + stop) / sum(lengths)
        for a, b, length in zip(corners[:-1], corners[1:], lengths, strict=True):
            rows.append(
                (
                    tool,
                    0.0 if rapid else feed,
                    speed,
                    number,
                    -1 if rapid else cutting,
                    _pull((a + b) / 2, centre, pace),
                    a,
                    b,
                    time,
                    time + length * scale,
                )
            )
            time += length * scale
        here = goal
    columns = list(zip(*rows, strict=True))
    return Path(*(np.array(c) for c in columns))


def _pull(at: Array, centre: Array | None, pace: float) -> Array:
    """Acceleration v^2/r towards the centre of a circle."""
    if centre is None:
        return np.zeros(3)
    inwards = (centre - at) * (1, 1, 0)
    return pace**2 * inwards / (inwards @ inwards)


def _circle(here: Array, goal: Array, i: float, j: float, left: bool) -> list[Array]:
    """Corners of short chords on a circle; one that ends where it begins is whole."""
    centre = here[:2] + (i, j)
    first = math.atan2(here[1] - centre[1], here[0] - centre[0])
    last = math.atan2(goal[1] - centre[1], goal[0] - centre[0])
    sweep = (last - first) % (2 * math.pi) if left else -((first - last) % (2 * math.pi))
    if abs(sweep) < 1e-9:
        sweep = 2 * math.pi if left else -2 * math.pi
    count = max(1, round(abs(sweep) / CHORD))
    share = np.linspace(0, 1, count + 1)
    radius = math.hypot(i, j)
    angles = first + sweep * share
    points = np.column_stack(
        [
            centre[0] + radius * np.cos(angles),
            centre[1] + radius * np.sin(angles),
            here[2] + (goal[2] - here[2]) * share,
        ]
    )
    points[-1] = goal
    return list(points)


@dataclass
class Moment(Cutting):
    """Where and when a contact is made.

    q (n, 3) mm: position of the tip; time s; sense (n, 3): the way each axis went last; velocity (n, 3) mm/s; way: cut so far, mm;
    force (n, 3) N: of the part on the tool, zero where nobody asked the cutter for it.
    """

    q: Array
    time: Array
    sense: Array
    velocity: Array
    way: Array
    force: Array

    def take(self, rows: NDArray[np.int_]) -> "Moment":
        """Some of them."""
        return Moment(*(getattr(self, f.name)[rows] for f in fields(self)))


Error = Callable[
    [Moment, Array], tuple[Array, Array]
]  # moments, normals -> tip error (n, 3) mm, growth of the tool's radius (n,) mm


@dataclass
class Cutter:
    """A program with its senses and ways, ready to be asked what it does at points.

    radius: of each tool, mm; force_of: what moments at walls meet (`referee.forces`), N.
    """

    path: Path
    radius: dict[int, float]
    force_of: Callable[["Moment"], Array] | None = None
    senses: Array = field(init=False)
    ways: Array = field(init=False)

    def __post_init__(self) -> None:
        """Sense of X and Y in each stretch (the last way they went), and the way cut by each tool up to its start.

        An axis has turned back when it is `PLAY` behind the furthest place of its last way, however many stretches that takes: a play
        operator, so that chords of a circle turn it and the small steps of a corrected straight do not.
        """
        self.senses = np.ones((len(self.path.start), 3))
        for k in range(3):
            sense, furthest = 1.0, float(self.path.start[0, k])
            for i, end in enumerate(self.path.end[:, k].tolist()):
                if (end - furthest) * sense < -PLAY:
                    sense = -sense
                    furthest = end
                elif (end - furthest) * sense > 0:
                    furthest = end
                self.senses[i, k] = sense
        length = np.where(
            self.path.cutting >= 0, np.linalg.norm(self.path.end - self.path.start, axis=1), 0.0
        )
        self.ways = np.zeros(len(length))
        for tool in set(self.path.tool.tolist()):
            mine = self.path.tool == tool
            self.ways[mine] = np.cumsum(length * mine)[mine] - length[mine]

    def moments(self, rows: NDArray[np.int_], share: Array) -> Moment:
        """Moments in stretches `rows`, each at a share of its length."""
        p = self.path
        step, took = p.end[rows] - p.start[rows], p.ended[rows] - p.began[rows]
        long = np.linalg.norm(step, axis=1)
        return Moment(
            q=p.start[rows] + share[:, None] * step,
            time=p.began[rows] + share * took,
            sense=self.senses[rows],
            velocity=step / np.maximum(long, 1e-12)[:, None] * (p.feed[rows] / 60)[:, None],
            way=self.ways[rows] + share * long,
            force=np.zeros((len(rows), 3)),
            tool=p.tool[rows],
            feed=p.feed[rows],
            speed=p.speed[rows],
            block=p.block[rows],
            cutting=p.cutting[rows],
            pull=p.pull[rows],
        )

    def contacts(self, point: Array, normal: Array) -> tuple[Moment, Array]:
        """Where the path makes this point, and the gap that it leaves there (mm, outwards positive)."""
        p = self.path
        tip, end = p.start, p.end
        radii = np.array([self.radius[int(t)] if t else 0.0 for t in p.tool])
        can = (p.feed > 0) & (np.minimum(tip[:, 2], end[:, 2]) <= point[2] + NEAR)
        if normal[2] > 0.9:
            reach = radii + np.linalg.norm(end - tip, axis=1) / 2
            close = np.flatnonzero(
                can & (np.linalg.norm((tip + end)[:, :2] / 2 - point[:2], axis=1) <= reach)
            )
            share = np.linspace(0, 1, ENDS)
            at = tip[close, None] + share[None, :, None] * (end - tip)[close, None]
            covers = np.linalg.norm(at[..., :2] - point[:2], axis=2) <= radii[close, None]
            covers &= np.abs(at[..., 2] - point[2]) < NEAR
            rows, places = np.nonzero(covers)
            moments = self.moments(close[rows], share[places])
            return moments, moments.q[:, 2] - point[2]
        along = np.array([-normal[1], normal[0]])
        first, last = (tip[:, :2] - point[:2]) @ along, (end[:, :2] - point[:2]) @ along
        can &= (
            (np.minimum(first, last) <= 1e-9)
            & (np.maximum(first, last) >= -1e-9)
            & (np.abs(last - first) > 1e-9)
        )
        rows = np.flatnonzero(can)
        moments = self.moments(rows, np.clip(-first[rows] / (last - first)[rows], 0, 1))
        gap = (moments.q[:, :2] - point[:2]) @ normal[:2] - radii[rows]
        near = np.flatnonzero((np.abs(gap) < NEAR) & (moments.q[:, 2] <= point[2] + 1e-3))
        return moments.take(near), gap[near]

    def cut(self, points: Array, normals: Array, errors: list[Error]) -> tuple[Array, Moment]:
        """Deviation of the cut surface at points along their outward normals (n,) mm, and the moments that made it.

        Raises
        ------
        ValueError
            Where the program does not make a point.
        """
        rows, deviations = [], []
        for point, normal in zip(points, normals, strict=True):
            moments, gap = self.contacts(point, normal)
            if not len(gap):
                raise ValueError(f"the program does not make the point {point.round(3)}")
            if self.force_of is not None and normal[2] < 0.9:
                moments.force = self.force_of(moments)
            many = np.broadcast_to(normal, moments.q.shape)
            for error in errors:
                tip, grown = error(moments, many)
                gap = gap + np.einsum("ni,ni->n", tip, many) - (grown if normal[2] < 0.9 else 0.0)
            deepest = int(np.argmin(gap))
            deviations.append(gap[deepest])
            rows.append(moments.take(np.array([deepest])))
        joined = Moment(*(np.concatenate([getattr(r, f.name) for r in rows]) for f in fields(Moment)))
        return np.array(deviations), joined
