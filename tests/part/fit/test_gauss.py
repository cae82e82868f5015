"""Fits with answers found by hand, conventions of the result, batches, and what is refused."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.refdata import KINDS, Array, Recipe, reference, rotation
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.part.fit import MINIMUM_POINTS, FittedElement, gauss
from vcmm.part.fit.elements import ELEMENTS, RX, RY, TX, TY, TZ, frames, jacobian

NEAR = 1e-12


def ring(radius: float | Array, n: int, z: float = 0.0) -> Array:
    turn = 2.0 * np.pi * np.arange(n) / n
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), np.full(n, z)], axis=1)


def test_point_is_the_mean() -> None:
    # mean of (0,0,0) and (6,0,8) = (3,0,4); both are 5 away from it
    fit = gauss("point", np.array([[0.0, 0, 0], [6, 0, 8]]))
    assert fit.point == pytest.approx([3, 0, 4], abs=NEAR)
    assert fit.residuals == pytest.approx([5, 5], abs=NEAR)
    assert fit.normals[1] == pytest.approx([0.6, 0, 0.8], abs=NEAR)
    assert not fit.axis.any()
    assert fit.sizes.shape == (0,)


def test_line_by_hand() -> None:
    # x = -15 -5 5 15, y = 1 -1 -1 1: sum x y = -15+5-5+15 = 0 and sum y = 0, so the x axis is the line
    points = np.array([[-15.0, 1, 0], [-5, -1, 0], [5, -1, 0], [15, 1, 0]])
    fit = gauss("line", points)
    assert fit.axis == pytest.approx([1, 0, 0], abs=NEAR)
    assert fit.point == pytest.approx([0, 0, 0], abs=NEAR)
    assert fit.residuals == pytest.approx([1, 1, 1, 1], abs=NEAR)
    assert fit.normals[:, 1] == pytest.approx([1, -1, -1, 1], abs=NEAR)


def test_plane_by_hand() -> None:
    # heights 1 -1 1 -1 at the corners of a square: no tilt (sum x h = sum y h = 0), mean height 5
    points = np.array([[10.0, 10, 6], [-10, 10, 4], [-10, -10, 6], [10, -10, 4]])
    fit = gauss("plane", points)
    assert fit.point == pytest.approx([0, 0, 5], abs=NEAR)
    assert fit.axis == pytest.approx([0, 0, 1], abs=NEAR)
    assert fit.residuals == pytest.approx([1, -1, 1, -1], abs=NEAR)


@pytest.mark.parametrize("kind", ["circle", "cylinder"])
def test_round_by_hand(kind: str) -> None:
    # radii 11 9 11 9 ... every 45 deg (and on a second level): centre 0, radius 10, residuals +-1
    radii = np.array([11.0, 9.0] * 4)
    levels = (0.0,) if kind == "circle" else (-7.0, 7.0)
    points = np.concatenate([ring(radii, 8, z) for z in levels])
    fit = gauss(kind, points + [1.0, 2.0, 3.0])
    assert fit.point == pytest.approx([1, 2, 3], abs=NEAR)
    assert np.abs(fit.axis) == pytest.approx([0, 0, 1], abs=NEAR)
    assert fit.sizes == pytest.approx([10], abs=NEAR)
    assert fit.residuals == pytest.approx(np.tile([1.0, -1.0], len(points) // 2), abs=NEAR)
    assert fit.normals[0] == pytest.approx([1, 0, 0], abs=NEAR)


def test_sphere_by_hand() -> None:
    # octahedron with arms 11, 10, 9: centre 0 by symmetry, radius (11 + 10 + 9) / 3 = 10
    points = np.concatenate([np.diag([11.0, 10, 9]), -np.diag([11.0, 10, 9])])
    fit = gauss("sphere", points)
    assert fit.point == pytest.approx([0, 0, 0], abs=NEAR)
    assert fit.sizes == pytest.approx([10], abs=NEAR)
    assert fit.residuals == pytest.approx([1, 0, -1, 1, 0, -1], abs=NEAR)
    assert not fit.axis.any()


def test_cone_by_hand_grows_along_its_axis() -> None:
    # radius 12 at z = -2 and 8 at z = +2: grows along -z, tan(half angle) = 4 / 4, radius 10 in the middle
    points = np.concatenate([ring(12.0, 6, -2.0), ring(8.0, 6, 2.0)])
    fit = gauss("cone", points)
    assert fit.axis == pytest.approx([0, 0, -1], abs=NEAR)
    assert fit.sizes == pytest.approx([10, np.pi / 4], abs=NEAR)
    assert fit.point == pytest.approx([0, 0, 0], abs=NEAR)
    # outward normal at (12, 0, -2): cos 45 (1, 0, 0) - sin 45 (0, 0, -1)
    assert fit.normals[0] == pytest.approx([np.sqrt(0.5), 0, np.sqrt(0.5)], abs=NEAR)
    wrong = dataclasses.replace(fit, axis=-fit.axis)
    assert gauss("cone", points, wrong).axis == pytest.approx([0, 0, -1], abs=NEAR)


def test_torus_by_hand() -> None:
    # ring 10, tube 3: rings of radius 13 and 7 at z = 0, of radius 10 at z = +-3
    rings = ((13.0, 6, 0.0), (7.0, 6, 0.0), (10.0, 5, 3.0), (10.0, 5, -3.0))
    points = np.concatenate([ring(*one) for one in rings])
    fit = gauss("torus", points)
    assert fit.sizes == pytest.approx([10, 3], abs=NEAR)
    assert fit.point == pytest.approx([0, 0, 0], abs=NEAR)
    assert np.abs(fit.axis) == pytest.approx([0, 0, 1], abs=NEAR)
    assert np.abs(fit.residuals) == pytest.approx(np.zeros(22), abs=NEAR)


@pytest.mark.parametrize("kind", KINDS)
def test_jacobian_against_differences_of_the_distance(kind: str) -> None:
    # moving the element by t, w is moving the points by -t - w x point
    rng = np.random.default_rng(3)
    local, sizes = rng.uniform(4.0, 9.0, (1, 3, 20)), np.array([[6.0, 0.4]])[:, : len(ELEMENTS[kind].sizes)]
    motions, h = (TX, TY, TZ, RX, RY), 1e-6
    _, jac, _ = jacobian(ELEMENTS[kind], motions, local, sizes)
    for j, motion in enumerate([*motions, *range(5, 5 + sizes.shape[1])]):
        moved, other = [], np.zeros(7)
        for sign in (-0.5, 0.5):
            other[motion] = sign * h
            shifted = local[0] - other[:3, None] - np.cross([*other[3:5], 0.0], local[0].T).T
            moved.append(
                jacobian(ELEMENTS[kind], (), shifted[None], sizes + other[5 : 5 + sizes.shape[1]])[0]
            )
        assert jac[0, j] == pytest.approx((moved[1] - moved[0])[0] / h, abs=1e-8)


def test_frames_are_right_handed() -> None:
    axes = np.array([[0.0, 0, 1], [0, 0, -1], [1, 0, 0], [0.6, -0.8, 0], [0, -0.0, -1.0]])
    f = frames(axes)
    assert f @ f.swapaxes(1, 2) == pytest.approx(np.tile(np.eye(3), (5, 1, 1)), abs=1e-15)
    assert np.cross(f[:, 0], f[:, 1]) == pytest.approx(axes, abs=1e-15)


@pytest.mark.parametrize("kind", KINDS)
def test_residuals_lie_along_the_normals(kind: str) -> None:
    # point - residual * normal lies on the fitted surface: refitting those points leaves nothing
    ref = reference(kind, np.random.default_rng(5))
    fit = gauss(kind, ref.points)
    feet = ref.points - fit.residuals[:, None] * fit.normals
    assert np.linalg.norm(fit.normals, axis=1) == pytest.approx(np.ones(30), abs=NEAR)
    assert np.max(np.abs(fit.residuals)) > 1e-3
    again = gauss(kind, feet, fit)
    # circle: moving the points within the plane turns the plane a little, by their waves out of it
    near = 2e-9 if kind == "circle" else 1e-11
    assert np.max(np.abs(again.residuals)) < near
    assert again.point == pytest.approx(fit.point, abs=10 * near)


def test_circle_point_lies_in_its_plane_at_the_height_of_the_centroid() -> None:
    points = ring(10.0, 12) + np.array([0, 0, 1.0]) * np.tile([[0.1], [-0.1]], (6, 1))
    fit = gauss("circle", points + [0, 0, 5])
    assert fit.point == pytest.approx([0, 0, 5], abs=NEAR)
    assert fit.residuals == pytest.approx(np.zeros(12), abs=NEAR)  # radial only: the waves are out of plane


@pytest.mark.parametrize("kind", ["line", "plane", "circle", "cylinder", "torus"])
def test_axis_follows_the_start(kind: str) -> None:
    ref = reference(kind, np.random.default_rng(6))
    fit = gauss(kind, ref.points)
    assert fit.axis[np.argmax(np.abs(fit.axis))] > 0
    back = gauss(kind, ref.points, dataclasses.replace(fit, axis=-fit.axis))
    assert back.axis == pytest.approx(-fit.axis, abs=NEAR)
    if kind == "plane":
        assert back.residuals == pytest.approx(-fit.residuals, abs=NEAR)


@pytest.mark.parametrize("kind", ["line", "plane", "circle", "cylinder", "cone", "torus"])
def test_fixed_axis(kind: str) -> None:
    ref = reference(kind, np.random.default_rng(8), Recipe(form=0.0))
    exact = gauss(kind, ref.points, fixed_axis=2.0 * ref.axis)
    assert exact.axis == pytest.approx(ref.axis, abs=NEAR)
    assert np.max(np.abs(exact.residuals)) < 1e-11
    tilted = ref.axis + 0.01 * np.array([ref.axis[1], -ref.axis[0], 0.0])
    fit = gauss(kind, ref.points, fixed_axis=tilted)
    assert fit.axis == pytest.approx(tilted / np.linalg.norm(tilted), abs=NEAR)
    assert np.max(np.abs(fit.residuals)) > (1e-4 if kind == "circle" else 1e-2)


def test_circle_in_projection_is_not_the_circle_in_its_plane() -> None:
    # R 10 tilted by 0.1 rad about x: the projection along z is an ellipse 10 x 10 cos 0.1 = 9.950
    points = ring(10.0, 36) @ np.array(
        [[1, 0, 0], [0, np.cos(0.1), np.sin(0.1)], [0, -np.sin(0.1), np.cos(0.1)]]
    )
    assert gauss("circle", points).sizes == pytest.approx([10.0], abs=NEAR)
    assert gauss("circle", points, fixed_axis=np.array([0, 0, 1.0])).sizes == pytest.approx([9.975], abs=1e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_batch_is_bit_for_bit_the_single_fit(kind: str) -> None:
    ref = reference(kind, np.random.default_rng(9))
    rng = np.random.default_rng(10)
    points = ref.points + 0.01 * rng.standard_normal((2, 7, *ref.points.shape))
    nominal = gauss(kind, ref.points)
    batch = gauss(kind, points, nominal)
    assert batch.point.shape == (2, 7, 3)
    assert batch.normals.shape == (2, 7, 30, 3)
    for index in ((0, 0), (1, 3)):
        one = gauss(kind, points[index], nominal)
        for name in ("point", "axis", "sizes", "residuals", "normals"):
            assert (getattr(one, name) == getattr(batch, name)[index]).all()


def test_batch_larger_than_a_chunk_and_batched_start() -> None:
    ref = reference("cylinder", np.random.default_rng(11))
    points = ref.points + 1e-3 * np.random.default_rng(12).standard_normal((1200, *ref.points.shape))
    first = gauss("cylinder", points, gauss("cylinder", ref.points))
    again = gauss("cylinder", points, first)
    assert again.sizes == pytest.approx(first.sizes, abs=NEAR)
    # u(r) = 1e-3 / sqrt(n) for evenly spread points; here within 30 %
    assert np.std(first.sizes) == pytest.approx(1e-3 / np.sqrt(30), rel=0.3)


@pytest.mark.parametrize("kind", KINDS)
def test_minimum_number_of_points(kind: str) -> None:
    least = MINIMUM_POINTS[kind]
    ref = reference(kind, np.random.default_rng(13), Recipe(form=0.0))
    nominal = gauss(kind, ref.points)
    some = ref.points[np.linspace(0, 29, least).astype(int)]
    assert np.max(np.abs(gauss(kind, some, nominal).residuals)) < 1e-9
    if least > 1:
        with pytest.raises(ModelLimit, match=f"{kind} needs at least {least} points, got {least - 1}"):
            gauss(kind, some[:-1], nominal)


def test_fixed_axis_needs_fewer_points() -> None:
    up = np.array([0.0, 0, 1])
    assert gauss("cylinder", ring(5.0, 3), fixed_axis=up).sizes == pytest.approx([5.0], abs=NEAR)
    assert gauss("plane", np.array([[1.0, 2, 3]]), fixed_axis=up).point == pytest.approx([1, 2, 3], abs=NEAR)
    with pytest.raises(ModelLimit, match="cone with a fixed axis needs at least 4 points, got 3"):
        gauss("cone", ring(5.0, 3), fixed_axis=up)


def nominal(kind: str, sizes: list[float]) -> FittedElement:
    return FittedElement(
        kind, np.zeros(3), np.array([0.0, 0, 1]), np.array(sizes), np.empty(0), np.empty((0, 3))
    )


def test_collinear_plane_points() -> None:
    along = np.linspace(-10, 10, 6)[:, None] * np.array([0.6, 0.8, 0.0]) + [100.0, 0, 7]
    with pytest.raises(
        ModelLimit, match=r"do not determine the tilt of the plane about \(0\.600, 0\.800, 0\.000\)"
    ):
        gauss("plane", along)
    with pytest.raises(ModelLimit, match=r"plane of the circle: .*\(0\.600, 0\.800, 0\.000\)"):
        gauss("circle", along)


@pytest.mark.parametrize("with_start", [True, False])
def test_cylinder_points_on_one_level(with_start: bool) -> None:
    start = nominal("cylinder", [10.0]) if with_start else None
    with pytest.raises(ModelLimit, match=r"do not determine the tilt of the cylinder about .* two levels"):
        gauss("cylinder", ring(10.0, 12), start)


def test_sphere_points_on_one_circle() -> None:
    with pytest.raises(
        ModelLimit, match=r"position along \(0\.000, 0\.000, 1\.000\) together with the radius"
    ):
        gauss("sphere", ring(6.0, 12, 8.0), nominal("sphere", [10.0]))


def test_cone_points_on_one_level() -> None:
    with pytest.raises(ModelLimit, match="do not determine the"):
        gauss("cone", ring(10.0, 12), nominal("cone", [10.0, 0.3]))


def test_line_points_at_one_place() -> None:
    with pytest.raises(ModelLimit, match="direction of the line"):
        gauss("line", np.ones((4, 3)))


def test_straight_arc_has_no_circle() -> None:
    points = np.stack([np.linspace(-1, 1, 9), np.zeros(9), np.zeros(9)], axis=1)
    points[::2, 1] = 1e-6
    message = r"position along \(0\.000, 1\.000, 0\.000\) together with the radius \(in 1 of 2 fits\)"
    with pytest.raises(ModelLimit, match=message):
        gauss("circle", np.stack([ring(1.0, 9), points]), fixed_axis=np.array([0, 0, 1.0]))


def test_no_convergence_names_how_many(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vcmm.part.fit.newton.MAX_STEPS", 2)
    ref = reference("torus", np.random.default_rng(15))
    start = dataclasses.replace(
        nominal("torus", [20.0, 5.0]), point=ref.point + [1.0, 2.0, 3.0], axis=ref.axis
    )
    with pytest.raises(ModelLimit, match=r"torus: 2 of 2 fits did not converge \(the first is number 0\)"):
        gauss("torus", np.stack([ref.points, ref.points]), start)


def test_wrong_calls() -> None:
    good = ring(5.0, 8)
    with pytest.raises(UsageError, match='Did you mean "cylinder"'):
        gauss("cylindre", good)
    with pytest.raises(UsageError, match="start is a plane"):
        gauss("circle", good, nominal("plane", []))
    with pytest.raises(UsageError, match=r"shape \(\.\.\., n, 3\), got \(8, 2\)"):
        gauss("circle", good[:, :2])
    bad = good.copy()
    bad[3, 1] = np.nan
    with pytest.raises(UsageError, match=r"\(3, 1\) is not a finite number"):
        gauss("circle", bad)
    with pytest.raises(UsageError, match="a sphere has no axis"):
        gauss("sphere", good, fixed_axis=np.array([0, 0, 1.0]))
    with pytest.raises(UsageError, match="not all zero"):
        gauss("circle", good, fixed_axis=np.zeros(3))
    several = gauss("circle", np.stack([good, good]))
    with pytest.raises(UsageError, match="start has the batch"):
        gauss("circle", np.stack([good] * 3), several)
    with pytest.raises(UsageError, match="the axis of start must be"):
        gauss("circle", good, dataclasses.replace(nominal("circle", [5.0]), axis=np.zeros(3)))
    with pytest.raises(UsageError, match="start has 0 sizes, a circle has 1"):
        gauss("circle", good, nominal("circle", []))
    with pytest.raises(UsageError, match="start holds a number that is not finite"):
        gauss("circle", good, nominal("circle", [np.nan]))
    with pytest.raises(UsageError, match="is empty"):
        gauss("circle", np.empty((0, 8, 3)))


def test_far_from_the_origin_and_far_start() -> None:
    rng = np.random.default_rng(14)
    points = np.concatenate([ring(12.0, 9, z) for z in (-15.0, 0.0, 15.0)]) @ rotation(rng).T + [
        4000.0,
        -3000,
        900,
    ]
    fit = gauss("cylinder", points)
    assert fit.sizes == pytest.approx([12.0], abs=1e-11)
    start = dataclasses.replace(fit, point=fit.point + [3.0, -4.0, 5.0], sizes=np.array([20.0]))
    assert gauss("cylinder", points, start).sizes == pytest.approx([12.0], abs=1e-11)
