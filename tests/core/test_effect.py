"""The interface of effects: names, parameters, unit responses."""

from __future__ import annotations

import numpy as np
import pytest

from tests.core.test_machine import run_at
from vcmm.core.effect import (
    along,
    basis,
    motion,
    parameter,
    projected_basis,
    required,
    stepped_basis,
    with_parameter,
)
from vcmm.core.errors import UsageError
from vcmm.core.run import Run
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.scale import ScaleFactor


def test_names_and_places():
    one = Backlash("Y", 1e-3)
    assert (one.where, one.id, required(one)) == ("Y", "backlash[Y]", ("sense_Y",))


def test_a_parameter_by_its_name():
    assert parameter(Backlash("X"), "gap").name == "gap"
    with pytest.raises(UsageError, match=r'no parameter gapp. Did you mean "gap"'):
        parameter(Backlash("X"), "gapp")
    assert with_parameter(Backlash("X", 1.0), "gap", 3.0).gap == 3.0


def test_the_unit_response_is_that_of_one_unit():
    # a scale factor of 1 at X = 250 mm moves X by 250 mm, whatever the present number is
    run = run_at(250.0)
    unit = basis(ScaleFactor("X", 5e-6), "k", run)
    assert unit.shape == (1, 6, 1)
    assert unit[0, :, 0].tolist() == [250.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    assert np.array_equal(unit, stepped_basis(ScaleFactor("X"), "k", run))
    # seen with the weights (2, 0, 0, 0, 0, 0): 500
    assert projected_basis(ScaleFactor("X"), "k", run, np.array([[2.0, 0, 0, 0, 0, 0]])).tolist() == [[500.0]]


def test_motions_are_put_together():
    run = run_at(0.0)
    assert motion(run, Y=np.array([2.0]), C=np.array([3.0])).tolist() == [[0, 2, 0, 0, 0, 3]]
    assert along(run, np.array([0.0, 0.6, 0.8]), np.array([10.0])).tolist() == [[0, 6, 8, 0, 0, 0]]


def test_unit_steps_are_kept_apart_for_every_effect():
    # the same law on two axes: 250 mm along X and 40 mm along Y per unit of k, asked in turns
    run = Run({a: np.array([q]) for a, q in (("X", 250.0), ("Y", 40.0), ("Z", 0.0))}, np.zeros((1, 3)))
    x, y = ScaleFactor("X", 5e-6), ScaleFactor("Y", 5e-6)
    for _ in range(2):
        assert stepped_basis(x, "k", run)[0, :3, 0].tolist() == [250.0, 0.0, 0.0]
        assert stepped_basis(y, "k", run)[0, :3, 0].tolist() == [0.0, 40.0, 0.0]
