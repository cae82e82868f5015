"""Ball bar (ISO 230-4): the length from a centre cup at any place to the tip, on circles.

The mean length is free unless the bar was calibrated (own error: length). Centre offset: three free numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.task.instruments.instrument import Instrument, OwnError, constant
from vcmm.task.instruments.laying import join_layouts
from vcmm.task.instruments.tracker import lengths_to
from vcmm.task.response.recording import Recording

LENGTH = OwnError("length", "um", constant, "u of the calibrated length of the bar")
BALL_BAR = Instrument(
    "ball bar", "length", (LENGTH,), ("centre", "radius"), "ISO 230-4:2022; ISO 230-1:2012, 11.3"
)


def circle(
    machine: Machine,
    centre: Sequence[float],
    radius: float,
    plane: str,
    u: float,
    points: int = 72,
    offset: Sequence[float] = (0.0, 0.0, 0.0),
    sweep: tuple[float, float] = (0.0, 360.0),
    calibrated: bool = False,
) -> Recording:
    """Lay out a circle (or arc, sweep in degrees) in the plane "XY", "YZ" or "ZX"; centre (3,) mm: where the tip meets the cup."""
    angle = np.radians(np.linspace(*sweep, points, endpoint=abs(sweep[1] - sweep[0]) < 360))
    way = np.zeros((points, 3))
    way[:, "XYZ".index(plane[0])] = radius * np.cos(angle)
    way[:, "XYZ".index(plane[1])] = radius * np.sin(angle)
    nuisance = {"centre": ""} if calibrated else {"centre": "", "radius": ""}
    tips: Array = np.asarray(centre, dtype=float) + way
    recording = lengths_to(machine, f"circle {plane}", tips, centre, offset, nuisance=nuisance, u=u)
    turn = np.sign(sweep[1] - sweep[0])
    ways = np.round(np.stack([-np.sin(angle), np.cos(angle)]) * turn, 9)
    senses = {f"sense_{a}": np.sign(w) for a, w in zip(plane, ways) if a in recording.run.position}
    return replace(recording, run=recording.run.with_columns(senses))


def both_senses(
    machine: Machine,
    centre: Sequence[float],
    radius: float,
    plane: str,
    u: float,
    points: int = 72,
    offset: Sequence[float] = (0.0, 0.0, 0.0),
) -> Recording:
    """Lay out a full circle counter-clockwise (label run: 1), then clockwise (2)."""
    ways = [
        circle(machine, centre, radius, plane, u, points=points, offset=offset, sweep=sweep)
        for sweep in ((0.0, 360.0), (360.0, 0.0))
    ]
    recording = join_layouts(f"circle {plane}", ways)
    return replace(recording, run=replace(recording.run, labels={"run": np.repeat(["1", "2"], points)}))
