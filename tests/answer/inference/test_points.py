"""Measured points become a task that gives them again; what is no point of the part is refused with the reason."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.plate import edited
from vcmm.answer.inference.given_points import GivenPoints
from vcmm.answer.inference.points import task_and_rows
from vcmm.core.errors import DataError
from vcmm.core.pose import Pose
from vcmm.face.api import measure
from vcmm.files.own.scenario import load_scenario
from vcmm.task.measuring.scenario import Scenario
from vcmm.task.measuring.task import evaluate_all, fit_features, measured_points


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Scenario:
    return load_scenario(edited(tmp_path_factory.mktemp("plate")))


def handed_in(scenario: Scenario, seed: int = 3) -> tuple[GivenPoints, np.ndarray]:
    """Points of a virtual measurement, in the drawing frame, and its values."""
    found = measure(scenario, seed)
    where = tuple(f"p.csv:{i + 2}" for i in range(len(found.points)))
    return GivenPoints("", found.points, where, found.features), np.array([v.value for v in found.values])


def values(task) -> np.ndarray:
    points = measured_points(task, task.machine.indication_error(task.touches.run))
    return np.asarray(evaluate_all(task, fit_features(task, points)))


def test_the_task_gives_the_measured_points_again(scenario: Scenario) -> None:
    given, expected = handed_in(scenario)
    task = task_and_rows(scenario, given)[0]
    again = measured_points(task, task.machine.indication_error(task.touches.run))
    assert (
        np.abs(again - given.points).max() < 1e-6
    )  # the tip touches at most 1 um beside the foot: 1e-6^2 / 15 along
    assert values(task) == pytest.approx(expected, abs=1e-7)


def test_rows_may_come_in_any_order(scenario: Scenario) -> None:
    given, expected = handed_in(scenario)
    order = np.random.default_rng(1).permutation(len(given.points))
    mixed = replace(given, points=given.points[order], features=tuple(np.array(given.features)[order]))
    assert values(task_and_rows(scenario, mixed)[0]) == pytest.approx(expected, abs=1e-7)


def test_points_in_the_machine_frame_of_a_part_that_lies_roughly_where_the_pose_says(
    scenario: Scenario,
) -> None:
    given, expected = handed_in(scenario)
    really = Pose.from_turns(np.array([0.3, -0.2, 0.1]), np.array([1e-3, -1e-3, 2e-3])).then(scenario.pose)
    moved = replace(given, points=really.apply(given.points))
    task = task_and_rows(scenario, moved, in_machine=True)[0]
    assert values(task) == pytest.approx(expected, abs=1e-6)
    assert (
        np.abs(task.touches.pose.apply(np.zeros(3)) - really.apply(np.zeros(3))).max() < 2e-3
    )  # of the plate as measured


def test_tip_centres_and_plan_order(scenario: Scenario) -> None:
    given, expected = handed_in(scenario)
    normals = scenario.task().touches.normals
    centres = replace(given, points=given.points + 2.0 * normals, features=None)
    assert values(task_and_rows(scenario, centres, tip_centres=True)[0]) == pytest.approx(expected, abs=1e-6)
    with pytest.raises(DataError, match=r"one tip radius \(2 mm\) outside .*--tip-centres"):
        task_and_rows(scenario, centres)[0]


def test_centres_of_a_tip_within_the_approach_and_points_compensated_twice_are_told(
    scenario: Scenario,
) -> None:
    """A tip of 4 mm is within the approach of 3 mm: nothing is too far off, but everything is one radius off."""
    given, _ = handed_in(scenario)
    normals = scenario.task().touches.normals
    centres = replace(given, points=given.points + 2.0 * normals, features=None)
    with pytest.raises(DataError, match=r"one tip radius \(2 mm\) outside .*--tip-centres"):
        task_and_rows(scenario, centres)[0]
    with pytest.raises(DataError, match=r"one tip radius \(2 mm\) inside .*leave --tip-centres out"):
        task_and_rows(scenario, given, tip_centres=True)[0]


def changed(given: GivenPoints, row: int, point: tuple[float, float, float]) -> GivenPoints:
    points = given.points.copy()
    points[row] = point
    return replace(given, points=points)


def without(given: GivenPoints, gone) -> GivenPoints:
    """The rows of which `gone` (feature, point) is false."""
    kept = [i for i, (f, p) in enumerate(zip(given.features, given.points)) if not gone(f, p)]
    where, features = tuple(given.where[i] for i in kept), tuple(given.features[i] for i in kept)
    return replace(given, points=given.points[kept], where=where, features=features)


@pytest.mark.parametrize(
    ("how", "message"),
    [
        (lambda g, s: replace(g, points=g.points / 25.4), "taken as inches"),
        (lambda g, s: replace(g, points=g.points / 1000), "taken as metres"),
        (lambda g, s: replace(g, points=s.pose.apply(g.points)), "use --frame machine"),
        (lambda g, s: replace(g, points=g.points + [0, 0, 11.0]), "of another part, or another feature"),
        (lambda g, s: changed(g, 0, (47.0, 0.0, 20.0)), 'p.csv:2: 7 mm beyond the extent of "top"'),
        (lambda g, s: replace(g, features=("tpo", *g.features[1:])), 'p.csv:2: the part has no feature "tpo". Did you mean "top"'),
        (lambda g, s: replace(g, features=("top",) * len(g.features)), 'no points of "front"'),
        (lambda g, s: replace(g, features=None, points=g.points[:5], where=g.where[:5]), "5 rows without a column feature"),
        (lambda g, s: replace(g, normals=np.tile([0.0, 0.0, -1.0], (len(g.points), 1))), "180 deg off the outward normal"),
        (lambda g, s: without(g, lambda f, p: f == "bore" and p[2] > 10.0), 'points of "bore": cylinder: the points do not determine'),
        (lambda g, s: without(g, lambda f, p: f == "front" and p[0] > -30.0), 'points of "front": plane needs at least 3 points, got 2'),
        (lambda g, s: replace(g, styli=("donw",) * len(g.points)), 'no stylus "donw". Did you mean "down"'),
    ],
)  # fmt: skip
def test_points_of_something_else(scenario: Scenario, how, message: str) -> None:
    given, _ = handed_in(scenario)
    with pytest.raises(DataError) as caught:
        task_and_rows(scenario, how(given, scenario))[0]
    assert message in str(caught.value)


def test_normals_that_point_out_of_the_material_are_taken(scenario: Scenario) -> None:
    """The nominal normals of the touches themselves: of length 1, none turned."""
    given, expected = handed_in(scenario)
    normals = scenario.task().touches.normals
    assert np.linalg.norm(normals, axis=1) == pytest.approx(np.ones(len(normals)))
    assert values(task_and_rows(scenario, replace(given, normals=normals))[0]) == pytest.approx(
        expected, abs=1e-7
    )


def test_a_larger_bore_is_a_larger_bore(scenario: Scenario, tmp_path: Path) -> None:
    """Every bore point 5 um further out: the diameter grows by 10 um and nothing else changes."""
    given, expected = handed_in(scenario)
    bore = np.array([f == "bore" for f in given.features])
    out = np.where(bore[:, None], given.points * [1, 1, 0], 0.0)
    size = np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1.0)
    found = values(task_and_rows(scenario, replace(given, points=given.points + 5e-3 * out / size))[0])
    assert found - expected == pytest.approx([0.010, 0.0, 0.0], abs=1e-7)


def test_a_copied_row_is_told() -> None:
    """Three rows, the third a copy of the first: one more row, named by its place; without a copy nothing."""
    from vcmm.answer.inference.given_points import GivenPoints
    from vcmm.answer.inference.point_checks import repetition_remarks

    points = np.array([[1.0, 2.0, 3.0], [1.0, 2.0, 3.000001], [1.0, 2.0, 3.0]])
    where = ("p.csv:2", "p.csv:3", "p.csv:4")
    (said,) = repetition_remarks(GivenPoints("", points, where))
    assert said.startswith("p.csv:4 as p.csv:2: the same point")
    assert repetition_remarks(GivenPoints("", points[:2], where[:2])) == ()
