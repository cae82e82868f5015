"""G150 of Haas: a pocket of any shape, its contour in a subprogram.

Source: Haas mill operator's manual 96-8000 and gcodes.net, "G150 general purpose pocket milling": X Y where the tool goes in, Z the depth, R the plane, Q the
infeed from there, P the subprogram (block N of this program, else a program), I strokes along Y, I apart, J strokes along X; K stays on the wall until a
last pass at the depth; G41 or G42 with D. The first move of the subprogram leads onto the contour, which ends where that move has ended. At each depth
once round the contour, then the strokes. How it gets from one to the next is the control's own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from vcmm.program.area import Area, Stroke, area
from vcmm.program.contouring import record_contour
from vcmm.program.cutter import CycleCutter
from vcmm.program.cycle_tables import Values, cycle
from vcmm.program.drilling import depths_of
from vcmm.program.faults import BlockFault
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.control import IsoControl
from vcmm.program.iso.flow import ActiveCall
from vcmm.program.iso.lengths import read_words
from vcmm.program.iso.macros import ProgramCall, start_program
from vcmm.program.moves import Move
from vcmm.program.radius import RadiusCompensation

if TYPE_CHECKING:
    from vcmm.program.iso.flow import IsoRunner

Flat = tuple[float, float]
POCKET = cycle("I mm?, J mm?, R mm!, Z mm!, Q mm!, K mm?, X mm?, Y mm?", None)


def mill_pocket(r: IsoRunner, w: IsoWords, here: int, run: Callable[[int], None]) -> None:
    """Execute a block with G150. run: executes one line of the text."""
    c, column = r.c, w.g_columns["irregular"]
    c.column = column
    beside, c.compensation = c.compensation, None
    if beside is None:
        raise BlockFault(
            column, "G150 needs the side of the tool; add G41 or G42 and D, as in G150 G41 D1 ..."
        )
    if (w.whole("L", column, 1) or 1) != 1:
        c.assume(
            "repeats of G150 (L)",
            "once",
            "L of G150 is not understood; write a block for each pocket",
            column=w.column("L"),
        )
    v = _read(c, w, column)
    along, step = (
        (1, v["I"]) if v.has("I") else (0, v["J"])
    )  # axis of the plane along which the strokes go, 0: X
    base = 0.0 if c.absolute else c.p[2]
    plane, depth = v["R"] + base, v["Z"] + base
    if depth >= plane:
        raise BlockFault(column, "G150 needs a depth Z below its plane R; correct them")
    c.assume(
        "how G150 clears", "down where X Y stand, round the contour, then strokes to and fro; up where the way crosses a wall",
        "how G150 gets from one stroke to the next is the control's own affair and not known; write its moves with G1, G2 and G3", column=column,
    )  # fmt: skip
    cutter = CycleCutter(c)
    x, y = (v.without(k, at) if c.absolute else v[k] + at for k, at in zip("XY", c.p))
    start = (x, y)
    c.marker = "G150"
    cutter.to(start, None, True)
    cutter.to(None, plane, True)
    number = w.whole("P", column)
    if number is None:
        raise BlockFault(column, "G150 needs P, the subprogram of its contour")
    moves = _subprogram(r, number, here, column, run)
    if moves is not None:
        path = _closed(moves, column)
        rough = area([(path, beside.side)], beside.radius + v["K"])
        strokes = rough.strokes(step, along)
        _clear(
            cutter,
            (rough, [*strokes[-len(rough.rings) :], *strokes[: -len(rough.rings)]]),
            start,
            depths_of(plane, depth, v["Q"]),
            plane,
        )
        if v["K"]:
            _finish(cutter, path, beside, (depth, plane))
        cutter.to(None, plane, True)
    c.marker = ""


def _read(c: IsoControl, w: IsoWords, column: int) -> Values:
    """Return the words of G150. Raises BlockFault where one is missing, or no length."""
    if w.has("I") == w.has("J"):
        raise BlockFault(
            column, "G150 takes either I (strokes along Y) or J (strokes along X); write one of them"
        )
    for name in POCKET.required_names:
        w.need(name, f"a {'length' if name == 'Q' else 'height'} ({name} of G150)", column)
    v = read_words(c, w, POCKET)
    for letter in "IJQK":
        if v.has(letter) and v[letter] <= 0:
            raise BlockFault(w.column(letter), f"{letter} of G150 is a length above zero; correct it")
    return v


def _subprogram(
    r: IsoRunner, number: int, here: int, column: int, run: Callable[[int], None]
) -> list[Move] | None:
    """Return the moves of the contour in programmed coordinates; they do not change the state. None where the subprogram is
    missing (a remark says so)."""
    c = r.c
    at, under = r.at, len(r.calls)
    with record_contour(c) as contour:
        c.cycle, c.mirrors = dict(c.cycle), dict(c.mirrors)
        index = r.text.number(number, here)
        if index is not None:
            r.push(ActiveCall(r.text, here + 1, "M98", f"N{number}", index, 1), None, column)
            r.enter(r.text, index)
        else:
            start_program(r, ProgramCall("M98", number), here, column)
        is_there = len(r.calls) > under
        while len(r.calls) > under:
            if r.at >= len(r.text.lines) or c.has_ended:
                raise BlockFault(column, f"the subprogram {number} of G150 ends without M99; add it")
            run(r.at)
    r.at = at
    return [m for m in contour.programmed_moves if m.kind in ("rapid", "line", "arc")] if is_there else None


def _closed(moves: Sequence[Move], column: int) -> list[Move]:
    """Return the contour without the move that leads onto it."""
    path = list(moves[1:])
    if len(path) < 2 or any(m.plane != "XY" or m.kind == "rapid" for m in path):
        raise BlockFault(
            column, "the subprogram of G150 makes no contour of G1, G2 and G3 in the plane XY; correct it"
        )
    return path


def _clear(
    cutter: CycleCutter,
    clearing: tuple[Area, list[Stroke]],
    start: Flat,
    depths: Sequence[float],
    plane: float,
) -> None:
    """Mill all strokes at each depth."""
    made, strokes = clearing
    for depth in depths:
        if cutter.here() != start:
            cutter.to(None, plane, True)
            cutter.to(start, None, True)
        cutter.to(None, depth, False)
        for stroke in strokes:
            if not made.is_clear(cutter.here(), stroke.start):
                cutter.to(None, plane, True)
                cutter.to(stroke.start, None, True)
                cutter.to(None, depth, False)
            cutter.to(stroke.start, None, False)
            cutter.follow(stroke.path, depth)


def _finish(cutter: CycleCutter, path: Sequence[Move], beside: RadiusCompensation, heights: Flat) -> None:
    """Mill once along the wall at the depth."""
    depth, plane = heights
    last = area([(path, beside.side)], beside.radius).strokes(0.0)
    for stroke in last:
        cutter.to(None, plane, True)
        cutter.to(stroke.start, None, True)
        cutter.to(None, depth, False)
        cutter.follow(stroke.path, depth)
