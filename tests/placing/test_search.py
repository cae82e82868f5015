"""The search over the boxes of a fixture on problems with a known answer or a dense reference."""

from __future__ import annotations

import re
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import qmc

from tests.placing.cases import plate
from tests.placing.drawn import problem
from vcmm.core.errors import ModelLimit
from vcmm.measuring.fixture import Fixture, Freedom, six_of
from vcmm.placing.fixture_boxes import boxes
from vcmm.placing.hindrances import Hindrance
from vcmm.placing.rows import Rows
from vcmm.placing.search import CountedObjective, search
from vcmm.placing.travels import Travels


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
    at = Rows.of(scenario).wanted(found.pose[None])[0]
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


@pytest.mark.parametrize("seed", [2, 3])
def test_drawn_problems_against_a_dense_scan(seed):
    """A small version of tools/place_statistics.py: 3000 evaluations against a scan of 8000."""
    one = problem(seed)
    found = search(one.objective, one.boxes, evaluations=3000, seed=seed)
    assert found.evaluations <= 3000
    for box in one.boxes:
        ask = CountedObjective(box, one.objective)
        best = min(ask(part).min() for part in np.array_split(qmc.Sobol(box.d, seed=9).random_base2(13), 4))
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
