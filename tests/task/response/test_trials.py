"""Exact trials: drawn numbers in the effects, transforms multiplied."""

from __future__ import annotations

import numpy as np
import pytest

from tests import build
from tests.task.response.test_influence import prepared
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.expansion import ScaleExpansion
from vcmm.physics.structure.tip import TipOffset
from vcmm.task.response.influence import influences
from vcmm.task.response.trials import Draws, exact_errors


def draws(machine, run, one: Input, departures) -> Draws:
    departures = np.array(departures, dtype=float)
    return Draws(influences(machine, run, [one])[0], departures, departures)


def test_a_drawn_parameter_is_put_into_its_effect():
    # k = 10 + 5 and 10 - 5 um/m at 200 and 400 mm: indicated - true = -3, -6 and -1, -2 um
    machine = build.machine(ScaleFactor("X", 10e-6))
    run = prepared(machine)
    one = draws(machine, run, Input("scale_factor", "X", "k", Normal(1e-6)), [[[5e-6]], [[-5e-6]]])
    out = exact_errors(machine, run, [one])
    assert out[:, :, 0] == pytest.approx(np.array([[-3e-3, -6e-3], [-1e-3, -2e-3]]))
    assert exact_errors(machine, run, [])[0, :, 0] == pytest.approx([-2e-3, -4e-3])
    assert one.head(1).departures.shape == (1, 1, 1)


def test_copies_act_on_their_rows():
    machine = build.machine(TipOffset("", np.zeros(3)))
    run = prepared(machine)
    offset = Input("tip_offset", "", "d", Normal(1e-3), "stylus")
    one = draws(machine, run, offset, [[[1e-3, 0.0, 0.0], [0.0, 2e-3, 0.0]]])
    assert exact_errors(machine, run, [one])[0] == pytest.approx(np.array([[1e-3, 0, 0], [0, 2e-3, 0]]))


def test_two_inputs_of_one_effect_multiply():
    # alpha + dalpha = 2e-5, reading 1 K wrong: 200 mm x 2e-5 x 1 = 4 um; the first order about alpha = 1e-5 says 2 um
    machine = build.machine(ScaleExpansion("X", 1e-5))
    run = prepared(machine, temp_scale_x_C=20.0, reading_scale_x_C=20.0)
    alpha = draws(machine, run, Input("scale_expansion", "X", "alpha", Normal(1e-6)), [[[1e-5]]])
    warm = draws(machine, run, Input("channel", "", "temp_scale_x_C", Normal(0.1)), [[[1.0]]])
    assert exact_errors(machine, run, [alpha, warm])[0, :, 0] == pytest.approx([-4e-3, -8e-3])


def test_an_effect_that_nobody_draws_stays():
    machine = build.machine(Backlash("X", 4e-3), ScaleFactor("X"))
    run = prepared(machine, sense_X=1.0)
    one = draws(machine, run, Input("scale_factor", "X", "k", Normal(1e-6)), [[[0.0]]])
    assert exact_errors(machine, run, [one])[0] == pytest.approx(machine.indication_error(run, exact=True))
