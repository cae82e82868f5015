"""The auditor's sheet: degrees of freedom by hand, words, and what stands on the page."""

from __future__ import annotations

import hashlib
import math
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.plate import edited
from vcmm.answer.evaluation.result import BudgetLine
from vcmm.answer.inference.given_points import GivenValue
from vcmm.answer.inference.job import evaluate_values
from vcmm.files.own.library import example
from vcmm.files.own.scenario import load_scenario
from vcmm.show.pages.sheet import (
    BLANK,
    effective_dof,
    in_words,
    round_to_uncertainty,
    sheet_page,
    shown_lines,
)


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
    assert round_to_uncertainty(30.0104712, 0.00086) == ("30.01047", "0.00086")
    assert round_to_uncertainty(1.23456, 0.123) == ("1.23", "0.12")


def test_what_stands_on_the_sheet(tmp_path: Path) -> None:
    record = '[record]\nby = "A. Person"\ndate = "2026-11-22"\nmachine_serial = "SN 12"\n[job]\n'
    file = edited(tmp_path, ("[job]\n", record), ('rule = "probability 95 %"', 'known_bias = "corrected"'))
    scenario = load_scenario(file)
    value = GivenValue("7", "bore diameter", 30.010, angle=False, deviation=False, where="values.csv:2")
    (part,) = evaluate_values(scenario, [[value]])
    html = sheet_page(scenario, part, [file])
    for words in (
        "A. Person",
        "2026-11-22",
        "SN 12",
        "part 7",
        "conforms",
        "ν_eff = ",
        "part: not corrected to 20 °C",
        "scales: corrected to 20 °C with 8 µm/(m K)",
        "certificate of the machine",
        BLANK,
        "approved by",
        "coverage probability of 95%",
    ):
        assert words in html
    assert hashlib.sha256(file.read_bytes()).hexdigest() in html
    low, high = part.characteristics[0].result.interval
    assert " mm ± ".join(round_to_uncertainty((low + high) / 2, (high - low) / 2)) in html
    assert html.count('class="sheet"') == 1


def test_lines_without_evidence_are_named(tmp_path: Path) -> None:
    """An input of the size of the scatter without evidence; what is under a thousandth of u^2 is not asked for."""
    input_ = '[[machine.inputs]]\neffect = "squareness"\npair = "C0Y"\nparameter = "angle"\nu = "90 urad"\n'
    old = '[[machine.inputs]]\neffect = "squareness"\npair = "C0Y"\nparameter = "angle"\nu = "1 urad"\n'
    scenario = load_scenario(edited(tmp_path, (old, input_)))
    given = GivenValue("", "bore to front", 40.0, angle=False, deviation=False, where="values.csv:2")
    (part,) = evaluate_values(replace(scenario, settings=replace(scenario.settings, trials=2000)), [[given]])
    shown = sheet_page(scenario, part, []).count("No evidence is stated for: squareness[C0Y].angle.")
    assert shown == int(part.characteristics[0].result.budget[0].input == "squareness[C0Y].angle") == 1


@pytest.mark.thorough
@pytest.mark.skipif(shutil.which("chromium") is None, reason="needs chromium")
def test_every_characteristic_has_one_printed_page(tmp_path: Path) -> None:
    """The answers, two characteristics with long budgets, one page each, and the page of files."""
    scenario = load_scenario(example("plate"))
    given = [
        GivenValue("", n, v, angle=False, deviation=False, where="values.csv:2")
        for n, v in (("bore diameter", 30.004), ("bore to front", 40.001))
    ]
    (part,) = evaluate_values(replace(scenario, settings=replace(scenario.settings, trials=2000)), [given])
    page, printed = tmp_path / "sheet.html", tmp_path / "sheet.pdf"
    page.write_text(sheet_page(scenario, part, [example("plate")]), encoding="utf-8")
    words = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"]
    done = subprocess.run(
        [*words, f"--user-data-dir={tmp_path / 'c'}", f"--print-to-pdf={printed}", page.as_uri()],
        capture_output=True, timeout=60, check=False,
    )  # fmt: skip
    if not printed.exists():
        pytest.skip(f"chromium does not run here: {done.stderr[-200:]!r}")
    assert len(re.findall(rb"/Type\s*/Page\b(?!s)", printed.read_bytes())) == 4


