"""Whole paths against LinuxCNC's own interpreter, within 2 um."""

from __future__ import annotations

import pytest

from oracle import SETUP, answer, differences, ours, program, steps

from vcmm.errors import DataError
from vcmm.nc.interpret import read_program

EQUAL = [  # the oracle reads these to their end
    "autodesk_hsm_fanuc_mill.nc",
    "fanuc_g17_18_19.nc",
    "fanuc_test_g91.nc",
    "linuxcnc_comp_g1.ngc",
    "linuxcnc_lathe_pawn.ngc",
    "linuxcnc_lathecomp.ngc",
    "nist_appC1_hello_world.ngc",
    "nist_appC2_expressions.ngc",
    "nist_appC3_canned_cycles_3planes.ngc",
    "nist_circle_diamond_square.ngc",
]
COMPENSATED = {"autodesk_hsm_fanuc_mill.nc", "linuxcnc_comp_g1.ngc", "linuxcnc_lathecomp.ngc"}


@pytest.mark.parametrize("name", EQUAL)
def test_the_whole_path_is_that_of_linuxcnc(name: str):
    expected = answer(name)
    assert expected["error"] is None
    found = read_program(program(name), "linuxcnc", SETUP)
    assert not differences(ours(found.moves), steps(expected["events"]))
