"""Sweeps as arrays, by hand: positions, lengths, pieces, frames, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.shop.cutting.sweeps import HELIX, arcs, frames_of, join, lengths, lines, path, pieces, position
from vcmm.shop.cutting.tools import ball, flat

TOOLS = (flat(5.0),)


def test_positions_and_lengths() -> None:
    """A line of 3, 4, 0: 5 mm, 2/5 along at (1.2, 1.6); half a circle of R 10 that rises by 6: sqrt((10 pi)^2 + 36)."""
    straight = lines([[0, 0, 0]], [[3, 4, 0]], TOOLS)
    assert lengths(straight) == pytest.approx([5.0])
    assert position(straight, np.array([0.4]))[0] == pytest.approx([1.2, 1.6, 0.0])
    helix = arcs([[10, 0, 0]], [[-10, 0, 6]], [[0, 0, 0]], np.array([math.pi]), TOOLS)
    assert helix.kind.tolist() == [HELIX]
    assert lengths(helix) == pytest.approx([math.hypot(10 * math.pi, 6)])
    assert position(helix, np.array([0.5]))[0] == pytest.approx([0.0, 10.0, 3.0])


def test_pieces_are_the_same_path() -> None:
    """A quarter in two: the middle is at 45 deg, and each piece turns by 45 deg."""
    whole = arcs([[10, 0, 0]], [[0, 10, 0]], [[0, 0, 0]], np.array([math.pi / 2]), TOOLS)
    parts, row, t0, t1 = pieces(whole, np.array([2]))
    assert row.tolist() == [0, 0]
    assert (t0.tolist(), t1.tolist()) == ([0.0, 0.5], [0.5, 1.0])
    assert parts.end[0] == pytest.approx([math.sqrt(50), math.sqrt(50), 0.0])
    assert parts.turn == pytest.approx([math.pi / 4, math.pi / 4])


def test_frames_are_right_handed_and_end_with_the_axis() -> None:
    axis = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.6, 0.8]])
    frames = frames_of(axis)
    assert frames[0] == pytest.approx(np.eye(3))
    assert frames[:, 2] == pytest.approx(axis)
    assert np.linalg.det(frames) == pytest.approx(np.ones(3))
    assert frames @ frames.transpose(0, 2, 1) == pytest.approx(np.tile(np.eye(3), (3, 1, 1)))


def test_join_and_path_number_their_moves() -> None:
    first, second = path([[0, 0, 0], [1, 0, 0], [1, 1, 0]], TOOLS), lines([[1, 1, 0]], [[0, 0, 0]], TOOLS)
    assert join([first, second]).move.tolist() == [0, 1, 2]
    with pytest.raises(UsageError, match="same tuple of tools"):
        join([first, lines([[1, 1, 0]], [[0, 0, 0]], (ball(1.0),))])


def test_an_arc_that_misses_its_end_is_named() -> None:
    with pytest.raises(UsageError, match=r"row 0 misses its end by 0\.1"):
        arcs([[10, 0, 0]], [[0.1, 10, 0]], [[0, 0, 0]], np.array([math.pi / 2]), TOOLS)
