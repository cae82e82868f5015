"""Work offsets, shifts, tool data, reference moves: positions by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from tests.program.meanings import ONE, ends, fanuc, linuxcnc
from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup, Tool


# -- positions ------------------------------------------------------------------------------------------------------------
def test_work_offset_and_tool_length():
    moves = linuxcnc("G21 T1 M6 G54\nG0 X0 Y0\nG43 H1 G0 Z5\nG55 G0 X1\n", ONE)
    assert moves[0].end[:2] == (100, 50)
    assert moves[1].end == (100, 50, -195)  # tip: offset -200 plus 5, the length taken off
    assert moves[1].tool_offset == (0, 0, 80)
    assert moves[1].start[2] == -80  # the axis stood at 0, so the tip of the 80 mm tool at -80
    assert moves[2].end == (11, 50, -195)
    assert moves[2].offset == "G55"


def test_further_offsets_and_local_shift():
    moves = fanuc("G21 G54.1 P3\nG0 X0. Y0. Z0.\nG52 X5.\nG0 X1.\nG52 X0.\nG0 X1.", ONE)
    assert ends(moves) == [(1, 2, 3), (7, 2, 3), (2, 2, 3)]


def test_g92_gives_the_present_position_a_value():
    moves = linuxcnc("G21 G0 X10 Y20\nG92 X0 Y0\nG0 X1 Y1\nG92.2\nG0 X1\nG92.3\nG0 X1\nG92.1\nG0 X1")
    assert [m.end[0] for m in moves] == [10, 11, 1, 11, 1]
    assert moves[1].end == (11, 21, 0)


def test_g10_sets_offsets_and_turns_them():
    moves = linuxcnc("G21 G10 L2 P1 X10 Y0 R90\nG0 X5 Y0\nG10 L20 P2 X100\nG55 G0 X101")
    assert moves[0].end == pytest.approx((10, 5, 0))  # 5 along the turned X, which points along Y
    # L20: the tip at machine X 10 reads 100 in G55, so its zero is at -90; X101 is at 11
    assert moves[1].end[0] == pytest.approx(11)


def test_g10_l20_under_a_rotation():
    moves = linuxcnc("G21 G0 X3 Y4\nG10 L2 P1 R90\nG10 L20 P1 X0 Y0\nG0 X5\nG0 Y1")
    # the tip at (3, 4) becomes the zero of a frame turned by 90 deg: X5 goes to (3, 9), Y1 from there to (2, 9)
    assert moves[1].end == pytest.approx((3, 9, 0))
    assert moves[2].end == pytest.approx((2, 9, 0))


def test_g10_enters_tools():
    moves = linuxcnc(
        "G21 G10 L1 P5 Z12 R3\nT5 M6 G43\nG0 Z0\nG49 G0 Z50\nG10 L10 P5 Z20\nG43\nG0 Z20\nG10 L1 P5 R2\nG41 D5\nG0 X30\nG1 X50 F100\nG40 G0 X60"
    )
    assert moves[0].tool_offset == (0, 0, 12)
    assert moves[2].tool_offset == (0, 0, 30)  # the axis at 50 reads 20
    assert moves[-2].end == pytest.approx((50, 2, 20))  # left of +X by the radius of 2


def test_g68_turns_about_a_centre():
    moves = fanuc("G21\nG68 X10. Y0. R90.\nG0 X15. Y0.\nG69\nG0 X15. Y0.")
    assert moves[0].end == pytest.approx((10, 5, 0))
    assert moves[1].end == (15, 0, 0)


def test_reference_moves_go_by_way_of_the_programmed_point():
    setup = replace(ONE, reference=(0.0, 0.0, 5.0))
    moves = fanuc("G21 T1 M6\nG43 H1 G0 Z10.\nG91 G28 Z2.\nG90 G0 X0.", setup)
    # tip at -190, up by 2, then the axis to its reference 5: the tip of the 80 mm tool at -75
    assert [m.end[2] for m in moves] == [-190, -188, -75, -75]
    assert [m.rewritable for m in moves] == [True, False, False, True]


def test_g0_g91_g28_in_one_block():
    moves = fanuc("G21 G0 X5. Z50.\nG0 G91 G28 Z0\nX1.")
    assert ends(moves) == [(5, 0, 50), (5, 0, 0), (6, 0, 0)]


def test_machine_coordinates():
    moves = linuxcnc("G21 G0 X1\nG53 G0 X0 Z0\nG0 X1", ONE)
    assert [m.end[0] for m in moves] == [101, 0, 101]
    assert [m.rewritable for m in moves] == [True, False, True]


@pytest.mark.parametrize(("dialect", "orientation"), [("linuxcnc", 2), ("fanuc-lathe", 3)])
def test_a_turning_tool_is_led_by_its_imaginary_tip(dialect: str, orientation: int):
    """Nose 0.5 mm, tip towards -X -Z: along a cylinder the tip stays on it; along a 45 deg cone it stands 1 - 0.5 sqrt 2 inside, in X + Z."""
    setup = Setup(tools={1: Tool(1, 0.0, shape="turning", nose_radius=0.5, orientation=orientation)})
    if dialect == "linuxcnc":
        text = "G21 G18 G8 F100 T1 M6\nG0 X8 Z5\nG42\nG0 X10 Z2\nG1 Z-10\nX20 Z-20\nG40 G0 X30 Z-19\nM2"
    else:
        text = "G21 G18 G98 F100. T0101\nG0 X16. Z5.\nG42 D1\nG0 X20. Z2.\nG1 Z-10.\nX40. Z-20.\nG40 G0 X60. Z-19.\nM30"
    moves = [m for m in interpret(text, dialect, setup).moves if m.compensation and m.kind == "line"]
    assert moves[0].end[0] == pytest.approx(10)  # centre at 10.5, tip half a millimetre below
    # centre line of the cone x = -z is shifted by 0.5 outwards (to +X +Z): x + z = 0.5 sqrt 2; the tip by 1 less
    assert moves[-1].end[0] + moves[-1].end[2] == pytest.approx(0.5 * math.sqrt(2) - 1)


def test_a_length_offset_changed_by_h_alone_keeps_g43():
    """Fanuc: while G43 is in effect an H by itself takes the other length; after G49 it does nothing."""
    setup = replace(ONE, tools={1: Tool(1, 80.0, 10.0), 2: Tool(2, 30.0, 10.0)})
    moves = fanuc("G21 T1 M6\nG43 H1 G0 Z10.\nH2 Z10.\nG49 Z10.\nH1 Z10.", setup)
    tips = [m.end[2] + m.tool_offset[2] for m in moves]
    assert [m.tool_offset[2] for m in moves] == [80, 30, 0, 0]
    assert tips[1] - tips[0] == pytest.approx(-50)


def test_limits_of_a_zone_are_no_way():
    """Fanuc: G22 X Y Z I J K states a zone that the tool may not enter; nothing moves."""
    made = fanuc("G21 G0 X1. Y2. Z3.\nG22 X10. Y10. Z0 I0 J0 K-10.\nG1 X5. F100.")
    assert [m.end for m in made] == [(1, 2, 3), (5, 2, 3)]
    for dialect, block in (("fanuc-lathe", "G50.1 X0"), ("haas", "G102 X0 Z9.")):
        text = f"G21 G0 X2. Z3.\n{block}\nX4.\nM30\n"
        assert {m.source.line for m in interpret(text, dialect, Setup(strict=False)).moves} == {1, 3}


def test_a_turn_about_an_axis_in_space_is_told():
    text = "G21 G90 G0 X1. Y2. Z3.\nG68 X0 Y0 Z0 I1. J0 K0 R30.\nX5.\nM30\n"
    program = interpret(text, "fanuc", Setup(strict=False))
    assert [m.end for m in program.moves] == [(1, 2, 3), (5, 2, 3)]
    assert [(a.line, a.value) for a in program.assumed] == [(2, "passed over: nothing is turned")]
    with pytest.raises(DataError, match=r"2:1: G68 with I J K turns about an axis in space"):
        interpret(text, "fanuc", Setup())
