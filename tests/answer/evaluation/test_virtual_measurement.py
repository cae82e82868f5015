"""One virtual measurement, at the estimates or drawn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.build import scenario
from vcmm.answer.evaluation.virtual_measurement import measure_task
from vcmm.physics.catalogue.scale import ScaleFactor


def test_errors_at_their_estimates():
    # X too long by 20 um/m: on the 104 mm that the axis goes (100 mm and the diameter of the tip) it indicates 2.08 um too little
    out = measure_task(scenario(ScaleFactor("X", 20e-6)).task())
    values = {v.name: v for v in out.values}
    assert values["length"].value == pytest.approx(100.0 - 2.08e-3, abs=1e-8)
    assert values["length"].nominal == 100.0
    assert out.features.count("bore") == 16
    # at the right face the axis stands at 52 mm: 1.04 um too little, outwards
    assert out.errors[-4:] == pytest.approx([-1.04e-3] * 4, abs=1e-8)


@pytest.mark.thorough
def test_a_draw_is_repeatable_and_its_scatter_that_of_the_machine():
    task = scenario().task()
    one, again, other = (measure_task(task, seed) for seed in (1, 1, 2))
    assert np.array_equal(one.errors, again.errors)
    assert not np.array_equal(one.errors, other.errors)
    drawn = np.concatenate([measure_task(task, seed).errors for seed in range(40)])
    assert drawn.std() == pytest.approx(1e-3, rel=0.1)


def test_without_inputs_a_seed_changes_nothing():
    task = replace(scenario().task(), inputs=())
    assert np.array_equal(measure_task(task, 5).errors, measure_task(task).errors)
