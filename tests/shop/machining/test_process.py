"""What stands the same for all processes: columns by axis, zeros of work offsets, lines of rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import vcmm
from tests.shop.machining import lathe, shop
from vcmm.shop.machining.milling import MillingProcess
from vcmm.shop.machining.preparation import set_up
from vcmm.shop.machining.process import by_axis, zeros
from vcmm.shop.machining.turning import TurningProcess


def test_vectors_as_columns():
    out = by_axis("part_{}_mm", np.array([[1.0, 2.0, 3.0]]))
    assert {name: values.tolist() for name, values in out.items()} == {
        "part_x_mm": [1.0], "part_y_mm": [2.0], "part_z_mm": [3.0],
    }  # fmt: skip


def test_a_zero_was_set_at_its_offset_or_where_it_is_stated(tmp_path):
    job = set_up(vcmm.load_cut(shop.write(tmp_path)))
    names = np.array(["G54", "G54"])
    assert zeros(job, names) == pytest.approx(np.tile([300.0, 250.0, -350.0], (2, 1)))
    stated = replace(job, scenario=replace(job.scenario, set_at=(1.0, 2.0, 3.0)))
    assert zeros(stated, names) == pytest.approx(np.tile([1.0, 2.0, 3.0], (2, 1)))
    assert isinstance(job.process, MillingProcess)
    assert job.process.why_fixed(job) is None


def test_a_lathe_sets_over_a_turn_and_does_not_move(tmp_path):
    job = lathe.shop(lathe.plain(tmp_path))
    assert isinstance(job.process, TurningProcess)
    assert job.process.rows_per_zero == 12
    assert "axis of the spindle" in job.process.why_fixed(job)
