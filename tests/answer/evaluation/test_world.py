"""The world of a measuring task: one machine, one run."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import SCATTER, scenario
from vcmm.answer.evaluation.exact import draw_inputs
from vcmm.answer.evaluation.linear import build
from vcmm.answer.evaluation.world import Measuring
from vcmm.physics.catalogue.scale import ScaleFactor


def test_errors_of_first_order_and_exact():
    task = scenario(ScaleFactor("X", 20e-6)).task()
    world = Measuring(task)
    x = task.touches.run.q("X")
    assert world.errors()[:, 0] == pytest.approx(-20e-6 * x)
    exact = world.exact_errors(draw_inputs(build(task), 0, 0, 3))
    assert exact.shape == (3, 24, 3)
    assert not world.predicts


def test_influences_and_their_machine():
    task = scenario().task()
    world = Measuring(task)
    (scatter,) = world.influences()
    assert scatter.input is SCATTER
    assert len(scatter.copies) == 24
    assert world.products([scatter]) == ()
    assert world.machine_of(SCATTER) == (task.machine, task.touches.run)
    # one unit of scatter moves each touch by one along its normal
    along = np.einsum("nik,ni->nk", scatter.response, task.touches.run.normal)
    assert np.abs(along) == pytest.approx(np.ones((24, 1)))
