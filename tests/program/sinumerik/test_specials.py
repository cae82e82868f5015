"""Frames, poles and reference points."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.program.sinumerik.programs import SURVEY, check, ends, moves, told
from vcmm.core.errors import DataError


def test_polar_coordinates():
    """G111: pole from the work zero; AP in deg, RP; G112 counts from the pole, G110 from the tool."""
    check(
        "G111 X10 Y5\nG0 AP=90 RP=20\nG112 X5\nG0 AP=0 RP=1\nG110 X1\nG0 AP=IC(180)",
        (10, 25, 0),
        (16, 5, 0),
        (18, 5, 0),
    )
    half = moves("G111 X0 Y0\nG1 X10 F100\nG3 AP=180 RP=10")
    assert np.allclose(half[1].end, (-10, 0, 0))
    assert half[1].centre == (0, 0, 0)


def test_shifts_of_single_axes():
    """G58 sets, G59 adds to, the shift of the axes that it names."""
    check("TRANS X10 Y20\nG58 X1\nG0 X0 Y0\nG59 Y2\nG0 X0 Y0", (1, 20, 0), (1, 22, 0))


def test_rotary_axes_are_shifted_and_turn_the_short_way():
    made = moves("TRANS C=30\nG0 C10\nTRANS\nG0 C350\nC=DC(10)\nC=ACN(0)\nC=ACP(0)", SURVEY)
    assert [round(math.degrees(m.rotary_end[2])) for m in made] == [40, 350, 370, 360, 360]
    along = moves("G1 X10 F100\nG3 X-10 CR=10 C=20", SURVEY)[1]
    assert (along.kind, round(math.degrees(along.rotary_end[2]))) == ("arc", 20)


def test_fixed_points_are_taken_at_the_reference():
    home = replace(SURVEY, reference=(100.0, 200.0, 300.0))
    check("G0 X1 Y2 Z3\nG75 Z0\nG74 X1=0", (1, 2, 3), (1, 2, 300), (100, 2, 300), setup=home)
    assert "the fixed point of the machine (G75)" in told("G75 FP=2 X1=0")
    with pytest.raises(DataError, match="G75"):
        moves("G75 Z0")


def test_machine_coordinates_of_rotary_axes():
    made = moves("TRANS B=10\nG0 SUPA Z5 B20\nG0 B0")
    assert [round(math.degrees(m.rotary_end[1])) for m in made] == [20, 10]


def test_arcs_under_a_rotation_out_of_the_plane():
    """Chords on the circle about (0, 0, 0) that X and Z now span; the side of the tool is not worked out there."""
    got = ends("AROT X90\nG1 X10 Y0 F100\nG3 X-10 Y0 CR=10", SURVEY)
    assert np.allclose(np.hypot(got[:, 0], got[:, 2]), 10)
    assert got[:, 2].max() == pytest.approx(10, abs=0.01)
    assert "radius compensation in a tilted plane" in told("T1\nROT Y90\nG41 G1 X10 F100")


def test_travel_to_a_fixed_stop_is_told():
    assert "FXS (travel to a fixed stop)" in told("G0 X1\nFXS[X]=1\nG1 X5 F100")
    with pytest.raises(DataError, match=r"FXS \(travel to a fixed stop\)"):
        moves("G0 X1\nFXS[X]=1\nG1 X5 F100")
