"""Back-propagation, compiled: patterns one after the other, epoch after epoch. Private to vcmm.learn.calibration.net."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vcmm.core._compile_kernels import njit

Array = NDArray[Any]


@njit(cache=True, error_model="numpy")
def answer(sizes: Array, weight: Array, threshold: Array, out: Array) -> None:
    """Compute the answer of a net. out (layers, widest): row 0 holds the inputs; O = 1 / (1 + exp(-I + theta)), eq. 8 and 9 of the paper."""
    at, node = 0, 0
    for layer in range(1, len(sizes)):
        for j in range(sizes[layer]):
            total = 0.0
            for i in range(sizes[layer - 1]):
                total += weight[at] * out[layer - 1, i]
                at += 1
            out[layer, j] = 1.0 / (1.0 + math.exp(-total + threshold[node]))
            node += 1


@njit(cache=True, error_model="numpy")
def train(
    sizes: Array,
    weight: Array,
    threshold: Array,
    x: Array,
    y: Array,
    order: Array,
    gain: float,
    momentum: float,
) -> None:
    """Train a net: adapt weight and threshold in place. order (epochs, n): the sequence of the patterns.

    delta = (d - O) O (1 - O) at the output, O (1 - O) sum(delta W) inside (eq. 12 and 13, which prints 1 - O of the last
    layer). The threshold enters with minus (eq. 8), so that eq. 11 needs - eta delta.
    """
    widest = 0
    for s in sizes:
        widest = max(widest, s)
    out = np.zeros((len(sizes), widest))
    delta = np.zeros((len(sizes), widest))
    step, shift = np.zeros_like(weight), np.zeros_like(threshold)
    for epoch in range(order.shape[0]):
        for pattern in order[epoch]:
            for i in range(sizes[0]):
                out[0, i] = x[pattern, i]
            answer(sizes, weight, threshold, out)
            last = len(sizes) - 1
            for j in range(sizes[last]):
                o = out[last, j]
                delta[last, j] = (y[pattern, j] - o) * o * (1.0 - o)
            end = len(weight)
            for layer in range(last, 1, -1):
                end -= sizes[layer] * sizes[layer - 1]
                for i in range(sizes[layer - 1]):
                    back = 0.0
                    for j in range(sizes[layer]):
                        back += delta[layer, j] * weight[end + j * sizes[layer - 1] + i]
                    o = out[layer - 1, i]
                    delta[layer - 1, i] = o * (1.0 - o) * back
            at, node = 0, 0
            for layer in range(1, len(sizes)):
                for j in range(sizes[layer]):
                    for i in range(sizes[layer - 1]):
                        step[at] = gain * delta[layer, j] * out[layer - 1, i] + momentum * step[at]
                        weight[at] += step[at]
                        at += 1
                    shift[node] = -gain * delta[layer, j] + momentum * shift[node]
                    threshold[node] += shift[node]
                    node += 1
