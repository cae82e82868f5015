"""Nominal points with normals as the theoretically exact surface."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.core.errors import DataError, UsageError
from vcmm.core.pose import Pose
from vcmm.part.extent import beyond_extent
from vcmm.part.nominal import NominalPoints, distance_and_normal, distance_beside_known, travel_onto
from vcmm.part.part import Feature, feature_to_frame, normal, signed_distance, surface_point


def ball(radius: float = 20.0, side: float = 1.0, step: float = 12.0) -> NominalPoints:
    """A cap of a sphere about the origin, a point every 12 deg; side -1: a socket."""
    a, b = np.meshgrid(np.radians(np.arange(-36, 37, step)), np.radians(np.arange(-36, 37, step)))
    way = np.stack([np.sin(a) * np.cos(b), np.sin(b), np.cos(a) * np.cos(b)], axis=-1).reshape(-1, 3)
    return NominalPoints(radius * way, side * way)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_between_coarse_points_of_a_sphere_the_sphere_is_found_again(side: float) -> None:
    surface = ball(side=side)
    np.testing.assert_allclose(
        np.linalg.eigvalsh(surface.curvature),
        np.sort([[0.0, side / 20, side / 20]]) + np.zeros((49, 1)),
        atol=1e-12,
    )
    beside = np.radians(3.0)  # 1.05 mm beside a point, where the tangent plane is off by 1.05^2 / 40 = 27 um
    way = np.array([math.sin(beside), 0.0, math.cos(beside)])
    distance, outward = distance_and_normal(surface, (20.0 + side * 0.01) * way[None])
    assert distance[0] == pytest.approx(0.01, abs=3e-5)  # fourth order: R b^4 / 8 = 19 nm
    np.testing.assert_allclose(outward[0], side * way, atol=2e-4)


def test_a_row_of_points_bends_along_it_and_not_across() -> None:
    turn = np.radians(np.arange(0, 91, 15))
    way = np.stack([np.cos(turn), np.sin(turn), np.zeros(7)], axis=1)
    surface = NominalPoints(10.0 * way, way)
    z = np.array([0.0, 0.0, 1.0])
    assert np.abs(surface.curvature @ z).max() < 1e-12
    assert np.einsum(
        "i,ij,j", [-way[3][1], way[3][0], 0], surface.curvature[3], [-way[3][1], way[3][0], 0]
    ) == pytest.approx(0.1)
    # 2 mm across the row of a cylinder nothing changes: 10.5 mm from the axis is 0.5 mm outside
    assert distance_and_normal(surface, 10.5 * way[3:4] + 2.0 * z)[0] == pytest.approx([0.5])


def test_neighbours_round_an_edge_tell_no_curvature() -> None:
    x = np.arange(1.0, 6.0)
    top = np.stack([x, 0 * x, 0 * x], axis=1)
    side = np.stack([0 * x, 0 * x, -x], axis=1)
    surface = NominalPoints(np.concatenate([top, side]), np.repeat([[0, 0, 1.0], [-1, 0, 0]], 5, axis=0))
    assert np.abs(surface.curvature).max() == 0.0


def test_a_ball_that_comes_in_beside_touches_where_the_sphere_of_both_radii_lies() -> None:
    surface, e = ball(), 0.1
    foot = np.array([[0.0, 0.0, 20.0]])
    start, down = foot + [[e, 0.0, 5.0]], np.array([[0.0, 0.0, -1.0]])
    travel = travel_onto(surface, (foot, -down), start, down, np.array([2.0]))
    assert travel[0] == pytest.approx(
        25.0 - math.sqrt(22.0**2 - e**2), abs=1e-8
    )  # 2 + 20 mm and 0.1 beside: 0.23 um lower
    assert 25.0 - travel[0] == pytest.approx(22.0 - e**2 / 44.0, abs=1e-8)


def test_a_feature_of_nominal_points_is_a_surface_like_any_other() -> None:
    surface = ball()
    f = Feature("blade", "points", surface.points.mean(axis=0), np.zeros(3), np.zeros(0), nominal=surface)
    assert f.free
    assert signed_distance(f, 1.001 * surface.points) == pytest.approx(0.02)
    np.testing.assert_allclose(normal(f, surface.points), surface.normals, atol=1e-12)
    turned = feature_to_frame(f, Pose.from_turns((1.0, 2.0, 3.0), (0.1, 0.2, 0.3)))
    assert turned.nominal is not None
    assert signed_distance(turned, turned.nominal.points + 0.01 * turned.nominal.normals) == pytest.approx(
        0.01
    )
    with pytest.raises(UsageError, match="give points instead"):
        surface_point(f, 0.0)
    with pytest.raises(DataError, match="nominal points belong to the type points"):
        Feature("blade", "points", np.zeros(3), np.zeros(3), np.zeros(0))


def test_beyond_the_second_neighbour_the_surface_is_not_known() -> None:
    x = np.arange(5.0) * 2.0
    flat = NominalPoints(np.stack([x, 0 * x, 0 * x], axis=1), np.tile([0, 0, 1.0], (5, 1)))
    np.testing.assert_allclose(flat.reach, [4, 2, 2, 2, 4])
    at = np.array(
        [[-5.0, 0, 0], [4.0, 1.5, 0.3]]
    )  # 5 mm beside the end, where 4 are known; 1.5 mm where 2 are
    np.testing.assert_allclose(distance_beside_known(flat, at), [1.0, -0.5])
    f = Feature("row", "points", flat.points.mean(axis=0), np.zeros(3), np.zeros(0), nominal=flat)
    np.testing.assert_allclose(beyond_extent(f, at), [1.0, -0.5])


@pytest.mark.parametrize(
    ("points", "normals", "word"),
    [
        ([[0, 0, 0], [1, 0, 0]], [[0, 0, 1]] * 2, "make no surface"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 1]] * 2, r"must both be \(n, 3\)"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, np.nan]], [[0, 0, 1]] * 3, "finite"),
        (
            [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
            [[0, 0, 1], [0, 0, 0], [0, 0, 1]],
            "point 2: its normal has the length 0",
        ),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0]], [[0, 0, 1]] * 4, "point 4 is in the file twice"),
    ],
)
def test_what_is_no_surface_is_refused(points: list, normals: list, word: str) -> None:
    with pytest.raises(DataError, match=word):
        NominalPoints(np.array(points, dtype=float), np.array(normals, dtype=float))
