"""Klartext programs: every feature by a number made by hand, refusals by name and place, the sample programs."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from tests.conftest import data_file
from vcmm.core.errors import DataError, ModelLimit
from vcmm.nc.heidenhain.reader import read, tokenize
from vcmm.nc.setup import Setup, Tool

SETUP = Setup(
    offsets={"G54": (0.0, 0.0, 0.0), "G55": (100.0, 50.0, -10.0)},
    tools={5: Tool(5, diameter=10.0), 2: Tool(2, length=80.0, diameter=6.0, name="MILL_6")},
)
S = math.sqrt(0.5)


def moves(text, setup=SETUP, unit="MM"):
    return read(f"BEGIN PGM T {unit}\n{text}\nEND PGM T {unit}\n", "part.h", setup).moves


def ends(text, **more):
    return np.array([m.end for m in moves(text, **more)])


def check(text, *points, **more):
    got = ends(text, **more)
    assert got.shape == (len(points), 3), got
    assert np.allclose(got, points, atol=1e-9), got


def test_tokens_are_lossless():
    text = '1 BEGIN PGM A MM\r\n2 L X+Q12 IY-2,5 R0 FMAX M3 ; note ~\n3 ;a\rb\r\nTOOL CALL "A B" Z§\n'
    assert "".join(t.text for t in tokenize(text)) == text


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


def test_approach_and_departure_on_lines():
    frame = "TOOL CALL 5 Z\nL X-30 Y-30 FMAX\nAPPR {} RL F100\nL Y+50\nDEP {}"
    # first element along +y from (0, 0): PH 10 before it, the tool 5 to the left; the way to it at rapid, depth at PH
    check(
        frame.format("LT X+0 Y+0 Z-2 LEN10", "LT LEN10"),
        (-30, -30, 0), (-5, -10, 0), (-5, -10, -2), (-5, 0, -2), (-5, 50, -2), (-5, 60, -2),
    )  # fmt: skip
    check(
        frame.format("LN X+0 Y+0 LEN10", "LN LEN10"),  # across: 10 + 5 away
        (-30, -30, 0), (-15, 0, 0), (-5, 0, 0), (-5, 50, 0), (-15, 50, 0),
    )  # fmt: skip
    got = moves(frame.format("LT X+0 Y+0 Z-2 LEN10", "LT LEN10"))
    assert [m.kind for m in got] == ["rapid", "rapid", "rapid", "line", "line", "line"]
    assert got[-1].compensation is None
    assert got[-2].compensation == "left"
    assert all(a.end == b.start for a, b in pairwise(got))


def test_approach_and_departure_on_arcs():
    # the centre path begins at (-5, 0); R = 8 to the left of it: centre (-13, 0). CCA 90: from (-13, -8), counterclockwise
    got = moves("TOOL CALL 5 Z\nL X-30 Y-30 FMAX\nAPPR CT X+0 Y+0 CCA90 R8 RL F100\nL Y+50\nDEP CT CCA90 R8")
    assert np.allclose(
        [m.end for m in got], [(-30, -30, 0), (-13, -8, 0), (-5, 0, 0), (-5, 50, 0), (-13, 58, 0)], atol=1e-9
    )
    assert [m.centre for m in got if m.kind == "arc"] == [(-13, 0, 0), (-13, 50, 0)]
    assert [m.clockwise for m in got if m.kind == "arc"] == [False, False]
    other = moves("TOOL CALL 5 Z\nL X-30 Y-30 FMAX\nAPPR CT X+0 Y+0 CCA90 R-8 RL F100\nL Y+50\nDEP LN LEN5")
    assert np.allclose(other[2].centre, (3, 0, 0), atol=1e-9)  # on the other side: -5 + 8
    assert other[2].clockwise is True


def test_approach_and_departure_on_line_and_arc():
    # centre of the arc (-13, 0), R = 8, start (-13 - 8 sqrt 2, 0 - ...): from (-33, -8) the line y = -8 touches the circle below
    got = moves(
        "TOOL CALL 5 Z\nL X-33 Y-8 FMAX\nAPPR LCT X+0 Y+0 R8 RL F100\nL Y+50\nDEP LCT X-33 Y+58 Z+9 R8"
    )
    assert np.allclose(
        [m.end for m in got],
        [(-33, -8, 0), (-13, -8, 0), (-5, 0, 0), (-5, 50, 0), (-13, 58, 0), (-33, 58, 0), (-33, 58, 9)], atol=1e-9,
    )  # fmt: skip
    assert [m.kind for m in got] == ["rapid", "line", "arc", "line", "arc", "line", "line"]


def test_tools():
    program = read(
        'TOOL CALL "MILL_6" Z S2000 DL+0.5\nL Z+0 FMAX M3\nTOOL CALL S500\nL Z+1 FMAX', "part.h", SETUP
    )
    assert [m.tool_offset for m in program.moves] == [(0, 0, 80.5)] * 2
    assert [m.spindle for m in program.moves] == [2000, 500]
    assert program.tools == {2: "MILL_6"}
    (one,) = moves("TOOL DEF 7 L+12 R+3\nTOOL CALL 7 Z\nL Z+0 FMAX")
    assert one.tool_offset == (0, 0, 12)


def test_tool_axis():
    (one,) = moves("TOOL CALL 2 Y\nCR Z+10 X+10 R+10 DR+ F100")
    assert (one.plane, one.tool_offset, one.start) == ("ZX", (0, 80, 0), (0, -80, 0))


def test_machine_coordinates_leave_out_the_tool_length():
    (one,) = moves("TOOL CALL 2 Z\nL Z-10 FMAX M91")
    assert one.end == (0, 0, -90)  # the axis stands at -10, the tip 80 mm below
    assert one.rewritable is False


def test_datum_shift_rotation_mirror_scale():
    shift = "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+100\nCYCL DEF 7.2 IY+20\n"
    check(
        shift + "L X+1 Y+2 FMAX\nCYCL DEF 7.0\nCYCL DEF 7.1 X+0\nCYCL DEF 7.2 Y+0\nL X+3 FMAX",
        (101, 22, 0),
        (3, 22, 0),
    )
    turned = (
        shift
        + "CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+90\nL X+10 Y+0 FMAX\nCYCL DEF 10.1 IROT-45\nL X+10 Y+0 FMAX"
    )
    check(turned, (100, 30, 0), (100 + 10 * S, 20 + 10 * S, 0))
    check(
        "CYCL DEF 8.0\nCYCL DEF 8.1 X\nL X+5 Y+1 FMAX\nCYCL DEF 8.0\nCYCL DEF 8.1\nL X+5 FMAX",
        (-5, 1, 0),
        (5, 1, 0),
    )
    check("CYCL DEF 11.0\nCYCL DEF 11.1 SCL 0.5\nL X+5 FMAX", (2.5, 0, 0))
    check("CYCL DEF 247 DATUM SETTING ~\n Q339=+2 ;DATUM NUMBER\nL X+1 Y+0 Z+0 FMAX", (101, 50, -10))


def test_dwell_and_tolerance():
    got = moves(
        "CYCL DEF 9.0 DWELL TIME\nCYCL DEF 9.1 DWELL 1.5\nCYCL DEF 32.0 TOLERANCE\nCYCL DEF 32.1 T0.05\nL X+1 FMAX"
    )
    assert got[0].seconds == 1.5
    assert got[1].tolerance == 0.05


DRILL = (
    "CYCL DEF 200 DRILLING ~\n Q200=2 ;SET-UP ~\n Q201=-15 ;DEPTH ~\n Q206=250 ;FEED ~\n Q202=10 ;PECK ~\n"
    " Q210=0 ;TOP ~\n Q203=+0 ;SURFACE ~\n Q204=20 ;2ND ~\n Q211=0.5 ;BOTTOM\n"
)


def test_drilling():
    # surface 0: clearance 2, to -10, out, back to 2 above, to -15, dwell, out to the second clearance 20
    got = moves(f"{DRILL}L X+30 Y+50 Z+50 FMAX M99\nL X+40 FMAX")
    assert [m.end[2] for m in got] == [50, 2, -10, 2, -8, -15, -15, 20, 20]
    assert [m.kind for m in got][:4] == ["rapid", "rapid", "line", "rapid"]
    assert {m.feed for m in got} == {None, 250}
    assert len(moves(f"{DRILL}L X+30 Z+50 FMAX\nCYCL CALL")) == 8
    assert len(moves(f"{DRILL}L X+30 Z+50 FMAX M89\nL X+40 FMAX\nL X+50 FMAX M99")) == 3 + 2 * 7


def test_q_parameters():
    text = (
        "FN 0: Q1 = +5\nFN 1: Q2 = +Q1 + +5\nFN 4: Q3 = +Q2 DIV +4\nFN 8: Q4 = +3 LEN +4\nFN 13: Q5 = +1 ANG-1\nFN 5: Q6 = SQRT 16\n"
        "FN 2: Q7 = +Q1 - +1\nFN 3: Q8 = +Q1 * +3\nL X+Q1 Y+Q2 Z-Q3 FMAX\nL X+Q4 Y+Q5 Z+Q6 FMAX\nL X+Q7 Y+Q8 FMAX"
    )
    check(text, (5, 10, -2.5), (5, 135, 4), (4, 15, 4))


@pytest.mark.parametrize(
    ("formula", "value"),
    [
        ("2 + 3 * 4", 14), ("( 2 + 3 ) * 4", 20), ("- 2 + 5", 3), ("2 ^ 3", 8), ("SIN 30 * 2", 1), ("SQRT ( 9 + 16 )", 5), ("SQ 3", 9),
        ("INT 2.7", 2), ("FRAC 2.75", 0.75), ("ABS - 4", 4), ("NEG 4", -4), ("ATAN 1", 45), ("10 - 4 - 3", 3), ("SGN -5", -1),
        ("7 % 4", 3), ("COS 60 ^ 2", 0.25), ("PI", math.pi), ("- 3 ^ 2", -9),
    ],
)  # fmt: skip
def test_formulas(formula, value):
    assert math.isclose(ends(f"Q1 = {formula}\nL X+Q1 FMAX")[0][0], value, rel_tol=1e-12)


def test_labels():
    check("CALL LBL 1\nL X+9 FMAX\nM30\nLBL 1\nL IX+1 FMAX\nLBL 0", (1, 0, 0), (9, 0, 0))
    check(
        'LBL "A"\nL IX+1 FMAX\nCALL LBL "A" REP 2/2\nL Y+5 FMAX', (1, 0, 0), (2, 0, 0), (3, 0, 0), (3, 5, 0)
    )
    jump = "Q1 = {}\nFN 9: IF +Q1 EQU +1 GOTO LBL 7\nL X+1 FMAX\nLBL 7\nL Y+1 FMAX"
    assert [len(ends(jump.format(n))) for n in (1, 2)] == [1, 2]
    loop = "LBL 3\nQ1 = Q1 + 1\nL X+Q1 FMAX\nFN 12: IF +Q1 LT +3 GOTO LBL 3"
    check(loop, (1, 0, 0), (2, 0, 0), (3, 0, 0))


def test_present_position():
    check("L X+7 FMAX\nFN 18: SYSREAD Q3 = ID270 NR1 IDX1\nL Y+Q3 FMAX", (7, 0, 0), (7, 7, 0))


def test_end_of_program():
    assert len(moves("L X+1 FMAX\nL X+2 FMAX M30\nL X+3 FMAX")) == 2


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("PLANE SPATIAL SPA+0 SPB+45 SPC+0", "part.h:2:1: PLANE is not understood"),
        ("1 L X+1 FMAX M128", "part.h:2:14: M128 is not understood"),
        ("CYCL DEF 251 RECTANGULAR POCKET", "part.h:2:10: CYCL DEF 251"),
        ("CALL PGM OTHER.H", "CALL PGM is not understood"),
        ("FN 18: SYSREAD Q1 = ID50 NR3 IDX1", "ID50 NR3 IDX1 is known to the machine only"),
        ("FN 14: ERROR = 1000", "FN 14 is not understood"),
        ("L X+1", "part.h:2:1: no feed"),
        ("L X+1 X+2 FMAX", "part.h:2:7: X stands twice"),
        ("L X FMAX", "part.h:2:5: X needs a number"),
        ("L X+1 LEN5 FMAX", "part.h:2:7: LEN is not understood"),
        ("CC X+0 Y+5\nC X+5 Y+5 F100", "needs the sense of rotation"),
        ("CC X+0 Y+5\nC X+6 Y+5 DR+ F100", "radius 5.0000 mm at its start, 6.0000 mm at its end"),
        ("CALL LBL 5", "there is no LBL 5"),
        ("LBL 1\nLBL 1", "part.h:3:1: LBL 1 stands twice"),
        ("LBL 1\nFN 9: IF +1 EQU +1 GOTO LBL 1", "seems to be endless"),
        ("CYCL CALL", "none is defined"),
        ("Q1,5 = 3", "Q1,5 is no Q parameter"),
        ("L X+1 RL F100", "no known radius"),
        ("Q1 = 1 / 0", "part.h:2:8: division by zero"),
        ("CT X+5 Y+5 F100", "needs a contour element before it"),
        ("APPR LT X+0 Y+0 LEN10 F100", "APPR needs the side of the tool"),
        ("CYCL DEF 10.0\nCYCL DEF 10.1 ROT+30\nCYCL DEF 7.0\nCYCL DEF 7.1 X+5", "shift first, then rotate"),
    ],
)  # fmt: skip
def test_refused_by_name_and_place(text, message, monkeypatch):
    monkeypatch.setattr("vcmm.nc.heidenhain.reader.LONGEST", 1000)
    with pytest.raises(DataError, match=message):
        moves(text)


def test_approach_without_contour():
    with pytest.raises(ModelLimit, match=r"part.h:3:1: APPR is not followed by a contour element"):
        moves("TOOL CALL 5 Z\nAPPR LT X+20 Y+0 LEN10 RL F100")


# The sample programs.


def sample(name):
    return data_file(f"data/nc/gpl_test_only/heidenhain_{name}.h").read_bytes().decode()


@pytest.mark.parametrize("name", ["CIRSTUD", "PROFILE", "metrologia_11"])
def test_samples_are_lossless(name):
    assert "".join(t.text for t in tokenize(sample(name))) == sample(name)


def test_sample_from_a_cam_system():
    program = read(sample("metrologia_11"), "part.h", Setup())
    lines = sample("metrologia_11").count(" L ") - 2  # two of them hold nothing but M03
    arcs = sample("metrologia_11").count(" C X")
    assert len([m for m in program.moves if m.kind in ("rapid", "line")]) == lines
    assert len([m for m in program.moves if m.kind == "arc"]) == arcs
    assert [m.seconds for m in program.moves if m.kind == "dwell"] == [5.0, 5.0]
    assert all(np.allclose(a.end, b.start) for a, b in pairwise(program.moves) if a.tool == b.tool)


def test_sample_with_approach_along_a_tangent():
    program = read(sample("PROFILE"), "part.h", Setup(tools={1: Tool(1, diameter=10.0)}))
    # the operator's positions are not known: all corners fall on (7, 7), (-7, -7): the square, right-hand, one radius outside
    box = np.array([m.end[:2] for m in program.moves if m.compensation])
    assert np.allclose(np.abs(box).max(axis=0)[1], 12)
    assert [m.kind for m in program.moves].count("arc") == 3


@pytest.mark.parametrize("end", ["STOP M30", "STOP M2", "M30", "L FMAX M2"])
def test_the_program_ends_where_it_says(end):
    """STOP with M2 or M30 ends the program as a block of its own does: what follows is not run."""
    (one,) = moves(f"L X+10 F100\n{end}\nLBL 1\nL X+99\nLBL 0")[:1]
    assert one.end == (10, 0, 0)
    assert all(m.end[0] == 10.0 for m in moves(f"L X+10 F100\n{end}\nLBL 1\nL X+99\nLBL 0"))


def test_a_stop_without_an_end_goes_on():
    assert [m.end[0] for m in moves("L X+10 F100\nSTOP M5\nL X+99\nSTOP\nL X+0")] == [10, 99, 0]
