"""Rewritten programs against numbers worked out by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.compensation.mill import SETUP, body, mill, rough, run, scale
from vcmm.core.machine import Machine
from vcmm.physics.structure.component import ComponentTable
from vcmm.physics.structure.squareness import Squareness
from vcmm.program.interpret import interpret
from vcmm.program.setup import Tool

HEAD = "%\nO1\nG21 G90 G54\n"


def test_a_line_through_a_scale_error(tmp_path):
    # +100 um/m: commanded 100 mm becomes 100.010 mm. 99.990 (1 + 1e-4) = 99.999999 mm: 1 nm is left
    found = run(tmp_path, HEAD + "G1 X100. F500 (wall)\nM30\n%\n", scale(100.0))
    assert body(found)[3] == "G1 X99.990 F500 (wall)\n"
    assert found.before.largest == pytest.approx(0.010)
    assert found.after.largest < 1e-5
    assert found.is_met


def test_sign_and_place_of_setting(tmp_path):
    # the offset was set at X = 100 on this machine, where the error is 10 um: G55 X100. is 200 mm, 20 - 10 = 10 um too far
    text = "%\nO1\nG21 G90 G55\nG1 X100. F500\nM30\n%\n"
    assert body(run(tmp_path, text, scale(100.0)))[3] == "G1 X99.990 F500\n"
    assert body(run(tmp_path, text, scale(100.0), set_here=False))[3] == "G1 X99.980 F500\n"


def test_a_perfect_machine_changes_nothing(tmp_path):
    text = HEAD + "g01 x+10. y-.5 F500\nG2 X20 I5.\n G1 G91 X 1 0.50 (é)\n\n/N5 Z5;\nM30\n%\n"
    found = run(tmp_path, text, mill())
    assert "".join(body(found)) == text
    assert max(found.before.largest, found.after.largest) < 1e-12
    assert found.blocks.changes == 0


def test_squareness_makes_an_arc_four_arcs(tmp_path):
    """20 urad on R50: one corrected arc leaves 0.5 um; the bar is 0.1 um with at most 8 arcs."""
    text = HEAD + "G0 X50. Y0 Z0\nG2 I-50. F500\nM30\n%\n"
    found = run(tmp_path, text, mill(Squareness("C0Y", 20e-6)), tolerance=1e-4, decimals=4)
    # tip error (-c y, 0): along the radius -c y x / R, largest at 45 deg: 20e-6 x 50 / 2 = 0.5 um
    assert found.before.largest == pytest.approx(0.5e-3, rel=1e-3)
    assert found.after.largest < 1e-4
    arcs = found.blocks.additions + 1
    assert 4 <= arcs <= 8
    moves = [m for m in interpret(found.text, "fanuc", SETUP).moves if m.kind == "arc"]
    assert len(moves) == arcs
    # first quarter ends at the bottom: y = -50 needs x = c y = -1 um (command less error -c y = +1 um)
    assert moves[0].end == pytest.approx((-0.001, -50.0, 0.0))


def test_increments_do_not_drift(tmp_path):
    # 1000 steps of 0.1 mm at +300 um/m: 100 mm become 100.030 mm; one step lacks only 0.03 um, far below a digit
    text = HEAD + "G91\nG1 F500\n" + "X0.1\n" * 1000 + "M30\n%\n"
    found = run(tmp_path, text, scale(300.0))
    steps = [float(line[1:]) for line in body(found)[5:1005]]
    assert math.fsum(steps) == pytest.approx(99.970, abs=6e-4)
    assert {round(s, 4) for s in steps} <= {0.099, 0.1, 0.101}
    assert found.after.largest < 1.1e-3  # one digit: error diffusion
    plain = run(tmp_path, text, scale(300.0), carry=False)
    steps = [float(line[1:]) for line in body(plain)[5:1005]]
    assert {round(s, 4) for s in steps} == {0.099, 0.1}
    assert math.fsum(steps) == pytest.approx(99.970, abs=6e-4)
    assert plain.after.largest < 0.51e-3


def test_rounding_along_a_path_has_no_bias(tmp_path):
    """Error diffusion: over short blocks the mean of what is written is the mean of what is wanted."""
    points = [(0.5 * i, 10 + 0.001 * (i % 7)) for i in range(1, 400)]
    text = HEAD + "G1 F500 X0 Y10.\n" + "".join(f"X{x:.3f} Y{y:.3f}\n" for x, y in points) + "M30\n%\n"
    found = run(tmp_path, text, scale(30.0, "Y"))  # 0.3 um at Y 10: always less than half a digit
    moves = interpret(found.text, "fanuc", SETUP).moves
    off = np.array([m.end[1] for m in moves[1:]]) - np.array([y for _, y in points])
    assert off.mean() == pytest.approx(-0.3e-3, abs=0.01e-3)  # plain rounding would leave 0
    assert np.abs(off).max() <= 1.001e-3


def test_only_what_must_change_changes(tmp_path):
    """CR LF, comments, small letters, blanks, blank lines, N numbers, percent signs and unchanged words, byte for byte."""
    text = "%\r\nO0815 (TEIL)\r\n\r\nN10 g21g90 G54\r\nN20 G0  X0  Y0 (start)\r\nN30 G1 X 100. Y+5.50 F500. (wand)\r\nN40 M30\r\n%\r\n"
    found = run(tmp_path, text, scale(100.0))
    expected = text.replace("X 100.", "X 99.990")
    assert "".join(body(found)) == expected
    assert found.text.count("\r\n") == found.text.count("\n")
    marks = [line for line, s in zip(found.text.splitlines(), found.source_lines) if not s]
    assert marks[0] == "(VCMM COMPENSATED - DO NOT COMPENSATE AGAIN)"
    assert found.text.splitlines()[2] == marks[0]  # behind the O number


def test_a_word_is_added_where_an_axis_leans(tmp_path):
    # 200 urad: at Y 100 the tip stands at -20 um in X, so the block needs X 0.020
    found = run(tmp_path, HEAD + "G1 X0 Y0 F500\nY100. F300 (up)\nM30\n%\n", mill(Squareness("C0Y", 200e-6)))
    assert body(found)[4] == "X0.020 Y100. F300 (up)\n"


def test_long_lines_are_split_only_where_they_bend(tmp_path):
    found = run(tmp_path, HEAD + "G1 X300. F500\nM30\n%\n", rough(), tolerance=1e-3)
    assert found.blocks.additions > 0
    assert found.after.largest <= 1e-3 + found.rounding.largest
    straight = run(tmp_path, HEAD + "G1 X300. F500\nM30\n%\n", scale(100.0), tolerance=1e-4)
    assert straight.blocks.additions == 0


def test_inverse_time_feed_is_shared_out(tmp_path):
    setup = replace(SETUP, dialect="linuxcnc")
    text = "G21 G90 G54 G93\nG1 X300. F2.\nG94\nM2\n"
    found = run(tmp_path, text, rough(), setup)
    feeds = [m.feed for m in interpret(found.text, "linuxcnc", setup).moves]
    assert len(feeds) > 1
    assert feeds == pytest.approx([600.0] * len(feeds), rel=1e-3)  # 300 mm in 1/2 min


def test_holes_move_and_keep_their_depth(tmp_path):
    # X +100 um/m, nothing in Z: only X changes; hole by hole, the depth words stay
    text = HEAD + "G0 Z50.\nG81 X100. Y0 Z-10. R2. F100\nX200.\nY50.\nG80\nM30\n%\n"
    assert body(run(tmp_path, text, scale(100.0)))[4:7] == [
        "G81 X99.990 Y0 Z-10. R2. F100\n", "X199.980\n", "Y50.\n",
    ]  # fmt: skip
    # Z +1000 um/m: at -10 mm the tip is 10 um too low; R and Z move up together
    lines = body(run(tmp_path, text, scale(1000.0, "Z")))
    assert lines[4] == "G81 X100. Y0 Z-9.990 R2.010 F100\n"
    assert lines[5:7] == ["X200.\n", "Y50.\n"]


def test_the_way_out_of_a_boring_cycle(tmp_path):
    # Z +1000 um/m: G85 cuts from 2 mm to -10 mm and back: -10 mm is 10 um too low, 2 mm is 2 um too high
    text = HEAD + "G0 Z50.\nG85 X100. Y0 Z-10. R2. F100\nG80\nM30\n%\n"
    assert body(run(tmp_path, text, scale(1000.0, "Z")))[4] == "G85 X100. Y0 Z-9.990 R1.998 F100\n"
    # in steps: from 49.950 (50 mm) down to R at 1.998 are 47.952, from there to the bottom at -9.990 are 11.988
    text = HEAD + "G0 Z50.\nG91 G85 X100. Y0 Z-12. R-48. F100\nG80\nM30\n%\n"
    assert body(run(tmp_path, text, scale(1000.0, "Z")))[4] == "G91 G85 X100. Y0 Z-11.988 R-47.952 F100\n"


def test_back_boring_ends_where_it_must(tmp_path):
    # LinuxCNC's G87 bores from Z up to K: at -5 mm the tip is 5 um too low
    setup = replace(SETUP, dialect="linuxcnc")
    text = "G21 G90 G54\nG0 Z50.\nG87 X100. Y0 Z-10. R2. I1. J0 K-5. F100\nG80\nM2\n"
    found = run(tmp_path, text, scale(1000.0, "Z"), setup)
    assert body(found)[2] == "G87 X100. Y0 Z-9.990 R2.010 I1. J0 K-4.995 F100\n"


def test_repeated_increments_are_written_out(tmp_path):
    # holes at 30, 60, 90 with +200 um/m: 29.994, 59.988, 89.982: steps 29.994 each, so K3 stays
    text = HEAD + "G0 X0 Y0 Z0\nG91 G81 X30. Z-5. R-1. K3 F100\nG80 G90\nM30\n%\n"
    lines = body(run(tmp_path, text, scale(200.0)))
    assert lines[4] == "G91 G81 X29.994 Z-5. R-1. K3 F100\n"
    # with a squareness of 5 urad more holes are alike in Y only by rounding; a wavy error makes the steps differ
    lines = body(run(tmp_path, text, rough()))
    assert "K3" not in lines[4]
    assert len(lines) == len(text.splitlines()) + 2


def test_radius_compensation_stays_on(tmp_path):
    text = (
        HEAD
        + "T1 M6\nG0 X-20. Y-20. Z0\nG41 D1 G1 X0 Y-10. F500\nY50.\nX80.\nY0\nX-10.\nG40 G1 X-20. Y-20.\nM30\n%\n"
    )
    found = run(tmp_path, text, rough())
    assert found.is_met
    assert found.after.largest < 1.7e-3 < found.before.largest
    assert "G41 D1" in found.text
    assert "G40" in found.text


def bowed(component: str) -> ComponentTable:
    """A component that is a parabola over its axis: 0 at 150 mm, 5.65 um at 0 and at 300 mm."""
    grid = np.linspace(-500.0, 500.0, 101)
    return ComponentTable(component, (component[-1],), (grid,), 5.65e-3 * ((grid - 150.0) / 150.0) ** 2)


BOWED = (bowed("EYX"), bowed("EXY"))
POCKET = (
    "T1 M6\nG0 X80. Y80. Z0\nG41 D1 G1 X80. Y0 F500\nX300.\nY300.\nX0\nY0\nX80.\nG40 G1 X80. Y80.\nM30\n%\n"
)


@pytest.mark.parametrize("dialect", ["fanuc", "linuxcnc"])
def test_a_compensated_contour_with_inside_corners_is_split(tmp_path, dialect):
    """Sides of 300 mm bent by 5.65 um; the last piece before a corner must be longer than the tool's radius of 20 mm."""
    setup = replace(SETUP, dialect=dialect, tools={1: Tool(1, 0.0, 40.0)})
    found = run(tmp_path, HEAD + POCKET, mill(*BOWED), setup, decimals=4)
    assert found.before.largest == pytest.approx(5.65e-3, rel=0.2)
    assert found.blocks.additions >= 4
    assert found.is_met
    assert not any("cannot follow blocks" in w for w in found.warnings)


