"""Fixtures, goals and the [placement] table: what is read, and what is refused with a fix."""

from __future__ import annotations

import re
from types import SimpleNamespace

import numpy as np
import pytest

from tests.placing.cases import plate, written
from vcmm.core.errors import DataError, ModelLimit, UsageError
from vcmm.files.scenario import load_scenario
from vcmm.measuring.fixture import DOWN, Fixture, Freedom, Goal, pose_of, six_of, turned_down
from vcmm.placing.job import place
from vcmm.placing.objective import Uncertain, complete
from vcmm.placing.rows import Rows
from vcmm.placing.search import search
from vcmm.placing.space import boxes, default_fixture
from vcmm.placing.travels import Travels


@pytest.mark.parametrize("direction", [*DOWN.values(), (0.6, 0.0, -0.8), (0.36, 0.48, 0.8)])
def test_a_face_is_turned_down(direction):
    a, b = turned_down(direction)
    assert np.allclose(
        pose_of(np.array([0, 0, 0, a, b, 0])).turn(np.array(direction)), [0, 0, -1], atol=1e-12
    )


def test_plus_x_down_by_hand():
    # Ry(90 deg) takes x = (1, 0, 0) to (cos 90, 0, -sin 90) = (0, 0, -1)
    assert turned_down((1, 0, 0)) == pytest.approx((0.0, np.pi / 2)) or turned_down((1, 0, 0))[
        1
    ] == pytest.approx(np.pi / 2)


def test_placement_table_is_read(tmp_path):
    text = """
[placement]
x = ["100 mm", "500 mm"]
y = "250 mm"
turn_z = ["0 deg", "90 deg", "180 deg"]
faces_down = ["-z", "top"]
objective = { "U/T" = 0.75, "risk" = 0.25 }
weights = { "bore diameter" = 0.7, "bore square to top" = 0.3 }
process = { "bore diameter" = { mean = "0.001 mm", u = "0.003 mm" } }
"""
    found = plate(tmp_path, text).placement
    assert found is not None
    assert found.fixture is not None
    free = {f.name: f for f in found.fixture.freedoms}
    assert (free["x"].low, free["x"].high) == (100.0, 500.0)
    assert free["y"].values == (250.0,)
    assert free["turn_z"].values == pytest.approx((0.0, np.pi / 2, np.pi))
    assert len(found.fixture.orientations(np.zeros(6))) == 2 * 3  # two faces, three turns, one y
    assert found.fixture.faces["top"] == (0.0, 0.0, 1.0)
    assert found.goal.process["bore diameter"] == (0.001, 0.003)
    assert found.goal.mixture == {"U/T": 0.75, "risk": 0.25}


@pytest.mark.parametrize(
    ("lines", "text"),
    [
        ('x = ["500 mm", "100 mm"]', "the range of x is empty: 500 is not below 100"),
        ("x = [100, 500]", "x"),
        ('turn_z = ["0 mm", "9 mm"]', "turn_z"),
        ('turns_z = ["0 deg", "90 deg"]', 'Did you mean "turn_z"?'),
        ('slots = ["1 2 3 mm"]\nx = ["0 mm", "9 mm"]', "slots sets x already"),
        ('faces_down = ["topp"]', 'Did you mean "top"?'),
        ('objective = "V"', 'objective = "V" is not known'),
        ('weights = { "bore diameter" = 0.7 }', 'the weights sum to 0.7, not to 1; in the same proportion: { "bore diameter" = 1 }'),
        ('weights = { "bore diametre" = 1.0 }', 'Did you mean "bore diameter"?'),
        ('objective = "cost"', "needs costs"),
        ('costs = { accept_bat = 3.0 }', 'Did you mean "accept_bad"?'),
    ],
)  # fmt: skip
def test_wrong_placements_are_refused_with_a_fix(tmp_path, lines, text):
    with pytest.raises(DataError) as error:
        plate(tmp_path, f"\n[placement]\n{lines}\n")
    assert text in str(error.value)
    assert "plate.toml:" in str(error.value)


