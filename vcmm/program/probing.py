"""Surfaces read by a probe: towards one, until ball and surface meet, and back. For the cycles of all controls."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple

from vcmm.program.faults import BlockFault, ProgramFault
from vcmm.program.moves import ORIGIN, Point
from vcmm.program.recorder import Recorder
from vcmm.program.setup import Tool
from vcmm.program.touching import ProbeContact, first_contact, left_contact, stopped_at

OVERTRAVEL = 10.0  # mm beyond the expected surface, as in Renishaw's Inspection Plus (Q) and usual as set-up of a probe elsewhere


class ProbedCircle(NamedTuple):
    """Middle and diameter, mm as programmed."""

    x: float
    y: float
    diameter: float


class Feeler(NamedTuple):
    """A probe on a recorder, and how far it goes beyond what it expects, mm."""

    recorder: Recorder
    tool: Tool
    overtravel: float = OVERTRAVEL

    @property
    def radius(self) -> float:
        """Radius of the ball, mm."""
        return ball_radius(self.tool)

    def feel(self, towards: Point, distance: float) -> Point:
        """Return the tip position (mm as programmed) when the probe answers: along a unit vector, and back.

        distance: mm at which it is expected to answer; where the set-up states no surface on that way, it does there.
        """
        r, start = self.recorder, self.recorder.p
        ends = [
            tuple(p + way * t for p, t in zip(start, towards))
            for way in (distance + self.overtravel, distance)
        ]
        met = touch(
            r, (ends[0][0], ends[0][1], ends[0][2]), self.tool, expected=(ends[1][0], ends[1][1], ends[1][2])
        )
        if not met:
            r.fault(
                f"the probe is behind the surface that it is to touch, its ball of {2.0 * self.radius:g} mm does not fit, or it finds nothing within "
                f"{self.overtravel:g} mm beyond: check where it starts, the expected position or size, and the way that it may go"
            )
        tip = r.p
        r.straight(start, False)
        return tip

    def until(self, towards: Point, farthest: float) -> Point | None:
        """Return the same without an expected place: None after so far (mm) without an answer."""
        r, start = self.recorder, self.recorder.p
        x, y, z = (p + farthest * t for p, t in zip(start, towards))
        met = touch(r, (x, y, z), self.tool)
        tip = r.p
        r.straight(start, False)
        return tip if met else None

    def surface(self, axis: int, expected: float, sense: float) -> float:
        """Return the coordinate of a surface along an axis (0, 1, 2), mm as programmed: the probe goes there, and back.

        expected: the place of the surface in the program; sense: +1 or -1, the way to it. From the side the ball touches its
        radius before; from above with its lowest point; from below with its highest one, and the reading stays low by the diameter,
        since along the probe controls correct the length alone (HEIDENHAIN, TNC7, cycle 427: Q272 = 3). A remark states it.
        """
        below = axis == 2 and sense > 0
        radius = 0.0 if axis == 2 else self.radius
        distance = sense * (expected - self.recorder.p[axis]) - (2.0 * self.radius if below else radius)
        tip = self.feel(at(ORIGIN, axis, sense), distance)
        if below and self.radius:
            self.recorder.remark(
                f"Z is touched from below: along the probe the control corrects its length alone, so the reading is {2.0 * self.radius:g} mm (the ball) below "
                "the surface; add the diameter of the ball where the program goes on with it",
                kind="from below",
            )
        return tip[axis] + sense * radius

    def rim(self, middle: tuple[float, float], diameter: float, angle: float, inside: bool) -> Point:
        """Return the tip position when a bore answers from inside, a boss from outside, at an angle (rad) about its expected middle."""
        x, y = math.cos(angle), math.sin(angle)
        sense = 1.0 if inside else -1.0
        here = self.recorder.p
        from_middle = (here[0] - middle[0]) * x + (here[1] - middle[1]) * y
        reach = diameter / 2.0 - sense * self.radius
        return self.feel((sense * x, sense * y, 0.0), sense * (reach - from_middle))

    def circle(self, tips: Sequence[Point], inside: bool) -> ProbedCircle:
        """Return the bore or boss through touches at tips."""
        x, y, radius = circle_through(tips)
        return ProbedCircle(x, y, 2.0 * (radius + (self.radius if inside else -self.radius)))


@contextmanager
def measuring_cycle(r: Recorder, what: str, feed: float) -> Iterator[None]:
    """Run a measuring cycle of the control, its ways at a feed per minute. In a survey an unsupported cycle is passed over with a remark,
    strict it is refused."""
    before = r.feed_mode, r.feed
    r.feed_mode, r.feed = "G94", feed
    try:
        yield
    except (BlockFault, ProgramFault) as fault:
        if r.setup.strict:
            raise
        reason = fault.text if isinstance(fault, BlockFault) else fault.reason
        r.assume(what, f"passed over from where it stops: {reason}")
    finally:
        r.feed_mode, r.feed = before


def ball_radius(tool: Tool) -> float:
    """Return the radius of the ball, mm; 0 where the set-up does not state it."""
    return (tool.diameter or 0.0) / 2.0


def circle_through(points: Sequence[Point]) -> tuple[float, float, float]:
    """Return the middle and radius of the circle through three points in X and Y, by least squares through more (as x^2 + y^2 = 2ax + 2by + c).

    Hand check: (1, 0), (-1, 0), (0, 1) give 0, 0, 1.
    """
    import numpy as np

    at_ = np.array([p[:2] for p in points])
    shift = at_.mean(axis=0)
    x, y = (at_ - shift).T
    a, b, c = np.linalg.lstsq(
        np.stack([2.0 * x, 2.0 * y, np.ones(len(x))], axis=1), x * x + y * y, rcond=None
    )[0]
    return float(a + shift[0]), float(b + shift[1]), math.sqrt(float(c + a * a + b * b))


def meeting(
    lines: Sequence[Sequence[Point]], sense: Sequence[float], radius: float
) -> tuple[float, float, list[float]]:
    """Return the meeting point of two surfaces: that touched along Y (by one tip or two along X) and that touched along X; their
    angles in deg from X+.

    One tip: parallel to its axis, or square to the other surface where that is known. A surface lies the radius beyond its tips.
    """
    turned = [math.atan2(t[1][1] - t[0][1], t[1][0] - t[0][0]) if len(t) == 2 else None for t in lines]
    turned = [None if a is None else _near(a, k * math.pi / 2.0) for k, a in enumerate(turned)]
    first = turned[0] if turned[0] is not None else (turned[1] or math.pi / 2.0) - math.pi / 2.0
    second = turned[1] if turned[1] is not None else first + math.pi / 2.0
    rows, right = [], []
    for tips, angle, k in ((lines[0], first, 1), (lines[1], second, 0)):
        normal = (-math.sin(angle), math.cos(angle)) if k == 1 else (math.sin(angle), -math.cos(angle))
        rows.append(normal)
        right.append(normal[0] * tips[0][0] + normal[1] * tips[0][1] + sense[k] * radius)
    (a, b), (c, d) = rows
    det = a * d - b * c
    return (
        (right[0] * d - b * right[1]) / det,
        (a * right[1] - c * right[0]) / det,
        [math.degrees(first), math.degrees(second)],
    )


def _near(angle: float, usual: float) -> float:
    """Return the same line's angle within 90 deg of the usual one."""
    return angle - math.pi * round((angle - usual) / math.pi)


