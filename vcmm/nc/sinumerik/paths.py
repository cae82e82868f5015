"""Motion of a Sinumerik block: end points, arcs in their forms, corners, modal cycles."""

from __future__ import annotations

import math

from vcmm.nc.moves import PLANES, Point
from vcmm.nc.recorder import radius_centre
from vcmm.nc.sinumerik import cycles
from vcmm.nc.sinumerik.state import AXES, CENTRES, ROTARY, SinumerikControl, SinumerikWords, point_of

MORE = ("CR", "AR", "I1", "J1", "K1")  # words that move too


class SinumerikPaths(SinumerikControl):
    """Executes the motion of a block."""

    def motion(self, words: SinumerikWords) -> None:
        called = next((c for c in words.commands if c.name == "MCALL"), None)
        if called is not None:
            words.commands.remove(called)
            rest = [c for c in words.commands if c.name in cycles.CYCLES]
            self.modes.cycle = rest[0] if rest else None
            self.modes.cycle_line = words.block.line
            if rest:
                words.commands.remove(rest[0])
        if not words.has(*AXES, *ROTARY, *CENTRES, *MORE):
            return
        if "G53" in words.g or "G153" in words.g or any(c.name == "SUPA" for c in words.commands):
            words.commands[:] = [c for c in words.commands if c.name != "SUPA"]
            self.machine_move(words)
            return
        before = len(self.r.moves)
        if self.r.compensation is not None:  # the style may have changed
            self.r.compensate(self.r.compensation.side, self.modes.style)
        self.interpolate(words)
        self.corner(words)
        if self.modes.cycle is not None and len(self.r.moves) > before:
            cycles.run(self, words.runner, self.modes.cycle, self.modes.cycle_line)

    def interpolate(self, words: SinumerikWords) -> None:
        motion = self.r.motion
        if motion is None:
            motion = "G1" if self.r.feed else "G0"
            if motion == "G0":
                self.r.remark(
                    "no G0 or G1 and no feed has been programmed; the motion is taken as rapid (G0)"
                )
        if motion in ("G2", "G3"):
            self.arc(words, clockwise=motion == "G2")
        elif motion == "CIP":
            self.circle_through(words)
        else:
            self.r.straight(self.target(words), motion == "G0", self.turning(words))

    def machine_move(self, words: SinumerikWords) -> None:
        """G53, G153, SUPA: coordinates of the machine for this block, tool offset kept."""
        tip = list(self.r.tip())
        for k, name in enumerate(AXES):
            value = words.take(name)
            if value is not None:
                tip[k] = value * self.r.unit / (2.0 if k == 0 and self.r.diametral() else 1.0)
        self.r.to_machine(point_of(tip), self.r.motion in (None, "G0"))

    def target(self, words: SinumerikWords) -> Point:
        point = list(self.r.p)
        for k, name in enumerate(AXES):
            item = words.items.get(name)
            if item is None:
                continue
            value = (words.take(name) or 0.0) * self.r.unit / (2.0 if k == 0 and self.r.diametral() else 1.0)
            absolute = item.mode == "AC" or (self.r.absolute and item.mode != "IC")
            point[k] = value if absolute else self.r.p[k] + value
        return point_of(point)

    def turning(self, words: SinumerikWords) -> Point | None:
        """Rotary axes, degrees in the program."""
        if not words.has(*ROTARY):
            return None
        angles = list(self.r.rotary)
        for k, name in enumerate(ROTARY):
            item = words.items.get(name)
            if item is not None:
                value = math.radians(words.take(name) or 0.0)
                absolute = item.mode == "AC" or (self.r.absolute and item.mode != "IC")
                angles[k] = value if absolute else angles[k] + value
        return point_of(angles)

    def arc(self, words: SinumerikWords, clockwise: bool) -> None:
        start, named = self.r.p, words.has(*AXES)
        turns = round(words.take("TURN") or 0.0) + 1
        radius, angle = words.take("CR"), words.take("AR")
        given = words.has(*CENTRES)
        centre = self.centre(words)
        end = self.target(words)
        if radius is not None:
            middle = radius_centre(start, end, radius * self.r.unit, clockwise, self.r.plane)
            if middle is None:
                self.r.fault(
                    f"CR={radius:g} fits no arc to this end point, {_chord(start, end, self.r.plane):.4f} mm away; correct CR or the end point (full circles take I J K)"
                )
            centre = middle
        elif angle is not None and given:
            end = self.opened(centre, end, angle, clockwise)
        elif angle is not None:
            centre = self.by_angle(start, end, angle, clockwise)
        elif not given:
            what = "an end point and " if not named else ""
            self.r.fault(f"the arc has {what}no centre; add I J K of the plane {self.r.plane}, CR= or AR=")
        self.r.arc(end, centre, clockwise, turns)

    def centre(self, words: SinumerikWords) -> Point:
        """I J K: from the start point; AC(...) from the work zero."""
        point = list(self.r.p)
        for k, name in enumerate(CENTRES):
            item = words.items.get(name)
            value = (words.take(name) or 0.0) * self.r.unit
            if item is not None:
                point[k] = value if item.mode == "AC" else point[k] + value
        return point_of(point)

    def opened(self, centre: Point, end: Point, angle: float, clockwise: bool) -> Point:
        """End of the arc about a centre with an opening angle, deg."""
        one, two, _ = PLANES[self.r.plane]
        turn = math.radians(-angle if clockwise else angle)
        a, b = self.r.p[one] - centre[one], self.r.p[two] - centre[two]
        point = list(end)
        point[one] = centre[one] + a * math.cos(turn) - b * math.sin(turn)
        point[two] = centre[two] + a * math.sin(turn) + b * math.cos(turn)
        return point_of(point)

    def by_angle(self, start: Point, end: Point, angle: float, clockwise: bool) -> Point:
        """Centre from end point and opening angle: R = chord / (2 sin(angle / 2))."""
        if not 0 < angle < 360:
            self.r.fault("AR= takes an angle between 0 and 360 deg; full circles take I J K")
        radius = _chord(start, end, self.r.plane) / (2 * math.sin(math.radians(angle) / 2))
        centre = radius_centre(start, end, radius if angle <= 180 else -radius, clockwise, self.r.plane)
        if centre is None:
            self.r.fault("an arc given by AR= must end elsewhere than it starts")
        return centre

    def circle_through(self, words: SinumerikWords) -> None:
        """CIP: through the intermediate point I1 J1 K1, absolute with G90, from the start with G91."""
        one, two, normal = PLANES[self.r.plane]
        start, middle = self.r.p, list(self.r.p)
        for k, name in enumerate(("I1", "J1", "K1")):
            item = words.items.get(name)
            if item is not None:
                value = (words.take(name) or 0.0) * self.r.unit
                absolute = item.mode == "AC" or (self.r.absolute and item.mode != "IC")
                middle[k] = value if absolute else start[k] + value
        end = self.target(words)
        if abs(middle[normal] - start[normal]) > 1e-9 or abs(end[normal] - start[normal]) > 1e-9:
            self.r.fault(
                f"CIP out of the plane {self.r.plane} (a circle in space) is not understood; choose G17, G18 or G19 so that the three points lie in it"
            )
        a, b = (
            (middle[one] - start[one], middle[two] - start[two]),
            (end[one] - start[one], end[two] - start[two]),
        )
        twice = 2 * (a[0] * b[1] - a[1] * b[0])
        if abs(twice) < 1e-9:
            self.r.fault("the three points of CIP lie on a line; correct I1= J1= K1= or program G1")
        aa, bb = a[0] ** 2 + a[1] ** 2, b[0] ** 2 + b[1] ** 2
        point = list(start)
        point[one] += (b[1] * aa - a[1] * bb) / twice
        point[two] += (a[0] * bb - b[0] * aa) / twice
        self.r.arc(end, point_of(point), clockwise=twice < 0)

    def corner(self, words: SinumerikWords) -> None:
        """RND= CHF= CHR= at the end of this move."""
        unit = self.r.unit
        for name, kind in (("RND", "round"), ("CHF", "width"), ("CHR", "chamfer")):
            size = words.take(name)
            if size is not None:
                self.r.corner(size * unit, kind)
                return
        if self.modes.rnd:
            self.r.corner(self.modes.rnd, "round")


def _chord(start: Point, end: Point, plane: str) -> float:
    one, two, _ = PLANES[plane]
    return math.hypot(end[one] - start[one], end[two] - start[two])
