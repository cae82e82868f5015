"""Profiles of cutters against their implicit functions."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.core.run import Array
from vcmm.shop.cutting.tools import Cutter, ball, bull, cone, drill, flat, implicit, nose_height

TOOLS = {
    "flat": flat(5.0),
    "ball": ball(5.0),
    "bull": bull(5.0, 1.5),
    "cone": cone(5.0, math.radians(90.0), 1.0),
    "drill": drill(5.0),
    "short": flat(5.0, 6.0),
}


def profile(tool: Cutter, height: Array) -> Array:
    """Return the radius (...) of the tool at heights (...) over its tip, mm; nothing (-1) below the tip and above its length."""
    h = np.asarray(height, float)
    if tool.shape == "cone":
        radius = np.minimum(tool.tip_radius + h * math.tan(tool.half_angle), tool.radius)
    else:
        below = np.clip(tool.corner - h, 0.0, tool.corner)
        radius = tool.radius - tool.corner + np.sqrt(tool.corner**2 - below**2)
    return np.where((h >= 0.0) & (h <= tool.length), radius, -1.0)


def test_profiles_agree_with_the_implicit_function() -> None:
    """The circle of `profile` at each height is the zero of `implicit`."""
    for tool in TOOLS.values():
        h = np.linspace(0.01, 5.9, 60)
        assert np.allclose(implicit(tool, profile(tool, h), h), 0.0, atol=1e-13)
    assert profile(ball(5.0), np.array([1.0]))[0] == pytest.approx(3.0)  # 5^2 = 4^2 + 3^2
    assert profile(bull(5.0, 1.0), np.array([0.0]))[0] == pytest.approx(4.0)


def test_height_of_the_nose_by_hand() -> None:
    """A cone of 90 deg from R 1 to R 5 rises by 4 mm; a ball by its radius; a drill of 118 deg by 5 / tan 59 deg."""
    assert nose_height(cone(5.0, math.radians(90.0), 1.0)) == pytest.approx(4.0)
    assert nose_height(ball(5.0)) == 5.0
    assert nose_height(drill(5.0)) == pytest.approx(3.0043, abs=1e-4)
