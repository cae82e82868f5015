"""Maps of programmed points, by hand."""

from __future__ import annotations

import math

import pytest

from vcmm.program.frames import UNITY, AffineMap, in_plane, inverse, rotation, stretch, translation


def test_a_quarter_turn_keeps_round_numbers_round():
    assert rotation(2, math.pi / 2).apply((3.0, 4.0, 5.0)) == (-4.0, 3.0, 5.0)
    assert rotation(0, math.pi / 2).apply((3.0, 4.0, 5.0)) == (3.0, -5.0, 4.0)
    assert rotation(1, 0.0).matrix is UNITY


def test_the_inner_map_comes_first():
    # shift by (1, 0, 0), then turn by 90 deg: (2, 0, 0) -> (3, 0, 0) -> (0, 3, 0)
    assert rotation(2, math.pi / 2).then(translation((1.0, 0.0, 0.0))).apply((2.0, 0.0, 0.0)) == (
        0.0,
        3.0,
        0.0,
    )
    assert translation((1.0, 2.0, 3.0)).then(translation((1.0, 1.0, 1.0))) == AffineMap(
        UNITY, (2.0, 3.0, 4.0)
    )


def test_undo_goes_back():
    mapped = translation((5.0, -2.0, 7.0)).then(rotation(2, 0.3)).then(stretch((2.0, -1.0, 0.5)))
    assert mapped.undo(mapped.apply((1.0, 2.0, 3.0))) == pytest.approx((1.0, 2.0, 3.0), abs=1e-12)
    # inverse of [[2, 1, 0], [0, 1, 0], [0, 0, 4]] = [[0.5, -0.5, 0], [0, 1, 0], [0, 0, 0.25]]
    rows = inverse(((2.0, 1.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 4.0)))
    assert rows == ((0.5, -0.5, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.25))


def test_circles_of_a_plane():
    assert in_plane(AffineMap(), "XY") == (1.0, False)
    assert in_plane(stretch((-1.0, 1.0, 1.0)), "XY") == (1.0, True)
    assert in_plane(stretch((2.0, 2.0, 1.0)), "XY") == (2.0, False)
    assert in_plane(stretch((2.0, 1.0, 1.0)), "XY") is None  # an ellipse
    assert in_plane(rotation(0, 0.1), "XY") is None
    assert in_plane(rotation(0, 0.1), "YZ") == pytest.approx((1.0, False))
