"""The measuring lines of ISO 10360-2: axis positions at both ends of every length."""

from __future__ import annotations

from itertools import product

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run

SHARES, REPEATS = (0.2, 0.4, 0.6, 0.8, 1.0), 3
RAM = 150.0  # mm: offset of the stylus for E150


def travels(machine: Machine) -> Array:
    """Ends (3, 2) mm of X, Y and Z. UsageError without three axes."""
    if not {"X", "Y", "Z"} <= set(machine.axes):
        raise UsageError("lengths in the volume need the axes X, Y and Z")
    return np.array([machine.axes[a].travel for a in "XYZ"])


def corners(machine: Machine) -> list[tuple[str, Array, Array]]:
    """Return the four body diagonals: name such as PPP, ends (3,) in axis positions."""
    ends, out = travels(machine), []
    for flips in product((0, 1), repeat=2):
        side = np.array([0, *flips])
        out.append(("".join("PN"[s] for s in side), ends[range(3), side], ends[range(3), 1 - side]))
    return out


def face_diagonals(machine: Machine) -> list[tuple[str, Array, Array]]:
    """Return the two diagonals of the middle plane of every pair of axes: name such as PN0, ends (3,) in axis positions."""
    ends, out = travels(machine), []
    for still in (2, 1, 0):
        first, second = (i for i in range(3) if i != still)
        for flip in (0, 1):
            start, end = ends.mean(axis=1), ends.mean(axis=1)
            start[first], end[first] = ends[first]
            start[second], end[second] = ends[second][:: -1 if flip else 1]
            letters = ["0", "0", "0"]
            letters[first], letters[second] = "P", "PN"[flip]
            out.append(("".join(letters), start, end))
    return out


def seven_lines(machine: Machine) -> list[tuple[Array, Array]]:
    """Return four body diagonals and the three lines parallel to the axes through the middle (ISO 10360-2:2009, 6.3)."""
    ends = travels(machine)
    lines = [(start, end) for _, start, end in corners(machine)]
    for i in range(3):
        start, end = ends.mean(axis=1), ends.mean(axis=1)
        start[i], end[i] = ends[i]
        lines.append((start, end))
    return lines


def length_run(
    machine: Machine, lines: list[tuple[Array, Array]], offset: Array | None = None, repeats: int = 1
) -> tuple[Run, Array]:
    """Return (run, lengths (m,) mm): five lengths on each line, each `repeats` times in turn; rows 0 .. m - 1 are the first ends, the
    others the second.

    nx ny nz look out of the gauge at both ends, so that the length indicated is too long by the sum of both readings.
    """
    first = np.array([s for s, _ in lines for _ in SHARES]).repeat(repeats, axis=0)
    second = np.array([s + f * (e - s) for s, e in lines for f in SHARES]).repeat(repeats, axis=0)
    length = np.linalg.norm(second - first, axis=1)
    way = (second - first) / length[:, None]
    rows, direction = np.concatenate([first, second]), np.concatenate([-way, way])
    middle = {a: (x.travel[0] + x.travel[1]) / 2 if a in "XYZ" else 0.0 for a, x in machine.axes.items()}
    position = {a: np.full(len(rows), q) for a, q in middle.items()}
    position |= {a: rows[:, i] for i, a in enumerate("XYZ")}
    columns = {f"sense_{a}": np.zeros(len(rows)) for a in machine.axes}
    columns |= {f"n{c}": direction[:, i].copy() for i, c in enumerate("xyz")}
    tip = np.zeros(3) if offset is None else offset
    return Run(position, np.tile(tip, (len(rows), 1)), columns), length


def ram_lines(machine: Machine) -> list[tuple[Array, Array]]:
    """Return two diagonals of the plane XZ, which an offset stylus along Y measures (ISO 10360-2:2009, 6.4)."""
    ends = travels(machine)
    low, high = ends[:, 0].copy(), ends[:, 1].copy()
    low[1] = high[1] = ends[1].mean()
    crossed = low.copy(), high.copy()
    crossed[0][2], crossed[1][2] = high[2], low[2]
    return [(low, high), crossed]
