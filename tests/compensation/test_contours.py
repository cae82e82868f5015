"""Lines and arcs of a program by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.compensation.contours import (
    directions,
    left_normal,
    length_of,
    nearest_share,
    nominal_distance,
    points,
    sweep_of,
)
from vcmm.program.interpret import interpret
from vcmm.program.moves import Move
from vcmm.program.setup import Setup

HEAD = "%\nO1\nG21 G17 G40 G80 G90 G94 G54\nG0 X10. Y0 Z0\n"


def move(block: str) -> Move:
    """The last move of a program that stands at X10 Y0 before it."""
    setup = Setup(dialect="fanuc", offsets={"G54": (0.0, 0.0, 0.0)})
    return interpret(f"{HEAD}{block} F100\nM30\n%\n", "fanuc", setup, "part.nc").moves[-1]


def test_a_quarter_to_the_left() -> None:
    """R 10 about 0 from (10, 0): 90 deg, 15.708 mm, its middle at (7.071, 7.071), there towards (-1, 1)."""
    m = move("G3 X0 Y10. I-10. J0")
    assert sweep_of(m) == pytest.approx(math.pi / 2)
    assert length_of(m) == pytest.approx(5 * math.pi)
    assert points(m, np.array([0.5]))[0] == pytest.approx([math.sqrt(50), math.sqrt(50), 0.0])
    assert directions(m, np.array([0.5]))[0] == pytest.approx([-math.sqrt(0.5), math.sqrt(0.5), 0.0])


def test_a_whole_circle_to_the_right() -> None:
    m = move("G2 X10. Y0 I-10. J0")
    assert sweep_of(m) == pytest.approx(-2 * math.pi)
    assert points(m, np.array([0.25]))[0] == pytest.approx([0.0, -10.0, 0.0])


def test_a_helix_is_longer_by_its_rise() -> None:
    m = move("G3 X0 Y10. Z-6. I-10. J0")
    assert length_of(m) == pytest.approx(math.hypot(5 * math.pi, 6.0))
    assert points(m, np.array([0.5]))[0, 2] == pytest.approx(-3.0)


def test_left_of_the_way() -> None:
    """Along +X the left is +Y; straight down there is none."""
    way = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    assert left_normal(way, "XY") == pytest.approx(np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0]]))


def test_the_nearest_point_of_a_line_and_of_an_arc() -> None:
    """2 mm beside the middle of a line of 10 mm; 1 mm outside a quarter of R 10 at 45 deg; before an end its end counts."""
    line, arc = move("G1 X20."), move("G3 X0 Y10. I-10. J0")
    out = (11.0 * math.sqrt(0.5),) * 2
    at = np.array([[15.0, 2.0, 0.0], [*out, 0.0], [7.0, 4.0, 0.0]])
    off = nominal_distance(at, [line, arc], np.array([0, 1, 0]))
    assert off[0] == pytest.approx([0.0, 2.0, 0.0])
    assert np.linalg.norm(off[1]) == pytest.approx(1.0)
    assert off[2] == pytest.approx([-3.0, 4.0, 0.0])
    assert nearest_share(arc, at[1:2]) == pytest.approx([0.5])
