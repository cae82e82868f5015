"""PATTERN DEF, CYCL CALL PAT and POS, cycles 220 and 221: where the holes are."""

from __future__ import annotations

import numpy as np
import pytest

from tests.program.heidenhain.klartext import moves
from vcmm.core.errors import DataError
from vcmm.program.heidenhain.patterns import pattern_points
from vcmm.program.heidenhain.text import KlartextReader, blocks_of

DRILL = (
    "TOOL CALL 5 Z S1\nCYCL DEF 201 ~\n Q200=2 ~\n Q201=-5 ~\n Q206=100 ~\n Q208=0 ~\n Q203=+0 ~\n Q204=10\n"
)


def points(text):
    return pattern_points(KlartextReader(blocks_of(text)[0].tokens, {}, lambda name: None))


def bottoms(text):
    return [m.end for m in moves(text) if m.kind == "line" and m.end[2] < m.start[2]]


def test_points_of_all_kinds():
    assert points("POS1 (X+25 Y+33.5 Z+1) ~\n POS2 (X+50 Y+6 Z+0)") == [(25, 33.5, 1), (50, 6, 0)]
    assert np.allclose(points("ROW1 (X+1 Y+2 D+8 NUM3 ROT+90 Z+0)"), [(1, 2, 0), (1, 10, 0), (1, 18, 0)])
    grid = points("PAT1 (X+0 Y+0 DX+10 DY+5 NUMX2 NUMY2 ROT+0 ROTX+0 ROTY+0 Z+0)")
    assert np.allclose(grid, [(0, 0, 0), (10, 0, 0), (10, 5, 0), (0, 5, 0)])
    assert (
        len(points("FRAME1 (X+0 Y+0 DX+1 DY+1 NUMX4 NUMY3 ROT+0 ROTX+0 ROTY+0 Z+0)")) == 10
    )  # 12 less 2 inside
    assert np.allclose(points("CIRC1 (X+0 Y+0 D20 START+90 NUM2 Z+0)"), [(0, 10, 0), (0, -10, 0)])
    assert np.allclose(points("PITCHCIRC1 (X+0 Y+0 D20 START+0 STEP+90 NUM2 Z+0)"), [(10, 0, 0), (0, 10, 0)])


def test_calls_at_a_pattern_and_at_a_position():
    """Z of a point counts on top of the surface of the cycle: 1 - 5 = -4."""
    text = f"{DRILL}L Z+50 FMAX\nPATTERN DEF POS1 (X+5 Y+6 Z+1)\nCYCL CALL PAT FMAX\nCYCL CALL POS X+20 Y+0 Z+0 FMAX"
    assert bottoms(text) == [(5, 6, -4), (20, 0, -5)]


def test_circle_and_rows_act_at_once():
    circle = f"{DRILL}CYCL DEF 220 ~\n Q216=+50 ~\n Q217=+0 ~\n Q244=20 ~\n Q245=+0 ~\n Q246=+360 ~\n Q247=+0 ~\n Q241=4"
    assert np.allclose(bottoms(circle), [(60, 0, -5), (50, 10, -5), (40, 0, -5), (50, -10, -5)])
    part = circle.replace("Q246=+360", "Q246=+90").replace("Q241=4", "Q241=2")
    assert np.allclose(bottoms(part), [(60, 0, -5), (50, 10, -5)])
    rows = f"{DRILL}CYCL DEF 221 ~\n Q225=+1 ~\n Q226=+2 ~\n Q237=10 ~\n Q238=5 ~\n Q242=2 ~\n Q243=2 ~\n Q224=+0 ~\n Q203=+3 ~\n Q301=1"
    assert bottoms(rows) == [(1, 2, -2), (11, 2, -2), (11, 7, -2), (1, 7, -2)]


def test_bad_patterns():
    with pytest.raises(DataError, match="PATTERN DEF takes"):
        moves("PATTERN DEF STAR1 (X+1)")
    with pytest.raises(DataError, match=r'"\)" is missing'):
        moves("PATTERN DEF POS1 (X+1")
    with pytest.raises(DataError, match="but none is defined"):
        moves("CYCL DEF 220 Q216=+50")


@pytest.mark.parametrize(
    ("text", "missing"),
    [
        ("CYCL DEF 220 POLAR PATTERN ~\n Q216=+50 ~\n Q217=+50 ~\n Q244=80 ~\n Q245=0 ~\n Q246=360 ~\n Q247=0", "cycle 220 has no Q241"),
        ("CYCL DEF 220 POLAR PATTERN ~\n Q216=+50 ~\n Q217=+50 ~\n Q244=80 ~\n Q241=4", "cycle 220 has no Q245"),
        ("CYCL DEF 221 CARTESIAN PATTERN ~\n Q225=+50 ~\n Q226=+50 ~\n Q237=10 ~\n Q238=10 ~\n Q243=1 ~\n Q224=0", "cycle 221 has no Q242"),
        ("PATTERN DEF CIRC1 (X+0 Y+0 D20 START+90)", "CIRC of PATTERN DEF has no NUM"),
        ("PATTERN DEF ROW1 (X+0 Y+0 NUM3)", "ROW of PATTERN DEF has no D"),
        ("PATTERN DEF ROW1 (X+0 Y+0 D8 NUM3 RTO+90)", "has no word RTO; its words are X, Y, Z, D, NUM, ROT"),
        ("PATTERN DEF CIRC1 (X+0 Y+0 D20 STEP+90 NUM3)", "CIRC of PATTERN DEF has no word STEP"),
    ],
)  # fmt: skip
def test_a_pattern_that_is_not_complete_is_refused(text, missing):
    # without Q241 or Q242 no hole was drilled, and nothing was said
    with pytest.raises(DataError, match=missing):
        moves(f"{DRILL}L Z+50 FMAX\n{text}\n")
