"""What physics allows: an air index beyond its law, a square below zero, an arm outside the machine."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from vcmm.core.declaration import ForDiagnosis
from vcmm.learn.diagnosis.answers import reason_impossible
from vcmm.learn.diagnosis.estimates import Estimate
from vcmm.physics.catalogue.laser import AirIndex, CosineError
from vcmm.physics.structure.expansion import ScaleExpansion

NO_OFFSET = np.zeros((4, 3))
MACHINE = SimpleNamespace(
    axes={
        "X": SimpleNamespace(travel=(0.0, 300.0), rotary=False),
        "Y": SimpleNamespace(travel=(-200.0, 200.0), rotary=False),
    }
)


def size(value: float, u: float, unit: str) -> Estimate:
    return Estimate(value, u, (value - 2 * u, value + 2 * u), unit)


def said(effect: object, offset: np.ndarray = NO_OFFSET, **found: Estimate) -> str:
    return reason_impossible(effect, found, MACHINE, offset)  # type: ignore[arg-type]


def test_an_air_index_is_corrected_not_at_all_twice_or_with_the_wrong_sign():
    assert "outside -1 to 2" in said(AirIndex(scale=-2.45), scale=size(-2.45, 0.3, "1"))
    assert said(AirIndex(scale=-2.45), scale=size(-2.45, 0.8, "1")) == ""  # -0.85 is within: it may be -1
    assert said(AirIndex(scale=1.0), scale=size(1.0, 0.1, "1")) == ""


def test_no_scale_expands_by_60_um_per_metre_and_kelvin():
    assert "35" in said(ScaleExpansion("X", alpha=60e-6), alpha=size(60, 5, "um/(m K)"))
    assert said(ScaleExpansion("X", alpha=11.5e-6), alpha=size(11.5, 0.5, "um/(m K)")) == ""


def test_a_beam_that_stands_askew_cannot_lengthen():
    assert "cannot be below zero" in said(CosineError(theta=1e-3, share=-2.0), theta=size(0.0, 0.1, "mrad"))
    assert said(CosineError(theta=1e-3, share=2.0), theta=size(1.4, 0.1, "mrad")) == ""


def test_an_arm_lies_within_travels_and_tool(monkeypatch):
    # travels 300 and 400 mm: diagonal 500 mm; a tool of 150 mm more
    monkeypatch.setattr("vcmm.learn.diagnosis.answers.parameter_fields", lambda _: ())
    abbe = SimpleNamespace(
        diagnosis=ForDiagnosis(size_name="arm"), about=SimpleNamespace(aliases={}), name="abbe_offset"
    )
    assert "outside the machine" in said(abbe, arm=size(700, 50, "mm"))
    assert said(abbe, np.tile([0.0, 0.0, -150.0], (4, 1)), arm=size(700, 50, "mm")) == ""
    assert said(abbe, arm=size(310, 20, "mm")) == ""
