"""A profile whose nominal surface is a list of points with normals, from the scenario file to the value."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vcmm.answer.evaluation.true_values import surface_model
from vcmm.answer.inference.points import task_and_rows
from vcmm.core.errors import DataError, VcmmError
from vcmm.files.own.measured_data import read_measured_points
from vcmm.files.own.scenario import load_scenario
from vcmm.task.measuring.task import evaluate_all, fit_features, measured_points

MACHINE = """
vcmm = "machine/1"
structure = "w b Y X Z t"
[axes]
X = { travel = ["0 mm", "600 mm"] }
Y = { travel = ["0 mm", "500 mm"] }
Z = { travel = ["-400 mm", "0 mm"] }
[repeatability]
law = "normal"
u = "0.5 um"
"""
SCENARIO = """
vcmm = "scenario/1"
machine = "machine.toml"
[part.features]
blade = { type = "points", nominal = "nominal.csv" }
[[part.characteristics]]
name = "where it stands"
type = "surface_profile"
of = "blade"
datums = ["below", "left", "front"]
zone = "0.05 mm"
[[part.characteristics]]
name = "shape alone"
type = "surface_profile"
of = "blade"
criterion = "C"
zone = "0.05 mm"
[part.features.below]
type = "plane"
point = "0 0 0 mm"
normal = [0, 0, 1]
size = "80 60 mm"
[part.features.left]
type = "plane"
point = "-40 0 15 mm"
normal = [-1, 0, 0]
size = "60 30 mm"
[part.features.front]
type = "plane"
point = "0 -30 15 mm"
normal = [0, -1, 0]
size = "80 30 mm"
[pose]
shift = "300 250 -300 mm"
[plan]
styli.down = { offset = "0 0 -120 mm", tip_diameter = "4 mm" }
"""
STEP = '[[plan.steps]]\nfeature = "{}"\nstylus = "down"\npoints = {{ {} }}\n'
STEPS = dict.fromkeys(("below", "left", "front"), 'strategy = "grid", n = [2, 2], margin = "5 mm"') | {
    "blade": 'strategy = "nominal"'
}


def saddle(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """z = x^2 / 80 - y^2 / 120 above 30 mm: points and normals."""
    normals = np.stack([-x / 40, y / 60, np.ones_like(x)], axis=-1)
    points = np.stack([x, y, 30 + x * x / 80 - y * y / 120], axis=-1)
    return points, normals / np.linalg.norm(normals, axis=-1, keepdims=True)


def grid() -> tuple[np.ndarray, np.ndarray]:
    x, y = np.meshgrid(np.linspace(-30, 30, 7), np.linspace(-20, 20, 5))
    return x.ravel(), y.ravel()


def write(path: Path, head: str, rows: np.ndarray, label: str = "") -> None:
    path.write_text(head + "\n" + "".join(label + ",".join(f"{v:.9f}" for v in row) + "\n" for row in rows))


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    write(tmp_path / "nominal.csv", "x_mm,y_mm,z_mm,nx,ny,nz", np.hstack(saddle(*grid())))
    (tmp_path / "machine.toml").write_text(MACHINE)
    steps = "".join(STEP.format(*step) for step in STEPS.items())
    (tmp_path / "s.toml").write_text(SCENARIO + steps)
    return tmp_path / "s.toml"


def measured(
    path: Path, departures: dict[int, float], beside: tuple[float, float] = (0.0, 0.0)
) -> np.ndarray:
    """Values of points that lie so far beside their nominal places, towards the middle, and off the saddle along its normals."""
    x, y = grid()
    points, normals = saddle(x - beside[0] * np.sign(x), y - beside[1] * np.sign(y))
    for i, d in departures.items():
        points[i] += d * normals[i]
    file, scenario = path.parent / "measured.csv", load_scenario(path)
    write(file, "feature,x_mm,y_mm,z_mm", points, "blade,")
    with file.open("a") as more:
        for name in ("below", "left", "front"):
            for p in next(s for s in scenario.plan.steps if s.feature == name).points:
                more.write(",".join([name, *map(str, p)]) + "\n")
    task = task_and_rows(scenario, read_measured_points(file)[0])[0]
    found = measured_points(task, task.machine.indication_error(task.touches.run))
    return np.asarray(evaluate_all(task, fit_features(task, found)))


def test_the_largest_departure_counts_twice(scenario: Path) -> None:
    """12 um out at one point and 4 um in at another: 24 um to the datums, whatever the points between do."""
    assert measured(scenario, {10: 0.012, 20: -0.004})[0] == pytest.approx(0.024, abs=1e-7)


def test_points_beside_their_nominal_places_count_along_the_surface_between(scenario: Path) -> None:
    """0.3 and 0.2 mm beside: tangent planes alone would be 0.3^2 / 80 - 0.2^2 / 120 = 0.8 um off in the middle."""
    assert (
        measured(scenario, {}, (0.3, 0.2))[0] < 0.3e-3
    )  # at the end, where curvature changes by a fifth to the neighbour, 0.14 um
    assert measured(scenario, {10: 0.012, 20: -0.004}, (0.3, 0.2))[0] == pytest.approx(0.024, abs=5e-5)


def test_without_datums_the_surface_is_laid_through_the_points(scenario: Path) -> None:
    """A shift of the whole saddle by 30 um along z is no departure of its shape; to the datums it is 2 x 30 um where it lies flat."""
    path, (x, y) = scenario, grid()
    to_datums, alone = measured(path, dict(enumerate(0.030 * saddle(x, y)[1][:, 2])))
    assert alone == pytest.approx(0.0, abs=1e-6)
    assert to_datums == pytest.approx(0.060, abs=1e-6)


def test_the_true_profile_is_that_at_the_nominal_points(scenario: Path) -> None:
    text = scenario.read_text().replace('"nominal" }', '"nominal", every = 3 }')
    scenario.write_text(text)
    task = load_scenario(scenario).task()
    assert len(task.touches.rows["blade"]) == 12  # every third of 35
    surface = surface_model(task).task
    assert len(surface.touches.rows["blade"]) == 35


def test_a_tip_that_comes_in_obliquely_touches_the_nominal_point_itself(scenario: Path) -> None:
    """A ball of 2 mm from 30 deg beside the normal: without errors it stops at the point, not 2 tan 30 = 1.15 mm beside it. An error
    is indicated along the way of the tip, as large as it is along that way.
    """
    plan = 'feature = "blade"\nstylus = "down"\n'
    scenario.write_text(scenario.read_text().replace(plan, plan + "approach = [0.5, 0, -0.8660254]\n"))
    task = load_scenario(scenario).task()
    rows, t = task.touches.rows["blade"], task.touches
    assert np.abs(np.cross(t.approach[rows], t.normals[rows])).max() > 0.5
    without = measured_points(task, np.zeros((t.run.n, 3)))
    np.testing.assert_allclose(without[rows], t.points[rows], atol=1e-12)
    out = measured_points(task, 1e-3 * t.run.normal)[rows] - t.points[rows]
    np.testing.assert_allclose((out * t.normals[rows]).sum(axis=1), 1e-3, atol=1e-7)
    along = measured_points(task, t.pose.turn(1e-3 * t.approach))[rows] - t.points[rows]
    np.testing.assert_allclose(along, 1e-3 * t.approach[rows], atol=1e-9)


def test_a_point_where_no_nominal_one_is_near_is_refused(scenario: Path) -> None:
    with pytest.raises(DataError, match=r'measured.csv:2: .* mm beyond the extent of "blade"'):
        measured(scenario, {}, (-14.0, 0.0))


@pytest.mark.parametrize(
    ("head", "word"),
    [
        ("x_mm,y_mm,z_mm,nx,ny", "the column nz is missing"),
        ("x_mm,y_mm,z_mm,nx,ny,nk", 'unknown column "nk"'),
    ],
)
def test_a_file_without_its_normals_is_refused_with_the_columns_it_needs(
    scenario: Path, head: str, word: str
) -> None:
    write(scenario.parent / "nominal.csv", head, np.hstack(saddle(*grid()))[:, : head.count(",") + 1])
    with pytest.raises(VcmmError, match=word) as caught:
        load_scenario(scenario)
    assert "nominal.csv:1" in str(caught.value)


def test_a_nominal_point_that_stands_twice_is_named_by_its_line(scenario: Path) -> None:
    rows = np.hstack(saddle(*grid()))
    write(scenario.parent / "nominal.csv", "x_mm,y_mm,z_mm,nx,ny,nz", np.concatenate([rows, rows[:1]]))
    with pytest.raises(VcmmError, match=r"nominal.csv:37: nominal point 36 is in the file twice"):
        load_scenario(scenario)
