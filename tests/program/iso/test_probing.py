"""G31 and G38: the probe stops where the ball meets what the set-up states, and the program reads where that is."""

from __future__ import annotations

import math

import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup, Tool
from vcmm.program.touching import Face, Round, box_faces

BOX = box_faces((50.0, 20.0, -230.0), (100.0, 60.0, 30.0))
PROBE = Tool(9, length=120.0, diameter=6.0, shape="probe")
SETUP = Setup(offsets={"G54": (100.0, 50.0, -200.0)}, tools={9: PROBE}, surfaces=BOX)
HEAD = "G21 G17 G40 G49 G80 G90 G94\nT9 M6\nG54 G0 X-70. Y0.\nG43 H9 Z-5.\n"


def test_a_skip_stops_at_the_stock_and_the_program_knows_where():
    # the left face lies at X = -50 of the work, the ball of radius 3 stops at -53; G10 L2 makes that face the zero of X
    text = HEAD + "G31 X-40. F100.\n#101=#5061+3.\nG0 X-70.\nG10 L2 P1 X[100.+#101]\nG0 X0.\nM30"
    found = interpret(text, "fanuc", SETUP)
    assert [m.end[0] for m in found.moves[-3:]] == [47.0, 30.0, 50.0]
    touch = found.touches[0]
    assert (touch.line, touch.tip, touch.normal, touch.tool) == (5, (47.0, 50.0, -205.0), (-1.0, 0.0, 0.0), 9)


def test_what_the_touch_reads_further_comes_out_in_the_path():
    text = HEAD + "G31 X-40. F100.\n#5221=#5221+#5061+53.\nG0 X-70.\nM30"
    later = Setup(offsets=SETUP.offsets, tools=SETUP.tools, surfaces=BOX, read_out=(0.002,))
    one, two = (interpret(text, "fanuc", s).moves[-1].end[0] for s in (SETUP, later))
    assert two - one == pytest.approx(0.002, abs=1e-12)


def test_inches_are_those_of_the_program():
    text = HEAD.replace("G21", "G20").replace("-70.", "-2.75").replace("-5.", "-.2")
    found = interpret(text + "G31 X-1. F4.\nG0 X[#5061-1.]\nM30", "fanuc", SETUP)
    assert found.moves[-1].end[0] == pytest.approx(47.0 - 25.4, abs=1e-9)


def test_linuxcnc_tells_whether_anything_was_met():
    text = "G21 G90 G94 G54\nT9 M6\nG43 H9\nG0 X-70 Y0\nG0 Z-5\nF100\nG38.3 X-40\nG0 X[#5061-10]\nG0 Y[#5070]\nG38.3 X-200\nG0 Z[#5070]\nM2"
    found = interpret(text, "linuxcnc", SETUP)
    x, y, z = found.moves[-1].end
    assert (x, y, z) == (-100.0, 51.0, -200.0)
    assert "meets no surface" in found.warnings[-1].text
    with pytest.raises(DataError, match=r"G38\.2 meets no surface"):
        interpret("G21 G90 F100\nT9 M6\nG43 H9\nG38.2 X-200\nM2", "linuxcnc", SETUP)


def test_without_surfaces_the_set_up_is_asked_for_them():
    with pytest.raises(DataError, match=r"surfaces.*normal"):
        interpret(HEAD + "G31 X-40. F100.\nM30", "fanuc", Setup(tools={9: PROBE}))


def test_a_cutter_that_probes_is_told():
    mill = Setup(offsets=SETUP.offsets, tools={9: Tool(9, length=120.0, diameter=6.0)}, surfaces=BOX)
    found = interpret(HEAD + "G31 X-40. F100.\nM30", "fanuc", mill)
    assert "tool 9 probes, which is no probe" in found.warnings[-1].text


def test_the_motion_before_stays_in_force():
    found = interpret(HEAD + "G0 X-60.\nG31 X-40. F100.\nX-65.\nM30", "fanuc", SETUP)
    assert (found.moves[-1].kind, found.moves[-1].end[0]) == ("rapid", 35.0)


def test_a_stated_plane_may_lean():
    lean = Face((60.0, 50.0, -200.0), (-0.6, 0.0, 0.8))
    found = interpret(
        HEAD + "G31 X-40. F100.\nM30",
        "fanuc",
        Setup(offsets=SETUP.offsets, tools=SETUP.tools, surfaces=(lean,)),
    )
    # centre (x, 50, -202): -0.6 (x - 60) + 0.8 (-2) = 3
    assert found.touches[0].tip[0] == pytest.approx(60.0 - 4.6 / 0.6)


