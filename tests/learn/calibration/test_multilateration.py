"""Multilateration: degrees of freedom and covariance by hand, a general-purpose least squares beside it, what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import ModelLimit
from vcmm.learn.calibration.multilateration import Lengths, locate_points, nearest_pose

GRID = np.array(
    [[x, y, z] for x in (-200.0, 0.0, 300.0) for y in (-100.0, 0.0, 250.0) for z in (-150.0, 0.0, 200.0)]
)
AROUND = 1000.0 * np.concatenate([np.eye(3), -np.eye(3)])
CORNERS = np.array(
    [[-600.0, -500, 50], [900, -450, -300], [700, 800, 100], [-500, 700, -200], [100, 50, 900]]
)


def lengths(points, stations, nominal, rng=None, u=0.0, dead=0.0, start=0.0):
    point = np.repeat(np.arange(len(points)), len(stations))
    station = np.tile(np.arange(len(stations)), len(points))
    length = np.linalg.norm(points[point] - stations[station], axis=1) - dead * station
    if rng is not None:
        length = length + u * rng.standard_normal(len(length))
    return Lengths(length, point, station, nominal, stations + start)


def test_a_quarter_turn_and_a_shift_by_hand():
    turn, shift = nearest_pose(
        np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        np.array([[5.0, 6, 7], [5, 7, 7], [4, 6, 7], [5, 6, 8]]),
    )
    assert turn == pytest.approx(np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]), abs=1e-12)
    assert shift == pytest.approx([5.0, 6.0, 7.0])


def test_without_noise_everything_is_found_though_stations_are_known_to_20_mm_only():
    rng = np.random.default_rng(1)
    points = GRID + 2e-3 * rng.standard_normal(GRID.shape)
    found = locate_points(
        lengths(points, CORNERS, GRID, dead=37.0, start=20.0 * rng.standard_normal(CORNERS.shape))
    )
    turn, shift = nearest_pose(found.points, points)
    assert found.points @ turn.T + shift == pytest.approx(points, abs=1e-8)
    assert found.stations @ turn.T + shift == pytest.approx(CORNERS, abs=1e-7)
    assert found.dead_paths == pytest.approx(37.0 * np.arange(5), abs=1e-7)
    assert found.u < 1e-10


def test_degrees_of_freedom_and_a_covariance_by_hand():
    """27 points, 6 stations: 162 - 81 - 24 + 6 = 63. At the origin two beams run along each axis: the variance of each coordinate is 1/2."""
    found = locate_points(lengths(GRID, AROUND, GRID))
    assert found.freedom == 63
    middle = int(np.flatnonzero((GRID == 0).all(axis=1))[0])
    assert found.alone[middle] == pytest.approx(0.5 * np.eye(3), abs=1e-9)


def test_residuals_give_the_noise_and_covariances_the_scatter():
    rng, u = np.random.default_rng(7), 0.3e-3
    several = [locate_points(lengths(GRID, CORNERS, GRID, rng, u)) for _ in range(24)]
    rms = np.sqrt(np.mean([f.u**2 for f in several]))
    assert rms == pytest.approx(u, rel=0.07)  # 24 x 40 degrees of freedom: 2.3 %
    points = np.array([f.points for f in several])
    alone = np.einsum("pii->pi", several[0].alone).mean()
    inner = points - points.mean(axis=0)
    whole = alone + np.einsum("pii->pi", several[0].common).mean()
    assert inner.std() / u == pytest.approx(np.sqrt(whole), rel=0.05)
    assert np.sqrt(whole / alone) > 1.1  # the stations matter


def test_the_same_as_a_general_least_squares():
    """All unknowns in one dense problem, scipy's own derivatives; compared as distances, which know no place of the whole."""
    from scipy.optimize import least_squares
    from scipy.spatial.distance import pdist

    rng = np.random.default_rng(3)
    nominal = GRID[::2]
    data = lengths(nominal, CORNERS, nominal, rng, 1e-3, dead=5.0)
    found = locate_points(data)

    def misfit(v):
        points, rest = v[: 3 * len(nominal)].reshape(-1, 3), v[3 * len(nominal) :].reshape(-1, 4)
        way = np.linalg.norm(points[data.point] - rest[data.station, :3], axis=1)
        return data.length + rest[data.station, 3] - way

    start = np.concatenate([nominal.ravel(), np.column_stack([CORNERS, 5.0 * np.arange(5)]).ravel()])
    other = (
        least_squares(misfit, start, method="lm", ftol=1e-15, xtol=1e-15, gtol=1e-15)
        .x[: 3 * len(nominal)]
        .reshape(-1, 3)
    )
    assert pdist(found.points) == pytest.approx(pdist(other), abs=1e-6)
    assert np.abs(pdist(found.points) - pdist(nominal)).max() > 1e-4  # there was something to find


@pytest.mark.parametrize(
    ("stations", "points", "said"),
    [
        (CORNERS[:3], GRID, "expected 4 or more"),
        (CORNERS * [1, 1, 0], GRID * [1, 1, 0], "one plane"),
        (CORNERS[:4], GRID[:3], "do not determine"),
        (np.array([[k * 400.0, 5, 3] for k in range(5)]), GRID, "one plane|undetermined"),
    ],
)  # fmt: skip
def test_what_does_not_determine_points_is_refused(stations, points, said):
    with pytest.raises(ModelLimit, match=said):
        locate_points(lengths(points, stations, points))
