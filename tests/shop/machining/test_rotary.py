"""Where a program leads its tools in workpiece axes, by hand: a table that turns about Y, a head that swivels."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.shop.machining.rotary import (
    by_letter,
    point_of_part,
    tip_and_axis,
    tool_offset_to,
    turn_to_workpiece,
    turned_back,
)

QUARTER = np.array([[0.0, np.pi / 2, 0.0]])  # B = 90 deg


def machine(structure: str, centre=(0.0, 0.0, -400.0)) -> Machine:
    axes = {a: Axis(a, (-500.0, 500.0)) for a in "XYZ"}
    axes["B"] = Axis("B", (-7.0, 7.0), centre=centre)
    return Machine("mill", "machine-tool", parse_structure(structure), axes)


def test_a_table_that_has_turned_by_a_quarter():
    """About Y through (0, 0, -400): a tip 30 mm over the centre lies at 30 mm beside it as seen from the part."""
    table = machine("w B' X' Y' b Z t")
    tip, axis = tip_and_axis(table, np.array([[0.0, 5.0, -370.0]]), QUARTER, np.zeros((1, 3)))
    assert np.abs(tip[0] - [0.0, 5.0, -400.0]).max() == pytest.approx(30.0, abs=1e-9)
    assert abs(tip[0, 0]) == pytest.approx(30.0)
    assert abs(axis[0]) == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)
    assert np.sign(tip[0, 0]) == np.sign(axis[0, 0])  # the tool comes from where its tip stands
    assert point_of_part(table, np.array([0.0, 5.0, -370.0]), QUARTER[0]) == pytest.approx(tip[0])


def test_a_swivelled_head_carries_its_tool():
    """Pivot 150 mm over the gauge line, tool 100 mm: the tip stands 250 mm beside the pivot, at its height."""
    head = machine("w X' Y' b Z B t", (0.0, 0.0, 150.0))
    offset = np.array([[0.0, 0.0, 100.0]])
    tip, axis = tip_and_axis(head, np.array([[0.0, 0.0, -100.0]]), QUARTER, offset)
    assert tip[0, 2] == pytest.approx(150.0)
    assert abs(tip[0, 0]) == pytest.approx(250.0)
    assert abs(axis[0, 0]) == pytest.approx(1.0)
    # a head on the tool side does not turn the part
    assert point_of_part(head, np.array([1.0, 2.0, 3.0]), QUARTER[0]) == pytest.approx([1.0, 2.0, 3.0])


def test_the_offset_that_leads_to_a_point():
    table = machine("w B' X' Y' b Z t")
    axes = by_letter(table, np.zeros((1, 3)), np.zeros((1, 3)))
    assert set(axes) == {"X", "Y", "Z", "B"}
    assert tool_offset_to(table, axes, np.array([[1.0, 2.0, -90.0]]))[0] == pytest.approx([1.0, 2.0, -90.0])


def test_frames_turn_there_and_back():
    frame = np.array([[[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]])
    v = np.array([[1.0, 2.0, 3.0]])
    assert turn_to_workpiece(frame, v)[0] == pytest.approx([2.0, 3.0, 1.0])
    assert turned_back(frame, turn_to_workpiece(frame, v)) == pytest.approx(v)
    assert turn_to_workpiece(None, v) is v
