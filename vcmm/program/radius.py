"""Cutter radius compensation as geometry: from the programmed contour to the path of the tool centre.

Reference for the rules: LinuxCNC, "Tool Compensation" (entry moves, arcs around outside corners, gouging refused).
The controls differ at the first and last move and at outside corners, hence Style:

    entry "linuxcnc"       the entry line is a contour line: its end lies beside its own end, corners as anywhere
    entry "perpendicular"  straight to the point beside the start of the next block (Fanuc type A, Sinumerik NORM,
                           Heidenhain L .. RL)
    entry "along"          Fanuc type B: like "linuxcnc" at an outside corner, "perpendicular" at an inside one; at the end too
    corner "arc"           outside corners: arc about the programmed corner (LinuxCNC, Sinumerik G450, Heidenhain)
    corner "lines"         outside corners: the tangents run on to their intersection, with one line across where the
                           direction changes by more than 90 deg (Fanuc without CCC)

Only neighbouring blocks are looked at, as LinuxCNC and Sinumerik without CDON do: a bottleneck narrower than the tool
between blocks that are not neighbours is cut, on the machine and here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, NoReturn

from vcmm.core.errors import UsageError, choose_from
from vcmm.program.faults import refuse
from vcmm.program.moves import ORIGIN, PLANES, Move, Point, minus, plus
from vcmm.program.offsetting import (
    ContourPiece,
    Joint,
    NoMeeting,
    Vec,
    corner,
    in_space,
    is_inside,
    parallel_point,
    parallel_radius,
    piece_of,
    planar,
    trimmed_sweep,
)

ENTRIES = ("linuxcnc", "perpendicular", "along")
CORNERS = ("arc", "lines")


@dataclass(frozen=True)
class Style:
    """Rules of a control for entering and leaving the contour and for outside corners."""

    entry: str = "linuxcnc"
    corner: str = "arc"

    def __post_init__(self) -> None:
        for word, allowed in ((self.entry, ENTRIES), (self.corner, CORNERS)):
            if word not in allowed:
                raise UsageError(
                    f'There is no style of radius compensation "{word}".{choose_from(word, allowed)}'
                )


LINUXCNC = Style()
FANUC_B = Style("along", "lines")
SINUMERIK = HEIDENHAIN = Style("perpendicular", "arc")


class RadiusCompensation(NamedTuple):
    """Radius compensation in force: side "left" or "right", radius in mm (a negative one changes the side), how the control takes
    it; nose (mm): from the centre to the controlled point of a turning tool set at its imaginary nose, else zero."""

    side: str
    radius: float
    style: Style = LINUXCNC
    nose: Point = ORIGIN


def centre_path(
    moves: Sequence[Move], sides: Sequence[RadiusCompensation | None], file: str = ""
) -> list[Move]:
    """Return the path of the tool centre (mm) for the programmed contour, with `compensation` set on compensated moves.

    sides[i]: in force during move i, None where there is none. Moves without motion in the plane (along its normal, dwells) are
    carried along at the centre point reached. Corner moves take the source, feed and state of the move after the corner.
    Approaches and departures that are programmed for the centre itself (APPR CT and its like) are moves without
    compensation that end beside the start of the contour or start beside its end.
    Raises ProgramLimit with the line for an inside corner or arc that the tool cannot reach, a lead-in not longer than the
    radius, and what may not be done while compensation is on.
    """
    if len(moves) != len(sides):
        raise UsageError(f"{len(moves)} moves need as many sides, got {len(sides)}.")
    walker = _Walker(LINUXCNC, file)
    i = 0
    while i < len(moves):
        run = _run_from(sides, i)
        if not run:
            walker.plain(moves[i])
            i += 1
            continue
        walker.style = run[0].style  # in force until after its exit
        last = i + len(run)
        walker.run(moves[i:last], run, _next_planar(moves, last))
        i = last
    return walker.path


def _run_from(sides: Sequence[RadiusCompensation | None], i: int) -> list[RadiusCompensation]:
    """Return the stretch with compensation on that begins at move i; empty where it is off."""
    run: list[RadiusCompensation] = []
    while i < len(sides) and (side := sides[i]) is not None:
        run.append(side)
        i += 1
    return run


class _Walker:
    """The path so far. `off` holds the distance of the tool from the programmed point after a compensated run."""

    def __init__(self, style: Style, file: str) -> None:
        self.style, self.file = style, file
        self.path: list[Move] = []
        self.off: Point = (0.0, 0.0, 0.0)

    def plain(self, move: Move) -> None:
        """Take a move without compensation. The offset left over from a run ends with the first move (in the plane; LinuxCNC: any)."""
        if self.off == (0.0, 0.0, 0.0):
            self.path.append(move)
            return
        start = self.standing(move)
        if self.path and _near(move.start, self.path[-1].end):  # the exit was written for the centre itself
            self.off = (0.0, 0.0, 0.0)
            self.path.append(move)
            return
        if move.kind == "arc":
            self.refuse(
                move,
                "the first move after compensation is cancelled must be a straight line",
                "add a G1 or G0 line in the plane after G40",
            )
        ends = move.kind != "dwell" if self.style.entry == "linuxcnc" else planar(move)
        off = (0.0, 0.0, 0.0) if ends else self.off
        end = tuple(e + o for e, o in zip(move.end, off))
        self.off = off
        self.path.append(move._replace(start=start, end=(end[0], end[1], end[2])))

    def standing(self, move: Move) -> Point:
        """Return the true position of the controlled point before a move; exactly at the end of the path, unless the tool has changed."""
        start = plus(move.start, self.off)
        return self.path[-1].end if self.path and _near(start, self.path[-1].end) else start

    def run(self, moves: Sequence[Move], sides: Sequence[RadiusCompensation], leaving: Move | None) -> None:
        """Take one stretch with compensation on; leaving: the first move in the plane behind it."""
        if self.off == ORIGIN and all(s.radius == 0.0 and s.nose == ORIGIN for s in sides):
            self.path += [m._replace(compensation=s.side) for m, s in zip(moves, sides)]
            return
        self.check_run(moves, sides)
        side, radius, shift = sides[0].side, sides[0].radius, sides[0].nose
        h = radius if side == "left" else -radius
        here = minus(self.standing(moves[0]), shift)
        flat = [k for k, m in enumerate(moves) if planar(m)]
        pieces = [piece_of(moves[k]) for k in flat]
        engaged = bool(pieces) and self.is_engaged(moves[flat[0]], pieces[0], h)
        if engaged:
            here = minus(self.path[-1].end, shift)
        elif pieces:
            pieces[0] = self.entry_piece(moves[flat[0]], pieces[0], here, h)
        joints = [
            self.joint(moves[b], pieces[n], pieces[n + 1], h, first=n == 0 and not engaged)
            for n, b in enumerate(flat[1:])
        ]
        exit_joint = self.exit_joint(pieces, h, leaving)
        ends = [j.end for j in joints] + ([exit_joint.end] if pieces else [])
        maker = _Maker(self, here, shift, side)
        number = -1
        for move in moves:
            if not planar(move):
                maker.carry(move)
                continue
            number += 1
            if number > 0:
                maker.round(joints[number - 1], move, h)
            maker.offset(move, pieces[number], h, ends[number], entry=number == 0 and not engaged)
        if pieces and (exit_joint.via or exit_joint.start != exit_joint.end):
            maker.round(exit_joint, leaving or moves[-1], h)
        if self.path:
            self.off = minus(self.path[-1].end, moves[-1].end)

    def check_run(self, moves: Sequence[Move], sides: Sequence[RadiusCompensation]) -> None:
        first = sides[0]
        for move, now in zip(moves, sides):
            if now.side not in ("left", "right"):
                raise UsageError(f'The side of radius compensation is "left" or "right", not "{now.side}".')
            fix = "cancel with G40 (R0) first, then switch it on again"
            if (now.side, now.radius) != (first.side, first.radius):
                what = "side" if now.side != first.side else "radius of the tool"
                self.refuse(move, f"the {what} changes while radius compensation is on", fix)
            if move.plane != moves[0].plane:
                self.refuse(
                    move,
                    f"the plane changes from {moves[0].plane} to {move.plane} while radius compensation is on",
                    fix,
                )
            if move.kind == "thread":
                self.refuse(move, "thread cutting while radius compensation is on", fix)
            if not move.rewritable:
                self.refuse(move, "a move in machine coordinates while radius compensation is on", fix)

    def is_engaged(self, move: Move, piece: ContourPiece, h: float) -> bool:
        """Return True where the path already ends beside the start of the contour: an approach written for the centre itself."""
        if not self.path or _near(self.path[-1].end, move.start):
            return False
        first, second, _ = PLANES[move.plane]
        end = self.path[-1].end
        return math.dist((end[first], end[second]), parallel_point(piece, piece.start, h)) < 1e-9

    def entry_piece(self, move: Move, piece: ContourPiece, here: Point, h: float) -> ContourPiece:
        """Return the entry from the true position of the tool, as a piece that ends on the contour."""
        first, second, _ = PLANES[move.plane]
        start = (here[first], here[second])
        if piece.centre is not None:
            fix = "begin with a straight line, G0 or G1, in the plane"
            self.refuse(move, "radius compensation begins with an arc", fix)
        if math.dist(start, piece.end) <= abs(h):
            self.refuse(
                move,
                f"the lead-in of {math.dist(start, piece.end):.6g} mm is not longer than the radius of the tool, {abs(h):.6g} mm",
                "start further away or use a smaller tool",
            )
        return piece._replace(start=start)

    def joint(self, move: Move, a: ContourPiece, b: ContourPiece, h: float, first: bool) -> Joint:
        for piece in (a, b):
            self.check_arc(move, piece, h)
        inside = is_inside(a, b, h)
        if first and (self.style.entry == "perpendicular" or (self.style.entry == "along" and inside)):
            point = parallel_point(b, b.start, h)
            return Joint(point, point)
        try:
            return corner(a, b, h, self.style.corner)
        except NoMeeting:
            self.gouge(move, h)

    def check_arc(self, move: Move, piece: ContourPiece, h: float) -> None:
        if piece.centre is not None and parallel_radius(piece, h) < 1e-9:
            self.refuse(
                move,
                f"an inside arc of radius {math.dist(piece.start, piece.centre):.6g} mm is not wider than the tool radius, {abs(h):.6g} mm",
                "use a smaller tool or a bigger arc",
            )

    def exit_joint(self, pieces: list[ContourPiece], h: float, leaving: Move | None) -> Joint:
        """Return the end of the last compensated move: beside its end, or for type B around an outside corner to the exit line."""
        if not pieces:
            return Joint((0.0, 0.0), (0.0, 0.0))
        last = pieces[-1]
        point = parallel_point(last, last.end, h)
        if self.style.entry == "along" and leaving is not None and leaving.kind != "arc":
            out = piece_of(leaving)
            if not is_inside(last, out, h):
                return corner(last, out, h, self.style.corner)
        return Joint(point, point)

    def feed_for(self, following: Move) -> float | None:
        """Return the feed of a corner move: that of the move after it, for a rapid the last one before."""
        if following.feed is not None:
            return following.feed
        return next((m.feed for m in reversed(self.path) if m.feed is not None), None)

    def gouge(self, move: Move, h: float) -> NoReturn:
        self.refuse(
            move,
            f"the tool of radius {abs(h):.6g} mm cannot reach the inside corner or the block before this one without gouging",
            "use a smaller tool or longer blocks",
        )

    def refuse(self, move: Move, what: str, fix: str) -> NoReturn:
        refuse(self.file, move.source, what, fix)


class _Maker:
    """Writes the moves of one run. `here` is where the centre stands."""

    def __init__(self, walker: _Walker, here: Point, shift: Point, side: str) -> None:
        self.walker, self.here, self.shift, self.side = walker, here, shift, side

    def put(self, move: Move, end: Point, centre: Point | None = None) -> None:
        centre = None if centre is None else plus(centre, self.shift)
        moved = move._replace(
            start=plus(self.here, self.shift),
            end=plus(end, self.shift),
            centre=centre,
            compensation=self.side,
        )
        self.walker.path.append(moved)
        self.here = end

    def carry(self, move: Move) -> None:
        """Carry a dwell or a move along the normal: the plane coordinates stay."""
        normal = PLANES[move.plane][2]
        end = tuple(move.end[k] - self.shift[k] if k == normal else self.here[k] for k in range(3))
        self.put(move, (end[0], end[1], end[2]))

    def offset(self, move: Move, piece: ContourPiece, h: float, end: Vec, entry: bool) -> None:
        """Take the parallel curve of one programmed move, up to its joint with the next."""
        first, second, normal = PLANES[move.plane]
        start = (self.here[first], self.here[second])
        target = in_space(move.plane, end, move.end[normal] - self.shift[normal])
        if piece.centre is None:
            ahead = (end[0] - start[0]) * (piece.end[0] - piece.start[0]) + (end[1] - start[1]) * (
                piece.end[1] - piece.start[1]
            )
            if ahead < -1e-9 and (not entry or self.walker.style.entry == "linuxcnc"):
                self.walker.gouge(move, h)
            self.put(move, target)
            return
        self.walker.check_arc(move, piece, h)
        sweep = trimmed_sweep(piece, start, end)
        if sweep * piece.sweep <= 0:
            self.walker.gouge(move, h)
        turns = max(1, math.ceil(abs(sweep) / (2 * math.pi) - 1e-9))
        self.put(move._replace(turns=turns), target, in_space(move.plane, piece.centre, self.here[normal]))

    def round(self, joint: Joint, following: Move, h: float) -> None:
        """Make the extra moves at an outside corner, at the height reached."""
        height = self.here[PLANES[following.plane][2]]
        state = following._replace(
            rotary_end=following.rotary_start, feed=self.walker.feed_for(following),
            turns=1, clockwise=None, centre=None, seconds=0.0, exact_stop=False,
        )  # fmt: skip
        if joint.pivot is not None:
            if state.feed is None:
                self.walker.refuse(
                    following,
                    "the arc around the corner has no feed",
                    "program F before the compensated contour",
                )
            arc = state._replace(
                kind="arc", clockwise=h > 0
            )  # around an outside corner against the side of the tool
            self.put(
                arc,
                in_space(following.plane, joint.start, height),
                in_space(following.plane, joint.pivot, height),
            )
            return
        points = [*joint.via, *((joint.start,) if joint.start != (joint.via or (joint.end,))[-1] else ())]
        kind = "rapid" if following.kind == "rapid" else "line"
        for point in points:
            self.put(
                state._replace(kind=kind, feed=following.feed if kind == "rapid" else state.feed),
                in_space(following.plane, point, height),
            )


def _next_planar(moves: Sequence[Move], at: int) -> Move | None:
    """Return the first move in its plane from number `at` on."""
    return next((moves[k] for k in range(at, len(moves)) if planar(moves[k])), None)


def _near(a: Point, b: Point) -> bool:
    return math.dist(a, b) < 1e-9
