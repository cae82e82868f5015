"""The rule of the surface left, with many overlapping moves, against plain membership sampled along the ray."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.laws import Array
from vcmm.shop.cutting.envelope import BEYOND, CUT, UNCUT, surface_left
from vcmm.shop.cutting.sweeps import Sweep, arcs, join, lines, position
from vcmm.shop.cutting.tools import ball, bull, cone, flat, implicit

TOOLS = (ball(1.5), flat(1.0, 4.0), bull(1.5, 0.5, 5.0), cone(1.2, 1.4, 0.2, 6.0))
DEPTH, HEIGHT, FINE = 3.0, 6.0, 0.03


def moves(rng: np.random.Generator) -> Sweep:
    """24 lines and 12 arcs and helices of all tools in a box of 20 mm."""
    start = rng.uniform(-10, 10, (24, 3))
    straight = lines(start, start + rng.normal(size=(24, 3)) * 4.0, TOOLS, rng.integers(0, 4, 24))
    centre, angle, turn = rng.uniform(-8, 8, (12, 3)), rng.uniform(0, 6.3, 12), rng.uniform(-7, 7, 12)
    radius, rise = rng.uniform(1, 5, 12), rng.uniform(-3, 3, 12) * (np.arange(12) % 2)

    def at(a: Array, z: Array) -> Array:
        return centre + np.stack([radius * np.cos(a), radius * np.sin(a), z], axis=1)

    curved = arcs(at(angle, 0 * rise), at(angle + turn, rise), centre, turn, TOOLS, rng.integers(0, 4, 12))
    return join([straight, curved])


def sampled(sweep: Sweep, p: Array, n: Array) -> tuple[Array, Array]:
    """Which samples s of the ray lie in some tool at one of 200 places of its path."""
    s = np.arange(-DEPTH, HEIGHT, FINE)
    q = p + s[:, None] * n
    gone = np.zeros(len(s), bool)
    path = position(sweep, np.linspace(0, 1, 200)[:, None])  # (200, m, 3)
    for k in range(len(sweep)):
        far = np.abs(q[:, None, :2] - path[None, ::20, k, :2]).max(axis=2).min(axis=1) < 4.0
        d = q[far][:, None, :] - path[None, :, k]
        g = implicit(TOOLS[int(sweep.tool[k])], np.hypot(d[..., 0], d[..., 1]), d[..., 2])
        gone[far] |= g.min(axis=1) <= 0.0
    return s, gone


def expected(s: Array, gone: Array) -> tuple[float, int]:
    """The rule, on samples."""
    zero = int(np.searchsorted(s, 0.0))
    if gone[zero]:
        below = np.flatnonzero(~gone[:zero])
        return (s[below[-1] + 1], CUT) if len(below) else (-DEPTH, BEYOND)
    above = np.flatnonzero(gone[zero:])
    return (s[zero + above[0]], CUT) if len(above) else (np.nan, UNCUT)


@pytest.mark.thorough
def test_the_rule_against_sampled_membership() -> None:
    """60 random rays: same status, s within the step of the samples.

    Samples cannot see gaps and slivers thinner than their step, nor the scallops between 200 places; a ray may therefore
    differ where its stretches nearly touch, graze or end at the search depth; such rays are counted: at most 3 of 60.
    """
    rng = np.random.default_rng(11)
    sweep = moves(rng)
    p, n = rng.uniform(-6, 6, (60, 3)), rng.normal(size=(60, 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    left = surface_left(p, n, sweep, DEPTH, HEIGHT)
    differ, seen = 0, np.zeros(3, int)
    for i in range(60):
        s, status = expected(*sampled(sweep, p[i], n[i]))
        seen[status] += 1
        same = status == left.status[i] and (status != CUT or abs(s - left.s[i]) < 2 * FINE)
        differ += not same
    assert (seen > 3).all()
    assert differ <= 3


def test_points_do_not_influence_one_another() -> None:
    """The search begins each point with the moves that cut the one before: asked alone, every point has the same contacts."""
    rng = np.random.default_rng(12)
    sweep = moves(rng)
    p, n = rng.uniform(-6, 6, (80, 3)), rng.normal(size=(80, 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    together = surface_left(p, n, sweep, DEPTH, HEIGHT)
    for i in range(80):
        alone = surface_left(p[i : i + 1], n[i : i + 1], sweep, DEPTH, HEIGHT)
        assert alone.status[0] == together.status[i]
        assert np.allclose(alone.contact_s[0], together.contact_s[i], rtol=0, atol=1e-13, equal_nan=True)
        assert alone.row[0].tolist() == together.row[i].tolist()
    assert (together.status == CUT).sum() > 20
