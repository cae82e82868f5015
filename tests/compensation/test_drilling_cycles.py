"""Holes of Sinumerik and Klartext by hand: straight over the mean of their corrections, heights in the definition."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.compensation.mill import SETUP, body, mill, run
from vcmm.core.errors import DataError
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.squareness import Squareness

SINUMERIK = (
    "G54 G90 G17 S1000 M3 F100\nG0 X0 Y0 Z50\nMCALL CYCLE81(50,0,2,-30)\nX100 Y0\nMCALL\nG0 Z50\nM30\n"
)


def test_a_scale_moves_the_hole(tmp_path) -> None:
    """100 um/m at X 100: the hole is drilled at X 99.990."""
    found = run(tmp_path, SINUMERIK, mill(ScaleFactor("X", 100e-6)), replace(SETUP, dialect="sinumerik"))
    assert "X99.990 Y0\n" in body(found)


def test_a_lean_is_met_half_way(tmp_path) -> None:
    """1 mrad between X and Z: from R 2 to -30 the tool leans by 32 um; the hole stands over the mean, at -14: 14 um beside."""
    lean = mill(Squareness("B0Z", 1e-3))
    found = run(tmp_path, SINUMERIK, lean, replace(SETUP, dialect="sinumerik"))
    (line,) = [text for text in body(found) if "X99.9" in text or "X100.0" in text]
    value = float(line.split()[0].removeprefix("X"))
    assert abs(value - 100.0) == pytest.approx(0.014, abs=0.0011)


def test_depth_follows_the_scale_of_z(tmp_path) -> None:
    """100 um/m along Z: at -30 the tool errs by -3 um, so the definition says 3 um less; the retract plane stays."""
    found = run(tmp_path, SINUMERIK, mill(ScaleFactor("Z", 100e-6)), replace(SETUP, dialect="sinumerik"))
    (cycle,) = [text for text in body(found) if "CYCLE81" in text]
    assert "-29.997" in cycle


def test_an_expression_in_a_definition_is_refused_by_its_line(tmp_path) -> None:
    text = SINUMERIK.replace("-30)", "R1)").replace("G54", "R1=-30\nG54", 1)
    with pytest.raises(DataError, match="is an expression; write it as a number") as caught:
        run(tmp_path, text, mill(ScaleFactor("Z", 100e-6)), replace(SETUP, dialect="sinumerik"), inline=0.0)
    assert caught.value.line == 4
