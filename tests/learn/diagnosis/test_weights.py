"""Weights and priors of diagnosis, by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from vcmm.learn.diagnosis.comparison import Comparison, Misfit
from vcmm.learn.diagnosis.evidence import Scorer
from vcmm.learn.diagnosis.select import _net_evidence


def test_the_weighted_rms_of_two_recordings():
    """3 with u = 1 and 4 with u = 2: weights 1 and 1/4, sqrt((9 + 16 / 4) / (5 / 4)) = sqrt(10.4); plain sqrt(12.5); chi2 9 + 4."""
    parts = [
        Misfit(name, None, np.array([r]), np.array([u]), 0, True, ())
        for name, r, u in (("a", 3.0, 1.0), ("b", 4.0, 2.0))
    ]
    both = Comparison("machine.toml", tuple(parts))
    assert both.weighted_rms == pytest.approx(math.sqrt(10.4), rel=1e-14)
    assert both.rms == pytest.approx(math.sqrt(12.5), rel=1e-14)
    assert both.noise == pytest.approx(math.sqrt(2.5), rel=1e-14)
    assert both.chi2 == pytest.approx(13.0, rel=1e-14)


def test_the_score_of_a_family_is_the_mean_over_its_options():
    """ln(1/4 e^0 + 3/4 e^1) for the first family of two options, ln(1 e^2) - 0.5 with its prior for the second."""
    found = SimpleNamespace(
        weight=np.log([0.25, 0.75, 1.0]), first=np.array([0, 2]), prior=np.array([0.0, -0.5])
    )
    scores = Scorer.families(SimpleNamespace(candidates=found), np.array([[0.0], [1.0], [2.0]]))  # type: ignore[arg-type]
    assert scores[:, 0] == pytest.approx([math.log(0.25 + 0.75 * math.e), 1.5], rel=1e-14)


def test_the_value_of_a_choice_counts_the_priors_of_family_and_option():
    """-3 and -2 of one term less 4 for each term, against the same columns without prior and threshold."""
    white, y = np.array([[1.0], [0.0], [0.0]]), np.array([2.0, 1.0, -1.0])

    def term(family: float, option: float) -> SimpleNamespace:
        return SimpleNamespace(
            white=white,
            width=1.0,
            family=SimpleNamespace(log_prior=family),
            option=SimpleNamespace(log_prior=option),
        )

    setting = SimpleNamespace(candidates=SimpleNamespace(dof=3), threshold=0.0)
    plain = _net_evidence([term(0.0, 0.0)], y, setting)  # type: ignore[list-item, arg-type]
    setting.threshold = 4.0
    assert _net_evidence([term(-3.0, -2.0)], y, setting) == pytest.approx(plain - 9.0, rel=1e-12)  # type: ignore[list-item, arg-type]
    assert _net_evidence([], y, setting) == 0.0  # type: ignore[arg-type]
