"""Lines, arcs, threads and numbers of the G-code family, with moves worked out by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from tests.program.meanings import ends, linuxcnc
from vcmm.program.interpret import interpret
from vcmm.program.iso.motion import arc_limits
from vcmm.program.setup import Setup, Tool
from vcmm.program.summary import arc_angle, move_length


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


def test_a_rotary_axis_alone_turns_in_degrees_per_minute():
    assert linuxcnc("G20 F90\nG1 A180")[0].feed == 90


def test_lathe_diameters_in_linuxcnc():
    moves = linuxcnc("G21 G18 G7 F100\nG0 X20 Z0\nG8 G0 X20")
    assert [m.end[0] for m in moves] == [10, 20]


def test_rotary_axes_are_kept_in_rad():
    (move,) = linuxcnc("G21 G0 A90 C180")
    assert move.rotary_end == pytest.approx((math.pi / 2, 0, math.pi))
    assert move.end == move.start


def test_threads():
    (move,) = linuxcnc("G21 S500 M3\nG33 Z-10 K1.5")
    assert (move.kind, move.feed) == ("thread", 750)


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


@pytest.mark.parametrize(
    ("unit", "step"),
    [(1.0, 0.02828427), (25.4, 0.07184205)],  # 2 sqrt(2) x 0.01 mm; 2 sqrt(2) x 0.001 x 25.4 mm
)
def test_how_far_the_radii_of_an_arc_may_differ(unit: float, step: float) -> None:
    assert arc_limits(SimpleNamespace(unit=unit)) == pytest.approx((100 * step, step, 0.001), rel=1e-6)  # type: ignore[arg-type]
