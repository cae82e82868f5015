"""Budget lines: sensitivities, units and words by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.build import scenario
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal
from vcmm.effects.component import ComponentTable
from vcmm.effects.expansion import ScaleExpansion
from vcmm.effects.scale import ScaleFactor
from vcmm.evaluation.budget import budget_line, estimate, unit_of, words
from vcmm.evaluation.linear import build

K = Input("scale_factor", "X", "k", Normal(2e-6), evidence="laser")
WARM = Input("channel", "", "temp_scale_x_C", Normal(0.1))


def test_a_scale_factor_in_its_own_unit():
    # 104 mm per unit of k (100 mm and the diameter of the tip): 0.104 um of length per um/m
    model = build(replace(scenario(ScaleFactor("X", 5e-6)), inputs=(K,)).task())
    term = replace(model.terms()[1], gain=(model.gradient()[1] @ model.terms()[1].gain)[None])
    line = budget_line(model.world, model.influences[1], term, 0.2e-3, 0.4e-3, True)
    assert (line.unit, line.estimate, line.u_input) == ("um/m", pytest.approx(5.0), pytest.approx(2.0))
    assert line.sensitivity == pytest.approx(-1.04e-4)  # mm per um/m
    assert line.share == pytest.approx(0.25)
    assert (line.evidence, line.distribution) == ("laser", "normal")
    assert budget_line(model.world, model.influences[1], term, 0.2e-3, 0.4e-3, False).sensitivity is None


def test_words_and_units():
    travel = np.array([-1e3, 1e3])
    effects = (ScaleExpansion("X", 1e-5), ComponentTable("EAX", ("X",), (travel,), np.zeros(2)))
    constants = {"temp_scale_x_C": 21.5, "reading_scale_x_C": 20.0}
    world = build(replace(scenario(*effects, constants=constants), inputs=(WARM,)).task()).world
    assert (unit_of(world, WARM), words(world, WARM)) == ("degC", "temperature scale x, true minus reading")
    assert estimate(world, WARM) == 21.5
    table = Input("component_table", "EAX", "values", Normal(1e-6))
    assert unit_of(world, table) == "urad"
    assert estimate(world, table) is None  # an array
    assert words(world, table).startswith("component table EAX: ")
