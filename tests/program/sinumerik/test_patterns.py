"""Patterns of holes and pockets: where the tool goes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.program.sinumerik.programs import SURVEY, moves, told
from vcmm.core.errors import DataError

DRILL = "G0 X0 Y0 Z10 F100\nMCALL CYCLE81(10,0,2,-5)\n"


def bottoms(text):
    return [m.end for m in moves(f"{DRILL}{text}\nMCALL", SURVEY) if m.kind == "line"]


def test_a_row_from_its_nearer_end():
    """HOLES1(SPCA, SPCO, STA1, FDIS, DBH, NUM)."""
    assert np.allclose(bottoms("HOLES1(10,5,90,2,20,2)"), [(10, 7, -5), (10, 27, -5)])
    assert np.allclose(bottoms("G0 X90\nHOLES1(10,0,0,0,40,3)")[1:], [(90, 0, -5), (50, 0, -5), (10, 0, -5)])


def test_a_circle_and_a_grid():
    """HOLES2 spreads four holes evenly where INDA is 0; CYCLE801 runs along the shorter distance, to and fro."""
    assert np.allclose(
        bottoms("HOLES2(70,60,10,0,0,4)"), [(80, 60, -5), (70, 70, -5), (60, 60, -5), (70, 50, -5)]
    )
    assert np.allclose(
        bottoms("CYCLE801(1,2,0,10,15,2,2)"), [(1, 2, -5), (11, 2, -5), (11, 17, -5), (1, 17, -5)]
    )
    assert np.allclose(
        bottoms("CYCLE801(0,0,90,20,5,2,2)"), [(0, 0, -5), (-5, 0, -5), (-5, 20, -5), (0, 20, -5)]
    )
    assert bottoms("CYCLE802(1,1,3,4,5,6)") == [(3, 4, -5), (5, 6, -5)]


def feeds(text):
    return [m for m in moves(f"T1\nG0 Z50 F300\n{text}", SURVEY) if m.kind in ("line", "arc")]


def test_rectangular_pocket():
    """POCKET3: 60 x 40 about (50, 40), tool of 10 mm: 50 +- 25, 40 +- 15, at -3 and -5; FFP1 500, FFD 120; CDIR 3: G3."""
    made = feeds("POCKET3(20,0,2,-5,60,40,8,50,40,0,3,0,0,500,120,3,11,5)")
    points = np.array([m.end for m in made])
    assert np.allclose([points.min(axis=0), points.max(axis=0)], [(25, 25, -5), (75, 55, -3)])
    assert {m.feed for m in made} == {500, 120}
    assert {round(math.dist(m.centre[:2], m.end[:2]), 6) for m in made if m.kind == "arc"} == {3.0}
    assert not any(m.clockwise for m in made if m.kind == "arc")


def test_circular_pocket_and_face():
    arcs = [m for m in feeds("POCKET4(20,0,2,-5,20,50,40,5,0,0,500,120,2,1,8)") if m.kind == "arc"]
    assert [round(math.dist(m.end[:2], (50, 40)), 6) for m in arcs] == [7.5, 15]
    assert all(m.clockwise for m in arcs)
    rows = feeds("CYCLE71(20,2,2,0,10,10,50,20,0,2,10,5,0,400)")
    assert [m.end[:2] for m in rows] == [(5, 10), (65, 10), (65, 20), (5, 20), (5, 30), (65, 30)]
    assert {m.end[2] for m in rows} == {0.0}


def test_how_a_pocket_is_cleared_is_told_and_refused_in_strict_reading():
    text = "T1\nG0 Z50 F300\nPOCKET4(20,0,2,-5,20,50,40,5,0,0,500,120,2,11,8)"
    assert told(text) == {"how POCKET4 clears": (3, "in rings from the inside outwards")}
    with pytest.raises(DataError, match="how POCKET4 clears is the control's own affair"):
        moves(text)
    with pytest.raises(DataError, match="the depth must lie below RFP"):
        feeds("POCKET4(20,0,2,5,20,50,40,5,0,0,500,120,2,1,8)")


def test_climb_milling_goes_by_the_spindle():
    """A pocket is climb milled (CDIR 0) counter-clockwise with M3 and clockwise with M4; CDIR 1 the other way, 2 and 3 whatever the spindle does."""
    for m, cdir, clockwise in (
        (3, 0, False),
        (4, 0, True),
        (3, 1, True),
        (4, 1, False),
        (4, 3, False),
        (3, 2, True),
    ):
        made = feeds(f"M{m} S1000\nPOCKET4(20,0,2,-5,20,50,40,5,0,0,500,120,{cdir},1,8)")
        assert {a.clockwise for a in made if a.kind == "arc"} == {clockwise}


def test_a_pocket_on_a_helix():
    """VARI 21, RAD1 3, DP1 2.5: from RFP + SDIS = 2 to -4 in 6 / 2.5 -> 3 whole turns of 2 mm, G2 (CDIR 2), from (3, 0) on the side of the
    first axis, which is approached at feed; then one full circle at -4, at FFD = 100."""
    made = feeds("POCKET4(10,0,2,-4,20,0,0,4,0,0,300,100,2,21,0,0,0,3,2.5)")
    assert [(m.kind, m.end, m.turns, m.clockwise, m.feed) for m in made[:3]] == [
        ("line", (3, 0, 2), 1, None, 100), ("arc", (3, 0, -4), 3, True, 100), ("arc", (3, 0, -4), 1, True, 100),
    ]  # fmt: skip
    assert made[1].centre[:2] == (0, 0)
    with pytest.raises(DataError, match="needs the radius RAD1 of its helix and the depth DP1"):
        feeds("POCKET4(10,0,2,-4,20,0,0,4,0,0,300,100,2,21)")
    with pytest.raises(DataError, match=r"leaves the pocket; at most 15 mm fit beside the tool and FAL"):
        feeds("POCKET4(10,0,2,-4,20,0,0,4,0,0,300,100,2,21,0,0,0,15.5,2.5)")  # 20 - 5 (the tool) - 0
    turned = feeds("POCKET3(20,0,2,-5,60,40,8,50,40,90,3,0,0,500,120,3,21,5,0,0,0,4,1)")
    assert turned[0].end == pytest.approx((50, 44, 2))  # STA 90: the longitudinal axis of the pocket is Y
    blank = told("T1\nG0 Z50 F300\nPOCKET3(20,0,2,-5,60,40,8,50,40,0,3,0,0,500,120,3,31,5,20,10,2,15)")
    assert blank["the blank of the pocket (AP1, AP2, AD) in POCKET3"][1].startswith("none")
    assert blank["how the tool goes in to and fro (VARI 3x) in POCKET3"][1] == "straight down at FFD"


def test_finishing_leaves_no_allowance():
    """VARI 12: the edge at 20 - 5 = 15 from the middle and the base at -5, FAL and FALD gone; POCKET2 with VARI 0 roughs (14.5) and finishes (15)
    in infeeds MIDF at FFP2. Both left their allowance standing before."""
    made = feeds("POCKET4(20,0,2,-5,20,50,40,5,0.5,0.2,500,120,2,12,8)")
    assert max(math.dist(m.end[:2], (50, 40)) for m in made) == pytest.approx(15)
    assert min(m.end[2] for m in made) == -5
    both = feeds("POCKET2(20,0,2,-5,,20,50,40,120,500,5,2,0.5,0,2.5,700)")
    rings = {(round(math.dist(m.end[:2], (50, 40)), 6), m.end[2], m.feed) for m in both if m.kind == "arc"}
    assert {r for r in rings if r[0] > 14} == {(14.5, -5, 500), (15, -2.5, 700), (15, -5, 700)}
