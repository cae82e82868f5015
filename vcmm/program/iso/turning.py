"""Turning cycles along a programmed contour: G71 and G72 (roughing), G73 (pattern), G70 (finishing); one block or two.

Source: FANUC Series 30i operator's manual for lathes B-64304EN-1, "multiple repetitive cycle"; Haas lathe operator's manual for
the form in one block. X here is a radius, machine coordinates, mm.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from vcmm.program.contouring import record_contour
from vcmm.program.cycle_tables import Values, cycle
from vcmm.program.faults import BlockFault
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.control import IsoControl
from vcmm.program.iso.grooving import GROOVING, TurningCycle, groove, to_tip
from vcmm.program.iso.lengths import read_words
from vcmm.program.iso.settings import keep_setting, setting_kept, tell_escape
from vcmm.program.moves import Move
from vcmm.program.roughing import MOST_PASSES, Cut, Rough, comes_back, follow_contour, passes

if TYPE_CHECKING:
    from vcmm.program.iso.flow import IsoRunner


def turning(r: IsoRunner, w: IsoWords, here: int, run: Callable[[int], None]) -> None:
    """Execute a block with G70 to G76. run: executes one line of the text."""
    c, code, column = r.c, w.g["turning"], w.g_columns["turning"]
    c.column, c.marker = column, code
    if code in GROOVING:
        groove(c, w, code)
    else:
        _contour_cycle(r, w, code, here, run)
    c.marker = ""


def _contour_cycle(r: IsoRunner, w: IsoWords, code: str, here: int, run: Callable[[int], None]) -> None:
    c, column = r.c, w.g_columns["turning"]
    if not (w.has("P") and w.has("Q")):  # the first of two blocks
        if code == "G70":
            raise BlockFault(
                column, "G70 needs P and Q: the numbers N of the first and the last block of its contour"
            )
        keep_setting(c, code, dict(read_words(c, w, CONTOURED[code].first).numbers))
        return
    first, last = (_line(r, w, k, here, column) for k in "PQ")
    if last < first:
        raise BlockFault(column, f"{code}: the block of Q is before that of P; correct them")
    if code == "G70":
        _finish(r, first, last, run)
        return
    setting, alone = Values(setting_kept(c, code)), any(w.has(k) for k in CONTOURED[code].key)
    v = read_words(c, w, CONTOURED[code].second if setting.numbers and not alone else CONTOURED[code].single)
    depth = 1.0 if code == "G73" else v.without("depth", setting["depth"])
    if depth <= 0:
        raise BlockFault(column, f"{code} has no depth of cut; add {code} U2. R1. before it, or D in it")
    rough = Rough(depth, setting["back"], v["x"] / 2.0, v["z"])
    start, moves = (c.tip()[0], c.tip()[2]), _contour(r, first, last, run)
    if len(moves) < 2:
        raise BlockFault(column, f"{code}: the blocks of P to Q make no contour; correct them")
    if code == "G73":
        _pattern(c, moves, rough, v if alone else setting)
    else:
        if not setting.has("back"):
            tell_escape(c, code)
        order = "XZ" if code == "G71" else "ZX"
        if comes_back(moves, start, order):
            _note_pockets(c, code, order[0])
        to_tip(c, (start[0] + rough.x, start[1] + rough.z), True)
        for cut in passes(moves, start, rough, order, column):
            _cut(c, cut)
    to_tip(c, start, True)
    r.at = max(last, here) + 1  # the contour may stand before its cycle on Okuma controls


def _note_pockets(c: IsoControl, code: str, across: str) -> None:
    """Note pockets of a contour that comes back: type II gives them passes of their own, type I an alarm (FANUC 064)."""
    c.assume(
        f"{code} along a contour that comes back in {across}", "its pockets get no passes of their own, only the last way along the contour",
        f"{code} along a contour that comes back in {across} (type II): how its pockets are cut is the control's own affair; write them with G0 and G1",
        column=c.column,
    )  # fmt: skip


def _line(r: IsoRunner, w: IsoWords, letter: str, here: int, column: int) -> int:
    number = w.whole(letter, column)
    index = None if number is None else r.text.number(number, here)
    if index is None:
        raise BlockFault(w.column(letter), f"{letter}{number}: this program has no block N{number}")
    return index


def _contour(r: IsoRunner, first: int, last: int, run: Callable[[int], None]) -> list[Move]:
    """Return the moves of the blocks first to last, as programmed; they do not change the state."""
    c = r.c
    with record_contour(c) as contour:
        c.cycle, c.mirrors = dict(c.cycle), dict(c.mirrors)
        _run(r, first, last, run)
    return [m for m in contour.moves if m.kind in ("rapid", "line", "arc")]


def _run(r: IsoRunner, first: int, last: int, run: Callable[[int], None]) -> None:
    for index in range(first, last + 1):
        run(index)
        if r.at != index + 1:
            raise BlockFault(1, "jumps and calls inside the blocks of a turning cycle are not understood")


def _finish(r: IsoRunner, first: int, last: int, run: Callable[[int], None]) -> None:
    """Finish by G70: the contour with its own feeds, and back to where it began."""
    c, back = r.c, r.at
    start = (c.tip()[0], c.tip()[2])
    _run(r, first, last, run)
    c.compensation = None
    to_tip(c, start, True)
    r.at = last + 1 if first == back else back  # a contour elsewhere in the text is called like a subprogram


# -- roughing ---------------------------------------------------------------------------------------------------------
def _cut(c: IsoControl, cut: Cut) -> None:
    """Make one move of a cycle, at the feed of the cycle."""
    if cut.centre is None:
        to_tip(c, cut.end, cut.rapid)
        return
    end, centre = (cut.end[0], c.tip()[1], cut.end[1]), (cut.centre[0], c.tip()[1], cut.centre[1])
    feed = c.rate(math.dist(c.tip(), end), c.feeding((c.tip()[0] + end[0]) / 2.0 - c.world.shift[0]))
    c.emit("arc", end, feed=feed, plane="ZX", centre=centre, clockwise=cut.clockwise, turns=cut.turns)
    c.locate()


def _follow(c: IsoControl, moves: list[Move], x: float, z: float) -> None:
    """Follow the contour moved by (x, z)."""
    for cut in follow_contour(moves, x, z):
        _cut(c, cut)


def _pattern(c: IsoControl, moves: list[Move], rough: Rough, v: Values) -> None:
    """Run G73: the whole contour, moved nearer from pass to pass."""
    way_x, way_z = v["way_x"], v["way_z"]
    count = max(1, round(v["count"] or 1.0))
    if count > MOST_PASSES:
        raise BlockFault(c.column, f"more than {MOST_PASSES} passes; correct R")
    for k in range(count):
        share = 0.0 if count == 1 else 1.0 - k / (count - 1)
        x, z = rough.x + way_x * share, rough.z + way_z * share
        to_tip(c, (moves[1].start[0] + x, moves[1].start[2] + z), moves[0].kind == "rapid")
        _follow(c, moves[1:], x, z)
        if k < count - 1:
            to_tip(c, (c.tip()[0] + way_x * share, c.tip()[2] + way_z * share), True)


_ALLOWANCES = "D=depth mm?, U=x mm, W=z mm"
CONTOURED: Mapping[str, TurningCycle] = {  # U and W of the first block, I and K in one, are the way of a pattern
    "G71": TurningCycle(cycle("U=depth mm?, R=back mm?", None), cycle(_ALLOWANCES, None), cycle(_ALLOWANCES, None), "D"),
    "G72": TurningCycle(cycle("W=depth mm?, R=back mm?", None), cycle(_ALLOWANCES, None), cycle(_ALLOWANCES, None), "D"),
    "G73": TurningCycle(cycle("U=way_x mm?, W=way_z mm?, R=count plain?", None), cycle("U=x mm, W=z mm", None), cycle("U=x mm, W=z mm, I=way_x mm, K=way_z mm, D=count plain", None), "IKD"),
}  # fmt: skip