def test_a_surface_macro_corrects_its_work_offset():
    # expected at, found at -50: measured minus expected +0.4, so G54 goes from 100 to 100.4
    found = interpret(HEAD + "G65 P9811 X-50.4 S1.\nG0 X0.\nX#135 Y[#140*100.]\nM30", "fanuc", SETUP)
    assert found.moves[-2].end[0] == pytest.approx(100.4)
    assert found.moves[-1].end[:2] == pytest.approx((50.4, 90.0))


def test_a_web_is_measured_from_both_sides():
    # the stock is 100 wide about X0; asked for 99: size error +1, the middle where it should be
    text = HEAD.replace("G0 X-70. Y0.", "G0 X1. Y0.").replace("Z-5.", "Z10.")
    found = interpret(text + "G65 P9812 X99. Z-8. S1.\n#1=#138\nG0 X0.\nX#1\nM30", "fanuc", SETUP)
    assert [round(t.tip[0], 9) for t in found.touches] == [153.0, 47.0]
    assert found.moves[-2].end[0] == pytest.approx(
        99.0
    )  # the middle is at X0, 1 mm left of where it was expected
    assert found.moves[-1].end[0] == pytest.approx(199.0)


def test_a_bore_without_a_stated_surface_lies_where_it_is_expected():
    plain = Setup(offsets=SETUP.offsets, tools=SETUP.tools, strict=False)
    found = interpret(HEAD + "G65 P9814 D30. S2.\nG55 G0 X0.\nM30", "fanuc", plain)
    assert [t.tip for t in found.touches] == [
        (42.0, 50.0, -205.0),
        (18.0, 50.0, -205.0),
        (30.0, 62.0, -205.0),
        (30.0, 38.0, -205.0),
    ]
    assert found.moves[-1].end[0] == pytest.approx(100.0)
    assert [a.value for a in found.assumed] == ["where the program expects them"]


def test_a_program_with_a_macro_of_its_own_runs_that_one():
    found = interpret("O1\n" + HEAD + "G65 P9811 X1.\nM30\nO9811\nG0 X#24\nM99", "fanuc", SETUP)
    assert found.moves[-1].end[0] == pytest.approx(101.0)
    assert not found.touches


def test_a_flat_tool_touches_with_its_end_from_above():
    mill = Setup(offsets=SETUP.offsets, tools={9: Tool(9, length=120.0, diameter=6.0)}, surfaces=BOX)
    found = interpret(HEAD.replace("Z-5.", "Z20.") + "G0 X0.\nG31 Z-10. F100.\nM30", "fanuc", mill)
    assert found.touches[0].tip[2] == -200.0


def corner_surfaces(angle: float) -> tuple[Face, Face]:
    """Two faces that meet at X -50, Y -30 of the work, turned by an angle (rad); the part lies towards +X and +Y."""
    c, s = math.cos(angle), math.sin(angle)
    point = (50.0, 20.0, -200.0)
    return Face(point, (-c, -s, 0.0)), Face(point, (s, -c, 0.0))


def test_an_outer_corner_is_found_where_turned_faces_meet():
    # part turned by 0.01 rad about its corner at X-50 Y-30; expected 1 mm beside it
    setup = Setup(offsets=SETUP.offsets, tools=SETUP.tools, surfaces=corner_surfaces(0.01))
    text = (
        HEAD.replace("X-70. Y0.", "X-60. Y-40.")
        + "G65 P9816 X-51. Y-30. I20. J20. S1.\n#1=#135\n#2=#142\n#3=#139\nG0 X#1 Y#2\nZ#3\nM30"
    )
    found = interpret(text, "fanuc", setup)
    assert len(found.touches) == 4
    # measured -50 where -51 was expected: G54 goes from 100 by 1; X reads -50, Y the 0.5730 deg, Z the 90.5730 deg
    degrees = math.degrees(0.01)
    assert found.moves[-1].end == pytest.approx(
        (101.0 - 50.0, 50.0 + degrees, -200.0 + 90.0 + degrees), abs=1e-9
    )


def test_a_corner_without_second_touches_is_square_to_the_axes():
    text = HEAD.replace("X-70. Y0.", "X-60. Y-40.") + "G65 P9816 X-50. Y-30. S2.\nG55 G0 X0. Y0.\nM30"
    found = interpret(text, "fanuc", SETUP)
    assert [t.tip for t in found.touches] == [(60.0, 17.0, -205.0), (47.0, 30.0, -205.0)]
    assert found.moves[-1].end[:2] == pytest.approx((100.0, 50.0))