ANGLE = """[[part.characteristics]]
name = "front to top"
type = "angle"
between = ["front", "top"]
limits = ["-0.5 deg", "0.5 deg"]
[pose]
"""


def test_angles_stand_in_degrees_and_the_rule_as_the_standard_names_it(tmp_path: Path) -> None:
    """90 deg +- 0.5 deg: limits 89.5 to 90.5 deg; nothing is in rad or urad but the budget's own columns."""
    record = '[record]\nreference_sphere = "25 mm, SN 7; certificate 118"\n[job]\n'
    file = edited(tmp_path, ("[pose]\n", ANGLE), ("[job]\n", record))
    scenario = load_scenario(file)
    scenario = replace(scenario, settings=replace(scenario.settings, trials=2000))
    given = GivenValue(
        "", "front to top", math.radians(90.01), angle=True, deviation=False, where="values.csv:2"
    )
    (part,) = evaluate_values(scenario, [[given]])
    html = sheet_page(scenario, part, [])
    assert "limits 89.5 to 90.5 deg" in html
    assert "90.010000 deg" in html
    assert re.search(r"front to top = 90\.01\d* deg ± 0\.\d+ deg, coverage factor k = ", html)
    assert "ISO 14253-1:2017, its default: conformance and non-conformance" in html
    assert "25 mm, SN 7; certificate 118" in html
    assert " rad" not in in_words(part.characteristics[0])


def test_a_product_of_two_inputs_has_its_line(tmp_path: Path) -> None:
    """A part at 20 degC known to 0.5 K with alpha known to 1 um/(m K): alone neither moves a length, together
    40 mm x 1e-6 x 0.5 K = 0.02 um, on scales without errors (the distance of front and bore is 40 mm).
    """
    file = edited(tmp_path, ('u_temperature = { part = "0.1 K" }', 'u_temperature = { part = "0.5 K" }'))
    scenario = load_scenario(file)
    scenario = replace(scenario, settings=replace(scenario.settings, trials=2000))
    given = GivenValue("", "bore to front", 40.0, angle=False, deviation=False, where="values.csv:2")
    (part,) = evaluate_values(scenario, [[given]])
    (line,) = [b for b in part.characteristics[0].result.budget if " x " in b.input and "part" in b.input]
    assert line.u == pytest.approx(40.0 * 1e-6 * 0.5, rel=0.01)


def test_thermal_lines_are_shown_however_small() -> None:
    """Ten larger lines and two of temperatures: six rows, both among them."""
    names = [*(f"effect {i}" for i in range(10)), "environment.room", "part_expansion.alpha"]
    rows = [SimpleNamespace(line=replace(line(10.0 - i / 2, math.inf), input=n)) for i, n in enumerate(names)]
    shown, rest = shown_lines(rows)  # type: ignore[arg-type]
    assert [row.line.input for row in shown] == [*names[:4], *names[10:]]
    assert len(rest) == 6


def test_a_qualification_has_the_degrees_of_freedom_of_its_touches(tmp_path: Path) -> None:
    """Scatter t with 6 degrees of freedom: the tip that was qualified with it is known with as many, the sphere with all."""
    sphere = 'tip_diameter = "4 mm", qualification = { sphere_diameter = "25 mm", u_diameter = "0.1 um", form = "0.1 um" }'
    scenario = load_scenario(edited(tmp_path, ('tip_diameter = "4 mm"', sphere)))
    given = GivenValue("", "bore diameter", 30.01, angle=False, deviation=False, where="values.csv:2")
    (part,) = evaluate_values(replace(scenario, settings=replace(scenario.settings, trials=2000)), [[given]])
    by = {b.input.rpartition(" by ")[2]: b.dof for b in part.characteristics[0].result.budget}
    assert (by["repeatability"], by["sphere diameter"], by["scatter.value"]) == (6.0, math.inf, 6.0)
