"""CYCLE95 and CYCLE97, by the rules of the cycles manual."""

from __future__ import annotations

import math

import pytest

from tests.program.pencil import check
from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup, Tool

SURVEY = Setup(strict=False)
HEAD = "G18 G90 G71 G95 DIAMON\nG97 S800 M3\nG0 X60 Z10\n"


def threads(arguments: str) -> list[tuple[float, float, float]]:
    """X (radius) and Z where each cut begins, and Z where it ends."""
    moves = interpret(f"{HEAD}CYCLE97({arguments})\nM30\n", "sinumerik", SURVEY).moves
    return [(m.start[0], m.start[2], m.end[2]) for m in moves if m.kind == "thread"]


def test_the_depths_of_a_thread_of_equal_section():
    """VARI 3, depth 1.2, allowance 0.2, 4 cuts: 1.0 sqrt(k / 4) = 0.5, 0.7071, 0.8660, 1.0; then 1.2, and two without infeed."""
    cuts = threads("2,,0,-30,20,20,4,3,1.2,0.2,0,0,4,2,3,1")
    assert [20 / 2 - x for x, _, _ in cuts] == pytest.approx(
        [0.5, 0.70711, 0.86603, 1.0, 1.2, 1.2, 1.2], abs=1e-5
    )
    assert {(z, end) for _, z, end in cuts} == {(4.0, -33.0)}  # run-in 4, run-out 3
    feed = next(m.feed for m in interpret(f"{HEAD}CYCLE97(2,,0,-30,20,20,4,3,1.2,0.2,0,0,4,2,3,1)\nM30\n", "sinumerik", SURVEY).moves if m.kind == "thread")  # fmt: skip
    assert feed == pytest.approx(2.0 * 800)


def test_equal_infeeds_inside_along_the_flank_and_on_a_taper():
    """VARI 2: inside, 3 equal cuts of 0.3 to 0.9; 30 degrees along the flank: 0.9 tan 30 deg = 0.5196 at the last one."""
    cuts = threads("1.5,,0,-20,30,30,2,1,0.9,0,30,0,3,0,2,1")
    assert [x - 15 for x, _, _ in cuts] == pytest.approx([0.3, 0.6, 0.9])
    assert cuts[-1][1] == pytest.approx(2.0 - 0.9 * math.tan(math.radians(30)))
    taper = threads(
        "1.5,,0,-20,30,34,5,0,0.5,0,0,0,1,0,1,1"
    )  # 2 mm in radius over 20 mm: 0.5 mm less 5 mm ahead
    assert taper[0][0] == pytest.approx(15 - 0.5 - 0.5)


def test_a_metric_size_stands_for_its_coarse_pitch():
    moves = interpret(
        f"{HEAD}CYCLE97(,10,0,-20,10,10,2,1,0.9,0,0,0,1,0,1,1)\nM30\n", "sinumerik", SURVEY
    ).moves
    assert next(m.feed for m in moves if m.kind == "thread") == pytest.approx(1.5 * 800)  # M10: 1.5 mm


CONTOUR = "M30\nPROC PART\nG1 X20 Z0\nZ-10\nX40\nZ-20\nRET\n"


def test_stock_is_taken_in_equal_cuts_along_the_contour():
    """From diameter 40 down to 20 with MID 4: ten millimetres in three cuts of 3.333; lift 1 mm at 45 degrees, allowance 0."""
    third = 10 / 3
    a, b = 20 - third, 20 - 2 * third
    check(
        "sinumerik",
        f'{HEAD}CYCLE95("PART",4,0,0,0,0.2,0.1,0.1,1,0,0,1)\n{CONTOUR}',
        f"R 30 0 10; R 21 0 1; R {a} 0 1; L . . -10; L {a + 1} . -9; R . . 1; R {b} . .; L . . -10; L {b + 1} . -9; R . . 1; "
        "R 10 . 0; L . . -10; L 20 . .; L . . -20; R 21 . 1",
    )


def test_a_depth_that_is_a_multiple_of_the_cut_takes_no_cut_more():
    """10 mm of radius in cuts of 5 mm: two, at X 15 and 10 (radius), down to the shoulder at Z-10."""
    text = f'{HEAD}CYCLE95("PART",5,0,0,0,0.2,0.1,0.1,1,0,0,1)\n{CONTOUR}'
    moves = interpret(text, "sinumerik", SURVEY).moves
    cuts = [m.end[0] for m in moves if m.kind == "line" and m.end[0] == m.start[0] and m.end[2] == -10]
    assert cuts == [15, 10]


def test_finishing_follows_the_contour_at_its_own_feed():
    moves = interpret(
        f'{HEAD}CYCLE95("PART",4,0,0,0,0.2,0.1,0.05,5,0,0,1)\n{CONTOUR}', "sinumerik", SURVEY
    ).moves
    cuts = [m for m in moves if m.kind == "line"]
    assert [(m.end[0], m.end[2]) for m in cuts] == [(10, -10), (20, -10), (20, -20)]
    assert [m.feed for m in cuts] == pytest.approx([0.05 * 800] * 3)


def test_a_contour_between_labels_and_one_that_is_missing():
    text = (
        f'{HEAD}CYCLE95("CON_A:CON_E",4,0,0,0,0.2,0.1,0.1,5,0,0,1)\nM30\nCON_A: G1 X20 Z0\nZ-10\nCON_E: X40\n'
    )
    cuts = [m.end[0] for m in interpret(text, "sinumerik", SURVEY).moves if m.kind == "line"]
    assert cuts == [10, 20]
    told = interpret(f'{HEAD}CYCLE95("GONE",4,0,0,0,0.2,0.1,0.1,1)\nM30\n', "sinumerik", SURVEY).assumed
    assert [(a.line, a.what) for a in told] == [(4, "the contour GONE of CYCLE95")]


def test_a_contour_without_feed_takes_those_of_the_cycle():
    """FF1 0.2 mm for roughing, FF3 0.05 for finishing, at 800 1/min: nothing is missing, so the strict reader reads it too."""
    cycle = f'{HEAD}CYCLE95("PART",4,0,0,0,{{}},0.1,{{}},9,0,0,1)\n{CONTOUR}'
    read = interpret(cycle.format(0.2, 0.05), "sinumerik")
    assert {round(m.feed, 9) for m in read.moves if m.kind == "line"} == {0.2 * 800, 0.05 * 800}
    with pytest.raises(DataError, match="no feed"):
        interpret(cycle.format(0.2, 0), "sinumerik")


def test_radius_compensation_takes_the_nose_where_the_tool_is_measured():
    """Nose 0.4 mm, tip at -X -Z: along a chamfer of 45 deg its imaginary tip leads by 0.4 (1 - sqrt(1/2)) = 0.11716 mm in X and Z, along
    the cylinder X30 it stands at X 15.000 (radius) and not the nose outside of it."""
    text = "G71 G18 G90 G40 DIAMON\nT1 D1\nG0 X20 Z2\nG42 G1 X24 Z0 F100\nX30 Z-3\nZ-30\nX50\nG40 G0 X60\nM30"
    tool = Tool(1, shape="turning", nose_radius=0.4, orientation=3)
    ends = [m.end for m in interpret(text, "sinumerik", Setup(tools={1: tool})).moves]
    lead = 0.4 * (1.0 - math.sqrt(0.5))
    assert ends[1] == pytest.approx((12.0 - lead, 0.0, -lead))
    assert (15.0, 0.0, -30.0) in [tuple(round(v, 9) for v in p) for p in ends]
    assert ends[-2] == pytest.approx((24.6, 0.0, -30.0))  # the nose beside X50, its tip 0.4 mm before