def test_goals_that_do_not_suit_the_part(tmp_path):
    scenario = plate(tmp_path)
    with pytest.raises(UsageError, match='"bore to front" has no two-sided tolerance'):
        complete(scenario, Goal({"U/T": 1.0}, {"bore to front": 1.0}))
    assert complete(scenario, Goal()).mixture == {"U/T": 1.0}
    assert complete(scenario, Goal()).weights == {"bore diameter": 0.5, "bore square to top": 0.5}
    with pytest.raises(UsageError, match="cannot be mixed"):
        complete(scenario, Goal({"U": 0.5, "risk": 0.5}, {"bore diameter": 1.0}))


def test_boxes_reach_the_travels_and_no_further(tmp_path):
    """Corners of the box touch the travels: the largest and smallest positions of an axis are its ends."""
    scenario = plate(tmp_path)
    rows = Rows.of(scenario)
    box = boxes(default_fixture(), six_of(scenario.pose), Travels(rows))[0]
    six, ok = box.poses(np.array([[0.0, 0.0, 0.5], [1.0, 1.0, 0.5], [0.0, 1.0, 0.9]]))
    assert ok.all()
    at = rows.wanted(six)
    assert at[0, :, 0].min() == pytest.approx(0.0, abs=1e-9)
    assert at[1, :, 0].max() == pytest.approx(600.0, abs=1e-9)
    assert at[2, :, 1].max() == pytest.approx(500.0, abs=1e-9)
    for row in six:  # the plan accepts them
        scenario.at(pose_of(row)).task()
    assert np.allclose(box.unit(six), [[0.0, 0.0, 0.5], [1.0, 1.0, 0.5], [0.0, 1.0, 0.9]])


def test_travels_name_axis_and_point(tmp_path):
    scenario = plate(tmp_path, "", ('shift = "300 250 -300 mm"', 'shift = "20 250 -300 mm"'))
    problems = Travels(Rows.of(scenario)).problems(scenario.pose)
    assert [p.constraint for p in problems] == ["travel of axis X"]
    assert problems[0].point.startswith(("top#", "front#"))
    with pytest.raises(ModelLimit, match="axis X"):
        scenario.task()


def test_no_reachable_pose_says_what_would_open_one(tmp_path):
    """The bore's lowest point needs Z = shift + 5 mm + 120 mm stylus; the fixture holds the part 100 mm too low."""
    scenario = plate(tmp_path)
    low = np.concatenate([six_of(scenario.pose)[:2], [-640.0], [0, 0, 0]])
    with pytest.raises(ModelLimit, match=r"travel of axis Z allows z from -524 to"):
        boxes(
            Fixture((Freedom("z", -660.0, -640.0), Freedom("x", 0.0, 600.0))), low, Travels(Rows.of(scenario))
        )
    # -524 - -640 = 116
    with pytest.raises(
        ModelLimit, match=r"move its upper end up by 116 mm to open a single pose, by 126 mm to leave 10 mm"
    ):
        boxes(Fixture((Freedom("z", -660.0, -640.0),)), low, Travels(Rows.of(scenario)))


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


def test_a_part_larger_than_the_machine(tmp_path):
    small = plate(tmp_path, "", ('travel = ["0 mm", "600 mm"]', 'travel = ["0 mm", "60 mm"]'))
    fixture = Fixture((Freedom("x", -np.inf, np.inf), Freedom("turn_z", -0.01, 0.01)))
    with pytest.raises(ModelLimit, match="the part is larger than the machine: the touches need"):
        place(small, fixture=fixture)


def test_scenario_without_characteristics_or_inputs(tmp_path):
    from dataclasses import replace

    scenario = plate(tmp_path)
    bare = replace(scenario, part=replace(scenario.part, characteristics=()))
    with pytest.raises(UsageError, match="has no characteristics"):
        Uncertain.of(bare)


def test_machine_of_a_scenario_is_replaced(tmp_path):
    from vcmm.library import path as shipped

    other = tmp_path / "other.toml"
    other.write_text(
        'vcmm = "machine/1"\nname = "other"\nstructure = "w b Y X Z t"\n'
        + "".join(
            f'[axes.{a}]\ntravel = ["{lo} mm", "{hi} mm"]\n'
            for a, lo, hi in (("X", 0, 700), ("Y", 0, 600), ("Z", -500, 0))
        )
        + '[repeatability]\nlaw = "normal"\nu = "0.5 um"\n'
    )
    found = load_scenario(written(tmp_path), other)
    assert found.machine.name == "other"
    assert shipped("plate").exists()
