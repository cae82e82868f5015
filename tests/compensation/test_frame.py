"""From points of the machine to numbers of a program and back, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.compensation.frame import frame_of
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup


def frame(head: str, dialect: str = "fanuc"):
    setup = Setup(dialect=dialect, offsets={"G54": (100.0, 50.0, -20.0)})
    text = f"%\nO1\n{head}\nG1 X1. F100\nM30\n%\n"
    return frame_of(interpret(text, dialect, setup, "part.nc", trace=True).traces[-1])


def test_millimetres_count_from_the_offset() -> None:
    f = frame("G21 G17 G90 G94 G54")
    assert f.numbers(np.array([103.0, 51.0, -20.0])) == pytest.approx([3.0, 1.0, 0.0])
    assert f.tip(np.array([3.0, 1.0, 0.0])) == pytest.approx([103.0, 51.0, -20.0])
    assert (f.absolute, f.inch) == (True, False)


def test_inches_and_increments() -> None:
    """25.4 mm are one inch; a vector knows no offset."""
    f = frame("G20 G17 G91 G94 G54")
    assert f.ways(np.array([25.4, 0.0, -50.8])) == pytest.approx([1.0, 0.0, -2.0])
    assert f.length(12.7, 0) == pytest.approx(0.5)
    assert (f.absolute, f.inch) == (False, True)


def test_a_rotation_turns_the_numbers() -> None:
    """G68 R90 about 0: what the program calls +X is +Y of the machine."""
    f = frame("G21 G17 G90 G94 G54\nG68 X0 Y0 R90.")
    assert f.numbers(np.array([100.0, 57.0, -20.0])) == pytest.approx([7.0, 0.0, 0.0])


def test_diameters_of_a_lathe() -> None:
    """10 mm from the axis are X20; a way is never a diameter."""
    f = frame("G21 G18 G99 G54 G97 S500 M3", "fanuc-lathe")
    assert f.numbers(np.array([110.0, 50.0, -20.0]))[0] == pytest.approx(20.0)
    assert f.ways(np.array([10.0, 0.0, 0.0]))[0] == pytest.approx(10.0)
