"""Blocks of the report: the histogram made coarse, the closing rows of a budget, which pictures a result has."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.show.tables.test_uncertainty import LINE, result
from vcmm.answer.evaluation.uncertainty import warnings_of
from vcmm.part.gps.decision import no_decision
from vcmm.show.charts.distribution import coarsen
from vcmm.show.pages.uncertainty import budget_table, characteristic_blocks


def test_a_fine_histogram_in_few_bars():
    """1000 counts in each of 161 cells, of which the last is beyond all but 0.05 %: 80 bars of two cells."""
    counts = np.zeros(400, dtype=int)
    counts[100:261] = 1000
    edges, coarse = coarsen(np.arange(401.0), counts)
    assert np.diff(edges).tolist() == [2.0] * 80
    assert coarse.tolist() == [2000] * 80
    assert edges[0] == 100.0


def test_a_budget_says_what_it_leaves_away_and_what_inputs_do_together():
    page = budget_table(result(interaction_share=0.0123))
    assert "1 further, each below 0.05 %" in page
    assert "interaction" in page
    assert "1.2%" in page
    assert "u = 0.200 µm, k = 2.00, U = 0.400 µm (p = 95%)" in page
    assert "c / (µm/unit)" in page
    assert "∞" not in page  # the line with infinite degrees of freedom is among those left away


def test_without_a_decision_there_are_no_zones():
    blocks = "".join(characteristic_blocks(result()))
    assert "Budget: contributions u_i" in blocks
    assert "ISO 14253-1" not in blocks
    assert "Distribution of the measured value" not in blocks
    none = replace(LINE, u=0.0)
    assert "Budget: contributions" not in "".join(characteristic_blocks(result(budget=(none,))))


def test_where_nothing_is_decided_the_picture_says_why_and_claims_no_zone_without_an_end():
    """value 30.0001, U 0.4 um within +-10 um: the picture may speak of a zone only where U is stated."""
    why = no_decision("probability 95 %", "the points bound nothing")
    known = result(tolerance=(29.99, 30.01), decision=why)
    assert "undecided: the points bound nothing" in "".join(characteristic_blocks(known))
    assert "lies in the conformance zone" in "".join(characteristic_blocks(known))
    endless = replace(known, extreme=True, half_width=4e-4, interval=(29.9, math.inf))
    page = "".join(characteristic_blocks(endless))
    assert "The result is not available." in page
    assert "conformance zone." not in page


@pytest.mark.parametrize(("bias", "told"), [(1e-3, "indicated value corrected by -1 um"), (-1e-3, "indicated value corrected by +1 um")])  # fmt: skip
def test_what_an_interval_takes_off_or_adds_is_said_without_a_sign(bias: float, told: str):
    assert told in "".join(warnings_of(replace(result(), extreme=True, bias=bias, why_not_shown="")))
