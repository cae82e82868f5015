"""Budget lines: sensitivities, units and words by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.build import scenario
from vcmm.answer.evaluation.budget import budget_line, estimate, form_line, unit_of, words
from vcmm.answer.evaluation.linear import build
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal
from vcmm.part.part import Characteristic, Feature
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.component import ComponentTable
from vcmm.physics.structure.expansion import ScaleExpansion

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


def test_what_qualification_leaves_by_its_causes():
    """Scatter of 1 um: in the touches of the bore and in the qualification; the sphere apart, u(diameter) = 0.5 um.

    Diameter of 16 touches: 2 / sqrt(16) = 0.5 um; of the stylus: twice the radius of a sphere of 25 touches on a half
    (0.3277 um, so 0.6554 um); of the sphere: 0.5 um. u^2 = 0.25 + 0.4296 + 0.25 um^2.
    """
    from dataclasses import replace

    from vcmm.answer.evaluation.result import common_causes
    from vcmm.answer.evaluation.uncertainty import evaluate
    from vcmm.task.measuring.qualification import Qualification
    from vcmm.task.measuring.settings import Settings

    job = replace(scenario(), qualifications={"down": Qualification(25.0, 0.5e-3)})
    found = evaluate(job.task(), Settings(trials=1000, certify=0)).characteristics[0]
    u2 = 0.25 + 0.6554**2 + 0.25
    share = {line.input: line.share for line in found.budget}
    assert share["scatter.value"] == pytest.approx(0.25 / u2, rel=2e-3)
    assert share["stylus_qualification[down].d by repeatability"] == pytest.approx(0.6554**2 / u2, rel=2e-3)
    assert share["stylus_qualification[down].d by sphere diameter"] == pytest.approx(0.25 / u2, rel=2e-3)
    together, names = common_causes(found.budget)["repeatability"]
    assert together == pytest.approx(1 - 0.25 / u2, rel=2e-3)
    assert len(names) == 2


def test_forms_between_points_are_those_of_sampled_surfaces():
    """A surface of nominal points is what these points are: between them lies the form of the datums alone."""
    top = Feature("top", "plane", np.zeros(3), np.array([0.0, 0, 1]), np.zeros(0), extent=(80.0, 80.0))
    blade = Feature("blade", "mesh", np.zeros(3), np.zeros(3), np.zeros(0))
    c = Characteristic("c", "surface_profile", of=("blade",), datums=("top",))
    line = form_line(c, {"top": top, "blade": blade}, 0.3e-3, 1e-3)
    assert (line.input, line.what) == ("form[top].between points", "form of top between the points")
    assert line.share == pytest.approx(0.09)
    flat = Characteristic("f", "surface_profile", of=("top",))
    assert form_line(flat, {"top": top}, 0.3e-3, 1e-3).input == "form[top].between points"
