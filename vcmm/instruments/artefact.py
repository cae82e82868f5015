"""Artefacts: ball and hole plates, ball bars as length standards, step gauges, measured by touching.

ball plate    x y z of every ball, the plate lying anywhere          nuisance rigid; own errors: scale, balls
step gauge    places of faces along one line, the gauge lying anywhere (zero, and its direction by the rows)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.instruments.instrument import SCALE, Instrument, OwnError, of_features
from vcmm.instruments.laying import layout, rows
from vcmm.response.recording import Recording

BALLS = OwnError("balls", "um", of_features, "u of the calibrated place of one ball, each direction")
BALL_PLATE = Instrument(
    "ball plate", "probe", (SCALE, BALLS), ("rigid",), "ISO 10360-2:2009, annex B; VDI/VDE 2617-5"
)
STEP_GAUGE = Instrument(
    "step gauge", "displacement", (SCALE,), ("zero",), "ISO 10360-2:2009, annex B", ("length",)
)


def plate(
    machine: Machine,
    centres: Array,
    pose: str,
    offset: Sequence[float],
    u: float,
    features: Sequence[str] | None = None,
) -> Recording:
    """x, y and z of balls at centres (n, 3) mm, workpiece axes; pose: label of this placement; u mm per coordinate."""
    tips = np.asarray(centres, dtype=float) - np.asarray(offset, dtype=float)
    position = {
        a: tips[:, "XYZ".index(a)] if a in "XYZ" else np.zeros(len(tips)) for a in machine.chain.letters
    }
    names = features or [f"ball {i + 1}" for i in range(len(tips))]
    run = rows(position, np.asarray(offset), {"pose": [pose] * len(tips), "feature": names})
    one = layout(f"plate {pose}", "probe", run, np.eye(3)[0], {"rigid": "pose"}, u)
    plain = {k: v for k, v in one.run.columns.items() if k not in ("nx", "ny", "nz")}
    n = run.n
    return replace(
        one,
        run=replace(one.run, columns=plain),
        value=np.zeros(3 * n),
        row=np.repeat(np.arange(n), 3),
        direction=np.tile(np.eye(3), (n, 1)),
        other=np.full(3 * n, -1, dtype=np.intp),
    )


def grid_of_balls(
    corner: Sequence[float], along: Sequence[float], across: Sequence[float], n: tuple[int, int] = (5, 5)
) -> Array:
    """(n0 n1, 3) mm: balls from a corner along two edges (their lengths are the size of the plate)."""
    a, b = np.meshgrid(np.linspace(0, 1, n[0]), np.linspace(0, 1, n[1]), indexing="ij")
    edge = [np.asarray(v, dtype=float) for v in (along, across)]
    return np.asarray(corner, dtype=float) + a.ravel()[:, None] * edge[0] + b.ravel()[:, None] * edge[1]
