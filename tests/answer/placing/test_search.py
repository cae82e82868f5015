"""The search over the boxes of a fixture on problems with a known answer or a dense reference."""

from __future__ import annotations

import re
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import qmc

from tests.answer.placing.cases import plate
from tests.answer.placing.drawn import problem
from vcmm.answer.placing.fixture_boxes import boxes
from vcmm.answer.placing.hindrances import Hindrance
from vcmm.answer.placing.rows import Rows
from vcmm.answer.placing.search import (
    CountedObjective,
    SearchOutcome,
    _compass,
    _forward,
    differences,
    polished_from,
    search,
)
from vcmm.answer.placing.travels import Travels
from vcmm.core.errors import ModelLimit
from vcmm.task.measuring.fixture import Fixture, Freedom, six_of


class Bowl:
    """Two bowls in x and y: the lower at (420, 130), value 1."""

    unit = "mm"

    def values(self, poses):
        x, y = poses[:, 0], poses[:, 1]
        low = 1.0 + 1e-5 * ((x - 420) ** 2 + (y - 130) ** 2)
        return np.minimum(low, 1.02 + 1e-6 * ((x - 120) ** 2 + (y - 400) ** 2))


def found_boxes(scenario, *freedoms):
    ends = [Freedom(n, -np.inf, np.inf) for n in ("x", "y")]
    return boxes(Fixture((*ends, *freedoms)), six_of(scenario.pose), Travels(Rows.of(scenario)))


def test_the_lower_of_two_bowls(tmp_path):
    found = search(Bowl(), found_boxes(plate(tmp_path)), evaluations=2000)
    assert found.pose[:2] == pytest.approx([420, 130], abs=0.05)
    assert found.value == pytest.approx(1.0, abs=1e-6)
    assert found.evaluations <= 2000


def test_an_optimum_at_the_end_of_the_travel(tmp_path):
    """Uphill in +x: the lowest value is where an axis stands at its end."""
    slope = SimpleNamespace(unit="mm", values=lambda p: 1 + 1e-3 * (p[:, 0] + p[:, 1]))
    scenario = plate(tmp_path)
    found = search(slope, found_boxes(scenario), evaluations=1500)
    at = Rows.of(scenario).axis_positions(found.pose[None])[0]
    assert at[:, 0].min() == pytest.approx(0.0, abs=1e-6)
    assert at[:, 1].min() == pytest.approx(0.0, abs=1e-6)


def test_a_constraint_of_another_kind_is_kept(tmp_path):
    """Poses with x > 350 are forbidden; the lower bowl is out, its slope at the border is not."""

    class West:
        def problems(self, pose):
            return [Hindrance("wall", "a wall", "x", 1.0, "a wall")] if pose.shift[0] > 350 else []

        def feasible(self, poses):
            return poses[:, 0] <= 350

    scenario = plate(tmp_path)
    box = boxes(
        Fixture((Freedom("x", 0, 600), Freedom("y", 0, 500))),
        six_of(scenario.pose),
        Travels(Rows.of(scenario)),
        (West(),),
    )
    found = search(Bowl(), box, evaluations=3000)
    assert found.pose[0] <= 350
    dense, ok = box[0].poses(qmc.Sobol(2, seed=1).random(16384))
    assert found.value <= Bowl().values(dense[ok]).min() * 1.0001


@pytest.mark.thorough
@pytest.mark.parametrize("seed", [2, 3])
def test_drawn_problems_against_a_dense_scan(seed):
    """A small version of tools/place_statistics.py: 3000 evaluations against a scan of 4096."""
    one = problem(seed)
    found = search(one.objective, one.boxes, evaluations=3000, seed=seed)
    assert found.evaluations <= 3000
    for box in one.boxes:
        ask = CountedObjective(box, one.objective)
        best = min(ask(part).min() for part in np.array_split(qmc.Sobol(box.d, seed=9).random_base2(12), 4))
        assert found.value <= best * 1.001


