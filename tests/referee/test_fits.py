"""The referee's elements and zones against numbers by pencil."""

import numpy as np
import pytest
from scipy.stats import binomtest

from referee import fits
from referee.count import bounds

ANGLE = np.arange(360) * np.pi / 180
RIM = np.column_stack([np.cos(ANGLE), np.sin(ANGLE)])


def test_least_squares_circle_through_three_points():
    # right angle at the origin: the side from (6, 0) to (0, 8) is the diameter
    centre, radius = fits.circle(np.array([[0.0, 0], [6, 0], [0, 8]]))
    assert np.allclose(centre, [3, 4])
    assert radius == pytest.approx(5)


def test_the_mean_of_four_radii():
    # radii 10, 10.2, 10, 10.2 at 0, 90, 180, 270 deg: symmetric, so the centre stays and the radius is the mean
    centre, radius = fits.circle(np.array([[10.0, 0], [0, 10.2], [-10, 0], [0, -10.2]]))
    assert np.allclose(centre, 0, atol=1e-9)
    assert radius == pytest.approx(10.1)


@pytest.mark.parametrize("lobes", [2, 3, 5])
def test_zone_of_a_lobed_circle_is_its_height(lobes):
    # three or more lobes touch both circles in turn at the middle already: peak to valley of 2 um
    points = (15 + 0.001 * np.cos(lobes * ANGLE))[:, None] * RIM + [0.003, -0.002]
    assert fits.roundness(points, True) == pytest.approx(0.002, abs=2e-8)
    # even lobes leave the mean where it is; by symmetry the least-squares circle reads the same
    assert fits.roundness(points, False) == pytest.approx(0.002, abs=2e-8)


def test_one_spike_counts_half_as_much_against_the_best_zone():
    # five points even round a circle and one at 0 deg raised by h: the zone moves towards it, least squares less so
    angle = np.arange(4) * np.pi / 2
    points = 10 * np.column_stack([np.cos(angle), np.sin(angle)])
    points[0, 0] += 0.004
    # radii about (e, 0): 10.004 - e, 10, 10 + e, 10 -> width max(4 - e, e) - 0 at e = 2: 2 um
    assert fits.roundness(points, True) == pytest.approx(0.002, abs=1e-6)
    # Gauss, e = 2/4 * 4 um = 2 um as well: residuals +-1 um
    assert fits.roundness(points, False) == pytest.approx(0.002, abs=1e-6)


def test_zone_of_four_corners_of_a_twisted_square():
    points = np.array([[1.0, 1, 0.001], [-1, -1, 0.001], [1, -1, -0.001], [-1, 1, -0.001]])
    assert fits.flatness(points, np.array([0.0, 0, 1]), True) == pytest.approx(0.002)


def test_straightness_of_a_bent_line():
    # 0, h, 0 at -1, 0, 1: the zone lies along the ends, width h; Gauss: the same slope, range h
    along, height = np.array([-1.0, 0, 1]), np.array([0.0, 0.003, 0])
    assert fits.straightness(along, height, True) == pytest.approx(0.003)
    # a triangle 0, 0, h: the zone has slope h/2 and width h/2
    assert fits.straightness(along, np.array([0.0, 0, 0.003]), True) == pytest.approx(0.0015, abs=1e-7)


def test_least_squares_of_that_triangle():
    # slope h/2, mean h/3: residuals h/6, -h/3, h/6: range h/2
    along = np.array([-1.0, 0, 1])
    assert fits.straightness(along, np.array([0.0, 0, 0.003]), False) == pytest.approx(0.0015, abs=1e-7)


def bore(form):
    angle, height = np.meshgrid(np.arange(36) * np.pi / 18, np.linspace(0, 20, 11))
    angle, height = angle.ravel(), height.ravel()
    radius = 15 + form(angle, height)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])


def test_a_leaning_bore_is_a_perfect_cylinder():
    points = bore(lambda a, h: 1e-4 * h * np.cos(a))  # the axis leans by 0.1 um per mm
    point, direction, radius = fits.cylinder(points)
    assert radius == pytest.approx(15, abs=1e-7)
    assert np.allclose(direction[:2], [1e-4, 0], atol=1e-9)
    assert np.allclose(point[:2], 0, atol=1e-7)
    assert fits.cylindricity(points, True) < 1e-6


def test_a_taper_is_its_difference_of_radii():
    points = bore(lambda a, h: 1e-4 * (h - 10))  # +-1 um
    assert fits.cylindricity(points, True) == pytest.approx(0.002, abs=1e-8)


def test_a_secondary_plane_stands_square_to_the_first():
    u, v = (g.ravel() for g in np.meshgrid(np.linspace(-1, 1, 5), np.linspace(-1, 1, 5)))
    up = np.array([0.0, 0, 1])
    # a wall in x and z whose height in -y is 2 um times x and leans by 5 um times z: the lean is not followed
    wall = np.column_stack([u, -0.002 * u - 0.005 * v, v])
    normal = fits.constrained_plane(wall, np.array([0.0, -1, 0]), [up])[1]
    assert normal @ up == pytest.approx(0, abs=1e-12)
    assert np.allclose(normal, np.array([-0.002, -1, 0]) / np.hypot(1, 0.002), atol=1e-7)


def test_bounds_are_those_of_the_binomial():
    for right, count in ((0, 20), (57, 60), (60, 60)):
        reference = binomtest(right, count).proportion_ci(0.95, "exact")
        assert bounds(right, count) == pytest.approx((reference.low, reference.high))
    assert bounds(60, 60)[0] == pytest.approx(
        0.025 ** (1 / 60)
    )  # by hand: the share whose 60th power is 2.5 %
