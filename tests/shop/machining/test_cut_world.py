"""The world of a cut part: errors of the machine tool become departures of the surface, with their sign and uncertainty."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from vcmm.answer.evaluation.linear import build
from vcmm.answer.evaluation.uncertainty import evaluate
from vcmm.answer.evaluation.world import Measuring
from vcmm.core.inputs import Input
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.laws import Normal
from vcmm.core.machine import Machine
from vcmm.core.pose import Pose
from vcmm.core.run import Run
from vcmm.part.part import Characteristic, Feature, Part
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.catalogue.workpiece import WorkpieceHeating
from vcmm.physics.structure.expansion import PartExpansion
from vcmm.physics.structure.scatter import Scatter
from vcmm.physics.structure.setting import ToolLength, ToolRadius, WorkOffset
from vcmm.shop.cutting.contactmap import Contacts
from vcmm.shop.machining.cut_world import Cutting
from vcmm.shop.machining.gauge import gauge_plan, ideal_gauge
from vcmm.shop.machining.tool_errors import ToolSide
from vcmm.shop.machining.zero_setting import SETTING
from vcmm.task.measuring.plan import touches
from vcmm.task.measuring.settings import Settings
from vcmm.task.measuring.task import Task

LEFT = Feature(
    "left", "plane", np.array([-50.0, 0, 0]), np.array([-1.0, 0, 0]), np.zeros(0), extent=(40.0, 20.0)
)
RIGHT = Feature(
    "right", "plane", np.array([50.0, 0, 0]), np.array([1.0, 0, 0]), np.zeros(0), extent=(40.0, 20.0)
)
TOP = Feature("top", "plane", np.array([0.0, 0, 10]), np.array([0.0, 0, 1]), np.zeros(0), extent=(40.0, 20.0))
WIDTH = Characteristic("width", "distance", between=("left", "right"), limits=(-0.02, 0.02))
SETTINGS = Settings(trials=5000, certify=20)


def mill(*effects, inputs=()) -> Machine:
    axes = {a: Axis(a, (-1000.0, 1000.0)) for a in "XYZ"}
    return Machine(
        "mill", "machine-tool", parse_structure("w X' Y' b Z t"), axes, tuple(effects), tuple(inputs)
    )


def world(
    machine: Machine, characteristics=(WIDTH,), shift=(300.0, 200.0, -100.0), constants=None
) -> tuple[Task, Cutting]:
    """Faces cut by the side or bottom of a cutter exactly on nominal; the offset is set at the part's zero."""
    part = Part({f.name: f for f in (LEFT, RIGHT, TOP)}, tuple(characteristics))
    plan = gauge_plan(part, None)
    gauge, pose = ideal_gauge(), Pose(np.eye(3), np.array(shift))
    placed = touches(plan, pose, gauge)
    task = Task(gauge, part, plan, placed, machine.inputs, np.zeros(placed.run.n))
    points, n = pose.apply(placed.points), placed.run.normal
    rows = np.concatenate([points, [shift]])
    normals = np.concatenate([n, [[0.0, 0.0, 1.0]]])
    count = len(rows)
    columns = {f"n{c}": normals[:, i] for i, c in enumerate("xyz")}
    columns |= {f"part_{c}_mm": rows[:, i] - shift[i] for i, c in enumerate("xyz")}
    columns |= {"setting": np.append(np.zeros(count - 1), 1.0)}
    columns |= {"time_s": np.linspace(60.0, 3600.0, count)} | {
        k: np.full(count, v) for k, v in (constants or {}).items()
    }
    touch = np.append(placed.run.labels["touch"], SETTING)
    labels = {"tool": np.full(count, "1"), "touch": touch}
    run = machine.prepare(
        Run({"X": rows[:, 0], "Y": rows[:, 1], "Z": rows[:, 2]}, np.zeros((count, 3)), columns, labels)
    )
    p = len(points)
    contacts = Contacts(np.zeros((p, 1)), n[:, None, :], n, np.arange(p)[:, None])
    setting = np.repeat(np.append(np.full(p, p), -1)[:, None], 3, axis=1)  # of X, Y and Z
    tool = ToolSide(machine, run, setting, np.zeros((count, 3)), machine.inputs)
    return task, Cutting(Measuring(Task(gauge, part, plan, placed, (), task.form)), tool, contacts)


