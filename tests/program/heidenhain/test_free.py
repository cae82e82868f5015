"""Free contours (FK): the examples of HEIDENHAIN's manuals, and one small contour for each word, by pencil."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup, Tool

HEAD = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1000\n2 L X{x} Y{y} R0 F500\n"
TOOLS = {1: Tool(1, 50.0, 4.0)}


def moves(text: str, x: float = 0.0, y: float = 0.0, strict: bool = True):
    program = interpret(
        HEAD.format(x=f"{x:+g}", y=f"{y:+g}") + text + "\n99 END PGM A MM\n",
        "heidenhain",
        Setup(strict=strict, tools=TOOLS),
    )
    return [m for m in program.moves if m.source.line > 3]


def check(
    text: str,
    *ends: tuple[float, float],
    x: float = 0.0,
    y: float = 0.0,
    strict: bool = True,
    tolerance: float = 1e-9,
):
    got = np.array([m.end[:2] for m in moves(text, x, y, strict)])
    assert got.shape == (len(ends), 2), got
    assert np.allclose(got, ends, atol=tolerance), got


FK1 = """8 FC DR- R18 CLSD+ CCX+20 CCY+30
9 FLT
10 FCT DR- R15 CCX+50 CCY+75
11 FLT
12 FCT DR- R15 CCX+75 CCY+20
13 FLT
14 FCT DR- R18 CLSD- CCX+20 CCY+30"""


def test_three_circles_and_the_lines_that_touch_them():
    """Manual, FK example 1. From (20, 30) to (50, 75) are (30, 45), radii 18 and 15: the line goes along (0.6, 0.8), whose left normal is (-0.8, 0.6)
    (0.6 * 45 - 0.8 * 30 = 3 = 18 - 15). It leaves at (20 - 0.8 * 18, 30 + 0.6 * 18) = (5.6, 40.8) and comes to (50 - 12, 75 + 9) = (38, 84).
    The circles of 15 are as far apart as their centres, (25, -55): along (25, -55) / 60.415, beside by 15 * (55, 25) / 60.415."""
    beside = 15.0 / math.hypot(25.0, 55.0)
    got = moves(FK1, 2.0, 30.0)
    ends = [m.end[:2] for m in got]
    assert np.allclose(ends[:2], [(5.6, 40.8), (38.0, 84.0)])
    assert np.allclose(
        ends[2:4], [(50 + 55 * beside, 75 + 25 * beside), (75 + 55 * beside, 20 + 25 * beside)]
    )
    assert np.allclose(ends[6], (2.0, 30.0))
    # the last line touches both: n.(75, 20) + 15 = n.(20, 30) + 18 = its offset
    (x, y), (u, v) = ends[4], ends[5]
    n = np.array([-(v - y), u - x]) / math.hypot(u - x, v - y)
    assert np.allclose((n @ (75 - x, 20 - y), n @ (20 - x, 30 - y)), (-15.0, -18.0))
    assert [m.kind for m in got] == ["arc", "line"] * 3 + ["arc"]
    assert all(m.clockwise for m in got if m.kind == "arc")


FK3 = """8 FC DR- R40 CCX+0 CCY+0
9 FLT
10 FCT DR- R10 CCX+0 CCY+50
11 FLT
12 FCT DR+ R6 CCX+0 CCY+0
13 FCT DR+ R24{first}
14 FCT DR+ R6 CCX+12 CCY+0
15 FSELECT 2
16 FCT DR- R1.5{second}
17 FCT DR- R36 CCX+44 CCY-10
18 FSELECT 2
19 FCT DR+ R5{third}
20 FLT X+110 Y+15 AN+0
21 FL AN-90
22 FL X+65 AN+180 PAR20 DP30
24 FL X+65 Y-25 AN-90
25 FC DR+ R50 CCX+65 CCY-75
26 FCT DR- R65{fourth}
27 FSELECT 1
28 FCT Y+0 DR- R40 CCX+0 CCY+0{last}
29 FSELECT 4"""


def test_a_lever_of_tangential_arcs_is_told_apart_by_coordinates():
    """Manual, FK example 3, with one coordinate for each FSELECT. R40 about 0 and R10 about (0, 50): n = (-0.8, 0.6). R24 about (6, +-sqrt(18^2 - 6^2)) holds
    the two of R6. PAR20 DP30: 30 mm below Y15,
    since block 21 goes down; R5 about (44 + sqrt(41^2 - 30^2), 20)."""
    made = moves(
        FK3.format(first=" Y-5.657", second=" Y+7.950", third=" X+71.946", fourth=" X-10.644", last=" X-40"),
        -40.0,
    )
    ends = [m.end[:2] for m in made]
    assert np.allclose(ends[:2], [(-32.0, 24.0), (-8.0, 56.0)])
    assert np.allclose(made[5].centre[:2], (6.0, math.sqrt(18**2 - 6**2)), atol=0.002)
    assert np.allclose(made[9].centre[:2], (44 + math.sqrt(41**2 - 30**2), 20.0), atol=0.002)
    assert np.allclose(ends[10:14], [(110, 15), (110, -15), (65, -15), (65, -25)])
    assert np.allclose(ends[-1], (-40, 0), atol=0.002)


def test_several_contours_are_told_and_strict_asks():
    """Example 2: a circle of R30 and one of R20, 55 mm apart, joined by lines at a distance of 10: 48 contours."""
    text = """9 FPOL X+30 Y+30
