"""Polar and cylindrical interpolation, by the examples of the manuals."""

from __future__ import annotations

import math

import pytest

from vcmm.program.interpret import interpret
from vcmm.program.moves import Move
from vcmm.program.setup import Setup, Tool

TOOL = Setup(strict=False, tools={1: Tool(1, 0.0, 8.0)})
# FANUC B-64304EN-1, "polar coordinate interpolation", its example: a square of 40 mm with two rounded corners, tool in line with X
POLAR = """G21 G98 T0101
G0 X120. C0 Z2.
G12.1
{on}G1 X40. F200
C10.
G3 X20. C20. R10.
G1 X-40.
C-10.
G3 X-20. C-20. I10. J0
G1 X40.
C0
{off}X120.
G13.1
G0 Z50.
M30
"""


def path(text: str, dialect: str = "fanuc-lathe", setup: Setup = TOOL) -> tuple[Move, ...]:
    return interpret(text, dialect, setup).moves


def test_polar_interpolation_is_the_path_over_the_end_face():
    moves = path(POLAR.format(on="", off=""))
    there = [m for m in moves if m.is_tip_led]
    assert [m.end[:2] for m in there] == [
        pytest.approx(p) for p in ((20, 0), (20, 10), (10, 20), (-20, 20), (-20, -10), (-10, -20), (20, -20), (20, 0), (60, 0))
    ]  # fmt: skip
    assert [m.centre[:2] for m in there if m.centre] == [pytest.approx((10, 10)), pytest.approx((-10, -10))]
    assert [m.kind for m in there] == ["line", "line", "arc", "line", "line", "arc", "line", "line", "line"]
    degrees = [math.degrees(m.rotary_end[2]) for m in there]  # C = atan2(y, x), going on
    turned = [0, 26.565, 63.435, 135, 206.565, 243.435, 315, 360, 360]
    assert degrees == pytest.approx(turned, abs=1e-3)
    assert [m.rotary_start[2] for m in there[1:]] == pytest.approx([m.rotary_end[2] for m in there[:-1]])
    assert moves[-1].start == (60.0, 0.0, 2.0)  # out of it again: X is 120 in diameter, C where it stands


def test_radius_compensation_lies_in_the_plane_of_the_end_face():
    """G42 with a tool of 4 mm radius: 4 mm to the right of the side at X 40 (20 in radius)."""
    moves = path(POLAR.format(on="G42 D1 ", off="G40 "))
    side = next(m for m in moves if m.is_tip_led and m.kind == "line" and abs(m.end[0] - m.start[0]) < 1e-9)
    assert (side.start[0], side.compensation) == (pytest.approx(24.0), "right")
    arc = next(m for m in moves if m.kind == "arc")
    assert math.dist(arc.start[:2], arc.centre[:2]) == pytest.approx(14.0)
    for m in moves:
        if m.is_tip_led and m.kind == "line":
            assert math.degrees(m.rotary_end[2] - math.atan2(m.end[1], m.end[0])) % 360 == pytest.approx(0, abs=1e-6) or m.end[1] == 0  # fmt: skip


def test_haas_counts_x_and_y_as_radii():
    """Haas lathe operator's manual, G112, its example: from (.875, .5) by R .625 to (.25, 1.125), inches."""
    text = "G20 G98 T101\nG0 X1.75 C0 Z.1\nG112\nG1 X.875 Y.5 F5.\nG3 X.25 Y1.125 R.625\nG113\nM30\n"
    arc = path(text, "haas-lathe")[-1]
    assert (arc.kind, arc.end[:2]) == ("arc", pytest.approx((0.25 * 25.4, 1.125 * 25.4)))
    assert arc.centre[:2] == pytest.approx((0.25 * 25.4, 0.5 * 25.4))


# the same manual, "cylindrical interpolation": a cylinder of 57.299 mm, so that one degree is 1 mm
CYLINDER = """G21 G98 T0101
G0 X114.598 Z100. C0
G18 G7.1 C57.299
G1 Z120. F250
C30.
G3 Z90. C60. R30.
G1 Z70.
G2 Z60. C70. R10.
G7.1 C0
M30
"""


def test_arcs_on_a_cylinder_are_arcs_of_its_developed_surface():
    moves = path(CYLINDER)
    ends = {m.source.line: (m.end[2], math.degrees(m.rotary_end[2])) for m in moves}
    assert list(ends.values()) == [
        pytest.approx(p) for p in ((100, 0), (120, 0), (120, 30), (90, 60), (70, 60), (60, 70))
    ]
    for line, centre, radius in ((6, (90, 30), 30.0), (8, (70, 70), 10.0)):
        for m in (m for m in moves if m.source.line == line):
            z, s = m.end[2], math.degrees(m.rotary_end[2]) * math.radians(57.299)
            assert math.hypot(z - centre[0], s - centre[1]) == pytest.approx(radius, abs=5e-3)
            assert m.end[0] == pytest.approx(57.299)
    time = sum(
        abs(math.degrees(m.rotary_end[2] - m.rotary_start[2])) / m.feed for m in moves if m.source.line == 5
    )
    assert time == pytest.approx(
        30.0 * math.radians(57.299) / 250, rel=1e-6
    )  # 30 mm along the surface at 250 mm/min


def test_haas_wraps_a_linear_axis_round_a_rotary_one():
    """G107 A0 Y0 R20: 10 mm of Y are 10 / 20 rad of A; Y itself stands."""
    moves = path(
        "G21 G90 T1 M6\nG0 X0 Y0 Z30.\nG107 A0 Y0 R20.\nG1 Y10. F100.\nX5. Y0\nG107\nG1 Y3.\nM30\n", "haas"
    )
    assert [(m.end[:2], m.rotary_end[0]) for m in moves[1:]] == [((0, 0), 0.5), ((5, 0), 0.0), ((5, 3), 0.0)]
