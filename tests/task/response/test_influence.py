"""Influences: d(indicated - true) per unit of every Input, and products of two."""

from __future__ import annotations

import numpy as np
import pytest

from tests import build
from vcmm.core.errors import UsageError
from vcmm.core.inputs import Input
from vcmm.core.laws import MultivariateNormal, Normal
from vcmm.core.run import Run
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.expansion import ScaleExpansion
from vcmm.physics.structure.tip import TipOffset
from vcmm.task.response.carrier import shared_effects
from vcmm.task.response.influence import influences, products

ALPHA = Input("scale_expansion", "X", "alpha", Normal(1e-6))
WARM = Input("channel", "", "temp_scale_x_C", Normal(0.1))


def prepared(machine, x=200.0, **columns):
    n = 2
    run = Run(
        {"X": np.array([x, 2 * x]), "Y": np.zeros(n), "Z": np.zeros(n)},
        np.zeros((n, 3)),
        {k: np.full(n, v) for k, v in columns.items()},
        {"stylus": np.array(["a", "b"])},
    )
    return machine.prepare(run)


def test_a_scale_factor_by_hand():
    # at 200 and 400 mm one unit of k takes the tip 200 and 400 mm too far: indicated - true = -200, -400 along x
    machine = build.machine(ScaleFactor("X"))
    (one,) = influences(machine, prepared(machine), [Input("scale_factor", "X", "k", Normal(1e-6))])
    assert one.response[:, :, 0].tolist() == [[-200.0, 0.0, 0.0], [-400.0, 0.0, 0.0]]
    assert (one.copies, one.codes.tolist()) == (("machine",), [0, 0])


def test_copies_follow_the_label():
    machine = build.machine(TipOffset("", np.zeros(3)))
    (one,) = influences(machine, prepared(machine), [Input("tip_offset", "", "d", Normal(1e-3), "stylus")])
    assert (one.copies, one.codes.tolist()) == (("a", "b"), [0, 1])
    assert np.array_equal(one.response[0], np.eye(3))


def test_a_law_fits_its_parameter():
    machine = build.machine(TipOffset("", np.zeros(3)))
    law = MultivariateNormal(np.eye(2))
    with pytest.raises(UsageError, match="for 2 numbers, but the parameter has 3"):
        influences(machine, prepared(machine), [Input("tip_offset", "", "d", law)])


def test_a_column_moves_the_whole_machine():
    # a scale of 1e-5 /K that is 1 K warmer takes the tip 2 um too far at 200 mm: it indicates 2 um too little
    machine = build.machine(ScaleExpansion("X", 1e-5))
    run = prepared(machine, temp_scale_x_C=20.0, reading_scale_x_C=20.0)
    (one,) = influences(machine, run, [WARM])
    assert one.response[:, 0, 0] == pytest.approx([-2e-3, -4e-3])
    with pytest.raises(UsageError, match="not a column"):
        influences(
            machine, prepared(machine, temp_scale_x_C=20.0), [Input("channel", "", "temp_air_C", Normal(1.0))]
        )


def test_a_coefficient_and_its_temperature_meet():
    # d2 / dalpha dT = minus the length, GUM H.1
    machine = build.machine(ScaleExpansion("X", 1e-5))
    run = prepared(machine, temp_scale_x_C=23.0, reading_scale_x_C=20.0)
    (product,) = products(machine, run, influences(machine, run, [ALPHA, WARM]))
    assert (product.first, product.second) == (0, 1)
    assert product.response[:, 0] == pytest.approx([-200.0, -400.0])
    assert shared_effects(machine, WARM, WARM) == []


def test_what_does_not_meet_has_no_product():
    machine = build.machine(ScaleFactor("X"), Backlash("X", 0.0))
    run = prepared(machine, sense_X=1.0)
    inputs = [Input("scale_factor", "X", "k", Normal(1e-6)), Input("backlash", "X", "gap", Normal(1e-3))]
    assert products(machine, run, influences(machine, run, inputs)) == ()
