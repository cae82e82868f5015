"""A hole whose block names one axis alone still gets its own correction in the other one, in every dialect."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from tests.compensation.mill import SETUP, body, rough, run, scale
from vcmm.program.interpret import interpret

FANUC = (
    "%\nO1\nG54 G90 G17 S1000 M3 F100\nG0 X0 Y0 Z50.\nG98 G83 X50. Y20. Z-30. R2. Q5.\nX350.\nG80\nM30\n%\n"
)
KLARTEXT = (
    "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S3000\n2 L X+0 Y+0 Z+50 R0 FMAX M3\n3 CYCL DEF 200 DRILLING ~\n Q200=+2 ~\n Q201=-30 ~\n"
    " Q206=+150 ~\n Q202=+5 ~\n Q210=+0 ~\n Q203=+0 ~\n Q204=+50 ~\n Q211=+0\n{holes}L Z+50 FMAX M30\n9 END PGM A MM\n"
)
SINUMERIK = "G54 G90 G17 S1000 M3 F100\nG0 X0 Y0 Z50\nMCALL CYCLE{cycle}\nX50 Y20\nX350\nMCALL\nG0 Z50\nM30\n"


def holes(found) -> list[tuple[str, ...]]:
    """X and Y of the blocks that stand over a hole: those whose X is near 50 or 350."""
    rows = [line for line in body(found) if re.search(r"X\+?(49\.99|349\.9)", line)]
    return [tuple(re.findall(r"[XY]\+?(-?[\d.]+)", line)) for line in rows]


@pytest.mark.parametrize(
    ("dialect", "text"),
    [
        ("fanuc", FANUC),
        ("sinumerik", SINUMERIK.format(cycle="81(10,0,2,-30)")),
        ("sinumerik", SINUMERIK.format(cycle="83(10,0,2,-30,,-5,,1,0,0,1,0)")),
        ("sinumerik", SINUMERIK.format(cycle="82(10,0,2,-30,,1)")),
        ("heidenhain", KLARTEXT.format(holes="L X+50 Y+20 FMAX M99\nL X+350 FMAX M99\n")),
        ("heidenhain", KLARTEXT.format(holes="L X+50 Y+20 FMAX M89\nL X+350 FMAX\n")),
        ("heidenhain", KLARTEXT.format(holes="L X+50 Y+20 FMAX\nCYCL CALL\nL X+350 FMAX\nCYCL CALL\n")),
    ],
)
def test_an_axis_that_is_not_named_is_corrected_for_its_hole(tmp_path, dialect, text):
    """Squareness 30 urad, EYX +-4 um, EXY: Y 20 becomes 20.004 at X 50 and 19.998 at X 350, as Fanuc's G83 has it."""
    found = run(tmp_path, text, rough(), replace(SETUP, dialect=dialect))
    assert holes(found) == [("49.998", "20.004"), ("349.981", "19.998")]
    assert found.is_met
    assert found.after.largest < 2e-3
    assert (
        found.rounding.largest < 0.87e-3 * 1.1
    )  # half a digit in three axes: nothing left off is called rounding


def test_what_leads_to_a_hole_stops_above_it_at_any_height(tmp_path):
    """The height of the approach is no height of the hole: no Z is added to its block."""
    text = SINUMERIK.format(cycle="81(10,0,2,-30)")
    lines = body(run(tmp_path, text, rough(), replace(SETUP, dialect="sinumerik")))
    assert not any("Z" in line for line in lines if line.startswith(("X49", "X349")))


def test_a_digit_of_an_inch_program_is_told_in_mm(tmp_path):
    """3 in / 1.00015 = 2.99955007 in, written 2.9996: 4.993e-5 in = 1.268 um are rounded off."""
    text = "%\nO1\nG20 G54 G90 G17 S1000 M3 F10.\nG0 X0 Y0 Z2.\nG98 G81 X3. Y2. Z-1. R.1\nG80\nM30\n%\n"
    found = run(tmp_path, text, scale(150.0))
    assert any("X2.9996" in line for line in body(found))
    assert found.rounding.largest == pytest.approx(1.2682e-3, rel=1e-3)


def drilled(text: str) -> list[tuple[float, ...]]:
    return [m.end for m in interpret(text, "fanuc", SETUP).moves if m.kind == "line"]


def test_heights_of_fanuc_given_under_g90_serve_holes_under_g91(tmp_path):
    """The holes of `G90 G81 ...` and `G91 X... K3` get the numbers that they get one by one under G90, within a digit."""
    text = "%\nO1\nG21 G54 G90 G17 S1000 M3 F100.\nG0 X0. Y0. Z50.\nG98 G81 X10. Y10. Z-12. R2.\n{}\nG80\nM30\n%\n"
    # the second block under G91: R 50 - 47 = 3, Z 3 - 15 = -12
    steps = text.format("G91 X80. K3\nZ-15. R-47.\nX-40.\nG90 X20. Y30.")
    apart = text.format("X90.\nX170.\nX250.\nX250. R3.\nX210.\nX20. Y30.")
    assert drilled(steps) == drilled(apart)
    one, other = (run(tmp_path, each, rough()) for each in (steps, apart))
    assert one.is_met
    assert np.abs(np.array(drilled(one.text)) - np.array(drilled(other.text))).max() < 1.1e-3
    assert drilled(one.text)[3][2] == pytest.approx(-12.005)  # EZX and the squareness at X 250
