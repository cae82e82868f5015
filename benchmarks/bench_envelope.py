"""N-rays against 40 000 moves: the compiled search against numpy brute force, in the same run.

    python benchmarks/bench_envelope.py [points]

Brute force is the closed form of one ray against all capsules at once (numpy); it is timed on few points and scaled up.
Times are those of the processor of this thread, so a busy computer changes them little.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from vcmm.core.run import Array
from vcmm.shop.cutting.envelope import surface_left
from vcmm.shop.cutting.index import build
from vcmm.shop.cutting.sweeps import Sweep, path
from vcmm.shop.cutting.tools import Cutter, ball, bull, flat

STEP, SIDE, BRUTE = 0.5, 100.0, 200


def height(x: Array, y: Array) -> Array:
    """A wavy surface."""
    return 2.0 * np.sin(x / 16.0) * np.cos(y / 16.0)


def raster(tool: Cutter, wavy: bool) -> Sweep:
    """200 lines of 200 moves of 0.5 mm, forth and back: 40 199 moves; a ball rolls over the surface, others stay level."""
    along, across = np.arange(0.0, SIDE + 1e-9, STEP), np.arange(0.0, SIDE, STEP)
    x = np.concatenate([along if k % 2 == 0 else along[::-1] for k in range(len(across))])
    y = np.repeat(across, len(along))
    centre = np.stack([x, y, height(x, y) * wavy], axis=1)
    if wavy:
        n = normals(x, y)
        flat_part = n * [1.0, 1.0, 0.0] / np.maximum(np.hypot(n[:, 0], n[:, 1]), 1e-12)[:, None]
        centre = centre + tool.corner * (n - [0, 0, 1.0]) + (tool.radius - tool.corner) * flat_part
    return path(centre, (tool,))


def normals(x: Array, y: Array) -> Array:
    """Unit normals of the wavy surface."""
    n = np.stack(
        [-np.cos(x / 16) * np.cos(y / 16) / 8, np.sin(x / 16) * np.sin(y / 16) / 8, np.ones_like(x)], axis=1
    )
    return np.asarray(n / np.linalg.norm(n, axis=1)[:, None])


def brute(p: Array, n: Array, sweep: Sweep, radius: float) -> float:
    """Lowest entry of one ray into all capsules."""
    w, d = p - sweep.start - [0, 0, radius], sweep.end - sweep.start
    dd, nd, wd = (d * d).sum(1), d @ n, (w * d).sum(1)
    across, off = n - (nd / dd)[:, None] * d, w - (wd / dd)[:, None] * d
    a, b, c = (across**2).sum(1), (across * off).sum(1), (off**2).sum(1) - radius**2
    with np.errstate(invalid="ignore"):
        s = (-b - np.sqrt(b * b - a * c)) / a
        u = np.clip((wd + s * nd) / dd, 0.0, 1.0)
        w = w - np.where(np.isnan(u), 0.0, u)[:, None] * d
        b = w @ n
        ends = -b - np.sqrt(b * b - (w * w).sum(1) + radius**2)
    s = np.where((u > 0.0) & (u < 1.0), s, ends)
    return float(np.nanmin(s))


def main() -> None:
    points = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    rng = np.random.default_rng(1)
    x, y = rng.uniform(5.0, 95.0, (2, points))
    for name, tool, wavy in (
        ("ball R5, wavy surface", ball(5.0), True),
        ("ball R5, level", ball(5.0), False),
        ("flat R5, level", flat(5.0), False),
        ("bull R5 r1, level", bull(5.0, 1.0), False),
        ("bull R5 r1, wavy", bull(5.0, 1.0), True),
    ):
        sweep = raster(tool, wavy)
        p = np.stack([x, y, height(x, y) * wavy], axis=1)
        n = normals(x, y) if wavy else np.tile([0.0, 0.0, 1.0], (points, 1))
        start = time.thread_time()
        index = build(sweep)
        built = time.thread_time() - start
        surface_left(p[:10], n[:10], index)  # compile
        start = time.thread_time()
        left = surface_left(p, n, index)
        took = time.thread_time() - start
        print(
            f"{name:24s} {len(sweep)} moves, index {built:.2f} s, {points / took:9.0f} points/s, "
            f"{left.tests.mean():6.1f} exact tests per point, {left.counts()['uncut']} uncut"
        )
        if tool.shape == "ball":
            start = time.thread_time()
            slow = np.array([brute(p[i], n[i], sweep, tool.radius) for i in range(BRUTE)])
            rate = BRUTE / (time.thread_time() - start)
            worst = np.abs(slow - left.s[:BRUTE]).max()
            print(
                f"{'':24s} numpy brute force {rate:9.0f} points/s, ratio {points / took / rate:.0f}, largest difference {worst:.1e} mm"
            )


if __name__ == "__main__":
    main()
