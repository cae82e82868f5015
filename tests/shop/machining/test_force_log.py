"""Measured forces in place of the model."""

from __future__ import annotations

import numpy as np
import pytest

import vcmm
from tests.shop.machining import shop
from vcmm.core.errors import DataError, ModelLimit
from vcmm.shop.machining.job import finished_part
from vcmm.shop.machining.preparation import set_up

SAID = '[cut]\nforce_log = "forces.csv"\ntools = { 1 = { compliance = "0.1 um/N" } }'


def scenario(folder, rows: str):
    (folder / "forces.csv").write_text("time_s,force_x_N,force_y_N,force_z_N\n" + rows)
    return shop.write(folder, scenario=shop.SCENARIO.replace("[cut]", SAID))


def test_a_logged_force_bends_the_tool(tmp_path):
    """120 N in X all the time, no stock and no teeth stated: 12 um in X, on +x of the boss more material, on -x less."""
    ready = set_up(vcmm.load_cut(scenario(tmp_path, "0,120,0,0\n1000,120,0,0\n")))
    task, world, _ = finished_part(ready)
    moved = world.errors()[:, 0] - 0.0
    normal = task.touches.run.normal[:, 0]
    assert moved == pytest.approx(
        12e-3 * normal * normal, abs=2e-5
    )  # a shift of the whole tool: 12 um cos a along n


def test_the_log_is_read_at_the_time_of_each_cut(tmp_path):
    """The boss is cut within the first minute; a force that begins at 500 s bends nothing."""
    ready = set_up(vcmm.load_cut(scenario(tmp_path, "0,0,0,0\n500,0,0,0\n501,120,0,0\n1000,120,0,0\n")))
    _, world, _ = finished_part(ready)
    assert np.abs(world.errors()).max() < 1e-9


def test_a_log_that_ends_early_or_lacks_a_column_is_told(tmp_path):
    with pytest.raises(
        ModelLimit, match=r"the force log covers 0\.0 to 5\.0 s, but the program runs from 0 to \d+"
    ):
        set_up(vcmm.load_cut(scenario(tmp_path, "0,1,0,0\n5,1,0,0\n")))
    path = scenario(tmp_path, "0,1,0,0\n0,1,0,0\n")
    with pytest.raises(DataError, match=r"forces.csv:3: time_s does not increase"):
        vcmm.load_cut(path)
    (tmp_path / "forces.csv").write_text("time_s,force_x_N\n0,1\n")
    with pytest.raises(DataError, match=r"forces.csv:1: the column force_y_N is missing"):
        vcmm.load_cut(path)
