"""FUNCTION and TRANS blocks."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.program.heidenhain.klartext import SETUP, check, moves
from vcmm.core.errors import DataError

SURVEY = replace(SETUP, strict=False)


def test_transformations_of_the_newer_controls():
    text = "TRANS DATUM AXIS X+10 Y+5\nL X+1 Y+0 FMAX\nTRANS ROTATION ROT+90\nL X+1 Y+0 FMAX\nTRANS ROTATION RESET\nTRANS DATUM RESET\nL X+1 FMAX"
    check(text, (11, 5, 0), (10, 6, 0), (1, 6, 0))
    check("TRANS MIRROR AXIS X\nL X+2 FMAX\nTRANS MIRROR RESET\nTRANS SCALE SCL0.5\nL X+2 FMAX\nTRANS SCALE RESET\nL X+2 FMAX",
          (-2, 0, 0), (1, 0, 0), (2, 0, 0))  # fmt: skip


def test_modes_that_move_nothing():
    check("FUNCTION MODE MILL\nL X+1 FMAX", (1, 0, 0))
    assert moves("FUNCTION DWELL TIME 2.5")[0].seconds == 2.5
    check('FUNCTION FILE COPY "A" TO "B"\nFUNCTION PARAXCOMP DISPLAY W\nL X+1 FMAX', (1, 0, 0), setup=SURVEY)
    with pytest.raises(DataError, match="FUNCTION MODE TURN is not understood"):
        moves("FUNCTION MODE TURN")
    with pytest.raises(DataError, match="TRANS takes DATUM"):
        moves("TRANS SHEAR X+1")
