"""A ray and a tool that stands still, by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.shop.cutting.standing_tool import entry
from vcmm.shop.cutting.tools import Cutter, ball, bull, cone, flat

X = [1.0, 0.0, 0.0]
Z = [0.0, 0.0, 1.0]


def met(tool: Cutter, start: list[float], way: list[float]) -> float:
    return float(entry(tool, np.array([start]), np.array([way]))[0])


def test_a_flat_mill() -> None:
    """R 5 from z = 0 upwards: from x = -20 at z 1 the wall comes after 15; from below its bottom after 2; beside it never."""
    assert met(flat(5.0), [-20, 0, 1], X) == pytest.approx(15.0)
    assert met(flat(5.0), [3, 0, -2], Z) == pytest.approx(2.0)
    assert met(flat(5.0), [6, 0, -2], Z) == math.inf
    assert met(flat(5.0, 8.0), [-20, 0, 9], X) == math.inf  # over its length


def test_a_ball() -> None:
    """R 5, 3 mm beside the axis: the ball is 5 - 4 = 1 mm over the tip there; at z 1 its radius is 3, so x = -20 meets it after 17."""
    assert met(ball(5.0), [3, 0, -2], Z) == pytest.approx(3.0)
    assert met(ball(5.0), [-20, 0, 1], X) == pytest.approx(17.0)


def test_a_rounded_corner() -> None:
    """R 5 with r 1: 4.6 mm beside the axis the corner is 1 - sqrt(1 - 0.36) = 0.2 mm over the tip."""
    assert met(bull(5.0, 1.0), [4.6, 0, -2], Z) == pytest.approx(2.2)
    assert met(bull(5.0, 1.0), [2.0, 0, -2], Z) == pytest.approx(2.0)


def test_a_cone() -> None:
    """90 deg from a tip of radius 1: 3 mm beside the axis it is 2 mm over the tip."""
    assert met(cone(5.0, math.radians(90.0), 1.0), [3, 0, -2], Z) == pytest.approx(4.0)
    assert met(cone(5.0, math.radians(90.0), 1.0), [-20, 0, 2], X) == pytest.approx(17.0)