@pytest.mark.parametrize("dialect", ["fanuc", "linuxcnc"])
def test_a_plunge_in_a_compensated_contour_stays_in_its_place(tmp_path, dialect):
    """A step of 1 um in X would be an element of the contour: the tool of radius 5 mm would go round it, 7.07 mm off."""
    text = HEAD + (
        "T1 M6\nG0 X-20. Y-20. Z5.\nG41 D1 G1 X0 Y-10. F500\nG1 Z-2. F100\nY300. F500\nX300.\nY0\nX-10.\n"
        "G0 Z5.\nG40 G0 X-20. Y-20.\nM30\n%\n"
    )
    found = run(tmp_path, text, mill(*BOWED), replace(SETUP, dialect=dialect))
    assert found.after.largest < 1.8e-3
    assert "G1 Z-2. F100" in found.text


def test_the_way_into_compensation_is_no_piece_of_a_contour(tmp_path):
    """G41 in a block of its own: the next block leads to the parallel, over its whole length. Split, it would end 3 mm off."""
    text = HEAD + (
        "T1 M6\nG0 X-20. Y-20. Z0\nG1 X0 Y-10. F500\nG41 D1\nY300.\nX300.\nY0\nX-10.\nG40\nG0 X-20. Y-20.\nM30\n%\n"
    )
    found = run(tmp_path, text, mill(*BOWED), replace(SETUP, dialect="linuxcnc"))
    assert "Y300.000\n" in found.text or "Y300.\n" in found.text
    assert found.after.largest < 8e-3
    assert any("compensation starts or ends in this block" in w for w in found.warnings)


