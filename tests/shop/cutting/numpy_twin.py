"""Numpy twin of the envelope kernels: the tool at many places of its path, each hit by the ray in closed form.

Slow and simple, and another formula than the kernels': they look for the root of the distance to the whole sweep, here the
lowest entry into the tool among samples of the path is refined by looking closer and closer at the best one. It checks
the kernels in test_envelope.py.
"""

from __future__ import annotations

import numpy as np

from vcmm.core.laws import Array
from vcmm.shop.cutting.standing_tool import entry
from vcmm.shop.cutting.sweeps import Sweep, position
from vcmm.shop.cutting.tools import Cutter


def lowest(sweep: Sweep, points: Array, normals: Array, samples: int = 401, rounds: int = 12) -> Array:
    """Return the lowest s (m,) at which ray i enters the sweep of row i alone (tool axis +Z); inf where it misses."""
    out = np.empty(len(sweep))
    for k, tool in enumerate(sweep.tools):
        rows = np.flatnonzero(sweep.tool == k)
        if len(rows):
            part = sweep.take(rows)
            out[rows] = _lowest(part, tool, points[rows], normals[rows], samples, rounds)
    return out


def _lowest(sweep: Sweep, tool: Cutter, p: Array, n: Array, samples: int, rounds: int) -> Array:
    lo, hi = np.zeros(len(sweep)), np.ones(len(sweep))
    best = np.full(len(sweep), np.inf)
    for _ in range(rounds):
        t = np.linspace(0.0, 1.0, samples)[:, None] * (hi - lo) + lo
        s = entry(tool, p - position(sweep, t), n)
        k = np.argmin(s, axis=0)
        columns = np.arange(len(sweep))
        best = np.minimum(best, s[k, columns])
        lo, hi = t[np.maximum(k - 1, 0), columns], t[np.minimum(k + 1, samples - 1), columns]
        samples = 31
    return best
