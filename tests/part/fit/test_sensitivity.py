"""Sensitivities against closed forms and differences of gauss(), the linear operator against exact fits."""

from __future__ import annotations

import numpy as np
import pytest

from tests.refdata import KINDS, Array, Recipe, reference
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.part.fit import gauss, linear_fit, sensitivity

UP = np.array([0.0, 0.0, 1.0])


def arc(radius: float, n: int, degrees: float = 360.0, z: float = 0.0) -> Array:
    """n points evenly on an arc about +x, ends included; a full circle has no double point."""
    half = np.radians(degrees) / 2
    turn = np.linspace(-half, half, n, endpoint=degrees < 360.0)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), np.full(n, z)], axis=1)


def hemisphere(radius: float) -> Array:
    """The 25 points of ISO 10360-5: the pole; 4 at 22.5 deg from it, 8 at 45, 4 at 67.5, 8 at 90."""
    points = [radius * UP[None]]
    for n, polar, turned in ((4, 22.5, 0.0), (8, 45.0, 22.5), (4, 67.5, 0.0), (8, 90.0, 22.5)):
        a, t = np.radians(polar), np.radians(turned) + 2 * np.pi * np.arange(n) / n
        ring = np.stack([np.sin(a) * np.cos(t), np.sin(a) * np.sin(t), np.full(n, np.cos(a))], axis=1)
        points.append(radius * ring)
    return np.concatenate(points)


def deviations(kind: str, points: Array, fixed_axis: Array | None = None) -> tuple[Array, Array, Array]:
    """Standard uncertainties of point (3,), axis (3,), sizes (s,) for unit noise in every coordinate."""
    sens = sensitivity(gauss(kind, points, fixed_axis=fixed_axis), points, fixed_axis=fixed_axis)
    return tuple(np.sqrt(np.sum(a**2, axis=(1, 2))) for a in (sens.point, sens.axis, sens.sizes))


@pytest.mark.parametrize("fixed", [True, False])
@pytest.mark.parametrize("n", [8, 25])
def test_full_circle(n: int, fixed: bool) -> None:
    # J columns: cos, sin, 1 over the full circle are orthogonal with sums n/2, n/2, n
    point, _, sizes = deviations("circle", arc(25.0, n), UP if fixed else None)
    assert point[:2] == pytest.approx([np.sqrt(2 / n)] * 2, rel=1e-12)
    assert sizes == pytest.approx([1 / np.sqrt(n)], rel=1e-12)
    assert point[2] == pytest.approx(1 / np.sqrt(n), rel=1e-12)  # mean height


@pytest.mark.parametrize(
    ("degrees", "x", "y", "r", "digit"),
    [(180.0, 0.610, 0.277, 0.423, 5e-4), (90.0, 2.11, 0.453, 1.89, 5e-3), (45.0, 8.15, 0.862, 7.92, 5e-3)],
)
def test_arc_of_25_points(degrees: float, x: float, y: float, r: float, digit: float) -> None:
    points = arc(25.0, 25, degrees)
    point, _, sizes = deviations("circle", points, UP)
    assert [*point[:2], *sizes] == pytest.approx([x, y, r], abs=digit)
    columns = np.concatenate([-points[:, :2] / 25.0, -np.ones((25, 1))], axis=1)  # closed form (J^T J)^-1
    assert [*point[:2], *sizes] == pytest.approx(
        np.sqrt(np.diag(np.linalg.inv(columns.T @ columns))), rel=1e-9
    )


def test_sphere_of_iso_10360_5() -> None:
    # x: sum n_x^2 over 4, 8, 4, 8 points = 2 sin^2 22.5 + 4 sin^2 45 + 2 sin^2 67.5 + 4 sin^2 90
    #    = 2 (sin^2 22.5 + cos^2 22.5) + 2 + 4 = 8, u = 1/sqrt 8 = .3536; z and r are coupled: .5462 and .3277
    point, _, sizes = deviations("sphere", hemisphere(12.5))
    assert point == pytest.approx([0.35355, 0.35355, 0.5462], abs=5e-5)
    assert sizes == pytest.approx([0.3277], abs=5e-5)


def test_plane_4_by_4() -> None:
    # u(z) = 1/sqrt 16; tilt 1/sqrt(sum x^2), x = +-50, +-16.667: 8 * 2500 + 8 * 277.78 = 22222, u = .006708
    x, y = np.meshgrid(np.linspace(-50, 50, 4), np.linspace(-50, 50, 4))
    point, axis, _ = deviations("plane", np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1))
    assert point[2] == pytest.approx(0.25, rel=1e-12)
    assert axis == pytest.approx([0.006708, 0.006708, 0.0], abs=5e-7)


