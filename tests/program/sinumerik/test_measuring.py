"""MEAS: the probe stops where the set-up states a surface, and $AA_MW, $AA_MM, $AC_MEA say where."""

from __future__ import annotations

import math

import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup, Tool
from vcmm.program.touching import Face, Round, box_faces

BOX = box_faces((50.0, 20.0, -230.0), (100.0, 60.0, 30.0))
TOOLS = {9: Tool(9, length=120.0, diameter=6.0, shape="probe")}
SETUP = Setup(offsets={"G54": (100.0, 50.0, -200.0)}, tools=TOOLS, surfaces=BOX)
HEAD = "G17 G71 G90 G94 G54\nT9 M6\nG0 X-70 Y0\nZ-5\n"


def test_the_program_shifts_its_zero_by_what_it_reads():
    # face at X-50, the ball stops at -53: G54 X from 100 by -53 + 3 + 50 = 0; Z reads -5 in the work, -205 + 120 on the axis
    text = (
        HEAD
        + "MEAS=1 G1 X-40 F100\nR1=$AA_MW[X]\nR2=$AA_MM[Z]\nR3=$AC_MEA[1]\nG0 X=R1-10\nZ=R2 \nY=R3\n$P_UIFR[1,X,TR]=100+R1+53.5\nG0 X0\nM30"
    )
    found = interpret(text, "sinumerik", SETUP)
    assert found.touches[0].tip == (47.0, 50.0, -205.0)
    assert [m.end for m in found.moves[-4:]] == [
        (37, 50, -205),
        (37, 50, -285),
        (37, 51, -285),
        (100.5, 51, -285),
    ]


def test_the_zero_is_read_as_it_stands():
    found = interpret(HEAD + "$P_UIFR[1,X,TR]=$P_UIFR[1,X,TR]+0.5\nG0 X0\nM30", "sinumerik", SETUP)
    assert found.moves[-1].end[0] == 100.5


def test_a_way_that_meets_nothing_goes_to_its_end():
    found = interpret(HEAD + "MEAS=1 G1 X-100 F100\nM30", "sinumerik", SETUP)
    assert found.moves[-1].end[0] == 0.0
    assert "meets no surface" in found.warnings[-1].text


def test_without_surfaces_the_set_up_is_asked():
    with pytest.raises(DataError, match=r"MEAS=1 \(measuring\): where the probe stops"):
        interpret(HEAD + "MEAS=1 G1 X-40 F100\nM30", "sinumerik", Setup(tools=TOOLS))
    told = interpret(HEAD + "MEAS=1 G1 X-40 F100\nM30", "sinumerik", Setup(tools=TOOLS, strict=False))
    assert told.assumed[0].what == "MEAS=1 (measuring)"


def test_meaw_keeps_where_it_answered_and_goes_on():
    found = interpret(HEAD + "MEAW=1 G1 X-45 F100\nR1=$AA_MW[X]\nG0 Y=R1\nM30", "sinumerik", SETUP)
    assert [m.end[:2] for m in found.moves[-3:]] == [(47, 50), (55, 50), (55, -3)]


BORE = Round((101.0, 51.0, 0.0), 15.02, inside=True)  # 1 mm beside the middle in X and Y, 0.04 mm wide
IN_BORE = Setup(offsets={**SETUP.offsets, "G505": (7.0, 8.0, 9.0)}, tools=TOOLS, surfaces=(BORE,))
MIDDLE = HEAD.replace("X-70", "X0")


@pytest.mark.parametrize(
    "call",
    [
        'CYCLE977(101,9000,,1,30,,,5,5,0,-6,,,1,1,"",,0,1.01,1.01,-1.01,0.34,1,0,,1,1)',
        "_MVAR=101 _SETVAL=30 _KNUM=1 _PRNUM=1 _FA=5 _TSA=5 _NMSP=1\nCYCLE977",
        "_MVAR=101 _SETVAL=30 _KNUM=1 _FA=5 _CPA=0 _CPO=0 _STA1=10 _INCA=100 _NUM=3\nCYCLE979",
    ],
)
def test_the_middle_of_a_bore_becomes_the_zero(call):
    # the middle found at X1 Y1 is to read X0 Y0: G54 goes from (100, 50) to (101, 51); _OVR[4] is the diameter, [16] its difference
    found = interpret(MIDDLE + call + "\nG0 X0 Y0\nX=_OVR[4] Y=_OVR[16]*100\nM30", "sinumerik", IN_BORE)
    assert found.moves[-2].end[:2] == pytest.approx((101.0, 51.0), abs=1e-9)
    assert found.moves[-1].end[:2] == pytest.approx((101.0 + 30.04, 51.0 + 4.0), abs=1e-7)