10 FC DR- R30 CCX+30 CCY+30
11 FL AN+60 PDX+30 PDY+30 D10{one}
12 FSELECT 3
13 FC DR- R20 CCPR+55 CCPA+60{two}
14 FSELECT 2
15 FL AN-120 PDX+30 PDY+30 D10{three}
16 FSELECT 3
17 FC X+0 DR- R30 CCX+30 CCY+30"""
    plain = text.format(one="", two="", three="")
    with pytest.raises(DataError, match=r"5:1: 48 free contours fit .FK.; FSELECT counts .* X35.482 Y59.495"):
        moves(plain, 0, 30)
    assert len(moves(plain, 0, 30, strict=False)) == 5
    # by pencil, t = (0.5, 0.866), n = (-0.866, 0.5) on its left: 30 + 10 n + sqrt(30^2 - 10^2) t; 30 + 10 n + (55 - sqrt(20^2 - 10^2)) t, then beside -n
    t, n = np.array([0.5, math.sqrt(0.75)]), np.array([-math.sqrt(0.75), 0.5])
    near, far = math.sqrt(800.0), 55.0 - math.sqrt(300.0)
    ends = [
        30 + 10 * n + near * t,
        30 + 10 * n + far * t,
        30 - 10 * n + far * t,
        30 - 10 * n + near * t,
        (0, 30),
    ]
    fixed = text.format(one=" X+40.179 Y+67.631", two=" X+57.5 Y+57.631", three=" X+52.802 Y+49.495").replace(
        "CCY+30\n11", "CCY+30 X+35.482 Y+59.495\n11"
    )
    check(fixed, *(tuple(p) for p in ends), x=0, y=30, tolerance=0.001)


@pytest.mark.parametrize(
    ("text", "ends"),
    [
        ("3 FL AN+30 LEN 20\n4 FL X+40 Y+0", [(20 * math.sqrt(0.75), 10), (40, 0)]),
        ("3 FL X+10 AN+45\n4 FL IAN-45 LEN 5", [(10, 10), (15, 10)]),  # IAN counts from the line before
        ("3 FL IX+10 IY+5\n4 FL IX+1 AN+90 LEN 0.5", "refused"),
        ("3 FPOL X+10 Y+10\n4 FL PR+20 PA+20", [(10 + 20 * math.cos(math.radians(20)), 10 + 20 * math.sin(math.radians(20)))]),
        ("3 FL X+10 Y+0\n4 FL X+10 Y+7\n5 FL IX+20 IY+3 RX 3 RY 4", [(10, 0), (10, 7), (30, 10)]),  # from the ends of blocks 3 and 4
        ("3 FL AN+0\n4 FL AN+90 P1X+12 P1Y+40 Y+20", [(12, 0), (12, 20)]),  # on the extension of the second line
        ("3 FL AN+0\n4 FL AN+90 PDX+10 PDY+3 D2 Y+20 X+12", [(12, 0), (12, 20)]),  # 2 mm beside (10, 3); X says on which side
        ("3 FL X+10 AN+0\n4 FCT DR+ R5 Y+10\n5 FLT X+0", [(10, 0), (10, 10), (0, 10)]),
        ("3 FL X+10 AN+0\n4 FCT DR+ R5 LEN 10\n5 FLT X+0", [(10, 0), (10, 10), (0, 10)]),  # the chord of half a circle
        ("3 FL AN+0\n4 FCT DR+ R5\n5 FLT AN+90 X+30 Y+20", [(25, 0), (30, 5), (30, 20)]),  # a fillet of 5 between Y0 and X30
        ("3 FC DR- CCX+10 CCY+0 X+20 Y+0", [(20, 0)]),
        ("3 FC DR- CCX+10 CCY+0 X+0 Y+0", [(0, 0)]),  # a full circle
        ("3 FPOL X+0 Y+0\n4 FC DR+ R10 CCPR+10 CCPA+90 X+10 Y+10", [(10, 10)]),
        ("3 FC DR- R10 AN+90 X+10 Y+10", [(10, 10)]),  # leaves upwards
    ],
)  # fmt: skip
def test_each_word_by_pencil(text, ends):
    if ends == "refused":
        with pytest.raises(DataError, match="no contour fits"):
            moves(text)
        return
    check(text, *ends)


def test_points_on_and_beside_the_contour():
    """Manual: FC DR- R10 P1X+42.929 P1Y+60.071, FLT AN-70 PDX+50 PDY+53 D10. P1 lies 10 mm from (50, 53), and so does the beginning (40, 53): that is
    the centre. The line at -70 deg touches at (50 + 10 cos 20, 53 + 10 sin 20), and goes on for 20."""
    c, s = math.cos(math.radians(20)), math.sin(math.radians(20))
    end = (50 + 10 * c + 20 * s, 53 + 10 * s - 20 * c)
    check(
        "3 FC DR- R10 P1X+42.929 P1Y+60.071\n4 FLT AN-70 PDX+50 PDY+53 D10 LEN20",
        (50 + 10 * c, 53 + 10 * s), end, x=40, y=53, tolerance=0.002,
    )  # fmt: skip


def test_corners_and_following_blocks_find_the_contour_done():
    """RND rounds between two elements; L goes on from the end."""
    got = moves("3 FL X+20 AN+0\n4 RND R2\n5 FL Y+10 AN+90\n6 L X+0 FMAX")
    assert np.allclose([m.end[:2] for m in got], [(18, 0), (20, 2), (20, 10), (0, 10)])
    assert got[-1].kind == "rapid"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("3 FL AN+30\n4 L X+10", "4:1: the free contour does not say where this line ends; add X or Y, LEN"),
        ("3 FL X+10 Y+10 FMAX", "4:1: a free contour is not run at FMAX"),
        ("3 FL\n4 FL X+10 Y+10 AN+0", "4:1: the free contour does not determine this line: its direction or place is open; add X, Y, PR, PA, AN"),
        ("3 FL X+10 Y+0\n4 FL AN+90 LEN5 PAR3", "no contour fits"),
        ("3 FC DR+ R10\n4 L X+10", "4:1: the free contour does not determine this arc: its centre or radius is open; add X, Y, CCX"),
        ("3 FL PR+20 PA+20", "4:1: polar coordinates of a free contour need FPOL"),
        ("3 FL X+10 Y+0\n4 FL PAR3 DP5 X+20 RX 9 IX+2", "X and IX stand in one block"),
        ("3 FL X+10 Y+0\n4 FL IX+2 RX 9 AN+0", "5:1: RX 9 names no block of a free contour before this one"),
        ("3 FL X+10 Y+0 DP3", "DP is the distance from a parallel line; add PAR"),
        ("3 FL X+10 Y+0 CLSD-", "no CLSD\\+ begins"),
        ("3 FC DR+ R5 CCA+90 X+5 Y+5", "CCA is the centre angle of an arc on later controls"),
        ("3 FL X+10 Y+0 Z-5", "FL takes no Z"),
        ("3 FL AN+30 LEN20 X+10", "4:1: no contour fits what the FK blocks of lines 4 to 4 say, beginning at X0 Y0"),
        ("3 FC DR+ R10 X+10 Y+0", "2 free contours fit"),
        ("3 FL X+10 Y+0 C+5", 'nothing in this block uses the word "C"'),
    ],
)  # fmt: skip
def test_what_is_open_or_contradicts_is_refused(text, message):
    with pytest.raises(DataError, match=message):
        moves(text)


def test_a_contour_cycle_follows_a_free_contour():
    """Cycle 25 along a label of FL blocks, 2 mm to their left."""
    text = (
        "3 CYCL DEF 14.0 CONTOUR\n4 CYCL DEF 14.1 CONTOUR LABEL1\n"
        "5 CYCL DEF 25 CONTOUR TRAIN Q1=-2 Q3=+0 Q5=+0 Q7=+10 Q10=-2 Q11=100 Q12=200 Q15=+1\n6 CYCL CALL\n7 M30\n"
        "8 LBL 1\n9 L X+0 Y+0 RL\n10 FL AN+0\n11 FL AN+90 X+20 Y+20\n12 LBL 0"
    )
    made = [m.end for m in moves(text, strict=False) if m.kind == "line"]
    assert np.allclose(made, [(0, 2, -2), (18, 2, -2), (18, 20, -2)])


def test_many_contours_are_told_soon():
    """Twelve half-known arcs have two centres each: 4096 contours, of which 64 are looked for."""
    text = "\n".join(f"{k + 3} FC DR+ R10 X{10 * (k + 1):+d} Y+0" for k in range(12))
    with pytest.raises(
        DataError,
        match=r"64 or more free contours fit .FK.: this element may have CCX\d+ CCY-8.66, CCX\d+ CCY8.66; add one",
    ):
        moves(text)