@pytest.mark.parametrize(
    ("levels", "n", "centre", "tilt", "radius"),
    [((-25.0, 0.0, 25.0), 8, 0.2887, 0.014142, 0.2041), ((-25.0, 25.0), 4, 0.5, 0.02, 0.35355)],
)
def test_cylinder(levels: tuple[float, ...], n: int, centre: float, tilt: float, radius: float) -> None:
    # 3 x 8: centre sqrt(2/24), tilt sqrt(2 / sum z^2) with sum z^2 = 16 * 625, radius 1/sqrt 24
    point, axis, sizes = deviations("cylinder", np.concatenate([arc(10.0, n, z=z) for z in levels]))
    assert point[:2] == pytest.approx([centre] * 2, abs=5e-5)
    assert axis == pytest.approx([tilt, tilt, 0.0], abs=5e-7)
    assert sizes == pytest.approx([radius], abs=5e-5)


def test_line_and_point() -> None:
    # 5 points at z = -20..20: transverse 1/sqrt 5, direction 1/sqrt(400 + 100 + 100 + 400) = .031623
    points = np.array([[0, 0, z] for z in (-20.0, -10.0, 0.0, 10.0, 20.0)])
    point, axis, _ = deviations("line", points)
    assert point == pytest.approx([1 / np.sqrt(5)] * 3, rel=1e-12)
    assert axis == pytest.approx([0.0316228, 0.0316228, 0.0], abs=1e-7)
    assert deviations("point", points)[0] == pytest.approx([1 / np.sqrt(5)] * 3, rel=1e-12)


@pytest.mark.parametrize(
    ("kind", "fixed"),
    [(k, False) for k in KINDS] + [(k, True) for k in KINDS if k not in ("point", "sphere")],
)
def test_against_central_differences(kind: str, fixed: bool) -> None:
    ref = reference(kind, np.random.default_rng(21), Recipe(n=14, form=2e-4, arc=3.0))
    axis = ref.axis if fixed else None
    nominal = gauss(kind, ref.points, fixed_axis=axis)
    sens = sensitivity(nominal, ref.points, fixed_axis=axis)
    h = 2e-5 if kind in ("point", "line") else 1e-3  # a distance of 1e-4 mm must stay away from its kink at 0
    step = h * np.eye(42).reshape(42, 14, 3)
    up, down = (gauss(kind, ref.points + s, nominal, fixed_axis=axis) for s in (step, -step))
    for name, scale in (("point", 1.0), ("axis", 1.0), ("sizes", 1.0), ("residuals", 1.0)):
        difference = (getattr(up, name) - getattr(down, name)) / (2 * h)
        want = np.moveaxis(difference.reshape(14, 3, -1), -1, 0)
        loose = 0.1 if kind in ("point", "line") and name == "residuals" else 3e-4
        assert getattr(sens, name) == pytest.approx(want, abs=loose * scale)
    # the test sees the sensitivities, not zeros
    assert np.max(np.abs(sens.residuals)) > 0.3


def noisy(points: Array, trials: int, s: float) -> Array:
    return s * np.random.default_rng(22).standard_normal((trials, *points.shape))


# bounds: largest difference in 300 draws, measured here, rounded up by a factor of about 2 (nm)
OPERATOR = [
    ("circle", arc(25.0, 25), 0.1),
    ("circle", arc(5.0, 8), 0.8),
    ("circle", arc(50.0, 15, 60.0), 10.0),
    ("cylinder", np.concatenate([arc(20.0, 8, z=z) for z in (-20.0, 0.0, 20.0)]), 0.12),
    ("cylinder", np.concatenate([arc(20.0, 8, 90.0, z) for z in (-20.0, 0.0, 20.0)]), 4.0),
    ("sphere", hemisphere(15.0), 0.5),
]


@pytest.mark.parametrize(("kind", "points", "bound"), OPERATOR)
def test_linear_operator_against_exact_fits_at_1_um(kind: str, points: Array, bound: float) -> None:
    nominal = gauss(kind, points)
    noise = noisy(points, 300, 1e-3)
    exact = gauss(kind, points + noise, nominal)
    linear = linear_fit(nominal, sensitivity(nominal, points), noise)
    worst = np.max(np.abs(linear.sizes - exact.sizes)) * 1e6
    assert worst < bound
    assert worst > 1e-4  # the exact fit is not the linear one
    assert np.max(np.abs(linear.point - exact.point)) * 1e6 < 2.5 * bound
    assert np.max(np.abs(linear.residuals - exact.residuals)) * 1e6 < 4.0 * max(bound, 0.5)


