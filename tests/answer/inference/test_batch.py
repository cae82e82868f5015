"""A batch of parts shares what is drawn: the same numbers as part by part, and no part is drawn twice for the same reach."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vcmm.answer.evaluation import inversion
from vcmm.answer.evaluation.belts import LEVELS, Belt
from vcmm.answer.inference.given_points import GivenPoints
from vcmm.answer.inference.job import EvaluatedPart, evaluate_points
from vcmm.files.own.scenario import load_scenario

from .test_evaluate import ROUND

MORE = """[[part.characteristics]]
name = "position"
type = "position"
of = "ring"
zone = "0.1 mm"
material = "M"
[[part.characteristics]]
name = "diameter"
type = "size"
of = "ring"
limits = ["-0.1 mm", "0.1 mm"]
"""


@pytest.fixture(autouse=True)
def fewer_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(inversion, "PARTS", (2000, 2000))
    monkeypatch.setattr(inversion, "COUNT_TRIALS", (400, 400))


def batch(folder: Path) -> tuple[object, list[GivenPoints]]:
    """Three parts: as drawn, 20 um off its place, and with three lobes of 30 um."""
    file = folder / "ring.toml"
    file.write_text(ROUND.replace("[plan]\n", MORE + "[plan]\n"))
    scenario = load_scenario(file)
    angle = 2 * np.pi * np.arange(24) / 24
    out = []
    for name, off, lobes in (("a", 0.0, 0.0), ("b", 0.02, 0.0), ("c", 0.0, 0.03)):
        radius = 15.0 + lobes * np.cos(3 * angle)
        points = np.stack([off + radius * np.cos(angle), radius * np.sin(angle), 0 * angle], axis=1)
        out.append(GivenPoints(name, np.round(points, 6), tuple(f"p:{i}" for i in range(24)), ("ring",) * 24))
    return scenario, out


def numbers(part: EvaluatedPart) -> list[object]:
    return [(e.result.name, e.result.value, e.result.interval, e.result.u) for e in part.characteristics]


@pytest.mark.thorough
def test_a_batch_gives_the_numbers_of_its_parts_alone_and_draws_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenario, parts = batch(tmp_path)
    asked: list[tuple[object, ...]] = []
    draw = inversion.families

    def count(drawing, count, seed, **how):  # type: ignore[no-untyped-def]
        asked.append(
            (seed, how["most"], how["ratio"], tuple(c.name for c in drawing.measured.characteristics))
        )
        return draw(drawing, count, seed, **how)

    monkeypatch.setattr(inversion, "families", count)
    together = evaluate_points(scenario, parts)  # type: ignore[arg-type]
    for seed, most, ratio, _ in asked:  # of one seed and reach no characteristic is drawn for again
        same = [n for s, m, r, n in asked if (s, m, r) == (seed, most, ratio)]
        assert len(same) == 1 or len(set().union(*map(set, same))) == sum(map(len, same))
    # forms of 0, 6 and 20 times the noise are of no reach: once each, whatever the parts are like
    assert sum(ratio is not None for _, _, ratio, _ in asked) <= 3
    # the evaluation is about the touches of the first part: with it, each of the others has the numbers that it has in the batch
    for one, whole in zip(parts[1:], together[1:]):
        alone = evaluate_points(scenario, [parts[0], one])  # type: ignore[arg-type]
        assert numbers(alone[1]) == numbers(whole)


def test_quantiles_between_levels_are_those_of_a_straight_line() -> None:
    """Levels 0.10 and 0.125: departures 1 and 2 um there, so 0.11 is 1 + 0.4 um; below the first level the first, above the last the last."""
    departure = np.zeros((2, len(LEVELS)))
    at = int(np.flatnonzero(np.isclose(LEVELS, 0.10))[0])
    departure[:, at], departure[:, at + 1] = 1e-3, 2e-3
    belt = Belt(np.array([0.0, 1.0]), departure)
    assert belt.at(0.11) == pytest.approx([1.4e-3, 1.0014], abs=1e-12)
    level = 0.3333
    row = np.random.default_rng(1).normal(size=(1, len(LEVELS)))
    assert Belt(np.zeros(1), row).at(level)[0] == np.interp(level, LEVELS, row[0])
    assert Belt(np.zeros(1), row).at(0.001)[0] == row[0, 0]
    assert Belt(np.zeros(1), row).at(0.999)[0] == row[0, -1]