def test_a_bore_round_an_island_is_touched_from_beside_its_wall():
    """_MVAR 1101: over the island (here Z3), beside the wall 15 - (3 the ball + 5 _FA) = 7 mm from the middle, 8 mm down, and up again.
    Plus X at Y0: the wall of radius 15.02 about (1, 1) stops the ball at X 1 + sqrt((15.02 - 3)^2 - 1^2) = 12.97833."""
    call = "CYCLE977(1101,9000,,1,30,,,5,5,0,-8)\nG0 X0 Y0\nM30"
    found = interpret(MIDDLE.replace("Z-5", "Z3") + call, "sinumerik", IN_BORE)
    ways = [(m.kind, *m.end) for m in found.moves if m.source.line == 5][:6]
    assert ways[:2] == [("rapid", 107.0, 50.0, -197.0), ("rapid", 107.0, 50.0, -205.0)]
    assert ways[2] == ("line", pytest.approx(112.97833, abs=1e-5), 50.0, -205.0)
    assert ways[3:] == [("line", 107, 50, -205), ("rapid", 107, 50, -197), ("rapid", 100, 50, -197)]
    assert found.moves[-1].end[:2] == pytest.approx((101.0, 51.0), abs=1e-9)


def test_ways_that_go_nowhere_are_no_moves():
    found = interpret(MIDDLE + "CYCLE977(101,9000,,1,30,,,5,5)\nM30", "sinumerik", IN_BORE)
    assert all(m.start != m.end for m in found.moves)
    assert (
        sum(m.source.line == 5 for m in found.moves) == 10
    )  # four touches and back, over the middle found and back from it


def test_only_measured_or_another_offset_corrected():
    found = interpret(MIDDLE + "CYCLE977(1,0,,1,30,,,5,5)\nG0 X0 Y=_OVR[17]\nM30", "sinumerik", IN_BORE)
    assert found.moves[-1].end[:2] == pytest.approx((100.0, 51.0), abs=1e-9)
    found = interpret(MIDDLE + "CYCLE977(101,10005,,1,30,,,5,5)\nG505 G0 X0 Y0 Z0\nM30", "sinumerik", IN_BORE)
    assert found.moves[-1].end == pytest.approx((101.0, 51.0, 9.0), abs=1e-9)


def test_a_web_and_a_rectangle_from_outside():
    # the stock: X -50 to 50, Y -30 to 30 of the work; from (1, 2) over it, 8 mm down
    over = HEAD.replace("X-70 Y0", "X1 Y2").replace("Z-5", "Z3")
    found = interpret(
        over + "CYCLE977(104,9000,,1,99,,,5,5,0,-8,,,1,1)\nG0 X0 Y=_OVR[4]\nM30", "sinumerik", SETUP
    )
    assert [t.tip for t in found.touches] == [(153.0, 52.0, -205.0), (47.0, 52.0, -205.0)]
    # the middle 0 is to read 1: the zero 1 mm back; 100 wide
    assert found.moves[-1].end[:2] == pytest.approx((99.0, 150.0))
    found = interpret(
        over + "CYCLE977(106,9000,,1,,99,61,5,5,0,-8)\nG0 X0 Y0\nX=_OVR[4] Y=_OVR[5]\nM30", "sinumerik", SETUP
    )
    assert found.moves[-2].end[:2] == pytest.approx((99.0, 48.0))
    assert found.moves[-1].end[:2] == pytest.approx((199.0, 108.0))


@pytest.mark.parametrize(
    "call",
    ["CYCLE978(100,9000,,1,-50.4,5,5,1,1,1)", "_MVAR=100 _KNUM=1 _SETVAL=-50.4 _FA=5 _MA=1 _MD=0\nCYCLE978"],
)
def test_a_single_surface_shifts_the_zero(call):
    # at -50, to read -50.4: G54 X from 100 to 100.4
    found = interpret(HEAD + call + "\nG0 X0\nY=_OVR[16]\nM30", "sinumerik", SETUP)
    assert found.moves[-1].end[:2] == pytest.approx((100.4, 50.4))


