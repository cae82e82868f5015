"""The auditor's sheet: degrees of freedom by hand, words, and what stands on the page."""

from __future__ import annotations

import hashlib
import math
from pathlib import Path

import pytest

from tests.plate import edited
from vcmm.evaluation.result import BudgetLine
from vcmm.files.scenario import load_scenario
from vcmm.inference.given import GivenValue
from vcmm.inference.job import evaluate_values
from vcmm.pages.sheet import effective_dof, rounded, sheet_page


def line(u: float, dof: float) -> BudgetLine:
    return BudgetLine(
        input="i", what="", distribution="", dof=dof, redraw="", estimate=None, u_input=None, unit="", sensitivity=None,
        u=u, share=0.0, evidence="",
    )  # fmt: skip


def test_effective_degrees_of_freedom() -> None:
    """u_i = 3 with 9 and 4 with 16: u = 5, 625 / (81 / 9 + 256 / 16) = 25; without finite ones infinite."""
    assert effective_dof([line(3.0, 9.0), line(4.0, 16.0)], 5.0) == pytest.approx(25.0)
    assert math.isinf(effective_dof([line(3.0, math.inf)], 3.0))


def test_rounding_to_two_digits_of_the_uncertainty() -> None:
    assert rounded(30.0104712, 0.00086) == ("30.01047", "0.00086")
    assert rounded(1.23456, 0.123) == ("1.23", "0.12")


def test_what_stands_on_the_sheet(tmp_path: Path) -> None:
    record = '[record]\nby = "A. Person"\ndate = "2026-11-22"\nmachine_serial = "SN 12"\n[job]\n'
    path = edited(tmp_path, ("[job]\n", record), ('rule = "probability 95 %"', 'known_bias = "corrected"'))
    scenario = load_scenario(path)
    value = GivenValue("7", "bore diameter", 30.010, angle=False, deviation=False, where="values.csv:2")
    (part,) = evaluate_values(scenario, [[value]])
    html = sheet_page(scenario, part, [path])
    for words in (
        "A. Person",
        "2026-11-22",
        "SN 12",
        "part 7",
        "conforms",
        "effective degrees of freedom",
        "coverage probability of 95%",
    ):
        assert words in html
    assert hashlib.sha256(path.read_bytes()).hexdigest() in html
    low, high = part.characteristics[0].result.interval
    assert " mm ± ".join(rounded((low + high) / 2, (high - low) / 2)) in html
    assert html.count("break-after: page") == 1
