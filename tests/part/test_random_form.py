"""Families of forms: range one over the whole surface, no size, place or direction, the same whatever else is asked."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.part.part import Feature, surface_point
from vcmm.part.random_form import SINGLE, SMOOTH, _wave, random_forms, whole_surface

Z = np.array([0.0, 0.0, 1.0])
FEATURES = (
    Feature("line", "line", np.zeros(3), np.array([1.0, 0, 0]), np.zeros(0), extent=(50.0,), u=Z),
    Feature("plane", "plane", np.array([3.0, 0, 0]), Z, np.zeros(0), extent=(80.0, 40.0)),
    Feature("circle", "circle", np.zeros(3), Z, np.array([15.0]), inside=True),
    Feature("cylinder", "cylinder", np.zeros(3), Z, np.array([15.0]), extent=(30.0,)),
    Feature("cone", "cone", np.zeros(3), Z, np.array([10.0, 0.2]), extent=(30.0,)),
    Feature("sphere", "sphere", np.ones(3), np.zeros(3), np.array([12.0])),
)


@pytest.mark.parametrize("feature", FEATURES, ids=lambda f: f.kind)
@pytest.mark.parametrize("family", [SMOOTH, SINGLE])
def test_range_is_one_over_the_surface(feature, family):
    dense = whole_surface(feature)
    found = random_forms(feature, dense, 20, family, np.random.default_rng(1))
    assert np.ptp(found, axis=1) == pytest.approx(np.ones(20), abs=5e-3)
    assert (
        np.abs(found.mean(axis=1)).max() < 1e-4
    )  # no size: the mean of a whole surface is its least-squares offset


def test_lobes_of_a_circle_by_hand():
    """One lobe number k: 1/2 cos(k a + phase) at any angle, whatever the points asked for."""
    circle = FEATURES[2]
    angle = np.linspace(0, 2 * np.pi, 100, endpoint=False)
    found = random_forms(circle, surface_point(circle, angle), 60, SINGLE, np.random.default_rng(2))
    power = np.abs(np.fft.rfft(found, axis=1)) / 50
    order = power.argmax(axis=1)
    assert sorted(set(order)) == [2, 3, 4, 5, 6, 7]
    assert np.take_along_axis(power, order[:, None], axis=1)[:, 0] == pytest.approx(
        np.full(60, 0.5), abs=0.01
    )


def test_a_few_points_see_part_of_the_form():
    circle = FEATURES[2]
    few = surface_point(circle, np.arange(8) * np.pi / 4)
    found = random_forms(circle, few, 500, SMOOTH, np.random.default_rng(3))
    seen = np.ptp(found, axis=1)
    assert 0.5 < seen.mean() < 0.95
    assert seen.max() <= 1.0 + 1e-9


def test_a_wave_across_a_plane_by_hand():
    """Phase 45 deg, order 2, at (20, 10) of 80 x 40: a quarter of either side, so cos(pi (0.25 + 0.25) / sqrt 2) = cos(1.110721) = 0.444016;
    at (20, -10) the two cancel: cos 0 = 1."""
    points = np.array([[23.0, 10.0, 0.0], [23.0, -10.0, 0.0]])  # the plane's own point lies at x = 3
    order, phase = np.array([[2]]), np.array([[np.pi / 4]])
    assert _wave(FEATURES[1], points, order, phase)[0] == pytest.approx([0.444016, 1.0], abs=1e-6)
