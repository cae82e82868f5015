"""Small programs and a machine for the tests of the time law."""

from __future__ import annotations

import math

import numpy as np

from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.program.moves import Move, Source

AT = Source(7, 1, 5)


def mill(**dynamics: float) -> Machine:
    """1 m/s^2, 10 m/s^3 on X, Y, Z unless told otherwise; C by its typical figures."""
    numbers = {"speed": 500.0, "acceleration": 1000.0, "jerk": 10_000.0} | dynamics
    axes = {a: Axis(a, (-1e4, 1e4), dynamics=numbers) for a in "XYZ"} | {"C": Axis("C", (-1e3, 1e3))}
    return Machine("mill", "machine-tool", parse_structure("w C' X' Y' b Z t"), axes)


def line(start, end, feed=6000.0, **more) -> Move:
    return Move("line", AT, tuple(map(float, start)), tuple(map(float, end)), feed=feed, **more)


def corner(tolerance: float | None = None, length: float = 50.0, feed: float = 3000.0) -> list[Move]:
    first = line((0, 0, 0), (length, 0, 0), feed, tolerance=tolerance)
    return [first, line((length, 0, 0), (length, length, 0), feed)]


def circle(radius: float, feed: float, turns: int = 1, clockwise: bool = False, rise: float = 0.0) -> Move:
    start, end = (radius, 0.0, 0.0), (radius, 0.0, rise)
    return Move("arc", AT, start, end, centre=(0.0, 0.0, 0.0), turns=turns, clockwise=clockwise, feed=feed)


def random_moves(rng: np.random.Generator, n: int) -> list[Move]:
    """Lines, arcs, rapids, dwells, lines with a rotary axis, short and long, with all kinds of joints."""
    here, c, out = np.zeros(3), 0.0, []
    for _ in range(n):
        kind, size = rng.integers(0, 8), 10 ** rng.uniform(-2, 1.5)
        way, feed = rng.normal(size=3), float(10 ** rng.uniform(1.5, 4.3))
        to, turn = here + way * size / np.linalg.norm(way), c
        more = {
            "exact_stop": bool(rng.random() < 0.1),
            "tolerance": [None, 0.0, 0.005, 0.1][rng.integers(0, 4)],
        }
        if kind == 6:
            angle = rng.uniform(0, 2 * math.pi)
            centre = here - size * np.array([math.cos(angle), math.sin(angle), 0])
            after = angle + rng.uniform(0.1, 6)
            to = centre + [size * math.cos(after), size * math.sin(after), rng.normal()]
            more |= {
                "centre": tuple(centre),
                "turns": int(rng.integers(1, 3)),
                "clockwise": bool(rng.random() < 0.5),
            }
        if kind == 4:
            turn = c + rng.normal() * 0.1
        name = {5: "rapid", 6: "arc", 7: "dwell"}.get(int(kind), "line")
        end = here if name == "dwell" else to
        rotary = {"rotary_start": (0.0, 0.0, c), "rotary_end": (0.0, 0.0, turn), "seconds": 0.1}
        out.append(
            Move(
                name,
                AT,
                tuple(here),
                tuple(end),
                feed=feed if name in ("line", "arc") else None,
                **rotary,
                **more,
            )
        )
        here, c = end, turn
    return out
