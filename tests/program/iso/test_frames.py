"""Scaling, mirrors, polar words and tilted planes."""

from __future__ import annotations

import math

import pytest

from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup

SURVEY = Setup(strict=False)


def moves(text: str, dialect: str = "fanuc"):
    return interpret(f"G21 G90 G17 F100.\n{text}\nM30\n", dialect, SURVEY).moves


def test_g51_scales_about_its_centre():
    # about (10, 0) by 2: X 20 is 30, Y 5 is 10; P without a point counts thousandths
    assert moves("G51 X10. Y0. P2.\nG0 X20. Y5.")[-1].end == (30, 10, 0)
    assert moves("G51 X10. Y0. P2000\nG0 X20. Y5.")[-1].end == (30, 10, 0)
    assert moves("G51 X10. Y0. P2.\nG50\nG0 X20. Y5.")[-1].end == (20, 5, 0)


def test_a_scaled_arc_is_an_arc_with_the_scaled_radius():
    arc = moves("G51 X0 Y0 P2.\nG0 X10. Y0.\nG3 X0 Y10. R10.")[-1]
    assert (arc.kind, arc.clockwise) == ("arc", False)
    assert arc.centre == pytest.approx((0, 0, 0), abs=1e-12)
    assert arc.end == pytest.approx((0, 20, 0), abs=1e-12)


def test_a_mirror_turns_arcs_round():
    arc = moves("G51.1 X0\nG0 X10. Y0.\nG3 X0 Y10. I-10. J0")[-1]
    assert (arc.start, arc.end, arc.clockwise) == ((-10, 0, 0), (0, 10, 0), True)
    assert moves("G101 X0\nG0 X10. Y3.\nG100 X0\nG0 X5.", "haas")[0].end == (-10, 3, 0)


def test_different_scales_make_straight_lines_near_the_ellipse():
    found = moves("G51 X0 Y0 I2. J1. K1.\nG0 X10. Y0.\nG3 X-10. Y0. I-10. J0")
    cuts = [m for m in found if m.kind == "line"]
    assert max(abs((m.end[0] / 20) ** 2 + (m.end[1] / 10) ** 2 - 1) for m in cuts) < 1e-9
    assert cuts[-1].end == pytest.approx((-20, 0, 0), abs=1e-9)
    assert len(cuts) > 50


def test_polar_words():
    found = moves("G16\nG0 X100. Y30.\nG91 Y60.\nG90 G15 X1. Y2.")
    assert found[0].end == pytest.approx((100 * math.cos(math.pi / 6), 50, 0))
    assert found[1].end == pytest.approx((0, 100, 0), abs=1e-9)
    assert found[2].end == (1, 2, 0)


def test_drilling_on_a_bolt_circle_in_polar_words():
    found = moves("G0 Z5.\nG16\nG81 X50. Y0. Z-3. R2.\nY90.\nG80 G15")
    assert [m.end for m in found if m.kind == "line"][1] == pytest.approx((0, 50, -3), abs=1e-9)


def test_a_tilted_plane_by_euler_angles():
    # turned by 90 degrees about the new X: programmed Y is machine Z, programmed Z is machine -Y
    found = moves("G68.2 X10. Y0 Z0 I0 J90. K0\nG0 X1. Y2. Z3.\nG69\nG0 X0 Y0 Z0")
    assert found[0].end == pytest.approx((11, -3, 2))
    assert found[-1].end == (0, 0, 0)
