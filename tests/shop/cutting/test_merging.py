"""Short lines that become one: by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vcmm.shop.cutting.merging import merge_lines
from vcmm.shop.cutting.sweeps import arcs, join, lines, path
from vcmm.shop.cutting.tools import ball, flat

FREE = np.ones(1000, dtype=bool)


def test_a_straight_line_in_pieces_is_one():
    pieces = path(np.column_stack([np.linspace(0, 30, 65), np.zeros(65), np.zeros(65)]), (flat(5.0),))
    found = merge_lines(pieces, FREE[:64], 0.05)
    assert len(found) == 1
    assert found.start[0] == pytest.approx([0, 0, 0])
    assert found.end[0] == pytest.approx([30, 0, 0])


def test_a_circle_keeps_chords_of_the_sagitta_that_is_allowed():
    # half of 0.08 mm on R 20: chords of 2 sqrt(2 20 0.04) = 2.53 mm; pairs of pairs of 0.5 mm reach 2 mm (4 of them), 4 mm would leave 0.1 mm
    angle = np.arange(257) * 0.025
    circle = path(np.column_stack([20 * np.cos(angle), 20 * np.sin(angle), np.zeros(257)]), (flat(5.0),))
    found = merge_lines(circle, FREE[:256], 0.08)
    assert len(found) == 64
    middle = (found.start + found.end) / 2
    assert 20 - np.linalg.norm(middle, axis=1).min() <= 0.04
    assert found.end[:-1] == pytest.approx(found.start[1:])


def test_a_tool_that_turns_on_the_spot_keeps_its_ball_where_it_is():
    # a ball of R 5, its centre at (0, 0, 5) all the time, tilts by 0.16 rad in 64 rows: 5 and 10 mm give a lever of 11.18 mm, half of 0.1 mm are 4.5 mrad to
    # either side of the middle row, so that rows of 0.0025 rad can be joined to groups of 2 (0.0025 rad = 0.028 mm off) but not of 4 (0.005 rad = 0.056 mm)
    lean = 0.0025 * np.arange(64)
    axis = np.column_stack([np.sin(lean), np.zeros(64), np.cos(lean)])
    tip = np.array([0, 0, 5.0]) - 5.0 * axis
    rows = replace(lines(tip, tip + [1e-6, 0, 0], (ball(5.0, length=40.0),)), axis=axis)
    found = merge_lines(rows, FREE[:64], 0.1)
    assert len(found) == 32
    assert found.start + 5.0 * found.axis == pytest.approx(np.tile([0, 0, 5.0], (32, 1)), abs=1e-5)


def test_rapids_arcs_and_other_tools_stay():
    tools = (flat(5.0), flat(2.0))
    straight = path(np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], float), tools)
    other = path(np.array([[2, 0, 0], [3, 0, 0]], float), tools, tool=1)
    round_ = arcs([[3, 0, 0]], [[5, 0, 0]], [[4, 0, 0]], [np.pi], tools)
    whole = join([straight, other, round_])
    assert len(merge_lines(whole, FREE[:4], 1.0)) == 3
    assert len(merge_lines(whole, np.array([True, False, True, True]), 1.0)) == 4
    assert len(merge_lines(whole.take(np.zeros(0, int)), FREE[:0], 1.0)) == 0
