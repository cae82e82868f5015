"""The form of the surface as a field: lobes by hand, draws and fits, what a dense measurement sees."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.answer.placing.design import Design, Target, TouchCandidates
from vcmm.answer.placing.form_field import _lobe_columns, _polynomials, _spherical, form_factor, surface_grid
from vcmm.answer.placing.motions import motions_of
from vcmm.part.fit import gauss
from vcmm.part.form import Lobes
from vcmm.part.part import Feature, frame, normal
from vcmm.task.measuring.strategies import Around, Levels, plan_points

Z = np.array([0.0, 0.0, 1.0])


CIRCLE = Feature("ring", "circle", np.zeros(3), Z, np.array([10.0]))


def candidates(feature, points, shared=None, touch=1e-3, short=0.0) -> TouchCandidates:
    """One feature with plain scatter."""
    n = len(points)
    normals = normal(feature, points)
    rows = motions_of(feature).rows(points, normals)
    a = np.zeros((n, 0)) if shared is None else shared
    whole = np.zeros(n, dtype=int)
    return TouchCandidates(
        (feature.name,),
        whole,
        points,
        normals,
        rows=(rows,),
        common=a,
        touch=np.full(n, touch),
        short=np.full(n, short),
        seconds=np.ones(1),
    )


def lobed(n: int, lobes: int) -> float:
    """u of the diameter (mm) from n equally spaced touches, form of 1 um amplitude and unknown phase, no scatter."""
    points = plan_points(CIRCLE, Around(n))[0]
    reference = surface_grid(CIRCLE, 96)
    there = (reference, reference / 10.0)
    shared, _ = form_factor(motions_of(CIRCLE), points, 0.0, Lobes(lobes, 1e-3), there)
    c = candidates(CIRCLE, points, shared, touch=0.0)
    return float(
        np.sqrt(Design(c, Target(np.array([[0, 0, 2.0]]), np.ones(1)), np.ones(n, dtype=int)).variances()[0])
    )


def test_three_touches_take_three_lobes_for_diameter():
    # three equally spaced touches all see cos(3 theta - phase): radius off by 1 um cos(phase): u_d = 2 x 1 um / sqrt 2
    assert lobed(3, 3) == pytest.approx(2e-3 / np.sqrt(2.0))
    assert lobed(4, 3) == pytest.approx(0.0, abs=1e-12)
    assert lobed(4, 4) == pytest.approx(2e-3 / np.sqrt(2.0))
    assert lobed(5, 3) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.thorough
def test_form_agrees_with_draws_and_fits():
    """A cylinder whose form is drawn from the field and fitted: the spread of its diameter is that of the closed form."""
    bore = Feature("bore", "cylinder", np.zeros(3), Z, np.array([15.0]), inside=True, extent=(20.0,))
    points, normals = plan_points(bore, Levels((5.0, 15.0), 5))
    reference = surface_grid(bore, 48)
    factor, short = form_factor(motions_of(bore), points, 1e-3, None, (reference, normal(bore, reference)))
    z = np.random.default_rng(8).normal(size=(4000, factor.shape[1]))
    noise = short * np.random.default_rng(9).normal(size=(4000, len(points)))
    fitted = gauss("cylinder", points + (z @ factor.T + noise)[..., None] * normals)
    c = candidates(bore, points, factor, touch=0.0, short=short)
    rows = np.zeros((1, 5))
    rows[0, 4] = 2.0
    u = np.sqrt(Design(c, Target(rows, np.ones(1)), np.ones(10, dtype=int)).variances()[0])
    assert np.std(2.0 * fitted.sizes[:, 0]) == pytest.approx(u, rel=0.05)  # 4000 draws: 1.1 %
    assert np.sqrt(np.mean(np.sum(factor**2, axis=1)) + short**2) == pytest.approx(1e-3, rel=0.3)


def test_a_dense_measurement_sees_no_error_of_form():
    """The measurand is the fit to the whole surface: touching all of it leaves nothing but the short part."""
    reference = surface_grid(CIRCLE, 48)
    factor, _ = form_factor(motions_of(CIRCLE), reference, 1e-3, None, (reference, reference / 10.0))
    c = candidates(CIRCLE, reference, factor, touch=0.0)
    rows = np.eye(3)
    assert np.allclose(
        Design(c, Target(rows, np.ones(3)), np.ones(48, dtype=int)).variances(), 0.0, atol=1e-20
    )


UP = np.array([0.0, 0.0, 1.0])
FEATURES = (
    Feature("plane", "plane", np.zeros(3), UP, np.zeros(0), extent=(80.0, 60.0)),
    Feature("line", "line", np.zeros(3), np.array([1.0, 0, 0]), np.zeros(0), extent=(60.0,)),
    Feature("ball", "sphere", np.zeros(3), np.zeros(3), np.array([8.0])),
    Feature("pin", "cylinder", np.zeros(3), UP, np.array([5.0]), extent=(30.0,)),
    Feature("cone", "cone", np.zeros(3), UP, np.array([5.0, 0.2]), extent=(30.0,)),
    Feature("tyre", "torus", np.zeros(3), UP, np.array([20.0, 4.0])),
)


def test_variance_over_the_surface_is_what_was_asked_for():
    """Where the fit sees nothing, the field has the mean variance 0.9 s^2, the short part 0.1 s^2."""
    for feature in FEATURES:
        reference = surface_grid(feature, 24)
        factor, short = form_factor(
            motions_of(feature), reference, 2e-3, None, (reference, normal(feature, reference))
        )
        assert np.mean(np.sum(factor**2, axis=1)) == pytest.approx(0.9 * 4e-6, rel=1e-9), feature.kind
        assert short**2 == pytest.approx(0.1 * 4e-6)


def test_lobes_fall_as_one_over_k():
    """On a circle the amplitude of lobe k is 1 / k of the constant's scale: the power of lobes 2 and 4 is as 4 to 1."""
    columns = _lobe_columns(CIRCLE, surface_grid(CIRCLE, 64))
    power = (columns**2).mean(axis=0)
    # columns: constant, then cosine and sine of 1, 2, 3, ...
    assert power[3] == pytest.approx(0.5 / 4)  # cos 2: (1/2)^2 / 2
    assert power[7] == pytest.approx(0.5 / 16)  # cos 4
    assert power[0] == pytest.approx(0.25)


