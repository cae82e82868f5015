"""The cutting power of a program, and a measured one in its place."""

from __future__ import annotations

import numpy as np
import pytest

import vcmm
from tests.machining import shop
from vcmm.core.errors import DataError, ModelLimit
from vcmm.machining.job import finished_part
from vcmm.machining.preparation import set_up
from vcmm.machining.spindle_load import modelled_power

PROGRAM = """\
%
O1 (SLOT)
G21 G17 G40 G49 G80 G90 G94
T1 M6
G54 G0 X-80. Y0. S3000 M3
G43 H1 Z5.
Z-2.
G1 X80. Y0. F600
G0 Z50.
M30
%
"""
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
