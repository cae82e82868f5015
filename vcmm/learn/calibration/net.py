"""Feed-forward nets of Echerfaoui et al. 2017: logistic neurons, back-propagation with momentum, everything mapped to 0 ... 1."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from vcmm.core.run import Array

LAYOUTS = {  # hidden layers for i inputs
    "i, i+1, o": lambda i: (i + 1,),
    "i, 2i+1, o": lambda i: (2 * i + 1,),
    "i, i+1, 2i+1, o": lambda i: (i + 1, 2 * i + 1),
    "i, 2i+1, 3i+1, o": lambda i: (2 * i + 1, 3 * i + 1),
}
BEST_LAYOUT = "i, 2i+1, o"  # the paper's best
GAIN, MOMENTUM, EPOCHS = (
    0.5,
    0.8,
    20_000,
)  # both between 0 and 1, eq. 10 and 11; their values are not published
MARGIN = 0.1  # outputs are mapped to 0.1 ... 0.9: a logistic neuron reaches 0 and 1 at infinity only


@dataclass(frozen=True, eq=False)
class AxisNet:
    """sizes of the layers; weight, threshold as the kernel keeps them; low, high: ranges (inputs,) and (outputs,)."""

    sizes: tuple[int, ...]
    weight: Array
    threshold: Array
    x_range: tuple[Array, Array]
    y_range: tuple[Array, Array]

    def at(self, x: Array) -> Array:
        """Return outputs (n, o) for inputs (n, i)."""
        z = _map_to_unit(x, self.x_range, 0.0)
        weight, threshold = self.weight, self.threshold
        for before, now in pairwise(self.sizes):
            w, weight = weight[: before * now].reshape(now, before), weight[before * now :]
            t, threshold = threshold[:now], threshold[now:]
            z = 1.0 / (1.0 + np.exp(-z @ w.T + t))
        low, high = self.y_range
        return np.asarray(low + (z - MARGIN) / (1.0 - 2.0 * MARGIN) * (high - low))


def _map_to_unit(values: Array, ends: tuple[Array, Array], margin: float) -> Array:
    low, high = ends
    return np.asarray(margin + (1.0 - 2.0 * margin) * (values - low) / np.where(high > low, high - low, 1.0))


def train_net(x: Array, y: Array, layout: str, rng: np.random.Generator, epochs: int = EPOCHS) -> AxisNet:
    """Train a net for inputs x (n, i) and outputs y (n, o), with the patterns in a random order in every epoch."""
    from vcmm.learn.calibration._net_kernels import train

    sizes = (x.shape[1], *LAYOUTS[layout](x.shape[1]), y.shape[1])
    pairs = list(pairwise(sizes))
    weight = rng.uniform(-1.0, 1.0, sum(a * b for a, b in pairs))
    threshold = rng.uniform(-1.0, 1.0, sum(sizes[1:]))
    ends = ((x.min(axis=0), x.max(axis=0)), (y.min(axis=0), y.max(axis=0)))
    order = np.argsort(rng.random((epochs, len(x))), axis=1)
    train(
        np.array(sizes), weight, threshold, x=_map_to_unit(x, ends[0], 0.0), y=_map_to_unit(y, ends[1], MARGIN), order=order, gain=GAIN,
        momentum=MOMENTUM,
    )  # fmt: skip
    return AxisNet(sizes, weight, threshold, *ends)


def share_left(net: AxisNet, x: Array, y: Array, span: Array) -> float:
    """Return the mean over outputs of the rms error of the net, as a share of the range (o,) of each output."""
    left = np.sqrt(np.mean((net.at(x) - y) ** 2, axis=0))
    return float(np.mean(left / span))


def folds(n: int) -> tuple[Sequence[int], Sequence[int]]:
    """Return training and validation rows: every third position is held out for validation, never an end."""
    held_out = [k for k in range(1, n - 1) if k % 3 == 2]
    return [k for k in range(n) if k not in held_out], held_out
