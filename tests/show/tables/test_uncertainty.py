"""The tables of an evaluation, from a result made by hand."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import pytest

from vcmm.answer.evaluation.result import BudgetLine, CharacteristicResult, TrueValue
from vcmm.answer.evaluation.truth import Additive
from vcmm.part.gps.decision import Decision
from vcmm.show.report.table import Cell
from vcmm.show.tables import uncertainty
from vcmm.show.tables.table import in_terminal, on_page

LINE = BudgetLine(
    input="scatter.value", what="scatter of the probe", distribution="t", dof=9.0, redraw="touch", estimate=None,
    u_input=3e-4, unit="um", sensitivity=0.5, u=1.5e-4, share=0.9, evidence="certificate",
)  # fmt: skip
REST = replace(LINE, input="part.alpha", dof=math.inf, sensitivity=None, u=1e-9, share=0.0)


def result(**changes):
    """30.0001 mm with U = 0.4 µm, u = 0.2 µm."""
    given = {
        "name": "bore", "type": "size", "unit": "mm", "nominal": 30.0, "value": 30.0001, "mean": 30.0001, "bias": 2e-5, "corrected": True,
        "u": 2e-4, "k": 2.0, "p": 0.95, "interval": (29.9997, 30.0005), "interval_kind": "symmetric", "coverage_shown": False,
        "extreme": False, "tolerance": (29.99, 30.01), "decision": None, "budget": (LINE, REST), "interaction_share": math.nan,
        "tier": "closed form", "trials": 0, "linear_error": 1.26e-7, "summary": None,
    }  # fmt: skip
    return CharacteristicResult(**{**given, **changes})


def found(*characteristics):
    return SimpleNamespace(characteristics=characteristics, trials=1000)


def test_results_in_the_terminal_and_on_the_page():
    table = uncertainty.results(found(result()))
    terminal, page = in_terminal(table), on_page(table)
    assert terminal.rows == [
        ["bore", "30.00000 mm", "30.00010 mm", "+0.02 µm", "0.40 µm", "2.00", "[-0.30, +0.50] µm", "–"]
    ]
    assert page.rows == [
        ["bore", "30.00000", "30.00010", "0.0200", "0.400", "−0.300 … 0.500", "−10.0 … 10.0", "–"]
    ]
    assert table.title.startswith("measured value y (bias corrected), U and coverage interval for p = 95%")
    assert "less its known bias." in table.page_caption


def test_a_decision_is_a_badge_on_the_page():
    c = result(decision=Decision("undecided", "guarded", 0.7, None))
    assert in_terminal(uncertainty.results(found(c))).rows[0][-1] == "undecided"
    assert on_page(uncertainty.results(found(c))).rows[0][-1] == Cell("undecided", kind="warning")
    assert uncertainty.characteristic_json(c)["p_conform"] == 0.7


def test_the_document_has_every_key_of_the_contract():
    document = uncertainty.uncertainty_json(found(result()))
    (c,) = document["characteristics"]
    assert document["trials"] == 1000
    assert set(c) == {
        "name", "type", "nominal_mm", "value_mm", "mean_mm", "bias_mm", "bias_corrected", "bias_in_U_mm", "u_mm", "U_mm", "k", "p",
        "interval_mm", "interval_kind", "coverage_shown", "tolerance_mm", "decision", "decision_rule", "p_conform",
        "budget", "interaction_share", "tier", "trials", "linear_error_mm", "true_value", "why_not_shown", "filter",
        "common_causes", "zone", "acceptance_limits_mm", "specific_risk", "global_risk",
    }  # fmt: skip
    assert c["true_value"] is None
    form = result(true_value=TrueValue(0.001, (0.0, 0.002), True, interval_u=(0.0, 1e-5)))
    assert uncertainty.characteristic_json(form)["true_value"] == {
        "estimate_mm": 0.001, "interval_mm": [0.0, 0.002], "interval_u_mm": [0.0, 1e-5], "coverage_claimed": True, "reason": None,
        "not_covered": [],
    }  # fmt: skip
    assert c["U_mm"] == pytest.approx(4e-4)
    assert c["budget"][0] == {
        "input": "scatter.value", "what": "scatter of the probe", "estimate": None, "u_input": 3e-4, "unit": "um",
        "distribution": "t", "dof": 9.0, "redraw": "touch", "sensitivity_mm_per_unit": 0.5, "u_mm": 1.5e-4, "share": 0.9,
        "evidence": "certificate",
    }  # fmt: skip
    assert c["budget"][1]["dof"] is None  # infinite


def test_angles_have_keys_of_their_own():
    c = uncertainty.characteristic_json(result(unit="rad"))
    assert "U_rad" in c
    assert "u_rad" in c["budget"][0]


def test_budget_lines_that_are_rounding_are_left_away():
    (row,) = in_terminal(uncertainty.budget_table([result()])).rows
    assert row == ["bore", "scatter.value", "t", "touch", "0.15 µm", "90.0 %"]


def test_the_budget_file_ends_with_the_combined_row():
    rows = list(csv.DictReader(io.StringIO(uncertainty.budget_csv(found(result())))))
    assert [r["input"] for r in rows] == ["scatter.value", "part.alpha", "combined"]
    assert rows[0]["u_i_um_or_urad"] == "0.15"
    assert rows[0]["sensitivity_um_or_urad_per_unit"] == "500"
    assert rows[1]["dof"] == ""
    assert rows[2]["what"] == "k = 2; U = 0.4; p = 0.95; y = 30.0001 mm; bias = 0.02"
    assert (rows[2]["u_i_um_or_urad"], rows[2]["share"], rows[2]["evidence"]) == ("0.2", "1", "closed form")


def test_how_it_was_computed():
    table = uncertainty.computation_table(
        found(result(), result(trials=20_000, coverage_shown=True, linear_error=math.nan))
    )
    assert in_terminal(table).rows == [
        ["bore", "closed form", "–", "0.13 nm"],
        ["bore", "closed form", "20,000", "not checked"],
    ]
    assert [row[-1] for row in on_page(table).rows] == [Cell("not demonstrated", kind="warning"), "yes"]


def test_the_largest_lines_come_first_and_stay_where_U_has_no_end():
    """A line of the form between the points is added last; U is infinite where the points bound nothing."""
    form = replace(LINE, input="form[top].between points", u=0.9e-4, share=0.24)
    endless = result(
        budget=(LINE, *[REST] * 5, form), extreme=True, half_width=2e-4, interval=(2e-4, math.inf)
    )
    told = in_terminal(uncertainty.budget_table([endless])).rows
    assert [row[1] for row in told] == ["scatter.value", "form[top].between points"]


def test_without_an_end_of_the_interval_no_expanded_uncertainty_is_stated():
    """u, and with it the budget, goes on saying what the machine adds."""
    endless = result(extreme=True, half_width=2e-4, interval=(0.0, math.inf))
    row = uncertainty.characteristic_json(endless)
    assert math.isnan(row["U_mm"])  # null in the document
    assert math.isnan(row["k"])
    assert row["u_mm"] == endless.u
    assert endless.expanded == 2e-4
    assert uncertainty.budget_total(endless).what.startswith("no U: the true value is not bounded; p = 0.95")
    assert result().stated == (result().expanded, result().k)


def test_shares_of_a_position_add_to_more_than_the_whole():
    # 2 hypot(x, y), both N(0, s): alone (2 s)^2 (1 - 2 / pi) = 0.36338, together (2 s)^2 (2 - pi / 2) = 0.42920 (Rayleigh):
    # 84.66 % each, 169.3 % together, so -69.3 % is what they do only together
    share = (1 - 2 / math.pi) / (2 - math.pi / 2)
    lines = (replace(LINE, share=share), replace(LINE, input="work_offset[y].shift", share=share))
    place = result(type="position", budget=lines, interaction_share=1 - 2 * share)
    (said,) = uncertainty.not_added_up([result(interaction_share=4e-4), place])
    assert said.startswith(
        "shares of u² that do not add to 100%: bore 169.3%; each line is the variance with that input alone"
    )
    assert "inputs together -0.6933 of u^2" in uncertainty.budget_total(place).what
    assert (
        uncertainty.not_added_up([replace(place, u=9e-7), result()]) == []
    )  # of next to nothing, and of a linear one


def test_the_true_value_of_a_size_is_freed_of_a_bias_that_is_not_corrected():
    """30.0001 mm with a bias of 0.02 um that U includes: 30.00008 mm; where the value is corrected already, it stays."""
    inside = uncertainty.true_value_by_points(result(truth=Additive(cast(Any, None), 30.0001, bias=2e-5)))
    assert inside is not None
    assert inside["estimate_mm"] == pytest.approx(30.00008, abs=1e-9)
    outside = uncertainty.true_value_by_points(result())
    assert outside is not None
    assert outside["estimate_mm"] == 30.0001
    assert outside["interval_mm"] == [29.9997, 30.0005]