def test_a_retract_is_corrected_in_all_axes(tmp_path):
    """Z out of square by 80 urad, 50 mm up: the way out would lead 4 um aside, through the wall that was just cut."""
    text = HEAD + "G0 X10. Y0 Z5.\nG1 Z-10. F200\nG0 Z40.\nG0 X50.\nM30\n%\n"
    lines = body(run(tmp_path, text, mill(Squareness("B0Z", 80e-6))))
    # 80e-6 x Z: -0.8 um at -10 mm, so X + 0.001; 3.2 um at 40 mm, so X - 0.003
    assert lines[-4:-2] == ["G0 X9.997 Z40.\n", "G0 X49.997\n"]


def test_x_and_y_of_an_offset_come_from_the_tool_that_set_it(tmp_path):
    """Tools of 120 and 200 mm under a head tilted by 100 urad: the second cuts 80 mm x 100 urad = 8 um aside."""
    tools = {1: Tool(1, 120.0, 10.0), 2: Tool(2, 200.0, 10.0)}
    grid = np.array([-1e4, 1e4])
    head = mill(ComponentTable("EBZ", ("Z",), (grid,), np.full(2, 100e-6)))
    text = HEAD + "".join(
        f"T{n} M6\nG0 X{x}. Y0\nG43 H{n} Z5.\nG1 Z-5. F200\nG0 Z50.\n" for n, x in ((1, 0), (2, 40))
    )
    found = run(tmp_path, text + "M30\n%\n", head, replace(SETUP, tools=tools))
    assert found.before.largest == pytest.approx(8e-3, abs=1e-6)
    assert found.is_met
    assert "X40.008" in found.text
    second = run(tmp_path, text + "M30\n%\n", head, replace(SETUP, tools=tools, set_with=2))
    assert "X-0.008" in second.text


