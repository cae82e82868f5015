"""MEAS: the probe stops where the set-up states a surface, and $AA_MW, $AA_MM, $AC_MEA say where."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError
from vcmm.nc.interpret import interpret
from vcmm.nc.setup import Setup, Tool
from vcmm.nc.touching import box_faces

BOX = box_faces((50.0, 20.0, -230.0), (100.0, 60.0, 30.0))
TOOLS = {9: Tool(9, length=120.0, diameter=6.0, shape="probe")}
SETUP = Setup(offsets={"G54": (100.0, 50.0, -200.0)}, tools=TOOLS, surfaces=BOX)
HEAD = "G17 G71 G90 G94 G54\nT9 M6\nG0 X-70 Y0\nZ-5\n"


def test_the_program_shifts_its_zero_by_what_it_reads():
    # face at X-50, the ball stops at -53: G54 X from 100 by -53 + 3 + 50 = 0; Z reads -5 in the work, -205 + 120 on the axis
    text = (
        HEAD
        + "MEAS=1 G1 X-40 F100\nR1=$AA_MW[X]\nR2=$AA_MM[Z]\nR3=$AC_MEA[1]\nG0 X=R1-10\nZ=R2 \nY=R3\n$P_UIFR[1,X,TR]=100+R1+53.5\nG0 X0\nM30"
    )
    found = interpret(text, "sinumerik", SETUP)
    assert found.touches[0].tip == (47.0, 50.0, -205.0)
    assert [m.end for m in found.moves[-4:]] == [
        (37, 50, -205),
        (37, 50, -285),
        (37, 51, -285),
        (100.5, 51, -285),
    ]


def test_the_zero_is_read_as_it_stands():
    found = interpret(HEAD + "$P_UIFR[1,X,TR]=$P_UIFR[1,X,TR]+0.5\nG0 X0\nM30", "sinumerik", SETUP)
    assert found.moves[-1].end[0] == 100.5


def test_a_way_that_meets_nothing_goes_to_its_end():
    found = interpret(HEAD + "MEAS=1 G1 X-100 F100\nM30", "sinumerik", SETUP)
    assert found.moves[-1].end[0] == 0.0
    assert "meets no surface" in found.warnings[-1].text


def test_without_surfaces_the_set_up_is_asked():
    with pytest.raises(DataError, match=r"MEAS=1 \(measuring\): where the probe stops"):
        interpret(HEAD + "MEAS=1 G1 X-40 F100\nM30", "sinumerik", Setup(tools=TOOLS))
    told = interpret(HEAD + "MEAS=1 G1 X-40 F100\nM30", "sinumerik", Setup(tools=TOOLS, strict=False))
    assert told.assumed[0].what == "MEAS=1 (measuring)"
