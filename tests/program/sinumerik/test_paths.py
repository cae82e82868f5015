"""End points, arcs in all their forms, corners: by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.program.sinumerik.programs import SURVEY, check, moves, told
from vcmm.core.errors import DataError, ModelLimit


def test_lines_absolute_incremental_and_per_word():
    check(
        "G0 X10 Y20 Z5\nG91 G1 X5 F100\nX=AC(1) Y5\nG90 X=IC(2)",
        (10, 20, 5), (15, 20, 5), (1, 25, 5), (3, 25, 5),
    )  # fmt: skip


@pytest.mark.parametrize(
    "arc",
    ["G3 X10 Y10 I0 J10", "G3 X10 Y10 J10", "G3 X10 Y10 I=AC(0) J=AC(10)", "G3 X10 Y10 CR=10", "G3 X10 Y10 AR=90",
     "G3 I0 J10 AR=90", "CIP X10 Y10 I1=7.071067811865475 J1=2.928932188134524"],
)  # fmt: skip
def test_the_same_quarter_circle_in_all_its_forms(arc):
    # quarter from (0, 0) about (0, 10) to (10, 10); the middle lies at 10 (sin 45, 1 - cos 45)
    (one,) = moves(f"G1 F100\n{arc}")
    assert np.allclose(one.end, (10, 10, 0), atol=1e-9)
    assert np.allclose(one.centre, (0, 10, 0), atol=1e-9)
    assert one.clockwise is False
    assert one.turns == 1


def test_long_way_round_and_turns():
    (one,) = moves("G1 F100\nG3 X10 Y10 CR=-10")  # the other centre, three quarters
    assert np.allclose(one.centre, (10, 0, 0), atol=1e-9)
    (helix,) = moves("G1 F100\nG2 X0 Y0 Z-6 I5 TURN=2")  # a full circle and two more
    assert (helix.turns, helix.clockwise, helix.end) == (3, True, (0, 0, -6))


def test_planes():
    (one,) = moves("G18 G1 F100\nG2 X10 Z10 K10 I0")  # about (x, z) = (0, 10); G18: first axis Z, second X
    assert (one.plane, one.centre) == ("ZX", (0, 0, 10))
    (two,) = moves("G19 G1 F100\nG3 Y10 Z10 J0 K10")
    assert (two.plane, two.centre) == ("YZ", (0, 0, 10))


def test_arc_that_does_not_fit():
    with pytest.raises(
        DataError, match=r"part.mpf:1:1: .*radius 10.0000 mm at its start, 11.0000 mm at its end"
    ):
        moves("G2 X21 Y0 I10 J0 F100")
    with pytest.raises(DataError, match="CR=4 fits no arc"):
        moves("G2 X10 CR=4 F100")


def test_rounding_and_chamfer():
    check("G1 F100\nX20 RND=5\nY20", (15, 0, 0), (20, 5, 0), (20, 20, 0))
    check("G1 F100\nX20 CHR=5\nY20", (15, 0, 0), (20, 5, 0), (20, 20, 0))
    s = 4 / math.sqrt(2)  # CHF is the width across: 4 mm across cut off 4 / sqrt 2 on each side
    check("G1 F100\nX20 CHF=4\nY20", (20 - s, 0, 0), (20, s, 0), (20, 20, 0))
    rounded = moves("G1 F100\nX20 RND=5\nY20")[1]
    assert (rounded.kind, rounded.centre, rounded.clockwise) == ("arc", (15, 5, 0), False)
    with pytest.raises(ModelLimit, match=r"part.mpf:2:1: a rounding of radius 50 mm does not fit"):
        moves("G1 F100\nX20 RND=50\nY20")


def test_rounding_between_line_and_arc():
    # line y = 0 to (10, 0), then clockwise about (20, 0), R = 10, from heading +y. Rounding r = 2 on the left: centre at
    # height 2, distance 10 + 2 from (20, 0): x = 20 - sqrt(144 - 4) = 8.167840; it touches the line below its centre
    got = moves("G1 F100\nX10 RND=2\nG2 X20 Y10 I10 J0")
    x = 20 - math.sqrt(140)
    assert np.allclose(got[1].centre, (x, 2, 0), atol=1e-9)
    assert np.allclose(got[0].end, (x, 0, 0), atol=1e-9)
    assert np.allclose(got[1].end, (20 + (x - 20) * 10 / 12, 2 * 10 / 12, 0), atol=1e-9)


def test_threads_and_tapping():
    """G33: K mm per turn; G331 K1.5 at S 200 without M3; G63 at the feed of its block alone."""
    made = moves("S500 M3 G0 X10\nG33 Z-20 K2\nG0 X20")
    assert [(m.kind, m.feed) for m in made] == [("rapid", None), ("thread", 1000), ("rapid", None)]
    tapped = moves("SPOS=0\nG331 Z-10 K1.5 S200\nG332 Z5 K1.5\nG0 Z9")
    assert [(m.kind, m.feed) for m in tapped] == [("line", 300), ("line", 300), ("rapid", None)]
    assert [m.kind for m in moves("G0 X1\nG63 Z-5 F300\nX2")] == ["rapid", "line", "rapid"]


def test_tangential_circle():
    """CT: leaves along +X from (10, 0); to (20, 10) it is a quarter about (10, 10)."""
    got = moves("G1 X10 F100\nCT X20 Y10\nG1 X30")
    assert np.allclose(got[1].centre, (10, 10, 0))
    assert not got[1].clockwise
    mirrored = moves("MIRROR X0\nG1 X10 F100\nCT X20 Y10")
    assert np.allclose(mirrored[1].end, (-20, 10, 0))
    assert mirrored[1].clockwise
    with pytest.raises(DataError, match="CT"):
        moves("CT X20 Y10 F100")


def test_splines_and_transformations_are_told():
    text = "G1 X1 F100\nBSPLINE X2 Y3\nX4\nTRAORI\nG1 X5 A3=0 B3=0 C3=1 LEAD=5"
    assert [m.end[:2] for m in moves(text, SURVEY)] == [(1, 0), (2, 3), (4, 3), (5, 3)]
    assert list(told(text)) == [
        "BSPLINE (spline)",
        "TRAORI (5-axis transformation)",
        "tool directions (LEAD, TILT, A4= B4= C4=)",
    ]


def test_a_line_by_its_angle():
    """ANG=30 to X20: Y = 10 tan 30; ANG=45 to Y7 from X20: X by 7 - 10 tan 30."""
    rise = 10 * math.tan(math.radians(30))
    check("G1 X10 F100\nX20 ANG=30\nY7 ANG=45", (10, 0, 0), (20, rise, 0), (20 + 7 - rise, 7, 0))
    assert "ANG= without one coordinate of the end point" in told("G1 X10 F100\nANG=30 Z1")
    assert "OFFN= (oversize of the contour)" in told("OFFN=2\nG0 X1")
