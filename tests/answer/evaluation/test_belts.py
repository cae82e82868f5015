"""Forms, drawn parts and belts against cases that are known without them."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.answer.evaluation.belts import coverage, inverse_of
from vcmm.answer.evaluation.form_family import FAMILIES, Ground, bump, left_over, motions
from vcmm.answer.evaluation.pairs import Pairs
from vcmm.part.part import Characteristic, Feature, normal, surface_point

RING = Feature("ring", "circle", np.zeros(3), np.array([0.0, 0.0, 1.0]), np.array([10.0]), inside=True)
FLATNESS = Characteristic("f", "flatness", of=("top",))
SIZE = Characteristic("s", "size", of=("ring",), criterion="GX")


def around(n: int) -> np.ndarray:
    return surface_point(RING, np.arange(n) * 2 * np.pi / n)


@pytest.mark.parametrize("family", FAMILIES)
def test_forms_have_no_size_and_no_place(family: str) -> None:
    dense = around(90)
    few, many = FAMILIES[family](np.random.default_rng(1), Ground(RING, (around(9), dense)), 50)
    assert np.sqrt((many**2).mean(axis=1)) == pytest.approx(np.ones(50))
    moved = motions(RING, dense, normal(RING, dense))
    assert np.abs(many @ moved[:, [0, 1, 6]]).max() < 1e-8 * 90
    assert np.abs(many[:, ::10] - few).max() < 1e-9  # one surface, seen at both sets of points


def test_what_a_fit_leaves_of_three_lobes() -> None:
    """cos 3a is no motion and stays; cos a is a shift and goes; a constant is size and goes."""
    points = around(12)
    turn = np.arange(12) * 2 * np.pi / 12
    left = left_over(RING, points, normal(RING, points))
    assert left @ np.cos(3 * turn) == pytest.approx(np.cos(3 * turn))
    assert np.abs(left @ np.cos(turn)).max() < 1e-12
    assert np.abs(left @ np.ones(12)).max() < 1e-12


def drawn(true: np.ndarray, indicated: np.ndarray) -> Pairs:
    return Pairs(true[:, None], indicated[:, None], np.ones((len(true), 1)))


def test_an_error_that_does_not_depend_on_the_value() -> None:
    """y = t + e, e normal with u = 1: away from 0 the interval is y -+ 1.96, the confidence that t <= y + 1 is 84.1 %."""
    rng = np.random.default_rng(2)
    true = np.exp(rng.uniform(np.log(0.1), np.log(100.0), 40_000))
    inverse = inverse_of(FLATNESS, 0, [drawn(true, true + rng.normal(size=len(true)))])
    low, high = inverse.interval(0.95, np.array([30.0]), None)
    assert (low[0], high[0]) == pytest.approx((28.04, 31.96), abs=0.2)
    assert inverse.within(-np.inf, 31.0, 30.0, None) == pytest.approx(0.841, abs=0.03)
    assert inverse.estimate(np.array([30.0]), None)[0] == pytest.approx(30.0, abs=0.1)


def test_noise_that_only_adds() -> None:
    """y = sqrt(t^2 + e^2): a perfect part indicates |e| (97.5 %: 2.24). Below, the interval begins at 0; far above it does not."""
    rng = np.random.default_rng(3)
    true = np.concatenate([np.zeros(4000), np.exp(rng.uniform(np.log(0.05), np.log(40.0), 36_000))])
    inverse = inverse_of(FLATNESS, 0, [drawn(true, np.hypot(true, rng.normal(size=len(true))))])
    low, high = inverse.interval(0.95, np.array([1.0, 2.0, 10.0]), None)
    assert list(low[:2]) == [0.0, 0.0]
    assert 9.0 < low[2] < 9.99 < high[2] < 10.2
    assert high[0] > 0.95  # never shorter than what a perfect part leaves open
    fresh = np.full(4000, 1.5)
    held = coverage(inverse, 0, drawn(fresh, np.hypot(fresh, rng.normal(size=4000))), 0.95)
    assert 0.93 <= held <= 0.99


def test_a_size_moves_with_its_indication() -> None:
    """e of GX leans to one side: exponential of mean 1 below the true size. y + [q 2.5 %, q 97.5 %] = y + [0.025, 3.69]."""
    rng = np.random.default_rng(4)
    error = -rng.exponential(size=30_000)
    inverse = inverse_of(SIZE, 0, [Pairs(np.zeros((30_000, 1)), error[:, None], np.zeros((30_000, 1)))])
    low, high = inverse.interval(0.95, np.array([10.0]), None)
    assert (low[0], high[0]) == pytest.approx((10.025, 13.69), abs=0.06)


def test_the_interval_holds_every_family() -> None:
    """Two families, one that indicates 1 too much, one that is right, both without noise: y - 1 to y."""
    true = np.exp(np.random.default_rng(5).uniform(np.log(0.1), np.log(100.0), 8000))
    both = inverse_of(FLATNESS, 0, [drawn(true, true + 1.0), drawn(true, true)])
    low, high = both.interval(0.95, np.array([20.0]), None)
    assert (low[0], high[0]) == pytest.approx((19.0, 20.0), abs=0.02)
    assert both.within(-np.inf, 19.5, 20.0, None) == pytest.approx(
        0.0, abs=0.02
    )  # the one that is right doubts it


def test_points_without_residuals_are_read_as_those_of_the_smoothest_parts() -> None:
    """Errors as large as the residuals: for residuals of 0, as of typed-in points, the interval must not shrink to nothing."""
    rng = np.random.default_rng(6)
    rest = np.exp(rng.uniform(np.log(0.1), np.log(10.0), 20_000))
    error = rest * rng.normal(size=20_000)
    inverse = inverse_of(SIZE, 0, [Pairs(np.zeros((20_000, 1)), error[:, None], rest[:, None])])
    ends = [np.ravel(inverse.interval(0.95, np.array([5.0]), np.array([r]))) for r in (0.0, 0.1)]
    assert ends[0] == pytest.approx(ends[1], rel=0.02)
    assert ends[0] == pytest.approx(
        [5.0 - 1.96 * 0.105, 5.0 + 1.96 * 0.105], abs=0.03
    )  # 1 % of them: 0.1 x 100^0.01
    assert inverse.within(4.8, 5.2, 5.0, 0.0) == pytest.approx(0.94, abs=0.02)


def test_a_bump_falls_as_a_normal_law():
    """1 on top, exp(-1/2) = 0.606531 at one width, exp(-2) = 0.135335 at two; (3, 4) lies 5 off: exp(-25 / 50) for a width of 5."""
    across, along = np.array([0.0, 0.2, 0.0, 3.0]), np.array([0.0, 0.0, -0.4, 4.0])
    width = np.array([0.2, 0.2, 0.2, 5.0])
    assert bump(across, along, width) == pytest.approx([1.0, 0.606531, 0.135335, 0.606531], abs=1e-6)


@pytest.mark.parametrize("count", [2400, 3000, 12_000])
def test_the_upper_end_does_not_grow_where_fewer_parts_are_drawn(count: int) -> None:
    """Points that see half of every form, t (0.5 +- 0.02), over three decades: 1 um is read of parts up to 1 / (0.5 - 1.812 x 0.02) = 2.156 um
    (3.5 % at this end alone, MOST_ONE_SIDED). A window of 1/40 of the parts spans 6.9 / 40 of ln t: the largest of it are 9 % larger and lack
    0.5 x 0.09 more, and its neighbours, 2.5 widths to either side with falling weights, 0.5 x 0.016: at most 1 / (0.464 - 0.053) = 2.43 um for
    any number of parts, and 3 % of chance. Windows of a tenth gave 12.0 um with 3000 parts and 2.4 with 12 000.
    """
    rng = np.random.default_rng(7)
    true = 1e-4 * 10 ** (3 * rng.random(count))
    seen = true * (0.5 + 0.02 * rng.standard_normal(count))
    pairs = Pairs(true[:, None], seen[:, None], np.ones((count, 1)))
    flat = Characteristic("f", "flatness", of=("top",), zone=0.1)
    (high,) = inverse_of(flat, 0, [pairs]).interval(0.95, np.array([1e-3]), None)[1]
    assert 2.156e-3 < high < 1.03 * 2.43e-3, high
