"""Rolling stylus on the scallops of a ball mill, R 5, lines 0.5 mm apart along x: numbers by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.shop.cutting.stylus import roll_ball
from vcmm.shop.cutting.sweeps import join, lines
from vcmm.shop.cutting.tools import ball, flat

RASTER = join(lines([[-10, y, 0.0]], [[20, y, 0.0]], (ball(5.0),)) for y in np.arange(0.0, 10.1, 0.5))
CREST = 5 - math.sqrt(25 - 0.0625)  # 6.2539 um
P = np.array([[5.0, 5.0, 0.0], [5.0, 5.25, 0.0], [5.0, 5.1, 0.0]])
UP = np.tile([0.0, 0.0, 1.0], (3, 1))


def test_a_stylus_larger_than_the_cutter_rests_on_the_crests() -> None:
    """r 20. Over a line both crests, 0.25 mm away: 6.2539 - 0.25^2/40 = 6.2539 - 1.5626 = 4.6913 um. On a crest: 6.2539 um.

    0.1 mm beside the line the nearer crest, 0.15 mm away: 6.2539 - 0.0225/40 = 5.6914 um.
    """
    found = roll_ball(P, UP, 20.0, RASTER)
    sag = [20 - math.sqrt(400 - d * d) for d in (0.25, 0.0, 0.15)]
    assert pytest.approx(6.2539e-3, abs=1e-7) == CREST
    assert found.s == pytest.approx([CREST - x for x in sag], abs=2e-6)
    assert found.s[0] == pytest.approx(4.6913e-3, abs=2e-6)
    assert abs(found.offset[0, 1]) == pytest.approx(0.25, abs=1e-3)
    assert not found.beside_uncut.any()
    assert not found.at_reach.any()


def test_a_small_stylus_reaches_the_valley() -> None:
    """r 1.5 < R 5: over a line it touches the bottom, 0. At 0.1 mm beside: two circles R 5 and r 1.5 touch in the line of
    their centres, 5 - sqrt(3.5^2 - 0.1^2) - 1.5 = 1.4289 um.
    """
    found = roll_ball(P[[0, 2]], UP[:2], 1.5, RASTER)
    assert found.s[0] == pytest.approx(0.0, abs=1e-9)
    assert found.s[1] == pytest.approx(3.5 - math.sqrt(3.5**2 - 0.01), abs=2e-6)


def test_uncut_places_are_said() -> None:
    one = lines([[-10, 0, 0]], [[20, 0, 0]], (flat(5.0),))
    found = roll_ball(np.array([[0, 4.9, 0], [0, 6.0, 0]]), UP[:2], 1.5, one)
    assert found.s[0] == pytest.approx(0.0, abs=1e-12)
    assert found.beside_uncut[0]
    assert np.isnan(found.s[1])
