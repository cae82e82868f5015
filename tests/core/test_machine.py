"""Machine: what fits together, signs, travels, and which errors it sums up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine, check_travel
from vcmm.core.run import Run
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.tip import TipOffset


def run_at(x: float, **columns: float) -> Run:
    position = {a: np.array([x if a == "X" else 0.0]) for a in "XYZ"}
    return Run(position, np.zeros((1, 3)), {k: np.array([v]) for k, v in columns.items()})


def test_indication_is_reading_less_tip_error():
    # X too long by 20 um/m at 100 mm: the tip stands 2 um too far; the stylus reads 5 um too much
    one = machine(ScaleFactor("X", 20e-6), TipOffset("", np.array([5e-3, 0.0, 0.0])))
    run = run_at(100.0)
    assert one.tip_error(run)[0] == pytest.approx([2e-3, 0.0, 0.0])
    assert one.reading(run)[0] == pytest.approx([5e-3, 0.0, 0.0])
    assert one.indication_error(run)[0] == pytest.approx([3e-3, 0.0, 0.0])


def test_the_row_outside_its_travel_is_data():
    axis = Axis("X", (0.0, 100.0))
    check_travel(axis, np.array([0.0, 100.0 + 1e-7]))  # rounding
    with pytest.raises(
        ModelLimit, match=r"row 2: axis X = 101 mm is outside its travel 0 to 100 mm"
    ) as caught:
        check_travel(axis, np.array([50.0, 101.0, 102.0]))
    assert caught.value.row == 1


def test_a_large_rotation_is_not_of_first_order():
    from vcmm.physics.structure.squareness import Squareness

    one = machine(Squareness("C0Y", 2e-3))
    with pytest.raises(ModelLimit, match=r"2 mrad of link .* exceeds 1 mrad"):
        one.tip_error(run_at(0.0))
    assert one.tip_error(run_at(0.0), exact=True).shape == (1, 3)


def test_a_lacking_column_is_named():
    one = machine(Backlash("X", 1e-3))
    with pytest.raises(ModelLimit, match=r"backlash\[X\] needs the column sense_X"):
        one.checked_motion(one.effects[0], run_at(0.0))
    one.check_columns(one.effects[0], run_at(0.0, sense_X=1.0))


def test_effects_in_and_out():
    one = machine(Backlash("X", 1e-3), Backlash("Y", 1e-3))
    assert [e.id for e in one.without("backlash", "X").effects] == ["backlash[Y]"]
    assert one.without("backlash").effects == ()
    assert len(one.with_effect(ScaleFactor("X")).effects) == 3
    with pytest.raises(UsageError, match="no effect backlsh"):
        one.without("backlsh")


def test_structure_axes_and_effects_agree():
    one = machine()
    with pytest.raises(UsageError, match=r"no \[axes.Y\]"):
        replace(one, axes={a: one.axes[a] for a in "XZ"})
    with pytest.raises(UsageError, match=r"\[axes.A\] is not in structure"):
        replace(one, axes={**one.axes, "A": Axis("A", (-1.0, 1.0))})
    with pytest.raises(UsageError, match="acts on axis B"):
        Machine("m", "cmm", parse_structure("w b X Y Z t"), one.axes, (ScaleFactor("B"),))
