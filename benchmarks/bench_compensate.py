"""Arcs kept as arcs against arcs cut into lines, for the same departure from the circle: python benchmarks/bench_compensate.py

Both are corrected for the same machine and tolerance, and both are run on it again. Lines are spread evenly, which is
the best that senders with a fixed pitch can do; numbers have six decimals, so that rounding plays no part.
"""

from __future__ import annotations

import math
import tempfile
import time
from pathlib import Path

import numpy as np

from vcmm.compensation.field import field_of, known_errors_of
from vcmm.compensation.job import compensate
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.component import ComponentTable
from vcmm.physics.structure.squareness import Squareness
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup

SETUP = Setup(dialect="fanuc", offsets={"G54": (0.0, 0.0, 0.0)}, compensation=())


def machine(kind: str) -> Machine:
    """20 urad of squareness, or squareness with scales and straightness of 4 um over 300 mm."""
    axes = {a: Axis(a, (-1000.0, 1000.0)) for a in "XYZ"}
    effects: tuple = (Squareness("C0Y", 20e-6),)
    if kind == "all":
        grid = np.linspace(-500.0, 500.0, 101)
        wave = 4e-3 * np.sin(2 * np.pi * grid / 300.0)
        effects += (
            ScaleFactor("X", 40e-6),
            ComponentTable(component="EYX", arguments=("X",), grids=(grid,), values=wave),
        )
    return Machine("bench", "machine-tool", parse_structure("w X' Y' b Z t"), axes, effects)


def as_arcs(folder: Path, text: str, m: Machine, tolerance: float) -> tuple[int, float]:
    """Blocks for one circle, and the departure they leave, mm."""
    path = folder / "circle.nc"
    path.write_text(text)
    found = compensate(path, SETUP, m, tolerance=tolerance, decimals=6)
    return found.blocks.additions + 1, found.after.largest


def as_lines(text: str, m: Machine, tolerance: float, radius: float) -> int:
    """Least number of equal chords between corrected points that leaves the tolerance."""
    moves = interpret(text, "fanuc", SETUP).moves
    field = field_of(known_errors_of(m), SETUP, moves)
    low, high = 3, 4 * math.ceil(math.pi / math.acos(1 - tolerance / radius))
    while low < high:
        n = (low + high) // 2
        low, high = (n + 1, high) if _left(n, radius, field) > tolerance else (low, n)
    return low


def _left(n: int, radius: float, field) -> float:
    """Largest departure of n corrected chords, at ends and middles."""
    angle = np.linspace(0.0, 2 * math.pi, n + 1)
    ring = radius * np.column_stack([np.cos(angle), -np.sin(angle), np.zeros(n + 1)])
    arc = np.full(n + 1, len(field.moves) - 1)
    share = angle / (2 * math.pi)
    points = field.correct(arc, share, ring, np.zeros_like(ring))
    middle = (points[1:] + points[:-1]) / 2
    real: Array = middle + field.errors(field.run(arc[1:], share[1:], middle), arc[1:])
    return float(np.abs(np.hypot(real[:, 0], real[:, 1]) - radius).max())


def circles() -> None:
    print("machine      R mm  tolerance um   arcs (left um)      lines   ratio")
    with tempfile.TemporaryDirectory() as folder:
        for kind in ("squareness", "all"):
            for radius in (10.0, 25.0, 50.0, 100.0):
                for tolerance in (1e-3, 1e-4):
                    text = f"%\nO1\nG21 G90 G54\nG0 X{radius} Y0 Z0\nG2 I-{radius} F500\nM30\n%\n"
                    arcs, left = as_arcs(Path(folder), text, machine(kind), tolerance)
                    lines = as_lines(text, machine(kind), tolerance, radius)
                    print(
                        f"{kind:10s} {radius:6.0f} {tolerance * 1e3:13g} {arcs:6d} ({left * 1e3:.3f}) {lines:14d} {lines / arcs:7.0f}"
                    )


def speed(count: int = 10_000) -> None:
    """Blocks per second through the whole chain: read, correct, write, read again, run twice."""
    rows = [
        f"X{100 * math.sin(i / 300):.3f} Y{i * 0.005:.3f} Z{3 * math.cos(i / 77):.3f}" for i in range(count)
    ]
    text = "\n".join(["%", "O1", "G21 G90 G54", "G0 X0 Y0 Z5.", "G1 Z0 F1000", *rows, "M30", "%", ""])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "surface.nc"
        path.write_text(text)
        start = time.process_time()
        found = compensate(path, SETUP, machine("all"))
        seconds = time.process_time() - start
    print(
        f"{count} short lines: {seconds:.1f} s of processor time, {count / seconds:.0f} blocks/s; {found.before.largest * 1e3:.2f} um before, "
        f"{found.after.largest * 1e3:.2f} um after (rounding {found.rounding.largest * 1e3:.2f} um)"
    )


if __name__ == "__main__":
    circles()
    speed()
