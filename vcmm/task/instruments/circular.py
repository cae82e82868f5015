"""Grid plate (ISO 230-4): x and y of the tip on circles, read against a cross grid that lies anywhere. Own error: scale."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.machine import Machine
from vcmm.task.instruments.ball_bar import both_senses
from vcmm.task.instruments.instrument import SCALE, Instrument
from vcmm.task.response.recording import Recording

GRID_PLATE = Instrument(
    "grid plate", "displacement", (SCALE,), ("rigid",), "ISO 230-4:2022, 5.2; ISO 230-1:2012, 11.3"
)


def grid_circle(
    machine: Machine,
    centre: Sequence[float],
    radius: float,
    plane: str,
    u: float,
    points: int = 72,
    offset: Sequence[float] = (0.0, 0.0, 0.0),
) -> Recording:
    """Lay out a circle in both senses (label run: 1 counter-clockwise, 2 clockwise), both directions of the plane read in every row."""
    recording = both_senses(machine, centre, radius, plane, u, points=points, offset=offset)
    n, axes = recording.run.n, sorted("XYZ".index(a) for a in plane)
    columns = {k: v for k, v in recording.run.columns.items() if not k.startswith(("from_", "length_"))}
    return replace(
        recording,
        name=f"grid plate {plane}",
        kind="displacement",
        run=replace(recording.run, columns=columns),
        value=np.zeros(2 * n),
        row=np.repeat(np.arange(n), 2),
        direction=np.tile(np.eye(3)[axes], (n, 1)),
        other=np.full(2 * n, -1, dtype=np.intp),
        nuisance={"rigid": ""},
    )
