"""Programs under tool centre point control rewritten: every block end, with the exact machine, comes where it was programmed."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from tests.compensation.mill import wavy
from tests.shop.motion.test_tool_centre import HEAD, LENGTH, SETUP, TABLES, by_hand, machine
from vcmm.compensation.job import compensate
from vcmm.core.errors import ModelLimit
from vcmm.core.run import Run
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.squareness import RotaryLocation, Squareness

COUNT = 24
ZERO = np.array([0.0, 0.0, -400.0])
READY = replace(SETUP, compensation=())
ERRORS = (
    ScaleFactor("X", 60e-6),
    Squareness("C0Y", 30e-6),
    wavy("EYX", 4.0, 300.0),
    RotaryLocation("X0C", offset=10e-3),
)


def path() -> list[tuple[float, ...]]:
    """x y z b c: round a circle of 30 mm, up and down, leaning by up to 20 deg, while C turns by 40 deg."""
    turns = [2 * math.pi * k / (COUNT - 1) for k in range(COUNT)]
    return [
        (30 * math.cos(t), 30 * math.sin(t), math.sin(3 * t) - 2, 20 * math.sin(t), 6.366 * t) for t in turns
    ]


def fanuc() -> str:
    lines = [f"G1 X{x:.3f} Y{y:.3f} Z{z:.3f} B{b:.3f} C{c:.3f} F800\n" for x, y, z, b, c in path()]
    return f"%\nO1\nG21 G90 G54 G94\nT1 M6\nG43.4 H1 G0 X30. Y0 Z20. B0 C0\n{''.join(lines)}G0 Z60.\nG49\nM30\n%\n"


def sinumerik() -> str:
    lines = [f"G1 X{x:.3f} Y{y:.3f} Z{z:.3f} B{b:.3f} C{c:.3f} F800\n" for x, y, z, b, c in path()]
    return f"G90 G54 G71\nT1 D1\nM6\nG0 X30 Y0 Z40\nTRAORI\n{''.join(lines)}G0 Z60\nTRAFOOF\nM30\n"


def klartext() -> str:
    lines = [f"L X{x:+.3f} Y{y:+.3f} Z{z:+.3f} B{b:+.3f} C{c:+.3f} F800\n" for x, y, z, b, c in path()]
    return f"BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nL X+30 Y+0 Z+40 FMAX M128\n{''.join(lines)}L Z+60 FMAX\nM129\nEND PGM A MM\n"


def axes_by_hand(structure: str, at: np.ndarray, rotary: np.ndarray) -> np.ndarray:
    """X, Y, Z (less the tool length) that lead the tip to a point: `by_hand` is affine in them."""
    origin = by_hand(structure, np.zeros(3), rotary)
    ways = np.stack([by_hand(structure, e, rotary) - origin for e in np.eye(3)], axis=1)
    return np.linalg.solve(ways, at - origin)


def error(mill, tip: np.ndarray, rotary: np.ndarray) -> np.ndarray:
    """Exact tip error (3,) mm, workpiece axes, of axes at tip + tool length."""
    position = {a: np.array([v]) for a, v in zip("XYZ", tip + [0.0, 0.0, LENGTH])}
    position |= {a: np.array([rotary["ABC".index(a)]]) for a in "BC"}
    return mill.tip_error(Run(position, np.array([[0.0, 0.0, -LENGTH]])), exact=True)[0]


@pytest.mark.parametrize("structure", [TABLES, HEAD])
@pytest.mark.parametrize(
    ("dialect", "text"), [("fanuc", fanuc()), ("sinumerik", sinumerik()), ("heidenhain", klartext())]
)  # fmt: skip
def test_block_ends_come_where_they_were_programmed(tmp_path, dialect, text, structure):
    mill = replace(machine(structure), effects=ERRORS)
    file = tmp_path / "part.nc"
    file.write_text(text)
    found = compensate(file, replace(READY, dialect=dialect), mill, decimals=4)
    assert found.is_met
    assert found.before.largest > 5e-3
    assert found.after.largest < 1e-3
    number = r"([-+]?\d+\.?\d*)"
    blocks = re.findall(rf"X{number} Y{number} Z{number} B{number} C{number} F800", found.text)
    assert len(blocks) == COUNT
    at_zero = error(mill, ZERO, np.zeros(3))
    off = []
    for words, wanted in zip(blocks, path()):
        x, y, z, b, c = map(float, words)
        rotary = np.array([0.0, math.radians(b), math.radians(c)])
        commanded = ZERO + [x, y, z]
        actual = commanded + error(mill, axes_by_hand(structure, commanded, rotary), rotary) - at_zero
        off.append(np.linalg.norm(actual - ZERO - np.round(wanted[:3], 3)))
        assert (b, c) == pytest.approx([round(v, 3) for v in wanted[3:]])  # angles are left as they are
    assert max(off) < 2e-4  # half a digit of 0.1 um in three axes, and 5 nm of the first order


def test_directions_of_the_tool_are_led_too(tmp_path):
    text = "%\nO1\nG21 G90 G54 G94\nT1 M6\nG43.5 H1 G0 X0 Y0 Z20.\nG1 X40. Y10. Z-2. I0.5 J0 K0.8660254 F800\nG0 Z60.\nM30\n%\n"
    file = tmp_path / "part.nc"
    file.write_text(text)
    found = compensate(file, replace(READY, dialect="fanuc"), replace(machine(HEAD), effects=ERRORS[:2]))
    assert found.is_met
    assert "I0.5 J0 K0.8660254" in found.text
    assert found.before.largest > 1e-3 > found.after.largest


def test_what_needs_the_state_of_the_axes_is_left_and_said(tmp_path):
    file = tmp_path / "part.nc"
    file.write_text(fanuc())
    mill = replace(machine(TABLES), effects=(ScaleFactor("X", 60e-6), Backlash("X", gap=4e-3)))
    found = compensate(file, replace(READY, dialect="fanuc"), mill, decimals=4)
    assert found.is_met
    assert any("backlash" in w and "not corrected" in w for w in found.warnings)


def test_a_rotary_axis_that_turns_along_a_cut_without_control_of_the_tip_is_refused(tmp_path):
    file = tmp_path / "part.nc"
    file.write_text("%\nO1\nG21 G90 G54 G94\nT1 M6\nG43 H1 G0 X0 Y0 Z20.\nG1 X40. B30. F800\nM30\n%\n")
    with pytest.raises(ModelLimit, match=r"part.nc:6:.*Post it with tool centre point control"):
        compensate(file, replace(READY, dialect="fanuc"), machine(TABLES))
