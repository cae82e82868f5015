"""The language, feature by feature, with numbers worked out by hand."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from vcmm.nc.interpret import interpret
from vcmm.nc.moves import Move
from vcmm.nc.setup import Setup, Tool
from vcmm.nc.summary import arc_angle, move_length

ONE = Setup(
    offsets={"G54": (100.0, 50.0, -200.0), "G55": (10.0, 20.0, 30.0), "G54.1 P3": (1.0, 2.0, 3.0)},
    tools={1: Tool(1, 80.0, 10.0), 2: Tool(2, 100.0, 6.0)},
)


def linuxcnc(text: str, setup: Setup | None = None) -> tuple[Move, ...]:
    return interpret(f"{text}\nM2", "linuxcnc", setup).moves


def fanuc(text: str, setup: Setup | None = None) -> tuple[Move, ...]:
    return interpret(f"{text}\nM30", "fanuc", setup).moves


def ends(moves: tuple[Move, ...]) -> list[tuple[float, ...]]:
    return [m.end for m in moves]


# -- arcs ---------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("text", "plane", "centre", "end", "clockwise", "angle"),
    [
        ("G17 G2 X10 Y0 I5 J0", "XY", (5, 0, 0), (10, 0, 0), True, math.pi),
        ("G17 G3 X0 Y10 I0 J5", "XY", (0, 5, 0), (0, 10, 0), False, math.pi),
        ("G18 G2 Z10 X0 K5 I0", "ZX", (0, 0, 5), (0, 0, 10), True, math.pi),
        ("G19 G3 Y10 Z0 J5 K0", "YZ", (0, 5, 0), (0, 10, 0), False, math.pi),
        (
            "G17 G2 X10 Y10 R10",
            "XY",
            (10, 0, 0),
            (10, 10, 0),
            True,
            math.pi / 2,
        ),  # quarter: centre below the end
        ("G17 G2 X10 Y10 R-10", "XY", (0, 10, 0), (10, 10, 0), True, 1.5 * math.pi),  # three quarters
        ("G17 G3 X10 Y10 R10", "XY", (0, 10, 0), (10, 10, 0), False, math.pi / 2),
        ("G17 G2 I5", "XY", (5, 0, 0), (0, 0, 0), True, 2 * math.pi),  # full circle without an end point
        ("G17 G3 X0 Y0 I5 P3", "XY", (5, 0, 0), (0, 0, 0), False, 6 * math.pi),  # three turns
        ("G90.1 G17 G2 X10 Y0 I5 J0", "XY", (5, 0, 0), (10, 0, 0), True, math.pi),
    ],
)
def test_arcs(
    text: str, plane: str, centre: tuple[float, ...], end: tuple[float, ...], clockwise: bool, angle: float
):
    (move,) = linuxcnc(f"G21 F100\n{text}")
    assert (move.kind, move.plane, move.clockwise) == ("arc", plane, clockwise)
    assert move.centre == pytest.approx(centre)
    assert move.end == pytest.approx(end)
    assert arc_angle(move) == pytest.approx(angle)


def test_a_helix_rises_along_the_normal():
    (move,) = linuxcnc("G21 F100 G3 X0 Y0 Z4 I10 P2")
    assert move.end == (0, 0, 4)
    assert move.turns == 2
    # two turns of radius 10 and a rise of 4: sqrt((40 pi)^2 + 16) = 125.727...
    assert move_length(move) == pytest.approx(math.sqrt((40 * math.pi) ** 2 + 16))


def test_a_small_difference_of_the_radii_is_remarked_in_um():
    found = interpret("G21 F100\nG2 X10.005 Y0 I5 J0\nM2", "linuxcnc")
    assert found.moves[0].end == (10.005, 0, 0)  # radii 5.000 and 5.005: 5 um
    assert found.moves[0].centre == (5, 0, 0)
    assert "differ by 5.0 um" in found.warnings[0].text
    assert not interpret("G21 F100\nG2 X10.0005 Y0 I5 J0\nM2", "linuxcnc").warnings  # 0.5 um


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


def test_a_rotary_axis_alone_turns_in_degrees_per_minute():
    assert linuxcnc("G20 F90\nG1 A180")[0].feed == 90


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


def test_lathe_diameters_in_linuxcnc():
    moves = linuxcnc("G21 G18 G7 F100\nG0 X20 Z0\nG8 G0 X20")
    assert [m.end[0] for m in moves] == [10, 20]


def test_rotary_axes_are_kept_in_rad():
    (move,) = linuxcnc("G21 G0 A90 C180")
    assert move.rotary_end == pytest.approx((math.pi / 2, 0, math.pi))
    assert move.end == move.start


# -- feeds and spindle ------------------------------------------------------------------------------------------------
def test_feeds():
    moves = linuxcnc("G21 S1000 M3\nG95 F0.2 G1 X10\nG93 G1 X20 F2\nG94 F300 G1 X30\nG20 F10 G1 X2")
    # 0.2 mm per turn x 1000; 10 mm in half a minute; 300; 10 inch/min
    assert [m.feed for m in moves] == pytest.approx([200, 20, 300, 254])
    assert moves[0].spindle == 1000


def test_constant_cutting_speed_with_its_limit():
    moves = linuxcnc("G21 G18 G8 G96 D2000 S100 M4 G95 F0.1\nG0 X20\nG1 Z-1\nG0 X1\nG1 Z-2")
    # 100 m/min on radius 20: 100e3 / (2 pi 20) = 795.77 turns/min; on radius 1 15915, limited to 2000
    assert [m.spindle for m in moves if m.kind == "line"] == pytest.approx([-795.7747, -2000])
    assert [m.feed for m in moves if m.kind == "line"] == pytest.approx([79.57747, 200])


def test_dwell_in_ms_and_s():
    assert [m.seconds for m in fanuc("G4 P500\nG4 X1.5\nG4 U2.")] == [0.5, 1.5, 2.0]
    assert [m.seconds for m in linuxcnc("G4 P0.5")] == [0.5]


def test_path_control():
    moves = linuxcnc("G21 F100 G64 P0.02\nG1 X1\nG61 X2\nG64 X3")
    assert [(m.exact_stop, m.tolerance) for m in moves] == [(False, 0.02), (True, None), (False, None)]
    assert [m.exact_stop for m in fanuc("G1 X1. F100.\nG9 X2.\nX3.")] == [False, True, False]


def test_threads():
    (move,) = linuxcnc("G21 S500 M3\nG33 Z-10 K1.5")
    assert (move.kind, move.feed) == ("thread", 750)


def test_threading_cycle_depths():
    # J 0.2, equal areas: 0.2, 0.2 sqrt 2 = 0.283, 0.2 sqrt 3 = 0.346, then the full 0.4 and one spring pass
    moves = linuxcnc("G21 S500 M3 G18 G8\nG0 X10 Z2\nG76 P1 Z-10 I-1 J0.2 K0.4 R2 H1")
    cuts = [m for m in moves if m.kind == "thread"]
    assert [m.end[0] for m in cuts] == pytest.approx([8.8, 9 - 0.2 * 2**0.5, 9 - 0.2 * 3**0.5, 8.6, 8.6])
    assert [m.end[0] for m in moves if m.kind == "rapid"][1] == pytest.approx(10.2)  # depth 8.8 + 1 + 0.4
    assert moves[-1].end == pytest.approx((10, 0, -10))


def test_threading_cycle_along_the_flank_and_with_a_taper():
    # tan 29.5 deg = 0.565773: the first pass, 0.2 deep, begins 0.113155 further on and ends 0.2 x 0.565773 before Z
    moves = linuxcnc("G21 S500 M3 G18 G8\nG0 X10 Z2\nG76 P1 Z-10 I-1 J0.2 K0.4 R2 Q29.5 E1 L2")
    first = [(m.kind, *(round(v, 4) for v in (m.end[0], m.end[2]))) for m in moves[1:6]]
    assert first == [
        ("rapid", 10.2, 1.8868), ("rapid", 8.8, 1.8868), ("thread", 8.8, -8.8868), ("thread", 9.2, -9.8868), ("rapid", 10.2, -9.8868),
    ]  # fmt: skip
    # the pitch counts along Z: 1 mm x sqrt(1 + 0.4^2) = 1.07703 per turn on the taper, 500 turns/min
    assert [m.feed for m in moves[3:5]] == pytest.approx([500, 538.516], abs=1e-3)


# -- cycles -------------------------------------------------------------------------------------------------------------
def test_pecks_of_fanuc():
    moves = fanuc("G21 G90 G99 G0 X0. Y0. Z50.\nG83 X10. Z-5. R2. Q3. F100.\nG80")
    # R 2: pecks to -1, -4, -5; back to 0.5 above the depth reached
    assert [(m.kind, m.end[2]) for m in moves[1:]] == [
        ("rapid", 50), ("rapid", 2), ("line", -1), ("rapid", 2), ("rapid", -0.5), ("line", -4), ("rapid", 2),
        ("rapid", -3.5), ("line", -5), ("rapid", 2),
    ]  # fmt: skip


def test_chip_breaking_and_initial_level():
    moves = fanuc("G21 G90 G98 G0 X0. Y0. Z50.\nG73 X10. Z-3. R2. Q3. F100.\nX20.\nG80")
    first = [m.end[2] for m in moves[1:7]]
    assert first == [50, 2, -1, -0.5, -3, 50]
    assert moves[7].end == (20, 0, 50)


def test_repeats_in_increments():
    moves = fanuc("G21 G90 G99 G0 X0. Y0. Z10.\nG91 G81 X5. Z-4. R-8. K3 F100.\nG80")
    holes = [m.end for m in moves if m.kind == "line"]
    assert holes == [(5, 0, -2), (10, 0, -2), (15, 0, -2)]  # R = 10 - 8 = 2, bottom = 2 - 4


def test_fine_boring_moves_off_the_wall():
    moves = fanuc("G21 G99 S100 M3 G0 X0. Y0. Z10.\nG76 X5. Z-4. R2. Q0.5 F100.\nG80")
    kinds = [(m.end, m.spindle) for m in moves[-4:]]
    assert kinds == [((5, 0, -4), 100), ((5.5, 0, -4), 0), ((5.5, 0, 2), 0), ((5, 0, 2), 0)]


def test_tapping_turns_the_spindle_back():
    moves = fanuc("G21 G99 S100 M3 G0 X0. Y0. Z10.\nG84 X5. Z-4. R2. F125.\nG80")
    assert [(m.kind, m.end[2], m.spindle) for m in moves[-2:]] == [("line", -4, 100), ("line", 2, -100)]


# -- flow ---------------------------------------------------------------------------------------------------------------
def test_subprograms_of_fanuc():
    text = "O1\nG21 G91 G0\nM98 P20 L3\nM98 P20020\nM30\nO20\nX1.\nM99\n"
    assert interpret(text, "fanuc").moves[-1].end[0] == 5  # 3 + 2 times


def test_a_colon_is_a_program_number():
    assert interpret(":12\nM98 P13\nM30\n:13\nG0 X7.\nM99\n", "fanuc").moves[-1].end[0] == 7


def test_a_subprogram_in_a_file_of_its_own(tmp_path: Path):
    (tmp_path / "O0020.nc").write_text("O0020\nG0 X7.\nM99\n")
    assert interpret("O1\nM98 P20\nM30", "fanuc", name=str(tmp_path / "main.nc")).moves[-1].end[0] == 7
    (tmp_path / "hop.ngc").write_text("o<hop> sub\nG0 X#1\no<hop> endsub [#1 * 2]\nM2\n")
    text = "G21\no<hop> call [4]\nG0 Y#<_value>\nM2"
    assert interpret(text, "linuxcnc", name=str(tmp_path / "main.ngc")).moves[-1].end == (4, 8, 0)


def test_macro_b():
    text = (
        "O1\nG21 G90 G0\n#100=0\nWHILE[#100 LT 3] DO1\n#100=#100+1\nX#100\nEND1\nIF[#100 EQ 3] GOTO 50\nX99.\nN50 Y[SQRT[16]*2]\n"
        "IF[#100 GT 2] THEN #101=7\nZ#101\nX#150\nG65 P9000 A1.5 I2. I4.\nM30\nO9000\nX#1 Y#4 Z#7\nM99\n"
    )
    moves = interpret(text, "fanuc").moves
    assert [m.end[0] for m in moves[:3]] == [1, 2, 3]
    assert [m.end for m in moves[3:]] == [
        (3, 8, 0),
        (3, 8, 7),
        (1.5, 2, 4),
    ]  # X#150 is vacant: no word at all


def test_modal_macro_after_every_motion():
    text = "O1\nG21 G90 G0\nG66 P9000 Z-5.\nX1.\nX2.\nG67\nX3.\nM30\nO9000\nG0 Z#26\nG0 Z0.\nM99\n"
    assert [(m.end[0], m.end[2]) for m in interpret(text, "fanuc").moves] == [
        (1, 0), (1, -5), (1, 0), (2, 0), (2, -5), (2, 0), (3, 0),
    ]  # fmt: skip


def test_o_words():
    text = (
        "G21 G0\no1 sub\no2 if [#1 GT 2]\nX#1\no2 elseif [#1 EQ 2]\nY#1\no2 else\nZ#1\no2 endif\no1 endsub\n"
        "#10=0\no3 while [#10 LT 4]\n#10=[#10+1]\no4 if [#10 EQ 3]\no3 continue\no4 endif\no1 call [#10]\no3 endwhile\n"
        "o5 repeat [2]\nG91 X1\no5 endrepeat\no6 do\n#10=[#10-1]\nX1\no6 while [#10 GT 2]\nM2"
    )
    assert ends(interpret(text, "linuxcnc").moves) == [
        (0, 0, 1), (0, 2, 1), (4, 2, 1), (5, 2, 1), (6, 2, 1), (7, 2, 1), (8, 2, 1),
    ]  # fmt: skip


def test_parameters_of_the_control():
    moves = linuxcnc("G21 G54\nG0 X3 Y4\nG0 X[#5420 + #5221] Y#<_y> Z[#<_metric> + EXISTS[#<depth>]]", ONE)
    assert moves[-1].end == (100 + 103, 54, -199)
    assert fanuc("G21 G0 X3.\nG0 X[#5041+1] Y#5221", ONE)[-1].end == (104, 150, 0)


def test_block_delete():
    assert len(linuxcnc("G21\n/G0 X1\nG0 X2")) == 2
    assert len(linuxcnc("G21\n/G0 X1\nG0 X2", Setup(block_delete=True))) == 1


# -- decimals -----------------------------------------------------------------------------------------------------------
def test_decimal_point_rules():
    found = interpret("G21 G0 X10\nX20.\nM30", "fanuc")
    assert [m.end[0] for m in found.moves] == [10, 20]
    assert "calculator type" in found.warnings[0].text
    increments = interpret("G21 G0 X10\nX20.\nG91 X500\nM30", "fanuc", Setup(decimal_point="increment"))
    assert [m.end[0] for m in increments.moves] == pytest.approx(
        [0.01, 20, 20.5]
    )  # 10 and 500 increments of 1 um
    assert interpret("G20 G0 X10\nM30", "fanuc", Setup(decimal_point="increment")).moves[0].end[
        0
    ] == pytest.approx(0.0254)


def test_absolute_centres_by_the_set_up():
    moves = interpret(
        "G21 F100.\nG0 X10.\nG3 X0. Y10. I0. J0.\nM30", "fanuc", Setup(arc_centre="absolute")
    ).moves
    assert moves[1].centre == (0, 0, 0)


# -- lathe of Fanuc ---------------------------------------------------------------------------------------------------------
def test_fanuc_lathe():
    text = (
        "G21 T0101\nG97 S1000 M3\nG0 X40. Z2.\nG1 Z-10. F0.1\nU2. W-1.\nG2 X50. Z-15. R5.\nG32 Z-20. F2.\nM30"
    )
    moves = interpret(text, "fanuc-lathe", Setup(tools={1: Tool(1, 0.0, shape="turning")})).moves
    assert ends(moves) == [(20, 0, 2), (20, 0, -10), (21, 0, -11), (25, 0, -15), (25, 0, -20)]
    assert [m.feed for m in moves] == pytest.approx([None, 100, 100, 100, 2000])
    assert moves[3].plane == "ZX"
    assert moves[-1].kind == "thread"


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


# -- traces and dialects ------------------------------------------------------------------------------------------------------
def test_traces_find_the_words():
    text = "O1\nG21 G90 F100.\nG1 X1.50 y-2.\nM98 P9 L2\nG81 X5. Z-1. R1.\nM30\nO9\nG91 G1 X1.\nG90\nM99\n"
    found = interpret(text, "fanuc", ONE, trace=True)
    assert len(found.traces) == len(found.moves)
    lines = text.split("\n")
    first = found.traces[0]
    x = first.words["X"]
    assert (lines[first.line - 1][x.first - 1 : x.last - 1], x.decimals, x.plain) == ("X1.50", 2, True)
    y = first.words["Y"]
    assert lines[first.line - 1][y.first - 1 : y.last - 1] == "y-2."
    assert first.programmed[1] == (1.5, -2, 200)  # the axis at 0 is at 200 in work coordinates
    assert first.transformation.shift == (100, 50, -200)
    assert (first.before.motion, first.after.motion) == ("G0", "G1")
    assert [t.runs for t in found.traces if t.line == 8] == [2, 2]
    assert not found.traces[1].after.absolute
    assert {t.cycle for t in found.traces if t.line == 5} == {"G81"}
    assert [m.end for m in found.moves] == [m.end for m in interpret(text, "fanuc", ONE).moves]


@pytest.mark.parametrize(
    ("text", "dialect", "doubt"),
    [
        ("o100 sub\no100 endsub\nM2", "linuxcnc", False),
        ("G0 X#<a>\nM2", "linuxcnc", False),
        ("%\nO0001\nG28 G91 Z0\nM30\n%", "fanuc", False),
        ("M98 P5\nG64 P0.1\nM30", "linuxcnc", True),
        ("G0 X1.\nM30", "fanuc", True),
        ("G0 X9. Z1.\nG3 X10. Z0. I0. K-.6\nM30", "fanuc-lathe", True),
    ],
)
def test_the_dialect_is_guessed_and_doubt_is_told(text: str, dialect: str, doubt: bool):
    from vcmm.nc.reading import guess

    found, why = guess(text, Path("part.nc"))
    assert found == dialect
    assert ("--dialect" in why) == doubt
