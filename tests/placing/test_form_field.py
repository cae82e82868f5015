"""The form of the surface as a field: lobes by hand, draws and fits, what a dense measurement sees."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.fit import gauss
from vcmm.measuring.strategies import Around, Levels, plan_points
from vcmm.part.form import Lobes
from vcmm.part.part import Feature
from vcmm.placing.design import Design, Target, TouchCandidates
from vcmm.placing.form_field import form_factor, surface_grid
from vcmm.placing.motions import motions_of

Z = np.array([0.0, 0.0, 1.0])


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
        shared=a,
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


def test_form_agrees_with_draws_and_fits():
    """A cylinder whose form is drawn from the field and fitted: the spread of its diameter is that of the closed form."""
    bore = Feature("bore", "cylinder", np.zeros(3), Z, np.array([15.0]), inside=True, extent=(20.0,))
    points, normals = plan_points(bore, Levels((5.0, 15.0), 5))
    reference = surface_grid(bore, 48)
    from vcmm.part.part import normal

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
