"""The 52 nodes: Tables 1 and 2 of Gaska et al. 2014, and draws of what they leave unpublished.

The eight published rows are two columns. They say that d(X) and d(Y) go together (r = 0.94) and that d(X) belongs to the column more than
to the height (p = 0.007). Draws for the other 44 nodes have both: a correlation of X and Y and a share of the column in the variance of
log d, each drawn from what eight nodes in two columns leave open of it, by direction; then maxima and means are those published.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vcmm import Array

COLUMNS = (
    (150, 50), (150, 325), (150, 600), (310, 460), (310, 190), (475, 50), (475, 325), (475, 600),
    (640, 460), (640, 190), (800, 50), (800, 325), (800, 600),
)  # fmt: skip
HEIGHTS = (50, 200, 350, 500)
NODES = np.array([(x, y, z) for x, y in COLUMNS for z in HEIGHTS], dtype=float)  # Table 1
PUBLISHED: Mapping[int, tuple[float, float, float]] = {  # Table 2: node -> d(X), d(Y), d(Z) in um
    17: (0.63, 0.66, 0.65), 18: (0.20, 0.23, 0.89), 19: (0.23, 0.53, 1.27), 20: (0.25, 0.43, 0.46),
    21: (2.12, 1.69, 0.97), 22: (1.01, 0.73, 0.58), 23: (1.18, 0.70, 0.61), 24: (1.29, 0.92, 0.21),
}  # fmt: skip
LARGEST, MEAN = (2.6, 1.8, 1.5), (0.9, 0.8, 0.7)  # section 3, um
SMALLEST = 0.20  # um, the smallest published
NU = 13  # 14 approaches less one
TABLE2 = np.array(list(PUBLISHED.values()))  # (8, 3) um
SHOWN = 171  # the draw in the scenario: from the middle of 200 (readings.central)
GROUPS = 2  # columns of Table 2, four nodes each


def correlation_of(d: Array) -> float:
    """Correlation of d(X) and d(Y) of nodes (n, 3)."""
    return float(np.corrcoef(d[:, 0], d[:, 1])[0, 1])


def column_ratio(d: Array) -> Array:
    """(3,): F of one-way analysis of variance of log d over the columns of Table 2, (8, 3)."""
    logs = np.log(d).reshape(GROUPS, -1, 3)
    size = logs.shape[1]
    between = size * logs.mean(axis=1).var(axis=0, ddof=1)
    within = logs.var(axis=1, ddof=1).mean(axis=0)
    return np.asarray(between / within)


def structure_of(rng: np.random.Generator) -> tuple[float, Array]:
    """Correlation of X and Y, and share (3,) of the column in the variance: one draw of what Table 2 leaves open.

    r by Fisher's z (standard deviation 1/sqrt(n - 3)); the variance ratio from F_observed / F(1, 6) = 1 + 4 ratio.
    """
    z = np.arctanh(correlation_of(TABLE2)) + rng.standard_normal() / np.sqrt(len(TABLE2) - 3)
    size = len(TABLE2) // GROUPS
    ratio = np.maximum(column_ratio(TABLE2) / rng.f(GROUPS - 1, GROUPS * (size - 1), 3) - 1, 0.0) / size
    return float(np.tanh(z)), ratio / (1 + ratio)


def draw_deviations(seed: int) -> Array:
    """(52, 3) um: the published rows, and draws for the others that meet the published maxima and means.

    Per direction: normal scores of column and node, X and Y correlated, become values between 0.20 um and the maximum, one node at
    the maximum, moved towards the ends until the mean over all 52 nodes is the published one (rounded to 0.01 um as in the paper).
    """
    rng = np.random.default_rng([seed, 20140425])
    free = np.array([i for i in range(len(NODES)) if i + 1 not in PUBLISHED])
    out = np.zeros((len(NODES), 3))
    for number, row in PUBLISHED.items():
        out[number - 1] = row
    scores = _scores(rng)[free]
    for axis in range(3):
        low, high = SMALLEST, LARGEST[axis]
        share = (np.exp(0.5 * scores[:, axis]) - np.exp(0.5 * scores[:, axis].min())) / np.ptp(
            np.exp(0.5 * scores[:, axis])
        )
        wanted = MEAN[axis] * len(NODES) - out[:, axis].sum()
        mean = (wanted / len(free) - low) / (high - low)
        out[free, axis] = low + (high - low) * share ** _power(share, mean)
    return np.round(out, 2)


def _scores(rng: np.random.Generator) -> Array:
    """(52, 3) standard normal: one part for the column, one for the node, X and Y correlated in both."""
    r, share = structure_of(rng)
    mixed = np.linalg.cholesky(np.array([[1.0, r, 0.0], [r, 1.0, 0.0], [0.0, 0.0, 1.0]]))
    column = np.repeat(rng.standard_normal((len(COLUMNS), 3)) @ mixed.T, len(HEIGHTS), axis=0)
    node = rng.standard_normal((len(NODES), 3)) @ mixed.T
    return np.asarray(np.sqrt(share) * column + np.sqrt(1 - share) * node)


def _power(share: Array, mean: float) -> float:
    """Exponent that brings the mean of share^p to `mean` (the ends 0 and 1 stay)."""
    low, high = 0.05, 20.0
    for _ in range(60):
        middle = np.sqrt(low * high)
        low, high = (middle, high) if (share**middle).mean() > mean else (low, middle)
    return float(np.sqrt(low * high))
