"""Zones, limits for readings and risks of a result, by hand."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.build import DIAMETER, scenario
from tests.plate import edited
from vcmm.answer.evaluation.indication import at_indication
from vcmm.answer.evaluation.judgement import decision_risk, production_risk, reading_limits, zone_of
from vcmm.answer.evaluation.uncertainty import evaluate
from vcmm.core.errors import DataError
from vcmm.files.own.scenario import load_scenario
from vcmm.part.gps import risk
from vcmm.task.measuring.settings import Settings


def bore(rule="probability 95 %"):
    """u = 0.5 um, U = 0.98 um, limits +-2 um; the process makes +0.3 um with 0.8 um."""
    settings = Settings(trials=1000, certify=0, rule=rule, production={"diameter": (0.3e-3, 0.8e-3)})
    job = scenario(characteristics=(replace(DIAMETER, limits=(-2e-3, 2e-3)),))
    return evaluate(job.task(), settings).characteristics[0]


def test_zones_and_limits_for_readings():
    c = bore()
    zones = [zone_of(at_indication(c, 30 + x * 1e-3, "probability 95 %")) for x in (0.0, 1.5, 2.5, 3.5)]
    assert zones == [risk.IN_ACCEPT, risk.IN_UNCERTAIN, risk.OUT_UNCERTAIN, risk.OUT_REJECT]
    # 1.645 u = 0.8224 um inside the limits; by the guard band U = 0.98 um
    assert reading_limits(c) == pytest.approx((30 - 1.17757e-3, 30 + 1.17757e-3), abs=1e-8)
    assert reading_limits(bore("guard band U")) == pytest.approx((30 - 1.02002e-3, 30 + 1.02002e-3), abs=1e-7)
    assert zone_of(replace(c, coverage_shown=False)) is None


def test_risk_of_the_decision_and_of_the_production():
    c = bore()
    assert decision_risk(c) == pytest.approx(6.334e-5, rel=1e-3)  # 4 u to either limit: 2 x 3.167e-5
    assert decision_risk(at_indication(c, 30 + 2e-3, "probability 95 %")) is None  # undecided
    found = production_risk(c)
    independent = risk.global_risk((-2e-3, 2e-3), 0.5e-3, 0.82243e-3, risk.Production(0.3e-3, 0.8e-3))
    assert found.consumer == pytest.approx(independent.consumer, rel=1e-3)
    assert found.producer == pytest.approx(independent.producer, rel=1e-3)
    assert production_risk(replace(c, production=None)) is None  # no process stated, no risk told


def test_production_in_a_file(tmp_path):
    job = 'rule = "probability 95 %"\n'
    path = edited(tmp_path, (job, job + 'production = { "bore diameter" = { mean = "1 um", u = "3 um" } }\n'))
    assert load_scenario(path).settings.production == {"bore diameter": pytest.approx((1e-3, 3e-3))}
    path = edited(tmp_path, (job, job + 'production = { "bore diametre" = { u = "3 um" } }\n'))
    with pytest.raises(DataError, match=r'no characteristic "bore diametre"\. Did you mean "bore diameter"'):
        load_scenario(path)
