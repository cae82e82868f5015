"""Feed-forward nets: learning by hand, slopes by differences, positions held out."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.learn.calibration.net import AxisNet, folds, train_net


def test_one_step_of_back_propagation_by_hand():
    """One neuron, w = 0.5, theta = 0.2, input 1: O = 1 / (1 + exp(-0.3)) = 0.574443. Wanted 0.9: delta = 0.325557 x 0.574443 x
    0.425557 = 0.079586. Gain 0.5: w = 0.539793, theta = 0.2 - 0.039793; the next step adds 0.8 of the first.
    """
    from vcmm.learn.calibration._net_kernels import train

    sizes, x, y = np.array([1, 1]), np.ones((1, 1)), np.full((1, 1), 0.9)
    weight, threshold = np.array([0.5]), np.array([0.2])
    train(sizes, weight, threshold, x, y, np.zeros((1, 1), dtype=np.intp), 0.5, 0.8)
    assert (weight[0], threshold[0]) == pytest.approx((0.539793, 0.160207), abs=1e-6)
    train(sizes, weight, threshold, x, y, np.zeros((1, 1), dtype=np.intp), 0.5, 0.0)
    once = weight[0]
    weight, threshold = np.array([0.5]), np.array([0.2])
    train(sizes, weight, threshold, x, y, np.zeros((2, 1), dtype=np.intp), 0.5, 0.8)
    assert weight[0] - once == pytest.approx(0.8 * 0.039793, abs=1e-6)


def test_a_hidden_layer_goes_down_its_slope():
    """The change of every number is minus gain times the slope of (y - O)^2 / 2, by differences."""
    from vcmm.learn.calibration._net_kernels import train

    sizes = np.array([1, 2, 1])
    weight, threshold = np.array([0.3, -0.4, 0.7, 0.2]), np.array([0.1, -0.2, 0.3])
    x, y = np.array([[0.6]]), np.array([[0.8]])

    def loss(numbers):
        ends = (np.zeros(1), np.ones(1))
        low, high = np.array([-0.125]), np.array([1.125])  # takes the margin of the mapping back out
        net = AxisNet((1, 2, 1), numbers[:4], numbers[4:], ends, (low, high))
        return float((y[0, 0] - net.at(x)[0, 0]) ** 2 / 2)

    start = np.concatenate([weight, threshold])
    slope = [(loss(start + 1e-6 * e) - loss(start - 1e-6 * e)) / 2e-6 for e in np.eye(7)]
    train(sizes, weight, threshold, x, y, np.zeros((1, 1), dtype=np.intp), 0.5, 0.0)
    moved = np.concatenate([weight, threshold]) - start
    assert moved / moved[2] == pytest.approx(np.array(slope) / slope[2], rel=1e-4)


def test_a_net_learns_a_smooth_curve_and_maps_back_to_its_range():
    x = np.linspace(0.0, 400.0, 21)[:, None]
    y = np.concatenate([10.0 * np.sin(x / 150.0), 3.0 + 0.01 * x], axis=1)
    net = train_net(x, y, "i, 2i+1, o", np.random.default_rng(0), 20_000)
    assert np.abs(net.at(x) - y).max(axis=0) == pytest.approx([0.0, 0.0], abs=0.6)


def test_held_out_positions_are_never_ends():
    kept, held = folds(21)
    assert sorted([*kept, *held]) == list(range(21))
    assert {0, 20} <= set(kept)
    assert held == [2, 5, 8, 11, 14, 17]