def test_full_circle_bias_is_the_known_tangential_term() -> None:
    # a tangential deviation e_t from the fitted circle lengthens the radius by e_t^2 / 2R; its variance is
    # s^2 (1 + 2/25), the point's and the centre's: 1.08e-6 mm^2 / 50 mm = 2.16e-8 mm = 0.0216 nm
    points = arc(25.0, 25)
    nominal = gauss("circle", points, fixed_axis=UP)
    noise = noisy(points, 3000, 1e-3)
    exact = gauss("circle", points + noise, nominal, fixed_axis=UP)
    linear = linear_fit(nominal, sensitivity(nominal, points, fixed_axis=UP), noise)
    assert np.mean(exact.sizes - linear.sizes) * 1e6 == pytest.approx(0.0216, abs=0.003)


@pytest.mark.parametrize("kind", KINDS)
def test_linear_fit_shapes_and_unit_vectors(kind: str) -> None:
    ref = reference(kind, np.random.default_rng(23))
    nominal = gauss(kind, ref.points)
    sens = sensitivity(nominal, ref.points)
    fit = linear_fit(nominal, sens, noisy(ref.points, 6, 1e-3).reshape(2, 3, 30, 3))
    exact = gauss(kind, ref.points + noisy(ref.points, 6, 1e-3).reshape(2, 3, 30, 3), nominal)
    for name in ("point", "axis", "sizes", "residuals", "normals"):
        assert getattr(fit, name).shape == getattr(exact, name).shape
    assert fit.point == pytest.approx(exact.point, abs=2e-6)
    assert fit.residuals == pytest.approx(exact.residuals, abs=3e-6)
    same = linear_fit(nominal, sens, np.zeros((30, 3)))
    assert same.residuals == pytest.approx(nominal.residuals, abs=1e-15)
    assert same.normals == pytest.approx(nominal.normals, abs=1e-12)


def test_straight_line_residuals_are_distances() -> None:
    # nominal distances are 0, where a distance has no derivative: the vectors are propagated instead
    points = np.linspace(0, 100, 11)[:, None] * np.array([0.0, 0.6, 0.8])
    nominal = gauss("line", points)
    noise = noisy(points, 50, 1e-3)
    exact = gauss("line", points + noise, nominal)
    linear = linear_fit(nominal, sensitivity(nominal, points), noise)
    assert linear.residuals == pytest.approx(exact.residuals, abs=2e-7)
    assert np.all(linear.residuals >= 0)


def test_refusals() -> None:
    points = arc(10.0, 8)
    fit = gauss("circle", points)
    with pytest.raises(UsageError, match="one fit and its points"):
        sensitivity(fit, points[:-1])
    with pytest.raises(UsageError, match="one fit and its points"):
        sensitivity(gauss("circle", np.stack([points] * 2)), np.stack([points] * 2))
    with pytest.raises(UsageError, match=r"shape \(\.\.\., 8, 3\)"):
        linear_fit(fit, sensitivity(fit, points), np.zeros((7, 3)))
    one_level = gauss("cylinder", points, fixed_axis=UP)
    with pytest.raises(ModelLimit, match="tilt of the cylinder"):
        sensitivity(one_level, points)


def test_ten_thousand_points_need_no_square_of_it() -> None:
    """u(r) = 1 / sqrt(n); a dense residual operator would hold 2.4 GB."""
    import tracemalloc

    points = arc(25.0, 10_000)
    fitted = gauss("circle", points, fixed_axis=UP)
    tracemalloc.start()
    sens = sensitivity(fitted, points, fixed_axis=UP, residuals=False)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert sens.residuals is None
    assert np.sqrt((sens.sizes**2).sum()) == pytest.approx(0.01, rel=1e-9)
    assert most < 50e6


@pytest.mark.parametrize("fixed", [True, False])
def test_without_residuals_nothing_else_changes(fixed: bool) -> None:
    points = arc(25.0, 12, 300.0) + 1e-3 * np.random.default_rng(1).standard_normal((12, 3))
    axis = UP if fixed else None
    fitted = gauss("circle", points, fixed_axis=axis)
    lean = sensitivity(fitted, points, fixed_axis=axis, residuals=False)
    full = sensitivity(fitted, points, fixed_axis=axis)
    assert np.array_equal(lean.sizes, full.sizes)
    assert np.array_equal(lean.point, full.point)
