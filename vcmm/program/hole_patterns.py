"""Places of the holes of a pattern, in the plane, mm, for all languages."""

from __future__ import annotations

import math
from collections.abc import Iterable

from vcmm.program.cutter import Flat


def hole_circle(middle: Flat, radius: float, angles: Iterable[float]) -> list[Flat]:
    """Return the holes on a circle, at angles in rad."""
    return [(middle[0] + radius * math.cos(w), middle[1] + radius * math.sin(w)) for w in angles]


def hole_line(begin: Flat, angle: float, distances: Iterable[float]) -> list[Flat]:
    """Return the holes on a line at an angle in rad."""
    return [(begin[0] + d * math.cos(angle), begin[1] + d * math.sin(angle)) for d in distances]


def hole_grid(
    begin: Flat, turn: float, counts: tuple[int, int], steps: Flat, along: bool = True
) -> list[Flat]:
    """Return the rows to and fro, turned about their begin by rad. counts, steps: along the first and the second axis; along: rows run
    along the first."""
    inner, outer = counts if along else counts[::-1]
    out: list[Flat] = []
    for row in range(outer):
        for k in range(inner) if row % 2 == 0 else reversed(range(inner)):
            x, y = (k * steps[0], row * steps[1]) if along else (row * steps[0], k * steps[1])
            out.append(
                (
                    begin[0] + x * math.cos(turn) - y * math.sin(turn),
                    begin[1] + x * math.sin(turn) + y * math.cos(turn),
                )
            )
    return out
