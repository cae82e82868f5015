"""The search settles on the answer that is worth most of all rows, whatever it began with."""

from __future__ import annotations

from typing import cast

import numpy as np

from vcmm.diagnosis.candidates import Family, Option
from vcmm.diagnosis.evidence import dictionary
from vcmm.diagnosis.problem import Problem
from vcmm.diagnosis.refine import Refiner
from vcmm.diagnosis.search import named
from vcmm.diagnosis.select import Setting, cleaned, select
from vcmm.evaluation.gaussian import whitener

ROWS = 200
RNG = np.random.default_rng(3)
NOISE = RNG.standard_normal(ROWS)


def setting_of(observed, **names):
    """Rows of white noise 1 and names with their columns (m, k), nothing of them scanned."""
    white = whitener(np.ones(ROWS), np.zeros((ROWS, 0)), np.zeros((ROWS, 0)))
    families = [Family(n, {}, (_option(x),), 0.0) for n, x in names.items()]
    refine = Refiner(cast(Problem, None), white)  # with nothing to be scanned no problem is asked
    return Setting(dictionary(families, white), white, observed, 3.0, 3.5, refine)


def _option(x):
    return Option(None, x, np.ones(x.shape[1]), tuple(map(str, range(x.shape[1]))), 0.0)


def names_of(selection):
    return sorted(t.family.name for t in selection.terms)


def test_a_curve_that_explains_most_alone_does_not_hide_two_simple_names_that_explain_as_much():
    """Two signals of delta 10 and 8: together 82 nats. A curve of eight numbers that holds their sum is worth more than either
    alone, and neither adds anything beside it.
    """
    one, two = (x / np.linalg.norm(x) for x in RNG.standard_normal((2, ROWS)))
    true = 10.0 * one + 8.0 * two
    free = np.column_stack([true / np.linalg.norm(true), RNG.standard_normal((ROWS, 7)) / np.sqrt(ROWS)])
    setting = setting_of(true + NOISE, one=one[:, None], two=two[:, None], curve=free)
    assert names_of(select(setting)) == ["curve"]
    assert names_of(named(setting, None)[0]) == ["one", "two"]


def test_two_bad_readings_are_no_step():
    """Near the end two readings are 12 standard deviations off: a step of the last six rows takes them for its own."""
    rows = NOISE.copy()
    rows[[-2, -5]] += 12.0
    late = (np.arange(ROWS) >= ROWS - 6).astype(float)[:, None]
    setting = setting_of(rows, step_of_six=late)
    assert names_of(select(cleaned(setting))) == ["step_of_six"]
    assert names_of(named(setting, None)[0]) == []
    assert names_of(named(setting_of(NOISE + 5.0 * late[:, 0], step_of_six=late), None)[0]) == ["step_of_six"]
