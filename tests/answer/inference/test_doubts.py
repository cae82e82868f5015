"""What points say against their own evaluation, from the user's chair: dust, digits, and how far the ends are known."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.answer.inference import outside
from vcmm.answer.evaluation import inversion
from vcmm.answer.evaluation.belts import Inverse
from vcmm.answer.evaluation.ends import jackknife_u
from vcmm.answer.evaluation.montecarlo import Summary
from vcmm.answer.evaluation.summary import summarise
from vcmm.face.cli import run


@pytest.fixture(autouse=True)
def fewer_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(inversion, "PARTS", (6000, 6000))
    monkeypatch.setattr(inversion, "COUNT_TRIALS", (800, 800))


def evaluated(
    capsys: pytest.CaptureFixture[str],
    folder: Path,
    text: str,
    lines: list[str],
    *words: str,
    unit: str = "mm",
) -> dict:
    """The document of an evaluation of points."""
    (folder / "s.toml").write_text(text)
    (folder / "p.csv").write_text(outside.csv(lines).replace("_mm", f"_{unit}"))
    run(["evaluate", str(folder / "s.toml"), "--points", str(folder / "p.csv"), "--json", *words])
    out, err = capsys.readouterr()
    assert out, err
    return json.loads(out)


def by_name(found: dict) -> dict[str, dict]:
    return {c["name"]: c for c in found["characteristics"]}


@pytest.mark.thorough
def test_dust_is_named_and_costs_the_claim(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Row 30 of 72 stands on line 32, under the heading; 15 um towards the axis is outside the material of a bore."""
    points = outside.bore(np.random.default_rng(5), 72, 4)
    points[30, :2] *= 1 - 0.015 / 15
    text = outside.scenario(outside.BORE, form=True)
    found = evaluated(capsys, tmp_path, text, outside.rows(points))
    (said,) = [w for w in found["warning_texts"] if "other points say" in w]
    assert "p.csv:32:" in said
    assert "outside" in said
    size = float(said.split(" lies ")[1].split(" um")[0])
    assert size == pytest.approx(15.0, abs=4.0)  # 4 standard deviations of the touch
    for c in found["characteristics"]:
        assert not c["coverage_shown"]
        assert c["decision"] == "undecided"
        assert "line 32" in c["why_not_shown"]
    dealt_with = evaluated(capsys, tmp_path, text, outside.rows(np.delete(points, 30, axis=0)))
    assert not [w for w in dealt_with["warning_texts"] if "other points say" in w]
    assert by_name(dealt_with)["diameter"]["coverage_shown"]


@pytest.mark.thorough
def test_digits_have_a_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """100 points in steps of 1 um: each rounding has u = 1 / sqrt(12) = 0.2887 um, the diameter twice that over sqrt(100)."""
    points = outside.bore(np.random.default_rng(6), 100)
    found = by_name(evaluated(capsys, tmp_path, outside.scenario(), outside.rows(points, digits=3)))[
        "diameter"
    ]
    (line,) = [b for b in found["budget"] if b["input"] == "resolution.value"]
    assert line["distribution"] == "uniform"
    assert line["u_mm"] == pytest.approx(2 * 2.887e-4 / 10, rel=1e-3)
    assert found["coverage_shown"]
    assert not [b for b in by_name(evaluated(capsys, tmp_path, outside.scenario(), outside.rows(points)))["diameter"]["budget"] if "resolution" in b["input"]]  # fmt: skip


