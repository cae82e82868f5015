"""The index of a sweep by hand: one tree per tool and direction, boxes that hold their paths."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.shop.cutting.index import build
from vcmm.shop.cutting.sweeps import arcs, join, lines
from vcmm.shop.cutting.tools import ball, flat

TOOLS = (flat(5.0), ball(3.0))


def test_one_tree_per_tool_and_direction() -> None:
    down = lines([[0, 0, 0], [0, 5, 0]], [[10, 0, 0], [10, 5, 0]], TOOLS, np.array([0, 1]))
    across = lines([[0, 0, 0]], [[10, 0, 0]], TOOLS, 0, np.array([0.0, 1.0, 0.0]))
    index = build(join([down, across]))
    assert len(index.roots) == 3
    assert sorted(index.group_tool.tolist()) == [0, 0, 1]
    assert sorted(index.row.tolist()) == [0, 1, 2]


def test_the_box_of_a_quarter_holds_its_bulge() -> None:
    """R 10 from 0 to 90 deg: the tangents at both ends cross in (10, 10), which the root holds, and no more than rounding."""
    index = build(arcs([[10, 0, 2]], [[0, 10, 2]], [[0, 0, 2]], np.array([math.pi / 2]), TOOLS))
    assert index.boxes[index.roots[0]] == pytest.approx([0, 0, 2, 10, 10, 2], abs=1e-9)


def test_a_full_circle_goes_in_quarters_that_lead_back_to_it() -> None:
    index = build(arcs([[10, 0, 0]], [[10, 0, 0]], [[0, 0, 0]], np.array([2 * math.pi]), TOOLS))
    assert len(index.items) == 4
    assert index.row.tolist() == [0] * 4
    assert np.sort(index.t0) == pytest.approx([0.0, 0.25, 0.5, 0.75])
    assert (index.t1 - index.t0) == pytest.approx([0.25] * 4)
