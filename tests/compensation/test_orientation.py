"""Directions of the tool corrected: where the machine with its errors really points it comes where it was programmed."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from tests.compensation.test_led_programs import READY, axes_by_hand
from tests.shop.motion.test_tool_centre import HEAD, LENGTH, TABLES, about, machine
from vcmm.compensation.job import compensate
from vcmm.core.errors import DataError, ModelLimit
from vcmm.core.run import Run
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.component import ComponentPolynomial
from vcmm.physics.structure.squareness import RotaryLocation

COUNT = 24
OFF = 50e-6  # rad
ERRORS = (
    RotaryLocation("A0C", tilt=OFF),
    RotaryLocation("C0B", tilt=-0.6 * OFF),
    ComponentPolynomial("EBB", np.array([30e-6, 20e-6])),
)
ZERO = np.array([0.0, 0.0, -400.0])


def path() -> list[tuple[float, ...]]:
    """x y z b c: round a circle of 30 mm leaning by 15 to 35 deg, never near the axis of C."""
    turns = [2 * math.pi * k / (COUNT - 1) for k in range(COUNT)]
    return [
        (30 * math.cos(t), 30 * math.sin(t), math.sin(3 * t) - 2, 25 + 10 * math.sin(t), 6.366 * t)
        for t in turns
    ]


def rotary_lines(start: str = "G1 ") -> str:
    sign = "+" if start == "L " else ""
    number = "{:" + sign + ".3f}"
    words = " ".join(f"{a}{number}" for a in "XYZBC")
    return "".join(f"{start}{words.format(*p)} F800\n" for p in path())


def fanuc(lines: str) -> str:
    return f"%\nO1\nG21 G90 G54 G94\nT1 M6\nG43.4 H1 G0 X30. Y0 Z20. B25. C0.\n{lines}G0 Z60.\nG49\nM30\n%\n"


TEXTS = {
    "fanuc": fanuc(rotary_lines()),
    "sinumerik": f"G90 G54 G71\nT1 D1\nM6\nG0 X30 Y0 Z40\nTRAORI\nG0 X30 Y0 Z20 B25 C0\n{rotary_lines()}G0 Z60\nTRAFOOF\nM30\n",
    "heidenhain": f"BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nL X+30 Y+0 Z+40 FMAX M128\nL X+30 Y+0 Z+20 B+25 C+0 FMAX\n{rotary_lines('L ')}L Z+60 FMAX\nM129\nEND PGM A MM\n",
}


def pointing(structure: str, b: float, c: float) -> np.ndarray:
    """Tool axis in the workpiece by rotation matrices: a head turns the tool by B then C, a table the other way round; rad."""
    turned = about("C", c) @ about("B", b)
    return turned @ np.array([0.0, 0.0, 1.0])


def exact(mill, structure: str, words: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """(tip, tool axis) where the machine with its errors has them, by exact transforms; words: X Y Z B C of a block."""
    x, y, z, b, c = words
    rotary = np.array([0.0, math.radians(b), math.radians(c)])
    commanded = ZERO + [x, y, z]
    axes = axes_by_hand(structure, commanded, rotary) + [0.0, 0.0, LENGTH]
    position = {a: np.full(2, v) for a, v in zip("XYZ", axes)} | {
        a: np.full(2, rotary["ABC".index(a)]) for a in "BC"
    }
    run = Run(position, np.array([[0.0, 0.0, -LENGTH], [0.0, 0.0, 0.0]]))
    off = mill.tip_error(run, exact=True)
    nominal = pointing(structure, rotary[1], rotary[2])
    return commanded + off[0], nominal + (off[1] - off[0]) / LENGTH


def written(text: str) -> list[list[float]]:
    number = r"([-+]?\d+\.?\d*)"
    found = re.findall(rf"X{number} Y{number} Z{number} B{number} C{number} F800", text)
    return [list(map(float, words)) for words in found]


@pytest.mark.parametrize(
    ("dialect", "structure"),
    [("fanuc", TABLES), ("fanuc", HEAD), ("sinumerik", HEAD), ("heidenhain", TABLES)],
)
def test_the_tool_points_where_it_was_programmed(tmp_path, dialect, structure):
    mill = replace(machine(structure), effects=ERRORS)
    file = tmp_path / "part.nc"
    file.write_text(TEXTS[dialect])
    ready = replace(READY, dialect=dialect)
    found = compensate(file, ready, mill, decimals=5, orientation=True, set_here=False)
    assert found.is_met
    assert found.orientation.before.largest > 30e-6
    assert found.orientation.after.largest < 1e-6
    blocks, plain = written(found.text), written(TEXTS[dialect])
    assert len(blocks) == COUNT
    before, after, tips = [], [], []
    for new, old in zip(blocks, plain):
        wanted = pointing(structure, math.radians(old[3]), math.radians(old[4]))
        before.append(np.linalg.norm(exact(mill, structure, old)[1] - wanted))
        tip, axis = exact(mill, structure, new)
        after.append(np.linalg.norm(axis - wanted))
        tips.append(np.linalg.norm(tip - ZERO - old[:3]))
    assert found.orientation.before.largest == pytest.approx(max(before), rel=0.02)
    assert (
        max(after) < 2e-7
    )  # half a digit of 1e-5 deg is 0.09 urad in either axis, and 1e-8 of the second order
    assert max(tips) < 1e-4


def test_an_axis_that_stands_off_is_written_off_as_much(tmp_path):
    # B stands 50 urad further than it says, everywhere: 50e-6 rad = 0.00286 deg less
    mill = replace(machine(HEAD), effects=(ComponentPolynomial("EBB", np.array([OFF])),))
    file = tmp_path / "part.nc"
    file.write_text(TEXTS["fanuc"])
    found = compensate(file, replace(READY, dialect="fanuc"), mill, decimals=5, orientation=True)
    for new, old in zip(written(found.text), written(TEXTS["fanuc"])):
        assert new[3] - old[3] == pytest.approx(-math.degrees(OFF), abs=6e-6)
        assert new[4] == pytest.approx(old[4], abs=1e-9)
    assert found.orientation.before.largest == pytest.approx(OFF, rel=1e-3)


def test_angles_that_need_no_change_stay_byte_for_byte(tmp_path):
    mill = replace(machine(HEAD), effects=(ScaleFactor("X", 100e-6),))
    file = tmp_path / "part.nc"
    file.write_text(TEXTS["fanuc"])
    found = compensate(file, replace(READY, dialect="fanuc"), mill, orientation=True)
    angles = [re.findall(r"[BC][-.\d]+", text) for text in (found.text, TEXTS["fanuc"])]
    assert angles[0] == angles[1]
    assert "B25. C0." in found.text


def test_without_asking_angles_stay(tmp_path):
    file = tmp_path / "part.nc"
    file.write_text(TEXTS["fanuc"])
    found = compensate(file, replace(READY, dialect="fanuc"), replace(machine(HEAD), effects=ERRORS))
    assert found.orientation is None
    assert [w[3:] for w in written(found.text)] == [w[3:] for w in written(TEXTS["fanuc"])]


@pytest.mark.parametrize(
    ("dialect", "head", "line", "vector"),
    [
        ("fanuc", "%\nO1\nG21 G90 G54 G94\nT1 M6\nG43.5 H1 G0 X0 Y0 Z20. I0.5 J0. K0.8660254\n", "G1 X40. Y10. Z-2. I0.5 J0.1 K0.86 F800\nG0 Z60.\nM30\n%\n", r"I(\S+) J(\S+) K(\S+) F800"),
        ("sinumerik", "G90 G54 G71\nT1 D1\nM6\nG0 X30 Y0 Z40\nTRAORI\nG0 X0 Y0 Z20 A3=0.5 B3=0 C3=0.8660254\n", "G1 X40 Y10 Z-2 A3=0.5 B3=0.1 C3=0.86 F800\nG0 Z60\nM30\n", r"A3=(\S+) B3=(\S+) C3=(\S+) F800"),
        ("heidenhain", "BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nL X+30 Y+0 Z+40 FMAX M128\nLN X+0 Y+0 Z+20 TX+0.5 TY+0 TZ+0.8660254 FMAX\n", "LN X+40 Y+10 Z-2 TX+0.5 TY+0.1 TZ+0.86 F800\nL Z+60 FMAX\nM129\nEND PGM A MM\n", r"TX(\S+) TY(\S+) TZ(\S+) F800"),
    ],
)  # fmt: skip
def test_directions_of_the_tool_are_written_anew(tmp_path, dialect, head, line, vector):
    mill = replace(machine(HEAD), effects=ERRORS)
    file = tmp_path / "part.nc"
    file.write_text(head + line)
    found = compensate(file, replace(READY, dialect=dialect), mill, decimals=7, orientation=True)
    new = np.array([float(v) for v in re.findall(vector, found.text)[-1]])
    old = np.array([0.5, 0.1, 0.86])
    assert np.linalg.norm(new) == pytest.approx(np.linalg.norm(old), abs=1e-6)
    assert 20e-6 < np.linalg.norm(new - old) < 200e-6
    assert found.orientation.before.largest > 20e-6
    assert found.orientation.after.largest < 1e-6


def test_what_cannot_be_turned_is_refused_with_its_line(tmp_path):
    mill, file = replace(machine(HEAD), effects=ERRORS), tmp_path / "part.nc"
    for lines, kind, message in (
        ("G1 X10. Z-2. B0. C0. F800\n", ModelLimit, r"part.nc:6:1: .*a singular position.*--orientation"),
        ("G91 G1 X1. B1. F800\nG90\n", DataError, r"part.nc:6:1: B turns the tool and is not rewritten"),
        ("G1 X10. Z-2. B[20.+5.] C0. F800\n", DataError, r"part.nc:6:1: B turns the tool"),
    ):
        file.write_text(fanuc(lines))
        with pytest.raises(kind, match=message):
            compensate(file, replace(READY, dialect="fanuc"), mill, orientation=True)
    file.write_text(fanuc("G1 X10. Z-2. B29.9999 C0. F800\n"))
    tight = replace(
        machine(HEAD, B=math.radians(30.0)), effects=(ComponentPolynomial("EBB", np.array([-OFF])),)
    )
    with pytest.raises(
        ModelLimit, match=r"part.nc:6:1: axis B = 30\.0028 deg is outside its travel -30 to 30 deg"
    ):
        compensate(file, replace(READY, dialect="fanuc"), tight, orientation=True)


def test_a_program_that_turns_nothing_is_told(tmp_path):
    file = tmp_path / "part.nc"
    file.write_text("%\nO1\nG21 G90 G54 G94\nT1 M6\nG43 H1 G0 X0 Y0 Z20.\nG1 X40. F800\nM30\n%\n")
    found = compensate(
        file, replace(READY, dialect="fanuc"), replace(machine(HEAD), effects=ERRORS), orientation=True
    )
    assert any("no block turns the tool" in w for w in found.warnings)