@pytest.mark.parametrize(("which", "start", "sense"), [("102", "X-10 Y-45", 1), ("201", "X-65 Y-10", 1)])
def test_an_edge_turns_the_zero(which, start, sense):
    # the part is turned by 0.01 rad about (50, 20, -200), X-50 Y-30 of the work: G54 is turned as much about its zero
    c, s = math.cos(0.01), math.sin(0.01)
    faces = (Face((50.0, 20.0, -200.0), (-c, -s, 0.0)), Face((50.0, 20.0, -200.0), (s, -c, 0.0)))
    setup = Setup(offsets=SETUP.offsets, tools=TOOLS, surfaces=faces)
    where = "-30" if which == "102" else "-50"
    text = (
        HEAD.replace("X-70 Y0", start)
        + f"CYCLE998(105,9000,0,1,{where},0,,10,5,{which},0,20)\nG0 X100 Y0\nZ=_OVR[4]\nM30"
    )
    found = interpret(text, "sinumerik", setup)
    assert found.moves[-1].end[:2] == pytest.approx((100.0 + 100.0 * c, 50.0 + 100.0 * s), abs=1e-9)
    assert found.moves[-1].end[2] == pytest.approx(-200.0 + math.degrees(0.01), abs=1e-9)


def test_what_measuring_cycles_do_not_do_is_said_by_line():
    for call, message in (
        (
            "CYCLE977(101,9000,,1,30,,,5,0.5)",
            r"5:1: CYCLE977: what it finds lies 1 mm off, more than the safe area _TSA = 0\.5",
        ),
        ("CYCLE977(101,9000,,1)", "it needs S_SETV, the diameter"),
        ("CYCLE977(109,9000,,1,30)", "last digit is 1 to 6"),
        ("CYCLE977(301,1,,1,30,,,5,5)", "corrects a tool"),
        ("CYCLE977(101,1000,,1,30,,,5,5)", "basic or system frame"),
        ("CYCLE998(105,9000,6,1,-30,0,,10,5,102,0,20)", "_RA turns a rotary axis"),
        ("CYCLE998(106,9000,0,1,-30,0,,10,5,102,0,20)", "known is the angle of one edge"),
        ("CYCLE979(101,9000,,1,30,5,5,0,0,0,90)", "not with arguments in brackets"),
        ("CYCLE978(100,9000,,1,-50,5,5,4,1,1)", "_MA = 4 must be 1, 2 or 3"),
    ):
        with pytest.raises(DataError, match=message):
            interpret(MIDDLE + call + "\nM30", "sinumerik", IN_BORE)


def test_calibrating_is_passed_over():
    found = interpret(HEAD + "CYCLE976(101,1000,,1,30)\nM30", "sinumerik", SETUP)
    assert not found.touches
    assert "calibrates the probe" in found.warnings[-1].text


@pytest.mark.parametrize(
    "surface", [Face((100.0, 50.0, -230.0), (0.0, 0.0, -1.0)), Face((900.0, 0.0, 0.0), (1.0, 0.0, 0.0))]
)
def test_from_below_the_reading_is_the_ball_below_the_surface(surface):
    """Face at Z-30, ball of 6 mm: its top meets it when the tip stands at Z-36, so G54 goes from -200 by -36 + 30 to -206. The same
    where no face is stated there and the program expects it."""
    text = HEAD + "Z-50\n_MVAR=100 _KNUM=1 _SETVAL=-30 _FA=10 _MA=3 _MD=0\nCYCLE978\nG0 Z0\nM30"
    found = interpret(
        text, "sinumerik", Setup(offsets={"G54": (100.0, 50.0, -200.0)}, tools=TOOLS, surfaces=(surface,))
    )
    assert found.touches[0].tip == (30.0, 50.0, -236.0)
    assert found.moves[-1].end[2] == pytest.approx(-206.0, abs=1e-9)
    assert any("6 mm (the ball) below the surface" in w.text for w in found.warnings)
