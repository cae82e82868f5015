"""Verdicts of counted coverages, by hand."""

from __future__ import annotations

from dataclasses import replace

import pytest

from vcmm.answer.inference.audit import AuditResult
from vcmm.show.tables.audit import audit_json, verdict

ROW = AuditResult("f", "mm", "stated knowledge", 0.95, 0.925, 200, 0.001, True, 0.93, 0.97)


def test_a_count_has_an_error() -> None:
    """185 of 200 (92.5 %) at 93 %: half of all counts come out as low; 1700 of 2000 (85 %) never do."""
    assert verdict(ROW) == "within counting error"
    assert 0.40 < ROW.p_value < 0.50
    assert verdict(replace(ROW, attained=0.94)) == "inside"
    far = replace(ROW, attained=0.85, parts=2000)
    assert (verdict(far), far.outside) == ("outside", True)
    assert verdict(replace(far, claimed=False)) == "not claimed"


def test_the_exact_tail() -> None:
    """3 of 4 at a band from 0.9: P(X <= 3) = 1 - 0.9^4 = 0.3439; 4 of 4 at a band up to 0.5: 0.5^4 = 0.0625."""
    few = replace(ROW, attained=0.75, parts=4, least=0.9, most=0.95)
    assert few.p_value == pytest.approx(0.3439, abs=1e-12)
    many = replace(ROW, attained=1.0, parts=4, least=0.1, most=0.5)
    assert many.p_value == pytest.approx(0.0625, abs=1e-12)
    assert audit_json([many])["audit"][0]["p_value"] == pytest.approx(0.0625)
