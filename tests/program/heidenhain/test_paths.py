"""Path functions of Klartext: points, centres and feeds by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.program.heidenhain.klartext import check, moves
from vcmm.core.errors import DataError
from vcmm.program.heidenhain.reader import read
from vcmm.program.setup import Setup


def test_lines():
    got = moves("L X+10 Y-5 R0 FMAX M3\n2 L IX+2.5 F200\nL Z-Q1 ; note\n4 ;nothing\nL Y+1,5")
    assert [m.kind for m in got] == ["rapid", "line", "line", "line"]
    assert np.allclose([m.end for m in got], [(10, -5, 0), (12.5, -5, 0), (12.5, -5, 0), (12.5, 1.5, 0)])
    assert [m.feed for m in got] == [None, 200, 200, 200]
    assert got[1].source == (3, 1, 16)


def test_inch():
    (one,) = moves("L X+1 F100", unit="INCH")
    assert one.end == (25.4, 0, 0)
    assert one.feed == 254.0  # 100 x 0.1 inch/min


def test_circle_about_a_pole():
    (one,) = moves("CC X+0 Y+10\nC X+10 Y+10 DR+ F100")
    assert (one.centre, one.clockwise) == ((0, 10, 0), False)
    (full,) = moves("CC IX+5 IY+0\nC X+0 Y+0 DR- F100")
    assert (full.centre, full.clockwise, full.end, full.turns) == ((5, 0, 0), True, (0, 0, 0), 1)


def test_circle_by_radius():
    (short,) = moves("CR X+10 Y+10 R+10 DR+ F100")
    (long,) = moves("CR X+10 Y+10 R-10 DR+ F100")
    assert np.allclose(short.centre, (0, 10, 0), atol=1e-9)
    assert np.allclose(long.centre, (10, 0, 0), atol=1e-9)


def test_tangential_circle():
    # leaves along +x, ends at (10, 10): a quarter circle about (0 + 0, 10); then straight on upwards, end (0, 10): half circle
    got = moves("L X-5 Y+0 FMAX\nL X+0 F100\nCT X+10 Y+10\nCT X+0 Y+10")
    assert np.allclose(got[2].centre, (0, 10, 0), atol=1e-9)
    assert np.allclose(got[3].centre, (5, 10, 0), atol=1e-9)
    assert [m.clockwise for m in got[2:]] == [False, False]


def test_polar_coordinates_and_helix():
    got = moves(
        "CC X+50 Y+50\nLP PR+20 PA+0 FMAX\nLP IPA+90 FMAX\nCP PA+180 DR+ F100\nCP IPA+720 IZ-4 DR+\nCP IPA-450 IZ-5 DR-"
    )
    assert np.allclose(
        [m.end for m in got], [(70, 50, 0), (50, 70, 0), (30, 50, 0), (30, 50, -4), (50, 70, -9)], atol=1e-9
    )
    assert [m.turns for m in got[2:]] == [
        1,
        2,
        2,
    ]  # 720 deg are two whole turns, 450 deg the second one started
    assert [m.clockwise for m in got[2:]] == [False, False, True]


def test_rounding_and_chamfer():
    check("L X+20 F100\nRND R5 F50\nL Y+20", (15, 0, 0), (20, 5, 0), (20, 20, 0))
    assert [m.feed for m in moves("L X+20 F100\nRND R5 F50\nL Y+20")] == [100, 50, 100]
    check("L X+20 F100\nCHF 5\nL Y+20", (15, 0, 0), (20, 5, 0), (20, 20, 0))


def test_radius_compensation():
    text = "TOOL CALL 5 Z S1000\nL X-20 Y+0 R0 FMAX\nL X+0 Y+0 RR F100\nL X+20\nL Y+20\nL X+40 R0"
    check(text, (-20, 0, 0), (0, -5, 0), (20, -5, 0), (25, 0, 0), (25, 20, 0), (40, 20, 0))
    over = text.replace("S1000", "S1000 DR+1")  # oversize: radius 6
    check(over, (-20, 0, 0), (0, -6, 0), (20, -6, 0), (26, 0, 0), (26, 20, 0), (40, 20, 0))


def test_machine_coordinates_leave_out_the_tool_length():
    (one,) = moves("TOOL CALL 2 Z\nL Z-10 FMAX M91")
    assert one.end == (0, 0, -90)  # the axis stands at -10, the tip 80 mm below
    assert one.rewritable is False


def test_a_tangential_circle_behind_a_circle_about_a_pole():
    # about (10, 0) from (15, 0) to (10, 5) counterclockwise: there the direction is (-1, 0). On to (5, 10): n = (0, -1),
    # d = (-5, 5), k = 50 / (2 x -5) = -5: centre (10, 5) - 5 n = (10, 10), clockwise
    got = moves("L X+15 Y+0 F100\nCC X+10 Y+0\nC X+10 Y+5 DR+\nCT X+5 Y+10")
    assert np.allclose(got[-1].centre, (10, 10, 0), atol=1e-12)
    assert got[-1].clockwise


def test_polar_coordinates_without_a_pole_are_told():
    """The control stops at LP and C without CC; the zero was taken in silence, on both levels."""
    text = "BEGIN PGM T MM\nL X+1 Y+0 R0 FMAX\n{}LP PR+10 PA+90 F100\nEND PGM T MM\n"
    found = read(text.format(""), "part.h", Setup(strict=False))
    assert [(a.line, a.what, a.value) for a in found.assumed] == [(3, "the pole (CC)", "the zero in force")]
    with pytest.raises(DataError, match=r"3:1: C, LP, CP and CTP need a pole"):
        read(text.format(""), "part.h", Setup())
    assert not read(text.format("CC X+0 Y+0\n"), "part.h", Setup(strict=False)).assumed
