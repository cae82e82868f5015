"""The way from points to errors of the tool by hand: rows of the contacts, their columns, the rows of setting."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import vcmm
from tests.shop.machining import shop
from vcmm.core.errors import ModelLimit
from vcmm.core.kinematics import Axis
from vcmm.shop.machining.contact_path import contact_rows, surface_at, tool_side
from vcmm.shop.machining.preparation import set_up

# the boss of radius 50 about the work zero (300, 250, -350), its side 4 mm below the top, cutter R 10 with its tip at -10
POINTS = np.array([[50.0, 0.0, -4.0], [0.0, -50.0, -4.0]])
NORMALS = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
NAMES = np.array(["east", "south"])


@pytest.fixture(scope="module")
def job(tmp_path_factory):
    return set_up(vcmm.load_cut(shop.write(tmp_path_factory.mktemp("boss"))))


def test_the_first_row_of_a_point_is_its_contact(job):
    surface = surface_at(job, POINTS, NORMALS)
    rows = contact_rows(job, surface)
    assert surface.s == pytest.approx([0.0, 0.0], abs=1e-9)
    for i, tip in enumerate([[360.0, 250.0, -360.0], [300.0, 190.0, -360.0]]):
        row = rows.contacts.row[i, 0]
        assert rows.tip[row] == pytest.approx(tip, abs=1e-6)
        assert rows.at[row] == pytest.approx(POINTS[i] + [300.0, 250.0, -350.0], abs=1e-6)
        assert job.line_of(int(rows.row[row])) == 10


def test_the_run_leads_to_the_cutting_point(job):
    """Axes X 360, tool 100 mm long: Z of the machine -260; the offset leads from there to the point on the wall."""
    tool, contacts = tool_side(job, surface_at(job, POINTS, NORMALS), NAMES, np.full(2, "boss"))
    run, row = tool.run, contacts.row[0, 0]
    assert [float(run.position[a][row]) for a in "XYZ"] == pytest.approx([360.0, 250.0, -260.0], abs=1e-6)
    assert run.offset[row] == pytest.approx([-10.0, 0.0, -94.0], abs=1e-6)
    assert run.tip[row] == pytest.approx([350.0, 250.0, -354.0], abs=1e-6)
    assert run.part_point[row] == pytest.approx([50.0, 0.0, -4.0], abs=1e-6)
    assert run.column("across_tool")[row] == pytest.approx(1.0)  # a wall
    assert (run.labels["touch"][row], run.labels["work_offset"][row]) == ("east", "G54")


def test_one_row_of_setting_for_tool_and_offset(job):
    tool, _ = tool_side(job, surface_at(job, POINTS, NORMALS), NAMES, np.full(2, "boss"))
    (last,) = np.flatnonzero(tool.run.column("setting"))
    assert last == tool.run.n - 1
    assert np.unique(tool.setting[:-1]).tolist() == [last]  # X, Y and Z: one tool cuts
    assert tool.setting[-1].tolist() == [-1, -1, -1]
    assert tool.run.tip[last] == pytest.approx([300.0, 250.0, -350.0])
    elsewhere = replace(job, scenario=replace(job.scenario, set_here=False))
    free, _ = tool_side(elsewhere, surface_at(job, POINTS, NORMALS), NAMES, np.full(2, "boss"))
    assert np.unique(free.setting).tolist() == [-1]


def test_a_cut_off_the_machine_names_the_line(job):
    short = {**job.machine.axes, "X": Axis("X", (0.0, 355.0))}
    small = replace(job, scenario=replace(job.scenario, machine=replace(job.machine, axes=short)))
    with pytest.raises(
        ModelLimit, match="some point of the cut is out of travel, line 10 of the program: row 1: axis X"
    ) as caught:
        tool_side(small, surface_at(job, POINTS, NORMALS), NAMES, np.full(2, "boss"))
    assert caught.value.row == 0