def touch(r: Recorder, end: Point, tool: Tool, expected: Point | None = None, stops: bool = True) -> bool:
    """Move straight towards a programmed point until the probe answers; return whether it does. Rotary axes are at rest.

    expected: the programmed point at which it answers where no surface is stated on this way; None: it goes on to the end.
    stops: else the way goes on to its end, and only where it answered is kept.
    """
    r.free("a probing move is programmed")
    _check_tool(r, tool)
    tip, radius, target = r.tip(), ball_radius(tool), r.world.apply(end)
    centre = (0.0, 0.0, radius)  # over the tip, which is the lowest point
    met = first_contact(r.setup.surfaces, tip, target, radius, centre)
    if met is None and expected is not None:
        expected_tips, number = r.setup.expected_at, len(r.touches)
        met = stopped_at(
            tip, expected_tips[number] if number < len(expected_tips) else r.world.apply(expected), target
        )
        if met is not None:
            r.assume(
                "where the surfaces lie that are probed", "where the program expects them", matters=False
            )
    return _answer_probe(r, met, end, stops)


def leave(r: Recorder, end: Point, tool: Tool) -> bool:
    """Move straight away from a surface until the probe is free (G38.4); return whether it touched one at the start."""
    r.free("a probing move is programmed")
    _check_tool(r, tool)
    radius = ball_radius(tool)
    met = left_contact(r.setup.surfaces, r.tip(), r.world.apply(end), radius, (0.0, 0.0, radius))
    return _answer_probe(r, met, end, True)


