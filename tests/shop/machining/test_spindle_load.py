"""The cutting power of a program, and a measured one in its place."""

from __future__ import annotations

import numpy as np
import pytest

import vcmm
from tests.shop.machining import shop
from vcmm.core.errors import DataError, ModelLimit
from vcmm.core.run import Series
from vcmm.shop.machining.job import finished_part
from vcmm.shop.machining.preparation import remarks, set_up
from vcmm.shop.machining.spindle_load import gap_of, modelled_power, of_one_part, power_log

PROGRAM = shop.SLOT
SETUP = shop.SETUP + 'teeth = 2\n[stock]\nbox = "100 60 20 mm"\nmaterial = "Al7075"\n'
SCENARIO = """\
vcmm = "scenario/1"
machine = "mill.toml"
[cut]
program = "part.nc"
setup = "setup.toml"
tools = { 1 = { compliance = "0.1 um/N" } }
[part.features]
floor = { type = "plane", point = "0 0 -2 mm", normal = [0, 0, 1], size = "80 10 mm" }
wall = { type = "plane", point = "0 10 -1 mm", normal = [0, -1, 0], size = "80 1 mm" }
[[part.characteristics]]
name = "floor"
type = "flatness"
of = "floor"
[[part.characteristics]]
name = "wall"
type = "flatness"
of = "wall"
[job]
trials = 1000
"""


def prepared(folder, scenario: str = SCENARIO):
    return set_up(vcmm.load_cut(shop.write(folder, "", scenario, PROGRAM, SETUP)))


def moved(job):
    _, world, _ = finished_part(job)
    return world.tool.run


def test_a_slot_takes_the_power_of_its_edges(tmp_path):
    """Slot of 20 mm, 2 mm deep, Al7075 (Ktc 796.1 N/mm2, Kte 27.7 N/mm), 2 teeth, 0.1 mm each, v = pi 20 mm 50 /s = 3.1416 m/s:

    N a / 2 pi (Ktc c 2 + Kte pi) v = 0.63662 (159.22 + 87.02) 3.1416 = 492.5 W while the tool is fully in.
    """
    load = modelled_power(prepared(tmp_path))
    assert load is not None
    assert load.value.max() == pytest.approx(492.5, rel=0.02)
    energy = np.trapezoid(load.value, load.time)
    assert energy == pytest.approx(
        492.5 * 10.0, rel=0.1
    )  # 100 mm at 10 mm/s, entry and exit with part of the tool


def test_a_logged_power_scales_the_forces(tmp_path):
    model = moved(prepared(tmp_path)).columns["force_y_N"]
    (tmp_path / "load.csv").write_text("time_s,spindle_load_W\n0,985\n1000,985\n")
    logged = moved(prepared(tmp_path, SCENARIO.replace("[cut]", '[cut]\nload_log = "load.csv"')))
    inside = np.abs(logged.position["X"] - 300.0) < 30.0  # the tool is fully in
    cut = inside & (np.abs(model) > 1.0)
    assert cut.any()
    assert logged.columns["force_y_N"][cut] / model[cut] == pytest.approx(2.0, rel=0.02)
    assert logged.series["spindle_load_W"].value.tolist() == [985.0, 985.0]


def test_a_wall_that_gives_way_is_left_thicker_towards_its_top(tmp_path):
    """0.1 um/N at the top, 20 mm over its foot: the wall of the slot keeps 0.1 um/N F_y (1 - depth / 20 mm)^3 along y, seen along -y."""
    given = '[[effects]]\neffect = "workpiece_bending"\ndirection = "y"\ncompliance = "0.1 um/N"\nfoot = "-20 mm"\nheight = "20 mm"\n'
    rigid = SCENARIO.replace('tools = { 1 = { compliance = "0.1 um/N" } }\n', "")
    task, world, _ = finished_part(prepared(tmp_path, rigid.replace("[job]", given + "[job]")))
    row, _ = world.contacts.deepest(world.tool_errors)
    run = world.tool.run.take(row)
    wall = task.touches.rows["wall"]
    share = (1.0 + task.touches.points[wall, 2] / 20.0) ** 3
    due = -1e-4 * run.columns["force_y_N"][wall] * share
    assert np.abs(due).max() > 5e-3
    assert world.tool_errors[row][wall] @ [0.0, -1.0, 0.0] == pytest.approx(due, rel=1e-6)


def test_the_third_part_in_a_row_has_the_load_of_those_before(tmp_path):
    job = prepared(tmp_path, SCENARIO.replace("[cut]", "[cut]\nbatch_part = 3"))
    one, load = modelled_power(job), power_log(job)
    assert len(load.time) == 3 * len(one.time)
    assert np.trapezoid(load.value, load.time) == pytest.approx(3.0 * np.trapezoid(one.value, one.time))
    assert load.time[-1] == pytest.approx(3.0 * job.seconds)


def test_a_log_that_is_short_or_lacks_a_column_is_told(tmp_path):
    said = SCENARIO.replace("[cut]", '[cut]\nload_log = "load.csv"')
    (tmp_path / "load.csv").write_text("time_s,spindle_load_W\n0,985\n5,985\n")
    with pytest.raises(ModelLimit, match=r"the load log covers 0\.0 to 5\.0 s, but the program runs"):
        prepared(tmp_path, said)
    (tmp_path / "load.csv").write_text("time_s,load_pct\n0,98\n5,98\n")
    with pytest.raises(
        DataError,
        match=r"load.csv:1: the column spindle_load_W is missing; a load log has time_s, spindle_load_W",
    ):
        prepared(tmp_path, said)


def test_a_log_of_one_part_steps_into_the_next():
    """Logged from 10 s before the start to 20 s behind the end of 100 s: 100 W rising by 1 W/s. The part holds 110 W to 210 W."""
    log = Series(np.arange(-10.0, 121.0, 10.0), np.arange(100.0, 231.0, 10.0))
    one = of_one_part(log, 100.0)
    assert (one.time[0], one.time[-1], one.value[0], one.value[-1]) == (0.0, 100.0, 110.0, 210.0)
    assert (np.diff(one.time) > 0).all()
    twice = np.r_[one.time, 100.0 + one.time], np.r_[one.value, one.value]
    assert np.interp([99.999, 100.001], *twice) == pytest.approx([210.0, 110.0], abs=0.01)


def test_a_gap_in_a_log_is_found():
    """One reading per second, none from 30 to 60 s."""
    time = np.r_[np.arange(31.0), np.arange(60.0, 100.0)]
    assert gap_of(Series(time, np.zeros(len(time)))) == (30.0, 60.0)
    assert gap_of(Series(np.arange(100.0), np.zeros(100))) is None


def test_a_gap_is_told_and_other_units_are_refused(tmp_path):
    rows = [f"{t},100" for t in (*range(31), *range(60, 1001))]
    said = SCENARIO.replace("[cut]", '[cut]\nload_log = "load.csv"')
    (tmp_path / "load.csv").write_text("time_s,spindle_load_W\n" + "\n".join(rows))
    assert any("no reading from 30.0 to 60.0 s" in text for text in remarks(prepared(tmp_path, said)))
    (tmp_path / "load.csv").write_text("time_s,spindle_load_kW\n0,1\n1000,1\n")
    with pytest.raises(DataError, match=r'"spindle_load_kW": convert it to W'):
        prepared(tmp_path, said)
    (tmp_path / "load.csv").write_text("time,spindle_load_W\n10:00:00,1\n")
    with pytest.raises(DataError, match=r'"time": write seconds since the start of the program as time_s'):
        prepared(tmp_path, said)
