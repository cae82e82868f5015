"""Choice of touches: textbook designs by hand, the bound of optimal design, updates of rank one."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.answer.placing.design import Design, Target, TouchCandidates, exchange_touches, fewest_touches
from vcmm.answer.placing.form_field import form_factor, surface_grid
from vcmm.answer.placing.motions import motions_of
from vcmm.part.form import Lobes
from vcmm.part.part import Feature
from vcmm.task.measuring.strategies import Around, plan_points

Z = np.array([0.0, 0.0, 1.0])


PLANE = Feature("top", "plane", np.zeros(3), Z, np.zeros(0), extent=(80.0, 80.0))


CIRCLE = Feature("ring", "circle", np.zeros(3), Z, np.array([10.0]))


def candidates(feature, points, shared=None, touch=1e-3, short=0.0) -> TouchCandidates:
    """One feature with plain scatter."""
    from vcmm.part.part import normal

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


def on_plane(*xy):
    return np.array([[x, y, 0.0] for x, y in xy])


def test_plane_by_hand():
    """Height at the centroid: sigma / sqrt(n). Tilt about y: sigma / sqrt(sum x^2)."""
    points = on_plane((-30, -30), (30, -30), (-30, 30), (30, 30))
    c = candidates(PLANE, points)
    rows = np.array([[1.0, 0, 0], [0, 0, 1.0]])  # height; tilt about v
    design = Design(c, Target(rows, np.ones(2)), np.ones(4, dtype=int))
    u = np.sqrt(design.variances())
    assert u[0] == pytest.approx(1e-3 / 2.0)  # 1 um / sqrt(4)
    assert u[1] == pytest.approx(1e-3 / 60.0)  # sum x^2 = 4 x 900 mm^2


def test_tilt_wants_the_ends():
    """c-optimal for the tilt about v: all touches at the two edges x = +-40, as far apart as they can be."""
    c = candidates(PLANE, surface_grid(PLANE, 9))
    design = Design(c, Target(np.array([[0.0, 0, 1.0]]), np.ones(1)), fewest_touches(c, 5))
    exchange_touches(design, passes=10)
    used = c.points[design.counts > 0]
    assert np.allclose(np.abs(used[:, 0]), 40.0)
    # u = sigma / sqrt(8 x 1600) = 1 um / 113.137 mm
    assert np.sqrt(design.variances()[0]) == pytest.approx(1e-3 / np.sqrt(8 * 1600.0))


def white_noise_bound(
    rows: np.ndarray, outputs: np.ndarray, weight: np.ndarray, steps: int = 2000
) -> tuple[float, np.ndarray]:
    """No n touches with independent scatter sigma do better than bound sigma^2 / n; also the shares (N,) of the best.

    For psi(x) = sum weight b^T M(x)^-1 b over shares x (convex), psi(best) >= 2 psi(x) - max_j sum weight (b^T M^-1 J_j)^2.
    Multiplicative gradient steps: Silvey, Titterington & Torsney, Commun. Stat. A7 (1978) 1379.
    """
    share = np.full(len(rows), 1.0 / len(rows))
    bound = 0.0
    for _ in range(steps):
        read = np.linalg.solve((rows.T * share) @ rows, outputs.T).T @ rows.T
        slope = weight @ read**2
        psi = float(share @ slope)
        bound = max(bound, 2.0 * psi - float(slope.max()))
        share = share * np.sqrt(slope / psi)
        share /= share.sum()
        if psi - bound < 1e-6 * psi:
            break
    return bound, share


def test_no_design_beats_the_bound_and_the_exchange_reaches_it():
    c = candidates(PLANE, surface_grid(PLANE, 9))
    rows, weight = np.array([[0.0, 0, 1.0], [0, 1.0, 0]]), np.ones(2)
    bound, share = white_noise_bound(c.rows[0], rows, weight)
    # both tilts: the four corners, 1/1600 each
    assert bound == pytest.approx(2.0 / 1600.0, rel=1e-3)
    assert share.sum() == pytest.approx(1.0)
    design = exchange_touches(Design(c, Target(rows, weight), fewest_touches(c, 5)), passes=10)
    assert design.value() >= bound * 1e-6 / design.n * (1 - 1e-9)
    assert design.value() <= 1.001 * bound * 1e-6 / design.n


def test_d_optimal_plane_is_the_corners():
    c = candidates(PLANE, surface_grid(PLANE, 9))
    design = exchange_touches(
        Design(c, Target(np.zeros((0, 3)), np.zeros(0), "D"), fewest_touches(c, 1)), passes=10
    )
    used = c.points[design.counts > 0]
    assert np.allclose(np.abs(used[:, :2]), 40.0)
    # det = 4 x (4 x 1600)^2
    assert design.log_det == pytest.approx(np.log(4 * 6400.0**2))


def test_the_exchange_leaves_the_aliased_three():
    points = plan_points(CIRCLE, Around(24))[0]
    shared, _ = form_factor(motions_of(CIRCLE), points, 0.0, Lobes(3, 1e-3), (points, points / 10.0))
    c = candidates(CIRCLE, points, shared, touch=1e-4)
    counts = np.zeros(24, dtype=int)
    counts[[0, 8, 16]] = 1
    counts[0] = 2
    design = Design(c, Target(np.array([[0, 0, 2.0]]), np.ones(1)), counts)
    assert np.sqrt(design.variances()[0]) > 1.3e-3
    exchange_touches(design, passes=6)
    # four touches 90 deg apart (or as good): only scatter is left, 2 x 0.1 um / sqrt 4 = 0.1 um
    assert np.sqrt(design.variances()[0]) == pytest.approx(1e-4, rel=0.01)


def test_repeats_average_scatter_but_not_the_surface():
    points = on_plane((-30, -30), (30, -30), (-30, 30), (30, 30))
    c = candidates(PLANE, points, touch=1e-3, short=2e-3)
    rows = np.array([[1.0, 0.0, 0.0]])
    once = Design(c, Target(rows, np.ones(1)), np.ones(4, dtype=int)).variances()[0]
    twice = Design(c, Target(rows, np.ones(1)), 2 * np.ones(4, dtype=int)).variances()[0]
    assert once == pytest.approx((1.0 + 4.0) * 1e-6 / 4)  # mean of four: (1^2 + 2^2) / 4
    assert twice == pytest.approx((0.5 + 4.0) * 1e-6 / 4)


def test_one_touch_more_or_less_by_rank_one_update():
    rng = np.random.default_rng(5)
    c = candidates(PLANE, surface_grid(PLANE, 7), rng.normal(size=(49, 6)) * 1e-3, short=4e-4)
    counts = rng.integers(0, 3, 49)
    for target in (
        Target(rng.normal(size=(2, 3)), np.array([1.0, 3.0])),
        Target(np.zeros((0, 3)), np.zeros(0), "D"),
    ):
        design = Design(c, target, counts)
        for sign in (1, -1):
            change = design.changes(0, sign)
            for i in np.flatnonzero(np.isfinite(change))[:12]:
                other = design.copy()
                other.counts[i] += sign
                other.refresh()
                assert other.value() - design.value() == pytest.approx(change[i], rel=1e-6, abs=1e-18)
