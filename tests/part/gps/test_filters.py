"""Filters of ISO 16610 on waves whose share that passes is computed by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.part.characteristic import Filter
from vcmm.part.fit import gauss
from vcmm.part.gps import characteristics as gps
from vcmm.part.gps.criteria import with_criteria
from vcmm.part.gps.filters import ALPHA, apply_filter, check_density, minimum_zone, transmission, words
from vcmm.part.part import Characteristic, Feature, surface_point

RING = Feature("ring", "circle", np.zeros(3), np.array([0.0, 0, 1]), np.array([15.0]), inside=True)
EDGE = Feature(
    "edge", "line", np.zeros(3), np.array([1.0, 0, 0]), np.zeros(0), extent=(40.0,), u=np.array([0.0, 0, 1])
)
ROUND = Characteristic("round", "roundness", of=("ring",), zone=0.01, filter=Filter("gaussian", upr=50))


def ring(n: int, jitter: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    turn = (np.arange(n) + jitter * np.random.default_rng(1).uniform(-0.5, 0.5, n)) * 2 * np.pi / n
    return turn, surface_point(RING, turn)


def edge(n: int) -> tuple[np.ndarray, np.ndarray]:
    at = np.linspace(0.0, 40.0, n)
    return at, surface_point(EDGE, at)


def share(values: np.ndarray, wave: np.ndarray) -> float:
    return float(values @ wave / (wave @ wave))


def test_the_constant() -> None:
    assert pytest.approx(0.4697, abs=5e-5) == ALPHA  # sqrt(ln 2 / pi)


@pytest.mark.parametrize("kind", ["gaussian", "spline"])
@pytest.mark.parametrize("jitter", [0.0, 0.4])
def test_half_passes_at_the_cut_off_of_a_closed_profile(kind: str, jitter: float) -> None:
    """Gaussian: 2^-(k / 50)^2: 50 waves 1/2, 25 waves 2^-0.25 = 0.8409, 100 waves 2^-4 = 0.0625. Spline: 1/2 at 50."""
    if kind == "spline" and jitter:
        return  # refused, below
    turn, points = ring(720, jitter)
    by_hand = {50: 0.5} if kind == "spline" else {50: 0.5, 25: 0.8409, 100: 0.0625}
    for waves, expected in by_hand.items():
        wave = np.cos(waves * turn)
        passed = apply_filter(Filter(kind, upr=50), RING, points, wave)
        assert share(passed, wave) == pytest.approx(expected, abs=2e-3 if jitter else 1e-4)


def test_the_spline_falls_more_steeply() -> None:
    """At twice the cut-off, 720 points: 1 / (1 + (sin 25 deg / sin 12.5 deg)^4) = 1 / (1 + 1.9526^4) = 0.0644."""
    f = Filter("spline", upr=50)
    ratio = math.sin(100 * math.pi / 720) / math.sin(50 * math.pi / 720)
    assert 1 / (1 + ratio**4) == pytest.approx(0.0644, abs=1e-4)
    turn, points = ring(720)
    wave = np.cos(100 * turn)
    assert share(apply_filter(f, RING, points, wave), wave) == pytest.approx(1 / (1 + ratio**4), abs=1e-9)
    assert (
        transmission(f, np.array([25.0]), 720)[0]
        > transmission(Filter("gaussian", upr=50), np.array([25.0]), 720)[0]
    )


@pytest.mark.parametrize("kind", ["gaussian", "spline"])
def test_half_passes_at_the_cut_off_of_an_open_profile(kind: str) -> None:
    """A wave of 2 mm at a cut-off of 2 mm, away from the ends; a straight line passes whole in the middle, any order of points."""
    at, points = edge(801)
    wave, inner = np.cos(2 * np.pi * at / 2.0), slice(200, 601)
    passed = apply_filter(Filter(kind, cutoff=2.0), EDGE, points, wave)
    assert share(passed[inner], wave[inner]) == pytest.approx(0.5, abs=2e-3)
    sloped = apply_filter(Filter(kind, cutoff=2.0), EDGE, points, 0.1 * at)
    assert sloped[inner] == pytest.approx(0.1 * at[inner], abs=1e-9)
    assert apply_filter(Filter(kind, cutoff=2.0), EDGE, points, np.ones(801)) == pytest.approx(np.ones(801))
    order = np.random.default_rng(2).permutation(801)
    assert apply_filter(Filter(kind, cutoff=2.0), EDGE, points[order], wave[order]) == pytest.approx(
        passed[order]
    )


def test_an_uneven_open_profile() -> None:
    at = np.sort(np.random.default_rng(3).uniform(0, 40.0, 2000))
    wave = np.cos(2 * np.pi * at / 4.0)
    passed = apply_filter(Filter("gaussian", cutoff=4.0), EDGE, surface_point(EDGE, at), wave)
    assert share(passed[500:1500], wave[500:1500]) == pytest.approx(0.5, abs=0.02)


def test_roundness_with_a_filter() -> None:
    """5 um of 3 lobes and 2 um of 100 waves: 2 x 5 x 2^-(3/50)^2 + at most 2 x 2 / 16 um. Without: more than 13.5 um."""
    turn, points = ring(720)
    away = 5e-3 * np.cos(3 * turn) + 2e-3 * np.cos(100 * turn)
    measured = points * (1.0 + away / 15.0)[:, None]
    fitted = {"ring": gauss("circle", measured, fixed_axis=RING.axis)}
    for c, low, high in (
        (ROUND, 9.95e-3, 10.25e-3),
        (Characteristic("r", "roundness", of=("ring",)), 13.5e-3, 14.01e-3),
    ):
        also = with_criteria([c], {"ring": RING}, lambda name: measured, fitted)
        assert low < float(gps.evaluate(c, {"ring": RING}, also)) < high


def test_what_is_refused() -> None:
    features = {"ring": RING, "edge": EDGE}
    cases = (
        (Filter("gauss", upr=50), "roundness", "ring", 'filter = "gauss"'),
        (Filter("gaussian"), "roundness", "ring", "needs its upr alone"),
        (Filter("gaussian", upr=50, cutoff=0.8), "roundness", "ring", "needs its upr alone"),
        (Filter("gaussian", upr=50), "straightness", "edge", "needs its cutoff alone"),
        (Filter("gaussian", upr=50), "size", "ring", "of one profile"),
    )
    for f, kind, of, message in cases:
        with pytest.raises(UsageError, match=message):
            gps.nominal(Characteristic("c", kind, of=(of,), filter=f), features)
    with pytest.raises(UsageError, match="needs 350 points, 7 per wave"):
        check_density(ROUND, RING, ring(200)[1])
    spline = Characteristic("c", "roundness", of=("ring",), filter=Filter("spline", upr=15))
    with pytest.raises(UsageError, match="evenly spaced"):
        check_density(spline, RING, ring(200, 0.8)[1])
    check_density(spline, RING, ring(200)[1])


def test_words() -> None:
    assert words(Filter("gaussian", upr=50)) == "gaussian filter ISO 16610-21, 50 UPR"
    assert words(Filter("spline", cutoff=0.8)) == "spline filter ISO 16610-22, cut-off 0.8 mm"


def smallest_range(columns: np.ndarray, values: np.ndarray) -> float:
    """min over x of the range of values - columns x, by linear programming (HiGHS)."""
    from scipy.optimize import linprog

    n, k = columns.shape
    cost = np.concatenate([np.zeros(k), [1.0, -1.0]])
    above = np.hstack([-columns, -np.ones((n, 1)), np.zeros((n, 1))])
    below = np.hstack([columns, np.zeros((n, 1)), np.ones((n, 1))])
    found = linprog(
        cost, A_ub=np.vstack([above, below]), b_ub=np.concatenate([-values, values]), bounds=(None, None)
    )
    return float(found.fun)


def test_minimum_zone_of_filtered_profiles() -> None:
    """Zone of the deviations that pass, against a linear program; and s^3 over a line without loss: 0.5 (Chebyshev), G 0.8."""
    rng = np.random.default_rng(6)
    turn, points = ring(720)
    rough = 1e-3 * sum(rng.normal() * np.cos(k * turn + rng.uniform(0, 6)) for k in (2, 3, 5, 90))
    passed = apply_filter(Filter("gaussian", upr=50), RING, points, rough)
    zone = minimum_zone(RING, points, passed)
    design = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    assert float(zone) == pytest.approx(smallest_range(design, passed), abs=2e-7)
    assert zone < np.ptp(passed - design @ np.linalg.lstsq(design, passed, rcond=None)[0]) - 1e-5
    at, line = edge(801)
    assert float(minimum_zone(EDGE, line, 1e-3 * (at / 20 - 1) ** 3)) == pytest.approx(0.5e-3, abs=1e-8)
    assert minimum_zone(RING, points, np.stack([passed, 2 * passed])).shape == (2,)


def test_roundness_by_the_minimum_zone_of_what_passes() -> None:
    """From measured points: waves of 2 and 90; the 90 are taken away but for 2^-(90/50)^2 = 0.1058 of 1 um."""
    turn, points = ring(720)
    heights = 2e-3 * np.cos(2 * turn) + 1e-3 * np.cos(90 * turn)
    c = Characteristic("r", "roundness", of=("ring",), criterion="C", filter=Filter("gaussian", upr=50))
    measured = points * (1 + heights / 15.0)[:, None]
    fitted = {"ring": gauss("circle", measured, fixed_axis=RING.axis)}
    also = with_criteria((c,), {"ring": RING}, lambda name: measured, fitted)
    passed = 2e-3 * np.exp2(-((2 / 50) ** 2)) * np.cos(2 * turn) + 1e-3 * np.exp2(-(1.8**2)) * np.cos(
        90 * turn
    )
    design = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    assert float(gps.evaluate(c, {"ring": RING}, also)) == pytest.approx(
        smallest_range(design, passed), abs=3e-6
    )
