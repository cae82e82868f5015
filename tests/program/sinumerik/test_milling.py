"""CYCLE61, CYCLE72, CYCLE90, SLOT1 and LONGHOLE: paths worked out by pencil from the manual (PGZ, "Milling cycles"). The tool has 10 mm."""

from __future__ import annotations

import math

import pytest

from tests.program.sinumerik.programs import SURVEY, moves, told
from vcmm.core.errors import DataError

HEAD = "T1\nG0 X0 Y0 Z100 F100\n"
CONTOUR = "\nM30\nCON:\nG1 X0 Y0\nX40\nY30\nG3 X30 Y40 I-10 J0\nG1 X0\nCEND:\n"


def path(text: str) -> list[tuple[str, tuple[float, ...]]]:
    return [(m.kind, tuple(round(v, 3) for v in m.end)) for m in moves(HEAD + text, SURVEY)][1:]


def test_long_holes_sink_at_both_ends():
    """LONGHOLE of the manual: four of 30 mm on 45 deg, RAD 20 about (40, 45), RFP + SDIS 1 to -23 in steps of 24/4 = 6.
    The tool goes from 20 + 5 = 25 to 20 + 30 - 5 = 45 mm out: 40 + 25 x 0.70711 = 57.678, 45 + 45 x 0.70711 = 76.820."""
    made = path("LONGHOLE(5,0,1,,23,4,30,40,45,20,45,90,100,320,6)")
    inner, outer = (57.678, 62.678), (71.820, 76.820)
    assert made[:11] == [
        ("rapid", (*inner, 100)), ("rapid", (*inner, 1)), ("line", (*inner, -5)), ("line", (*outer, -5)), ("line", (*outer, -11)),
        ("line", (*inner, -11)), ("line", (*inner, -17)), ("line", (*outer, -17)), ("line", (*outer, -23)), ("line", (*inner, -23)),
        ("rapid", (*inner, 5)),
    ]  # fmt: skip
    assert made[11] == ("rapid", (22.322, 62.678, 5))  # 135 deg: 40 - 17.678
    assert len(made) == 44
    feeds = [
        m.feed
        for m in moves(HEAD + "LONGHOLE(5,0,1,,23,1,30,40,45,20,45,90,100,320,6)", SURVEY)
        if m.kind == "line"
    ]
    assert feeds == [100, 320] * 4


def test_a_tool_wider_than_its_hole_is_refused():
    with pytest.raises(DataError, match="LONGHOLE: the tool is wider"):
        path("LONGHOLE(5,0,1,,23,4,8,40,45,20,45,90,100,320,6)")
    with pytest.raises(DataError, match="SLOT1: the tool"):
        path("SLOT1(5,0,1,-23,,4,30,9,40,45,20,45,90,100,320,6,2,0,0,0,0,0,0,0)")


def test_slots_keep_their_walls():
    """One slot on the X axis, 30 x 15 from RAD 20 on about (0, 0): x 20 to 50, y -7.5 to 7.5. The tool stays 5 mm inside: 25 to 45, +-2.5."""
    text = "SLOT1(5,0,1,-5,,1,30,15,0,0,20,0,0,100,320,0,3,0,0,0,0,0,0,0)"
    made = [m for m in moves(HEAD + text, SURVEY) if m.kind in ("line", "arc") and m.feed == 320]
    assert [min(m.end[0] for m in made), max(m.end[0] for m in made)] == pytest.approx([25, 45])
    assert [min(m.end[1] for m in made), max(m.end[1] for m in made)] == pytest.approx([-2.5, 2.5])
    assert {round(math.dist(m.centre[:2], m.end[:2]), 6) for m in made if m.kind == "arc"} == {2.5}
    assert not any(m.clockwise for m in made if m.kind == "arc")  # CDIR 3: G3
    assert told(HEAD + text)["how SLOT1 clears"][0] == 3
    with pytest.raises(DataError, match="how SLOT1 clears is the control's own affair"):
        moves(HEAD + text)


def test_a_thread_is_a_helix_of_its_pitch():
    """CYCLE90 of the manual: DIATH 60 about (60, 50), pitch 2, from 40 to 35: radius 30 - 5 = 25, two turns and a half, by G2 (2)."""
    text = "CYCLE90(48,40,5,35,,60,50,2,500,2,0,60,50)"
    assert path(text) == [
        ("rapid", (60, 50, 100)), ("rapid", (60, 50, 40)), ("arc", (85, 50, 40)), ("arc", (85, 50, 36)), ("arc", (35, 50, 35)),
        ("arc", (60, 50, 35)), ("rapid", (60, 50, 48)),
    ]  # fmt: skip
    arcs = [m for m in moves(HEAD + text, SURVEY) if m.kind == "arc"]
    assert [(a.turns, a.clockwise) for a in arcs] == [(1, True), (2, True), (1, True), (1, True)]
    outside = path("CYCLE90(48,40,5,36,,60,50,2,500,3,1,60,50)")  # core 50: radius 30; SDIS 5 beside it
    assert outside[2:] == [
        ("line", (90, 50, 40)),
        ("arc", (90, 50, 36)),
        ("line", (95, 50, 36)),
        ("rapid", (95, 50, 48)),
    ]


