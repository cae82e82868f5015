"""Programs that cut with an indexed table: corrected in the position in which it stands, by hand."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import vcmm
from tests.compensation.mill import SETUP, run
from tests.compensation.test_surface import off_drawing
from vcmm.compensation.job import compensate
from vcmm.compensation.proof import compare
from vcmm.core.effect import Effect
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.rotary import RotaryCyclic
from vcmm.program.interpret import interpret

HEAD = "%\nG21 G17 G40 G49 G80 G90 G94\nT1 M6\nG54 G0 X0 Y0 S1200 M3\nG43 H1 Z50.\n"
SINUMERIK = replace(SETUP, dialect="sinumerik")
CUT = "G0 X100. Y0.\nG1 Z10. F500\nX120.\nG0 Z50.\nM30\n%\n"
OFF = RotaryCyclic("EXB", np.array([25e-3, 0.0]))  # the bearing carries the table 25 um cos B along X


def pallet(*effects: Effect) -> Machine:
    """A horizontal mill, its pallet about Y through the origin."""
    axes = {a: Axis(a, (-1e3, 1e3)) for a in "XYZ"} | {"B": Axis("B", (-7.0, 7.0), error_frame="fixed")}
    return Machine("pallet mill", "machine-tool", parse_structure("w B' Z' b X Y t"), axes, effects)


@pytest.mark.parametrize(
    ("angle", "x"), [("0", "100."), ("90", "99.975"), ("180", "99.950"), ("270", "99.975")]
)
def test_a_bearing_that_runs_out_carries_the_part_as_it_turns(tmp_path, angle, x):
    """25 um cos B along X of the machine, the zero set at B = 0: at 90 deg the part lies 25 um, at 180 deg 50 um towards -X; Z stays."""
    found = run(tmp_path, f"{HEAD}G0 B{angle}.\n{CUT}", pallet(OFF))
    assert f"G0 X{x} Y0.\nG1 Z10. F500\n" in found.text
    assert found.after.largest < 1e-6


def test_an_offset_that_was_set_where_it_cuts_holds_the_table_there(tmp_path):
    found = run(tmp_path, f"{HEAD}G0 B180.\n{CUT}", pallet(OFF), replace(SETUP, set_as_cut=True))
    assert "G0 X100. Y0." in found.text
    assert found.before.largest < 1e-9


def test_an_offset_that_was_set_in_one_place_cuts_in_no_other(tmp_path):
    text = f"{HEAD}G0 B180.\n{CUT}".replace("M30", "G0 B90.\nG1 X10.\nM30")
    with pytest.raises(UsageError, match=r"part.nc:12:1: .*G54 cuts with the rotary axes in several places"):
        run(tmp_path, text, pallet(OFF), replace(SETUP, set_as_cut=True))


def test_a_scale_stays_along_its_axis_whichever_way_the_table_stands(tmp_path):
    """X 100 um/m too long: X100 is written 99.990 and X120 119.988 at B90 as at B0, and Z stays."""
    found = run(tmp_path, f"{HEAD}G0 B90.\n{CUT}", pallet(ScaleFactor("X", 100e-6)))
    assert "G0 X99.990 Y0." in found.text
    assert "G1 Z10. F500\nX119.988\n" in found.text


def test_a_table_that_turns_along_a_cut_is_refused_with_what_to_do(tmp_path):
    with pytest.raises(
        ModelLimit, match=r"part.nc:6:1: a rotary axis turns while the tool cuts.*index the axis by a rapid"
    ):
        run(tmp_path, f"{HEAD}G1 X10. B30. F100\nM30\n%\n", pallet(OFF))


def test_the_way_round_of_a_rotary_axis_stays_where_loops_are_written_out(tmp_path):
    """DC: the shorter way, from 170 to 340 deg. As A=340 alone a table at 35 deg would go 305 deg where it went 55 deg back."""
    text = "G17 G90 G54 G71 G94\nT1 D1 M6\nS1200 M3\nFOR R1=1 TO 2\nG0 B=DC(R1*170)\nG0 X100 Y0 Z50\nG1 Z10 F500\nX=IC(20)\nG0 Z50\nG0 B=ACN(20)\nENDFOR\nM30\n"
    found = run(tmp_path, text, pallet(ScaleFactor("X", 100e-6)), SINUMERIK)
    assert [line for line in found.text.splitlines() if "B=" in line] == [
        "G0 B=DC(170)", "G0 B=ACN(20)", "G0 B=DC(340)", "G0 B=ACN(20)"
    ]  # fmt: skip
    turns = [
        [m.rotary_end[1] for m in interpret(one, "sinumerik", SINUMERIK).moves] for one in (text, found.text)
    ]
    np.testing.assert_allclose(turns[1], turns[0], atol=1e-12)
    assert math.degrees(turns[0][-1]) == pytest.approx(-340.0)


def test_a_new_program_that_turns_another_way_is_no_proof():
    old = "G17 G90 G54 G71 G94\nT1 D1 M6\nG0 B=300\nG0 B=DC(20)\nG0 X1\nM30\n"
    read = [interpret(t, "sinumerik", SINUMERIK, trace=True) for t in (old, old.replace("DC(20)", "20"), old)]
    lines = list(range(1, 8))
    compare(read[0], read[2], lines, "part.mpf")
    with pytest.raises(ModelLimit, match=r"part.mpf:4.*a rotary axis goes another way round"):
        compare(read[0], read[1], lines, "part.mpf")


def test_the_way_to_g43_needs_no_zero_in_reach(tmp_path):
    """Work zero at Z -910, travel to -900: a tool of 30 mm stands there at -880. The rapid before G43 leads no length, which was taken as 0."""
    machine = pallet(ScaleFactor("X", 100e-6))
    machine = replace(machine, axes=machine.axes | {"Z": Axis("Z", (-900.0, 0.0))})
    setup = replace(SETUP, offsets={"G54": (0.0, 0.0, -910.0)})
    text = HEAD.replace("T1", "T2").replace("H1", "H2") + CUT
    assert "X99.990" in run(tmp_path, text, machine, setup).text


@pytest.mark.thorough
def test_the_block_of_the_example_is_cut_right_by_the_new_program(tmp_path):
    """All four faces and bores, cut on the machine as it is: 6.9 um off their drawing before, less than 0.8 um after."""
    scenario = vcmm.load_cut(Path(vcmm.__file__).parents[1] / "scenarios" / "pallet_block.toml")
    made = compensate(
        scenario.program, scenario.setup, scenario.machine, constants=scenario.constants, decimals=4
    )
    new = tmp_path / "new.nc"
    new.write_text(made.text)
    assert np.abs(off_drawing(scenario)).max() == pytest.approx(6.86e-3, rel=0.02)
    assert np.abs(off_drawing(scenario, new)).max() < 0.8e-3