def value(machine: Machine, name: str = "width", **options) -> float:
    task, cutting = world(machine, **options)
    model = build(task, cutting)
    names = [c.name for c in model.characteristics]
    return float(model.values(model.q0)[names.index(name)])


def test_a_scale_that_is_long_makes_the_part_long():
    # k = 100 um/m over 100 mm: actual - commanded differs by +10 um between the faces
    assert value(mill(ScaleFactor("X", k=1e-4))) == pytest.approx(100.010, abs=1e-9)


def test_a_tool_that_is_too_large_takes_more_away():
    # 7 um on either side of an outer width
    assert value(mill(ToolRadius("1", dr=0.007))) == pytest.approx(100 - 0.014, abs=1e-9)
    assert value(mill(ToolRadius("2", dr=0.007))) == pytest.approx(100, abs=1e-12)  # not the tool in use


def test_the_offset_set_on_this_machine_takes_the_common_error_away():
    task, cutting = world(mill(ScaleFactor("X", k=1e-4)))
    # at the zero (X = 300) nothing is left; the right face at +50 mm lies 5 um too far, the left one 5 um the other way
    found = cutting.errors()
    assert found[0] == pytest.approx([-0.005, 0, 0], abs=1e-12)
    loose = Cutting(
        cutting.measuring,
        ToolSide(**{**vars(cutting.tool), "setting": np.full_like(cutting.tool.setting, -1)}),
        cutting.contacts,
    )
    # offset from elsewhere: at X = 250 the error is 25 um towards +x, into the left face (n = -x)
    assert loose.errors()[0] == pytest.approx([0.025, 0, 0], abs=1e-12)
    assert task.touches.run.normal[0] == pytest.approx([-1, 0, 0])


def test_a_long_tool_and_a_wrong_zero():
    # the tool reaches 4 um deeper, the work zero lies 6 um too high: the top is 2 um too high ...
    _, cutting = world(mill(ToolLength("1", dl=0.004), WorkOffset("z", shift=0.006)))
    free = Cutting(
        cutting.measuring,
        ToolSide(**{**vars(cutting.tool), "setting": np.full_like(cutting.tool.setting, -1)}),
        cutting.contacts,
    )
    top = cutting.measuring.task.touches.rows
    assert "top" not in top  # only features of a characteristic are inspected
    heights = free.tool.errors()[:, 2]
    assert heights[:-1] == pytest.approx(np.full(len(heights) - 1, 0.002), abs=1e-12)
    assert heights[-1] == 0.0  # the row of setting cuts nothing


def test_a_part_cut_warm_is_small_when_cold():
    warm = {"temp_part_C": 25.0}
    # 11.5 um/(m K) x 5 K x 100 mm = 5.75 um
    assert value(mill(PartExpansion(alpha=11.5e-6)), constants=warm) == pytest.approx(100 - 5.75e-3, abs=1e-9)
    assert (
        value(mill(WorkpieceHeating(k=1e-5 / 3600))) < 100 - 1e-5
    )  # stated for the finished part: small as well


def test_uncertainty_is_that_of_the_difference_and_agrees_with_exact_trials():
    law = Input("scale_factor", "X", "k", Normal(2e-5), "machine")
    scatter = Input("scatter", "", "value", Normal(1e-3), "touch")
    task, cutting = world(mill(ScaleFactor("X", k=1e-4), Scatter(), inputs=(law, scatter)))
    found = evaluate(task, SETTINGS, world=cutting).characteristics[0]
    by_name = {b.input: b for b in found.budget}
    # u(k) x 100 mm = 2 um, whatever the place of the part: the offset is set there
    assert by_name["scale_factor[X].k"].u == pytest.approx(2e-3, rel=1e-9)
    # each face: mean of 49 points, and the distance is from the left's centre: sqrt(2/49) um for the centres
    assert by_name["scatter.value"].u == pytest.approx(1e-3 * np.sqrt(2 / 49), rel=0.05)
    assert found.linear_error < 2e-6  # mm, over 20 exact trials on the same draws
    assert found.value == pytest.approx(100.010, abs=1e-9)
    assert found.bias == pytest.approx(0.010, abs=1e-9)


