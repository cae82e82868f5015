"""Motion of a Sinumerik block: end points, arcs in their forms, corners, modal cycles."""

from __future__ import annotations

import math

from vcmm.program.chords import arc_or_chords
from vcmm.program.frames import in_plane
from vcmm.program.leading import name_axes
from vcmm.program.moves import ORIGIN, PLANES, Point
from vcmm.program.offsetting import left_normal, piece_of, planar, tangent
from vcmm.program.probing import touch
from vcmm.program.recorder import radius_centre
from vcmm.program.sinumerik.blocks import Item
from vcmm.program.sinumerik.flow import SinumerikRunner
from vcmm.program.sinumerik.state import AXES, CENTRES, ROTARY, SinumerikControl, SinumerikWords, point_of

MORE = ("CR", "AR", "I1", "J1", "K1", "AP", "RP")  # words that move too
MOVING = (*AXES, *ROTARY, "AP", "RP")


class SinumerikPaths(SinumerikControl):
    """Executes the motion of a block."""

    def motion(self, words: SinumerikWords) -> None:
        self.modal_call(words)
        name_axes(self.r, "".join("XYZ" if n in ("AP", "RP") else n[0] for n in words.items if n in MOVING))
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
        cycle = self.modes.cycle
        if cycle is not None and not self.modes.calling and len(self.r.moves) > before:
            self.modes.calling = True  # motions of a modal subprogram do not call it again
            self.command(words.runner, cycle, 1)
            self.modes.calling = False

    def modal_call(self, words: SinumerikWords) -> None:
        """Execute MCALL CYCLE81(...), MCALL L70: after each motion; MCALL alone ends it."""
        called = next((c for c in words.commands if c.name == "MCALL"), None)
        if called is None:
            return
        words.commands.remove(called)
        rest = (
            [called._replace(name="CALL")] if called.text else [c for c in words.commands if c.name != "SUPA"]
        )
        self.modes.cycle = rest[0] if rest else None
        self.modes.cycle_line = words.block.line
        words.commands[:] = [c for c in words.commands if c not in rest[:1]]

    def command(self, runner: SinumerikRunner, item: Item, times: int = 1) -> None:
        """Call a cycle or a subprogram."""
        raise NotImplementedError

    def interpolate(self, words: SinumerikWords) -> None:
        motion = self.r.motion
        if motion is None:
            motion = "G1" if self.r.feed else "G0"
            if motion == "G0":
                self.r.remark(
                    "no G0 or G1 and no feed has been programmed; the motion is taken as rapid (G0)"
                )
        turned = self.turning(words)
        if words.has("MEAS", "MEAW"):
            self.measure(words, turned)
        elif "G63" in words.g:
            self.r.straight(self.target(words), False, turned)
        elif motion in ("G33", "G331") and not words.by_itself:
            self.thread(words, motion, turned)
        elif motion in ("G2", "G3"):
            self.arc(words, clockwise=motion == "G2")
            self.turn_along(turned)
        elif motion == "CIP":
            self.circle_through(words)
            self.turn_along(turned)
        elif motion == "CT":
            self.tangential(words)
            self.turn_along(turned)
        else:
            self.r.straight(self.target(words), motion == "G0" or words.by_itself, turned)

    def measure(self, words: SinumerikWords, turned: Point | None) -> None:
        """Measure by MEAS=1 (the rest of the way is deleted) and MEAW=1 (it goes on to the end): straight until the probe answers;
        $AA_MM, $AA_MW, $AC_MEA hold where.

         Source: Siemens, Programming Manual Job Planning, "Measuring with touch-trigger probe (MEAS, MEAW)".
        """
        stops, r = words.has("MEAS"), self.r
        number = words.take("MEAS") or words.take("MEAW") or 0.0
        end = self.target(words)
        if not r.setup.surfaces or turned is not None:
            what = f"MEA{'S' if stops else 'W'}={number:g} (measuring)"
            r.assume(
                what, "to its end point",
                f"{what}: where the probe stops is not known; state what it touches in the set-up file, as [stock] with box or [[surfaces]]",
            )  # fmt: skip
            r.straight(end, False, turned)
            return
        words.runner.memory.has_contact = touch(r, end, r.tool_data, stops=stops)
        if not words.runner.memory.has_contact:
            r.remark(
                f"MEA{'S' if stops else 'W'}={number:g} meets no surface that the set-up states and goes to its end point",
                every=True,
            )

    def turn_along(self, turned: Point | None) -> None:
        """Turn rotary axes that go along with an arc."""
        if turned is not None:
            self.r.moves[-1] = self.r.moves[-1]._replace(rotary_end=turned)
            self.r.rotary = turned

    def thread(self, words: SinumerikWords, motion: str, turned: Point | None) -> None:
        """Cut a thread, G33: a line of I, J or K mm per turn; G331, G332: tapping with the spindle as an axis, at K times its speed."""
        leads = [abs(v) for v in (words.take(c) for c in CENTRES) if v is not None]
        lead = max(leads) * self.r.unit if leads else 0.0
        target = self.target(words)
        r = self.r
        start, end = r.tip(), r.world.apply(target)
        turns = abs(r.spindle(start, end)) or (r.speed if motion == "G331" else 0.0)
        if not lead or not turns:
            r.assume(
                "the speed of a thread", "not known; its time is not counted",
                "G33 (thread cutting or tapping) needs a lead I, J or K and a turning spindle; add them", matters=False,
            )  # fmt: skip
        r.emit("thread" if motion == "G33" else "line", end, rotary=turned, feed=lead * turns or None)
        r.p = target

    def tangential(self, words: SinumerikWords) -> None:
        """Make an arc, CT: the arc that leaves along the direction of the last move; centre at k n with k = |d|^2 / (2 n.d), n left of it."""
        r = self.r
        first, second, _ = PLANES[r.plane]
        last = next((m for m in reversed(r.moves) if planar(m)), None)
        target = self.target(words)
        if last is None or last.plane != r.plane:
            r.fault("a tangential arc (CT) needs a move in its plane before it; program G1 first")
        piece = piece_of(last)
        n, tip, end = left_normal(tangent(piece, piece.end)), r.tip(), r.world.apply(target)
        d = (end[first] - tip[first], end[second] - tip[second])
        across = n[0] * d[0] + n[1] * d[1]
        if abs(across) < 1e-9:
            r.straight(target, False)
            return
        k = (d[0] ** 2 + d[1] ** 2) / (2.0 * across)
        centre = list(tip)
        centre[first], centre[second] = tip[first] + k * n[0], tip[second] + k * n[1]
        plane_map = in_plane(r.world, r.plane)
        arc_or_chords(
            r, target, r.world.undo(point_of(centre)), (k < 0) != (plane_map is not None and plane_map[1])
        )

    def machine_move(self, words: SinumerikWords) -> None:
        """Move by G53, G153, SUPA: coordinates of the machine for this block, tool offset kept."""
        tip, shift = list(self.r.tip()), self.modes.turns
        self.modes.turns = ORIGIN
        turned = self.turning(words)
        self.modes.turns = shift
        for k, name in enumerate(AXES):
            value = words.take(name)
            if value is not None:
                tip[k] = value * self.r.unit / (2.0 if k == 0 and self.r.diametral() else 1.0)
        self.r.to_machine(point_of(tip), self.r.motion in (None, "G0") or words.by_itself, turned)

    def target(self, words: SinumerikWords) -> Point:
        point, axes = list(self.r.p), set()
        for k, name in enumerate(AXES):
            item = words.items.get(name)
            if item is None:
                continue
            axes.add(k)
            absolute = item.mode == "AC" or (self.r.absolute and item.mode != "IC")
            value = (
                (words.take(name) or 0.0) * self.r.unit / (2.0 if k == 0 and self.halves(absolute) else 1.0)
            )
            point[k] = value if absolute else self.r.p[k] + value
        if words.has("ANG"):
            self.incline(words, point, axes)
        return self.polar(words, point) if words.has("AP", "RP") else point_of(point)

    def halves(self, absolute: bool) -> bool:
        """Return whether a word of X is a diameter: with DIAMON always, with DIAM90 where it counts from the work zero."""
        return self.r.diameter == "always" or (self.r.diameter == "absolute" and absolute)

    def incline(self, words: SinumerikWords, point: list[float], axes: set[int]) -> None:
        """Incline by ANG=: the angle of a line with the first axis, deg; one coordinate of its end point gives the other."""
        first, second, _ = PLANES[self.r.plane]
        angle = math.radians(words.take("ANG") or 0.0)
        along, across = math.cos(angle), math.sin(angle)
        if first in axes and second not in axes and abs(along) > 1e-9:
            point[second] = self.r.p[second] + (point[first] - self.r.p[first]) * across / along
        elif second in axes and first not in axes and abs(across) > 1e-9:
            point[first] = self.r.p[first] + (point[second] - self.r.p[second]) * along / across
        elif not {first, second} <= axes:
            self.r.assume(
                "ANG= without one coordinate of the end point", "the unchanged end point",
                "ANG= without one coordinate of the end point is not understood; program both coordinates",
            )  # fmt: skip

    def polar(self, words: SinumerikWords, point: list[float]) -> Point:
        """Return the point of AP= RP=: angle (deg) and radius about the pole of G110 to G112; what is missing stays as it is."""
        first, second, _ = PLANES[self.r.plane]
        a, b = self.r.p[first] - self.modes.pole[first], self.r.p[second] - self.modes.pole[second]
        item = words.items.get("AP")
        angle, radius = words.take("AP"), words.take("RP")
        now = math.atan2(b, a)
        turn = (
            now
            if angle is None
            else math.radians(angle) + (now if item is not None and item.mode == "IC" else 0.0)
        )
        size = math.hypot(a, b) if radius is None else radius * self.r.unit
        point[first] = self.modes.pole[first] + size * math.cos(turn)
        point[second] = self.modes.pole[second] + size * math.sin(turn)
        return point_of(point)

    def set_pole(self, words: SinumerikWords) -> None:
        """Set the pole of G110 from where the tool is, G111 from the work zero, G112 from the pole: X Y Z, or AP= RP=."""
        base = self.r.p if "G110" in words.g else self.modes.pole if "G112" in words.g else ORIGIN
        if words.has("AP", "RP"):
            first, second, _ = PLANES[self.r.plane]
            turn, size = math.radians(words.take("AP") or 0.0), (words.take("RP") or 0.0) * self.r.unit
            point = list(base)
            point[first], point[second] = (
                base[first] + size * math.cos(turn),
                base[second] + size * math.sin(turn),
            )
        else:
            point = [base[k] + (words.take(name) or 0.0) * self.r.unit for k, name in enumerate(AXES)]
        self.modes.pole = point_of(point)

    def turning(self, words: SinumerikWords) -> Point | None:
        """Return the rotary axes, degrees in the program."""
        if not words.has(*ROTARY):
            return None
        angles = list(self.r.rotary)
        for k, name in enumerate(ROTARY):
            item = words.items.get(name)
            if item is None:
                continue
            value, now = math.radians(words.take(name) or 0.0), angles[k]
            absolute = item.mode in ("AC", "DC", "ACP", "ACN") or (self.r.absolute and item.mode != "IC")
            goal = value + self.modes.turns[k] if absolute else now + value
            if item.mode == "DC":  # the shorter way round
                goal = now + math.remainder(goal - now, 2.0 * math.pi)
            elif item.mode in ("ACP", "ACN"):  # in positive, in negative direction
                sign = 1.0 if item.mode == "ACP" else -1.0
                goal = now + sign * ((sign * (goal - now)) % (2.0 * math.pi))
            angles[k] = goal
        return point_of(angles)

    def arc(self, words: SinumerikWords, clockwise: bool) -> None:
        start, named, about = self.r.p, words.has(*AXES, "AP"), words.has("AP")
        turns = round(words.take("TURN") or 0.0) + 1
        radius, angle = words.take("CR"), words.take("AR")
        has_centre = words.has(*CENTRES)
        centre = self.centre(words)
        end = self.target(words)
        if radius is not None:
            middle = radius_centre(start, end, radius * self.r.unit, clockwise, self.r.plane)
            if middle is None:
                self.r.fault(
                    f"CR={radius:g} fits no arc to this end point, {_chord(start, end, self.r.plane):.4f} mm away; correct CR or the end point (full circles take I J K)"
                )
            centre = middle
        elif angle is not None and has_centre:
            end = self.arc_end(centre, end, angle, clockwise)
        elif angle is not None:
            centre = self.by_angle(start, end, angle, clockwise)
        elif about and not has_centre:
            centre = self.modes.pole
        elif not has_centre:
            what = "an end point and " if not named else ""
            self.r.fault(f"the arc has {what}no centre; add I J K of the plane {self.r.plane}, CR= or AR=")
        arc_or_chords(self.r, end, centre, clockwise, turns)

    def centre(self, words: SinumerikWords) -> Point:
        """Return the centre from I J K: from the start point, of X a radius; AC(...) from the work zero, a diameter with DIAMON and DIAM90.

        Source: Siemens, Programming Manual Fundamentals, "Channel-specific diameter/radius programming (DIAMON, DIAM90)".
        """
        point = list(self.r.p)
        for k, name in enumerate(CENTRES):
            item = words.items.get(name)
            value = (words.take(name) or 0.0) * self.r.unit
            if item is not None and item.mode == "AC":
                point[k] = value / (2.0 if k == 0 and self.r.diameter else 1.0)
            elif item is not None:
                point[k] += value
        return point_of(point)

    def arc_end(self, centre: Point, end: Point, angle: float, clockwise: bool) -> Point:
        """End of the arc about a centre with an opening angle, deg."""
        first, second, _ = PLANES[self.r.plane]
        turn = math.radians(-angle if clockwise else angle)
        a, b = self.r.p[first] - centre[first], self.r.p[second] - centre[second]
        point = list(end)
        point[first] = centre[first] + a * math.cos(turn) - b * math.sin(turn)
        point[second] = centre[second] + a * math.sin(turn) + b * math.cos(turn)
        return point_of(point)

    def by_angle(self, start: Point, end: Point, angle: float, clockwise: bool) -> Point:
        """Return the centre from end point and opening angle: R = chord / (2 sin(angle / 2))."""
        if not 0 < angle < 360:
            self.r.fault("AR= takes an angle between 0 and 360 deg; full circles take I J K")
        radius = _chord(start, end, self.r.plane) / (2 * math.sin(math.radians(angle) / 2))
        centre = radius_centre(start, end, radius if angle <= 180 else -radius, clockwise, self.r.plane)
        if centre is None:
            self.r.fault("an arc given by AR= must end elsewhere than it starts")
        return centre

    def circle_through(self, words: SinumerikWords) -> None:
        """Make an arc, CIP: through the intermediate point I1 J1 K1, absolute with G90 (of X a diameter with DIAMON), from the start with
        G91, a radius."""
        first, second, normal = PLANES[self.r.plane]
        start, middle = self.r.p, list(self.r.p)
        for k, name in enumerate(("I1", "J1", "K1")):
            item = words.items.get(name)
            if item is not None:
                value = (words.take(name) or 0.0) * self.r.unit
                absolute = item.mode == "AC" or (self.r.absolute and item.mode != "IC")
                half = 2.0 if k == 0 and absolute and self.r.diameter else 1.0
                middle[k] = value / half if absolute else start[k] + value
        end = self.target(words)
        if abs(middle[normal] - start[normal]) > 1e-9 or abs(end[normal] - start[normal]) > 1e-9:
            self.r.fault(
                f"CIP out of the plane {self.r.plane} (a circle in space) is not understood; choose G17, G18 or G19 so that the three points lie in it"
            )
        a, b = (
            (middle[first] - start[first], middle[second] - start[second]),
            (end[first] - start[first], end[second] - start[second]),
        )
        twice = 2 * (a[0] * b[1] - a[1] * b[0])
        if abs(twice) < 1e-9:
            self.r.fault("the three points of CIP lie on a line; correct I1= J1= K1= or program G1")
        aa, bb = a[0] ** 2 + a[1] ** 2, b[0] ** 2 + b[1] ** 2
        point = list(start)
        point[first] += (b[1] * aa - a[1] * bb) / twice
        point[second] += (a[0] * bb - b[0] * aa) / twice
        arc_or_chords(self.r, end, point_of(point), twice < 0)

    def corner(self, words: SinumerikWords) -> None:
        """Read the corner RND= CHF= CHR= at the end of this move."""
        unit = self.r.unit
        for name, kind in (("RND", "round"), ("CHF", "width"), ("CHR", "chamfer")):
            size = words.take(name)
            if size is not None:
                self.r.corner(size * unit, kind)
                return
        if self.modes.rnd:
            self.r.corner(self.modes.rnd, "round")
            self.r.corners[-1] = self.r.corners[-1]._replace(modal=True)


def _chord(start: Point, end: Point, plane: str) -> float:
    first, second, _ = PLANES[plane]
    return math.hypot(end[first] - start[first], end[second] - start[second])