def test_machine_moves_are_left_alone(tmp_path):
    text = HEAD + "G1 X100. Y0 F500\nG91 G28 Z0\nG90 G53 G0 X0\nG1 X100.\nM30\n%\n"
    lines = body(run(tmp_path, text, scale(100.0)))
    assert lines[3:7] == ["G1 X99.990 Y0 F500\n", "G91 G28 Z0\n", "G90 G53 G0 X0\n", "G1 X99.990\n"]


def test_rapids_are_corrected_at_their_ends_only(tmp_path):
    found = run(tmp_path, HEAD + "G0 X300. Y0\nG1 Y1. F100\nM30\n%\n", rough())
    assert found.blocks.additions == 0
    assert float(body(found)[3].split("X")[1].split()[0]) == pytest.approx(299.982, abs=0.012)


def test_arcs_by_radius_stay_arcs_by_radius(tmp_path):
    found = run(tmp_path, HEAD + "G1 X0 Y0 F500\nG2 X100. Y100. R100.\nM30\n%\n", rough())
    arcs = [line for line in body(found) if " R" in line]
    assert arcs
    assert not any(k in line for line in body(found) for k in "IJK")
    assert found.is_met


def test_inches(tmp_path):
    # 4 in = 101.6 mm: 10.16 um too far = 0.0004 in
    found = run(tmp_path, "%\nO1\nG20 G90 G54\nG1 X4. F20.\nM30\n%\n", scale(100.0))
    assert body(found)[3] == "G1 X3.9996 F20.\n"


def test_increments_without_a_point(tmp_path):
    setup = replace(SETUP, decimal_point="increment")
    found = run(tmp_path, HEAD + "G1 X100000 F500\nM30\n%\n", scale(100.0), setup)
    assert body(found)[3] == "G1 X99990 F500\n"


