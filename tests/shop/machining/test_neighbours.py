"""The deepest of many places along a path, and the tool a little before and after its contact, by hand."""

from __future__ import annotations

import numpy as np
import pytest

import vcmm
from tests.shop.machining import hole
from vcmm.shop.cutting.envelope import surface_left, tips
from vcmm.shop.cutting.sweeps import lines, position
from vcmm.shop.cutting.tools import flat
from vcmm.shop.machining.job import cut, patch
from vcmm.shop.machining.maps import net
from vcmm.shop.machining.neighbours import OFFSETS, STEPS, candidates, deepest_between
from vcmm.shop.machining.preparation import set_up


def test_the_deepest_lies_between_the_steps():
    """(at - 0.2)^2, moved with at: asked at -0.3, -0.1 ... the least is found at 0.2 to 1e-5 mm."""

    def heights(which, at):
        return (at - 0.2) ** 2, np.repeat(at[..., None], 3, axis=2)

    points, at = deepest_between(heights, 1, STEPS)
    assert points.tolist() == [0]
    assert at == pytest.approx([0.2], abs=1e-4)


def test_the_search_keeps_to_the_steps_beside_the_deepest():
    """(at - 0.15)^2 at -1, 0, 1: the deepest step is 0, so that it is sought from -1 to 1 and not beyond; found to 4^-7 = 6e-5 of the reach."""
    asked = []

    def heights(which, at):
        asked.append(at)
        return (at - 0.15) ** 2, np.repeat(at[..., None], 3, axis=2)

    _, at = deepest_between(heights, 1, np.array([-2.0, -1.0, 0.0, 1.0]))
    assert (asked[1].min(), asked[1].max()) == (-1.0, 1.0)
    assert at == pytest.approx([0.15], abs=1e-4)


def test_what_is_moved_alike_everywhere_is_not_searched():
    points, at = deepest_between(lambda which, at: ((at - 0.2) ** 2, np.zeros((*at.shape, 3))), 1, STEPS)
    assert len(points) == len(at) == 0


def test_a_wall_is_passed_on_either_side():
    """R 10 along +X beside a wall: d before the contact the wall stands 10 - sqrt(100 - d^2) further off; d = 0.02 x 10: 2 um."""
    sweep = lines([[-50.0, 10.0, 0.0]], [[50.0, 10.0, 0.0]], (flat(10.0),))
    point, normal = np.array([[0.0, 0.0, 5.0]]), np.array([[0.0, 1.0, 0.0]])
    surface = surface_left(point, normal, sweep, candidates=1)
    assert surface.s == pytest.approx([0.0], abs=1e-12)

    def standing(row, share):
        return position(sweep.take(row), share), None

    found = candidates(surface, sweep, tips(surface, sweep), standing)
    near = found.height[0][found.row[0] >= 0]
    d = 10.0 * OFFSETS[:3]
    expected = 10.0 - np.sqrt(100.0 - d**2)
    assert np.unique(near.round(9)) == pytest.approx(np.append(0.0, expected), abs=2e-9)
    assert np.sum(found.row[0] >= 0) == 1 + 2 * len(d)  # the next stands more than 50 um off


OUT_OF_SQUARE = '[[effects]]\neffect = "squareness"\npair = "B0Z"\nangle = "60 urad"\n'


@pytest.mark.parametrize(
    ("cycle", "shape"),
    [(hole.DRILL, "drill"), (hole.DRILL, "flat"), (hole.PECK, "flat")],
    ids=["drill", "mill", "pecks"],
)
def test_the_wall_of_a_hole_drilled_out_of_square_is_straight(tmp_path, cycle, shape):
    """Z leans by 60 urad: the tool goes down along a slant, its wall is left where it passes last.

    On the side +x that is where the tool arrives, at the height of the point itself: 60 urad x depth; on the side -x it is the
    bottom at -45 mm, 2.70 um everywhere. The axis leans by half of 60 urad: 1.20 um over 40 mm.
    """
    ready = set_up(vcmm.load_cut(hole.write(tmp_path, OUT_OF_SQUARE, cycle, shape)))
    found = patch(ready, net(ready.scenario.part.features["hole"], 9))
    x, z = found.net.points[:, 0], found.net.points[:, 2]
    moved = 1e3 * (found.height - found.nominal)
    nose = 5.0 / np.tan(np.radians(59.0)) if shape == "drill" else 0.0
    right, left = x > 4.999, x < -4.999
    assert moved[right] == pytest.approx(-60e-3 * (z[right] - nose), abs=2e-3)
    assert moved[left] == pytest.approx(-2.70, abs=2e-3)
    (square,) = cut(ready.scenario).characteristics
    assert 1e3 * square.value == pytest.approx(1.20, abs=2e-3)
