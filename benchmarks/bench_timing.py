"""Time law of 10^5 short moves, kernel and readable twin in one run, processor time: python benchmarks/bench_timing.py"""

from __future__ import annotations

import time
from dataclasses import replace
from itertools import pairwise

import numpy as np

from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.program.moves import Move, Source
from vcmm.shop.motion.timing import Elements, Timing, plan_motion, plan_stretches
from vcmm.shop.motion.toolpath import naive_seconds, toolpath

MOVES, LENGTH, FEED = 100_000, 0.5, 6000.0


def machine() -> Machine:
    """A small machining centre with stated limits."""
    dynamics = {"speed": 500.0, "acceleration": 3000.0, "jerk": 50_000.0, "gain": 50.0, "feed_forward": 0.9}
    axes = {a: Axis(a, (-1e4, 1e4), dynamics=dynamics) for a in "XYZ"}
    return Machine("bench", "machine-tool", parse_structure("w X' Y' b Z t"), axes)


def freeform(n: int) -> list[Move]:
    """Rows over a wavy surface in chords of 0.5 mm: curvature, sharp ends of rows, rounded numbers (1 um)."""
    along = np.arange(n + 1) * LENGTH
    row, x = np.divmod(along, 100.0)
    x = np.where(row % 2 == 0, x, 100.0 - x)
    z = 3.0 * np.sin(x / 6.0) * np.cos(row / 10.0)
    points = np.round(np.stack([x, 0.3 * row, z], axis=1), 3)
    where = Source(1, 1, 1)
    return [Move("line", where, tuple(a), tuple(b), feed=FEED) for a, b in pairwise(points.tolist())]


def timed(label: str, moves: list[Move], kernel: bool) -> tuple[float, Timing]:
    start = time.process_time()
    timing = plan_motion(moves, machine(), kernel=kernel)
    seconds = time.process_time() - start
    print(f"{label:28s} {seconds:7.2f} s for {len(moves)} moves")
    return seconds, timing


def ratio_of_passes(timing: Timing) -> None:
    """The look-ahead alone, on the program and on a spiral whose curvature limit falls from element to element."""
    e = timing.elements
    straight = np.tile([1 / 3000.0, 0.0, 1 / 50_000.0, 0.0, 0.0], (len(e.speed), 1))
    falling = replace(e, speed=np.linspace(100.0, 50.0, len(e.speed)), needs=straight)
    for label, elements, part in (
        ("program", e, slice(None)),
        ("falling limits, a tenth", falling, slice(0, len(e.speed) // 10)),
    ):
        some = Elements(
            elements.edge[: len(elements.speed[part]) + 1],
            elements.curve[part], elements.offset[part], elements.speed[part], elements.needs[part],
        )  # fmt: skip
        one = np.array([0]), np.array([len(some.speed) - 1])
        seconds = []
        for kernel in (True, False):
            start = time.process_time()
            plan_stretches(some, *one, kernel)
            seconds.append(time.process_time() - start)
        print(
            f"look-ahead, {label}: kernel {seconds[0]:.3f} s, twin {seconds[1]:.2f} s, ratio {seconds[1] / seconds[0]:.0f}"
        )


def main() -> None:
    moves = freeform(MOVES)
    plan_motion(moves[:10], machine())  # compiled, or read from the cache
    fast, kernel = timed("plan with the kernel", moves, True)
    slow, twin = timed("plan with the twin", moves, False)
    print(f"ratio {slow / fast:.1f}, cycle times differ by {abs(kernel.seconds - twin.seconds):.1e} s")
    ratio_of_passes(kernel)
    start = time.process_time()
    path = toolpath(moves, machine())
    print(f"{'toolpath with servo':28s} {time.process_time() - start:7.2f} s for {path.n} rows")
    naive = naive_seconds(kernel)
    print(
        f"cycle time {kernel.seconds:.1f} s, length over feed {naive:.1f} s: {kernel.seconds / naive:.2f} times"
    )


if __name__ == "__main__":
    main()