def test_a_range_moved_as_advised_can_be_searched(tmp_path):
    """The smallest move opens one pose, at one end of the turns; the message also names one that leaves a range."""
    scenario = plate(tmp_path)

    def moved(by: float):
        fixture = Fixture((Freedom("x", 590.0 - by, 600.0), Freedom("turn_z", 0.0, 0.1)))
        return boxes(fixture, six_of(scenario.pose), Travels(Rows.of(scenario)))

    with pytest.raises(ModelLimit) as error:
        moved(0.0)
    least, enough = (float(v) for v in re.findall(r"by ([\d.]+) mm to", str(error.value)))
    assert least == pytest.approx(26.0)  # the travels end at 564 mm: 590 - 564
    one, many = moved(least), moved(enough)
    unit = np.random.default_rng(1).random((400, 2))
    assert one[0].poses(unit)[1].mean() == 0.0
    assert many[0].poses(unit)[1].mean() > 0.4
    with pytest.raises(ModelLimit, match="too narrow to be found") as narrow:
        search(SimpleNamespace(unit="mm", values=lambda p: p[:, 0]), one, evaluations=100)
    assert "known" not in str(narrow.value)  # nothing about tables, of which there are none
    nowhere = SimpleNamespace(unit="mm", values=lambda p: np.full(len(p), np.inf))
    with pytest.raises(ModelLimit, match="can be reached, but each of them lies where an error"):
        search(nowhere, many, evaluations=100)


def test_differences_by_hand():
    """x^2 + 3 y at (0.5, 1): slopes 1 and 3, the second one-sided at the face."""

    def ask(at):
        return at[:, 0] ** 2 + 3 * at[:, 1]

    for made in (differences, _forward):
        value, slope = made(ask, np.array([0.5, 1.0]))
        assert value == pytest.approx(3.25)
        assert slope == pytest.approx([1.0, 3.0], abs=2e-4)

    def walled(at):
        return np.where(at[:, 0] > 0.5, np.inf, ask(at))

    assert differences(walled, np.array([0.5, 1.0]))[1] == pytest.approx([0.0, 3.0])


def test_the_best_lie_apart(tmp_path):
    ask = CountedObjective(found_boxes(plate(tmp_path))[0], Bowl())
    ask.history.append(
        (np.array([[0.5, 0.5], [0.52, 0.5], [0.9, 0.5], [0.1, 0.1]]), np.array([1.0, 1.1, 2.0, np.inf]))
    )
    assert [(v, u.tolist()) for v, u in ask.best(9)] == [(1.0, [0.5, 0.5]), (2.0, [0.9, 0.5])]
    assert len(ask.best(1)) == 1


def test_the_compass_ends_at_a_kink(tmp_path):
    """|x - a| + |y - b| has no gradient where it is least; the steps are halved down to 1e-5 of the range."""
    kink = SimpleNamespace(unit="", values=lambda p: np.abs(p[:, 0] - 301.7) + np.abs(p[:, 1] - 222.2))
    ask = CountedObjective(found_boxes(plate(tmp_path))[0], kink)
    start = np.array([0.5, 0.5])
    value, unit = _compass(ask, start, float(ask(start[None])[0]), 2000)
    assert value < 0.02  # 1e-5 of some 500 mm, twice
    assert ask.box.poses(unit[None])[0][0, :2] == pytest.approx([301.7, 222.2], abs=0.01)


def test_going_on_from_a_better_start(tmp_path):
    box = found_boxes(plate(tmp_path))[0]
    before = SearchOutcome(box, np.zeros(2), np.zeros(6), 1.02, 100, ())
    better = polished_from(Bowl(), box, box.unit(np.array([[400.0, 150, -300, 0, 0, 0.0]]))[0], before)
    assert better.value == pytest.approx(1.0, abs=1e-6)
    assert 100 < better.evaluations <= 1101
    worse = polished_from(
        Bowl(), box, np.array([0.9, 0.9]), SearchOutcome(box, np.zeros(2), np.zeros(6), 0.5, 7, ())
    )
    assert worse.value == 0.5