def test_another_cut_takes_over_where_it_is_deeper():
    n = np.array([[0.0, 0.0, 1.0]])
    cutter = np.array([[[0.0, 0.0, 1.0], [0.0, 0.6, 0.8]]])
    contacts = Contacts(np.array([[0.0, 0.001]]), cutter, n, np.array([[0, 1]]))
    still = np.zeros((2, 3))
    assert contacts.surface(still) == pytest.approx([0.0])
    # the second cut moves by -4 um in y: (0.6 x -4) / 0.8 = -3 um, from +1 to -2 um: now it is the deeper one
    moved = np.array([[0.0, 0.0, 0.0], [0.0, -0.004, 0.0]])
    assert contacts.surface(moved) == pytest.approx([-0.002])
    row, gain = contacts.deepest(moved)
    assert row.tolist() == [1]
    assert gain[0] == pytest.approx([0, 0.75, 1.0])


def test_what_setting_errs_by_is_not_taken_off(tmp_path):
    # the zero lies 6 um too far in x though it was set on this machine; a scale, which is in the zero, leaves nothing there
    _, cutting = world(
        mill(WorkOffset("x", shift=0.006), ToolLength("1", dl=0.004), ScaleFactor("X", k=1e-4))
    )
    x = cutting.tool.run.q("X")
    moved = cutting.tool.errors()[:-1]
    assert moved[:, 0] == pytest.approx(0.006 + 1e-4 * (x[:-1] - 300.0), abs=1e-12)
    assert moved[:, 2] == pytest.approx(np.full(len(moved), -0.004), abs=1e-12)


def test_a_larger_cutter_takes_from_walls_and_slopes_not_from_floors():
    normals = np.array([[1.0, 0, 0], [0, 0, 1.0], [0.6, 0, 0.8]])
    run = Run(
        {"X": np.zeros(3)},
        np.zeros((3, 3)),
        {f"n{c}": normals[:, i] for i, c in enumerate("xyz")},
        {"tool": np.full(3, "1")},
    )
    moved = ToolRadius("1", dr=0.005).error_motion(run)[:, :3]
    # along n: -dr (1 - n_z): 5 um from a wall, nothing from a floor, 5 x (1 - 0.8) = 1 um from the slope of a ball
    assert (moved * normals).sum(axis=1) == pytest.approx([-0.005, 0.0, -0.001], abs=1e-15)


def test_an_influence_on_both_machines_is_counted_once():
    """Cut under a and b, probed under b, c and d: b is one influence, c and d follow behind."""
    under = lambda *ids: [SimpleNamespace(input=SimpleNamespace(id=i)) for i in ids]  # noqa: E731
    both = SimpleNamespace(_cut=under("a", "b"), _probing=under("b", "c", "d"))
    assert Cutting._place.func(both) == [1, 2, 3]


def test_of_two_passes_along_one_line_the_one_towards_which_the_force_bends_makes_the_wall():
    # a slot cut on the way in (700 N towards +x), and run through again on the way out (0 N): both leave the same height. A mill of 1 um/N
    # stands 0.7 um towards +x on the way in, so that way makes the wall which looks to -x (it stands at +x), and the way out the other
    _, cutting = world(mill())
    walls = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    contacts = Contacts(
        np.zeros((2, 2)), np.repeat(walls[:, None], 2, axis=1), walls, np.array([[0, 1], [0, 1]])
    )
    run = cutting.tool.run.take(np.array([0, 0]))
    force = {"force_x_N": np.array([700.0, 0.0]), "force_y_N": np.zeros(2), "force_z_N": np.zeros(2)}
    still = {"setting": np.full((2, 3), -1), "known_error": np.zeros((2, 3))}
    pushed = replace(cutting.tool, run=run.with_columns(force), **still)
    assert replace(cutting, tool=pushed, contacts=contacts).makers()[0].tolist() == [0, 1]
    # without forces the first of them, as ever
    bare = replace(cutting.tool, run=run, **still)
    assert replace(cutting, tool=bare, contacts=contacts).makers()[0].tolist() == [0, 0]
