"""Shift, mirror, rotation, scale, presets: what builds up on one another in the order in which it is programmed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.program.heidenhain.klartext import SETUP, check, ends

SURVEY = replace(SETUP, strict=False)
TURN = "CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+90\n"


def test_a_shift_after_a_rotation_lies_along_the_turned_axes():
    """(2, 0) shifted by (10, 0) along X turned to +Y: (0, 12)."""
    text = f"{TURN}CYCL DEF 7.0\nCYCL DEF 7.1 X+10\nL X+2 FMAX"
    check(text, (0, 12, 0), setup=SURVEY)


def test_a_preset_ends_the_transformations():
    """247: "resets datum shift, mirror image, rotation, scaling factor"; G55 lies at 100, 50, -10."""
    check(f"CYCL DEF 7.0\nCYCL DEF 7.1 X+10\n{TURN}CYCL DEF 247 Q339=+2\nL X+1 Y+0 Z+0 FMAX", (101, 50, -10))
    check("CYCL DEF 247 Q339=+9\nL X+1 FMAX", (1, 0, 0), setup=SURVEY)


def test_scales_of_single_axes_about_a_point():
    """26: X by 2 about X = 5: 6 becomes 5 + 2."""
    check("CYCL DEF 26.0\nCYCL DEF 26.1 X2 CCX5\nL X+6 Y+3 FMAX", (7, 3, 0))


def test_mirror_inside_a_rotation():
    """Programmed later, so inside: (1, 2) mirrored to (-1, 2), turned by 90 deg: (-2, -1)."""
    check(f"{TURN}CYCL DEF 8.0\nCYCL DEF 8.1 X\nL X+1 Y+2 FMAX", (-2, -1, 0), setup=SURVEY)


def test_a_rotation_programmed_again_keeps_its_place():
    text = f"CYCL DEF 7.0\nCYCL DEF 7.1 X+100\n{TURN}CYCL DEF 11.0\nCYCL DEF 11.1 SCL2\n{TURN.replace('90', '180')}L X+1 FMAX"
    assert np.allclose(ends(text), [(98, 0, 0)])
