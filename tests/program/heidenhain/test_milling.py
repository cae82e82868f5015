"""Pockets, slots, faces: where the centre of the tool goes. Sizes less the radius of the tool, 5 mm.

Cycle 262, by the rules of the manual.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.program.heidenhain.klartext import SETUP, moves
from tests.program.pencil import SETUP as PENCIL_SETUP
from tests.program.pencil import check
from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret

SURVEY = replace(SETUP, strict=False)
HEAD = "TOOL CALL 5 Z S1000\n"
Q = " ~\n Q200=2 ~\n Q201=-6 ~\n Q202=4 ~\n Q203=+0 ~\n Q204=20 ~\n Q206=100 ~\n Q207=500\nL X+50 Y+40 Z+30 FMAX M99"


def feeds(text: str):
    return [m for m in moves(HEAD + text, setup=SURVEY) if m.kind in ("line", "arc")]


def box(made) -> list[tuple[float, float]]:
    points = np.array([m.end for m in made])
    return list(zip(points.min(axis=0), points.max(axis=0)))


def test_rectangular_pocket():
    """60 x 40, centre 50, 40: the tool comes to 50 +- 25 and 40 +- 15, at -4 and -6, rows 5 mm apart: 3 rings."""
    made = feeds(f"CYCL DEF 251 ~\n Q218=60 ~\n Q219=40 ~\n Q220=8{Q}")
    assert box(made) == [(25, 75), (25, 55), (-6, -4)]
    rings = {round(abs(m.end[1] - 40), 6) for m in made if m.kind == "line"}
    assert {5.0, 10.0, 15.0} <= rings
    corners = {round(math.dist(m.centre[:2], m.end[:2]), 6) for m in made if m.kind == "arc"}
    assert corners == {3.0}  # 8 - 5
    assert {m.feed for m in made} == {100, 500}


def test_circular_pocket():
    """Diameter 40: circles of 7.5 and 15 mm (two of at most 10 mm with Q370 = 2), counterclockwise: climb milling inside."""
    made = feeds(f"CYCL DEF 252 ~\n Q223=40 ~\n Q370=2{Q}")
    arcs = [m for m in made if m.kind == "arc"]
    assert [round(math.dist(m.end[:2], (50, 40)), 6) for m in arcs] == [7.5, 15, 7.5, 15]
    assert not any(m.clockwise for m in arcs)


def test_slot_lies_along_its_angle():
    made = feeds(f"CYCL DEF 253 ~\n Q218=50 ~\n Q219=10 ~\n Q374=+90{Q}")
    assert np.allclose(box(made), [(50, 50), (20, 60), (-6, -4)])


def test_old_pockets_count_from_where_the_tool_stands():
    old = "CYCL DEF 4.0 POCKET\nCYCL DEF 4.1 DIST2\nCYCL DEF 4.2 DEPTH-5\nCYCL DEF 4.3 PECKG5 F80\nCYCL DEF 4.4 X80\nCYCL DEF 4.5 Y40\n"
    made = feeds(f"{old}CYCL DEF 4.6 F100 DR+ RADIUS5\nL X+60 Y+35 Z+2 FMAX M99")
    assert box(made) == [(25, 95), (20, 50), (-5, -5)]
    assert made[0].feed == 80
    assert made[-1].feed == 100
    circle = "CYCL DEF 5.0 CIRC\nCYCL DEF 5.1 DIST2\nCYCL DEF 5.2 DEPTH-5\nCYCL DEF 5.3 PECKG5 F80\nCYCL DEF 5.4 RADIUS15\nCYCL DEF 5.5 F100 DR-\n"
    arcs = [m for m in feeds(f"{circle}L X+0 Y+0 Z+2 FMAX M99") if m.kind == "arc"]
    assert [(round(m.end[0], 6), m.clockwise) for m in arcs] == [(5, True), (10, True)]
    slot = "CYCL DEF 3.0 SLOT\nCYCL DEF 3.1 DIST2\nCYCL DEF 3.2 DEPTH-5\nCYCL DEF 3.3 PECKG5 F80\nCYCL DEF 3.4 X-50\nCYCL DEF 3.5 Y10\n"
    assert box(feeds(f"{slot}CYCL DEF 3.6 F100\nL X+45 Y+0 Z+2 FMAX M99"))[0] == (5, 45)  # 50 less a diameter


def test_rows_over_a_face():
    made = feeds(
        "CYCL DEF 230 ~\n Q225=+10 ~\n Q226=+12 ~\n Q227=+2 ~\n Q218=100 ~\n Q219=20 ~\n Q240=3 ~\n Q206=150 ~\n Q207=500 ~\n Q209=200 ~\n"
        " Q200=2\nL Z+50 FMAX M99"
    )
    assert [m.end[:2] for m in made] == [(10, 12), (110, 12), (110, 22), (10, 22), (10, 32), (110, 32)]
    assert [m.feed for m in made] == [150, 500, 200, 500, 200, 500]
    face = feeds(
        "CYCL DEF 232 ~\n Q389=2 ~\n Q225=+0 ~\n Q226=+0 ~\n Q227=+2 ~\n Q386=-1 ~\n Q218=50 ~\n Q219=20 ~\n Q202=2 ~\n Q207=500 ~\n Q253=750 ~\n"
        " Q357=2 ~\n Q200=2\nL Z+50 FMAX M99"
    )
    assert box(face) == [(-7, 57), (0, 20), (-1, 0)]  # two levels; 5 + 2 mm beside the face


def test_what_is_assumed_is_refused_in_strict_reading():
    with pytest.raises(DataError, match="how cycle 252 clears is the control's own affair"):
        moves(f"{HEAD}CYCL DEF 252 ~\n Q223=40{Q}")


CYCLE = (
    "BEGIN PGM T MM\nTOOL CALL 1 Z S1000\nL Z+50 FMAX\nCYCL DEF 262 Q335=20 Q239={pitch} Q201=-6 Q355={steps} Q253=750 Q351={way} Q200=2 Q203=0 Q204=20 Q207=200\n"
    "L X+30 Y+0 FMAX M99\nEND PGM T MM\n"
)


def test_a_right_hand_thread_in_climb_rises_one_turn_from_its_depth():
    """Tool 10 mm in a thread of 20: the centre runs on 5 mm, counter-clockwise, from -6 to -4.5."""
    check(
        "heidenhain",
        CYCLE.format(pitch="+1.5", steps=0, way="+1"),
        "R 0 0 50; R 30 . .; R . . 2; L . . -6; A 35 0 . (32.5 0 +); A 35 0 -4.5 (30 0 +); A 30 0 . (32.5 0 +); R . . 20",
    )


@pytest.mark.parametrize(
    ("pitch", "way", "clockwise", "heights"),
    [("+1.5", "-1", True, (-4.5, -6)), ("-1.5", "+1", False, (-4.5, -6)), ("-1.5", "-1", True, (-6, -4.5))],
)
def test_hand_and_sense_decide_which_way_the_helix_goes(
    pitch: str, way: str, clockwise: bool, heights: tuple[float, float]
):
    moves = interpret(CYCLE.format(pitch=pitch, steps=0, way=way), "heidenhain", PENCIL_SETUP).moves
    helix = next(m for m in moves if m.kind == "arc" and m.start[2] != m.end[2])
    assert (helix.clockwise, helix.start[2], helix.end[2]) == (clockwise, *heights)


def test_one_helix_along_the_thread_and_several_apart():
    """6 mm deep, pitch 1.5: four turns in one; with Q355 = 2 two helices 3 mm apart."""
    whole = [
        m
        for m in interpret(CYCLE.format(pitch="+1.5", steps=1, way="+1"), "heidenhain", PENCIL_SETUP).moves
        if m.turns > 1
    ]
    assert [(m.turns, m.start[2], m.end[2]) for m in whole] == [(4, -6, 0)]
    several = [
        m
        for m in interpret(CYCLE.format(pitch="+1.5", steps=2, way="+1"), "heidenhain", PENCIL_SETUP).moves
        if m.kind == "arc"
    ]
    assert [(m.start[2], m.end[2]) for m in several if m.start[2] != m.end[2]] == [(-6, -4.5), (-3, -1.5)]


def test_what_is_assumed_is_told():
    told = interpret(CYCLE.format(pitch="+1.5", steps=0, way="+1"), "heidenhain", PENCIL_SETUP).assumed
    assert [(a.line, a.what) for a in told] == [(5, "how cycle 262 leads in and out")]
