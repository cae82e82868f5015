"""PLANE and cycle 19: the same plane said in different ways, points by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.program.heidenhain.klartext import SETUP, check, ends, moves
from vcmm.core.errors import DataError

SURVEY = replace(SETUP, strict=False)
S = math.sqrt(0.5)


@pytest.mark.parametrize(
    "plane",
    [
        "PLANE SPATIAL SPA+45 SPB+0 SPC+0 STAY",
        "PLANE VECTOR BX1 BY0 BZ0 NX0 NY-1 NZ1 STAY SEQ- TABLE ROT",
        "PLANE EULER EULPR+0 EULNU45 EULROT0 TURN FMAX",
        "PLANE POINTS P1X+0 P1Y+0 P1Z+0 P2X+5 P2Y+0 P2Z+0 P3X+0 P3Y+2 P3Z+2 MOVE DIST50 F500",
        "PLANE PROJECTED PROPR+0 PROMIN+45 ROT+0 STAY",
        "PLANE AXIAL A+45 STAY",
        "CYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 A+45 B+0 C+0 F1000 DIST50",
        "PLANE SPATIAL SPA+30 SPB+0 SPC+0 STAY\nPLANE RELATIV SPA+15 STAY",
    ],
)
def test_forty_five_degrees_about_x(plane: str):
    """Y of the plane lies along (0, 1, 1) / sqrt 2, Z along (0, -1, 1) / sqrt 2; reset, all is as before."""
    text = f"{plane}\nL X+1 Y+2 Z+0 FMAX\nL X+0 Y+0 Z+1 FMAX\nPLANE RESET STAY\nL X+0 Y+0 Z+1 FMAX"
    check(text, (1, 2 * S, 2 * S), (0, -S, S), (0, 0, 1), setup=SURVEY)


def test_order_of_spatial_angles():
    """A about X, B about Y, then C about Z, axes that stand still: X goes by B to -Z, which C leaves alone."""
    check("PLANE SPATIAL SPA+0 SPB+90 SPC+90 STAY\nL X+1 FMAX", (0, 0, -1), setup=SURVEY)
    check("PLANE SPATIAL SPA+0 SPB+0 SPC+90 STAY\nL X+1 FMAX", (0, 1, 0), setup=SURVEY)


def test_a_shift_inside_the_plane_ends_with_it():
    text = "CYCL DEF 7.0\nCYCL DEF 7.1 X+100\nPLANE SPATIAL SPA+90 SPB+0 SPC+0 STAY\nCYCL DEF 7.0\nCYCL DEF 7.1 Y+3\n"
    check(
        f"{text}L X+0 Y+1 FMAX\nPLANE RESET STAY\nL X+0 Y+1 Z+0 FMAX", (100, 0, 4), (100, 1, 0), setup=SURVEY
    )


def test_arcs_of_a_tilted_plane_are_chords_on_the_circle():
    """Half a circle about (0, 0) in the plane Y-Z, radius 10, from Y 10 to Y -10 over Z +10."""
    text = "PLANE SPATIAL SPA+90 SPB+0 SPC+90 STAY\nL X+10 Y+0 Z+0 F100\nCC X+0 Y+0\nC X-10 Y+0 DR+"
    got = ends(text, setup=SURVEY)[1:]
    assert np.allclose(np.hypot(got[:, 1], got[:, 2]), 10, atol=1e-9)
    assert np.allclose(got[:, 0], 0, atol=1e-9)
    assert got[:, 2].max() == pytest.approx(10, abs=0.01)
    assert np.allclose(got[-1], (0, -10, 0))
    step = np.linalg.norm(np.diff(got, axis=0), axis=1).max()
    assert 10 - math.sqrt(100 - step**2 / 4) <= 1.0001e-3  # the sagitta of the longest chord


def test_side_of_the_tool_in_a_tilted_plane_is_told():
    made = moves(
        "TOOL CALL 5 Z\nPLANE SPATIAL SPA+45 SPB+0 SPC+0 STAY\nL X+10 RL F100\nL X+20 R0", setup=SURVEY
    )
    assert [m.end[0] for m in made] == [10, 20]


def test_bad_planes():
    with pytest.raises(DataError, match="PLANE takes SPATIAL"):
        moves("PLANE SPATIALLY SPA+1", setup=SURVEY)
    with pytest.raises(DataError, match="parallel or zero"):
        moves("PLANE VECTOR BX1 BY0 BZ0 NX1 NY0 NZ0 STAY", setup=SURVEY)