def test_a_contour_left_of_its_path():
    """CYCLE72 with RL 41: 5 mm inside of the corner (40, 0) and of the arc of 10 mm: (35, 5), radius 5. LP1 4 from the edge of the tool: 9 mm."""
    made = path('CYCLE72("CON:CEND",100,0,2,-5,3,0,0,300,100,1,41,1,4,300,1,4)' + CONTOUR)
    ring = [
        ("line", (0, 5)),
        ("line", (35, 5)),
        ("line", (35, 30)),
        ("arc", (30, 35)),
        ("line", (0, 35)),
        ("line", (-9, 35)),
    ]
    expected = [("rapid", (-9, 5, 100))]
    for level in (-2.5, -5):  # 5 mm in equal steps of 3 at most
        expected += [
            ("rapid", (-9, 5, 2)),
            ("line", (-9, 5, level)),
            *((k, (*p, level)) for k, p in ring),
            ("rapid", (-9, 35, 100)),
        ]
        expected += [("rapid", (-9, 5, 100))] if level == -2.5 else []
    assert made == expected


def test_a_contour_right_of_its_path_between_quadrants():
    """RL 42: outside, corners as arcs about (40, 0), the arc of 10 mm with 15. Quadrants of 4 mm on the right: from (-4, -9) to (0, -5)."""
    made = path('CYCLE72("CON:CEND",100,0,2,-5,0,0.5,0,300,100,1,42,2,4,300,3,4)' + CONTOUR)
    assert made == [
        ("rapid", (-4, -9.5, 100)), ("rapid", (-4, -9.5, 2)), ("line", (-4, -9.5, -5)), ("arc", (0, -5.5, -5)), ("line", (40, -5.5, -5)),
        ("arc", (45.5, 0, -5)), ("line", (45.5, 30, -5)), ("arc", (30, 45.5, -5)), ("line", (0, 45.5, -5)), ("arc", (0, 53.5, -5)),
        ("rapid", (0, 53.5, 100)),
    ]  # fmt: skip
    with pytest.raises(DataError, match="RL 43"):
        path('CYCLE72("CON:CEND",100,0,2,-5,0,0,0,300,100,1,43,1,4,300,1,4)' + CONTOUR)


def test_what_cycle72_lacks_is_a_hole_or_refused():
    text = 'CYCLE72("NONE",100,0,2,-5,0,0,0,300,100,1,41,1,4,300,1,4)'
    assert told(HEAD + text)["the contour NONE of CYCLE72"][1].startswith("a hole in the path")
    with pytest.raises(DataError, match="there is no contour NONE"):
        moves(HEAD + text)


def test_a_face_in_rows():
    """CYCLE61: 60 x 40 from (0, 0), 80 % of 10 mm, so rows 8 mm apart; ends 5 + SDIS 1 beside it; 2 to 0.2 (FALD) in two of 0.9."""
    made = path("CYCLE61(100,2,1,0,0,0,60,40,1,80,0.2,300,31,0,1,10)")
    assert made[:4] == [
        ("rapid", (-6, 0, 100)),
        ("line", (-6, 0, 1.1)),
        ("line", (66, 0, 1.1)),
        ("line", (66, 8, 1.1)),
    ]
    assert made[-2:] == [("line", (-6, 40, 0.2)), ("rapid", (-6, 40, 100))]
    assert sum(kind == "line" for kind, _ in made) == 2 * 12
    one_way = path(
        "CYCLE61(100,2,1,0,0,0,60,40,0,20,0,300,21,0,1,0)"
    )  # along Y, 20 mm apart, each from below
    assert [p for k, p in one_way if k == "line"] == [
        (0, -6, 0),
        (0, 46, 0),
        (20, -6, 0),
        (20, 46, 0),
        (40, -6, 0),
        (40, 46, 0),
        (60, -6, 0),
        (60, 46, 0),
    ]
    with pytest.raises(DataError, match="CYCLE61 with VARI 31, LIM 1111"):
        path("CYCLE61(100,2,1,0,0,0,60,40,1,80,0.2,300,31,1111,1,10)")
