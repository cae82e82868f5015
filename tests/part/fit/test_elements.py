"""Distances and Jacobians of the elements, by hand and against differences."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.part.fit.elements import (
    ELEMENTS,
    MINIMUM_POINTS,
    RX,
    RY,
    TX,
    TZ,
    frames,
    free_pose,
    jacobian,
    signed_residuals,
)


def distance(kind: str, point, *sizes: float) -> float:
    d, _, _ = jacobian(ELEMENTS[kind], (), np.array(point, dtype=float)[None, :, None], np.array([sizes]))
    return float(d[0, 0])


def test_distances_by_hand():
    assert distance("plane", (3, 4, 2)) == 2.0
    assert distance("cylinder", (3, 4, 7), 2.0) == pytest.approx(3.0)
    assert distance("sphere", (2, 3, 6), 5.0) == pytest.approx(2.0)
    # cone of 45 deg, radius 1 at z = 0: at z = 2 the radius is 3, a point at 5 is 2 across, 2 cos 45 square to it
    assert distance("cone", (5, 0, 2), 1.0, np.pi / 4) == pytest.approx(np.sqrt(2.0))
    # torus of ring 10 and tube 2: from the middle of the tube 3 across and 4 up are 5, less 2
    assert distance("torus", (13, 0, 4), 10.0, 2.0) == pytest.approx(3.0)


@pytest.mark.parametrize("kind", ["plane", "cylinder", "sphere", "cone", "torus"])
def test_sizes_against_differences(kind):
    element, point = ELEMENTS[kind], np.array([[[7.0], [2.0], [1.5]]])
    sizes = np.array([[5.0, 0.4]])[:, : len(element.sizes)]
    _, jac, _ = jacobian(element, element.pose, point, sizes)
    for k in range(len(element.sizes)):
        step = np.zeros_like(sizes)
        step[0, k] = 1e-6
        high, low = (jacobian(element, (), point, sizes + s)[0][0, 0] for s in (step, -step))
        assert jac[0, len(element.pose) + k, 0] == pytest.approx((high - low) / 2e-6, rel=1e-6)


def test_motions_of_a_plane():
    # up by 1: the distance falls by 1; tilted about x by 1: at y = 4 the surface rises by 4; about y: at x = 3 it falls by 3
    _, jac, _ = jacobian(ELEMENTS["plane"], (TZ, RX, RY), np.array([[[3.0], [4.0], [0.0]]]), np.zeros((1, 0)))
    assert jac[0, :, 0].tolist() == [-1.0, -4.0, 3.0]


def test_a_fixed_axis_takes_both_tilts():
    assert free_pose(ELEMENTS["cylinder"], True) == (TX, 1)
    assert free_pose(ELEMENTS["plane"], True) == (TZ,)
    assert MINIMUM_POINTS["cone"] == 6


def test_frames_are_right_handed():
    axis = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.6, 0.0, 0.8]])
    frame = frames(axis)
    assert np.allclose(frame @ frame.swapaxes(1, 2), np.eye(3))
    assert np.linalg.det(frame) == pytest.approx([1.0, 1.0, 1.0])
    assert np.array_equal(frame[:, 2], axis)


def test_a_line_counts_its_residuals_as_lengths():
    # 3 across x and 4 across y are 5 off the line, in the direction (0.6, 0.8, 0)
    _, _, rows = jacobian(ELEMENTS["line"], (), np.array([[[3.0], [4.0], [9.0]]]), np.zeros((1, 0)))
    residual, normal = signed_residuals(rows, np.eye(3)[None], (1, 1))
    assert residual.tolist() == [[5.0]]
    assert normal[0, 0] == pytest.approx([0.6, 0.8, 0.0])
