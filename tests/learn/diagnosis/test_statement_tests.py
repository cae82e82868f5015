"""Pulls of stated quantities, by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from vcmm.answer.evaluation.gaussian import whitener
from vcmm.learn.diagnosis.statement_tests import (
    _as_normal,
    calibration_pulls,
    contradiction_probability,
    pull_limit,
)


def problem(*stated, inputs=("a", "b")):
    m = len(stated[0][1])
    none = np.zeros((m, 0))
    return SimpleNamespace(
        stated=stated, calibration=np.concatenate([c for _, c in stated], axis=1),
        machine=SimpleNamespace(inputs=[SimpleNamespace(id=i) for i in inputs]), recording=SimpleNamespace(known=()),
        without_statements=lambda names: SimpleNamespace(whitener=lambda u, rho: whitener(u, none, none)),
    )  # fmt: skip


def test_a_pull_is_the_estimate_after_in_units_of_the_stated_uncertainty():
    """Four rows of u 1 that show the quantity, stated 0 +- 3, as 12: K = 3, z = K'y / (K'K + 1) = 144 / 37 = 3.89."""
    one = problem(("a", np.full((4, 1), 3.0)))
    (pull,) = calibration_pulls(one, np.full(4, 12.0), 1.0, np.ones(4), 0.0)
    assert (pull.input, pull.numbers) == ("a", 1)
    assert pull.pull == pytest.approx(144.0 / 37.0)
    assert (
        calibration_pulls(problem(("field", np.full((4, 1), 3.0))), np.full(4, 12.0), 1.0, np.ones(4), 0.0)
        == ()
    )


def test_many_numbers_have_one_pull():
    """A chi-square of its own mean is near the middle of the normal law, one of 30 at 10 degrees of freedom 3.1 above."""
    assert _as_normal(9.34, 10.0) == pytest.approx(0.0, abs=0.01)  # the median of chi-square, 10 degrees
    assert _as_normal(29.59, 10.0) == pytest.approx(3.09, abs=0.03)  # its 99.9 % point


def test_what_chance_says_against_a_statement():
    """p = 0.0027 of a pull of 3: -e p ln p = 0.0434, so 1 / 1.0434 = 0.958; asked of 100 pulls nothing is left to say."""
    assert contradiction_probability(3.0, 1) == pytest.approx(0.9584, abs=5e-4)
    assert contradiction_probability(3.0, 100) < 0.7
    assert contradiction_probability(-4.0, 3) == pytest.approx(contradiction_probability(4.0, 3))


def test_of_many_statements_the_largest_pull_is_allowed_more():
    """One pull beyond 3 has the chance 0.0027; of eight the largest is beyond 3.58 as often (0.0027 / 8 two-sided)."""
    assert pull_limit(1) == pytest.approx(3.0)
    assert pull_limit(8) == pytest.approx(3.5847, abs=1e-4)