@pytest.mark.thorough
def test_coarse_digits_lead_and_nothing_is_claimed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Steps of 10 um beside a scatter of 1 um: u^2 of the digits 8.33 um^2 of 9.33, 89 %."""
    points = outside.bore(np.random.default_rng(6), 100)
    found = evaluated(capsys, tmp_path, outside.scenario(), outside.rows(points, digits=2))
    assert [w for w in found["warning_texts"] if "largest line of its budget, 89% of u squared" in w]
    assert "coarser than the scatter" in found["characteristics"][0]["why_not_shown"]
    assert not found["characteristics"][0]["coverage_shown"]


@pytest.mark.thorough
def test_inches_have_their_own_step(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The fourth digit of an inch is 2.54 um: u = 2.54 / sqrt(12) = 0.7332 um of a touch."""
    points = outside.bore(np.random.default_rng(6), 100) / 25.4
    lines = outside.rows(points, digits=4)
    found = evaluated(capsys, tmp_path, outside.scenario(), lines, unit="in")["characteristics"][0]
    (line,) = [b for b in found["budget"] if b["input"] == "resolution.value"]
    assert line["u_mm"] == pytest.approx(2 * 7.332e-4 / 10, rel=1e-3)


Change = Callable[[np.ndarray], tuple[str, list[str], tuple[str, ...], str]]
CHANGES: dict[str, Change] = {
    "order of the points": lambda p: (
        outside.scenario(form=True),
        outside.rows(np.roll(p[::-1], 7, axis=0)),
        (),
        "mm",
    ),
    "name of the feature": lambda p: (
        outside.scenario(form=True, name="bohrung"),
        outside.rows(p, "bohrung"),
        (),
        "mm",
    ),
    "seed": lambda p: (outside.scenario(form=True), outside.rows(p), ("--seed", "17"), "mm"),
    "unit": lambda p: (outside.scenario(form=True), outside.rows(p / 25.4, digits=9), (), "in"),
}


@pytest.mark.thorough
@pytest.mark.parametrize("change", CHANGES)
def test_ends_move_by_what_their_u_covers(
    change: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Names, order, seed and unit say nothing of the part: ends differ by at most 4 standard uncertainties of the difference.

    u is taken from ten groups: t with 9 degrees of freedom, beyond 4 in 0.3 % of cases.
    """
    points = outside.bore(np.random.default_rng(12), 24, form=outside.lobed(3, 4e-3))
    text, lines = outside.scenario(form=True), outside.rows(points)
    monkeypatch.setattr(
        inversion, "PARTS", (12_000, 12_000)
    )  # of 6000 the upper end is known to a third of the length, as it says
    first = by_name(evaluated(capsys, tmp_path, text, lines))["form"]["true_value"]
    text, lines, words, unit = CHANGES[change](points)
    other = by_name(evaluated(capsys, tmp_path, text, lines, *words, unit=unit))["form"]["true_value"]
    for end in (0, 1):
        u = np.hypot(first["interval_u_mm"][end], other["interval_u_mm"][end])
        assert 0.0 < u < 0.3 * (first["interval_mm"][1] - first["interval_mm"][0])
        assert abs(first["interval_mm"][end] - other["interval_mm"][end]) <= 4.0 * u


def test_jackknife_of_a_mean() -> None:
    """Means without one of 1, 2, 3, 6: 11/3, 10/3, 3, 2; u = sqrt(3/4 sum (x - 3)^2) = sqrt(3/4 (4/9 + 1/9 + 0 + 1)) = s / 2."""
    values = np.array([[11 / 3], [10 / 3], [3.0], [2.0]])
    assert jackknife_u(values)[0] == pytest.approx(np.sqrt(0.75 * 14 / 9), rel=1e-12)
    assert jackknife_u(values)[0] == pytest.approx(np.std([1, 2, 3, 6], ddof=1) / 2, rel=1e-12)


def test_ends_of_a_sample() -> None:
    """Quantile of M uniform trials: sqrt(p (1 - p) / M) over the density 1: sqrt(0.025 x 0.975 / 10^4) = 0.00156."""
    found: Summary = summarise((np.arange(10_000) + 0.5) / 10_000)
    assert found.ends_u(0.95) == pytest.approx((0.00156, 0.00156), rel=0.01)


def test_no_groups_no_uncertainty() -> None:
    from vcmm.answer.evaluation.ends import ends_u

    groups: tuple[Inverse, ...] = ()
    assert ends_u(groups, 0.95, np.zeros(1), None) is None
