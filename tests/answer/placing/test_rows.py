"""Rows of many poses at once agree with the plan placed pose by pose."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.build import scenario
from vcmm.answer.placing.rows import Rows
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.task.measuring.fixture import pose_of

SIX = np.array([[0.0, 0, 0, 0, 0, 0], [30.0, -20.0, 5.0, 0.0, 0.0, 0.7]])


def test_rows_are_those_of_the_plan():
    one = scenario(Backlash("X", 1e-3))
    run = Rows.of(one).run(SIX)
    assert run.n == 2 * 24
    for i, six in enumerate(SIX):
        placed = one.at(pose_of(six)).task().touches.run
        part = slice(24 * i, 24 * (i + 1))
        for axis in "XYZ":
            assert run.q(axis)[part] == pytest.approx(placed.q(axis), abs=1e-9)
        for column in ("nx", "ny", "nz", "sense_X", "tip_z_mm", "part_x_mm"):
            assert run.column(column)[part] == pytest.approx(placed.column(column), abs=1e-9), column


def test_the_machine_knows_all_inputs():
    k = Input("scale_factor", "X", "k", Normal(1e-6))
    rows = Rows.of(replace(scenario(ScaleFactor("X")), inputs=(k,)))
    assert [i.id for i in rows.machine.inputs] == ["scatter.value", "scale_factor[X].k"]
    assert rows.task.inputs == ()


def test_some_of_the_touches():
    rows = Rows.of(scenario())
    few = rows.only(np.array([0, 23]))
    assert (rows.n, few.n) == (24, 2)
    assert few.run(SIX).q("X")[:2] == pytest.approx(rows.run(SIX).q("X")[[0, 23]])


def test_a_shift_is_asked_of_the_axes():
    rows = Rows.of(scenario())
    first, second = rows.axis_positions(np.array([SIX[0], [3.0, 0, 0, 0, 0, 0]]))
    assert second - first == pytest.approx(np.tile([3.0, 0.0, 0.0], (24, 1)))