def test_an_inner_corner_is_touched_from_inside():
    inside = (Face((100.0, 0.0, 0.0), (-1.0, 0.0, 0.0)), Face((0.0, 80.0, 0.0), (0.0, -1.0, 0.0)))
    setup = Setup(offsets=SETUP.offsets, tools=SETUP.tools, surfaces=inside)
    text = HEAD.replace("X-70. Y0.", "X-20. Y10.") + "G65 P9815 X0. Y30.\nG0 X[#140*100.] Y[#141*100.]\nM30"
    found = interpret(text, "fanuc", setup)
    assert [t.tip[:2] for t in found.touches] == [(80.0, 77.0), (97.0, 60.0)]
    assert found.moves[-1].end[:2] == pytest.approx((100.0, 50.0))


@pytest.mark.parametrize(("axis", "start", "expected"), [("Y", "X0. Y-45.", 0.0), ("X", "X-65. Y0.", 90.0)])
def test_the_angle_of_a_face(axis, start, expected):
    # 0.01 rad = 0.5730 deg, counter-clockwise seen from +Z
    setup = Setup(offsets=SETUP.offsets, tools=SETUP.tools, surfaces=corner_surfaces(0.01))
    where = {"X": "-50.", "Y": "-30."}[axis]
    text = (
        HEAD.replace("X-70. Y0.", start)
        + f"G65 P9843 {axis}{where} D20.\n#1=#139\n#2=#144\nG0 X#1\nY[#2*100.]\nM30"
    )
    found = interpret(text, "fanuc", setup)
    x, y, _ = found.moves[-1].end
    assert x - 100.0 == pytest.approx(expected + math.degrees(0.01), abs=1e-9)
    assert y - 50.0 == pytest.approx(100.0 * math.degrees(0.01), abs=1e-7)


def test_a_bore_by_three_points_and_across_an_angle():
    # bore of 30.04 about (101, 51); expected 30 about (100, 50)
    bore = Round((101.0, 51.0, 0.0), 15.02, inside=True)
    setup = Setup(offsets=SETUP.offsets, tools=SETUP.tools, surfaces=(bore,))
    text = HEAD.replace("X-70. Y0.", "X0. Y0.")
    found = interpret(text + "G65 P9823 A0. B120. C240. D30.\nG0 X[#140+#138] Y#141\nM30", "fanuc", setup)
    assert found.moves[-1].end[:2] == pytest.approx((100.0 + 1.0 + 30.04, 51.0), abs=1e-9)
    found = interpret(text + "G65 P9814 D30.\nG0 X[#140+#138] Y#141\nM30", "fanuc", setup)
    assert found.moves[-1].end[:2] == pytest.approx((100.0 + 1.0 + 30.04, 51.0), abs=1e-9)
    # across 45 deg through (100, 50): the middle of the chord is the foot of the axis, half the diagonal away: (101, 51)
    found = interpret(text + "G65 P9821 A45. D30.\nG0 X[#140+#138] Y#141\nM30", "fanuc", setup)
    assert found.moves[-1].end[:2] == pytest.approx((100.0 + 1.0 + 30.04, 51.0), abs=1e-9)


def test_an_overtravel_of_nothing_is_one():
    # the face lies 0.4 mm beyond what is expected: within the usual 10 mm, not within none; then it is where it is expected
    beyond = HEAD + "G65 P9811 X-50.4 Q0.\nG0 X[#140*100.]\nM30"
    assert interpret(beyond, "fanuc", SETUP).moves[-1].end[0] == pytest.approx(100.0)
    assert interpret(beyond.replace(" Q0.", ""), "fanuc", SETUP).moves[-1].end[0] == pytest.approx(140.0)


def test_calibrating_and_switching_move_nothing_and_others_are_refused():
    found = interpret(HEAD + "G65 P9832\nG65 P9804 D25.\nG65 P9833\nM30", "fanuc", SETUP)
    assert not found.touches
    assert "calibrates the probe" in found.warnings[-1].text
    with pytest.raises(DataError, match=r":5:1: G65 P9834 \(from feature to feature\) is not understood"):
        interpret(HEAD + "G65 P9834\nM30", "fanuc", SETUP)


def test_linuxcnc_probes_away_from_what_it_touches():
    text = "G21 G90 G94 G54\nT9 M6\nG43 H9\nG0 X-70 Y0\nG0 Z-5\nF100\nG38.2 X-40\nG38.4 X-70\nG0 X[#5061-1]\nG0 Y#5070\n{}M2"
    found = interpret(text.format(""), "linuxcnc", SETUP)
    assert [t.along for t in found.touches] == [(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)]
    assert found.moves[-1].end[:2] == (46.0, 51.0)
    with pytest.raises(DataError, match=r"G38\.4 leaves no surface"):
        interpret(text.format("G38.4 X-80\n"), "linuxcnc", SETUP)
    assert (
        "G38.5 leaves no surface"
        in interpret(text.format("G38.5 X-80\n"), "linuxcnc", SETUP).warnings[-1].text
    )
