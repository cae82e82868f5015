"""Physics outside the catalogue: where, what shape, and a formula that predicts rows never fitted."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

from tests.learn.diagnosis import generator as make
from vcmm.learn.diagnosis.engine import diagnose_recording
from vcmm.learn.diagnosis.result import diagnosis_json
from vcmm.show.pages.diagnosis import diagnosis_page


@pytest.fixture(scope="module")
def region():
    case = make.make(("unknown_region",), 25.0, 5)
    return case, diagnose_recording(case.recording, make.machine(), 1, 500)


@pytest.mark.thorough
def test_a_soft_spot_is_placed_and_written_as_a_product(region):
    _, found = region
    assert found.unknown is not None
    assert {"X", "Y"} <= set(found.unknown.covariates)
    assert found.unknown.direction == "z"
    text = found.unknown.formula
    assert "exp" in text  # the generator's spot: exp(-((X - 320) / 60)^2 - ((Y - 260) / 70)^2) in z
    assert "X" in text
    assert "Y" in text
    assert found.unknown.gain > 10


@pytest.mark.thorough
def test_the_document_holds_shape_and_formula_and_calls_them_a_proposal(region):
    case, found = region
    body = diagnosis_json(found)
    assert body["unknown"]["status"] == "proposal, not physics"
    shape = body["unknown"]["shape"]
    assert len(shape["over"]) in (1, 2)
    json.dumps(body, allow_nan=False)
    page = diagnosis_page(case.recording, make.machine(), found)
    assert "a proposal, not physics" in page
    assert "Residuals in space" in page
    assert "Rms of the residual before" in page
    assert "depends on a covariate" in page


@pytest.mark.thorough
def test_a_rhythm_has_its_period_in_the_formula():
    found = diagnose_recording(make.make(("unknown_rhythm",), 15.0, 5).recording, make.machine(), 1, 500)
    assert found.unknown is not None
    (period,) = {float(p) for p in re.findall(r"time / ([\d.]+)", found.unknown.formula)}
    assert period == pytest.approx(1700.0, rel=0.03)
    shape = found.unknown.shape
    assert shape is not None
    assert np.isfinite(shape.value).all()
    assert (shape.u > 0).all()


@pytest.mark.thorough
def test_nothing_unknown_no_formula():
    assert diagnose_recording(make.make((), 0.0, 11).recording, make.machine(), 1, 500).unknown is None


@pytest.mark.thorough
def test_a_map_is_written_over_the_first_covariate_then_the_second(region):
    """The spot at X = 320, Y = 260 (generator) is the extreme of the map, indexed as `over` says."""
    shape = diagnosis_json(region[1])["unknown"]["shape"]
    value = np.array(shape["value_um"])
    first, second = (np.array(shape[name]) for name in shape["over"])
    assert value.shape == (len(first), len(second))
    i, j = np.unravel_index(np.argmax(np.abs(value)), value.shape)
    at = dict(zip(shape["over"], (first[i], second[j])))
    assert abs(at["X"] - 320) < 60
    assert abs(at["Y"] - 260) < 70