def test_polynomials_and_harmonics_have_the_power_of_their_degree():
    """Legendre of degree k has the mean square 1 / k^2 over a line; harmonics of degree n sum to (2 n + 1) / n^2 at any point."""
    line = FEATURES[1]
    power = (_polynomials(line, surface_grid(line, 4001)) ** 2).mean(axis=0)
    assert power == pytest.approx([1 / 4, 1 / 9, 1 / 16, 1 / 25], rel=5e-3)
    plane = FEATURES[0]
    u, v, _ = frame(plane)
    corner = plane.point + 0.5 * (plane.extent[0] * u + plane.extent[1] * v)
    # at the corner every Legendre polynomial is 1: sqrt((2 i + 1) (2 j + 1)) / (i + j); (0, 2), (1, 1) and (3, 1)
    there = sorted(_polynomials(plane, corner[None])[0])
    for i, j in ((0, 2), (1, 1), (3, 1)):
        assert np.isclose(there, np.sqrt((2 * i + 1) * (2 * j + 1)) / (i + j)).any()
    assert there[-1] == pytest.approx(1.5)  # (1, 1): 3 / 2, the largest
    ball = FEATURES[2]
    square = _spherical(ball, surface_grid(ball, 4)) ** 2
    assert square[:, :5].sum(axis=1) == pytest.approx(5 / 4)
    assert square[:, 5:12].sum(axis=1) == pytest.approx(7 / 9)


def test_grids_keep_the_margin():
    plane, line, ball, pin, cone, tyre = FEATURES
    assert np.abs(surface_grid(plane, 9, 5.0)[:, 0]).max() == pytest.approx(35.0)
    assert np.ptp(surface_grid(line, 9, 5.0)[:, 0]) == pytest.approx(50.0)
    assert np.ptp(surface_grid(pin, 24, 4.0)[:, 2]) == pytest.approx(22.0)
    assert np.ptp(surface_grid(pin, 24, 20.0)[:, 2]) == pytest.approx(
        15.0
    )  # no more than a quarter from each end
    assert np.linalg.norm(surface_grid(ball, 8), axis=1) == pytest.approx(8.0)
    assert surface_grid(ball, 8)[:, 2].mean() == pytest.approx(0.0, abs=1e-9)
    assert np.abs(surface_grid(tyre, 16)[:, 2]).max() == pytest.approx(4.0)
    assert len(surface_grid(cone, 12)) == 12 * 5


def test_a_leaning_wall_is_out_by_opposite_amounts_at_its_ends():
    # the first column beyond the circle's own 31 (1 and 15 pairs): Legendre degree 1 alone, weight 1/2 (k = 0) x sqrt(3) / 2
    wall = Feature("wall", "cylinder", np.array([0.0, 0.0, 5.0]), np.array([0.0, 0.0, 1.0]), np.array([10.0]), True, (30.0,))  # fmt: skip
    foot, middle, head = np.array([10.0, 0.0, 5.0]), np.array([10.0, 0.0, 20.0]), np.array([10.0, 0.0, 35.0])
    assert _lobe_columns(wall, np.array([foot, middle, head]))[:, 31] == pytest.approx(
        [-0.4330127, 0.0, 0.4330127]
    )


def test_polynomials_of_a_plane_end_with_the_fifth_degree():
    """Pairs (i, j) with 2 <= i + j <= 5: 4 + 4 + 4 + 3 + 2 + 1 = 18; at the corner all Legendre polynomials are 1, so that (0, 2)
    is sqrt(1 x 5) / 2 and (5, 0) sqrt(11 x 1) / 5."""
    plane = Feature("top", "plane", np.zeros(3), Z, np.zeros(0), extent=(80.0, 40.0))
    u, v, _ = frame(plane)
    (row,) = _polynomials(plane, np.array([40.0 * u + 20.0 * v]))
    assert len(row) == 18
    assert (row[0], row[-1]) == pytest.approx((np.sqrt(5.0) / 2, np.sqrt(11.0) / 5))
