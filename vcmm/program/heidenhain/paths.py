"""Path functions of Klartext: L C CR CT LP CP CTP CC RND CHF APPR DEP, tools, M functions.

Source: HEIDENHAIN, TNC 640 User's Manual Klartext Programming, "Programming contours".
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from vcmm.program.chords import arc_or_chords
from vcmm.program.heidenhain.approach import APPROACH_WORDS, Approach, ApproachBlock, depart, resolve
from vcmm.program.heidenhain.orienting import by_spatial_angles, retracting, settling
from vcmm.program.heidenhain.technology import KlartextTechnology
from vcmm.program.heidenhain.text import KlartextBlock, KlartextReader
from vcmm.program.heidenhain.words import AXES, ROTARY, KlartextWords, read_words
from vcmm.program.moves import PLANES, Move, Point, point_of
from vcmm.program.offsetting import planar
from vcmm.program.recorder import Sides, radius_centre

POLAR = ("PR", "PA", "IPR", "IPA")


@dataclass(eq=False)
class KlartextPaths(KlartextTechnology):
    """State of the path functions."""

    # -- end points --
    def target(self, words: KlartextWords) -> Point:
        point = list(self.r.p)
        for k, name in enumerate(AXES):
            absolute, relative = words.take(name), words.take(f"I{name}")
            if absolute is not None:
                point[k] = absolute * self.r.unit
                self.moved_axes.add(k)
            if relative is not None:
                point[k] = self.r.p[k] + relative * self.r.unit
        return point_of(point)

    def turning(self, words: KlartextWords) -> Point | None:
        if not words.has(*ROTARY, *(f"I{a}" for a in ROTARY)):
            return None
        if self.spatial is not None:
            by_spatial_angles(self, words, self.spatial)
            return None
        angles = list(self.r.rotary)
        for k, name in enumerate(ROTARY):
            absolute, relative = words.take(name), words.take(f"I{name}")
            if absolute is not None:
                turn = math.radians(absolute)
                if self.shortest:  # M126: the shorter way round, half a turn at most
                    turn = angles[k] + math.remainder(turn - angles[k], 2.0 * math.pi)
                angles[k] = turn
            elif relative is not None:
                angles[k] += math.radians(relative)
        return point_of(angles)

    def polar(self, words: KlartextWords) -> tuple[Point, float]:
        """End point from PR and PA about the pole, and the angle travelled (IPA) in rad, 0 where PA is absolute."""
        self.need_pole()
        first, second, _ = PLANES[self.r.plane]
        a, b = self.r.p[first] - self.pole[first], self.r.p[second] - self.pole[second]
        radius, angle, swept = math.hypot(a, b), math.atan2(b, a), 0.0
        if words.has("PR", "IPR"):
            radius = (
                (words.take("PR") or 0.0) * self.r.unit
                + (radius if words.has("IPR") else 0.0)
                + (words.take("IPR") or 0.0) * self.r.unit
            )
        if words.has("PA"):
            angle = math.radians(words.take("PA") or 0.0)
        elif words.has("IPA"):
            swept = math.radians(words.take("IPA") or 0.0)
            angle += swept
        point = list(self.target(words))
        point[first] = self.pole[first] + radius * math.cos(angle)
        point[second] = self.pole[second] + radius * math.sin(angle)
        return point_of(point), swept

    # -- path functions --
    def straight(self, reader: KlartextReader) -> bool:
        """Execute a line L."""
        words = settling(self, reader)
        if words.away is not None:
            return retracting(self, words)
        rapid = self.technology(words)
        if 91 in words.m or 92 in words.m:
            self.machine_move(words, rapid)
        elif words.has(*AXES, *ROTARY, *(f"I{a}" for a in (*AXES, *ROTARY))):
            turned = self.turning(words)
            self.line(self.target(words), rapid, turned)
            words.has_moved = True
        return self.after(words)

    def short(self, block: KlartextBlock) -> bool:
        """Make a plain line where nothing special is in force: as `straight`, but faster. False: nothing is done."""
        r, line = self.r, block.read()
        if line is None or r.tracer or r.compensation or self.modal_call or self.per_turn or r.unmoved_axes:
            return False
        if line.feed is not None:
            r.feed, r.feed_mode = self.feed_of(line.feed, "F"), "G94"
        point = list(r.p)
        for k, value in line.axes:
            point[k] = value * r.unit
            self.moved_axes.add(k)
        self.line(point_of(point), line.rapid)
        return True

    def line(self, end: Point, rapid: bool, turned: Point | None = None) -> None:
        self.note_line(end)
        self.r.straight(end, rapid, turned)
        self.last_rapid = rapid

    def note_line(self, end: Point) -> None:
        """Remember the direction for tangential arcs."""
        first, second, _ = PLANES[self.r.plane]
        a, b = end[first] - self.r.p[first], end[second] - self.r.p[second]
        length = math.hypot(a, b)
        self.tangent = (a / length, b / length) if length > 1e-9 else self.tangent

    def machine_move(self, words: KlartextWords, rapid: bool) -> None:
        """Move to machine coordinates, M91: positions of the axes; the tool length is not counted. Increments count from the last
        position given with M91,
        where there is none from where the axes are."""
        q, turned = list(self.r.q), self.turning(words)
        for k, name in enumerate(AXES):
            absolute, relative = words.take(name), words.take(f"I{name}")
            if relative is not None:
                q[k] = self.machine.get(k, q[k]) + relative * self.r.unit
            if absolute is not None:
                q[k] = absolute * self.r.unit
            if absolute is not None or relative is not None:
                self.machine[k] = q[k]
        o = self.r.tool_offset
        self.r.to_machine((q[0] - o[0], q[1] - o[1], q[2] - o[2]), rapid, turned)
        self.last_rapid = rapid

    def normal_line(self, reader: KlartextReader) -> bool:
        """Execute LN: a point with the normal of the surface (NX NY NZ) and the direction of the tool (TX TY TZ)."""
        vectors = tuple(f"{v}{a}" for v in "NT" for a in AXES)
        words = read_words(reader, vectors)
        self.r.assume(
            "3-D compensation and tool directions (LN)", "the points as programmed, the tool along TX TY TZ", matters=False,
        )  # fmt: skip
        values = {name: words.take(name) for name in vectors}
        if any(values[f"T{a}"] is not None for a in AXES):
            x, y, z = (values[f"T{a}"] or 0.0 for a in AXES)
            self.r.point_to((x, y, z))
        rapid = self.technology(words)
        if words.has(*AXES, *ROTARY):
            turned = self.turning(words)
            self.line(self.target(words), rapid, turned)
        return self.after(words)

    def spline(self, reader: KlartextReader) -> bool:
        """Execute SPL: the end point and the coefficients K of a spline."""
        words = KlartextWords()
        while reader.upper() in tuple(AXES):
            name = reader.upper()
            reader.at += 1
            words.values[name] = reader.value(name)
        reader.rest()
        self.r.assume(
            "splines (SPL)",
            "straight lines between their points",
            "SPL is not understood; program the points with L",
        )
        self.line(self.target(words), False)
        return False

    def polar_line(self, reader: KlartextReader) -> bool:
        """Execute a polar line LP."""
        words = read_words(reader, POLAR)
        rapid = self.technology(words)
        self.line(self.polar(words)[0], rapid)
        words.has_moved = True
        return self.after(words)

    def circle(self, reader: KlartextReader, name: str) -> bool:
        """Execute an arc: C CR CT CP CTP."""
        words = read_words(reader, POLAR if name in ("CP", "CTP") else ("R",) if name == "CR" else ())
        if self.technology(words):
            self.r.assume(
                "the feed of an arc at FMAX",
                "not known; its time is not counted",
                f"{name} at FMAX is not understood; give it a feed",
            )
            self.r.feed = None
        if words.clockwise is None and name in ("C", "CR", "CP"):
            self.r.fault(f"{name} needs the sense of rotation; add DR+ or DR-")
        clockwise, turns = bool(words.clockwise), 1
        if name == "CR":
            radius = words.take("R")
            end = self.target(words)
            middle = radius_centre(self.r.p, end, (radius or 0.0) * self.r.unit, clockwise, self.r.plane)
            if not radius or middle is None:
                if radius and math.dist(self.r.p, end) < 1e-9:
                    self.r.fault(
                        "CR ends where it starts: a TNC draws no full circle by R; write two CR blocks of half a circle, or CC and C"
                    )
                self.r.fault("CR needs R, and R must reach the end point; correct R or the end point")
            centre = middle
        elif name in ("CT", "CTP"):
            end = self.target(words) if name == "CT" else self.polar(words)[0]
            centre, clockwise = self.tangential(end)
        else:
            end, swept = (self.target(words), 0.0) if name == "C" else self.polar(words)
            self.need_pole()
            centre = point_of(self.pole)
            turns = max(1, math.ceil(abs(swept) / (2 * math.pi) - 1e-9))
        self.round(end, centre, clockwise, turns)
        words.has_moved = True
        return self.after(words)

    def round(self, end: Point, centre: Point, clockwise: bool, turns: int) -> None:
        first, second, _ = PLANES[self.r.plane]
        a, b = end[first] - centre[first], end[second] - centre[second]
        length = math.hypot(a, b) or 1.0
        if self.unfitting(end, centre):
            self.line(end, False)
            return
        arc_or_chords(self.r, end, centre, clockwise, turns)
        self.tangent = (b / length, -a / length) if clockwise else (-b / length, a / length)
        self.last_rapid = False

    def unfitting(self, end: Point, centre: Point) -> bool:
        """Make a line with a remark for an arc that cannot fit because the position of the tool before the program is unknown."""
        first_axis, second, _ = PLANES[self.r.plane]
        if {first_axis, second} <= self.moved_axes or self.r.setup.strict:
            return False
        first, last = (
            math.hypot(p[first_axis] - centre[first_axis], p[second] - centre[second])
            for p in (self.r.p, end)
        )
        if min(first, last) > 1e-9 and abs(first - last) <= max(0.01, 0.001 * first):
            return False
        self.r.assume("the start position, from which an arc is programmed", "the arc is left out")
        return True

    def tangential(self, end: Point) -> tuple[Point, bool]:
        """Return the centre of the arc that leaves along the last direction t: k n with k = |d|^2 / (2 n.d), n left of t."""
        if self.tangent is None:
            self.r.fault("a tangential arc needs a contour element before it; program L or C first")
        first, second, _ = PLANES[self.r.plane]
        d = (end[first] - self.r.p[first], end[second] - self.r.p[second])
        n = (-self.tangent[1], self.tangent[0])
        across = n[0] * d[0] + n[1] * d[1]
        if abs(across) < 1e-9:
            self.r.fault("the end point of the tangential arc lies straight ahead; program L")
        k = (d[0] ** 2 + d[1] ** 2) / (2 * across)
        centre = list(self.r.p)
        centre[first] += k * n[0]
        centre[second] += k * n[1]
        return point_of(centre), k < 0

    def need_pole(self) -> None:
        """Require a pole: C and polar coordinates count from the last CC; where there is none the control stops."""
        if not self.has_pole:
            self.r.assume(
                "the pole (CC)", "the zero in force", "C, LP, CP and CTP need a pole, and there is no CC before; program CC with X and Y"
            )  # fmt: skip

    def set_pole(self, reader: KlartextReader) -> None:
        """Set the pole, CC: coordinates, or the present position where there are none."""
        words = read_words(reader, ())
        self.has_pole = True
        if not words.values:
            self.pole = list(self.r.p)
            return
        for k, name in enumerate(AXES):
            absolute, relative = words.take(name), words.take(f"I{name}")
            if absolute is not None:
                self.pole[k] = absolute * self.r.unit
            if relative is not None:
                self.pole[k] = self.r.p[k] + relative * self.r.unit
        self.leftover(words)

    def corner(self, reader: KlartextReader, kind: str) -> None:
        """Read a corner, RND R5, CHF 5; F acts on the rounding only."""
        words = read_words(reader, ("R",) if kind == "round" else (), bare="R")
        size = words.take("R")
        if size is None or size <= 0:
            self.r.fault("RND takes a radius and CHF a length above zero, as in RND R5 or CHF 2")
        if self.r.moves and self.r.moves[-1].kind == "approach":
            self.r.fault("RND or CHF directly after APPR is not understood; place it after the first element")
        feed = None if words.feed is None else self.feed_of(words.feed, words.feed_kind)
        self.leftover(words)
        self.r.corner(size * self.r.unit, kind, feed)

    # -- approach and departure --
    def approach(self, reader: KlartextReader) -> bool:
        """Execute APPR LT LN CT LCT."""
        kind, polar = self.kind(reader, "APPR")
        before = self.r.feed if self.r.feed_mode == "G94" else None
        words = read_words(reader, ("LEN", "R", "CCA", *(POLAR if polar else ())))
        self.r.free("APPR")
        self.technology(words)
        if self.r.compensation is None:
            self.r.fault("APPR needs the side of the tool; add RL or RR")
        data = self.data(kind, words)
        direct = kind == "LCT"  # PS to PH at the feed of the block
        self.approach_blocks.append(
            ApproachBlock(data, self.last_rapid and not direct, None if direct else before)
        )
        self.r.straight(self.polar(words)[0] if polar else self.target(words), False)
        self.r.moves[-1] = self.r.moves[-1]._replace(
            kind="approach", seconds=float(len(self.approach_blocks) - 1)
        )
        self.tangent, self.last_rapid = None, False
        return self.after(words)

    def kind(self, reader: KlartextReader, what: str) -> tuple[str, bool]:
        """Return the kind LT LN CT LCT, or with P before it, where the point is given by PR and PA."""
        kind = reader.upper()
        base = kind[1:] if kind[:1] == "P" else kind
        if base not in APPROACH_WORDS:
            raise reader.fault(
                f"{what} takes LT, LN, CT or LCT{f', {kind} is not understood' if kind else ''}"
            )
        reader.at += 1
        return base, base != kind

    def data(self, kind: str, words: KlartextWords) -> Approach:
        length, radius, angle = words.take("LEN"), words.take("R"), words.take("CCA")
        if kind in ("LT", "LN") and (length is None or length <= 0):
            self.r.fault(f"{kind} needs LEN above zero, as in LEN10")
        if kind in ("CT", "LCT") and not radius:
            self.r.fault(f"{kind} needs the radius R, as in R10")
        if kind == "CT" and (angle is None or not 0 < angle <= 360):
            self.r.fault("CT needs the angle CCA, above 0 up to 360 deg")
        return Approach(
            kind, (length or 0.0) * self.r.unit, (radius or 0.0) * self.r.unit, math.radians(angle or 0.0)
        )

    def departure(self, reader: KlartextReader) -> bool:
        """Execute DEP LT LN CT LCT; the tool ends without radius compensation."""
        kind, polar = self.kind(reader, "DEP")
        words = read_words(reader, ("LEN", "R", "CCA", *(POLAR if polar else ())))
        last = next(
            ((m, s) for m, s in zip(reversed(self.r.moves), reversed(self.r.sides)) if planar(m)), None
        )
        if last is None or last[1] is None:
            self.r.fault("DEP needs a contour with RL or RR before it")
        words.has_side, words.side = False, None
        self.technology(words)
        data, r = self.data(kind, words), self.r
        goal = self.polar(words)[0] if polar else self.target(words)
        tip = r.world.apply(goal)
        first, second, normal = PLANES[r.plane]
        r.compensation = None
        way_out = depart(
            last[0]._replace(end=r.tip()), last[1], data, (tip[first], tip[second]), (r.file, r.source)
        )
        for start, end, centre, clockwise in way_out:
            rate = r.rate(1.0, r.spindle(start, end))
            kind = "line" if centre is None else "arc"
            r.emit(kind, end, start=start, feed=rate, centre=centre, clockwise=clockwise)
        low = r.tip()
        if abs(tip[normal] - low[normal]) > 1e-12:
            up = list(low)
            up[normal] = tip[normal]
            r.emit("line", point_of(up), feed=r.rate(1.0, r.spindle(low, low)))
        r.refresh()
        self.tangent, self.last_rapid = None, False
        return self.after(words)

    def finish(self, moves: list[Move], sides: Sides) -> tuple[list[Move], Sides]:
        """Insert the approaches, once the elements after them are known."""
        return resolve(moves, sides, self.approach_blocks, self.r.file)
