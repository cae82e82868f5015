"""Linear interpolation as weights."""

from __future__ import annotations

import numpy as np

from vcmm.core.grid import multilinear


def test_weights_by_hand():
    # 2.5 in the cell 0..10: 3/4 and 1/4; 15 in the cell 10..30: 3/4 and 1/4
    weights, nodes = multilinear([np.array([2.5, 15.0])], (np.array([0.0, 10.0, 30.0]),))
    assert np.allclose(weights, [[0.75, 0.25], [0.75, 0.25]])
    assert nodes.tolist() == [[0, 1], [1, 2]]


def test_two_axes_count_the_last_fastest():
    # x = 0.5 of 0..1 and y = 3 of 0..4: (1/2, 1/2) x (1/4, 3/4); node = 2 i + j
    weights, nodes = multilinear([np.array([0.5]), np.array([3.0])], (np.array([0.0, 1]), np.array([0.0, 4])))
    by_node = dict(zip(nodes[0].tolist(), weights[0].tolist()))
    assert by_node == {0: 0.125, 1: 0.375, 2: 0.125, 3: 0.375}


def test_an_axis_of_one_node_does_not_count():
    weights, nodes = multilinear([np.array([7.0]), np.array([3.0])], (np.array([0.0]), np.array([0.0, 4])))
    assert nodes.tolist() == [[0, 1]]
    assert np.allclose(weights, [[0.25, 0.75]])


def test_beyond_the_grid_the_last_cell_goes_on():
    weights, _ = multilinear([np.array([12.0])], (np.array([0.0, 10.0]),))
    assert np.allclose(weights, [[-0.2, 1.2]])
