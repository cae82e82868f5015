"""What is set once is drawn once: work offsets one by one, each tool for the whole set-up of the machine."""

from __future__ import annotations

import pytest
import shop

import vcmm

TURNING = (
    '[tools.9]\nlength = "60 mm"\nshape = "turning"\nnose_radius = "0.8 mm"\norientation = 3\n'  # never called
)


def test_a_turning_tool_that_is_never_called_leaves_the_work_offset_alone(tmp_path):
    milled = vcmm.load_cut(shop.write(tmp_path))
    listed = vcmm.load_cut(shop.write(tmp_path, setup=shop.SETUP + TURNING))
    expected = [f"work_offset[{d}].shift" for d in "xyz"]
    assert [i.id for i in milled.inputs] == expected
    assert [i.id for i in listed.inputs] == expected
    assert {e.id for e in milled.machine.effects} <= {e.id for e in listed.machine.effects}