def test_offset_alone(tmp_path):
    # 0 to 100 mm at +100 um/m: mean 5 um along the path; what is left is 5 um at either end
    found = run(tmp_path, HEAD + "G1 X100. F500\nM30\n%\n", scale(100.0))
    assert found.shifts["G54"] == pytest.approx([-0.005, 0.0, 0.0], abs=1e-9)
    assert found.offset_only.largest == pytest.approx(0.005, abs=1e-9)


def test_reversal_is_left_to_the_control(tmp_path):
    from vcmm.physics.catalogue.backlash import Backlash

    machine: Machine = mill(Backlash("X", 4e-3))
    found = run(tmp_path, HEAD + "G1 X100. F500\nX0\nM30\n%\n", machine)
    assert "".join(body(found)) == HEAD + "G1 X100. F500\nX0\nM30\n%\n"
    assert any("backlash[X]" in w for w in found.warnings)
    assert found.whole is not None
    assert found.whole[1].largest == pytest.approx(found.whole[0].largest)


def test_growth_is_capped_by_relaxing_the_tolerance(tmp_path):
    found = run(tmp_path, HEAD + "G1 X300. F500\nM30\n%\n", rough(), tolerance=1e-5, decimals=5, growth=20.0)
    assert found.tolerance_used > found.tolerance
    assert not found.is_met
    assert any("relaxed" in w for w in found.warnings)


def test_half_circles_by_radius_do_not_hang_on_the_last_digit(tmp_path):
    # 178 deg: half a digit of R, 0.5 um, would move the centre by 0.5 / cos(89 deg) = 29 um
    angle = math.radians(178.0)
    x, y = 50 * math.cos(angle), 50 * math.sin(angle)
    text = HEAD + f"G1 X50. Y0 F500\nG3 X{x:.3f} Y{y:.3f} R50.\nM30\n%\n"
    found = run(tmp_path, text, mill(Squareness("C0Y", 40e-6)))
    assert found.is_met
    assert sum(" R" in line for line in body(found)) >= 2


def test_a_stop_stays_behind_its_motion(tmp_path):
    found = run(tmp_path, HEAD + "G1 X300. F500 M0 (look)\nX0 M30\n%\n", rough())
    lines = [line.strip() for line in body(found)]
    assert lines[3].endswith("F500 (look)")
    stop = next(i for i, line in enumerate(lines) if line.endswith("M0"))
    assert stop > 3
    assert lines[-2].endswith("M30")
    assert found.is_met


def test_the_mark_stands_behind_percent_and_number(tmp_path):
    for text, at in (
        ("%\n\nO1 (A)\nG21 G90 G54\nG1 X1. F5\nM30\n%\n", 3),
        ("G21 G90 G54\nG1 X1. F5\nM30\n", 0),
    ):
        found = run(tmp_path, text, scale(100.0))
        assert found.source_lines.index(0) == at


def test_the_hash_changes_with_the_machine_and_nothing_else(tmp_path):
    text = HEAD + "G1 X100. F500\nM30\n%\n"
    one, again, other = (run(tmp_path, text, scale(k)).digest for k in (100.0, 100.0, 101.0))
    assert one == again != other


@pytest.mark.parametrize(("unit", "x", "more"), [("G21", "104.", 4), ("G20", "4.5", 6)])
def test_rounding_that_is_left_names_the_decimals_that_would_help(tmp_path, unit, x, more):
    """104 mm / 1.0001 = 103.98960 mm, written 103.990: 0.40 um are left where 0.2 um are allowed.

    4.5 / 1.0001 = 4.49955 inch, written with four decimals: 0.00005 inch = 1.27 um. Five would not do for certain: sqrt(3)/2 x
    25.4 mm x 1e-5 = 0.22 um is more than 0.2 um; six do.
    """
    text = HEAD.replace("G21", unit) + f"G1 X{x} F50\nM30\n%\n"
    found = run(tmp_path, text, scale(100.0), tolerance=2e-4)
    assert found.after.largest > 2e-4
    assert any(f"--decimals {more}" in w and "0.2 um" in w for w in found.warnings)
    finer = run(tmp_path, text, scale(100.0), tolerance=2e-4, decimals=more)
    assert finer.after.largest < 2e-4
    assert not any("--decimals" in w for w in finer.warnings)
