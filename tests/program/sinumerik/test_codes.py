"""G functions that change the state."""

from __future__ import annotations

import math

from tests.program.sinumerik.programs import check, moves


def test_radius_compensation_with_arc_and_mitre_corners():
    contour = "T1 D1\nG0 X-20 Y0\n{} G42 G1 X0 Y0 F100\nX20\nY20\nG40 X40"
    # right of +x: y = -5; around the corner (20, 0) to x = 25
    arc = [(-20, 0, 0), (0, -5, 0), (20, -5, 0), (25, 0, 0), (25, 20, 0), (40, 20, 0)]
    check(contour.format("G450"), *arc)
    check(contour.format("G451"), (-20, 0, 0), (0, -5, 0), (25, -5, 0), (25, 20, 0), (40, 20, 0))


def test_exact_stop_and_tolerance():
    got = moves("G60 G1 X1 F100\nX2\nG64 X3\nG9 X4\nX5\nCYCLE832(0.02,1)\nX6\nG642 CTOL=0.01\nX7")
    assert [m.exact_stop for m in got] == [True, True, False, True, False, False, False]
    assert [m.tolerance for m in got] == [None, None, None, None, None, 0.02, 0.01]


def test_constant_surface_speed_and_diameters():
    # G96 S100 at the mean diameter 40: 1000 x 100 / (pi x 40) = 795.77 1/min
    got = moves("DIAMON G18 LIMS=2000\nG97 S500 M4\nG0 X40 Z0\nG96 S100 G1 Z-10 F0.2")
    assert got[0].end == (20, 0, 0)
    assert math.isclose(got[1].spindle, -1e5 / (math.pi * 40), rel_tol=1e-12)
    assert math.isclose(got[1].feed, 0.2 * 1e5 / (math.pi * 40), rel_tol=1e-12)
    kept = moves("DIAMON G18 G96 S100 M3 G0 X40\nG1 Z-10 F0.2\nG97\nX80")[
        -1
    ]  # G97 without S keeps the speed reached
    assert math.isclose(kept.spindle, 1e5 / (math.pi * 40), rel_tol=1e-12)