def _check_tool(r: Recorder, tool: Tool) -> None:
    if tool.number and tool.shape not in ("probe", "ball"):
        what = f"of {tool.diameter:g} mm" if tool.diameter else "without a diameter"
        r.remark(
            f'tool {tool.number} probes, which is no probe (shape = "probe") but {tool.shape} {what}: it touches like a ball of that diameter',
            kind=f"probes {tool.number}",
        )


def _answer_probe(r: Recorder, met: tuple[Point, Point, Point] | None, end: Point, stops: bool) -> bool:
    """Make the move to the place where the probe answers, which may be read later, and return whether it answered."""
    goal = end
    if met is not None:
        number, read = len(r.touches), r.setup.read_out
        r.touches.append(
            ProbeContact(
                line=r.line,
                tip=met[0],
                along=met[1],
                normal=met[2],
                tool=r.tool,
                tool_offset=r.tool_offset,
                offset=r.offset,
                rotary=r.rotary,
            )
        )
        further = read[number] if number < len(read) else 0.0
        x, y, z = (p + further * a for p, a in zip(met[0], met[1]))
        goal = r.world.undo((x, y, z))
    r.straight(goal, False)
    r.skip, r.skip_axes = goal, r.q
    if not stops and met is not None:
        r.straight(end, False)
    return met is not None


def shifted_zero(r: Recorder, reads: Point, should: Point) -> Point:
    """Return the work offset in force, shifted so that what now reads `reads` (mm) will read `should`; machine axes, mm."""
    here, there = r.world.apply(should), r.world.apply(reads)
    old = r.offsets.get(r.offset, ORIGIN)
    return old[0] + there[0] - here[0], old[1] + there[1] - here[1], old[2] + there[2] - here[2]


def correct_zero(
    r: Recorder, name: str, reads: Sequence[float | None], should: Sequence[float | None]
) -> None:
    """Correct a work offset (that in force, or another, which takes the corrected values over), so that `reads` will read `should` in the axes that
    are not None."""
    p = r.p
    reading, goal = (
        tuple(p[i] if v is None else v for i, v in enumerate(which)) for which in (reads, should)
    )
    shifted = shifted_zero(r, (reading[0], reading[1], reading[2]), (goal[0], goal[1], goal[2]))
    if name != r.offset:
        before = r.offsets.get(name, ORIGIN)
        x, y, z = (before[i] if reads[i] is None else shifted[i] for i in range(3))
        shifted = (x, y, z)
    r.offsets[name] = shifted


def correct_turn(r: Recorder, name: str, by: float) -> None:
    """Turn a work offset about its zero by so many rad."""
    old = r.rotations.get(r.offset, 0.0)
    r.rotations[name] = old + by


def at(point: Point, axis: int, value: float) -> Point:
    """Return the point with another coordinate along an axis."""
    out = list(point)
    out[axis] = value
    return out[0], out[1], out[2]
