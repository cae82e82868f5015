"""Tests of residuals: false-alarm rates on parts from outside, and what they must notice."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tests.answer.inference import outside
from vcmm.answer.evaluation.linear import prepare_model
from vcmm.answer.inference.doubts import outward
from vcmm.answer.inference.memory import RHOS, likelihood_ratio, whitening
from vcmm.answer.inference.points import task_and_rows
from vcmm.answer.inference.residual_tests import ALARM, ResidualTests, as_large
from vcmm.files.own.measured_data import read_measured_points
from vcmm.files.own.scenario import load_scenario
from vcmm.task.measuring.task import fit_features, measured_points


def alarms(
    folder: Path, kind: str, parts: list[np.ndarray], law: str = outside.NORMAL
) -> tuple[int, int, int]:
    """Parts with outliers, points named, parts whose noise is said to have memory."""
    scenario, points = folder / "scenario.toml", folder / "points.csv"
    scenario.write_text(outside.scenario(kind, law))
    points.write_text(
        outside.csv([r for i, p in enumerate(parts) for r in outside.rows(p, part=f"p{i}")], part=True)
    )
    loaded, tests, found = load_scenario(scenario), None, [0, 0, 0]
    for given in read_measured_points(points):
        task, rows = task_and_rows(loaded, given)
        touched = measured_points(task, task.machine.indication_error(task.touches.run))
        fitted = fit_features(task, touched)
        tests = tests or ResidualTests(prepare_model(task), 1)
        residuals = {"ring": outward(task, "ring", touched, fitted)}
        outliers = tests.outliers(residuals)
        memory = tests.memory(residuals, {"ring": np.argsort(rows, kind="stable")})
        found[0] += bool(outliers)
        found[1] += len(outliers)
        found[2] += memory is not None and memory.p <= ALARM
    return found[0], found[1], found[2]


def most(count: int, share: float = ALARM, p: float = 1e-3) -> int:
    """So many alarms are exceeded with probability p at most, where each part has one with probability `share` (binomial)."""
    tail, k = 1.0, 0
    while tail > p:
        tail -= math.comb(count, k) * share**k * (1 - share) ** (count - k)
        k += 1
    return k - 1


CASES: dict[str, tuple[str, int, int, Callable, Callable, str]] = {
    "perfect": (outside.RING, 48, 1, outside.perfect, outside.normal, outside.NORMAL),
    "three lobes, t with 3 degrees": (outside.RING, 24, 1, outside.lobed(3, 5e-3), outside.student3, outside.T3),
    "eight points, seven lobes": (outside.RING, 8, 1, outside.lobed(7, 0.01), outside.normal, outside.NORMAL),
    "barrel with lobes": (outside.BORE, 40, 4, outside.bowed, outside.normal, outside.NORMAL),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_false_alarms_of_correct_data(case: str, tmp_path: Path) -> None:
    """At most 1 % of the parts, as is said: of 40 parts at most 3 (P of more: about 0.4^4 / 24 e^-0.4 = 0.0007)."""
    kind, n, levels, form, noise, law = CASES[case]
    rng = np.random.default_rng(7)
    parts = [outside.bore(rng, n, levels, form, noise) for _ in range(40)]
    with_outliers, _, with_memory = alarms(tmp_path, kind, parts, law)
    assert most(40) == 3
    assert with_outliers <= most(40)
    assert with_memory <= most(40)


def test_a_speck_of_dust_is_named_on_lobes_too(tmp_path: Path) -> None:
    """15 um on one of 72 points: 15 of its standard deviations, under three lobes of 10 um, whose waves are told apart."""
    rng = np.random.default_rng(8)
    parts = [outside.bore(rng, 72, 4, outside.lobed(3, 0.01)) for _ in range(8)]
    for p in parts:
        p[30, :2] *= 1 - 0.015 / 15
    with_outliers, named, _ = alarms(tmp_path, outside.BORE, parts)
    assert with_outliers == 8
    assert named <= 9


def test_two_outliers_do_not_hide_one_another(tmp_path: Path) -> None:
    rng = np.random.default_rng(9)
    parts = [outside.bore(rng, 40, 1) for _ in range(5)]
    for p in parts:
        p[[3, 24], :2] *= 1 - 0.05 / 15
    with_outliers, named, _ = alarms(tmp_path, outside.RING, parts)
    assert with_outliers == 5
    assert named >= 10


@pytest.mark.thorough
def test_memory_of_the_noise_is_noticed(tmp_path: Path) -> None:
    """Correlation 0.95 of scatter that is stated per touch: a mean of 100 then scatters as one of 2.6."""
    rng = np.random.default_rng(10)
    parts = [outside.bore(rng, 200, 4, noise=outside.remembered(0.95)) for _ in range(8)]
    assert alarms(tmp_path, outside.BORE, parts)[2] >= 6


def test_likelihood_by_the_whole_covariance() -> None:
    """Against dense matrices: -2 ln L = (n - k) ln d'Pd + ln |R| + ln |Q'R^-1 Q|, P = R^-1 - R^-1 Q (Q'R^-1 Q)^-1 Q'R^-1."""
    rng = np.random.default_rng(11)
    n, rho = 9, 0.6
    q = np.linalg.qr(rng.normal(size=(n, 3)))[0]
    d = rng.normal(size=n)
    covariance = rho ** np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    back = np.linalg.inv(covariance)
    inner = q.T @ back @ q
    projected = back - back @ q @ np.linalg.inv(inner) @ q.T @ back
    one = whitening(q, rho)
    assert one.rest(d[None])[0] == pytest.approx(d @ projected @ d, rel=1e-12)
    logs = np.linalg.slogdet(covariance)[1] + np.linalg.slogdet(inner)[1]
    assert one.penalty == pytest.approx(logs, rel=1e-12)
    ratio, best = likelihood_ratio({"a": [whitening(q, r) for r in RHOS]}, {"a": d[None]})
    assert ratio[0] >= 0.0
    assert best[0] in RHOS


def test_form_takes_up_what_the_noise_lacks() -> None:
    """(3, 0) and a unit shape (0, 1): length 5 asks for 4 of it; where the noise is longer than 5 it stays alone."""
    drawn = as_large(np.array([[3.0, 0.0], [6.0, 0.0]]), np.array([[0.0, 2.0], [0.0, 2.0]]), 5.0)
    assert drawn == pytest.approx(np.array([[3.0, 4.0], [6.0, 0.0]]))


def test_long_scans_with_form_are_not_taken_for_memory(tmp_path: Path) -> None:
    """Forms are drawn for up to 3000 points; of 3200 with lobes of 3 um the order is not tested, the outlier is."""
    points = outside.bore(np.random.default_rng(13), 3200, form=outside.lobed(3, 3e-3))
    points[77, :2] *= 1 - 0.1 / 15
    assert alarms(tmp_path, outside.RING, [points]) == (1, 1, 0)


@pytest.mark.parametrize(
    ("score", "size", "p"),
    [(3.0, 0.35, 0.6), (3.5, -0.15, 0.8), (9.0, 9.0, 0.2), (0.0, 0.0, 1.0)],
)
def test_the_p_value_counts_the_part_itself(score: float, size: float, p: float) -> None:
    """Of 4 drawn parts, as many as score and size leave above, and the part: (1 + 2) / 5, (1 + 3) / 5, 1 / 5, 5 / 5."""
    nulls = np.array([[1.0, 2.0, 3.0, 4.0], [0.5, 0.6, 0.7, 0.8]]), np.array([0.1, 0.2, 0.3, 0.4])
    known = SimpleNamespace(nulls=nulls, draws=4, model=SimpleNamespace(influences=()))
    assert ResidualTests._p(known, score, size) == pytest.approx(p)  # type: ignore[arg-type]
